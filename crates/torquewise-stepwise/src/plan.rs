//! Options of a library: candidates, regressions, friction and selection.

use crate::FrictionKind;
use serde::{Deserialize, Serialize};
use torquewise_model::JointKinds;
use torquewise_regression::Selector;
use torquewise_regression::select::criterion::Criterion;
use torquewise_regression::select::stlsq::Stlsq;

/// Which candidates are offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LibraryKind {
    /// M(q) and V(q), shared by all joints (E4); at most this many joint angles to a term.
    Energy {
        /// `None`: as many as keep the library below [`MOST_CANDIDATES`].
        interaction: Option<usize>,
    },
    /// F₁·F₂ for each joint on its own (13).
    Product {
        /// N₁ of the gravity step.
        gravity_order: u8,
        /// N₁ of the other steps and of the whole library.
        trig_order: u8,
    },
}

impl LibraryKind {
    /// The product library at the orders of the paper's arm: N₁ = 2 for gravity, 4 else.
    pub const PRODUCT: Self = Self::Product { gravity_order: 2, trig_order: 4 };
}

/// Candidates of an energy library unless an interaction order is asked for.
pub const MOST_CANDIDATES: usize = 2_100;

/// How many regressions a library is fitted in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Regression {
    /// Three: standstill, uniform velocity, variable velocity (8)–(10).
    #[default]
    Stepwise,
    /// One: the whole library on all rows at once, as SINDy does.
    OneShot,
}

/// How a library of candidates is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct LibraryOptions {
    /// Candidates.
    pub library: LibraryKind,
    /// Which joints turn and which slide; none is looked for.
    pub kinds: JointKinds,
    /// One-shot or stepwise.
    pub regression: Regression,
    /// Friction beside M, C and G (17).
    pub friction: FrictionKind,
    /// Which terms stay.
    pub selector: Selector,
    /// Coefficients at most this large are dropped, in units of the coefficient (the paper: 0.1).
    pub threshold: Option<f64>,
    /// Whether the bias that noise in q, q̇, q̈ leaves in the normal equations is taken out (E7).
    pub noise_correction: bool,
    /// Resampled logs from which the inclusion of each term is counted; 0 for none.
    pub bags: usize,
}

impl Default for LibraryOptions {
    /// The energy library in three regressions, terms kept by the criterion (E5), no friction.
    fn default() -> Self {
        Self {
            library: LibraryKind::Energy { interaction: None },
            kinds: JointKinds::default(),
            regression: Regression::Stepwise,
            friction: FrictionKind::None,
            selector: Selector::Criterion(Criterion::default()),
            threshold: None,
            noise_correction: true,
            bags: 50,
        }
    }
}

impl LibraryOptions {
    /// One-shot SINDy, the baseline: the whole product library on all rows, terms above 0.1 kept by
    /// sequentially thresholded least squares as PySINDy does by default and the paper counts
    /// active terms, no noise correction.
    pub fn sindy() -> Self {
        Self {
            library: LibraryKind::PRODUCT,
            regression: Regression::OneShot,
            selector: Selector::Stlsq(Stlsq::default()),
            noise_correction: false,
            bags: 0,
            ..Self::default()
        }
    }

    /// Stepwise reconstruction with the product library.
    pub fn product() -> Self {
        Self { library: LibraryKind::PRODUCT, ..Self::default() }
    }
}
