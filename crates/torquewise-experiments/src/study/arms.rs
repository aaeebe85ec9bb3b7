//! From arms of two to five joints to candidates, time and error: how the libraries grow.

use crate::agenda::{Agenda, TrialId, Trials};
use crate::error::ExperimentError;
use crate::method::Method;
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use crate::trial::TrialPlan;
use crate::truth::true_energies;
use serde::Serialize;
use std::collections::BTreeSet;
use torquewise_model::library::{angle_functions, energy_library};
use torquewise_model::{EnergyTerm, Form};
use torquewise_sim::Arm;

/// N₁ of the product libraries that are counted.
const TRIG_ORDER: u8 = 4;
/// N₁ of the gravity step.
const GRAVITY_ORDER: u8 = 2;

/// The trial of one arm.
#[derive(Clone, Debug)]
pub(crate) struct ArmPlan {
    scenario: Scenario,
    trial: TrialId,
}

/// How the energy library does for one arm, and how large the others would be.
#[derive(Clone, Debug, Serialize)]
pub struct ArmResults {
    /// Its name.
    pub arm: &'static str,
    /// Number of joints.
    pub joints: usize,
    /// Length of its log \[s\].
    pub log_length: f64,
    /// Candidates of the energy library.
    pub energy_candidates: usize,
    /// Candidates of the stepwise product library, over all steps, N₁ = 4.
    pub product_candidates: usize,
    /// Candidates of one-shot SINDy, N₁ = 4, N₂ ≤ 2.
    pub sindy_candidates: usize,
    /// True energies of the arm.
    pub true_terms: usize,
    /// Energies found.
    pub terms: usize,
    /// Energies found that are true.
    pub right_terms: usize,
    /// Error outside the training log \[%\], per joint.
    pub nrmse_percent: Vec<f64>,
    /// CPU time of the reconstruction on one thread \[s\].
    pub seconds: f64,
}

/// Every arm with the noise of case 3.
pub(crate) fn ask(agenda: &mut Agenda, settings: &Settings) -> Vec<ArmPlan> {
    let plan = |&(arm, seconds): &(&'static str, f64)| {
        let scenario = Scenario { arm, seconds, noise: Decibels::case(3), seed: settings.seed };
        let trial = TrialPlan { scenario: scenario.clone(), plan: Method::Energy.plan() };
        ArmPlan { scenario, trial: agenda.ask(trial) }
    };
    settings.arms.iter().map(plan).collect()
}

impl ArmPlan {
    /// How the arm fares, once its trial is done.
    pub(crate) fn result(&self, trials: &Trials) -> Result<ArmResults, ExperimentError> {
        let arm = Arm::builtin(self.scenario.arm)?;
        let (n, trial) = (arm.n_joints(), trials.get(self.trial)?);
        let truth: BTreeSet<EnergyTerm> = true_energies(&arm).into_keys().collect();
        let right_terms = match &trial.model.form {
            Form::Energy(terms) => terms.iter().filter(|w| truth.contains(&w.term)).count(),
            Form::Torque(_) => 0,
        };
        let (angles, gravity) =
            (angle_functions(n, TRIG_ORDER).len(), angle_functions(n, GRAVITY_ORDER).len());
        Ok(ArmResults {
            arm: self.scenario.arm,
            joints: n,
            log_length: self.scenario.seconds,
            energy_candidates: energy_library(n, None).len(),
            product_candidates: gravity + angles * (monomials(n, 2) + n),
            sindy_candidates: angles
                * (0..=2).map(|degree| monomials(2 * n, degree)).sum::<usize>(),
            true_terms: truth.len(),
            terms: trial.terms,
            right_terms,
            nrmse_percent: trial.nrmse_percent.clone(),
            seconds: trial.cost.total(),
        })
    }
}

/// Number of monomials of one degree in some variables, degree ≤ 2.
fn monomials(variables: usize, degree: usize) -> usize {
    match degree {
        0 => 1,
        1 => variables,
        _ => variables * (variables + 1) / 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use torquewise_model::library::{Degree, product_library};

    #[test]
    fn libraries_are_counted_as_they_are_listed() {
        for n in 2..=3 {
            let angles = angle_functions(n, TRIG_ORDER).len();
            let counted = angles * (0..=2).map(|degree| monomials(2 * n, degree)).sum::<usize>();

            assert_eq!(counted, product_library(n, TRIG_ORDER, &Degree::up_to(2)).len());
        }
    }

    #[test]
    fn the_reference_arm_has_the_sizes_of_the_method() {
        let mut agenda = Agenda::default();
        let settings = Settings { arms: vec![("puma560-3", 60.0)], ..Settings::quick(1) };
        let plans = ask(&mut agenda, &settings);

        let trials = agenda.run(1).unwrap();
        let found = plans[0].result(&trials).unwrap();

        assert_eq!(
            (found.energy_candidates, found.product_candidates, found.sindy_candidates),
            (84, 1186, 3612)
        );
        assert_eq!(found.true_terms, 23);
        assert!(found.right_terms <= found.terms && found.seconds > 0.0);
    }
}
