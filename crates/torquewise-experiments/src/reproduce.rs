//! From settings to results: every experiment, one after the other on all cores.

use crate::agenda::{Agenda, Progress, Trials};
use crate::claims::judge_claims;
use crate::error::ExperimentError;
use crate::results::Results;
use crate::settings::Settings;
use crate::study::ablation::{self, VariantPlan};
use crate::study::arms::{self, ArmPlan};
use crate::study::cases::{self, CasePlan, true_terms};
use crate::study::coefficients::judge_coefficients;
use crate::study::control::{ControlResults, study_control};
use crate::study::cost::{self, CostPlan};
use crate::study::order_curves::{OrderResults, study_orders};
use crate::study::patterns::{PatternResults, study_patterns};
use crate::study::steps::study_steps;
use crate::study::sweeps::{self, PointPlan};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Work of the experiments that are no trials, in units of a small reconstruction.
const PATTERN_WORK: usize = 6;
const ORDER_WORK: usize = 60;
const EVALUATION_WORK: usize = 30;
const CONTROL_WORK: usize = 40;

/// Does every experiment.
///
/// `progress` is called when work begins or is done, from any thread.
///
/// # Errors
/// [`ExperimentError::Setting`] for settings that ask for nothing, else what kept an experiment
/// from being done.
pub fn reproduce(
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Results, ExperimentError> {
    settings.check()?;
    let mut agenda = Agenda::default();
    let asked = Asked::of(&mut agenda, settings);
    let studies = [PATTERN_WORK, ORDER_WORK, EVALUATION_WORK, CONTROL_WORK];
    let total = agenda.work() + studies.iter().sum::<usize>();
    let done = AtomicUsize::new(0);
    let advance = |doing: &'static str, work: usize| {
        let done = done.fetch_add(work, Ordering::Relaxed) + work;
        progress(Progress { doing, done, total });
    };
    advance("patterns", 0);
    let patterns = study_patterns(settings)?;
    advance("timed trials", PATTERN_WORK);
    let timed = agenda.run_timed(settings.seed, &advance)?;
    let evaluated = cost::evaluate(&asked.costs, settings)?;
    advance("trials", EVALUATION_WORK);
    // From here on nothing is timed for its own sake, so everything runs at once.
    let (orders, control, trials) = std::thread::scope(|scope| {
        let orders = scope.spawn(|| {
            let orders = study_orders(settings);
            advance("trials", ORDER_WORK);
            orders
        });
        let control = scope.spawn(|| {
            let control = study_control(settings);
            advance("trials", CONTROL_WORK);
            control
        });
        let trials = agenda.run_rest(settings.seed, timed, &advance);
        let orders = orders.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        let control = control.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        (orders, control, trials)
    });
    let (orders, control, trials) = (orders?, control?, trials?);
    let studies = Studies { patterns, orders, control };
    asked.results(settings, studies, &evaluated, &trials)
}

/// The experiments that are no trials.
struct Studies {
    patterns: PatternResults,
    orders: Vec<OrderResults>,
    control: ControlResults,
}

/// What each experiment asked the agenda for.
struct Asked {
    costs: Vec<CostPlan>,
    cases: Vec<CasePlan>,
    ablation: Vec<VariantPlan>,
    noise: Vec<PointPlan>,
    lengths: Vec<PointPlan>,
    arms: Vec<ArmPlan>,
}

impl Asked {
    fn of(agenda: &mut Agenda, settings: &Settings) -> Self {
        Self {
            costs: cost::ask(agenda, settings),
            cases: cases::ask(agenda, settings),
            ablation: ablation::ask(agenda, settings),
            noise: sweeps::ask_noise(agenda, settings),
            lengths: sweeps::ask_lengths(agenda, settings),
            arms: arms::ask(agenda, settings),
        }
    }

    fn results(
        &self,
        settings: &Settings,
        studies: Studies,
        evaluated: &[f64],
        trials: &Trials,
    ) -> Result<Results, ExperimentError> {
        let noisy = || self.cases.iter().filter(|case| case.case > 1);
        let second = self.cases.iter().find(|case| case.case == 2);
        let mut results = Results {
            settings: settings.clone(),
            patterns: studies.patterns,
            orders: studies.orders,
            costs: cost::costs(&self.costs, evaluated, trials)?,
            true_terms: true_terms(settings.arm)?,
            cases: all(&self.cases, |case| case.results(settings, trials))?,
            steps: second.map_or(Ok(Vec::new()), |case| study_steps(case, settings, trials))?,
            control: studies.control,
            ablation: all(&self.ablation, |variant| variant.result(settings, trials))?,
            noise_sweep: all(&self.noise, |point| point.result(trials))?,
            length_sweep: all(&self.lengths, |point| point.result(trials))?,
            arms: all(&self.arms, |arm| arm.result(trials))?,
            coefficients: noisy()
                .map(|case| judge_coefficients(case, settings, trials))
                .collect::<Result<_, _>>()?,
            claims: Vec::new(),
        };
        results.claims = judge_claims(&results);
        Ok(results)
    }
}

fn all<P, R>(
    plans: &[P],
    result: impl Fn(&P) -> Result<R, ExperimentError>,
) -> Result<Vec<R>, ExperimentError> {
    plans.iter().map(result).collect()
}
