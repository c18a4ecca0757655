//! Ctrl-C, a request to terminate (SIGTERM) and a terminal that goes away (SIGHUP): the first ends a run in good order, the second is an
//! emergency stop, the third ends the program at once. A run that `nohup` has started goes on when its terminal goes away.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals as Caught;

use crate::run::orders::{Operator, Order, RunStatus};

/// Becomes true at the first.
pub static STOP: AtomicBool = AtomicBool::new(false);

/// How many have come.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// Watches for them from now on.
pub fn watch() {
    let hangup = (!is_hangup_ignored()).then_some(SIGHUP).into_iter();
    // Without a handler Ctrl-C ends the program at once, which is safe too: modules that hear nothing hold.
    let Ok(mut signals) = Caught::new(hangup.chain([SIGTERM, SIGINT])) else { return };
    std::thread::spawn(move || {
        for _ in signals.forever() {
            STOP.store(true, Ordering::Relaxed);
            if COUNT.fetch_add(1, Ordering::Relaxed) >= 2 {
                std::process::exit(130);
            }
        }
    });
}

/// Whether SIGHUP was ignored when the program began, as `nohup` has it: bit 0 of the mask that Linux shows.
fn is_hangup_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 != 0)
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
