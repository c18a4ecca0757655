//! Panics and faults of the firmware end the emulator with a failing status, and say why.

use qemu::emulator::{Emulator, Setup};

fn ends(image: &str, says: &str) {
    let emulator = Emulator::start(&Setup { image, ..Setup::default() });
    let (status, lines) = emulator.wait();
    assert_eq!(status.code(), Some(1), "{image}: {status}: {lines:?}");
    assert!(lines.iter().any(|line| line.contains(says)), "{image}: {lines:?}");
}

#[test]
fn a_panic_is_told_and_ends_it() {
    // It wants a configuration, and gets none.
    ends("measure.elf", "panicked at");
    ends("measure.elf", "begins with [00, 00, 00, 00]");
}

#[test]
fn a_fault_is_told_and_ends_it() {
    ends("fault.elf", "hard fault: ExceptionFrame");
}
