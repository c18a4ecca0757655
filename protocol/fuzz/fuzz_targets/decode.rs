//! `cargo +nightly fuzz run decode`, from `protocol/`: bytes on every way into a session.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| protocol_fuzz::decode(bytes));
