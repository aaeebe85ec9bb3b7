//! From trials that experiments ask for to their results: each done once, on all cores, in any
//! order.

use crate::error::ExperimentError;
use crate::method::MethodPlan;
use crate::scenario::{Scenario, outside};
use crate::trial::{Trial, TrialPlan, attempt};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use torquewise_motion::Motion;

/// Where a trial stands in an agenda.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TrialId(usize);

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub doing: &'static str,
    /// Work done so far, in units of a small reconstruction.
    pub done: usize,
    /// All the work.
    pub total: usize,
}

/// Trials to be done; one that several experiments ask for is done once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Agenda {
    plans: Vec<TrialPlan>,
    /// Whether time is to be measured with nothing else at work.
    timed: Vec<bool>,
}

/// Told what was done, and how much work it was.
pub(crate) type Advance<'a> = &'a (dyn Fn(&'static str, usize) + Sync);

/// Trials done so far.
#[derive(Clone, Debug)]
pub(crate) struct Done(Vec<Option<Trial>>);

/// The results of an agenda.
#[derive(Clone, Debug)]
pub(crate) struct Trials(Vec<Trial>);

impl Agenda {
    /// Asks for a trial.
    pub(crate) fn ask(&mut self, plan: TrialPlan) -> TrialId {
        if let Some(place) = self.plans.iter().position(|known| *known == plan) {
            return TrialId(place);
        }
        self.plans.push(plan);
        self.timed.push(false);
        TrialId(self.plans.len() - 1)
    }

    /// Asks for a trial with each of some seeds, from that of the scenario on.
    pub(crate) fn ask_seeds(
        &mut self,
        from: &Scenario,
        plan: &MethodPlan,
        seeds: u64,
    ) -> Vec<TrialId> {
        let trial = |step| {
            let scenario = Scenario { seed: from.seed.wrapping_add(step), ..from.clone() };
            self.ask(TrialPlan { scenario, plan: plan.clone() })
        };
        (0..seeds).map(trial).collect()
    }

    /// Has the cost of trials measured with nothing else at work.
    pub(crate) fn time(&mut self, trials: &[TrialId]) {
        for id in trials {
            self.timed[id.0] = true;
        }
    }

    /// The work of all trials, in units of a small reconstruction.
    pub(crate) fn work(&self) -> usize {
        self.plans.iter().map(work_of).sum()
    }

    /// Does the trials to be timed, one by one in a pool of one thread.
    pub(crate) fn run_timed(
        &self,
        seed: u64,
        advance: Advance<'_>,
    ) -> Result<Done, ExperimentError> {
        let tests = self.tests(seed)?;
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let mut done: Vec<Option<Trial>> = vec![None; self.plans.len()];
        for place in self.places(true) {
            let plan = &self.plans[place];
            done[place] = Some(one_thread.install(|| attempt(plan, test_of(&tests, plan)?))?);
            advance("timed trials", work_of(plan));
        }
        Ok(Done(done))
    }

    /// Does all other trials, on all cores.
    ///
    /// Each runs in a pool of one thread, so that results depend neither on the number of cores nor
    /// on the order, and the time of a trial is that of one thread.
    pub(crate) fn run_rest(
        &self,
        seed: u64,
        Done(mut done): Done,
        advance: Advance<'_>,
    ) -> Result<Trials, ExperimentError> {
        let tests = self.tests(seed)?;
        let mut rest = self.places(false);
        // The longest first, so that no core waits for one at the end.
        rest.sort_by_key(|&place| std::cmp::Reverse(work_of(&self.plans[place])));
        for (place, trial) in self.run_parallel(&rest, &tests, advance)? {
            done[place] = Some(trial);
        }
        let all = done.into_iter().enumerate();
        let all = all.map(|(trial, done)| done.ok_or(ExperimentError::NotDone { trial }));
        Ok(Trials(all.collect::<Result<_, _>>()?))
    }

    fn places(&self, timed: bool) -> Vec<usize> {
        (0..self.plans.len()).filter(|&place| self.timed[place] == timed).collect()
    }

    /// The motion that judges each arm.
    fn tests(&self, seed: u64) -> Result<BTreeMap<&'static str, Motion>, ExperimentError> {
        let mut tests = BTreeMap::new();
        for arm in self.plans.iter().map(|plan| plan.scenario.arm) {
            if !tests.contains_key(arm) {
                tests.insert(arm, outside(arm, seed)?);
            }
        }
        Ok(tests)
    }

    fn run_parallel(
        &self,
        places: &[usize],
        tests: &BTreeMap<&'static str, Motion>,
        advance: Advance<'_>,
    ) -> Result<Vec<(usize, Trial)>, ExperimentError> {
        let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        let results = Mutex::new(Vec::with_capacity(places.len()));
        let worker = || -> Result<(), ExperimentError> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            while let Some(&place) = places.get(next.fetch_add(1, Ordering::Relaxed)) {
                if failed.load(Ordering::Relaxed) {
                    break;
                }
                let plan = &self.plans[place];
                let trial = test_of(tests, plan)
                    .and_then(|test| pool.install(|| attempt(plan, test)))
                    .inspect_err(|_| failed.store(true, Ordering::Relaxed))?;
                results.lock().unwrap_or_else(PoisonError::into_inner).push((place, trial));
                advance("trials", work_of(plan));
            }
            Ok(())
        };
        let workers = rayon::current_num_threads().min(places.len());
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
            all.into_iter().try_for_each(|worker| match worker.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
        })?;
        Ok(results.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

fn test_of<'a>(
    tests: &'a BTreeMap<&'static str, Motion>,
    plan: &TrialPlan,
) -> Result<&'a Motion, ExperimentError> {
    tests.get(plan.scenario.arm).ok_or(ExperimentError::NotDone { trial: 0 })
}

