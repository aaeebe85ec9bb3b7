//! Recording → summary: all that a fit needs of its logs, in sums that add up without rounding.

use crate::estimate::add_up;
use crate::evidence::{Evidence, Step};
use crate::found::Progress;
use crate::patterns::{LEAST_SHARE, Patterns, find_patterns, place_of};
use crate::plan::{Method, Plan};
use crate::rounds::Request;
use crate::rows::{Gathering, clear_of_reversals, samples_of};
use crate::settings::{Basis, Settings, SummedLibrary};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use torquewise_model::FrictionTerm;
use torquewise_model::model::Choice;
use torquewise_motion::{Motion, Pattern, ReadError, Recording};
use torquewise_regression::SparseError;
use torquewise_regression::normal_sums::NormalSums;
use torquewise_regression::row_sums::{RowAdder, RowSums};
use torquewise_regression::samples::Samples;
use torquewise_survey::error::IdentifyError;
use torquewise_survey::noise::{NoiseFloor, NoiseSum};
use torquewise_survey::survey::{Survey, SurveySum};

/// All that a fit needs of logs: ranges, noise, an even sample, and sums over their rows.
///
/// Sums are exact, samples depend on the logs alone: whatever the order in which logs are merged
/// and however they are grouped before, the summary is the same, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    pub(crate) settings: Settings,
    pub(crate) logs: usize,
    pub(crate) survey: SurveySum,
    /// Noise in rows at standstill.
    pub(crate) still: NoiseSum,
    /// What the rows of each pattern say, or all rows; nothing where a chain is learned.
    pub(crate) sums: Vec<RowSums>,
    /// What was chosen before rows were summed.
    pub(crate) choices: Vec<Choice>,
    /// What the rows say where a chain asked for it.
    pub(crate) pass: Option<Pass>,
}

/// A pass over the rows of logs that a chain asked for (E11).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pass {
    pub(crate) request: Request,
    pub(crate) sums: NormalSums,
}

impl Pass {
    /// Sums up the rows of a recording as a request asks for.
    pub(crate) fn over(
        recording: &(impl Recording + ?Sized),
        request: Request,
    ) -> Result<Self, IdentifyError> {
        let sums = add_up(recording, request.linearisation())?;
        Ok(Self { request, sums })
    }
}

/// Sums up each log of a recording, in two passes over it and fixed memory: one to look around,
/// one to sum what the rows of each pattern say of the candidates.
///
/// Patterns are found log by log, so that the sums of a log do not depend on the others.
///
/// - `signals`: how the signals were filtered; summaries of other words do not add up
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, a library too large, or numbers too
/// large to be summed.
pub fn summarise(
    recording: &(impl Recording + ?Sized),
    plan: &Plan,
    signals: &str,
    progress: &mut dyn FnMut(Progress),
) -> Result<Summary, IdentifyError> {
    let (library, choices) = match &plan.method {
        Method::Library(options) => {
            let (library, choices) = SummedLibrary::of(recording, options, progress)?;
            (Some(library), choices)
        }
        Method::Chain(_) => (None, Vec::new()),
    };
    let settings = Settings::new(recording, plan, library, signals);
    let basis = settings.basis()?;
    let mut all = Summary { choices, ..Summary::new(settings, basis.as_ref()) };
    for log in 0..recording.n_logs() {
        progress(Progress::Survey);
        let mut look = SurveySum::new(recording.joints());
        recording
            .read_log(log, &mut |trajectory, block| Ok(look.add(trajectory, block)?))
            .map_err(IdentifyError::Read)?;
        if look.rows() == 0 {
            continue;
        }
        let survey = look.finish()?;
        survey.sample.require_tau()?;
        all.survey.merge(&look)?;
        all.logs += 1;
        if let Some(basis) = &basis {
            progress(Progress::Patterns);
            let patterns = find_patterns(&survey, &all.settings.patterns)?;
            progress(Progress::Evidence);
            let mut sorter = Sorter::new(basis, &patterns, &all.settings.parts());
            recording
                .read_log(log, &mut |_, block| sorter.add(block))
                .map_err(IdentifyError::Read)?;
            let (sums, still) = sorter.finish()?;
            all.still.merge(&still);
            all.sums.iter_mut().zip(&sums).try_for_each(|(all, own)| all.merge(own))?;
        }
    }
    all.sort();
    Ok(all)
}

