//! A chain learned from a sample of a log: geometry, inertia and friction (E8).

use crate::chain_spec::error;
use crate::{
    AT_REST, ChainOptions, ChainSpec, DriveTerm, FrictionKind, Progress, WEIGHT_AT_REST, Watch,
    chain_rows, columns, geometric_mean, record_worth, trial,
};
pub(crate) use gravity::against_axes;
use kinds::upright;
use offers::Offer;
use rayon::prelude::*;
use std::ops::ControlFlow;
use torquewise_model::{Choice, GeometryFound, Training};
use torquewise_motion::Motion;
use torquewise_regression::ascending;
use torquewise_rigid::search::{
    FINAL_ROWS, Found, SearchStage, SearchWatch, all_parameters, turned,
};
use torquewise_rigid::{Chain, ChainError, ChainRows, JointKinds, Search, refine, search};
use torquewise_stepwise::friction::FrictionLibrary;
use torquewise_stepwise::held_out::CvScore;
use torquewise_stepwise::{IdentifyError, thinned};

mod coordinates;
mod couplings;
mod gravity;
pub(crate) mod kinds;
mod offers;

/// A chain with what stands beside it, and how both were chosen.
#[derive(Clone, Debug)]
pub(crate) struct Learned {
    pub(crate) chain: Chain,
    /// What was fitted: what stands beside the links, which of the geometry moved.
    pub(crate) spec: ChainSpec,
    /// Friction that was offered, where held-out rows chose more than the simplest of it.
    pub(crate) offered: Vec<DriveTerm>,
    pub(crate) choices: Vec<Choice>,
    /// Friction that may be offered.
    pub(crate) laws: FrictionLibrary,
    /// How often the geometry was found, where it was searched.
    pub(crate) found: Option<GeometryFound>,
}

/// No axis is farther \[rad\] than this from the nearest right angle.
const ANY_ANGLE: f64 = 1.0;
/// Axes farther \[rad\] than this from a right angle may lie anywhere, where that lowers the error on
/// held-out rows by a part that no public arm reaches but an MTM: the others stand at right angles, and
/// seem to gain up to 5 %.
const OBLIQUE: f64 = 0.2;
const WORTH_OF_ANGLES: f64 = 0.1;
/// No axis of an arm that is looked for anywhere is held.
const ANYWHERE: f64 = 0.0;
/// An arm is another than those before only if its error is less by this part.
const CLEARLY: f64 = 0.02;
/// Parallel neighbours must lower the error by this part: a wrist that hardly turns fits either way,
/// and its axes stand across each other.
const WORTH_OF_PARALLEL: f64 = 0.05;
/// Where they lower it by less than this part, the axis is not resolved.
const UNRESOLVED: f64 = 0.3;
/// Rows that trials are fitted on.
const TRIAL_ROWS: usize = 900;
/// Rows that the last fit is made on.
pub(crate) const LAST_ROWS: usize = 4_000;
/// Where more is left of the torque, it is not the ridge that leaves it.
const LEFT_BY_RIDGE: f64 = 0.01;
/// A ridge that is none, and the part of the residual that is left without one where it was all there
/// was to the residual.
const NO_RIDGE: f64 = 1e-8;
const NOTHING: f64 = 0.1;
/// Two chains whose costs are closer than this are one.
const SAME: f64 = 1e-3;

