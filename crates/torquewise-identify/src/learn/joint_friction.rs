//! Chain, rows → friction of each joint: none, viscous, Coulomb, Stribeck, Dahl or both, each with
//! or without load (17) (E13).

use super::School;
use super::left_over::{LeftOver, WORTH};
use crate::beside::{Beside, columns};
use crate::trial::{Recipe, record_worth};
use rayon::prelude::*;
use torquewise_model::FrictionTerm;
use torquewise_model::friction::FrictionLaw;
use torquewise_model::model::Choice;
use torquewise_rigid::Chain;
use torquewise_survey::error::IdentifyError;
use torquewise_survey::held_out::Trial;

/// Terms of linear friction: offset, viscous, Coulomb.
const LINEAR: usize = 3;

/// Laws of one joint with a name.
type Way = (String, Vec<FrictionTerm>);

impl School<'_> {
    /// Chooses the friction of each joint by what the rest of a chain leaves of its torque.
    pub(super) fn joint_friction(
        &self,
        recipe: &mut Recipe,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let left = LeftOver::of(self, recipe, chain)?;
        let gravity = recipe.gravity.as_ref();
        let judged = |joint: usize| -> Vec<(Vec<Beside>, Trial)> {
            let own = recipe.beside.iter().filter(|beside| beside.is_friction_of(joint));
            let own = own.filter_map(Beside::law).cloned().collect();
            let judge = |(label, laws): Way| {
                let laws: Vec<Beside> = Beside::friction(laws).collect();
                let columns = &columns(&laws, &left.motion, gravity)[joint];
                Some((laws, left.trial(joint, label, columns)?))
            };
            self.ways(joint, own).into_iter().filter_map(judge).collect()
        };
        let n = self.motion.n_joints();
        let joints: Vec<_> = (0..n).into_par_iter().map(judged).collect();
        let mut now = self.error(recipe, &left)?;
        for (joint, mut ways) in joints.into_iter().enumerate() {
            let trials: Vec<Trial> = ways.iter().map(|(_, trial)| trial.clone()).collect();
            let what = format!("friction of {}", self.motion.joints()[joint]);
            let place = record_worth(&what, &trials, WORTH, choices);
            let mut with = recipe.clone();
            with.beside.retain(|beside| !beside.is_friction_of(joint));
            with.beside.extend(ways.swap_remove(place).0);
            let rough =
                rough(recipe.beside.iter().filter(|beside| beside.is_friction_of(joint)).count());
            self.agree((recipe, &mut now), with, &left, (choices.last_mut(), rough))?;
        }
        Ok(())
    }

    /// Friction that a joint may have, the simplest first.
    ///
    /// - `now`: its richest law of the velocity alone
    fn ways(&self, joint: usize, now: Vec<FrictionTerm>) -> Vec<Way> {
        let own = |term: &FrictionTerm| term.joint() == Some(joint);
        let is_dry = |term: &FrictionTerm| matches!(term.law, FrictionLaw::Coulomb { .. });
        let linear: Vec<FrictionTerm> = self.laws.linear().into_iter().filter(own).collect();
        let (dry, smooth): (Vec<_>, Vec<_>) = linear.iter().cloned().partition(is_dry);
        let dahl = self.laws.dahl(joint);
        let elements = [smooth.clone(), dahl.clone()].concat();
        let rough = rough(now.len());
        let both = [now.clone(), dahl.clone()].concat();
        let mut ways = vec![("none".into(), smooth[..1].to_vec()), ("viscous".into(), smooth)];
        // What remembers the path does so under load as well, where nothing else is dry.
        let dry_ways = [
            ("Coulomb".into(), linear, &dry),
            ("Dahl".into(), elements, &dahl),
            (rough.into(), now, &dry),
            (format!("{rough} and Dahl"), both, &dry),
        ];
        for (label, laws, pressed) in dry_ways {
            let loads = pressed.iter().cloned().map(FrictionTerm::under_load);
            let loaded = laws.iter().cloned().chain(loads).collect();
            ways.extend([(format!("{label} under load"), loaded), (label, laws)]);
        }
        ways.sort_by_key(|(_, laws)| laws.len());
        ways.dedup_by(|a, b| a.0 == b.0);
        ways
    }
}

/// The law of so many terms that depend on the velocity alone.
fn rough(terms: usize) -> &'static str {
    if terms > LINEAR { "Stribeck" } else { "Coulomb" }
}
