//! From chains to the arms they stand for: dynamics, recovery, bad input.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod twins;
mod dynamics;
mod prismatic;
mod recursion;
mod tangent;
mod bad_input;
