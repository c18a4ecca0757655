//! Observation and action of an environment: order, units, frames and bounds.
//!
//! Observation, f64. S is the structure's frame: x sway (right), y surge (forward); Θ the heading of the surge axis.
//!
//! | place | what | unit |
//! |---|---|---|
//! | 0, 1 | station less position, in S; zero where a velocity is asked for | m |
//! | 2, 3 | velocity asked for, in S; zero where a station is | m/s |
//! | 4, 5 | mean velocity over ground since the last decision, in S as it is turned now | m/s |
//! | 6, 7 | sin and cos of the heading asked for less Θ | |
//! | 8 | mean yaw rate since the last decision, counter-clockwise | rad/s |
//! | 9, 10, 11 | mean wrench (F_x, F_y, τ) in S of the cycle that runs, by (7) | N, N, N·m |
//! | 12 + 2i, 13 + 2i | sin and cos of where the tail of module i will rest when that cycle ends, from the sway axis | |
//!
//! Means, and not what is at the instant: within a cycle tails swing the structure to and fro.
//!
//! Action `swing`, f64, three numbers a module:
//!
//! | place | what | unit |
//! |---|---|---|
//! | 3i | centreline φ₀ of waveform (1), counter-clockwise from the sway axis; −π to π | rad |
//! | 3i + 1 | amplitude A; its sign chooses the end at which the swing starts; −A_max to A_max | rad |
//! | 3i + 2 | way of the turn to φ₀ + A: below −½ clockwise, above ½ counter-clockwise, else the shorter; −1 to 1 | |
//!
//! |A| below half of the least amplitude is none: the tail turns to φ₀ and rests there. |A| below the least is the least. Numbers beyond
//! their bounds are taken for the bound; centrelines are angles, and wrapped.
//!
//! Action `wrench`: F_x, F_y in N and τ in N·m, in S, up to the greatest that all modules give together.

use std::f64::consts::PI;
use std::sync::Arc;

use host::run::scenario::Scenario;
use modboat::distance::DistanceToCollision;
use modboat::envelope::Envelope;

use crate::settings::{ActionKind, Settings};

/// Numbers of an observation before those of the tails.
pub const SHARED: usize = 12;
/// Numbers of an action for each module.
pub const PER_MODULE: usize = 3;

/// What [`Info`] is called by, in its order.
pub const INFO: [&str; 7] = ["time_s", "interval_s", "x_m", "y_m", "heading_rad", "contacts", "is_stuck"];

/// What is told of one environment beside observation and reward; names with units in [`INFO`]. Time counts from the start of the
/// first cycle of the episode; the pose is the true one in the world, the heading unwrapped; contacts are those of the step; stuck is
/// one where a module took no cycle any more.
pub type Info = [f64; INFO.len()];

/// Sizes and bounds, and where tails meet: the same in all environments of a batch.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Modules of the structure.
    pub modules: usize,
    /// Their centres in S, m.
    pub positions_m: Vec<[f64; 2]>,
    /// Docked pairs along sway and along surge: (left, right), (behind, ahead).
    pub neighbours: [Vec<(usize, usize)>; 2],
    /// Where tails meet.
    pub distance: Arc<DistanceToCollision>,
    /// Numbers of an observation.
    pub observation: usize,
    /// Least of each number of an action.
    pub action_low: Vec<f64>,
    /// Greatest of each number of an action.
    pub action_high: Vec<f64>,
}

impl Layout {
    /// Of these settings.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let Scenario { structure, modboat, .. } = &settings.scenario;
        let modules = structure.len();
        let positions_m = structure.positions_m(modboat.pitch_m);
        let action_high: Vec<f64> = match settings.action {
            ActionKind::Swing => [PI, modboat.amplitude_max_rad, 1.0].repeat(modules),
            ActionKind::Wrench => {
                let envelope = Envelope::new(&positions_m, modboat);
                let mut most = [0.0; 3];
                for (axis, most) in most.iter_mut().enumerate() {
                    let mut normal = [0.0; 3];
                    normal[axis] = 1.0;
                    *most = envelope.support(normal);
                }
                most.to_vec()
            }
        };
        Self {
            modules,
            neighbours: [[1, 0], [0, 1]].map(|offset| structure.neighbours(offset).collect()),
            positions_m,
            distance: Arc::new(DistanceToCollision::new(modboat)),
            observation: SHARED + 2 * modules,
            action_low: action_high.iter().map(|high| -high).collect(),
            action_high,
        }
    }

    /// Numbers of an action.
    #[must_use]
    pub fn action(&self) -> usize {
        self.action_high.len()
    }
}

/// (x, y) in the world → S, by sin and cos of Θ: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
pub(crate) fn in_structure((sin, cos): (f64, f64), [x, y]: [f64; 2]) -> [f64; 2] {
    [sin * x - cos * y, cos * x + sin * y]
}
