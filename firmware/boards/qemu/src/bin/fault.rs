//! Faults on purpose, to show that a fault ends the emulator and is reported.
#![no_std]
#![no_main]

use cortex_m_rt::entry;

board_qemu::ends_with_its_faults!();

#[entry]
fn main() -> ! {
    cortex_m::asm::udf()
}
