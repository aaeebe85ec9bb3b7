//! Trials: one reconstruction each, its cost, its terms and its error on another motion.

use crate::error::{PaperError, within};
use crate::method::ACTIVE;
use crate::results::Spread;
use crate::scenario::{Scenario, outside};
use cpu_time::ThreadTime;
use faer::Mat;
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use torquewise_identify::{Plan, reconstruct, score};
use torquewise_model::{Form, Model, Stage, Torque};
use torquewise_motion::Motion;
use torquewise_stepwise::Progress as Work;

/// What is to be tried.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TrialPlan {
    pub scenario: Scenario,
    /// How it becomes a model.
    pub plan: Plan,
}

impl TrialPlan {
    /// The same plan with each of some seeds, from that of the scenario on.
    pub(crate) fn seeds(from: &Scenario, plan: impl Into<Plan>, seeds: u64) -> Vec<Self> {
        let plan = plan.into();
        let seed = |step| Scenario { seed: from.seed.wrapping_add(step), ..from.clone() };
        (0..seeds).map(|step| Self { scenario: seed(step), plan: plan.clone() }).collect()
    }
}

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub doing: &'static str,
    /// Trials done so far.
    pub done: usize,
    /// All trials.
    pub total: usize,
}

/// Trials that are done.
#[derive(Clone, Debug)]
pub(crate) struct Trials(Vec<(TrialPlan, Trial)>);

impl Trials {
    /// Does each trial once: those to be timed one by one, then the others on all cores.
    ///
    /// Each runs in a pool of one thread, so that its time is that of one thread.
    pub(crate) fn run(
        timed: &[TrialPlan],
        others: &[TrialPlan],
        seed: u64,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<Self, PaperError> {
        let mut plans: Vec<&TrialPlan> = Vec::new();
        let mut n_timed = 0;
        let mut tests = BTreeMap::new();
        for (place, plan) in timed.iter().chain(others).enumerate() {
            if plans.contains(&plan) {
                continue;
            }
            plans.push(plan);
            n_timed += usize::from(place < timed.len());
            let arm = plan.scenario.arm;
            if !tests.contains_key(arm) {
                tests.insert(arm, outside(arm, seed)?);
            }
        }
        let (done, total) = (AtomicUsize::new(0), plans.len());
        let attempt = |plan: &TrialPlan, doing| -> Result<(TrialPlan, Trial), PaperError> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            let trial = pool.install(|| attempt(plan, &tests[plan.scenario.arm]))?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress(Progress { doing, done, total });
            Ok((plan.clone(), trial))
        };
        let (timed, others) = plans.split_at(n_timed);
        let mut trials: Vec<_> =
            timed.iter().map(|plan| attempt(plan, "timed trials")).collect::<Result<_, _>>()?;
        let queue = Mutex::new(others.iter());
        let next = || queue.lock().ok().and_then(|mut queue| queue.next());
        let worker = || -> Result<Vec<_>, PaperError> {
            std::iter::from_fn(next).map(|plan| attempt(plan, "trials")).collect()
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> =
                (0..rayon::current_num_threads()).map(|_| scope.spawn(worker)).collect();
            for worker in workers {
                let own = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                trials.extend(own?);
            }
            Ok(Self(trials))
        })
    }

    /// The trials of one plan with each of some seeds.
    pub(crate) fn runs(&self, plans: &[TrialPlan]) -> Result<Runs<'_>, PaperError> {
        let find = |plan| self.0.iter().find(|(known, _)| known == plan);
        let done = plans.iter().map(|plan| Ok(&find(plan).ok_or(PaperError::NotDone)?.1));
        Ok(Runs(done.collect::<Result<_, PaperError>>()?))
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

    /// Of the coefficients kept.
    pub(crate) fn terms(&self) -> Spread {
        self.spread(|trial| trial.terms as f64)
    }

    /// Of the coefficients that the paper calls active.
    pub(crate) fn active(&self) -> Spread {
        self.spread(|trial| trial.active as f64)
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
}

