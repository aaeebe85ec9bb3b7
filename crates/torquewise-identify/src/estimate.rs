//! A chain refitted on every row, physical, with its covariance (E11) (E14).
//!
//! The search finds the structure on a sample. Here every row counts: a [`Linearisation`] says
//! where the torque is linearised, a pass over the logs adds up normal equations, and these say
//! where to linearise next.

mod linearisation;
mod nominal;
mod pass;
mod equations;
mod step;
mod solve;
mod refine;
mod windows;
mod rollouts;

pub(crate) use linearisation::Linearisation;
pub(crate) use nominal::{Sizes, prior};
pub(crate) use pass::add_up;
pub(crate) use refine::{Passes, refine};
pub(crate) use rollouts::refined_by_rollouts;
pub(crate) use solve::Solved;
pub(crate) use step::{LEAST_RESIDUAL, STRENGTH, weights};
