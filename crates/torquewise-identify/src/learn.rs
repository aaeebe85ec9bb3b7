//! A chain learned from a sample of a log: geometry, inertia and friction (E8).

use crate::chain_spec::error;
use crate::{
    AT_REST, ChainOptions, ChainSpec, DriveTerm, FrictionKind, Progress, WEIGHT_AT_REST, Watch,
    chain_rows, columns, geometric_mean,
};
use axes::AXES;
pub(crate) use gravity::against_axes;
use kinds::upright;
use offers::Offer;
use std::ops::ControlFlow;
use torquewise_model::{Choice, GeometryFound};
use torquewise_motion::Motion;
use torquewise_regression::ascending;
use torquewise_rigid::search::{FINAL_ROWS, SearchStage, all_parameters};
use torquewise_rigid::{Chain, ChainRows, JointKinds, Search, refine};
use torquewise_stepwise::friction::FrictionLibrary;
use torquewise_stepwise::{IdentifyError, thinned};

mod axes;
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
    let rotors = spec.drive.iter().filter(|own| matches!(own, DriveTerm::Rotor(_)));
    // Each joint has one; any more are of shafts that two share.
    if !is_given && rotors.count() > n {
        choices.retain(|choice: &Choice| choice.what != AXES);
        chain = learner.geometry(&mut spec, Some(chain), &mut choices)?;
    }
    Progress::Refit.tell(watch)?;
    learner.finish((spec, offered), &chain, choices)
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