/// Learns the chain of an arm: searches its geometry, where that is not given, and chooses what
/// stands beside its links, both on held-out rows.
pub(crate) fn learn(
    motion: &Motion,
    options: &ChainOptions,
    (seed, before): (u64, Option<Learned>),
    watch: Watch<'_>,
) -> Result<Learned, IdentifyError> {
    let (n, friction) = (motion.n_joints(), options.friction);
    let balanced = balanced(motion, &options.counterbalanced)?;
    let mut learner = ChainLearner::new(motion, watch);
    let known = |kinds: &JointKinds| -> Vec<DriveTerm> {
        let springs =
            balanced.iter().flat_map(|&joint| DriveTerm::counterbalance(n, joint, kinds.of(joint)));
        DriveTerm::rotors(n).into_iter().chain(springs).collect()
    };
    let has_friction = friction != FrictionKind::None;
    let linear: Vec<DriveTerm> = DriveTerm::friction(learner.laws.linear()).collect();
    let at_kinds = |kinds: JointKinds| {
        let mut drive = known(&kinds);
        if has_friction {
            drive.extend(linear.clone());
        }
        let search = Search { seed, kinds, ..Search::default() };
        ChainSpec { drive, search, free: all_parameters(n), gravity: None }
    };
    let mut choices = Vec::new();

    let is_given = options.geometry.is_some();
    let given = given_kinds(motion, options)?;
    let (mut spec, mut chain) = match &options.geometry {
        Some(known) => learner.at_given(known, &at_kinds, &mut choices)?,
        None => learner.moving_geometry((given, before), &at_kinds, &mut choices)?,
    };
    let kinds = chain.geometry.kinds().clone();
    let searched = if is_given { JointKinds::default() } else { kinds.clone() };
    let (mut offers, mut offered) = (learner.springs(&balanced, &kinds), Vec::new());
    if matches!(friction, FrictionKind::Stribeck | FrictionKind::Auto) {
        learner.reverse(&spec, known(&kinds), &chain, &mut choices)?;
    }
    if has_friction {
        offers.extend(learner.shafts(&kinds));
    }
    match friction {
        FrictionKind::None | FrictionKind::Linear => {}
        FrictionKind::Stribeck => {
            spec.drive = known(&kinds);
            spec.drive.extend(DriveTerm::friction(learner.laws.of(FrictionKind::Stribeck)));
            spec = upright(spec, &searched);
        }
        FrictionKind::Auto => {
            let laws = learner.friction(&searched);
            offered = laws.iter().flat_map(Offer::terms).cloned().collect();
            offers.extend(laws);
            spec.drive = known(&kinds);
        }
    }
    learner.choose(&mut spec, &chain, &offers, &mut choices)?;
    choices.extend(balanced.iter().map(|&joint| offers::given_balance(motion, joint)));
    if learner.is_linear(&spec) {
        // Where no joint wants more than dry and viscous friction, what was offered is left out.
        offered.clear();
    }
    if !is_given && spec.drive.iter().any(is_shared) {
        choices.retain(|choice: &Choice| choice.what != AXES);
        chain = learner.geometry(&mut spec, Some(chain), &mut choices)?;
    }
    Progress::Refit.tell(watch)?;
    learner.finish((spec, offered), &chain, choices)
}

/// Whether it is the rotor of a shaft that several joints turn.
fn is_shared(own: &DriveTerm) -> bool {
    matches!(own, DriveTerm::Rotor(shaft) if shaft.iter().filter(|part| **part != 0.0).count() > 1)
}

/// Which joints are said to slide, if that is said: as many as the log has, and as a given geometry has
/// them.
fn given_kinds(
    motion: &Motion,
    options: &ChainOptions,
) -> Result<Option<JointKinds>, IdentifyError> {
    let known = options.geometry.as_ref().map(|known| known.geometry.kinds());
    match &options.kinds {
        Some(own) if !own.fit(motion.n_joints()) || known.is_some_and(|known| known != own) => {
            let joints = motion.joints().join(", ");
            Err(IdentifyError::Kinds { kinds: own.to_string(), joints })
        }
        given => Ok(given.clone()),
    }
}

/// Places of joints that are said to be balanced, each once.
fn balanced(motion: &Motion, names: &[String]) -> Result<Vec<usize>, IdentifyError> {
    let joints = motion.joints();
    let place = |name: &String| {
        joints.iter().position(|joint| joint == name).ok_or_else(|| IdentifyError::NoSuchJoint {
            name: name.clone(),
            joints: joints.join(", "),
        })
    };
    Ok(ascending(names.iter().map(place).collect::<Result<Vec<usize>, _>>()?))
}

/// A chain by its error on held-out rows, with what was fitted.
type Judged = (CvScore, ChainSpec, Chain);

/// The best arm whose axes nearer \[rad\] than `angle` to a right angle stand there, and how many starts
/// led to it, of how many.
struct Way {
    angle: f64,
    times: [usize; 2],
    arm: Judged,
}

/// Judges a chain, its axes nearer than `angle` to a right angle put there.
fn judged(
    label: &str,
    angle: f64,
    start: &Chain,
    (spec, rows): (&ChainSpec, &ChainRows),
    watch: SearchWatch<'_>,
) -> Result<Judged, IdentifyError> {
    let (geometry, free) = start.geometry.snapped(angle);
    let (spec, start) = (ChainSpec { free, ..spec.clone() }, Chain { geometry, ..start.clone() });
    Ok((trial(label.to_owned(), &spec, rows, &start, watch)?, spec, start))
}

fn best(all: Result<Vec<Judged>, IdentifyError>) -> Result<Judged, IdentifyError> {
    let best = all?.into_iter().min_by(|a, b| a.0.error().total_cmp(&b.0.error()));
    best.ok_or(IdentifyError::Chain(ChainError::Singular))
}

