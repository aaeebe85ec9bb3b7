//! `cargo +nightly fuzz run readers --features libfuzzer`; the first byte of an input picks the reader.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    torquewise_fuzz::reader::picked(input);
});
