//! From a sample of a log to chain: the geometry of the arm, its masses and its friction (E8).

use crate::chain_spec::{ChainSpec, record, record_best, trial};
use crate::drive_terms::{AT_REST, DriveTerm, WEIGHT_AT_REST, columns};
use crate::plan::{ChainOptions, FrictionKind};
use couplings::Searched;
use rayon::prelude::*;
use torquewise_model::model::{Choice, GeometryFound};
use torquewise_motion::Motion;
use torquewise_rigid::search::all_parameters;
use torquewise_rigid::{Chain, Geometry, Rows, Search, refine, search};
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::friction::FrictionLibrary;
use torquewise_stepwise::held_out::CvScore;
use torquewise_stepwise::survey::thinned;

mod couplings;
mod residual;
mod joint_friction;
mod loads;
mod ripple;

/// A chain with what stands beside it, and how both were chosen.
#[derive(Clone, Debug)]
pub(crate) struct Learned {
    pub(crate) chain: Chain,
    /// RMS of what it leaves of each joint \[N·m\], all rows alike, n.
    pub(crate) residual_rms: Vec<f64>,
    /// What was fitted: what stands beside the links, which of the geometry moved.
    pub(crate) spec: ChainSpec,
    pub(crate) choices: Vec<Choice>,
    /// Friction that may be offered.
    pub(crate) laws: FrictionLibrary,
    /// How often the geometry was found, where it was searched.
    pub(crate) found: Option<GeometryFound>,
}

/// No axis is farther \[rad\] than this from the nearest right angle.
const ANY_ANGLE: f64 = 1.0;
/// Ridges that are tried, the strongest first.
const RIDGES: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Weaker ones, tried where the weakest of those is the best: only a log without noise bears them.
const WEAK_RIDGES: [f64; 2] = [1e-6, 1e-8];
/// Axes nearer to a right angle \[rad\] and to the axis before \[m\] than this are put there, if
/// held-out rows agree.
const SNAP: (f64, f64) = (0.2, 0.03);
/// Rounds of refinement on all but a held-out block.
const ROUNDS: usize = 6;
/// The same once axes were put elsewhere.
const SNAP_ROUNDS: usize = 15;
/// Rows that trials are fitted on.
const TRIAL_ROWS: usize = 900;
/// Rows that the last fit is made on.
pub(crate) const LAST_ROWS: usize = 4_000;
/// Two chains whose costs are closer than this are one.
const SAME: f64 = 1e-3;

/// Learns the chain of an arm: searches its geometry, where that is not given, and chooses all that
/// is fitted on held-out blocks of time.
///
/// # Errors
/// [`IdentifyError::Chain`] if no chain can be fitted, [`IdentifyError::NoSuchJoint`] if a joint is
/// said to be balanced that is not there.
pub(crate) fn learn(
    motion: &Motion,
    options: &ChainOptions,
    seed: u64,
) -> Result<Learned, IdentifyError> {
    let (n, friction) = (motion.n_joints(), options.friction);
    let balanced = loads::balanced(motion, &options.counterbalanced)?;
    let mut learner = ChainLearner::new(motion);
    let mut drive = DriveTerm::rotors(n);
    let has_friction = friction != FrictionKind::None;
    if has_friction {
        drive.extend(DriveTerm::friction(learner.laws.linear()));
    }
    let search = Search { seed, ..Search::default() };
    let spec = ChainSpec { drive, search, free: all_parameters(n), gravity: None };
    let mut choices = Vec::new();

    let is_given = options.geometry.is_some();
    let Searched { mut spec, mut chain, mut starts } = match &options.geometry {
        Some(known) => learner.at_geometry(spec, &known.geometry)?,
        None => learner.coupled_geometry(&spec, &mut choices)?,
    };
    let shares = has_friction && learner.shafts(&mut spec, &chain, &mut choices)?;
    if shares && !is_given {
        choices.retain(|choice: &Choice| choice.what != AXES);
        (chain, starts) = learner.geometry(&mut spec, Some(chain), &mut choices)?;
    }
    learner.counterbalances(&mut spec, &chain, &balanced, &mut choices)?;
    if has_friction {
        learner.reversal(&mut spec, &chain, friction, &mut choices)?;
    }
    learner.friction(&mut spec, &chain, friction, &mut choices)?;
    if friction == FrictionKind::Auto && spec.has_friction() {
        learner.joint_friction(&mut spec, &chain, &mut choices)?;
        learner.ripple(&mut spec, &chain, &mut choices)?;
    }
    learner.ridge(&mut spec, &chain, &mut choices)?;
    if !is_given {
        chain = learner.right_angles(&mut spec, &chain, &starts, &mut choices)?;
    }
    learner.finish(spec, &chain, choices)
}

