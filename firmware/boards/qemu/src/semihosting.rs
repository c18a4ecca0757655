//! Semihosting: the PC's random numbers, a line to its terminal, and an exit status (Arm IHI 0100).
//!
//! A real board draws its boot nonce from a generator of its own. This machine has none, so that of the PC serves.

use core::ffi::CStr;

use cortex_m_semihosting::{debug, hprintln, nr, syscall, syscall1};

/// Different from boot to boot, from the PC's `/dev/urandom`.
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

/// The number after `word` on the emulator's command line (`-semihosting-config …,arg=WORD,arg=NUMBER`).
#[must_use]
pub fn number_after(word: &str) -> Option<u32> {
    let mut line = [0_u8; 128];
    let mut block = [line.as_mut_ptr().expose_provenance(), line.len()];
    // SAFETY: the parameter block as the call wants it: address and length of the buffer, which comes back as that of the line. Both
    // outlive the call, and the emulator writes within them.
    let failed = unsafe { syscall1(nr::GET_CMDLINE, block.as_mut_ptr().expose_provenance()) };
    let line = line.get(..block[1]).filter(|_| failed == 0)?;
    let mut words = core::str::from_utf8(line).ok()?.trim_end_matches('\0').split(' ');
    words.find(|other| *other == word)?;
    words.next()?.parse().ok()
}

/// A file of the debugger's, or of the PC's where there is no debugger: its handle.
#[must_use]
pub fn open_to_write(path: &CStr) -> Option<usize> {
    // SAFETY: the parameter block as the call wants it: address of the path, mode, length without the zero. All outlive the call.
    let handle = unsafe { syscall(nr::OPEN, &[path.as_ptr().addr(), nr::open::W_TRUNC, path.count_bytes()]) };
    (handle != usize::MAX).then_some(handle)
}

/// Writes bytes to a file that is open; returns when that is done.
pub fn write(handle: usize, bytes: &[u8]) {
    // SAFETY: the parameter block as the call wants it: handle, address and length of the bytes. They outlive the call.
    unsafe { syscall(nr::WRITE, &[handle, bytes.as_ptr().expose_provenance(), bytes.len()]) };
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