const AXES: &str = "axes at right angles";

/// The log in the hands of the learner.
struct ChainLearner<'a> {
    motion: &'a Motion,
    /// Friction that is offered.
    laws: FrictionLibrary,
    found: Option<GeometryFound>,
    watch: Watch<'a>,
}

impl<'a> ChainLearner<'a> {
    fn new(motion: &'a Motion, watch: Watch<'a>) -> Self {
        let peak = |joint: usize| motion.dq().col(joint).norm_max();
        let laws = FrictionLibrary::new((0..motion.n_joints()).map(peak).collect());
        Self { motion, laws, found: None, watch }
    }

    fn rows(&self, spec: &ChainSpec, count: usize) -> Result<ChainRows, IdentifyError> {
        let motion = thinned(self.motion, count);
        let drive = columns(&spec.drive, &motion, spec.gravity.as_ref());
        let rows = chain_rows(&motion, drive)?;
        // Where a joint moves, its friction has one direction.
        let moves =
            |row, joint: usize| motion.dq()[(row, joint)].abs() >= AT_REST * self.laws.width[joint];
        let is_certain = |row, joint| !spec.has_friction() || moves(row, joint);
        let share = |row, joint| if is_certain(row, joint) { 1.0 } else { WEIGHT_AT_REST };
        Ok(rows.measured().with_shares(share))
    }

    /// Whether the friction of no joint is more than dry and viscous.
    fn is_linear(&self, spec: &ChainSpec) -> bool {
        let linear = self.laws.linear();
        let of_joints = spec.drive.iter().filter_map(DriveTerm::law);
        of_joints.filter(|term| term.joint().is_some()).all(|term| linear.contains(term))
    }

    /// Searches the geometry. Of parallel neighbours it is asked whether they may as well stand across
    /// each other.
    fn geometry(
        &mut self,
        spec: &mut ChainSpec,
        known: Option<Chain>,
        choices: &mut Vec<Choice>,
    ) -> Result<Chain, IdentifyError> {
        let (watch, rows) = (searching(self.watch), self.rows(spec, TRIAL_ROWS)?);
        let Way { angle, times: [times, starts], arm } =
            self.axes((spec, &rows), known, choices)?;
        let (mut least, own, mut start) = arm;
        let mut unresolved = Vec::new();
        for joint in 1..self.motion.n_joints() {
            // Those beyond an axis that was turned may have become parallel.
            if angle == ANYWHERE || !start.geometry.is_parallel(joint) {
                continue;
            }
            let across = start.geometry.turned_across(joint).into_par_iter().map(|geometry| {
                let start = Chain { geometry, ..start.clone() };
                judged(&least.label, angle, &start, (spec, &rows), &watch)
            });
            let across = best(across.collect())?;
            if across.0.error() < (1.0 + UNRESOLVED) * least.error() {
                unresolved.push(joint);
            }
            if across.0.error() < (1.0 + WORTH_OF_PARALLEL) * least.error() {
                (least, _, start) = across;
            }
        }
        self.found = Some(GeometryFound { times, starts, unresolved });
        *spec = own;
        let rows = self.rows(spec, FINAL_ROWS)?;
        let chain = refine(&rows, &start, &spec.free, &spec.search, &watch)?;
        let chain = self.falling(spec, &rows, chain)?.upright();
        self.exact(spec, &rows, chain)
    }

