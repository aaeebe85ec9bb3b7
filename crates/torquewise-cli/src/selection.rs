//! How terms are selected and fitted, and which friction is looked for.

use clap::{Args, ValueEnum};
use torquewise::regression::select::Selector;
use torquewise::regression::select::criterion::Criterion;
use torquewise::regression::select::lasso::Lasso;
use torquewise::regression::select::stlsq::Stlsq;
use torquewise::{FitOptions, FrictionKind};

/// Friction beside inertia, Coriolis and gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Friction {
    /// None
    None,
    /// Offset, viscous and dry friction
    Linear,
    /// The same and the Stribeck curve, forward and backward apart
    Stribeck,
    /// Whichever predicts held-out rows best; of a chain joint by joint, with memory of the path at
    /// rest and reversal, and with load, where they pay
    Auto,
}

impl From<Friction> for FrictionKind {
    fn from(friction: Friction) -> Self {
        match friction {
            Friction::None => Self::None,
            Friction::Linear => Self::Linear,
            Friction::Stribeck => Self::Stribeck,
            Friction::Auto => Self::Auto,
        }
    }
}

/// Which terms stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Select {
    /// What a term explains against the noise
    Bic,
    /// LASSO, then least squares
    Lasso,
    /// Sequentially thresholded least squares
    Stlsq,
}

/// What becomes of candidates once the rows are summed.
#[derive(Args, Clone, Debug)]
pub(crate) struct SelectionArguments {
    /// Which terms of a library stay [default: bic; stlsq with --method sindy]
    #[arg(long, value_enum)]
    select: Option<Select>,
    /// Drop coefficients of a library that are at most this large [paper: 0.1]
    #[arg(long, value_name = "X", value_parser = threshold)]
    threshold: Option<f64>,
    /// Joints that a spring or a weight is known to balance, for --library chain; others are looked
    /// for
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    counterbalance: Vec<String>,
    /// Leave the bias that measurement noise causes in the fit, as --method sindy always does
    #[arg(long)]
    no_noise_correction: bool,
    /// Resampled logs to count in how many each term of a library stays [default: 50; 0 with
    /// --method sindy]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    bags: Option<u16>,
}

impl SelectionArguments {
    /// Sets these choices among the options of a fit.
    pub(crate) fn apply_to(&self, mut options: FitOptions) -> FitOptions {
        let selector = self.select.map(|select| match select {
            Select::Bic => Selector::Criterion(Criterion::default()),
            Select::Lasso => Selector::Lasso(Lasso::default()),
            Select::Stlsq => Selector::Stlsq(Stlsq::default()),
        });
        options.selector = selector;
        options.threshold = self.threshold;
        options.bags = self.bags.map(usize::from);
        options.counterbalanced.clone_from(&self.counterbalance);
        options.noise_correction = !self.no_noise_correction;
        options
    }

    /// The first flag given that selects terms or fits them, if any.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let all = [
            ("--select", self.select.is_some()),
            ("--threshold", self.threshold.is_some()),
            ("--no-noise-correction", self.no_noise_correction),
            ("--bags", self.bags.is_some()),
        ];
        all.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }
}

fn threshold(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a number that is zero or more".to_owned()),
    }
}
