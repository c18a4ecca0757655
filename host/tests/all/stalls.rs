//! Stalls of the machine: what swims in real time is judged again after one, and that is printed.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A pause of this process longer than this is a stall of the machine.
const STALL: Duration = Duration::from_millis(100);
/// Runs that fall into stalls are taken again so often.
pub const TRIES: u32 = 4;

/// The longest pause of a thread that sleeps for a millisecond at a time.
pub struct Stalls {
    longest_us: Arc<AtomicU64>,
    over: Arc<AtomicBool>,
}

impl Stalls {
    /// Watches from now on, until it is dropped.
    pub fn watch() -> Self {
        let (longest_us, over) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let (kept, ends) = (Arc::clone(&longest_us), Arc::clone(&over));
        std::thread::spawn(move || {
            let mut last = Instant::now();
            while !ends.load(Ordering::Relaxed) {
                sleep(Duration::from_millis(1));
                let now = Instant::now();
                kept.fetch_max((now - last).as_micros() as u64, Ordering::Relaxed);
                last = now;
            }
        });
        Self { longest_us, over }
    }

    fn longest(&self) -> Duration {
        Duration::from_micros(self.longest_us.load(Ordering::Relaxed))
    }

    /// Whether the machine stalled.
    pub fn excuse(&self) -> bool {
        self.longest() > STALL
    }
}

impl fmt::Display for Stalls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the machine stalled for {:?}", self.longest())
    }
}

impl Drop for Stalls {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
    }
}
