//! Words of the command line → how terms are selected and fitted, and which friction is looked for.

use crate::error::CliError;
use crate::flags::{Fitted, Flag, refuse_unused};
use clap::{Args, ValueEnum};
use torquewise::identify::plan::{ChainOptions, FrictionKind, LibraryOptions, Regression};
use torquewise::identify::settings::Settings;
use torquewise::identify::{LibraryKind, Method, Plan};
use torquewise::regression::select::Selector;
use torquewise::regression::select::criterion::Criterion;
use torquewise::regression::select::lasso::Lasso;
use torquewise::regression::select::stlsq::Stlsq;

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
    pub(crate) counterbalance: Vec<String>,
    /// Leave the bias that measurement noise causes in the fit, as --method sindy always does
    #[arg(long)]
    no_noise_correction: bool,
    /// Fit a chain by least squares alone, without what physics asks of masses, rotors and
    /// friction: for comparison, its mass matrix may not be positive definite
    #[arg(long)]
    unconstrained: bool,
    /// Resampled logs to count in how many each term of a library stays [default: 50; 0 with
    /// --method sindy]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    bags: Option<u16>,
}

impl SelectionArguments {
    /// The plan for moments that were made under these settings.
    ///
    /// # Errors
    /// [`CliError::Usage`] if a flag is given that what the moments are for does not use.
    pub(crate) fn plan_of(
        &self,
        settings: &Settings,
        friction: Option<Friction>,
        seed: u64,
    ) -> Result<Plan, CliError> {
        let because = "the moments were made for it";
        let choose = "make the moments with";
        let rubs = friction.is_some_and(|friction| friction != Friction::None);
        if let (true, Some(_)) = (rubs, &settings.library) {
            let message = "--friction is not used by a library, for which the moments were made: \
                           leave it out or make the moments with --library chain";
            return Err(CliError::Usage(message.into()));
        }
        let (fitted, method) = match &settings.library {
            None => (Fitted::Chain, self.chain_options(friction)),
            Some(library) => {
                let fitted = match library.kind {
                    LibraryKind::Energy { .. } => Fitted::Energy(library.regression),
                    LibraryKind::Product { .. } => Fitted::Product(library.regression),
                };
                (fitted, self.library_options(library.kind, library.regression, None))
            }
        };
        refuse_unused(&self.given(), fitted, because, choose)?;
        Ok(Plan { method, patterns: settings.patterns, seed })
    }

    /// The flags given, of which not every method uses all.
    pub(crate) fn given(&self) -> Vec<Flag> {
        let all = [
            (Flag::Select, self.select.is_some()),
            (Flag::Threshold, self.threshold.is_some()),
            (Flag::Counterbalance, !self.counterbalance.is_empty()),
            (Flag::NoNoiseCorrection, self.no_noise_correction),
            (Flag::Bags, self.bags.is_some()),
            (Flag::Unconstrained, self.unconstrained),
        ];
        all.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag).collect()
    }

    /// How a library is fitted.
    pub(crate) fn library_options(
        &self,
        library: LibraryKind,
        regression: Regression,
        friction: Option<Friction>,
    ) -> Method {
        let usual = match regression {
            Regression::OneShot => LibraryOptions::sindy(),
            Regression::Stepwise => LibraryOptions::default(),
        };
        Method::Library(LibraryOptions {
            library,
            regression,
            friction: friction.map_or(usual.friction, Into::into),
            selector: self.selector(usual.selector),
            threshold: self.threshold.or(usual.threshold),
            noise_correction: usual.noise_correction && !self.no_noise_correction,
            bags: self.bags.map_or(usual.bags, usize::from),
        })
    }

    /// How a chain is learned.
    pub(crate) fn chain_options(&self, friction: Option<Friction>) -> Method {
        let usual = ChainOptions::default();
        Method::Chain(ChainOptions {
            friction: friction.map_or(usual.friction, Into::into),
            counterbalanced: self.counterbalance.clone(),
            noise_correction: usual.noise_correction && !self.no_noise_correction,
            physical: !self.unconstrained,
        })
    }

    fn selector(&self, usual: Selector) -> Selector {
        let asked = match self.select {
            None => usual,
            Some(Select::Bic) => Selector::Criterion(Criterion::default()),
            Some(Select::Lasso) => Selector::Lasso(Lasso::default()),
            Some(Select::Stlsq) => Selector::Stlsq(Stlsq::default()),
        };
        match (asked, self.threshold) {
            (Selector::Lasso(lasso), Some(threshold)) => {
                Selector::Lasso(Lasso { threshold, ..lasso })
            }
            (Selector::Stlsq(stlsq), Some(threshold)) => {
                Selector::Stlsq(Stlsq { threshold, ..stlsq })
            }
            (other, _) => other,
        }
    }
}

fn threshold(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a number that is zero or more".to_owned()),
    }
}
