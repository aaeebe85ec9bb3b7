//! From scenario, plan to trial: one reconstruction, its cost, its terms and its error elsewhere.

use crate::error::{ExperimentError, within};
use crate::method::{ACTIVE, MethodPlan};
use crate::scenario::Scenario;
use cpu_time::ThreadTime;
use std::time::Duration;
use torquewise_identify::{reconstruct, score};
use torquewise_model::{Form, Model};
use torquewise_motion::Motion;
use torquewise_stepwise::Progress;

/// What is to be tried.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TrialPlan {
    pub scenario: Scenario,
    /// How it becomes a model.
    pub plan: MethodPlan,
}

/// CPU time of a reconstruction \[s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    /// Survey and clusters.
    pub patterns: f64,
    /// Normal equations and the selection of terms: the regression.
    pub regression: f64,
    /// The last fit of the kept terms on all rows.
    pub refit: f64,
}

impl Cost {
    /// All of it \[s\].
    pub(crate) fn total(&self) -> f64 {
        self.patterns + self.regression + self.refit
    }
}

/// What came of it.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    /// What was found.
    pub model: Model,
    pub candidates: usize,
    /// Candidates offered in each step.
    pub candidates_by_step: Vec<usize>,
    /// Coefficients kept.
    pub terms: usize,
    /// Those of them with |coefficient| > 0.1, which the paper calls active.
    pub active: usize,
    /// RMSE / std of the torque of each joint outside the training log \[%\], n.
    pub nrmse_percent: Vec<f64>,
    /// RMSE of the same \[N·m\], n.
    pub rmse: Vec<f64>,
    /// CPU time on one thread.
    pub cost: Cost,
}

/// Does a trial and judges it on a motion it has not seen.
///
/// The cost is that of the calling thread: it counts all of the work if that runs in a pool of one
/// thread.
pub(crate) fn attempt(trial: &TrialPlan, test: &Motion) -> Result<Trial, ExperimentError> {
    let log = trial.scenario.record(&trial.scenario.simulate()?)?;
    let named = || within(name_of(trial));
    let mut stopwatch = Stopwatch::start();
    let plan = trial.plan.clone().into();
    let found = reconstruct(&log, &plan, &mut |stage| stopwatch.enter(stage)).map_err(named())?;
    let scores = score(&found.model, test).map_err(named())?;
    let coefficients = coefficients(&found.model.form);
    Ok(Trial {
        candidates: found.candidates,
        candidates_by_step: found.steps.iter().map(|step| step.candidates).collect(),
        terms: coefficients.len(),
        active: coefficients.iter().filter(|c| c.abs() > ACTIVE).count(),
        nrmse_percent: scores.joints.iter().map(|joint| joint.nrmse_percent).collect(),
        rmse: scores.joints.iter().map(|joint| joint.rmse).collect(),
        cost: stopwatch.cost,
        model: found.model,
    })
}

/// All coefficients of a model.
fn coefficients(form: &Form) -> Vec<f64> {
    match form {
        Form::Torque(joints) => joints.iter().flatten().map(|w| w.coefficient).collect(),
        Form::Energy(terms) => terms.iter().map(|w| w.coefficient).collect(),
    }
}

fn name_of(trial: &TrialPlan) -> String {
    let Scenario { arm, seconds, noise, seed } = &trial.scenario;
    format!("{arm}, {seconds} s, noise {}, seed {seed}", noise.name())
}

/// The same model judged after each of its steps, without the last fit: NRMSE \[%\], n each.
pub(crate) fn judge_steps(model: &Model, test: &Motion) -> Result<Vec<Vec<f64>>, ExperimentError> {
    (1..=model.stages.len())
        .map(|step| {
            let stage = model.after_step(step)?;
            let scores = score(&stage, test).map_err(within(format!("step {step}")))?;
            Ok(scores.joints.into_iter().map(|joint| joint.nrmse_percent).collect())
        })
        .collect()
}

/// Time of this thread, sorted by the stage of the work.
struct Stopwatch {
    since: Duration,
    stage: Progress,
    cost: Cost,
}

impl Stopwatch {
    fn start() -> Self {
        Self { since: now(), stage: Progress::Survey, cost: Cost::default() }
    }

    fn enter(&mut self, stage: Progress) {
        let now = now();
        let spent = now.saturating_sub(self.since).as_secs_f64();
        match self.stage {
            Progress::Survey | Progress::Patterns => self.cost.patterns += spent,
            Progress::Geometry | Progress::Sums | Progress::Step(_) => {
                self.cost.regression += spent;
            }
            Progress::Refit | Progress::Done => self.cost.refit += spent,
        }
        (self.since, self.stage) = (now, stage);
    }
}

/// CPU time of this thread; zero where the system does not tell.
pub(crate) fn now() -> Duration {
    ThreadTime::try_now().map_or(Duration::ZERO, |time| time.as_duration())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Method;
    use crate::scenario::{Decibels, outside};

    #[test]
    fn a_trial_without_noise_predicts_another_motion() {
        let noise = Decibels::NONE;
        let scenario = Scenario { arm: "planar-2", seconds: 60.0, noise, seed: 3 };
        let plan = TrialPlan { scenario, plan: Method::Energy.plan() };

        let trial = attempt(&plan, &outside("planar-2", 3).unwrap()).unwrap();

        assert!(trial.nrmse_percent.iter().all(|&percent| percent < 1e-6), "{trial:?}");
        assert_eq!(trial.candidates_by_step.len(), 3);
        assert!(0 < trial.active && trial.active <= trial.terms);

        let steps = judge_steps(&trial.model, &outside("planar-2", 3).unwrap()).unwrap();
        assert!(steps[2][0] < steps[0][0], "{steps:?}");
    }

    #[test]
    fn time_counts_for_the_stage_it_is_spent_in() {
        let mut stopwatch = Stopwatch::start();
        stopwatch.enter(Progress::Sums);
        let before = stopwatch.cost;
        let sum: f64 = (0..2_000_000).map(|k| f64::from(k).sqrt()).sum();
        assert!(sum > 0.0);
        stopwatch.enter(Progress::Refit);

        assert!(stopwatch.cost.regression > before.regression);
        assert!(stopwatch.cost.refit < f64::EPSILON);
    }
}
