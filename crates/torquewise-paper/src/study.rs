//! The experiments, one file each.

pub(crate) mod patterns;
pub(crate) mod orders;
pub(crate) mod cost;
pub(crate) mod cases;
pub(crate) mod control;
pub(crate) mod ablation;
pub(crate) mod sweeps;
pub(crate) mod arms;
pub(crate) mod coefficients;
