//! The table of distances to collision that a planner may be set to search by, from the user's cache.
//!
//! `[planner] distance = "table"` asks for it. It is generated once for each kind of module, on all cores, and kept in the
//! first of these folders that takes it:
//!
//! 1. `$XDG_CACHE_HOME/flotilla`, if that is an absolute path, or else `$HOME/.cache/flotilla`
//! 2. `flotilla` in the system's folder for temporary files
//!
//! If none does, the run has its table all the same, and the next one generates it again. Whatever a file says, the cycles
//! found by it are checked with the exact geometry.

use std::env;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use modboat::parameters::Parameters;
use modboat::planner_config::{DistanceSource, PlannerConfig};
use modboat::planner_kind::PlannerKind;
use modboat::table::Table;

use super::progress::Progress;

mod kept;

/// How often progress is reported.
const REPORT: Duration = Duration::from_millis(20);

/// The table that `config` asks for, if it does. Reports to `progress` while it takes.
pub fn table(
    parameters: &Parameters,
    config: &PlannerConfig,
    progress: &mut dyn Progress,
) -> Option<Arc<Table>> {
    if config.kind != PlannerKind::PotentialField || config.distance == DistanceSource::Direct {
        return None;
    }
    let (done, total) = (AtomicU64::new(0), AtomicU64::new(0));
    let count = |now: u64, all: u64| {
        total.store(all, Ordering::Relaxed);
        done.fetch_max(now, Ordering::Relaxed);
    };
    let (table, error) = thread::scope(|scope| {
        let work = scope.spawn(|| kept::load_or_generate(&folders(), parameters, &count));
        while !work.is_finished() {
            thread::sleep(REPORT);
            let total = total.load(Ordering::Relaxed);
            if total > 0 {
                progress.preparing("table of distances", done.load(Ordering::Relaxed), total);
            }
        }
        work.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    if let Some(error) = error {
        progress.note(&error.to_string());
    }
    Some(Arc::new(table))
}

/// Where tables are kept, first choice first.
fn folders() -> Vec<PathBuf> {
    let absolute = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")));
    cache.into_iter().chain([env::temp_dir()]).map(|folder| folder.join("flotilla")).collect()
}
