//! Trials: one reconstruction each, its cost, its terms and its error on another motion.

use crate::method::ACTIVE;
use crate::scenario::{Scenario, outside};
use crate::{Cell, Result, Spread, within};
use cpu_time::ThreadTime;
use faer::Mat;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use torquewise_identify::{Plan, reconstruct, score};
use torquewise_model::{EnergyTerm, Form, Model, Stage, Torque, Weighted};
use torquewise_motion::Motion;
use torquewise_report::Colour;
use torquewise_stepwise::Progress as Work;

/// A row of a table: what stands at its head, and what is tried.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub head: Vec<Cell>,
    /// They differ in their seed; one at least.
    pub scenarios: Vec<Scenario>,
    /// How each becomes a model.
    pub plan: Plan,
}

impl Row {
    /// The same plan with each of some seeds, from that of the scenario on.
    pub(crate) fn new(head: &[Cell], from: &Scenario, plan: impl Into<Plan>, seeds: u64) -> Self {
        let seed = |step| Scenario { seed: from.seed.wrapping_add(step), ..from.clone() };
        let scenarios = (0..seeds).map(seed).collect();
        Self { head: head.to_vec(), scenarios, plan: plan.into() }
    }
}

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrialProgress {
    /// What is being done.
    pub doing: &'static str,
    /// Trials done so far.
    pub done: usize,
    /// All trials.
    pub total: usize,
}

/// Who is told when work begins or is done, from any thread.
pub type TrialWatch<'a> = &'a (dyn Fn(TrialProgress) + Sync);

#[derive(Clone, Debug)]
pub(crate) struct Trials(Vec<(Scenario, Plan, Trial)>);

impl Trials {
    /// Does each trial once: those to be timed one by one, then the others on all cores.
    ///
    /// Each runs in a pool of one thread, so that its time is that of one thread.
    pub(crate) fn run(
        timed: &[Row],
        others: &[Row],
        seed: u64,
        told: TrialWatch<'_>,
    ) -> Result<Self> {
        let (mut plans, mut n_timed) = (Vec::new(), 0);
        for (place, row) in timed.iter().chain(others).enumerate() {
            for scenario in &row.scenarios {
                if !plans.contains(&(scenario, &row.plan)) {
                    plans.push((scenario, &row.plan));
                    n_timed += usize::from(place < timed.len());
                }
            }
        }
        let done = AtomicUsize::new(0);
        let attempt = |place: usize| -> Result<(Scenario, Plan, Trial)> {
            let (scenario, plan) = plans[place];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            let trial = pool.install(|| attempt(scenario, plan, seed))?;
            let doing = if place < n_timed { "timed trials" } else { "trials" };
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            told(TrialProgress { doing, done, total: plans.len() });
            Ok((scenario.clone(), plan.clone(), trial))
        };
        let mut trials = (0..n_timed).map(attempt).collect::<Result<Vec<_>>>()?;
        let begun = AtomicUsize::new(n_timed);
        let next = || Some(begun.fetch_add(1, Ordering::Relaxed)).filter(|at| *at < plans.len());
        let worker = || std::iter::from_fn(next).map(attempt).collect::<Result<Vec<_>>>();
        for part in rayon::broadcast(|_| worker()) {
            trials.extend(part?);
        }
        Ok(Self(trials))
    }

    pub(crate) fn of(&self, row: &Row) -> Runs<'_> {
        let find = |own| self.0.iter().find(|(log, plan, _)| log == own && *plan == row.plan);
        Runs(row.scenarios.iter().filter_map(find).map(|(.., trial)| trial).collect())
    }
}

/// Trials that differ in their seed, one at least.
#[derive(Debug)]
pub(crate) struct Runs<'a>(pub Vec<&'a Trial>);

