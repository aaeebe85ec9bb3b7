//! How terms are selected and fitted, and which friction is looked for.

use crate::arguments::{fitting, kinds_of_joints, words};
use crate::{CliError, Result};
use clap::Args;
use serde::Serialize;

pub(crate) const FRICTION: [(&str, &str); 4] = [
    ("none", "None"),
    ("linear", "Offset, viscous and dry friction"),
    ("stribeck", "The same and the Stribeck curve, forward and backward apart"),
    (
        "auto",
        "Whichever predicts held-out rows best; of a chain joint by joint, with memory of the path \
         at rest and reversal, and with load, where they pay",
    ),
];

const REFINE: [(&str, &str); 1] = [(
    "rollout",
    "Windows of the log, simulated with the measured torque: for a model that is to move like the arm",
)];

const SELECT: [(&str, &str); 3] = [
    ("bic", "BIC-like information criterion"),
    ("lasso", "LASSO, then least squares"),
    ("stlsq", "Sequentially thresholded least squares"),
];

/// What becomes of candidates once the rows are summed.
#[derive(Args, Clone, Debug, Serialize)]
#[command(next_help_heading = "Term libraries")]
pub(crate) struct SelectionArguments {
    /// Which terms of a library stay [default: bic; stlsq with --method sindy]
    #[arg(long, value_parser = words(&SELECT))]
    select: Option<String>,
    /// Drop coefficients of a library that are at most this large [paper: 0.1]
    #[arg(long, value_name = "X")]
    #[arg(value_parser = fitting(|x: &f64| *x >= 0.0 && x.is_finite(), "expected a number that is zero or more"))]
    threshold: Option<f64>,
    /// Which joints turn and which slide, base to tip, as r,r,p,r or RRPR; without, a chain finds them
    /// in the log, and in a library all turn
    #[arg(help_heading = "Method", long, value_name = "KINDS", value_parser = kinds_of_joints())]
    kinds: Option<String>,
    /// Joints that a spring or a weight is known to balance, for --library chain; others are looked
    /// for
    #[arg(help_heading = "Learned chain", long, value_name = "JOINT", value_delimiter = ',')]
    counterbalance: Vec<String>,
    /// Refine a learned chain once its torque is fitted, as far as it may while at most 1.5 % more
    /// of the torque is missed
    #[arg(help_heading = "Learned chain", long, value_parser = words(&REFINE))]
    refine: Option<String>,
    /// Disable the correction of the bias that measurement noise causes, as --method sindy always does
    #[arg(help_heading = "Method", long)]
    no_noise_correction: bool,
    /// Bootstrap resamples for the inclusion frequency of each term [default: 50; 0 with --method
    /// sindy]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    #[serde(rename = "n_bootstrap")]
    bootstrap: Option<u16>,
}

impl SelectionArguments {
    /// Where logs are only summed up.
    pub(crate) fn refuse(&self) -> Result<()> {
        let all = [
            ("--select", self.select.is_some()),
            ("--threshold", self.threshold.is_some()),
            ("--no-noise-correction", self.no_noise_correction),
            ("--bootstrap", self.bootstrap.is_some()),
        ];
        all.into_iter().find(|(_, given)| *given).map_or(Ok(()), |(flag, _)| {
            let why = "is not used where logs are only summed up: give it to solve";
            Err(CliError::Usage(format!("{flag} {why}")))
        })
    }
}
