//! What was identified of one kind of ROV, and how well.

use serde::Serialize;

use super::super::outcome::{Constant, Indistinct, Residuals};

/// What the scale of all forces, masses and dampings rests on. Poses show ratios of them only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Thrusters give on average what their law says, those that push up and down alone by themselves.
    #[default]
    Thrust,
    /// The mass with the water that moves along is as the vehicle file has it, in surge and in heave.
    Mass,
}

/// One thruster of the kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Thruster {
    /// Its number, from 1.
    pub number: usize,
    /// What it gives over what its law says.
    pub gain: Constant,
}

/// Velocities over a short span: surge, sway, heave, m/s, yaw, rad/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Foretold {
    /// Middle of the span, s.
    pub t_s: f64,
    /// As measured.
    pub measured: [f64; 4],
    /// As predicted.
    pub predicted: [f64; 4],
    /// From which start, from 0.
    pub start: usize,
}

/// How well the future was foretold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Prediction {
    /// How far ahead, s.
    pub horizon_s: f64,
    /// Data that constants were not fitted to, s.
    pub held_back_s: f64,
    /// Predictions that were made.
    pub starts: usize,
    /// Root mean square of the velocity that was measured there, m/s.
    pub speed_rms_m_s: f64,
    /// That of its error, m/s.
    pub velocity_error_rms_m_s: f64,
    /// The second over the first; `None` where none was made.
    pub velocity_error: Option<f64>,
    /// Root mean square of the yaw rate that was measured, rad/s.
    pub yaw_rate_rms_rad_s: f64,
    /// That of its error, rad/s.
    pub yaw_rate_error_rms_rad_s: f64,
}

/// Everything of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The vehicle's name.
    pub vehicle: String,
    /// The robots of that kind that swam.
    pub robots: Vec<u16>,
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Swims that were used.
    pub swims: usize,
    /// Length of all, s.
    pub duration_s: f64,
    /// Poses that were used.
    pub fixes: usize,
    /// What the scale rests on.
    pub scale: Scale,
    /// In a sentence.
    pub scale_text: String,
    /// Constants of the vehicle and the water.
    pub constants: Vec<Constant>,
    /// Thrusters in the order of the vehicle.
    pub thrusters: Vec<Thruster>,
    /// What is not told apart.
    pub indistinct: Vec<Indistinct>,
    /// Names of rows and columns of `correlations`.
    pub correlated: Vec<String>,
    /// Correlations of estimates.
    pub correlations: Vec<Vec<f64>>,
    /// What constants that were fitted to the first part of the logs foretell of the rest.
    pub prediction: Prediction,
    /// One bin ahead.
    pub residuals: Residuals,
    /// Steps of the search.
    pub steps: usize,
    /// Whether it ended by itself.
    pub converged: bool,
    /// What is worth a person's attention.
    pub notes: Vec<String>,
    /// For pictures: predictions over the held-back data.
    #[serde(skip)]
    pub foretold: Vec<Foretold>,
    /// For pictures: time, s, and prediction errors one bin ahead of north, east, down (m), yaw (rad).
    #[serde(skip)]
    pub errors: Vec<(f64, [f64; 4])>,
}

impl Outcome {
    /// The constant of that name.
    #[must_use]
    pub fn constant(&self, name: &str) -> Option<&Constant> {
        self.constants.iter().find(|constant| constant.name == name)
    }
}
