//! Models beside closed forms.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod chain;
mod friction;
mod model;
mod physics;
mod rigid_chain;
mod rollout;
mod shaft_friction;
