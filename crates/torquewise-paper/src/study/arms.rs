//! Arms of two to five joints: how the libraries grow, and what the energy library finds.

use crate::error::PaperError;
use crate::method::Method;
use crate::results::{Cell, Study, Table, Timed};
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use crate::trial::{Cost, TrialPlan, Trials};
use crate::truth::true_energies;
use std::collections::BTreeSet;
use torquewise_model::library::{angle_functions, energy_library};
use torquewise_model::{EnergyTerm, Form};
use torquewise_report::html::number::significant;
use torquewise_sim::Arm;

/// N₁ of the product libraries that are counted, and of their gravity step.
const TRIG_ORDER: u8 = 4;
const GRAVITY_ORDER: u8 = 2;

/// Every arm with the noise of case 3, the largest first.
pub(crate) fn plans(settings: &Settings) -> Vec<TrialPlan> {
    let plan = |&(arm, seconds): &(&'static str, f64)| TrialPlan {
        scenario: Scenario { arm, seconds, noise: Decibels::case(3), seed: settings.seed },
        plan: Method::Energy.options().into(),
    };
    settings.arms.iter().rev().map(plan).collect()
}

/// How the energy library does for each arm, and how large the others would be.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let mut table = Table::new(
        "Candidates of each library at N₁ = 4 and N₂ ≤ 2, and what the energy library finds in one \
         log with the noise of case 3.",
        "arm;log [s];energy library;product library;one-shot SINDy;true terms found;other terms;\
         error [%], joint 1 / 2 / …;error of the worst joint [%]",
    );
    let mut times = Table::new("CPU time of the energy library.", "arm;[s]");
    for plan in plans(settings).iter().rev() {
        let runs = trials.runs(std::slice::from_ref(plan))?;
        let trial = runs.first();
        let arm = Arm::builtin(plan.scenario.arm)?;
        let [energy, product, sindy] = candidates(arm.n_joints());
        let truth: BTreeSet<EnergyTerm> = true_energies(&arm).into_keys().collect();
        let right = match &trial.model.form {
            Form::Energy(terms) => terms.iter().filter(|w| truth.contains(&w.term)).count(),
            Form::Torque(_) => 0,
        };
        let errors: Vec<String> = trial.nrmse_percent.iter().map(|x| significant(*x, 2)).collect();
        table.push([
            plan.scenario.arm.into(),
            plan.scenario.seconds.into(),
            energy.into(),
            product.into(),
            sindy.into(),
            format!("{right} of {}", truth.len()).into(),
            (trial.terms - right).into(),
            errors.join(" / ").into(),
            runs.worst().median.into(),
        ]);
        times.push([Cell::from(plan.scenario.arm), Cost::total(&trial.cost).into()]);
    }
    Ok(Study {
        heading: "More joints",
        tables: vec![table],
        timed: Timed { tables: vec![times], ..Timed::default() },
        ..Study::default()
    })
}

/// Candidates of the energy library, of the steps over products, and of one-shot SINDy.
fn candidates(n: usize) -> [usize; 3] {
    let [angles, gravity] =
        [TRIG_ORDER, GRAVITY_ORDER].map(|order| angle_functions(n, order).len());
    // Monomials of degree 2 in some variables.
    let squares = |variables: usize| variables * (variables + 1) / 2;
    let product = gravity + angles * (squares(n) + n);
    [energy_library(n, None).len(), product, angles * (1 + 2 * n + squares(2 * n))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use torquewise_model::library::{Degree, product_library};

    #[test]
    fn libraries_are_counted_as_they_are_listed() {
        for n in 2..=3 {
            let listed = product_library(n, TRIG_ORDER, &Degree::up_to(2)).len();

            assert_eq!(candidates(n)[2], listed);
        }
        assert_eq!(candidates(3), [84, 1186, 3612], "as docs/results.md has them");
    }
}
