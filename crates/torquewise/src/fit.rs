//! The fit: the one call that chooses what is fitted, conditions, fits and judges.

use crate::physics::MassMatrix;
use crate::summary::repairs_note;
use crate::{
    Error, Evaluation, Event, Filter, FitOptions, Library, Log, NOBODY, Observer, Prepared, Result,
    Rows, Source, Watched, evaluate,
};
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Instant;
use torquewise_identify::bandwidth::{Tuned, tune};
use torquewise_identify::reconstruct::reconstruct_from;
use torquewise_identify::verdict::{Grade, Verdict, judge};
use torquewise_identify::{
    ChainOptions, IdentifyError, Method, Plan, Reconstruction, Warning, first_look, reconstruct,
};
use torquewise_stepwise::progress::Watch;
use torquewise_stepwise::{Progress, survey};

/// A fit to be run: what it reads, and what is asked for.
#[must_use]
pub struct Fit<'a> {
    source: Source<'a>,
    options: FitOptions,
    observer: Observer<'a>,
}

impl<'a> Fit<'a> {
    /// A fit to a [`Log`], or to motion at hand, with the usual options.
    pub fn new(log: impl Into<Source<'a>>) -> Self {
        Self { source: log.into(), options: FitOptions::default(), observer: NOBODY }
    }

    /// Sets what is fitted, and how.
    pub fn options(self, options: FitOptions) -> Self {
        Self { options, ..self }
    }

    /// Tells `observer` what is done, and stops where it breaks.
    pub fn observer(self, observer: Observer<'a>) -> Self {
        Self { observer, ..self }
    }

    /// Conditions the log, fits it, and judges the model on blocks of time that were held out. Where the
    /// library is open and its terms give a model that is not good or not physical, as of an arm with
    /// friction, or joints slide, it learns a chain, and takes it if that misses less.
    ///
    /// # Errors
    /// `Error::UnusedOption` if an option does not go with what is fitted, `Error::Interrupted`
    /// if the observer broke, and those of reading and fitting, each with what to do.
    pub fn run(self) -> Result<FitResult> {
        self.options.check()?;
        self.run_as_open()?.judged()
    }

    /// What is fitted where the library is open, without a verdict.
    fn run_as_open(&self) -> Result<FitResult> {
        let mut fit = self.run_as(&self.options)?;
        // No chain explains a torque that never changes.
        if fit.model.chain.is_some() || fit.model.training.torque_std.contains(&0.0) {
            return Ok(fit);
        }
        let sample = &fit.found.survey.sample;
        let look = |progress: Watch<'_>| first_look(sample, self.options.seed, progress);
        // Kinds that are said stand; a log that no chain can be learned from is one of terms.
        let seen = match self.options.kinds.is_none().then(|| timed(self.observer, look)) {
            Some(Err(Error::Interrupted)) => return Err(Error::Interrupted),
            Some(Ok((seen, ..))) => Some(seen),
            _ => None,
        };
        let slides = seen.as_ref().filter(|seen| !seen.kinds.all_turn());
        let may_slide = seen.as_ref().is_some_and(|seen| !seen.may_slide.is_empty());
        let is_physical = fit.mass_matrix()?.positive_definite;
        let grade = fit.verdict().grade;
        let is_good = grade == Grade::Good && is_physical;
        if slides.is_none() && !may_slide && is_good {
            return Ok(fit);
        }
        let is_better = |chain: &FitResult| {
            let is_least = || chain.log_error().zip(fit.log_error()).is_some_and(|(a, b)| a < b);
            let is_sound = grade != Grade::Unusable && is_physical;
            chain.verdict().grade != Grade::Unusable && (!is_sound || !is_good && is_least())
        };
        let chain = FitOptions { library: Some(Library::Chain), ..self.options.clone() };
        if self.options.library.is_none() && chain.check().is_ok() {
            match self.run_as(&chain) {
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Ok(chain) if !chain.model.kinds().all_turn() || is_better(&chain) => {
                    return Ok(chain);
                }
                Ok(chain) => {
                    let of_torque = |own: &Warning| matches!(own, Warning::Gains { .. });
                    let told = chain.found.warnings.into_iter().filter(of_torque);
                    fit.found.warnings.extend(told);
                    return Ok(fit);
                }
                // What seems to slide is said of the terms below.
                Err(_) => {}
            }
        }
        fit.found.warnings.extend(slides.map(|seen| {
            let kinds = seen.kinds.letters(fit.model.n_joints());
            Warning::Sliding { kinds }
        }));
        Ok(fit)
    }

    fn run_as(&self, options: &FitOptions) -> Result<FitResult> {
        match self.source {
            Source::Log(log) => self.run_log(log, options),
            Source::Recording(recording) => {
                let plan = options.plan(recording.joints().len(), recording.is_filtered())?;
                fit_plan(&Watched::new(recording, self.observer, "reading", None), &plan)
            }
        }
    }

