//! Arms of two to five joints: how the libraries grow, and what the energy library finds.

use crate::error::PaperError;
use crate::method::Method;
use crate::results::{Cell, Study, Table, Timed};
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use crate::trial::{Cost, Trial, TrialPlan, Trials};
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
        plan: Method::Energy.plan(),
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
        let trial = trials.get(plan)?;
        let arm = Arm::builtin(plan.scenario.arm)?;
        let [energy, product, sindy] = candidates(arm.n_joints());
        let truth: BTreeSet<EnergyTerm> = true_energies(&arm).into_keys().collect();
        let right = right_terms(trial, &truth);
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
            trial.worst_percent().into(),
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
    let whole = (0..=2).map(|degree| monomials(2 * n, degree)).sum::<usize>();
    let product = gravity + angles * (monomials(n, 2) + n);
    [energy_library(n, None).len(), product, angles * whole]
}

/// Number of monomials of one degree in some variables, degree ≤ 2.
fn monomials(variables: usize, degree: usize) -> usize {
    match degree {
        0 => 1,
        1 => variables,
        _ => variables * (variables + 1) / 2,
    }
}

fn right_terms(trial: &Trial, truth: &BTreeSet<EnergyTerm>) -> usize {
    match &trial.model.form {
        Form::Energy(terms) => terms.iter().filter(|w| truth.contains(&w.term)).count(),
        Form::Torque(_) => 0,
    }
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
