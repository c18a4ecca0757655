//! Reconfiguration of ROVs, executed: the plan, the fleet on a link, the water, and what came of it.
//!
//! | file | what |
//! |---|---|
//! | [`scenario`] | what is run, from a TOML file |
//! | [`conductor`] | which action, which thrusts |
//! | [`controller`] | the controller of the closed loop: who answers, when the plan begins, what is sent |
//! | [`poses`], [`estimator`] | bodies as a motion capture sees them, and what their states are by that |
//! | [`water`] | the water and the poses in it |
//! | [`accounts`] | what is measured meanwhile; the [log](super::log::rovs) takes it down |
//! | [`execution`] | a run |
//! | [`summary`], [`phases`] | its figures; where its energy went |

use rov::guidance::tracking::TrackingError;
use rov::power::PowerError;
use rov::propulsion::PropulsionError;
use sim::rov::basin::BasinError;
use thiserror::Error;

pub mod accounts;
pub mod conductor;
pub mod controller;
pub mod estimator;
pub mod execution;
pub mod phases;
pub mod poses;
pub mod scenario;
pub mod summary;
pub mod water;

/// Why a plan is not executed, or not to its end.
#[derive(Debug, Error)]
pub enum ExecutionError {
    /// The plan is not one of this problem.
    #[error("the plan does not fit the problem: {0}")]
    Misfit(String),
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
