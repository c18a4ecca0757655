//! `cargo +nightly fuzz run configuration`, from `firmware/`: bytes as a block of flash.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| firmware_fuzz::configuration::run(bytes));
