//! Plans within their limits, and what is learned from them.

mod plan;
