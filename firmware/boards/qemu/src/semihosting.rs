//! What only an emulator has: the PC's dice, a line to its terminal, and a status to end with (Arm IHI 0100, semihosting).
//!
//! A real board draws its boot nonce from a generator of its own. This machine has none, so that of the PC serves.

use cortex_m_semihosting::{debug, hprintln, nr, syscall, syscall1};

/// Different from life to life, from the PC's `/dev/urandom`.
///
/// Nothing where it cannot be read: a module without it would let recordings in.
#[must_use]
pub fn boot_nonce() -> Option<[u8; 12]> {
    let (path, mut nonce) = (c"/dev/urandom", [0; 12]);
    // SAFETY: parameter blocks as the calls want them: address of the path, mode, length without the zero; handle, address
    // and length of the buffer; handle. All outlive their call.
    let unread = unsafe {
        let file = syscall(nr::OPEN, &[path.as_ptr().addr(), nr::open::R_BINARY, path.count_bytes()]);
        let unread = syscall(nr::READ, &[file, nonce.as_mut_ptr().expose_provenance(), nonce.len()]);
        syscall(nr::CLOSE, &[file]);
        unread
    };
    (unread == 0).then_some(nonce)
}

/// Whether the emulator's command line ends with `word` (`-semihosting-config …,arg=NAME,arg=WORD`).
#[must_use]
pub fn is_asked(word: &str) -> bool {
    let mut line = [0_u8; 64];
    let mut block = [line.as_mut_ptr().expose_provenance(), line.len()];
    // SAFETY: the parameter block as the call wants it: address and length of the buffer, which comes back as that of the line. Both
    // outlive the call, and the emulator writes within them.
    let failed = unsafe { syscall1(nr::GET_CMDLINE, block.as_mut_ptr().expose_provenance()) };
    failed == 0 && line.get(..block[1]).is_some_and(|line| line.ends_with(word.as_bytes()))
}

/// Ends the emulator, with status 0 if all went `well`, else with 1.
pub fn done(well: bool) -> ! {
    debug::exit(if well { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    halt()
}

/// Says why, and ends the emulator with status 1: what a panic and a fault do.
pub fn failed(why: &dyn core::fmt::Display) -> ! {
    cortex_m::interrupt::disable();
    hprintln!("{}", why);
    done(false)
}

fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

/// Defines what a program of this board does in a panic and in a fault.
#[macro_export]
macro_rules! ends_with_its_faults {
    () => {
        #[panic_handler]
        fn panicked(info: &core::panic::PanicInfo<'_>) -> ! {
            $crate::semihosting::failed(info)
        }

        // SAFETY: ends, and touches nothing on the way that the fault may have left half done but the debugger's port.
        #[cortex_m_rt::exception]
        unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
            $crate::semihosting::failed(&format_args!("hard fault: {frame:?}"))
        }
    };
}
