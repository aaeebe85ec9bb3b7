//! Joints that several logged coordinates turn, where the log shows it (E18).

use super::kinds::Searched;
use super::{ChainLearner, FINAL_ROWS, TRIAL_ROWS, left, searching};
use crate::{ChainSpec, geometric_mean, record_worth, trial};
use rayon::prelude::*;
use torquewise_model::Choice;
use torquewise_rigid::coupling::Coupled;
use torquewise_rigid::search::glance;
use torquewise_rigid::{Chain, Coupling, JointKinds, Search, refine};
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::held_out::CvScore;

/// As the model file has it.
pub(super) const COUPLING: &str = "coupling";
/// Coupled joints at most.
const MOST_COUPLED: usize = 2;
/// Starts of a first look at a coupling, and its rows.
const GLANCE: (usize, usize) = (2, 80);
/// A coupling is searched with if it lowers what the first look leaves to this part.
const PROMISING: f64 = 0.7;
/// A coupling must lower the error on held-out rows to this part: arms seldom have one.
const COUPLING_GAIN: f64 = 0.7;

impl ChainLearner<'_> {
    /// Looks beyond a geometry that was found for joints that the coordinate of the joint before turns
    /// as well, as behind a parallelogram \[E18\].
    ///
    /// - `own`: how its axes were chosen
    pub(super) fn coupled_geometry(
        &mut self,
        (spec, mut chain, mut own): Searched,
        choices: &mut Vec<Choice>,
    ) -> Result<(ChainSpec, Chain), IdentifyError> {
        let mut best = spec.clone();
        for _ in 0..MOST_COUPLED {
            let mut known = spec.clone();
            known.search.coupling = best.search.coupling.clone();
            let Some((label, search)) = self.promising(&known)? else { break };
            let (with, found, made) = self.searched(ChainSpec { search, ..known })?;
            let rows = self.rows(&spec, TRIAL_ROWS)?;
            let trials = [
                trial("none".to_owned(), &best, &rows, &chain, &searching(self.watch))?,
                trial(label, &with, &rows, &found, &searching(self.watch))?,
            ];
            if !is_coupled(&trials, choices) {
                break;
            }
            (best, chain, own) = (with, found, made);
        }
        choices.extend(own);
        Ok((best, chain))
    }

    /// Looks for such joints beyond a geometry that is given, which stays.
    pub(super) fn coupled_at(
        &self,
        spec: &ChainSpec,
        mut chain: Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<Chain, IdentifyError> {
        let (few, all) = (self.rows(spec, TRIAL_ROWS)?, self.rows(spec, FINAL_ROWS)?);
        let watch = searching(self.watch);
        for _ in 0..MOST_COUPLED {
            let known = chain.geometry.coupling();
            let without = left(&refine(&few, &chain, &spec.free, &spec.search, &watch)?);
            let tried = self.pairs(chain.geometry.kinds(), known).into_par_iter().map(|own| {
                let geometry = chain.geometry.clone().coupled(known.with(own));
                let start = Chain { geometry, ..chain.clone() };
                Ok((label(own), refine(&few, &start, &spec.free, &spec.search, &watch)?))
            });
            let tried = tried.collect::<Result<Vec<_>, IdentifyError>>()?;
            let best = tried.into_iter().min_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
            let best = best.filter(|(_, found)| left(found) <= PROMISING * without);
            let Some((label, found)) = best else { break };
            let trials = [
                trial("none".to_owned(), spec, &few, &chain, &watch)?,
                trial(label, spec, &few, &found, &watch)?,
            ];
            if !is_coupled(&trials, choices) {
                break;
            }
            chain = refine(&all, &found, &spec.free, &spec.search, &watch)?;
        }
        Ok(chain)
    }

    /// The search with one more coupled joint that a first look at few rows is best with, if it is
    /// much better than without.
    fn promising(&self, spec: &ChainSpec) -> Result<Option<(String, Search)>, IdentifyError> {
        let (most, count) = GLANCE;
        let rows = self.rows(spec, count)?;
        let known = &spec.search.coupling;
        let look = Search { starts: most, ..spec.search.clone() };
        let candidates = self.pairs(&spec.search.kinds, known);
        let watch = searching(self.watch);
        let left = |search: &Search| geometric_mean(&glance(&rows, search, &watch));
        let with = |&own| left(&Search { coupling: known.with(own), ..look.clone() });
        let without = left(&look);
        let left: Vec<f64> = candidates.par_iter().map(with).collect();
        let best = candidates.into_iter().zip(left).min_by(|a, b| a.1.total_cmp(&b.1));
        Ok(best.filter(|(_, left)| *left <= PROMISING * without).map(|(own, _)| {
            (label(own), Search { coupling: known.with(own), ..spec.search.clone() })
        }))
    }

    /// What may be coupled beyond what is: joints that turn, to the one before.
    fn pairs(&self, kinds: &JointKinds, known: &Coupling) -> Vec<Coupled> {
        let turns = |joint: &usize| kinds.of(*joint).turns() && kinds.of(joint - 1).turns();
        let joints = (1..self.motion.n_joints()).filter(turns);
        let pairs = joints
            .flat_map(|joint| [-1, 1].map(|ratio| Coupled { joint, driver: joint - 1, ratio }));
        let is_new = |own: &Coupled| {
            known.coupled().iter().all(|k| (k.joint, k.driver) != (own.joint, own.driver))
        };
        pairs.filter(is_new).collect()
    }
}

/// Whether the second of two trials, with a coupled joint, is to be taken.
fn is_coupled(trials: &[CvScore; 2], choices: &mut Vec<Choice>) -> bool {
    trials[1].error() <= COUPLING_GAIN * trials[0].error()
        && record_worth(COUPLING, trials, 0.0, choices) > 0
}

/// `q3 - q2`: what turns a coupled joint.
fn label(Coupled { joint, driver, ratio }: Coupled) -> String {
    let sign = if ratio < 0 { '-' } else { '+' };
    format!("q{} {sign} q{}", joint + 1, driver + 1)
}
