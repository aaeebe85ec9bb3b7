//! Mutated files for every reader: seeds made by the program itself, mutations that repair what
//! checksums would hide, and the decoders they are given to.

pub mod reader;
pub mod seeds;
pub mod mutate;
#[path = "../../crates/torquewise-logs/tests/logs/made_bags.rs"]
mod made_bags;
