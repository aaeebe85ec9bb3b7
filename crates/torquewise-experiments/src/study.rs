//! From settings to studies: each asks for its trials, and turns them into numbers when they are
//! done.

pub(crate) mod patterns;
pub(crate) mod order_curves;
pub(crate) mod cost;
pub(crate) mod cases;
pub(crate) mod steps;
pub(crate) mod recorded;
pub(crate) mod control;
pub(crate) mod coefficients;
pub(crate) mod ablation;
pub(crate) mod sweeps;
pub(crate) mod arms;
