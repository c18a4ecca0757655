//! What constants are identified from: measured poses, reported tail angles, planned cycles and battery voltages of runs.

use modboat::motion::Swing;
use modboat::observer::Fix;
use modboat::parameters::Parameters;
use modboat::structure::Structure;

/// One set of tail angles as modules reported them.
#[derive(Clone, Debug, PartialEq)]
pub struct Tails {
    /// When, fleet time, s.
    pub t_s: f64,
    /// Angle of each tail from the sway axis, counter-clockwise, unwrapped, rad.
    pub angle_rad: Vec<f64>,
    /// Its speed, rad/s.
    pub rate_rad_s: Vec<f64>,
}

/// One swim cycle as it was planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Start of waveform (1), fleet time, s.
    pub start_s: f64,
    /// Its period, s.
    pub period_s: f64,
    /// Of each module; amplitude zero where it rests.
    pub swings: Vec<Swing>,
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// What it is called in messages.
    pub name: String,
    /// Measured poses in the order of their times; a heading is in (−π, π].
    pub fixes: Vec<Fix>,
    /// Tail angles in the order of their times.
    pub tails: Vec<Tails>,
    /// Planned cycles in order.
    pub cycles: Vec<Cycle>,
    /// Spans of which nothing is known, fleet time, s.
    pub gaps: Vec<[f64; 2]>,
    /// Mean battery voltage of all modules, where it was measured, V.
    pub battery_v: Option<f64>,
}

/// What is taken as known of the structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Boat {
    /// Its shape.
    pub structure: Structure,
    /// The numbers of its modules by place.
    pub ids: Vec<u16>,
    /// What is believed: geometry and period are taken as they are, the rest is where the search begins.
    pub belief: Parameters,
    /// Moment of inertia J of rotor and tail about the motor axis, kg·m².
    pub rotor_inertia_kg_m2: f64,
}

impl Boat {
    /// Number of modules.
    #[must_use]
    pub fn modules(&self) -> usize {
        self.structure.len()
    }
}