const AXES: &str = "axes at right angles";

/// A label, what is fitted, and from where.
type Way = (String, ChainSpec, Chain);

/// Each start with its axes held at right angles, as those of nearly all arms are, then free: on a
/// short log, an axis that may lie anywhere follows the noise.
fn held_or_free(spec: &ChainSpec, starts: &[Chain]) -> Vec<Way> {
    let held = starts.iter().map(|start| {
        let (geometry, free) = start.geometry.snapped(ANY_ANGLE, 0.0);
        let spec = ChainSpec { free, ..spec.clone() };
        ("held".to_owned(), spec, Chain { geometry, ..start.clone() })
    });
    let free = starts.iter().map(|start| ("free".to_owned(), spec.clone(), start.clone()));
    held.chain(free).collect()
}

/// The log in the hands of the learner.
struct ChainLearner<'a> {
    motion: &'a Motion,
    /// Friction that is offered.
    laws: FrictionLibrary,
    /// How often the geometry was found.
    found: Option<GeometryFound>,
}

impl<'a> ChainLearner<'a> {
    fn new(motion: &'a Motion) -> Self {
        let speed = |joint: usize| {
            motion.dq().col(joint).iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()))
        };
        let laws = FrictionLibrary::new((0..motion.n_joints()).map(speed).collect());
        Self { motion, laws, found: None }
    }

    fn rows(&self, spec: &ChainSpec, count: usize) -> Result<Rows, IdentifyError> {
        let motion = thinned(self.motion, count);
        let drive = columns(&spec.drive, &motion, spec.gravity.as_ref());
        let tau = motion.require_tau()?;
        let rows = Rows::new([motion.q(), motion.dq(), motion.ddq(), tau], &drive)?;
        if !spec.has_friction() {
            return Ok(rows);
        }
        let moves = |row, joint| self.moves(&motion, row, joint);
        let share = |row, joint| if moves(row, joint) { 1.0 } else { WEIGHT_AT_REST };
        Ok(rows.with_shares(share))
    }

    /// Whether a joint moves in a row, so that its friction has one direction.
    fn moves(&self, motion: &Motion, row: usize, joint: usize) -> bool {
        motion.dq()[(row, joint)].abs() >= AT_REST * self.laws.width[joint]
    }

    /// The chain at a given geometry, which stays.
    fn at_geometry(&self, spec: ChainSpec, geometry: &Geometry) -> Result<Searched, IdentifyError> {
        let spec = ChainSpec { free: Vec::new(), ..spec };
        let rows = self.rows(&spec, spec.search.final_rows)?;
        let start = Chain::at(geometry.clone());
        let chain = refine(&rows, &start, &spec.free, &spec.search)?;
        Ok(Searched { spec, chain, starts: Vec::new() })
    }

    /// Searches the geometry, then chooses whether its axes are held at right angles.
    fn geometry(
        &mut self,
        spec: &mut ChainSpec,
        known: Option<Chain>,
        choices: &mut Vec<Choice>,
    ) -> Result<(Chain, Vec<Chain>), IdentifyError> {
        let found = search(&self.rows(spec, LAST_ROWS)?, &spec.search)?;
        self.found = Some(GeometryFound { times: found.times, starts: found.starts });
        let mut starts = found.chains;
        starts.dedup_by(|a, b| (a.cost - b.cost).abs() < SAME * b.cost);
        starts.extend(known);
        let rows = self.rows(spec, TRIAL_ROWS)?;
        let ways = held_or_free(spec, &starts);
        let trials = ways
            .par_iter()
            .map(|(label, spec, start)| trial(label.clone(), spec, &rows, start, ROUNDS))
            .collect::<Result<Vec<CvScore>, IdentifyError>>()?;
        let (_, chosen, start) = &ways[record_best(AXES, &trials, starts.len(), choices)];
        spec.clone_from(chosen);
        let rows = self.rows(spec, spec.search.final_rows)?;
        let chain = refine(&rows, start, &spec.free, &spec.search)?;
        Ok((chain, starts))
    }

    fn ridge(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let way = |ridge: &f64| {
            let search = Search { ridge: *ridge, ..spec.search.clone() };
            (format!("{ridge:e}"), ChainSpec { search, ..spec.clone() })
        };
        let mut ways: Vec<(String, ChainSpec)> = RIDGES.iter().map(way).collect();
        let mut trials = self.trials(&ways, chain, 0)?;
        let errors: Vec<f64> = trials.iter().map(CvScore::error).collect();
        if errors.last() < errors.first() && errors.iter().all(|e| Some(e) >= errors.last()) {
            let weak: Vec<(String, ChainSpec)> = WEAK_RIDGES.iter().map(way).collect();
            trials.extend(self.trials(&weak, chain, 0)?);
            ways.extend(weak);
        }
        *spec = ways[record("ridge", &trials, choices)].1.clone();
        Ok(())
    }

    /// Puts axes at right angles and on each other where held-out rows do not object: each
    /// parameter that is zero makes the model shorter.
    fn right_angles(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        starts: &[Chain],
        choices: &mut Vec<Choice>,
    ) -> Result<Chain, IdentifyError> {
        let rows = self.rows(spec, TRIAL_ROWS)?;
        let sources: Vec<&Chain> = std::iter::once(chain).chain(starts).collect();
        let (angle, distance) = SNAP;
        let mut ways: Vec<Way> = (sources.iter())
            .map(|source| {
                let (geometry, free) = source.geometry.snapped(angle, distance);
                let label = format!("{angle} rad, {distance} m: {} free", free.len());
                (label, ChainSpec { free, ..spec.clone() }, Chain { geometry, ..chain.clone() })
            })
            .collect();
        ways.push((format!("none: {} free", spec.free.len()), spec.clone(), chain.clone()));
        let trials = ways
            .par_iter()
            .map(|(label, spec, start)| trial(label.clone(), spec, &rows, start, SNAP_ROUNDS))
            .collect::<Result<Vec<_>, _>>()?;
        let place = record_best("right angles", &trials, sources.len(), choices);
        let (_, chosen, chain) = ways.swap_remove(place);
        *spec = chosen;
        Ok(chain)
    }

    /// Fits the chosen specification on a sample of many rows.
    fn finish(
        &self,
        spec: ChainSpec,
        chain: &Chain,
        choices: Vec<Choice>,
    ) -> Result<Learned, IdentifyError> {
        let rows = self.rows(&spec, LAST_ROWS)?;
        let chain = refine(&rows, chain, &spec.free, &spec.search)?;
        let residual_rms = residual_rms(&chain, &rows);
        let (laws, found) = (self.laws.clone(), self.found);
        Ok(Learned { chain, residual_rms, spec, choices, laws, found })
    }

    fn trials(
        &self,
        ways: &[(String, ChainSpec)],
        chain: &Chain,
        rounds: usize,
    ) -> Result<Vec<CvScore>, IdentifyError> {
        ways.par_iter()
            .map(|(label, spec)| {
                let rows = self.rows(spec, TRIAL_ROWS)?;
                trial(label.clone(), spec, &rows, chain, rounds)
            })
            .collect()
    }
}

/// RMS of what a chain leaves of each joint \[N·m\], all rows alike, n.
pub(crate) fn residual_rms(chain: &Chain, rows: &Rows) -> Vec<f64> {
    let (m, predicted) = (rows.len(), chain.torque(rows));
    let of_joint = |joint: usize| {
        let pairs = rows.torque_of(joint).iter().zip(&predicted[joint * m..]);
        let squares: f64 = pairs.map(|(tau, found)| (tau - found).powi(2)).sum();
        (squares / m.max(1) as f64).sqrt()
    };
    (0..rows.n_joints()).map(of_joint).collect()
}
