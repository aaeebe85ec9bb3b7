//! The engine of the page: a request in, an answer out, both JSON.
//!
//! It keeps nothing between requests, so that the page may end it at any time: a model comes back as
//! the text of its file. Bytes of logs are read from the page as they are wanted. The functions that a
//! worker calls are few and plain, in `exports.rs`: texts and bytes go through the memory of the
//! module, which needs no generated code on either side.

pub mod request;
pub mod examples;
mod fitted;
pub mod answer;
#[cfg(target_family = "wasm")]
pub mod exports;