/// Sums up logs for a chain that asked for another pass over their rows, see
/// [`Solution`](crate::reconstruct::Solution).
///
/// # Errors
/// As [`summarise`]; [`IdentifyError::Apart`] if the request is of another arm.
pub fn summarise_again(
    recording: &(impl Recording + ?Sized),
    plan: &Plan,
    signals: &str,
    request: &Request,
    progress: &mut dyn FnMut(Progress),
) -> Result<Summary, IdentifyError> {
    request.check_joints(recording.joints())?;
    let summary = summarise(recording, plan, signals, progress)?;
    progress(Progress::Refit);
    Ok(Summary { pass: Some(Pass::over(recording, request.clone())?), ..summary })
}

impl Summary {
    fn new(settings: Settings, basis: Option<&Basis>) -> Self {
        let n = settings.joints.len();
        let none = |basis: &Basis| RowSums::new(&basis.prepared, n);
        let sums = basis.map_or_else(Vec::new, |basis| vec![none(basis); settings.parts().len()]);
        let (survey, still) = (SurveySum::new(&settings.joints), NoiseSum::new(n));
        Self { settings, logs: 0, survey, still, sums, choices: Vec::new(), pass: None }
    }

    /// What its logs were summed under.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Laws of friction among its candidates, and how they were chosen.
    pub(crate) fn friction(&self) -> (&[FrictionTerm], &[Choice]) {
        (self.settings.friction(), &self.choices)
    }

    /// The request that its rows were summed for, if a chain asked for a pass.
    pub fn request(&self) -> Option<&Request> {
        self.pass.as_ref().map(|pass| &pass.request)
    }

    /// Logs summed.
    pub fn logs(&self) -> usize {
        self.logs
    }

    /// Rows summed.
    pub fn rows(&self) -> usize {
        self.survey.rows()
    }

    /// Adds the logs of another.
    ///
    /// # Errors
    /// [`IdentifyError::Apart`] if the two were made under different settings.
    pub fn merge(&mut self, other: &Self) -> Result<(), IdentifyError> {
        self.settings.check(&other.settings)?;
        self.settings.refuse_friction()?;
        self.survey.merge(&other.survey)?;
        self.still.merge(&other.still);
        self.sums.iter_mut().zip(&other.sums).try_for_each(|(all, own)| all.merge(own))?;
        match (&mut self.pass, &other.pass) {
            (None, None) => {}
            (Some(pass), Some(more)) if pass.request == more.request => {
                pass.sums.merge(&more.sums)?;
            }
            (own, more) => {
                let name = |pass: Option<&Pass>| {
                    pass.map_or_else(|| "none".to_owned(), |pass| pass.request.name())
                };
                let (expected, found) = (name(own.as_ref()), name(more.as_ref()));
                return Err(IdentifyError::Apart { what: "requests", expected, found });
            }
        }
        self.logs += other.logs;
        self.sort();
        Ok(())
    }

    fn sort(&mut self) {
        self.survey.sort();
        self.still.sort();
    }

    /// What its logs told at a glance.
    pub(crate) fn survey(&self) -> Result<Survey, IdentifyError> {
        self.survey.finish()
    }

    /// The noise at standstill, if enough rows stand still.
    pub(crate) fn still(&self) -> Option<NoiseFloor> {
        self.still.finish_still()
    }

