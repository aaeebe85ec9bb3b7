//! Plants and controllers beside identities.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod bristles;
mod plant;
mod tracking;
