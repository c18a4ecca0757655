//! As many threads as the computer has cores, for searches that know of none.

use std::sync::atomic::{AtomicUsize, Ordering};

use rov::order::Workers;

/// See the module's documentation.
pub struct Threads(usize);

impl Threads {
    /// As many as there are cores.
    #[must_use]
    pub fn new() -> Self {
        Self(std::thread::available_parallelism().map_or(1, usize::from))
    }
}

impl Default for Threads {
    fn default() -> Self {
        Self::new()
    }
}

impl Workers for Threads {
    fn run(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let own = next.fetch_add(1, Ordering::Relaxed);
                if own >= jobs {
                    break;
                }
                job(own);
            }
        };
        let others = self.0.min(jobs).saturating_sub(1);
        std::thread::scope(|scope| {
            for _ in 0..others {
                scope.spawn(work);
            }
            work();
        });
    }
}
