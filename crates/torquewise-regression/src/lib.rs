//! Moments, Gram matrices, term selectors and k-means for sparse regression.
//!
//! Everything here speaks of angles, variables, columns and responses; it knows nothing of
//! robots. A column is a sum of harmonics of the angles times monomials of the variables, so the
//! normal equations of any library follow from one table of moments, see [`moments`].

pub mod error;
pub mod exact;
pub mod atom;
pub mod design;
pub mod samples;
pub mod products;
mod cholesky;
pub mod normal_equations;
pub mod normal_sums;
pub mod noise_correction;
pub mod moments;
pub mod row_sums;
pub mod elimination;
pub mod select;
pub mod kmeans;

pub use design::{AtomSum, Design};
pub(crate) use error::expect;
pub use error::{Result, SparseError};
pub use normal_equations::{KeptColumns, NormalEquations, ascending};
pub use normal_sums::{Alike, BlockSums, NormalSums};
pub use row_sums::{PreparedDesign, RowAdder, RowSums};
pub use samples::Samples;
pub use select::Selector;
