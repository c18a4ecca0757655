//! Runs of many seeds on all cores, and numbers from the environment.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// A whole number from the environment, if it is set.
///
/// # Panics
/// If it is none.
#[must_use]
pub fn number(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} = {text:?}: must be a whole number")))
}

/// What `run` gives for each of `seeds`, in their order; on all cores.
///
/// # Panics
/// If `run` does.
pub fn on_all_cores<R: Send>(seeds: Range<u64>, run: impl Fn(u64) -> R + Sync) -> Vec<R> {
    let next = AtomicU64::new(seeds.start);
    let all: Mutex<Vec<(u64, R)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= seeds.end {
                        break;
                    }
                    let result = run(seed);
                    all.lock().expect("no panic with it").push((seed, result));
                }
            });
        }
    });
    let mut all = all.into_inner().expect("no panic with it");
    all.sort_by_key(|(seed, _)| *seed);
    all.into_iter().map(|(_, result)| result).collect()
}
