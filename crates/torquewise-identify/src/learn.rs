//! A sample of a log → chain: the geometry of the arm, its masses and its friction (E8).

use crate::beside::{Beside, columns};
use crate::plan::{ChainOptions, FrictionKind};
use crate::trial::{Recipe, record, record_best, trial};
use couplings::Searched;
use rayon::prelude::*;
use torquewise_model::model::Choice;
use torquewise_motion::Motion;
use torquewise_rigid::search::all_parameters;
use torquewise_rigid::{Chain, Rows, Search, refine, search};
use torquewise_survey::error::IdentifyError;
use torquewise_survey::friction::Dictionary;
use torquewise_survey::held_out::Trial;
use torquewise_survey::survey::thinned;

mod couplings;
mod left_over;
mod further;
mod joint_friction;
mod loads;
mod ripple;

/// A chain with what stands beside it, and how both were chosen.
#[derive(Clone, Debug)]
pub(crate) struct Learned {
    pub(crate) chain: Chain,
    /// What was fitted: what stands beside the links, which of the geometry moved.
    pub(crate) recipe: Recipe,
    pub(crate) choices: Vec<Choice>,
    /// Rows on which terms that are not the chain's are tried.
    pub(crate) rows: Rows,
    /// Friction that may be offered.
    pub(crate) laws: Dictionary,
}

/// Pulls to right angles that are tried, the strongest first.
const PULLS: [f64; 4] = [0.3, 0.1, 0.03, 0.003];
/// No axis is farther \[rad\] than this from the nearest right angle.
const ANY_ANGLE: f64 = 1.0;
/// Parts of the pull that are tried once axes are at right angles.
const RELEASED: [f64; 3] = [1.0, 0.1, 0.01];
/// Ridges that are tried, the strongest first.
const RIDGES: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Weaker ones, tried where the weakest of those is the best: only a log without noise bears them.
const WEAK_RIDGES: [f64; 2] = [1e-6, 1e-8];
/// Axes nearer to a right angle \[rad\] and to the axis before \[m\] than this are put there, if
/// held-out rows agree.
const SNAPS: [(f64, f64); 3] = [(0.4, 0.06), (0.2, 0.03), (0.1, 0.015)];
/// Rows of a joint slower than so many half widths of the reversal say nothing of its friction,
/// which may be anything at rest.
pub(crate) const AT_REST: f64 = 3.0;
/// What such a row counts in a fit: little, but it knows gravity.
const SHARE_AT_REST: f64 = 0.1;
/// Rounds of refinement on all but a held-out block.
const ROUNDS: usize = 6;
/// The same once axes were put elsewhere.
const SNAP_ROUNDS: usize = 15;
/// Rows that trials are fitted on.
const TRIAL_ROWS: usize = 900;
/// Rows that the last fit is made on.
pub(crate) const LAST_ROWS: usize = 4_000;
/// Rows that terms beside those of the chain are tried on.
pub(crate) const TRIED_ROWS: usize = 1_500;
/// A log of fewer rows after its filter leaves several geometries about as likely: which is found
/// first is chance.
const SHORT: usize = 1_000;
/// Searches that are made then.
const SEARCHES: u64 = 4;
/// Two chains whose costs are closer than this are one.
const SAME: f64 = 1e-3;

/// Learns the chain of an arm, choosing on held-out blocks of time.
///
/// Where the log is short, several searches are made, each from another seed.
///
/// # Errors
/// [`IdentifyError::Chain`] if no chain can be fitted, [`IdentifyError::NoSuchJoint`] if a joint is
/// said to be balanced that is not there.
pub(crate) fn learn(
    motion: &Motion,
    options: &ChainOptions,
    seed: u64,
) -> Result<Learned, IdentifyError> {
    if motion.n_rows() >= SHORT {
        let Attempt { school, recipe, chain, choices } = attempt(motion, options, seed)?;
        return school.finish(recipe, &chain, choices);
    }
    let (mut found, mut failed) = (Vec::new(), None);
    for more in 0..SEARCHES {
        let seed = seed.wrapping_add(more);
        match attempt(motion, options, seed)
            .and_then(|attempt| Ok((attempt.judged(seed)?, attempt)))
        {
            Ok(judged) => found.push(judged),
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    if let (true, Some(error)) = (found.is_empty(), failed) {
        return Err(error);
    }
    found.sort_by_key(|(judged, _)| judged.complexity);
    let trials: Vec<Trial> = found.iter().map(|(judged, _)| judged.clone()).collect();
    let mut choices = Vec::new();
    let place = record("seed of the search", &trials, &mut choices);
    let Attempt { school, recipe, chain, choices: made } = found.swap_remove(place).1;
    choices.extend(made);
    school.finish(recipe, &chain, choices)
}

/// What one search came to.
struct Attempt<'a> {
    school: School<'a>,
    recipe: Recipe,
    chain: Chain,
    choices: Vec<Choice>,
}

impl Attempt<'_> {
    /// How it does on held-out rows, and how many numbers it takes.
    fn judged(&self, seed: u64) -> Result<Trial, IdentifyError> {
        let rows = self.school.rows(&self.recipe, TRIAL_ROWS)?;
        let judged = trial(seed.to_string(), &self.recipe, &rows, &self.chain, ROUNDS)?;
        let complexity = self.recipe.free.len() + self.recipe.beside.len();
        Ok(Trial { complexity, ..judged })
    }
}

