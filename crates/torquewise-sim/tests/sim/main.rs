//! Arms, motions, noise, plants and plans beside identities and values of another program.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod identities;
mod motions;
mod noise;
mod oracles;
mod plan;
mod tracking;
mod urdf_chain;
#[path = "../../../torquewise-logs/tests/logs/shared.rs"]
mod shared;
#[path = "../../../torquewise-paper/src/truth.rs"]
mod truth;
