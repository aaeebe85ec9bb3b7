//! From chain, rows to friction of each joint: none, viscous, Coulomb, Stribeck, Dahl or both, each
//! with or without load (17) (E13).

use super::ChainLearner;
use super::residual::{FrictionResidual, WORTH, refuse};
use crate::chain_spec::ChainSpec;
use crate::drive_terms::{DriveTerm, columns};
use rayon::prelude::*;
use torquewise_model::FrictionTerm;
use torquewise_model::friction::FrictionLaw;
use torquewise_model::model::Choice;
use torquewise_rigid::Chain;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::{CvScore, choose_worth};

const COULOMB: &str = "Coulomb";
const STRIBECK: &str = "Stribeck";
const APART: &str = "Stribeck, forward and backward apart";

/// Friction that a joint is offered.
struct Offer {
    joint: usize,
    /// What its friction is called so far.
    has: &'static str,
    ways: Vec<Vec<DriveTerm>>,
    trials: Vec<CvScore>,
    /// What was chosen of these.
    place: usize,
    choice: Choice,
    /// Error of what was chosen beside that of what it has.
    gain: f64,
}

/// Laws of one joint with a name.
type Way = (String, Vec<FrictionTerm>);

impl ChainLearner<'_> {
    /// Chooses the friction of each joint by what the rest of a chain leaves of its torque.
    pub(super) fn joint_friction(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let left = FrictionResidual::of(self, spec, chain)?;
        let gravity = spec.gravity.as_ref();
        let judged = |joint: usize| -> Option<Offer> {
            let now = laws_of(spec, joint);
            let has = label(&now);
            let judge = |(label, laws): Way| {
                let laws: Vec<DriveTerm> = DriveTerm::friction(laws).collect();
                let columns = &columns(&laws, &left.motion, gravity)[joint];
                Some((laws, left.trial(joint, label, columns)?))
            };
            let (ways, trials): (Vec<_>, Vec<_>) =
                self.ways(joint, &now).into_iter().filter_map(judge).unzip();
            let what = format!("friction of {}", self.motion.joints()[joint]);
            let (place, choice) = choose_worth(&what, &trials, WORTH)?;
            let now = trials.iter().find(|trial| trial.label == has)?;
            let gain = trials[place].error() / now.error();
            Some(Offer { joint, has, ways, trials, place, choice, gain })
        };
        let joints = (0..self.motion.n_joints()).into_par_iter();
        let mut offers: Vec<Offer> = joints.filter_map(judged).collect();
        // Who has most to gain comes first.
        offers.sort_by(|a, b| a.gain.total_cmp(&b.gain));
        let mut now = self.error(spec, &left)?;
        for Offer { joint, has, ways, trials, place, mut choice, .. } in offers {
            // What is simple may be too little for the whole: then the best is offered.
            let best =
                (0..trials.len()).min_by(|&a, &b| trials[a].error().total_cmp(&trials[b].error()));
            let tried: Vec<usize> =
                std::iter::once(place).chain(best.filter(|best| *best != place)).collect();
            for (k, &place) in tried.iter().enumerate() {
                let mut with = spec.clone();
                with.drive.retain(|drive| !drive.is_friction_of(joint));
                with.drive.extend(ways[place].iter().cloned());
                if self.agree((spec, &mut now), with, &left)? {
                    break;
                }
                refuse(&mut choice, tried.get(k + 1).map_or(has, |&next| &trials[next].label));
            }
            choices.push(choice);
        }
        Ok(())
    }

    /// Friction that a joint may have, the simplest first.
    ///
    /// - `now`: what it has
    fn ways(&self, joint: usize, now: &[FrictionTerm]) -> Vec<Way> {
        let own = |term: &FrictionTerm| term.joint() == Some(joint);
        let is_dry = |term: &FrictionTerm| matches!(term.law, FrictionLaw::Coulomb { .. });
        let linear: Vec<FrictionTerm> = self.laws.linear().into_iter().filter(own).collect();
        let (dry, smooth): (Vec<_>, Vec<_>) = linear.iter().cloned().partition(is_dry);
        let bends = self.laws.stribeck().into_iter().filter(own);
        let bends: Vec<FrictionTerm> = bends.filter(|term| term.direction.is_both()).collect();
        let dahl = self.laws.dahl(joint);
        let of = |parts: &[&[FrictionTerm]]| parts.concat();
        let mut ways =
            vec![("none".into(), smooth[..1].to_vec()), ("viscous".into(), smooth.clone())];
        // What remembers the path does so under load as well, where nothing else is dry.
        let mut rough = vec![
            (COULOMB, linear.clone(), &dry),
            ("Dahl", of(&[&smooth, &dahl]), &dahl),
            ("Coulomb and Dahl", of(&[&linear, &dahl]), &dry),
            (STRIBECK, of(&[&linear, &bends]), &dry),
            ("Stribeck and Dahl", of(&[&linear, &bends, &dahl]), &dry),
        ];
        if label(now) == APART {
            rough.push((APART, now.to_vec(), &dry));
            rough.push(("Stribeck, forward and backward apart, and Dahl", of(&[now, &dahl]), &dry));
        }
        for (label, laws, pressed) in rough {
            let loads = pressed.iter().cloned().map(FrictionTerm::under_load);
            let loaded = laws.iter().cloned().chain(loads).collect();
            ways.extend([(format!("{label} under load"), loaded), (label.to_owned(), laws)]);
        }
        ways.sort_by_key(|(_, laws)| laws.len());
        ways
    }
}

/// The friction of a joint in a specification.
fn laws_of(spec: &ChainSpec, joint: usize) -> Vec<FrictionTerm> {
    let own = spec.drive.iter().filter(|drive| drive.is_friction_of(joint));
    own.filter_map(DriveTerm::law).cloned().collect()
}

/// What friction of the velocity alone is called.
fn label(laws: &[FrictionTerm]) -> &'static str {
    if laws.iter().any(|term| !term.direction.is_both()) {
        APART
    } else if laws.iter().any(|term| matches!(term.law, FrictionLaw::Stribeck { .. })) {
        STRIBECK
    } else {
        COULOMB
    }
}