impl<'a> Runs<'a> {
    pub(crate) fn first(&self) -> &'a Trial {
        self.0[0]
    }

    pub(crate) fn spread(&self, number: impl Fn(&Trial) -> f64) -> Spread {
        Spread::of(self.0.iter().map(|trial| number(trial)))
    }

    /// Of the error of each joint \[%\].
    pub(crate) fn errors(&self) -> Vec<Spread> {
        Spread::of_columns(self.0.iter().map(|trial| trial.nrmse_percent.as_slice()))
    }

    /// Of the error of the joint whose median is the largest \[%\].
    pub(crate) fn worst(&self) -> Spread {
        let worst = self.errors().into_iter().max_by(|a, b| a.median.total_cmp(&b.median));
        worst.unwrap_or(Spread::of([]))
    }

    /// How many there are, their terms, and the error of each joint.
    pub(crate) fn cells(&self) -> Vec<Cell> {
        let size = [self.0.len().into(), self.spread(|trial| trial.terms).into()];
        size.into_iter().chain(self.errors().into_iter().map(Cell::from)).collect()
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Trial {
    pub model: Model,
    pub candidates: usize,
    /// Candidates offered in each step.
    pub candidates_by_step: Vec<usize>,
    /// Coefficients kept.
    pub terms: f64,
    /// Those of them with |coefficient| > 0.1, which the paper calls active.
    pub active: f64,
    /// RMSE / std of the torque of each joint outside the training log \[%\], n.
    pub nrmse_percent: Vec<f64>,
    /// RMSE of the same \[N·m\], n.
    pub rmse: Vec<f64>,
    /// CPU time on one thread \[s\]: of normal equations and the selection of terms, and of these
    /// with clustering and the last fit of the kept terms on all rows.
    pub cost: [f64; 2],
}

impl Trial {
    /// The terms of an energy model, none of another.
    pub(crate) fn energies(&self) -> &[Weighted<EnergyTerm>] {
        if let Form::Energy(terms) = &self.model.form { terms } else { &[] }
    }
}

/// Does a trial and judges it on a motion it has not seen.
fn attempt(scenario: &Scenario, plan: &Plan, test_seed: u64) -> Result<Trial> {
    let log = scenario.record(&scenario.simulate()?)?;
    let Scenario { arm, seconds, noise, seed } = scenario;
    let named = || within(format!("{arm}, {seconds} s, noise {noise}, seed {seed}"));
    let (start, entered) = (now(), Mutex::new(Vec::new()));
    let enter = |work| {
        if work != Work::Working {
            entered.lock().unwrap_or_else(PoisonError::into_inner).push((now(), work));
        }
        ControlFlow::Continue(())
    };
    let found = reconstruct(&log, plan, &enter).map_err(named())?;
    let total = now().saturating_sub(start);
    let is_regression = |work| matches!(work, Work::Sums | Work::Step(_));
    let entered = entered.into_inner().unwrap_or_else(PoisonError::into_inner);
    let parts = entered.windows(2).filter(|pair| is_regression(pair[0].1));
    let regression: Duration = parts.map(|pair| pair[1].0.saturating_sub(pair[0].0)).sum();
    let scores = score(&found.model, &outside(arm, test_seed)?).map_err(named())?;
    let coefficients: Vec<f64> = match &found.model.form {
        Form::Torque(joints) => joints.iter().flatten().map(|w| w.coefficient).collect(),
        Form::Energy(terms) => terms.iter().map(|w| w.coefficient).collect(),
    };
    Ok(Trial {
        candidates: found.candidates,
        candidates_by_step: found.steps.iter().map(|step| step.candidates).collect(),
        terms: coefficients.len() as f64,
        active: coefficients.iter().filter(|c| c.abs() > ACTIVE).count() as f64,
        nrmse_percent: scores.joints.iter().map(|joint| joint.nrmse_percent).collect(),
        rmse: scores.joints.iter().map(|joint| joint.rmse).collect(),
        cost: [regression, total].map(|time| time.as_secs_f64()),
        model: found.model,
    })
}

/// A model after one of its steps, without the last fit.
#[derive(Debug)]
pub(crate) struct Step {
    pub name: String,
    /// What it predicts of a motion \[N·m\], m×n.
    pub torque: Mat<f64>,
    /// NRMSE of the same \[%\], n.
    pub nrmse_percent: Vec<f64>,
}

/// A model after each of its steps, made ready to predict a motion.
pub(crate) fn steps(model: &Model, ready: fn(&Model) -> Model, test: &Motion) -> Result<Vec<Step>> {
    let step = |(place, stage): (usize, &Stage)| {
        let model = ready(&model.after_step(place + 1)?);
        let scores = score(&model, test).map_err(within(format!("step {}", place + 1)))?;
        Ok(Step {
            name: stage.name.clone(),
            torque: Torque::new(&model).over(test)?,
            nrmse_percent: scores.joints.into_iter().map(|joint| joint.nrmse_percent).collect(),
        })
    };
    model.stages.iter().enumerate().map(step).collect()
}

/// Name, colour and torque after each step, m×n.
pub(crate) fn step_lines(steps: Vec<Step>) -> Vec<(String, Colour, Mat<f64>)> {
    let colours = [5, 2, 1].map(Colour::Series);
    let line = |(step, Step { name, torque, .. }): (usize, Step)| {
        (format!("after step {}: {name}", step + 1), colours[step.min(2)], torque)
    };
    steps.into_iter().enumerate().map(line).collect()
}

/// CPU time of this thread; zero where the system does not tell.
fn now() -> Duration {
    ThreadTime::try_now().map_or(Duration::ZERO, |time| time.as_duration())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Method;
    use torquewise_sim::Noise;

    fn row(noise: Noise, seconds: f64, seed: u64) -> Row {
        let scenario = Scenario { arm: "planar-2", seconds, noise, seed };
        Row::new(&[], &scenario, Method::Energy.options(), 1)
    }

    #[test]
    fn a_trial_without_noise_predicts_another_motion() {
        let Row { scenarios, plan, .. } = row(Noise::CASES[0], 60.0, 3);
        let trial = attempt(&scenarios[0], &plan, 3).unwrap();

        assert!(trial.nrmse_percent.iter().all(|&percent| percent < 1e-6), "{trial:?}");
        assert_eq!(trial.candidates_by_step.len(), 3);
        assert!(0.0 < trial.active && trial.active <= trial.terms);
        let [regression, total] = trial.cost;
        assert!(0.0 < regression && regression < total, "{regression} {total}");
    }

    #[test]
    fn each_trial_is_made_once_and_one_that_fails_is_reported() {
        let rows = [1, 2, 3, 2].map(|seed| row(Noise::CASES[2], 30.0, seed));
        let trials = Trials::run(&rows[..1], &rows, 1, &|_| {}).unwrap();

        assert_eq!(trials.0.len(), 3, "each once");
        let failed = Trials::run(&[], &[row(Noise::CASES[2], 0.1, 1)], 1, &|_| {});
        assert!(matches!(failed, Err(crate::PaperError::Identify { .. })), "{failed:?}");
    }
}