    fn run_log(&self, log: &Log, options: &FitOptions) -> Result<FitResult> {
        log.files.require_tau()?;
        let plan = options.plan(log.joints().len(), log.is_filtered())?;
        let is_chosen = log.filter == Filter::Auto || log.delay.is_none() && log.is_filtered();
        let rows = if is_chosen { Rows::WithRawTorque } else { Rows::Filtered };
        let fitted = fit_at_best(log.prepare(rows)?, &plan, self.observer);
        if let Err(Error::Identify(IdentifyError::Chain(_))) = &fitted {
            // What stops a search among degrees says nothing of them.
            survey(log.prepare(rows)?.rows())?.check_size(torquewise_motion::LARGEST[0])?;
        }
        let mut fit = fitted?;
        let Some(log) = &fit.log else { return Ok(fit) };
        fit.found.model.training.filter = log.filter();
        let is_cut_off = |own: &Warning| matches!(own, Warning::Clipped { .. });
        if !fit.found.warnings.iter().any(is_cut_off) {
            fit.found.warnings.extend(log.cut_off());
        }
        if fit.found.warnings.iter().any(is_cut_off) {
            // What a limit takes from a torque looks like a gain.
            fit.found.warnings.retain(|own| !matches!(own, Warning::Gains { .. }));
        }
        let at_odds = log.at_odds(&fit.found.model, self.observer)?;
        fit.found.warnings.extend(at_odds.into_iter().map(Warning::Disagreement));
        fit.found.model.training.conditioning = log.repairs();
        Ok(fit)
    }
}

/// A model, how it was found, and how far to trust it. What was found is reached as its own fields:
/// `fit.model`, `fit.warnings`, see [`Reconstruction`].
#[derive(Debug)]
pub struct FitResult {
    pub(crate) found: Reconstruction,
    /// The log as it was fitted; none where motion at hand was.
    pub log: Option<Prepared>,
    /// Time it took \[s\].
    pub seconds: f64,
    /// Time each step took \[s\].
    pub step_seconds: Vec<f64>,
    weakest: OnceLock<MassMatrix>,
}

impl Deref for FitResult {
    type Target = Reconstruction;

    fn deref(&self) -> &Reconstruction {
        &self.found
    }
}

impl FitResult {
    pub(crate) fn of(
        found: Reconstruction,
        log: Option<Prepared>,
        (seconds, step_seconds): (f64, Vec<f64>),
    ) -> Self {
        Self { found, log, seconds, step_seconds, weakest: OnceLock::new() }
    }

    /// The same with its verdict in the model.
    pub(crate) fn judged(mut self) -> Result<Self> {
        let flaw = self.mass_matrix()?.flaw();
        self.found.warnings.extend(flaw.map(Warning::NotPhysical));
        self.found.model.training.verdict = Some(self.verdict());
        Ok(self)
    }

    /// Where M(q) is weakest, looked for once.
    ///
    /// # Errors
    /// [`Error::Model`] if M(q) cannot be computed.
    pub fn mass_matrix(&self) -> Result<&MassMatrix> {
        if let Some(known) = self.weakest.get() {
            return Ok(known);
        }
        let found = MassMatrix::of(&self.found.model)?;
        Ok(self.weakest.get_or_init(|| found))
    }

    /// Whether the model may be used, and why, by its own log; [`Evaluation::verdict`] is by others too.
    pub fn verdict(&self) -> Verdict {
        judge(&self.found)
    }

    /// Sum over the joints of the logarithm of the error on held-out rows; `None` where none were.
    fn log_error(&self) -> Option<f64> {
        let errors = self.found.model.training.held_out_errors()?;
        Some(errors.iter().map(|error| error.max(f64::MIN_POSITIVE).ln()).sum())
    }

    /// What is good to know and changes nothing: remarks of the fit, and what was repaired.
    pub fn notes(&self) -> Vec<String> {
        let remarks = self.found.warnings.iter().filter(|warning| warning.is_remark());
        let repaired = repairs_note(&self.found.model.training.conditioning);
        repaired.into_iter().chain(remarks.map(ToString::to_string)).collect()
    }

    /// Takes over the verdict of a log of other motion where that is worse, so that whoever uses the
    /// model is told.
    pub fn judged_by(&mut self, test: &Evaluation) {
        if test.verdict.grade > self.verdict().grade {
            self.found.model.training.verdict = Some(test.verdict.clone());
        }
    }

    /// How well the model predicts the torque of another log of the arm.
    ///
    /// # Errors
    /// As [`evaluate()`].
    pub fn evaluate<'b>(&self, test: impl Into<Source<'b>>) -> Result<Evaluation> {
        evaluate(&self.found.model, test)
    }
}

/// Fits a plan to rows as they are.
pub(crate) fn fit_plan(recording: &Watched<'_>, plan: &Plan) -> Result<FitResult> {
    let (found, spent) =
        timed(recording.observer, |progress| reconstruct(recording, plan, progress))?;
    Ok(FitResult::of(found, None, spent))
}

