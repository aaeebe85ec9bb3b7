//! Plan, recording → settings: what logs are summed under, and the columns that are summed.

use crate::candidates::Candidates;
use crate::found::Progress;
use crate::patterns::PatternPlan;
use crate::plan::{FrictionKind, LibraryKind, LibraryOptions, Plan, Regression};
use crate::settle::choose_laws;
use serde::{Deserialize, Serialize};
use torquewise_model::FrictionTerm;
use torquewise_model::model::Choice;
use torquewise_motion::{Pattern, Recording};
use torquewise_regression::accumulate::{Prepared, Route, cheaper_route};
use torquewise_regression::gram::Gram;
use torquewise_regression::row_sums::RowSums;
use torquewise_survey::error::IdentifyError;
use torquewise_survey::survey::survey;

/// What logs are summed under. Summaries made under different settings do not add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Joint names, base to tip.
    pub joints: Vec<String>,
    /// The library that is summed; none where a chain is learned, which needs no sums.
    pub library: Option<SummedLibrary>,
    /// How rows are told apart, log by log.
    pub patterns: PatternPlan,
    /// How the signals were filtered, in the words of whoever did.
    pub signals: String,
    /// Whether they were filtered at all.
    pub filtered: bool,
}

/// Which columns are summed, and over which rows together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SummedLibrary {
    /// Candidates.
    pub kind: LibraryKind,
    /// One-shot or stepwise: one sum over all rows, or one for each pattern.
    pub regression: Regression,
    /// Laws of friction among the candidates. They follow from the speeds of all logs together, so
    /// that summaries with friction are neither written nor merged.
    #[serde(skip)]
    pub friction: Vec<FrictionTerm>,
}

/// The candidates of a summary, made ready to be summed.
pub(crate) struct Basis {
    pub(crate) candidates: Candidates,
    pub(crate) prepared: Prepared,
    pub(crate) route: Route,
    pub(crate) n_joints: usize,
}

/// Rows that the route to the sums is chosen for. One number for all logs, lest parts of different
/// size come by different routes and do not add up.
const USUAL_ROWS: usize = 1 << 18;

impl SummedLibrary {
    /// The library of a fit with laws of friction that suit a recording, and how these were chosen.
    pub(crate) fn of(
        recording: &(impl Recording + ?Sized),
        options: &LibraryOptions,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(Self, Vec<Choice>), IdentifyError> {
        let LibraryOptions { library: kind, regression, friction, .. } = *options;
        let (friction, choices) = if friction == FrictionKind::None {
            (Vec::new(), Vec::new())
        } else {
            progress(Progress::Survey);
            let survey = survey(recording)?;
            survey.sample.require_tau()?;
            choose_laws(&survey, options)?
        };
        Ok((Self { kind, regression, friction }, choices))
    }
}

impl Settings {
    pub(crate) fn new(
        recording: &(impl Recording + ?Sized),
        plan: &Plan,
        library: Option<SummedLibrary>,
        signals: &str,
    ) -> Self {
        let rubs = library.as_ref().is_some_and(|library| !library.friction.is_empty());
        let slow = plan.patterns.slow || rubs;
        Self {
            joints: recording.joints().to_vec(),
            library,
            patterns: PatternPlan { slow, ..plan.patterns },
            signals: signals.to_owned(),
            filtered: recording.is_filtered(),
        }
    }

    /// The candidates, unless a chain is learned.
    pub(crate) fn basis(&self) -> Result<Option<Basis>, IdentifyError> {
        let Some(SummedLibrary { kind, regression, friction }) = &self.library else {
            return Ok(None);
        };
        let n_joints = self.joints.len();
        let laws = friction.clone();
        let candidates = Candidates::with_friction(n_joints, *kind, *regression, laws)?;
        let route = cheaper_route(&candidates.design, n_joints, USUAL_ROWS);
        let prepared = Prepared::new(&candidates.design, route);
        Ok(Some(Basis { candidates, prepared, route, n_joints }))
    }

    /// The candidates that were summed, and options with what was settled then.
    ///
    /// # Errors
    /// [`IdentifyError::NoLibrary`] if nothing was summed.
    pub(crate) fn basis_for(
        &self,
        options: &LibraryOptions,
    ) -> Result<(Basis, LibraryOptions), IdentifyError> {
        let (Some(basis), Some(library)) = (self.basis()?, &self.library) else {
            return Err(IdentifyError::NoLibrary);
        };
        let (library, regression) = (library.kind, library.regression);
        Ok((basis, LibraryOptions { library, regression, ..options.clone() }))
    }

    /// The patterns whose rows are summed apart; `None` stands for all rows.
    pub(crate) fn parts(&self) -> Vec<Option<Pattern>> {
        match self.library.as_ref().map(|library| library.regression) {
            Some(Regression::Stepwise) => Pattern::ALL.map(Some).into(),
            Some(Regression::OneShot) => vec![None],
            None => Vec::new(),
        }
    }

    /// Laws of friction among the candidates.
    pub(crate) fn friction(&self) -> &[FrictionTerm] {
        self.library.as_ref().map_or(&[], |library| &library.friction)
    }

    /// Fails where laws of friction were chosen for these logs alone.
    pub(crate) fn refuse_friction(&self) -> Result<(), IdentifyError> {
        if self.friction().is_empty() {
            return Ok(());
        }
        let message = "it holds friction, whose laws suit its logs alone: fit all logs together";
        Err(IdentifyError::Moments(message.into()))
    }

    /// Fails unless summaries of both add up.
    pub(crate) fn check(&self, other: &Self) -> Result<(), IdentifyError> {
        let quoted = |what: &dyn std::fmt::Debug| format!("{what:?}");
        let regression = |it: &Self| match &it.library {
            Some(library) => quoted(&library.regression),
            None => "Chain".to_owned(),
        };
        let library = |it: &Self| quoted(&it.library.as_ref().map(|library| library.kind));
        let pairs = [
            ("joints", self.joints.join(", "), other.joints.join(", ")),
            ("method", regression(self), regression(other)),
            ("library", library(self), library(other)),
            ("patterns", quoted(&self.patterns), quoted(&other.patterns)),
            ("signals", self.signals.clone(), other.signals.clone()),
            ("filters", quoted(&self.filtered), quoted(&other.filtered)),
        ];
        match pairs.into_iter().find(|(_, expected, found)| expected != found) {
            Some((what, expected, found)) => Err(IdentifyError::Apart { what, expected, found }),
            None => Ok(()),
        }
    }
}

impl Basis {
    /// The normal equations of some candidates over rows.
    pub(crate) fn grams(&self, rows: &RowSums, columns: &[usize]) -> Vec<Gram> {
        rows.grams(&self.prepared, self.n_joints, columns)
    }
}
