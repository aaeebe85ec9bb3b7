//! From settings to studies: each asks for its trials, and turns them into numbers when they are
//! done.

pub mod patterns;
pub mod order_curves;
pub mod cost;
pub mod cases;
pub mod steps;
pub mod recorded;
pub mod control;
pub mod coefficients;
pub mod ablation;
pub mod sweeps;
pub mod arms;
pub mod indicators;
