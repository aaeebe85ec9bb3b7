//! Which joints turn and which slide, by held-out rows (E26).

use super::axes::UNRESOLVED;
use super::couplings::COUPLING;
use super::{
    ChainLearner, DriveTerm, LEFT_BY_RIDGE, Learned, NO_RIDGE, TRIAL_ROWS, Watch, searching,
};
use crate::excitation::LEAST_RANGE;
use crate::{ChainSpec, geometric_mean, record_worth, trial};
use rayon::prelude::*;
use torquewise_model::{Choice, FrictionLaw, FrictionTerm, JointKind, JointKinds, Training};
use torquewise_motion::{Motion, ends};
use torquewise_rigid::search::{all_parameters, glance};
use torquewise_rigid::{Chain, ChainRows, Search, refine};
use torquewise_stepwise::IdentifyError;

/// Travel \[m\] of a slide at most: a joint that goes farther is taken to turn. Arms with longer ones
/// are told of them.
const LONGEST_SLIDE: f64 = 2.0;
/// Slides of an arm at most: more would only repeat a direction.
const MOST_SLIDES: usize = 3;
/// Starts of a first look, and its rows: of surgical arms, which slide by little, fewer starts miss the
/// slide of one log in six.
const GLANCE: (usize, usize) = (8, 60);
/// Slides must lower the error by this part: a joint that turned by little fits either way, and most
/// joints turn. Of a joint of so little travel that it is warned of, held-out rows alone decide: it
/// slides where that errs less by more than a standard error.
const WORTH_OF_SLIDES: f64 = 0.1;

/// As the model file has them.
const KINDS: &str = "kinds of joints";
const KIND_OF: &str = "kind of";

/// A slide is turned the other way for a positive mass where that costs this part at most.
const SIGN_OF_MASS: f64 = 0.05;

/// What joints are at a first look at a motion.
#[derive(Clone, Debug, Default)]
pub struct FirstLook {
    /// The kinds they seem to be of.
    pub kinds: JointKinds,
    /// Joints that may slide all the same, and how: they moved by little, and fit nearly as well so.
    pub may_slide: Vec<(usize, JointKind)>,
    /// Joints that fit nearly as well as the other kind.
    untold: Vec<usize>,
}

/// A first look at the joints of a motion.
///
/// # Errors
/// [`IdentifyError::Chain`] if the watcher breaks, or no chain is found.
pub fn first_look(
    motion: &Motion,
    seed: u64,
    watch: Watch<'_>,
) -> Result<FirstLook, IdentifyError> {
    let (learner, n) = (ChainLearner::new(motion, watch), motion.n_joints());
    learner.first_look(&|kinds: JointKinds| {
        let drive = DriveTerm::usual(&learner.laws);
        let search = Search { seed, kinds, ..Search::default() };
        ChainSpec { drive, search, free: all_parameters(n), gravity: None }
    })
}

/// A specification, its chain, and how its axes were chosen.
pub(super) type Searched = (ChainSpec, Chain, Vec<Choice>);

