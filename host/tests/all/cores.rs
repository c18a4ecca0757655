//! Who may take the cores of this machine: tests that swim in real time, or tests that compute.

use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// The cores of this machine. What swims in real time in processes of its own has to be given them in time.
static CORES: RwLock<()> = RwLock::new(());

/// Held while something swims in real time: beside it nothing takes all cores.
pub fn in_real_time() -> RwLockReadGuard<'static, ()> {
    CORES.read().unwrap_or_else(PoisonError::into_inner)
}

/// Held by what takes all cores: it waits until nothing swims in real time.
pub fn all_cores() -> RwLockWriteGuard<'static, ()> {
    CORES.write().unwrap_or_else(PoisonError::into_inner)
}