    /// Searches arms whose axes stand at right angles, as those of nearly all do, unless held-out rows
    /// are clear: on real logs an axis that may lie anywhere follows what the model lacks. Where freeing
    /// some lowers the error at all, starts lie anywhere too.
    fn axes(
        &self,
        at: (&ChainSpec, &ChainRows),
        known: Option<Chain>,
        choices: &mut Vec<Choice>,
    ) -> Result<Way, IdentifyError> {
        let (watch, many) = (searching(self.watch), self.rows(at.0, LAST_ROWS)?);
        let Found { chains: mut starts, times, starts: made } =
            search(&many, &at.0.search, &watch)?;
        starts.dedup_by(|a, b| (a.cost - b.cost).abs() < SAME * b.cost);
        starts.extend(known);
        let held = starts.par_iter().map(|start| judged("held", ANY_ANGLE, start, at, &watch));
        let held = held.collect::<Result<Vec<Judged>, IdentifyError>>()?;
        let free = starts.par_iter().zip(&held).map(|(start, held)| {
            if start.geometry.snapped(OBLIQUE) != start.geometry.snapped(ANY_ANGLE) {
                return judged("free", OBLIQUE, start, at, &watch);
            }
            let (trial, spec, start) = held.clone();
            Ok((CvScore { label: "free".to_owned(), ..trial }, spec, start))
        });
        let times = [times, made];
        let mut free = Way { angle: OBLIQUE, times, arm: best(free.collect())? };
        let held = Way { angle: ANY_ANGLE, times, arm: best(Ok(held))? };
        if free.arm.0.error() < held.arm.0.error() {
            let offer = |from: &[Chain], times, own: &mut Way| -> Result<(), IdentifyError> {
                let all = from.par_iter().map(|own| judged("free", ANYWHERE, own, at, &watch));
                let arm = best(all.collect())?;
                // An arm that misses more tells no angles.
                if arm.0.error() < Training::POOR.min((1.0 - CLEARLY) * own.arm.0.error()) {
                    *own = Way { angle: ANYWHERE, times, arm };
                }
                Ok(())
            };
            offer(&starts, times, &mut free)?;
            let oblique = Search { is_oblique: true, ..at.0.search.clone() };
            // Where these cannot be fitted, those found so far can; a stop is seen by the next trial.
            if let Ok(found) = search(&many, &oblique, &watch) {
                offer(&found.chains, [found.times, found.starts], &mut free)?;
            }
            if let Ok(turned) = turned(&many, &free.arm.2, &oblique, &watch) {
                offer(&[turned], [1, free.times[1]], &mut free)?;
            }
        }
        let trials = [&held, &free].map(|way| way.arm.0.clone());
        let place = record_worth(AXES, &trials, WORTH_OF_ANGLES, choices);
        Ok(if place == 0 { held } else { free })
    }

    /// Fits the chosen specification on a sample of many rows.
    fn finish(
        &self,
        (mut spec, offered): (ChainSpec, Vec<DriveTerm>),
        chain: &Chain,
        mut choices: Vec<Choice>,
    ) -> Result<Learned, IdentifyError> {
        let rows = self.rows(&spec, LAST_ROWS)?;
        let chain = refine(&rows, chain, &spec.free, &spec.search, &searching(self.watch))?;
        let chain = self.exact(&mut spec, &rows, chain)?;
        let (laws, found) = (self.laws.clone(), self.found.clone());
        choices.extend((!offered.is_empty()).then(|| Choice {
            what: "friction as saved".to_owned(),
            chosen: "mean of the laws chosen and of all offered".to_owned(),
            rule: "errors of laws differ by little [E21]".to_owned(),
            from: Vec::new(),
        }));
        Ok(Learned { chain, spec, offered, choices, laws, found })
    }

    /// The same chain with next to no ridge, here and from here on, where the ridge was all there was to
    /// what it left: a log without noise bears that.
    fn exact(
        &self,
        spec: &mut ChainSpec,
        rows: &ChainRows,
        chain: Chain,
    ) -> Result<Chain, IdentifyError> {
        if error(&chain, rows, rows) > LEFT_BY_RIDGE {
            return Ok(chain);
        }
        let search = Search { ridge: NO_RIDGE, ..spec.search.clone() };
        let exact = refine(rows, &chain, &spec.free, &search, &searching(self.watch))?;
        if left(&exact) > NOTHING * left(&chain) {
            return Ok(chain);
        }
        spec.search = search;
        Ok(exact)
    }
}

/// The observer, in the form that a search reports to.
pub(crate) fn searching(watch: Watch<'_>) -> impl Fn(SearchStage) -> ControlFlow<()> + Sync {
    move |stage| {
        watch(match stage {
            SearchStage::Round => Progress::Working,
            SearchStage::Starts { made, agreeing } => {
                Progress::Starts { made, most: Search::default().starts, agreeing }
            }
        })
    }
}

/// What a chain leaves of all torques \[N·m\], by which those of other weights are compared.
fn left(chain: &Chain) -> f64 {
    geometric_mean(&chain.residual_rms)
}

/// RMS of what a chain leaves of each joint \[N·m\], all rows alike, n.
pub(crate) fn residual_rms(chain: &Chain, rows: &ChainRows) -> Vec<f64> {
    let (m, predicted) = (rows.len(), chain.torque(rows));
    let of_joint = |joint: usize| {
        let pairs = rows.torque_of(joint).iter().zip(&predicted[joint * m..]);
        let squares: f64 = pairs.map(|(tau, found)| (tau - found).powi(2)).sum();
        (squares / m.max(1) as f64).sqrt()
    };
    (0..rows.n_joints()).map(of_joint).collect()
}