/// Searches the geometry and chooses all that is fitted, from one seed.
fn attempt<'a>(
    motion: &'a Motion,
    options: &ChainOptions,
    seed: u64,
) -> Result<Attempt<'a>, IdentifyError> {
    let (n, friction) = (motion.n_joints(), options.friction);
    let balanced = loads::balanced(motion, &options.counterbalanced)?;
    let mut school = School::new(motion);
    let mut beside = Beside::rotors(n);
    let rubs = friction != FrictionKind::None;
    if rubs {
        beside.extend(Beside::friction(school.laws.linear()));
    }
    let search = Search { seed, ..Search::default() };
    let recipe = Recipe { beside, search, free: all_parameters(n), gravity: None };
    let mut choices = Vec::new();

    let Searched { mut recipe, mut chain, mut starts } =
        school.coupled_geometry(&recipe, &mut choices)?;
    if rubs && school.shafts(&mut recipe, &chain, &mut choices)? {
        choices.retain(|choice: &Choice| choice.what != PULL);
        (chain, starts) = school.geometry(&mut recipe, Some(chain), &mut choices)?;
    }
    school.counterbalances(&mut recipe, &chain, &balanced, &mut choices)?;
    if rubs {
        school.reversal(&mut recipe, &chain, friction, &mut choices)?;
    }
    school.friction(&mut recipe, &chain, friction, &mut choices)?;
    if friction == FrictionKind::Auto && recipe.rubs() {
        school.joint_friction(&mut recipe, &chain, &mut choices)?;
        school.ripple(&mut recipe, &chain, &mut choices)?;
    }
    school.ridge(&mut recipe, &chain, &mut choices)?;
    chain = school.right_angles(&mut recipe, &chain, &starts, &mut choices)?;
    Ok(Attempt { school, recipe, chain, choices })
}

const PULL: &str = "pull to right angles";

/// A label, what is fitted, and from where.
type Way = (String, Recipe, Chain);

/// Each start with its axes held at right angles, as those of nearly all arms are, then with each
/// pull: on a short log, an axis that may lie anywhere follows the noise.
fn pulls(recipe: &Recipe, starts: &[Chain]) -> Vec<Way> {
    let held = starts.iter().map(|start| {
        let (geometry, free) = start.geometry.snapped(ANY_ANGLE, 0.0);
        let search = Search { pull: PULLS[0], ..recipe.search.clone() };
        let recipe = Recipe { search, free, ..recipe.clone() };
        ("held".to_owned(), recipe, Chain { geometry, ..start.clone() })
    });
    let pulled = PULLS.iter().flat_map(|&pull| {
        starts.iter().map(move |start| {
            let search = Search { pull, ..recipe.search.clone() };
            (format!("{pull}"), Recipe { search, ..recipe.clone() }, start.clone())
        })
    });
    held.chain(pulled).collect()
}

/// The log in the hands of the learner.
struct School<'a> {
    motion: &'a Motion,
    /// Friction that is offered.
    laws: Dictionary,
}