/// About how long a trial takes, in units of a small reconstruction: the candidates tell.
fn work_of(plan: &TrialPlan) -> usize {
    use torquewise_identify::LibraryKind;
    use torquewise_identify::plan::Regression;
    use torquewise_regression::select::Selector;
    let joints = torquewise_sim::arms()
        .into_iter()
        .find(|arm| arm.name == plan.scenario.arm)
        .map_or(3, |arm| arm.joints);
    let options = &plan.plan.options;
    match (options.library, options.regression, &options.selector) {
        (LibraryKind::Energy { .. }, _, _) => [1, 1, 1, 1, 4, 40][joints.min(5)],
        (_, Regression::Stepwise, _) => 3,
        (_, Regression::OneShot, Selector::Lasso(_)) => 5,
        (_, Regression::OneShot, _) => 16,
    }
}

impl Trials {
    pub(crate) fn get(&self, id: TrialId) -> Result<&Trial, ExperimentError> {
        self.0.get(id.0).ok_or(ExperimentError::NotDone { trial: id.0 })
    }

    /// The results of some trials.
    pub(crate) fn all(&self, ids: &[TrialId]) -> Result<Vec<&Trial>, ExperimentError> {
        ids.iter().map(|&id| self.get(id)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Method;
    use crate::scenario::{Decibels, Scenario};

    impl Agenda {
        /// Does all trials.
        pub(crate) fn run(&self, seed: u64) -> Result<Trials, ExperimentError> {
            self.run_rest(seed, self.run_timed(seed, &|_, _| {})?, &|_, _| {})
        }
    }

    fn plan(seed: u64) -> TrialPlan {
        let noise = Decibels::case(3);
        let scenario = Scenario { arm: "planar-2", seconds: 30.0, noise, seed };
        TrialPlan { scenario, plan: Method::Energy.plan() }
    }

    #[test]
    fn a_trial_asked_for_twice_is_done_once() {
        let mut agenda = Agenda::default();

        let ids = [plan(1), plan(1), plan(2)].map(|plan| agenda.ask(plan));
        agenda.time(&ids[1..2]);

        assert_eq!(ids[0], ids[1]);
        assert_eq!((agenda.plans.len(), agenda.places(true)), (2, vec![0]));
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let mut agenda = Agenda::default();
        let ids: Vec<TrialId> = (1..=4).map(|seed| agenda.ask(plan(seed))).collect();
        let errors = |threads: usize| -> Vec<Vec<f64>> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let trials = pool.install(|| agenda.run(1)).unwrap();
            ids.iter().map(|&id| trials.get(id).unwrap().nrmse_percent.clone()).collect()
        };

        assert_eq!(errors(1), errors(3));
    }

    #[test]
    fn a_failed_trial_is_reported() {
        let mut agenda = Agenda::default();
        let mut short = plan(1);
        short.scenario.seconds = 0.1;
        agenda.ask(short);

        let failed = agenda.run(1);

        assert!(matches!(failed, Err(ExperimentError::Identify { .. })), "{failed:?}");
    }
}
