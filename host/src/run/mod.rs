//! The main job: plan, dispatch, execute, observe, in a closed loop.
//!
//! | file | what |
//! |---|---|
//! | [`scenario`] | what is run, from a TOML file |
//! | [`roster`] | which modules a fleet has, from a TOML file |
//! | [`pilot`] | the host's closed loop; sans-IO |
//! | [`fleet`] | what executes: modules in this process, or processes on UDP |
//! | [`distances`] | the table that a planner may search by, from the user's cache |
//! | [`experiment`] | pilot, fleet and tank against the clock |
//! | [`progress`] | what a run reports while it goes on |
//! | [`recorder`] | what is measured meanwhile |
//! | [`summary`] | the figures of a run |
//! | [`compare`] | several planners on one scenario |
//! | [`vehicles`] | ROVs by name or from files |
//! | [`reconfigure`] | the same for ROVs that change their configuration |

use quantity::ParameterError;
use sim::module::ModuleError;
use thiserror::Error;

pub mod compare;
pub mod distances;
pub mod experiment;
pub mod fleet;
pub mod pilot;
pub mod progress;
pub mod reconfigure;
pub mod recorder;
pub mod roster;
pub mod scenario;
pub mod summary;
pub mod vehicles;

/// Why a run ended before its time.
#[derive(Debug, Error)]
pub enum RunError {
    /// Modules are not there, or not ready, and have not been for too long.
    #[error("{} within {waited_s} s{hint}", silent(modules))]
    Silent {
        /// Ids of the modules that are missing.
        modules: Vec<u16>,
        /// How long they were waited for, s.
        waited_s: f64,
        /// What may help.
        hint: String,
    },
    /// The radio itself failed.
    #[error(transparent)]
    Radio(#[from] link::udp::BrokenRadio),
    /// A module cannot be built.
    #[error("module {id}: {source}")]
    Module {
        /// Which one.
        id: u16,
        /// Why.
        source: ModuleError,
    },
    /// A number that cannot be.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

fn silent(modules: &[u16]) -> String {
    let ids: Vec<String> = modules.iter().map(u16::to_string).collect();
    match ids.as_slice() {
        [one] => format!("module {one} did not answer"),
        many => format!("modules {} did not answer", many.join(", ")),
    }
}
