//! Models beside closed forms.

mod friction;
mod model;
mod physics;
mod rigid_chain;