    /// The patterns that some log shows in more than a few rows, of those that all logs together
    /// show: a short log may take its slowest motion for none. The rows of the others join those of
    /// variable velocity, which assume nothing. Where all rows are one sum, the patterns stay.
    pub(crate) fn settle(
        &mut self,
        basis: &Basis,
        together: &[Pattern],
    ) -> Result<Vec<Pattern>, IdentifyError> {
        if self.sums.len() < Pattern::ALL.len() {
            return Ok(together.to_vec());
        }
        let least = LEAST_SHARE * self.rows() as f64;
        let last = place_of(Pattern::VariableVelocity);
        let mut present = Vec::new();
        for pattern in Pattern::ALL {
            let place = place_of(pattern);
            let is_shown = place == last || together.contains(&pattern);
            if is_shown && self.sums[place].rows() as f64 > least {
                present.push(pattern);
            } else if place != last {
                let none = RowSums::new(&basis.prepared, basis.n_joints);
                let few = std::mem::replace(&mut self.sums[place], none);
                self.sums[last].merge(&few)?;
            }
        }
        Ok(present)
    }

    /// What the rows of a step say of its columns.
    pub(crate) fn evidence(&self, basis: &Basis, step: &Step) -> Evidence {
        let sums = &self.sums[step.pattern.map_or(0, place_of)];
        let grams = sums.grams(&basis.prepared, basis.n_joints, &step.columns);
        Evidence { grams, route: basis.route, rows: sums.rows() }
    }

    /// All rows as one.
    pub(crate) fn whole(&self, basis: &Basis) -> Result<RowSums, SparseError> {
        let mut whole = RowSums::new(&basis.prepared, basis.n_joints);
        self.sums.iter().try_for_each(|sums| whole.merge(sums))?;
        Ok(whole)
    }
}

/// Hands each row of a log to the sums of its pattern.
struct Sorter<'a> {
    patterns: &'a Patterns,
    friction: &'a [FrictionTerm],
    noise: NoiseSum,
    bins: Vec<Bin<'a>>,
}

struct Bin<'a> {
    /// Whose rows; `None` for all.
    pattern: Option<Pattern>,
    gathering: Gathering,
    adder: RowAdder<'a>,
}

impl<'a> Sorter<'a> {
    fn new(basis: &'a Basis, patterns: &'a Patterns, parts: &[Option<Pattern>]) -> Self {
        let (n, friction) = (basis.n_joints, &basis.candidates.friction[..]);
        let bin = |&pattern: &Option<Pattern>| Bin {
            pattern,
            gathering: Gathering::new(n, friction.len()),
            adder: RowAdder::new(&basis.prepared, n),
        };
        let bins = parts.iter().map(bin).collect();
        Self { patterns, friction, noise: NoiseSum::new(n), bins }
    }

    fn add(&mut self, block: &Motion) -> Result<(), ReadError> {
        let labels = self.patterns.label(block);
        self.noise.add(block, |row| labels[row] == Pattern::Standstill);
        match clear_of_reversals(block, self.friction) {
            Cow::Borrowed(block) => self.add_rows(block, &labels),
            Cow::Owned(block) => self.add_rows(&block, &self.patterns.label(&block)),
        }
    }

    fn add_rows(&mut self, block: &Motion, labels: &[Pattern]) -> Result<(), ReadError> {
        let samples = samples_of(block, self.friction)?;
        for bin in &mut self.bins {
            for (row, &label) in labels.iter().enumerate() {
                if bin.pattern.is_none_or(|pattern| pattern == label) {
                    let full: Option<Samples> = bin.gathering.push(&samples, row);
                    full.map_or(Ok(()), |full| bin.adder.push(full))?;
                }
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<(Vec<RowSums>, NoiseSum), SparseError> {
        let sums = self.bins.into_iter().map(|mut bin| {
            if let Some(rest) = bin.gathering.take() {
                bin.adder.push(rest)?;
            }
            bin.adder.finish()
        });
        Ok((sums.collect::<Result<_, _>>()?, self.noise))
    }
}
