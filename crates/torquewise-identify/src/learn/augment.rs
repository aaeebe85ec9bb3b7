//! From learned chain, term to the chain with that term beside it, where held-out rows agree (E10).

use super::residual::WORTH;
use super::{ChainLearner, LAST_ROWS, Learned, SNAP_ROUNDS, TRIAL_ROWS};
use crate::chain_spec::{ChainSpec, trial};
use crate::drive_terms::DriveTerm;
use torquewise_model::EnergyTerm;
use torquewise_model::model::Choice;
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, refine};
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::listed;

impl Learned {
    /// Takes in a term that no chain of rigid bodies has, if a fit with it, geometry and all,
    /// predicts held-out rows better than one without. Returns whether it was taken.
    ///
    /// - `motion`: what the chain was learned from
    pub(crate) fn offer(
        &mut self,
        term: &EnergyTerm,
        motion: &Motion,
    ) -> Result<bool, IdentifyError> {
        let learner = ChainLearner { motion, laws: self.laws.clone() };
        let mut with = self.spec.clone();
        with.drive.push(DriveTerm::Energy(term.clone()));
        // The geometry was learned without the term and may be bent to stand for it: with it, the
        // chain is fitted first, and the other as well, so that both start alike.
        let refined = |spec: &ChainSpec| {
            let rows = learner.rows(spec, LAST_ROWS)?;
            Ok::<Chain, IdentifyError>(refine(&rows, &self.chain, &spec.free, &spec.search)?)
        };
        let (without, chain) = (refined(&self.spec)?, refined(&with)?);
        let ways = [("none".to_owned(), &self.spec, &without), (term.name(), &with, &chain)];
        let trials = ways
            .into_iter()
            .map(|(label, spec, start)| {
                trial(label, spec, &learner.rows(spec, TRIAL_ROWS)?, start, SNAP_ROUNDS)
            })
            .collect::<Result<Vec<_>, IdentifyError>>()?;
        // One joint gains, as was seen on its held-out rows: what scatters would hide it.
        let taken = trials[1].error() <= (1.0 - WORTH) * trials[0].error();
        self.choices.push(Choice {
            what: "term beyond the chain".to_owned(),
            chosen: trials[usize::from(taken)].label.clone(),
            rule: format!("{} % better, 5 blocks in time", 100.0 * WORTH),
            from: listed(&trials),
        });
        if taken {
            *self = learner.finish(with, &chain, std::mem::take(&mut self.choices))?;
        }
        Ok(taken)
    }
}
