//! Models beside closed forms.

mod chain;
mod friction;
mod friction_load;
mod model;
mod physics;
mod rigid_chain;
mod rollout;
mod shaft_friction;
