//! Does on purpose what no firmware should, to show that a fault ends the emulator and is told.
#![no_std]
#![no_main]

use cortex_m_rt::entry;

board_qemu::ends_with_its_faults!();

#[entry]
fn main() -> ! {
    cortex_m::asm::udf()
}
