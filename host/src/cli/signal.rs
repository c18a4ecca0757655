//! Ctrl-C, a request to terminate (SIGTERM) and a terminal that goes away (SIGHUP): the first ends a run in good order, the second is an
//! emergency stop, the third ends the program at once.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::run::orders::{Operator, Order, RunStatus};

/// Becomes true at the first.
pub static STOP: AtomicBool = AtomicBool::new(false);

/// How many have come.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// Watches for them from now on.
pub fn watch() {
    // Without a handler Ctrl-C ends the program at once, which is safe too: modules that hear nothing hold.
    let _ = ctrlc::set_handler(|| {
        STOP.store(true, Ordering::Relaxed);
        if COUNT.fetch_add(1, Ordering::Relaxed) >= 2 {
            std::process::exit(130);
        }
    });
}

/// The operator who sends signals.
#[derive(Debug, Default)]
pub struct Signals {
    followed: u32,
}

impl Operator for Signals {
    fn poll(&mut self, _: &dyn Fn() -> RunStatus) -> Option<Order> {
        if self.followed >= COUNT.load(Ordering::Relaxed) {
            return None;
        }
        self.followed += 1;
        Some(if self.followed == 1 { Order::End } else { Order::Stop })
    }
}
