//! Every reader of torquewise, and small valid files for each, to be mutated.

pub mod reader;
pub mod seeds;
#[path = "../../crates/torquewise-logs/tests/logs/made_bags.rs"]
mod made_bags;
#[path = "../../crates/torquewise-logs/tests/logs/made_mats.rs"]
#[expect(dead_code, clippy::unwrap_used, reason = "made for tests of more than seeds")]
mod made_mats;
