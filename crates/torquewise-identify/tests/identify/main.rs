//! Reconstruction, summaries and memory, as a user of the crate sees them.

mod bristles;
mod chain;
mod chain_limits;
mod disagreement;
mod excited;
mod friction;
mod gears;
mod memory;
mod oracle;
mod recovery;
mod rollouts;
mod rounds;
mod samples;
mod six_joints;
mod sliding;
mod spoilt;
mod summary;
mod support;
mod torque_sign;
mod truth;
mod work;
