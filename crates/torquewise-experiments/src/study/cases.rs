//! From trials in cases 1–3 to terms kept (Fig. 7) and torque outside the training log (Fig. 8).

use crate::agenda::{Agenda, TrialId, Trials};
use crate::error::ExperimentError;
use crate::method::{ACTIVE, Method};
use crate::scenario::{Decibels, outside};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::truth::{true_energies, true_torques};
use serde::Serialize;
use torquewise_model::{Model, Torque};
use torquewise_motion::Motion;
use torquewise_sim::Arm;

/// The trials of one case: those of each method, one per seed.
#[derive(Clone, Debug)]
pub(crate) struct CasePlan {
    /// 1, 2 or 3.
    pub case: u8,
    trials: Vec<(Method, Vec<TrialId>)>,
}

/// What one case shows.
#[derive(Clone, Debug, Serialize)]
pub struct CaseResults {
    /// 1, 2 or 3.
    pub case: u8,
    pub noise: Decibels,
    pub methods: Vec<MethodResults>,
    /// Torque outside the training log, needed and predicted.
    pub prediction: Prediction,
}

/// How one method does in one case.
#[derive(Clone, Debug, Serialize)]
pub struct MethodResults {
    pub method: Method,
    /// Runs, each with another motion and other noise.
    pub runs: usize,
    /// Coefficients kept.
    pub terms: Spread,
    /// Those of them with |coefficient| > 0.1.
    pub active: Spread,
    /// RMSE / std of the torque outside the training log \[%\], per joint.
    pub nrmse_percent: Vec<Spread>,
    /// RMSE of the same \[N·m\], per joint.
    pub rmse: Vec<Spread>,
}

/// Torque of the test motion; predictions are those of the first seed.
#[derive(Clone, Debug, Serialize)]
pub struct Prediction {
    /// Instants \[s\], m.
    pub t: Vec<f64>,
    /// Torque that is needed \[N·m\], n×m.
    pub needed: Vec<Vec<f64>>,
    /// Torque predicted \[N·m\], per method n×m.
    pub predicted: Vec<Vec<Vec<f64>>>,
}

/// How many terms the truth has.
#[derive(Clone, Debug, Serialize)]
pub struct TrueTerms {
    /// Functions in M(q) and V(q).
    pub energies: usize,
    /// Those with |coefficient| > 0.1.
    pub active_energies: usize,
    /// Products of the torque of each joint, n.
    pub products: Vec<usize>,
    /// Those with |coefficient| > 0.1, n.
    pub active_products: Vec<usize>,
}

/// Rows of a prediction that are kept: every fifth of 20 s at 100 Hz.
const STRIDE: usize = 5;

/// Cases 1, 2 and 3 for every method.
pub(crate) fn ask(agenda: &mut Agenda, settings: &Settings) -> Vec<CasePlan> {
    ask_methods(agenda, settings, &Method::ALL)
}

/// Cases 1, 2 and 3 for some methods. Without noise one run says all.
pub(crate) fn ask_methods(
    agenda: &mut Agenda,
    settings: &Settings,
    methods: &[Method],
) -> Vec<CasePlan> {
    (1..=3)
        .map(|case| {
            let seeds = if case == 1 { 1 } else { settings.seeds };
            let scenario = settings.scenario(Decibels::case(case), settings.seed);
            let trials = methods
                .iter()
                .map(|&method| (method, agenda.ask_seeds(&scenario, &method.plan(), seeds)));
            CasePlan { case, trials: trials.collect() }
        })
        .collect()
}

impl CasePlan {
    /// The trials of a method, one per seed.
    pub(crate) fn trials(&self, wanted: Method) -> &[TrialId] {
        let found = self.trials.iter().find(|(method, _)| *method == wanted);
        found.map_or(&[], |(_, trials)| trials)
    }

    /// What the case shows, once the trials are done.
    pub(crate) fn results(
        &self,
        settings: &Settings,
        trials: &Trials,
    ) -> Result<CaseResults, ExperimentError> {
        let test = outside(settings.arm, settings.seed)?;
        let mut methods = Vec::with_capacity(self.trials.len());
        let mut predicted = Vec::with_capacity(self.trials.len());
        for (method, ids) in &self.trials {
            let done = trials.all(ids)?;
            if let Some(first) = done.first() {
                predicted.push(predict(&first.model, &test)?);
            }
            methods.push(MethodResults {
                method: *method,
                runs: done.len(),
                terms: Spread::of(done.iter().map(|trial| trial.terms as f64)),
                active: Spread::of(done.iter().map(|trial| trial.active as f64)),
                nrmse_percent: Spread::of_columns(done.iter().map(|t| t.nrmse_percent.as_slice())),
                rmse: Spread::of_columns(done.iter().map(|t| t.rmse.as_slice())),
            });
        }
        let prediction = Prediction {
            t: shown_rows(&test).map(|row| test.t()[row]).collect(),
            needed: columns(test.require_tau()?, &test),
            predicted,
        };
        Ok(CaseResults { case: self.case, noise: Decibels::case(self.case), methods, prediction })
    }
}

/// Torque of a model over the shown rows of a motion \[N·m\], n×m.
pub(crate) fn predict(model: &Model, test: &Motion) -> Result<Vec<Vec<f64>>, ExperimentError> {
    Ok(columns(Torque::new(model).over(test)?.as_ref(), test))
}

/// Rows of a motion that are shown.
pub(crate) fn shown_rows(motion: &Motion) -> impl Iterator<Item = usize> {
    (0..motion.n_rows()).step_by(STRIDE)
}

fn columns(torque: faer::MatRef<'_, f64>, motion: &Motion) -> Vec<Vec<f64>> {
    (0..motion.n_joints())
        .map(|joint| shown_rows(motion).map(|row| torque[(row, joint)]).collect())
        .collect()
}

/// Counts the terms of the truth.
pub(crate) fn true_terms(arm: &str) -> Result<TrueTerms, ExperimentError> {
    let arm = Arm::builtin(arm)?;
    let energies = true_energies(&arm);
    let torques = true_torques(&energies, arm.n_joints());
    let large = |weight: &f64| weight.abs() > ACTIVE;
    Ok(TrueTerms {
        energies: energies.len(),
        active_energies: energies.values().filter(|weight| large(weight)).count(),
        products: torques.iter().map(Vec::len).collect(),
        active_products: torques
            .iter()
            .map(|sum| sum.iter().filter(|(weight, _)| large(weight)).count())
            .collect(),
    })
}
