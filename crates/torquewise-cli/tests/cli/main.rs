//! The command line as its users and their programs see it.
#![expect(clippy::unwrap_used, reason = "a test may panic wherever it is written")]

mod documents;
mod terminal;
mod spoilt;
mod whole_way;
mod moments;
mod reports;
mod robots;
mod gains;
mod json_contract;
mod excite;
mod control;
mod friction;
mod export;
mod pitfalls;
mod harm;
mod bad_input;
mod conformance;
mod usage;
mod flags;
mod physics;
#[cfg(unix)]
mod faults;
