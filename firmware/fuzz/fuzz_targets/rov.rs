//! `cargo +nightly fuzz run rov`, from `firmware/`: bytes as what happens to an ROV.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    firmware_fuzz::rov::run(bytes);
});
