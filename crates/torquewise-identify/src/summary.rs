//! Summary of logs: all that a fit needs of them, in sums that add up without rounding.

use crate::estimate::add_up;
use crate::framed::{damaged, framed, unframed};
use crate::rounds::Request;
use crate::settings::SumSettings;
use crate::{Method, Plan, Progress, Watch};
use serde::{Deserialize, Serialize};
use torquewise_model::Choice;
use torquewise_motion::Recording;
use torquewise_regression::normal_sums::FOLDS;
use torquewise_regression::{NormalSums, RowSums};
use torquewise_stepwise::library::{Basis, LibrarySums, PatternAccumulator, SummedLibrary};
use torquewise_stepwise::noise::NoiseSum;
use torquewise_stepwise::survey::SurveySum;
use torquewise_stepwise::{IdentifyError, find_patterns};

/// First bytes of the file of a summary.
const MAGIC: [u8; 8] = *b"twmoment";

/// All that a fit needs of logs: ranges, noise, an even sample, and sums over their rows.
///
/// Sums are exact, samples depend on the logs alone: whatever the order in which logs are merged
/// and however they are grouped before, the summary is the same, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// What its logs were summed under.
    pub settings: SumSettings,
    /// Logs summed.
    pub logs: usize,
    pub(crate) survey: SurveySum,
    /// Noise in rows at standstill.
    pub(crate) still: NoiseSum,
    /// Sums of the rows of each pattern, or of all rows; none where a chain is learned.
    pub(crate) sums: Vec<RowSums>,
    /// What was chosen before rows were summed; not in a file, which holds no friction.
    #[serde(skip)]
    pub(crate) choices: Vec<Choice>,
    pub(crate) pass: Option<Pass>,
}

/// A pass over the rows of logs that a chain asked for (E11).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pass {
    pub(crate) request: Request,
    pub(crate) sums: NormalSums,
}

impl Pass {
    pub(crate) fn over(
        recording: &(impl Recording + ?Sized),
        request: Request,
    ) -> Result<Self, IdentifyError> {
        let sums = add_up(recording, &request.passes.at)?;
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
    watch: Watch<'_>,
) -> Result<Summary, IdentifyError> {
    let (library, choices) = match &plan.method {
        Method::Library(options) => {
            let (library, choices) = SummedLibrary::of(recording, options, watch)?;
            (Some(library), choices)
        }
        Method::Chain(_) => (None, Vec::new()),
    };
    let settings = SumSettings::new(recording, plan, library, signals);
    let basis = settings.basis()?;
    let mut all = Summary { choices, ..Summary::new(settings, basis.as_ref()) };
    for log in 0..recording.n_logs() {
        Progress::Survey.tell(watch)?;
        let mut look = SurveySum::new(recording.joints());
        recording.read_log(log, &mut |trajectory, block| Ok(look.add(trajectory, block)?))?;
        if look.rows() == 0 {
            continue;
        }
        let survey = look.finish()?;
        survey.check_size(f64::INFINITY)?;
        survey.sample.require_tau()?;
        all.survey.merge(&look)?;
        all.logs += 1;
        if let Some(basis) = &basis {
            Progress::Patterns.tell(watch)?;
            let patterns = find_patterns(&survey, &all.settings.patterns)?;
            Progress::Sums.tell(watch)?;
            let mut sorter = PatternAccumulator::new(basis, &patterns, &all.settings.parts());
            recording.read_log(log, &mut |_, block| sorter.add(block))?;
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
    watch: Watch<'_>,
) -> Result<Summary, IdentifyError> {
    request.check_joints(recording.joints())?;
    let summary = summarise(recording, plan, signals, watch)?;
    Progress::Refit.tell(watch)?;
    Ok(Summary { pass: Some(Pass::over(recording, request.clone())?), ..summary })
}

impl Summary {
    /// Joint names, base to tip.
    pub fn joints(&self) -> &[String] {
        self.survey.joints()
    }

    fn new(settings: SumSettings, basis: Option<&Basis>) -> Self {
        let n = settings.joints.len();
        let none = |basis: &Basis| vec![RowSums::new(&basis.prepared); settings.parts().len()];
        let sums = basis.map_or_else(Vec::new, none);
        let (survey, still) = (SurveySum::new(&settings.joints), NoiseSum::new(n));
        Self { settings, logs: 0, survey, still, sums, choices: Vec::new(), pass: None }
    }

    /// The request that its rows were summed for, if a chain asked for a pass.
    pub fn request(&self) -> Option<&Request> {
        self.pass.as_ref().map(|pass| &pass.request)
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

    /// What its logs were summed up to for a library.
    pub(crate) fn library_sums(self) -> Result<LibrarySums, IdentifyError> {
        let SumSettings { library, patterns, .. } = self.settings;
        let library = library.ok_or(IdentifyError::NoLibrary)?;
        let still = self.still.finish_still();
        Ok(LibrarySums { library, patterns, sums: self.sums, still, choices: self.choices })
    }

    /// The summary as the bytes of a file.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if it holds friction.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IdentifyError> {
        self.settings.refuse_friction()?;
        framed(MAGIC, self)
    }

    /// The summary that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if the bytes are not a summary, are of another version, or were
    /// damaged or cut short.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentifyError> {
        let summary: Self = unframed(MAGIC, bytes)?;
        let Self { settings, survey, still, sums, pass, .. } = &summary;
        let n = settings.joints.len();
        let fits = settings.joints == survey.joints()
            && survey.is_sound()
            && still.is_sound(n)
            && sums.len() == settings.parts().len();
        let is_sound = |pass: &Pass| {
            let at = &pass.request.passes.at;
            at.is_sound(n) && pass.sums.is_sound(at.n_parameters(), n, FOLDS)
        };
        if !fits || !pass.as_ref().is_none_or(is_sound) {
            return Err(damaged("its parts do not fit each other"));
        }
        let basis = settings.basis()?;
        let prepared = basis.as_ref().map(|basis| &basis.prepared);
        if !sums.iter().all(|sums| prepared.is_some_and(|own| sums.is_sound(own))) {
            return Err(damaged("its sums are not those of its library"));
        }
        Ok(summary)
    }
}
