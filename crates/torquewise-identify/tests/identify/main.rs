//! Reconstruction, summaries and memory, as a user of the crate sees them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod bristles;
mod chain;
mod chain_limits;
mod disagreement;
mod excited;
mod friction;
mod gears;
mod memory;
mod recovery;
mod rollouts;
mod rounds;
mod samples;
#[path = "../../../torquewise-logs/tests/logs/shared.rs"]
mod shared;
mod sliding;
mod spoilt;
mod summary;
mod support;
mod torque_sign;
mod verdict;
#[path = "../../../torquewise-paper/src/truth.rs"]
mod truth;
mod work;
