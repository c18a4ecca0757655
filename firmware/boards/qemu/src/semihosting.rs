//! What only an emulator has: the PC's dice, a line to its terminal, and a status to end with (Arm IHI 0100, semihosting).
//!
//! A real board draws its boot nonce from a generator of its own. This machine has none, so that of the PC serves.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::{debug, hprintln, nr, syscall};

/// Different from life to life, from the PC's `/dev/urandom`.
///
/// # Panics
/// Where it cannot be read: a module without it would let recordings in.
#[must_use]
pub fn boot_nonce() -> [u8; 12] {
    let (path, mut nonce) = (c"/dev/urandom", [0; 12]);
    // SAFETY: parameter blocks as the calls want them: address of the path, mode, length without the zero; handle, address
    // and length of the buffer; handle. All outlive their call.
    let unread = unsafe {
        let file = syscall(nr::OPEN, &[path.as_ptr().addr(), nr::open::R_BINARY, path.count_bytes()]);
        let unread = syscall(nr::READ, &[file, nonce.as_mut_ptr().expose_provenance(), nonce.len()]);
        syscall(nr::CLOSE, &[file]);
        unread
    };
    assert_eq!(unread, 0, "no random bytes from the PC");
    nonce
}

/// Ends the emulator with status 0.
pub fn done() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    halt()
}

/// Says why, and ends the emulator with status 1.
fn failed(why: &dyn core::fmt::Display) -> ! {
    cortex_m::interrupt::disable();
    hprintln!("{}", why);
    debug::exit(debug::EXIT_FAILURE);
    halt()
}

fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panicked(info: &PanicInfo<'_>) -> ! {
    failed(info)
}

// SAFETY: ends, and touches nothing on the way that the fault may have left half done but the debugger's port.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    failed(&format_args!("hard fault: {frame:?}"))
}
