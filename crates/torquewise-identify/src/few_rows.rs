//! Chains on few rows: torques in each other's place, and axes that are not the arm's.

use crate::learn::searching;
use crate::torque_sign::{HALF, QUARTER, ROWS};
use crate::{DriveTerm, Linearisation, Watch, chain_rows, columns, geometric_mean};
use rayon::prelude::*;
use torquewise_motion::Motion;
use torquewise_rigid::search::glance;
use torquewise_rigid::{Chain, ChainError, ChainRows, Geometry, Search, refine, search};
use torquewise_stepwise::friction::FrictionLibrary;
use torquewise_stepwise::{IdentifyError, thinned};

/// Torques that are changed over must leave a quarter of what they leave as they are, geometric mean of
/// the two, by so many starts each on so many rows; of all pairs, so many that do best by fewer starts
/// on fewer rows.
const FEW: (usize, usize) = (6, 200);
const FEWER: (usize, usize) = (2, 100);
const LIKELIEST: usize = 4;

/// Usual friction, and rows of a motion with its columns, joints that all turn.
fn few_rows(
    (sample, dq_peak): (&Motion, &[f64]),
    count: usize,
) -> Result<(Vec<DriveTerm>, ChainRows), IdentifyError> {
    let drive = DriveTerm::usual(&FrictionLibrary::new(dq_peak.to_vec()));
    let motion = thinned(sample, count);
    let rows = chain_rows(&motion, columns(&drive, &motion, None))?.measured();
    Ok((drive, rows))
}

/// What axes leave of each torque on these rows \[N·m\], n.
pub(crate) fn left_by_axes(
    motion: (&Motion, &[f64]),
    axes: &Geometry,
    watch: Watch<'_>,
) -> Result<Vec<f64>, IdentifyError> {
    let (_, rows) = few_rows(motion, ROWS)?;
    let still = Search { rounds: 0, ..Search::default() };
    let chain = refine(&rows, &Chain::at(axes.clone()), &[], &still, &searching(watch))?;
    Ok(chain.residual_rms)
}

/// A chain with usual friction that is searched on few rows of a motion, joints that all turn.
pub(crate) fn at_a_glance(
    (sample, dq_peak): (&Motion, &[f64]),
    seed: u64,
    watch: Watch<'_>,
) -> Result<Linearisation, IdentifyError> {
    let (drive, rows) = few_rows((sample, dq_peak), ROWS)?;
    let found = search(&rows, &Search { seed, ..Search::default() }, &searching(watch))?;
    let chain = found.chains.into_iter().next().ok_or(ChainError::Singular)?;
    Ok(Linearisation::of(&chain, (drive, &chain.drive), vec![0.0; rows.n_joints()]))
}

/// Two joints whose torques stand in each other's place: a first look at few rows finds a chain that
/// explains far more of all torques with these two changed over. The pair that does best, if any.
///
/// - `missed`, `doubtful`: joints whose torque a model misses: one of the pair or both; and those whose
///   torque may be another's: both
pub(crate) fn swapped(
    sample: &Motion,
    (missed, doubtful): (&[usize], &[usize]),
    seed: u64,
    watch: Watch<'_>,
) -> Result<Option<[usize; 2]>, IdentifyError> {
    let (motion, n) = (thinned(sample, FEW.1), sample.n_joints());
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
    let is_likely = |pair: &[usize; 2]| {
        pair.iter().any(|joint| missed.contains(joint))
            && pair.iter().all(|joint| doubtful.contains(joint))
    };
    let pairs: Vec<[usize; 2]> = pairs.filter(is_likely).collect();
    let peaks: Vec<f64> = (0..n).map(|joint| motion.dq().col(joint).norm_max()).collect();
    let (_, rows) = few_rows((&motion, &peaks), FEW.1)?;
    let watch = searching(watch);
    let parts = |rows: &ChainRows, (starts, count): (usize, usize)| {
        glance(&rows.thinned(count), &Search { seed, starts, ..Search::default() }, &watch)
    };
    let left = |rows: &ChainRows, look: (usize, usize)| geometric_mean(&parts(rows, look));
    // Those that leave less than a part of what is left as it is, the best first.
    let better = |pairs: Vec<[usize; 2]>, look: (usize, usize), part: f64| {
        let than = if pairs.is_empty() { 0.0 } else { part * left(&rows, look) };
        let left = |pair| {
            let parts = parts(&rows.clone().swapped(pair), look);
            (geometric_mean(&parts), parts, pair)
        };
        let mut pairs: Vec<(f64, Vec<f64>, [usize; 2])> = pairs.into_par_iter().map(left).collect();
        pairs.retain(|(own, ..)| *own <= than);
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs.into_iter()
    };
    let likeliest = better(pairs, FEWER, 1.0).map(|(.., pair)| pair).take(LIKELIEST).collect();
    // Of all joints: what the two leave is two parts of n.
    let best = better(likeliest, FEW, QUARTER.powf(2.0 / n as f64)).next();
    // Where one of the two is turned round, an arm is found that explains the other in its place better.
    let is_swapped = |(own, parts, pair): &(f64, Vec<f64>, [usize; 2])| {
        let is_told = |joint: usize| *own < left(&rows.clone().turned(joint), FEW);
        pair.iter().all(|&joint| parts[joint] < HALF && is_told(joint))
    };
    Ok(best.filter(is_swapped).map(|(.., pair)| pair))
}
