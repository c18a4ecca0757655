//! Ctrl-C, a request to terminate (SIGTERM) and a terminal that goes away (SIGHUP): the first asks for an orderly end, the second is
//! the operating system's.

use std::sync::atomic::{AtomicBool, Ordering};

/// Becomes true at the first.
pub static STOP: AtomicBool = AtomicBool::new(false);

/// Watches for them from now on.
pub fn watch() {
    // Without a handler Ctrl-C ends the program at once, which is safe too: modules that hear nothing hold.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}
