//! Arms, motions and noise beside identities and values of another program.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod identities;
mod motions;
mod noise;
mod oracles;
mod urdf_chain;
#[path = "../../../torquewise-logs/tests/logs/shared.rs"]
mod shared;