/// The same at the bandwidth that held-out rows ask for, where raw torque is at hand (E12).
fn fit_at_best(log: Prepared, plan: &Plan, observer: Observer<'_>) -> Result<FitResult> {
    let Prepared::Raw(raw) = log else {
        let fit = fit_plan(&log.watched(observer, "reading"), plan)?;
        return Ok(FitResult { log: Some(log), ..fit });
    };
    let by_chain = match &plan.method {
        Method::Chain(_) => plan.clone(),
        Method::Library(_) => Plan { seed: plan.seed, ..ChainOptions::default().into() },
    };
    let ((log, found), spent) = timed(observer, |progress| {
        let Tuned { recording, request, choices } = tune(raw.as_ref(), &by_chain, progress)?;
        let log = Prepared::Conditioned(Box::new(recording));
        let watched = log.watched(observer, "reading");
        let request = Some(request).filter(|_| matches!(plan.method, Method::Chain(_)));
        let mut found = reconstruct_from(&watched, request, plan, progress)?;
        found.model.choices.splice(0..0, choices);
        Ok((log, found))
    })?;
    Ok(FitResult::of(found, Some(log), spent))
}

/// Does some work, and takes the time of it and of each of its steps \[s\].
pub(crate) fn timed<T>(
    observer: Observer<'_>,
    work: impl FnOnce(Watch<'_>) -> Result<T, IdentifyError>,
) -> Result<(T, (f64, Vec<f64>))> {
    // WebAssembly has no clock: there no work takes time.
    let start = cfg!(not(target_family = "wasm")).then(Instant::now);
    let now = || start.map_or(0.0, |start| start.elapsed().as_secs_f64());
    let events: Mutex<Vec<(Progress, f64)>> = Mutex::new(Vec::new());
    let is_stopped = AtomicBool::new(false);
    let done = work(&|stage| {
        if stage != Progress::Working && stage.share().is_none() {
            events.lock().unwrap_or_else(PoisonError::into_inner).push((stage, now()));
        }
        let told = observer(Event::Stage(stage));
        is_stopped.fetch_or(told.is_break(), Ordering::Relaxed);
        told
    });
    if is_stopped.into_inner() {
        // Whatever came of it: a part that was stopped may be taken for one that failed.
        return Err(Error::Interrupted);
    }
    let done = done?;
    let events = events.into_inner().unwrap_or_else(PoisonError::into_inner);
    let is_step = |stage| matches!(stage, Progress::Step(_) | Progress::Geometry);
    let steps = events.windows(2).filter(|pair| is_step(pair[0].0));
    let step_seconds = steps.map(|pair| pair[1].1 - pair[0].1).collect();
    Ok((done, (now(), step_seconds)))
}

#[cfg(test)]
mod tests {
    use crate::dynamics::{Arm, MotionPlan, simulate};
    use crate::{Error, Event, Fit, FitOptions, Grade, Library};
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use torquewise_identify::Warning;

    /// Calls that are under way in other threads, or of parts that were begun.
    const FEW: usize = 40;

    #[test]
    fn what_slides_is_learned_as_a_chain_unless_terms_are_asked_for() {
        for (name, kinds) in [("scara-4", "rrpr"), ("gantry-3", "ppp")] {
            let plan = MotionPlan { seconds: 30.0, rate: 50.0, seed: 1, ..MotionPlan::default() };
            let motion = simulate(&Arm::builtin(name).unwrap(), &plan).unwrap().motion;
            let terms = FitOptions { library: Some(Library::Energy), ..FitOptions::default() };

            let usual = Fit::new(&motion).run().unwrap();
            let of_terms = Fit::new(&motion).options(terms).run().unwrap();

            assert_eq!(usual.model.kinds().letters(kinds.len()), kinds);
            assert_eq!(usual.verdict().grade, Grade::Good, "{name}: {:?}", usual.warnings);
            let said = |warning: &Warning| matches!(warning, Warning::Sliding { kinds: own } if own == kinds);
            assert!(of_terms.warnings.iter().any(said), "{name}: {:?}", of_terms.warnings);
        }
    }

    #[test]
    fn a_fit_ends_soon_after_its_observer_breaks() {
        let plan = MotionPlan { seconds: 40.0, rate: 50.0, seed: 1, ..MotionPlan::default() };
        let motion = simulate(&Arm::builtin("generic-4").unwrap(), &plan).unwrap().motion;
        let calls_until = |last: usize| {
            let calls = AtomicUsize::new(0);
            let observer = |_: Event| {
                let is_last = calls.fetch_add(1, Ordering::Relaxed) >= last;
                if is_last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let fit = Fit::new(&motion).observer(&observer).run();
            (fit.map(drop), calls.into_inner())
        };

        let (whole, all) = calls_until(usize::MAX);
        whole.unwrap();
        for tenths in [1, 3, 5, 7, 9] {
            let last = tenths * all / 10;
            let (stopped, calls) = calls_until(last);
            assert!(matches!(stopped, Err(Error::Interrupted)), "{tenths}: {stopped:?}");
            assert!(calls < last + FEW, "{calls} calls, stopped at {last} of {all}");
        }
    }
}
