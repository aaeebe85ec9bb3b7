//! `cargo +nightly fuzz run fuzz-parquet --features libfuzzer`.
#![no_main]

use torquewise_fuzz::reader::{Reader, Tried};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    Tried::here(Reader::Parquet).one(bytes);
});