impl ChainLearner<'_> {
    /// Searches the geometry of joints of given kinds; or of joints that all turn, then looks for those
    /// that rather slide. Then it looks for coupled ones. What was found of the joints before stays.
    ///
    /// - `before`: the arm as it was learned at another bandwidth
    /// - `at`: the specification for joints of some kinds
    pub(super) fn moving_geometry(
        &mut self,
        (given, before): (Option<JointKinds>, Option<Learned>),
        at: &(impl Fn(JointKinds) -> ChainSpec + Sync),
        choices: &mut Vec<Choice>,
    ) -> Result<(ChainSpec, Chain), IdentifyError> {
        if let Some(Learned { chain, choices: before, .. }) = before {
            let kinds = chain.geometry.kinds();
            let is_of_joints = |own: &Choice| {
                [KINDS, COUPLING].contains(&own.what.as_str()) || own.what.starts_with(KIND_OF)
            };
            choices.extend(before.into_iter().filter(is_of_joints));
            let mut spec = upright(at(kinds.clone()), kinds);
            spec.search.coupling = chain.geometry.coupling().clone();
            let chain = self.geometry(&mut spec, None, choices)?;
            return Ok((spec, chain));
        }
        let searched = match given {
            Some(kinds) => self.searched(upright(at(kinds.clone()), &kinds))?,
            None => self.kinds_and_geometry(at, choices)?,
        };
        self.coupled_geometry(searched, choices)
    }

    /// The geometry of a specification, and how its axes were chosen.
    pub(super) fn searched(&mut self, mut spec: ChainSpec) -> Result<Searched, IdentifyError> {
        let mut own = Vec::new();
        let chain = self.geometry(&mut spec, None, &mut own)?;
        Ok((spec, chain, own))
    }

    /// The geometry of joints of the kinds that held-out rows choose, and how its axes were chosen.
    fn kinds_and_geometry(
        &mut self,
        at: &(impl Fn(JointKinds) -> ChainSpec + Sync),
        choices: &mut Vec<Choice>,
    ) -> Result<Searched, IdentifyError> {
        let (mut kinds, n) = (JointKinds::default(), self.motion.n_joints());
        let mut best = self.searched(at(kinds.clone()))?;
        let look = self.first_look(at)?;
        if !look.kinds.all_turn() {
            // Where no joint tells, slides that fit are simpler: a mass each, without a place.
            let is_simpler = look.untold.len() == n;
            let rule = (WORTH_OF_SLIDES, is_simpler);
            if let Some(slid) = self.slid(at, &look.kinds, (&best, rule), choices)? {
                (best, kinds) = (slid, look.kinds.clone());
            }
        }
        for &(joint, kind) in &look.may_slide {
            let other = kinds.with(joint, kind, n);
            if let Some(slid) = self.slid(at, &other, (&best, (0.0, false)), choices)? {
                (best, kinds) = (slid, other);
            }
        }
        choices.extend(look.untold.iter().map(|&joint| Choice {
            what: format!("{KIND_OF} {}", self.motion.joints()[joint]),
            chosen: kinds.of(joint).name.to_owned(),
            rule: "not told by the log: the other kind fits nearly as well".to_owned(),
            from: Vec::new(),
        }));
        Ok(best)
    }

    /// The geometry of joints of other kinds, where held-out rows are for it.
    ///
    /// - `rule`: the part by which the error must fall, and whether the other kinds are simpler
    fn slid(
        &mut self,
        at: &(impl Fn(JointKinds) -> ChainSpec + Sync),
        kinds: &JointKinds,
        (known, rule): (&Searched, (f64, bool)),
        choices: &mut Vec<Choice>,
    ) -> Result<Option<Searched>, IdentifyError> {
        let (found, n) = (self.found.clone(), self.motion.n_joints());
        let slid = self.searched(upright(at(kinds.clone()), kinds))?;
        let watch = searching(self.watch);
        let judged = |(spec, chain, _): &Searched| {
            let kinds = chain.geometry.kinds();
            let of_kinds = || format!("kinds {}", kinds.letters(n));
            let label = if kinds.all_turn() { "all turn".to_owned() } else { of_kinds() };
            trial(label, spec, &self.rows(spec, TRIAL_ROWS)?, chain, &watch)
        };
        let (worth, is_simpler) = rule;
        let (known, other) = (judged(known)?, judged(&slid)?);
        let (trials, place) = if is_simpler { ([other, known], 0) } else { ([known, other], 1) };
        let is_other = record_worth(KINDS, &trials, worth, choices) == place;
        if !is_other {
            self.found = found;
        }
        Ok(is_other.then_some(slid))
    }

    /// The same chain with slides pointing the way in which gravity pulls what they bear: a slide that
    /// works on gravity alone is explained as well by a negative mass the other way.
    pub(super) fn falling(
        &self,
        spec: &ChainSpec,
        rows: &ChainRows,
        mut chain: Chain,
    ) -> Result<Chain, IdentifyError> {
        for joint in 0..self.motion.n_joints() {
            if chain.geometry.kinds().slides(joint) && chain.mass_beyond(joint) < 0.0 {
                let back = Chain { geometry: chain.geometry.turned_back(joint), ..chain.clone() };
                let back = refine(rows, &back, &spec.free, &spec.search, &searching(self.watch))?;
                if back.mass_beyond(joint) > 0.0 && back.cost < (1.0 + SIGN_OF_MASS) * chain.cost {
                    chain = back;
                }
            }
        }
        Ok(chain)
    }

    /// The kinds that few rows are best with, one joint changed after another as long as that is worth
    /// it, and those that may slide all the same.
    fn first_look(
        &self,
        at: &(impl Fn(JointKinds) -> ChainSpec + Sync),
    ) -> Result<FirstLook, IdentifyError> {
        let (n, (starts, count)) = (self.motion.n_joints(), GLANCE);
        let watch = searching(self.watch);
        let left = |kinds: &JointKinds| -> Result<f64, IdentifyError> {
            let spec = at(kinds.clone());
            let rows = self.rows(&spec, count)?;
            let search = Search { starts, ..spec.search };
            let part = |search: &Search| geometric_mean(&glance(&rows, search, &watch));
            let own = part(&search);
            let free = || part(&Search { ridge: NO_RIDGE, ..search.clone() });
            Ok(if own > LEFT_BY_RIDGE { own } else { own.min(free()) })
        };
        let q = self.motion.q();
        let travel = |joint: usize| {
            let [low, high] = ends(q.col(joint).iter().copied());
            high - low
        };
        // One that rests is no slide that is found.
        let is_short =
            |joint: &usize| (Training::AT_REST..=LONGEST_SLIDE).contains(&travel(*joint));
        let short: Vec<usize> = (0..n).filter(is_short).collect();
        if short.is_empty() {
            return Ok(FirstLook::default());
        }
        let mut kinds = JointKinds::default();
        let mut least = left(&kinds)?;
        let count = |kinds: &JointKinds| (0..n).filter(|&joint| kinds.slides(joint)).count();
        let tried = loop {
            let known = &kinds;
            let others = |&joint: &usize| {
                let others =
                    JointKind::ALL.into_iter().filter(move |kind| *kind != known.of(joint));
                others.map(move |kind| (joint, known.with(joint, kind, n)))
            };
            let tried = short.par_iter().flat_map_iter(others);
            let tried = tried.map(|(joint, other)| Ok((left(&other)?, joint, other)));
            let tried = tried.collect::<Result<Vec<_>, IdentifyError>>()?;
            let best = tried.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            let worthy = best.filter(|(best, ..)| *best < (1.0 - WORTH_OF_SLIDES) * least);
            let worthy = worthy.filter(|(.., other)| count(other) <= MOST_SLIDES);
            let Some((best, _, other)) = worthy else { break tried };
            (least, kinds) = (*best, other.clone());
        };
        let is_near = |left: f64| left < (1.0 + UNRESOLVED) * least;
        let near = tried.into_iter().filter(|(left, ..)| is_near(*left));
        let mut untold: Vec<usize> = near.map(|(_, joint, _)| joint).collect();
        untold.dedup();
        let alike = like_the_others(&kinds, &untold, n);
        if alike != kinds && count(&alike) <= MOST_SLIDES && is_near(left(&alike)?) {
            kinds = alike;
        }
        let may_slide = |joint: &usize| !kinds.slides(*joint) && travel(*joint) <= LEAST_RANGE;
        let may_slide = untold.iter().copied().filter(may_slide);
        let may_slide = may_slide.take(MOST_SLIDES.saturating_sub(count(&kinds)));
        let may_slide = may_slide.flat_map(|joint| sliding().map(move |kind| (joint, kind)));
        Ok(FirstLook { may_slide: may_slide.collect(), kinds, untold })
    }
}

