//! The main job: plan, dispatch, execute, observe, in a closed loop.
//!
//! | file | what |
//! |---|---|
//! | [`closed_loop`] | the loop of both fleets, and its seams |
//! | [`host`] | a controller and its dispatcher; sans-IO |
//! | [`fleet`] | what executes: modules in this process, or processes on UDP |
//! | `clock` | ticks, simulated or awaited |
//! | [`progress`], `reporter` | what a run reports while it goes on |
//! | [`scenario`], [`roster`] | what is run, and which modules a fleet has, from TOML files |
//! | [`pilot`] | the controller of Modboats |
//! | [`experiment`], [`boats`] | a run of Modboats, and what its loop is made of |
//! | [`pose_source`], `stream`, [`lab`], [`logged`] | where poses come from: the seam, frames of a motion capture, a structure in them, a log |
//! | [`orders`], [`steering`] | what an operator orders meanwhile, and targets among it |
//! | [`log`], [`summary`] | what is written meanwhile, and read again; its figures |
//! | [`watch`], [`hold`], [`shortfall`] | how much of the time modules took no part and the fleet held, and why; what a run was to do and did not |
//! | [`distances`] | the table that a planner may search by, from the user's cache |
//! | [`compare`] | several planners on one scenario |
//! | [`vehicles`] | ROVs by name or from files |
//! | [`reconfigure`] | a run of ROVs that change their configuration |

use link::strangers::Silence;
use quantity::ParameterError;
use sim::module::ModuleError;
use sim::rov::RovError;
use thiserror::Error;

pub mod boats;
pub(crate) mod clock;
pub mod closed_loop;
pub mod compare;
pub mod distances;
pub mod experiment;
pub mod fleet;
pub mod hold;
pub mod host;
pub mod identified;
pub mod identify;
pub mod lab;
mod leg_figures;
pub mod log;
pub mod logged;
pub mod orders;
pub mod pilot;
pub mod pose_source;
pub mod progress;
pub mod reconfigure;
mod reporter;
pub mod roster;
pub mod scenario;
pub mod shortfall;
pub mod steering;
mod stream;
pub mod summary;
pub mod vehicles;
pub mod watch;

/// Why a run ended before its time.
#[derive(Debug, Error)]
pub enum RunError {
    /// Modules are not there, or not ready, and have not been for too long.
    #[error("{}{hint}", silent(kind, modules, known, *waited_s))]
    Silent {
        /// What they are: modules, or robots.
        kind: &'static str,
        /// Ids of the modules that did not answer.
        modules: Vec<u16>,
        /// Ids of those of which something else is known, what, and in words.
        known: Vec<(u16, Silence, String)>,
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
    /// A robot cannot be built.
    #[error("robot {id}: {source}")]
    Rov {
        /// Which one.
        id: u16,
        /// Why.
        source: RovError,
    },
    /// A plan of ROVs is not executed.
    #[error(transparent)]
    Execution(#[from] reconfigure::ExecutionError),
    /// What was told of the run makes no sense.
    #[error("the log of this run: {0}")]
    Log(String),
    /// There are no poses, and waiting does not mend that.
    #[error("no poses: {0}")]
    Pose(String),
    /// A number that cannot be.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

fn silent(kind: &str, modules: &[u16], known: &[(u16, Silence, String)], waited_s: f64) -> String {
    let mut said: Vec<String> = known.iter().map(|(id, _, what)| format!("{kind} {id} {what}")).collect();
    let ids: Vec<String> = modules.iter().map(u16::to_string).collect();
    said.extend(match ids.as_slice() {
        [] => None,
        [one] => Some(format!("{kind} {one} did not answer within {waited_s} s")),
        many => Some(format!("{kind}s {} did not answer within {waited_s} s", many.join(", "))),
    });
    said.join("; ")
}
