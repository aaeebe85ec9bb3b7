//! Normal equations → the few columns that explain the response.

pub mod lasso;
pub mod stlsq;
