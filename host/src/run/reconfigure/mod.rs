//! Reconfiguration of ROVs, executed: the plan, the fleet on a link, the water, and what came of it.
//!
//! | file | what |
//! |---|---|
//! | [`scenario`] | what is run, from a TOML file |
//! | [`conductor`] | which action, which thrusts: the host's closed loop |
//! | [`fleet`] | what executes: ROVs in this process, or processes on UDP |
//! | [`execution`] | conductor, fleet and water against the clock |
//! | [`accounts`] | what is measured meanwhile |
//! | [`summary`] | the figures of a run |

use rov::guidance::tracking::TrackingError;
use rov::power::PowerError;
use rov::propulsion::PropulsionError;
use sim::rov::RovError;
use sim::rov::basin::BasinError;
use thiserror::Error;

pub mod accounts;
pub mod conductor;
pub mod execution;
pub mod fleet;
pub mod scenario;
pub mod summary;

/// Why a plan is not executed, or not to its end.
#[derive(Debug, Error)]
pub enum ExecutionError {
    /// Robots are not there, or not ready.
    #[error("{} within {waited_s} s", silent(robots))]
    Silent {
        /// Ids of the robots that are missing.
        robots: Vec<u16>,
        /// How long they were waited for, s.
        waited_s: f64,
    },
    /// The plan is not one of this problem.
    #[error("the plan does not fit the problem: {0}")]
    Misfit(String),
    /// A robot cannot be built.
    #[error("robot {id}: {source}")]
    Rov {
        /// Which one.
        id: u16,
        /// Why.
        source: RovError,
    },
    /// The radio itself failed.
    #[error(transparent)]
    Radio(#[from] link::udp::BrokenRadio),
    /// The tracking controller refuses the robots or their states.
    #[error(transparent)]
    Tracking(#[from] TrackingError),
    /// It went wrong on the way.
    #[error(transparent)]
    Failed(#[from] conductor::Failure),
    /// They cannot be in water.
    #[error(transparent)]
    Basin(#[from] BasinError),
    /// Nothing is known of the thrusters at this voltage.
    #[error(transparent)]
    Power(#[from] PowerError),
    /// What it takes cannot be told.
    #[error(transparent)]
    Propulsion(#[from] PropulsionError),
}

fn silent(robots: &[u16]) -> String {
    let ids: Vec<String> = robots.iter().map(u16::to_string).collect();
    match ids.as_slice() {
        [one] => format!("robot {one} did not answer"),
        many => format!("robots {} did not answer", many.join(", ")),
    }
}