impl<'a> School<'a> {
    fn new(motion: &'a Motion) -> Self {
        let speed = |joint: usize| {
            motion.dq().col(joint).iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()))
        };
        let laws = Dictionary::new((0..motion.n_joints()).map(speed).collect());
        Self { motion, laws }
    }

    fn rows(&self, recipe: &Recipe, count: usize) -> Result<Rows, IdentifyError> {
        let motion = thinned(self.motion, count);
        let beside = columns(&recipe.beside, &motion, recipe.gravity.as_ref());
        let tau = motion.require_tau()?;
        let rows = Rows::new([motion.q(), motion.dq(), motion.ddq(), tau], &beside)?;
        if !recipe.rubs() {
            return Ok(rows);
        }
        Ok(rows.with_shares(|row, joint| self.share(&motion, row, joint)))
    }

    /// What the square of a row counts in a fit of the torque of a joint.
    fn share(&self, motion: &Motion, row: usize, joint: usize) -> f64 {
        let moves = motion.dq()[(row, joint)].abs() >= AT_REST * self.laws.width[joint];
        if moves { 1.0 } else { SHARE_AT_REST }
    }

    /// Searches the geometry, then chooses how strongly it is pulled to right angles.
    fn geometry(
        &self,
        recipe: &mut Recipe,
        known: Option<Chain>,
        choices: &mut Vec<Choice>,
    ) -> Result<(Chain, Vec<Chain>), IdentifyError> {
        let mut starts = search(&self.rows(recipe, LAST_ROWS)?, &recipe.search)?;
        starts.dedup_by(|a, b| (a.cost - b.cost).abs() < SAME * b.cost);
        starts.extend(known);
        let rows = self.rows(recipe, TRIAL_ROWS)?;
        let ways = pulls(recipe, &starts);
        let trials = ways
            .par_iter()
            .map(|(label, recipe, start)| trial(label.clone(), recipe, &rows, start, ROUNDS))
            .collect::<Result<Vec<Trial>, IdentifyError>>()?;
        let (_, chosen, start) = &ways[record_best(PULL, &trials, starts.len(), choices)];
        recipe.clone_from(chosen);
        let rows = self.rows(recipe, recipe.search.final_rows)?;
        let chain = refine(&rows, start, &recipe.free, &recipe.search)?;
        Ok((chain, starts))
    }

    fn ridge(
        &self,
        recipe: &mut Recipe,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let way = |ridge: &f64| {
            let search = Search { ridge: *ridge, ..recipe.search.clone() };
            (format!("{ridge:e}"), Recipe { search, ..recipe.clone() })
        };
        let mut ways: Vec<(String, Recipe)> = RIDGES.iter().map(way).collect();
        let mut trials = self.trials(&ways, chain, 0)?;
        let errors: Vec<f64> = trials.iter().map(Trial::error).collect();
        if errors.last() < errors.first() && errors.iter().all(|e| Some(e) >= errors.last()) {
            let weak: Vec<(String, Recipe)> = WEAK_RIDGES.iter().map(way).collect();
            trials.extend(self.trials(&weak, chain, 0)?);
            ways.extend(weak);
        }
        *recipe = ways[record("ridge", &trials, choices)].1.clone();
        Ok(())
    }

    /// Puts axes at right angles and on each other where held-out rows do not object: each
    /// parameter that is zero makes the model shorter.
    fn right_angles(
        &self,
        recipe: &mut Recipe,
        chain: &Chain,
        starts: &[Chain],
        choices: &mut Vec<Choice>,
    ) -> Result<Chain, IdentifyError> {
        let rows = self.rows(recipe, TRIAL_ROWS)?;
        let sources: Vec<&Chain> = std::iter::once(chain).chain(starts).collect();
        let mut ways: Vec<Way> = Vec::new();
        for (angle, distance) in SNAPS {
            for source in &sources {
                let (geometry, free) = source.geometry.snapped(angle, distance);
                let label = format!("{angle} rad, {distance} m: {} free", free.len());
                let start = Chain { geometry, ..chain.clone() };
                ways.push((label, Recipe { free, ..recipe.clone() }, start));
            }
        }
        ways.push((format!("none: {} free", recipe.free.len()), recipe.clone(), chain.clone()));
        let trials = ways
            .par_iter()
            .map(|(label, recipe, start)| trial(label.clone(), recipe, &rows, start, SNAP_ROUNDS))
            .collect::<Result<Vec<_>, _>>()?;
        let place = record_best("right angles", &trials, sources.len(), choices);
        let (_, chosen, chain) = ways.swap_remove(place);
        *recipe = chosen;
        // What is left free lies where it lies: the pull has done its work.
        let ways = RELEASED.map(|part| {
            let pull = part * recipe.search.pull;
            let search = Search { pull, ..recipe.search.clone() };
            (format!("{pull:.1e}"), Recipe { search, ..recipe.clone() })
        });
        let place = self.choose("pull on free axes", &ways, &chain, ROUNDS, choices)?;
        *recipe = ways[place].1.clone();
        Ok(chain)
    }

    /// Fits the chosen recipe on a sample of many rows.
    fn finish(
        &self,
        recipe: Recipe,
        chain: &Chain,
        choices: Vec<Choice>,
    ) -> Result<Learned, IdentifyError> {
        let rows = self.rows(&recipe, LAST_ROWS)?;
        let chain = refine(&rows, chain, &recipe.free, &recipe.search)?;
        let rows = self.rows(&recipe, TRIED_ROWS)?;
        let laws = self.laws.clone();
        Ok(Learned { chain, recipe, choices, rows, laws })
    }

    fn choose(
        &self,
        what: &str,
        ways: &[(String, Recipe)],
        chain: &Chain,
        rounds: usize,
        choices: &mut Vec<Choice>,
    ) -> Result<usize, IdentifyError> {
        Ok(record(what, &self.trials(ways, chain, rounds)?, choices))
    }

    fn trials(
        &self,
        ways: &[(String, Recipe)],
        chain: &Chain,
        rounds: usize,
    ) -> Result<Vec<Trial>, IdentifyError> {
        ways.par_iter()
            .map(|(label, recipe)| {
                let rows = self.rows(recipe, TRIAL_ROWS)?;
                trial(label.clone(), recipe, &rows, chain, rounds)
            })
            .collect()
    }
}