/// Whether a log does not tell the kind of a joint, as the choices of its fit have it.
pub(crate) fn is_kind_untold(choices: &[Choice], joint: &str) -> bool {
    choices.iter().any(|own| own.what == format!("{KIND_OF} {joint}"))
}

/// Whether friction is no offset of a slide whose direction is searched: gravity explains that as
/// well, and tells which way is up.
pub(super) fn is_told_from_gravity(term: &FrictionTerm, searched: &JointKinds) -> bool {
    let shaft = term.shaft.iter().enumerate();
    let on_slide = shaft.filter(|(_, part)| **part != 0.0).any(|(joint, _)| searched.slides(joint));
    term.law != FrictionLaw::Offset || !on_slide
}

/// A specification with friction that can be told from gravity alone.
pub(super) fn upright(mut spec: ChainSpec, searched: &JointKinds) -> ChainSpec {
    spec.drive.retain(|term| term.law().is_none_or(|law| is_told_from_gravity(law, searched)));
    spec
}

fn sliding() -> impl Iterator<Item = JointKind> {
    JointKind::ALL.into_iter().filter(|kind| kind.slides())
}

/// The same kinds, but that joints of which the log does not tell slide where most of the others do.
fn like_the_others(kinds: &JointKinds, untold: &[usize], n: usize) -> JointKinds {
    let told: Vec<usize> = (0..n).filter(|joint| !untold.contains(joint)).collect();
    let slides = told.iter().filter(|&&joint| kinds.slides(joint)).count();
    if !told.is_empty() && 2 * slides <= told.len() {
        return kinds.clone();
    }
    let usual = told.iter().map(|&joint| kinds.of(joint)).find(|kind| kind.slides());
    let Some(kind) = usual.or_else(|| sliding().next()) else { return kinds.clone() };
    untold.iter().fold(kinds.clone(), |kinds, &joint| kinds.with(joint, kind, n))
}
