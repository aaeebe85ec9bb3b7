//! From noise or length of the log to error of every method.

use crate::agenda::{Agenda, TrialId, Trials};
use crate::error::ExperimentError;
use crate::method::Method;
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use crate::spread::Spread;
use serde::Serialize;

/// The trials of one method at one point.
#[derive(Clone, Debug)]
pub(crate) struct PointPlan {
    scenario: Scenario,
    method: Method,
    trials: Vec<TrialId>,
}

/// How one method does at one point.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    pub method: Method,
    pub noise: Decibels,
    /// Length of the log \[s\].
    pub log_length: f64,
    /// Runs, each with another motion and other noise.
    pub runs: usize,
    /// Coefficients kept.
    pub terms: Spread,
    /// Error outside the training log \[%\], per joint.
    pub nrmse_percent: Vec<Spread>,
}

/// Each level of noise.
pub(crate) fn ask_noise(agenda: &mut Agenda, settings: &Settings) -> Vec<PointPlan> {
    let levels = settings.noise_levels.iter();
    levels
        .flat_map(|&noise| ask(agenda, settings, &Method::SWEPT, noise, settings.seconds))
        .collect()
}

/// Each length of the log, with the noise of case 3, for the methods that are not ruined by it.
pub(crate) fn ask_lengths(agenda: &mut Agenda, settings: &Settings) -> Vec<PointPlan> {
    let lengths = settings.lengths.iter();
    let methods = [Method::Energy, Method::Product, Method::SindyCriterion];
    lengths.flat_map(|&length| ask(agenda, settings, &methods, Decibels::case(3), length)).collect()
}

/// Some methods at one point; one-shot SINDy with its threshold, the slowest, with one seed.
fn ask(
    agenda: &mut Agenda,
    settings: &Settings,
    methods: &[Method],
    noise: Decibels,
    seconds: f64,
) -> Vec<PointPlan> {
    let scenario = Scenario { seconds, ..settings.scenario(noise, settings.seed) };
    let mut plan = |&method: &Method| {
        let seeds = if method == Method::Sindy { 1 } else { settings.sweep_seeds };
        let trials = agenda.ask_seeds(&scenario, &method.plan(), seeds);
        PointPlan { scenario: scenario.clone(), method, trials }
    };
    methods.iter().map(&mut plan).collect()
}

impl PointPlan {
    /// How the method does, once its trials are done.
    pub(crate) fn result(&self, trials: &Trials) -> Result<Point, ExperimentError> {
        let done = trials.all(&self.trials)?;
        Ok(Point {
            method: self.method,
            noise: self.scenario.noise,
            log_length: self.scenario.seconds,
            runs: done.len(),
            terms: Spread::of(done.iter().map(|trial| trial.terms as f64)),
            nrmse_percent: Spread::of_columns(done.iter().map(|t| t.nrmse_percent.as_slice())),
        })
    }
}
