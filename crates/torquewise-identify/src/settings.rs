//! Under which settings logs are summed, and which columns are.

use crate::Plan;
use serde::{Deserialize, Serialize};
use torquewise_model::FrictionTerm;
use torquewise_model::model::TrainingFilter;
use torquewise_motion::{Pattern, Recording};
use torquewise_stepwise::library::{Basis, SummedLibrary};
use torquewise_stepwise::{IdentifyError, PatternPlan};

/// What logs are summed under. Summaries made under different settings do not add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SumSettings {
    /// Joint names, base to tip.
    pub joints: Vec<String>,
    /// The library that is summed; none where a chain is learned, which needs no sums.
    pub library: Option<SummedLibrary>,
    /// Patterns of the rows, log by log.
    pub patterns: PatternPlan,
    /// How the signals were filtered, as the caller describes it.
    pub signals: String,
    /// Whether they were filtered at all.
    pub filtered: bool,
    /// The filter that the model keeps, if there was one.
    pub filter: Option<TrainingFilter>,
}

impl SumSettings {
    pub(crate) fn new(
        recording: &(impl Recording + ?Sized),
        plan: &Plan,
        library: Option<SummedLibrary>,
        signals: &str,
    ) -> Self {
        let has_friction = library.as_ref().is_some_and(|library| !library.friction.is_empty());
        let slow = plan.patterns.slow || has_friction;
        Self {
            joints: recording.joints().to_vec(),
            library,
            patterns: PatternPlan { slow, ..plan.patterns },
            signals: signals.to_owned(),
            filtered: recording.is_filtered(),
            filter: None,
        }
    }

    /// The candidates, unless a chain is learned.
    pub(crate) fn basis(&self) -> Result<Option<Basis>, IdentifyError> {
        self.library.as_ref().map(|library| library.basis(self.joints.len())).transpose()
    }

    /// The patterns whose rows are summed apart; `None` stands for all rows.
    pub(crate) fn parts(&self) -> Vec<Option<Pattern>> {
        self.library.as_ref().map_or_else(Vec::new, SummedLibrary::parts)
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
        let mut pairs = std::iter::zip(self.described(), other.described());
        let apart = pairs.find(|(own, other)| own != other);
        let Some(((what, expected), (_, found))) = apart else { return Ok(()) };
        Err(IdentifyError::Apart { what, expected, found })
    }

    /// All that must be alike.
    fn described(&self) -> [(&'static str, String); 7] {
        let library = self.library.as_ref();
        let regression = |own: &SummedLibrary| format!("{:?}", own.regression);
        [
            ("joints", self.joints.join(", ")),
            ("method", library.map_or_else(|| "Chain".to_owned(), regression)),
            ("library", format!("{:?}", library.map(|own| own.kind))),
            ("kinds", library.map_or_else(String::new, |own| own.kinds.to_string())),
            ("patterns", format!("{:?}", self.patterns)),
            ("signals", self.signals.clone()),
            ("filters", format!("{:?}", self.filtered)),
        ]
    }
}
