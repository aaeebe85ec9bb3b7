//! From numbers of all experiments to results: plain, to be saved, drawn and told.

use crate::error::ExperimentError;
use crate::settings::Settings;
use crate::study::ablation::Variant;
use crate::study::arms::ArmResults;
use crate::study::cases::{CaseResults, TrueTerms};
use crate::study::coefficients::CoefficientResults;
use crate::study::control::ControlResults;
use crate::study::cost::MethodCost;
use crate::study::order_curves::OrderResults;
use crate::study::patterns::PatternResults;
use crate::study::steps::StepResults;
use crate::study::sweeps::Point;
use serde::Serialize;

/// All that was measured, as plain numbers in SI units.
///
/// Of the same settings all numbers are the same at any number of threads, but for times, which
/// stand under keys named `seconds`.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// What was done.
    pub settings: Settings,
    /// Fig. 1–3: patterns.
    pub patterns: PatternResults,
    /// Fig. 5: orders.
    pub orders: Vec<OrderResults>,
    /// Fig. 6: candidates and time.
    pub costs: Vec<MethodCost>,
    /// The number of terms of the truth, for Fig. 7.
    pub true_terms: TrueTerms,
    /// Fig. 7 and 8: terms and torque in cases 1, 2 and 3.
    pub cases: Vec<CaseResults>,
    /// Fig. 10: the model after each step.
    pub steps: Vec<StepResults>,
    /// Fig. 10 and 11: an arm with friction, recorded, learned and controlled.
    pub control: ControlResults,
    /// What each of our choices buys.
    pub ablation: Vec<Variant>,
    /// Error against noise.
    pub noise_sweep: Vec<Point>,
    /// Error against the length of the log.
    pub length_sweep: Vec<Point>,
    /// Arms of more joints.
    pub arms: Vec<ArmResults>,
    /// Coefficients beside the truth, in cases 2 and 3.
    pub coefficients: Vec<CoefficientResults>,
    /// The paper's claims, judged.
    pub claims: Vec<Claim>,
}

/// A claim of the paper, judged by what was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// What the paper says.
    pub claim: &'static str,
    /// Where it says so.
    pub source: &'static str,
    /// What is measured here, times left out.
    measured: String,
    /// Whether it holds.
    #[serde(flatten)]
    judgement: Judgement,
}

/// What a verdict rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
enum Judgement {
    /// On what is the same in every run.
    Lasting { verdict: Verdict },
    /// On time, which is another in every run.
    Timed { seconds: Times },
}

/// What was measured of time.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Times {
    measured: String,
    verdict: Verdict,
}

impl Claim {
    /// A claim judged by what is the same in every run.
    pub(crate) fn new(
        claim: &'static str,
        source: &'static str,
        measured: String,
        verdict: Verdict,
    ) -> Self {
        Self { claim, source, measured, judgement: Judgement::Lasting { verdict } }
    }

    /// A claim judged by time.
    pub(crate) fn timed(
        claim: &'static str,
        source: &'static str,
        [measured, times]: [String; 2],
        verdict: Verdict,
    ) -> Self {
        let seconds = Times { measured: times, verdict };
        Self { claim, source, measured, judgement: Judgement::Timed { seconds } }
    }

    /// What is measured here, times among it.
    pub fn measurement(&self) -> String {
        match &self.judgement {
            Judgement::Lasting { .. } => self.measured.clone(),
            Judgement::Timed { seconds } => format!("{} {}", self.measured, seconds.measured),
        }
    }

    /// Whether it holds.
    pub fn verdict(&self) -> Verdict {
        match &self.judgement {
            Judgement::Lasting { verdict }
            | Judgement::Timed { seconds: Times { verdict, .. } } => *verdict,
        }
    }
}

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As it stands.
    Holds,
    /// Under a condition that the measurement names.
    HoldsInPart,
    /// The measurement says otherwise.
    Contradicted,
}

impl Verdict {
    /// As one reads it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::HoldsInPart => "holds in part",
            Self::Contradicted => "contradicted",
        }
    }
}

impl Results {
    /// The results as JSON, one object.
    ///
    /// # Errors
    /// [`ExperimentError::Json`] if they cannot be written.
    pub fn to_json(&self) -> Result<String, ExperimentError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The results of a case.
    pub fn case(&self, case: u8) -> Option<&CaseResults> {
        self.cases.iter().find(|results| results.case == case)
    }
}
