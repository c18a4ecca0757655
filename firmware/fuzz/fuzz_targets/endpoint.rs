//! `cargo +nightly fuzz run endpoint`, from `firmware/`: bytes as what happens to a Modboat.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    firmware_fuzz::endpoint::run(bytes);
});
