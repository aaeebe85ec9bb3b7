//! The methods that are compared: what each offers, and which terms stay.

use torquewise_identify::{LibraryOptions, Regression};
use torquewise_regression::Selector;
use torquewise_regression::select::lasso::Lasso;
use torquewise_report::Colour;

/// A coefficient larger than this counts as active in the paper.
pub(crate) const ACTIVE: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Stepwise over the energy library \[E4\], terms judged against the noise \[E5\].
    Energy,
    /// One-shot SINDy as it is usually run: thresholded least squares at the paper's 0.1.
    Sindy,
    /// Stepwise over the paper's product library, everything else the same as with energies.
    Product,
    /// One-shot SINDy, terms by LASSO (5) at the best information criterion, then refitted.
    SindyLasso,
    /// The stepwise product plan in a single step: what is left of it without the steps.
    SindyCriterion,
}

impl Method {
    /// Those of cases 1–3, ours first.
    pub(crate) const ALL: [Self; 4] = [Self::Energy, Self::Product, Self::SindyLasso, Self::Sindy];
    /// Those of the sweeps. In strong noise LASSO with BIC keeps thousands of terms, whose refit
    /// takes minutes.
    pub(crate) const SWEPT: [Self; 4] =
        [Self::Energy, Self::Product, Self::SindyCriterion, Self::Sindy];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Energy => "stepwise, energy library",
            Self::Product => "stepwise, product library",
            Self::Sindy => "one-shot SINDy, |c| > 0.1",
            Self::SindyLasso => "one-shot SINDy, LASSO + BIC + refit",
            Self::SindyCriterion => "one-shot SINDy, our rule",
        }
    }

    /// In all charts.
    pub(crate) fn colour(self) -> Colour {
        Colour::Series(self as usize)
    }

    /// What it offers, and which terms stay.
    pub(crate) fn options(self) -> LibraryOptions {
        let (product, sindy) = (LibraryOptions::product(), LibraryOptions::sindy());
        let lasso = Selector::Lasso(Lasso::default());
        let options = match self {
            Self::Energy => LibraryOptions::default(),
            Self::Product => product,
            Self::Sindy => sindy,
            Self::SindyLasso => LibraryOptions { selector: lasso, ..sindy },
            Self::SindyCriterion => LibraryOptions { regression: Regression::OneShot, ..product },
        };
        // How often a term stays in resampled logs is not asked here.
        LibraryOptions { bags: 0, ..options }
    }

    pub(crate) fn with_rule_of(self, other: Self) -> LibraryOptions {
        LibraryOptions { selector: other.options().selector, ..self.options() }
    }
}
