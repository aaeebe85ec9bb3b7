//! From sample of a log to motors that are wired the wrong way round: joints share one energy, so a
//! torque of the wrong sign contradicts those of the others.

use crate::rough::{Normal, offset_and_friction};
use faer::Mat;
use torquewise_model::EnergyTerm;
use torquewise_model::energy::Place;
use torquewise_model::library::{energy_library, energy_library_size};
use torquewise_motion::Motion;
use torquewise_survey::survey::thinned;

/// Rows that tell.
const ROWS: usize = 500;
/// Functions of the energy at most.
const MOST_TERMS: usize = 600;
/// Equations per column at least.
const LEAST_EQUATIONS: usize = 4;
/// Ridge on columns of unit length.
const RIDGE: f64 = 1e-8;
/// Other signs must leave this part of what the torque leaves as it is, sum of squares.
const HALVED: f64 = 0.25;
/// Signs of more joints than this are not tried all together.
const MOST_JOINTS: usize = 10;

/// Joints whose torque, turned round, fits the energy that all joints share far better.
///
/// The normal equations are the same for any signs: all 2ⁿ⁻¹ are tried. Of a set and the rest, which
/// fit alike, the one is meant that leaves the kinetic energy positive.
pub fn backward(sample: &Motion) -> Vec<usize> {
    found(sample).unwrap_or_default()
}

fn found(sample: &Motion) -> Option<Vec<usize>> {
    let motion = thinned(sample, ROWS);
    let (m, n) = (motion.n_rows(), motion.n_joints());
    if !(2..=MOST_JOINTS).contains(&n) {
        return None;
    }
    let fits = |limit: &usize| {
        let terms = energy_library_size(n, Some(*limit));
        terms <= MOST_TERMS && LEAST_EQUATIONS * terms <= m * n
    };
    let limit = (1..=n).take_while(fits).last()?;
    let library = energy_library(n, Some(limit));
    let p = library.len() + 3 * n;
    let tau = motion.tau()?;

    let mut gram = Mat::<f64>::zeros(p, p);
    // What each joint's torque says of the columns, p×n.
    let mut moments = Mat::<f64>::zeros(p, n);
    for joint in 0..n {
        let own = columns(&motion, &library, joint);
        let mean = tau.col(joint).sum() / m as f64;
        let size = tau.col(joint).iter().map(|tau| (tau - mean).powi(2)).sum::<f64>();
        if size <= 0.0 {
            return None;
        }
        gram += own.transpose() * &own * (1.0 / size);
        let target = Mat::from_fn(m, 1, |row, _| (tau[(row, joint)] - mean) / size);
        let said = own.transpose() * target;
        moments.col_mut(joint).copy_from(said.col(0));
    }
    let weights = Normal::new(gram, RIDGE)?.solve_each(&moments);
    // Of the torque of all joints with signs s, sᵀ·shared·s is explained, of n.
    let shared = moments.transpose() * &weights;
    let left = |signs: u32| -> f64 {
        let sign = |joint: usize| if signs >> joint & 1 == 1 { -1.0 } else { 1.0 };
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        n as f64 - pairs.map(|(i, j)| sign(i) * sign(j) * shared[(i, j)]).sum::<f64>()
    };
    let best = (0..1_u32 << (n - 1)).min_by(|a, b| left(*a).total_cmp(&left(*b)))?;
    if best == 0 || left(best) > HALVED * left(0) {
        return None;
    }
    let is_turned = |joint: usize| best >> joint & 1 == 1;
    let coefficient = |column: usize| -> f64 {
        (0..n)
            .map(|j| if is_turned(j) { -weights[(column, j)] } else { weights[(column, j)] })
            .sum()
    };
    let kinetic: f64 = library
        .iter()
        .enumerate()
        .filter_map(|(column, term)| {
            let Place::Inertia(i, j) = term.place else { return None };
            Some(coefficient(column) * twice_kinetic(&motion, term, i, j))
        })
        .sum();
    Some((0..n).filter(|&joint| is_turned(joint) == (kinetic > 0.0)).collect())
}

/// 2T of one term, summed over the rows.
fn twice_kinetic(motion: &Motion, term: &EnergyTerm, i: usize, j: usize) -> f64 {
    let share = if i == j { 1.0 } else { 2.0 };
    let zeros = vec![0.0; motion.n_joints()];
    (0..motion.n_rows())
        .map(|row| {
            let q: Vec<f64> = motion.q().row(row).iter().copied().collect();
            let rates = motion.dq()[(row, i)] * motion.dq()[(row, j)];
            share * term.function.value(&q, &zeros, &zeros) * rates
        })
        .sum()
}

/// What each energy adds to the torque of a joint, then offset, viscous and dry friction of each
/// joint: m×p.
fn columns(motion: &Motion, library: &[EnergyTerm], joint: usize) -> Mat<f64> {
    let (m, n) = (motion.n_rows(), motion.n_joints());
    let sums: Vec<_> = library.iter().map(|term| term.torque(joint)).collect();
    let peak = motion.dq().col(joint).norm_max().max(f64::MIN_POSITIVE);
    let mut columns = Mat::zeros(m, library.len() + 3 * n);
    for row in 0..m {
        let state = [motion.q(), motion.dq(), motion.ddq()];
        let [q, dq, ddq] = state.map(|of| of.row(row).iter().copied().collect::<Vec<f64>>());
        for (column, sum) in sums.iter().enumerate() {
            let value = sum.iter().map(|(weight, term)| weight * term.value(&q, &dq, &ddq)).sum();
            columns[(row, column)] = value;
        }
        let own = library.len() + 3 * joint;
        for (k, value) in offset_and_friction(dq[joint], peak).into_iter().enumerate() {
            columns[(row, own + k)] = value;
        }
    }
    columns
}
