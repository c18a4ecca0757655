//! x
#![no_std]
#![no_main]
use board_qemu as _;
#[cortex_m_rt::entry]
fn main() -> ! { board_qemu::semihosting::done() }
