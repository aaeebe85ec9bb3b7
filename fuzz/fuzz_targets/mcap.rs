//! `cargo +nightly fuzz run fuzz-mcap --features libfuzzer`.
#![no_main]

use torquewise_fuzz::reader::{Reader, Tried};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    Tried::here(Reader::Mcap).one(bytes);
});
