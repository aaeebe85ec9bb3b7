//! Selectors: the few columns that explain a response.

pub mod lasso;
pub mod stlsq;
pub mod criterion;

use crate::{KeptColumns, NormalEquations, Result};

/// A rule to choose columns.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Selector {
    /// What a term explains against the noise (E5).
    Criterion(criterion::Criterion),
    /// LASSO (5).
    Lasso(lasso::Lasso),
    /// Sequentially thresholded least squares.
    Stlsq(stlsq::Stlsq),
}

impl Selector {
    /// Selects columns of a problem.
    ///
    /// # Errors
    /// Those of the selector.
    pub fn select(&self, problem: &NormalEquations) -> Result<KeptColumns> {
        match self {
            Self::Criterion(criterion) => criterion.select(problem),
            Self::Lasso(lasso) => lasso.select(problem),
            Self::Stlsq(stlsq) => stlsq.select(problem),
        }
    }
}