/// CPU time of a reconstruction \[s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    /// Normal equations and the selection of terms.
    pub regression: f64,
    /// That, clustering, and the last fit of the kept terms on all rows.
    pub total: f64,
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
fn attempt(trial: &TrialPlan, test: &Motion) -> Result<Trial, PaperError> {
    let log = trial.scenario.record(&trial.scenario.simulate()?)?;
    let named = || within(name_of(trial));
    let (start, mut regression) = (now(), Duration::ZERO);
    let (mut since, mut is_regression) = (start, false);
    let mut enter = |work| {
        if is_regression {
            regression += now().saturating_sub(since);
        }
        since = now();
        is_regression = matches!(work, Work::Geometry | Work::Sums | Work::Step(_));
    };
    let found = reconstruct(&log, &trial.plan, &mut enter).map_err(named())?;
    let total = now().saturating_sub(start).as_secs_f64();
    let scores = score(&found.model, test).map_err(named())?;
    let coefficients = coefficients(&found.model.form);
    Ok(Trial {
        candidates: found.candidates,
        candidates_by_step: found.steps.iter().map(|step| step.candidates).collect(),
        terms: coefficients.len(),
        active: coefficients.iter().filter(|c| c.abs() > ACTIVE).count(),
        nrmse_percent: scores.joints.iter().map(|joint| joint.nrmse_percent).collect(),
        rmse: scores.joints.iter().map(|joint| joint.rmse).collect(),
        cost: Cost { regression: regression.as_secs_f64(), total },
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
pub(crate) fn steps(
    model: &Model,
    ready: impl Fn(&Model) -> Model,
    motion: &Motion,
) -> Result<Vec<Step>, PaperError> {
    let step = |(place, stage): (usize, &Stage)| {
        let model = ready(&model.after_step(place + 1)?);
        let scores = score(&model, motion).map_err(within(format!("step {}", place + 1)))?;
        Ok(Step {
            name: stage.name.clone(),
            torque: Torque::new(&model).over(motion)?,
            nrmse_percent: scores.joints.into_iter().map(|joint| joint.nrmse_percent).collect(),
        })
    };
    model.stages.iter().enumerate().map(step).collect()
}

/// CPU time of this thread; zero where the system does not tell.
fn now() -> Duration {
    ThreadTime::try_now().map_or(Duration::ZERO, |time| time.as_duration())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Method;
    use crate::scenario::{Decibels, outside};

    fn plan(noise: Decibels, seconds: f64, seed: u64) -> TrialPlan {
        let scenario = Scenario { arm: "planar-2", seconds, noise, seed };
        TrialPlan { scenario, plan: Method::Energy.options().into() }
    }

    #[test]
    fn a_trial_without_noise_predicts_another_motion() {
        let test = outside("planar-2", 3).unwrap();

        let trial = attempt(&plan(Decibels::NONE, 60.0, 3), &test).unwrap();

        assert!(trial.nrmse_percent.iter().all(|&percent| percent < 1e-6), "{trial:?}");
        assert_eq!(trial.candidates_by_step.len(), 3);
        assert!(0 < trial.active && trial.active <= trial.terms);
        let Cost { regression, total } = trial.cost;
        assert!(0.0 < regression && regression < total, "{regression} {total}");
        let steps = steps(&trial.model, Model::clone, &test).unwrap();
        assert!(steps[2].nrmse_percent[0] < steps[0].nrmse_percent[0], "{steps:?}");
    }

    #[test]
    fn trials_do_not_depend_on_threads_and_one_that_fails_is_reported() {
        let plans = [1, 2, 3, 2].map(|seed| plan(Decibels::case(3), 30.0, seed));
        let errors = |threads: usize| -> Vec<Vec<f64>> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let run = || Trials::run(&plans[..1], &plans, 1, &|_| {});
            let trials = pool.install(run).unwrap();
            assert_eq!(trials.0.len(), 3, "each once");
            let all = trials.runs(&plans).unwrap().0;
            all.into_iter().map(|trial| trial.nrmse_percent.clone()).collect()
        };

        assert_eq!(errors(1), errors(3));
        let failed = Trials::run(&[], &[plan(Decibels::case(3), 0.1, 1)], 1, &|_| {});
        assert!(matches!(failed, Err(PaperError::Identify { .. })), "{failed:?}");
    }
}
