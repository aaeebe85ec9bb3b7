//! What the user wants → plan: library, method, selector, clusters.

use crate::patterns::PatternPlan;
use serde::{Deserialize, Serialize};
use torquewise_sparse::select::Selector;
use torquewise_sparse::select::criterion::Criterion;
use torquewise_sparse::select::stlsq::Stlsq;

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

/// One regression or three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// Standstill, uniform velocity, variable velocity (8)–(10).
    #[default]
    Stepwise,
    /// The whole library on all rows at once.
    Sindy,
    /// The energy of a chain of rigid bodies whose geometry is learned as well (E8); the library
    /// of the plan is not asked.
    Chain,
}

/// Which friction is looked for (17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrictionKind {
    /// None: simulated arms, or torque measured behind the gears.
    #[default]
    None,
    /// Offset, viscous and dry friction of each joint.
    Linear,
    /// The same and the Stribeck curve, from a dictionary of speeds; forward and backward apart.
    Stribeck,
    /// None, linear or Stribeck, whichever predicts held-out rows best.
    Auto,
}

impl FrictionKind {
    /// As the command line has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Linear => "linear",
            Self::Stribeck => "stribeck",
            Self::Auto => "auto",
        }
    }
}

/// How a log becomes a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Candidates.
    pub library: LibraryKind,
    /// One-shot or stepwise.
    pub method: Method,
    /// Friction beside M, C and G (17).
    pub friction: FrictionKind,
    /// Names of joints that a spring or a weight is known to balance: a chain is given functions of
    /// their angle in V(q) that no mass has. Without, they are looked for.
    pub counterbalanced: Vec<String>,
    /// Which terms stay.
    pub selector: Selector,
    /// Coefficients at most this large are dropped, in units of the coefficient (the paper: 0.1).
    pub threshold: Option<f64>,
    /// Whether the bias that noise in q, q̇, q̈ leaves in the normal equations is taken out (E7).
    pub noise_correction: bool,
    /// Clustering.
    pub patterns: PatternPlan,
    /// Resampled logs from which the inclusion of each term is counted; 0 for none.
    pub bags: usize,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            library: LibraryKind::Energy { interaction: None },
            method: Method::Stepwise,
            friction: FrictionKind::None,
            counterbalanced: Vec::new(),
            selector: Selector::Criterion(Criterion::default()),
            threshold: None,
            noise_correction: true,
            bags: 50,
            patterns: PatternPlan::default(),
            seed: 0,
        }
    }
}

impl Plan {
    /// One-shot SINDy, the baseline: the whole product library on all rows, terms above 0.1 kept by
    /// sequentially thresholded least squares as PySINDy does by default and the paper counts
    /// active terms, no noise correction.
    pub fn sindy() -> Self {
        Self {
            library: LibraryKind::PRODUCT,
            method: Method::Sindy,
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
