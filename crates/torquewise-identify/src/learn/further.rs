//! Learned chain, term → the chain with that term beside it, where held-out rows agree (E10).

use super::{Learned, ROUNDS, School};
use crate::beside::Beside;
use crate::error::IdentifyError;
use torquewise_model::EnergyTerm;
use torquewise_motion::Motion;

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
        let school = School { motion, laws: self.laws.clone() };
        let mut with = self.recipe.clone();
        with.beside.push(Beside::Energy(term.clone()));
        let ways = [("none".to_owned(), self.recipe.clone()), (term.name(), with)];
        let (what, choices) = ("term beyond the chain", &mut self.choices);
        let place = school.choose(what, &ways, &self.chain, ROUNDS, choices)?;
        let taken = place > 0;
        if taken {
            let choices = std::mem::take(choices);
            *self = school.finish(ways[place].1.clone(), &self.chain, choices)?;
        }
        Ok(taken)
    }
}
