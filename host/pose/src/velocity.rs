//! Velocities from fixes: a tracking filter for a rigid body, position and attitude.
//!
//! ```text
//! x⁻ = x + v·T + a·T²/2      v⁻ = v + a·T      r = z − x⁻
//! x = x⁻ + g·r               v = v⁻ + h·r/T    a = a⁻ + 2·k·r/T²
//! g = 1 − θ³                 h = 3/2·(1−θ)²·(1+θ)                 k = (1−θ)³/2,    θ = e^(−ω·T)
//! ```
//!
//! The fading-memory filter of second degree (Brookner, *Tracking and Kalman Filtering Made Easy*, 1998, table 1.7-1): all three
//! poles at θ, critically damped, no lag of the velocity under constant acceleration. ω is its bandwidth. At first its gains are those
//! of the least-squares parabola through all fixes so far (growing memory, the same book, table 1.7-2), until they fall to the
//! fading ones; [`Tracker::is_settled`] says so.
//!
//! For the attitude r is the rotation vector from the predicted attitude to the seen one, in the body's axes, and the prediction
//! turns about the body's rates: the same law on SO(3), exact for a steady turn and for small errors.
//!
//! | symbol | what | unit |
//! |---|---|---|
//! | z | fix: position in the frame, attitude of the body | m, – |
//! | v | velocity in the frame; rates in the body's axes | m/s, rad/s |
//! | T | time between two fixes, as it comes | s |
//! | ω | bandwidth | rad/s |
//!
//! Assumed and limits: white noise σ of positions at a steady rate gives a noise of the velocity of
//! σ/T·√((1−θ)³·(49+50θ+13θ²)/(2·(1+θ)⁵)): 9 mm/s for 2 mm at 100 Hz and 10 rad/s. A jerk j leaves 3·j/ω³ in the position.

use nalgebra::{UnitQuaternion, Vector3};

use crate::axes::Pose;

/// Without a fix for this time what was known of the motion is forgotten, s. *Assumed.*
const FORGET_AFTER_S: f64 = 1.0;
/// Fixes closer together are one, s: their difference would say nothing of velocity.
const SHORTEST_S: f64 = 1e-4;

/// Gains of one fix.
#[derive(Clone, Copy, Debug)]
struct Gains {
    g: f64,
    h: f64,
    k: f64,
    /// Whether they are the fading ones.
    settled: bool,
}

/// What is known of a body's motion at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// When, s on the host's clock.
    pub at_s: f64,
    /// Where and how turned.
    pub pose: Pose,
    /// Velocity in the frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Rates in the body's axes, rad/s.
    pub rates_rad_s: Vector3<f64>,
}

/// The filter of one body.
#[derive(Clone, Debug)]
pub struct Tracker {
    bandwidth_rad_s: f64,
    motion: Option<Motion>,
    acceleration_m_s2: Vector3<f64>,
    angular_acceleration_rad_s2: Vector3<f64>,
    /// Fixes since it began.
    fixes: u32,
    settled: bool,
}

impl Tracker {
    /// A filter that knows nothing yet.
    pub fn new(bandwidth_rad_s: f64) -> Self {
        Self {
            bandwidth_rad_s,
            motion: None,
            acceleration_m_s2: Vector3::zeros(),
            angular_acceleration_rad_s2: Vector3::zeros(),
            fixes: 0,
            settled: false,
        }
    }

    /// Whether it has seen as much as its bandwidth asks for.
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// Forgets all: the body was carried, or is another one.
    pub fn reset(&mut self) {
        *self = Self::new(self.bandwidth_rad_s);
    }

    /// Takes a fix captured at `at_s`; one that is not newer than the last is left aside.
    pub fn take(&mut self, at_s: f64, seen: &Pose) {
        let step_s = self.motion.map_or(f64::INFINITY, |motion| at_s - motion.at_s);
        if step_s < SHORTEST_S {
            return;
        }
        let Some(predicted) = self.at(at_s).filter(|_| step_s <= FORGET_AFTER_S) else {
            self.reset();
            let still = Vector3::zeros();
            self.motion = Some(Motion { at_s, pose: *seen, velocity_m_s: still, rates_rad_s: still });
            return;
        };
        self.fixes = self.fixes.saturating_add(1);
        let Gains { g, h, k, settled } = self.gains(step_s);
        self.settled = settled;
        let moved = seen.position - predicted.pose.position;
        let turned = (predicted.pose.attitude.inverse() * seen.attitude).scaled_axis();
        self.acceleration_m_s2 += moved * (2.0 * k / step_s.powi(2));
        self.angular_acceleration_rad_s2 += turned * (2.0 * k / step_s.powi(2));
        self.motion = Some(Motion {
            at_s,
            pose: Pose {
                position: predicted.pose.position + moved * g,
                attitude: predicted.pose.attitude * UnitQuaternion::from_scaled_axis(turned * g),
            },
            velocity_m_s: predicted.velocity_m_s + moved * (h / step_s),
            rates_rad_s: predicted.rates_rad_s + turned * (h / step_s),
        });
    }

    fn gains(&self, step_s: f64) -> Gains {
        let theta = (-self.bandwidth_rad_s * step_s).exp();
        let left = 1.0 - theta;
        let fading = Gains {
            g: 1.0 - theta.powi(3),
            h: 1.5 * left.powi(2) * (1.0 + theta),
            k: 0.5 * left.powi(3),
            settled: true,
        };
        let n = f64::from(self.fixes);
        let below = (n + 1.0) * (n + 2.0) * (n + 3.0);
        let growing = Gains {
            g: 3.0 * (3.0 * n * n + 3.0 * n + 2.0) / below,
            h: 18.0 * (2.0 * n + 1.0) / below,
            k: 30.0 / below,
            settled: false,
        };
        match self.fixes {
            // Two fixes make a line.
            1 => Gains { g: 1.0, h: 1.0, k: 0.0, settled: false },
            _ if growing.g > fading.g => growing,
            _ => fading,
        }
    }

    /// The motion at another moment, carried on from the newest fix; `None` before the first.
    pub fn at(&self, at_s: f64) -> Option<Motion> {
        let motion = self.motion?;
        let step_s = at_s - motion.at_s;
        let half = step_s.powi(2) / 2.0;
        let turned = motion.rates_rad_s * step_s + self.angular_acceleration_rad_s2 * half;
        Some(Motion {
            at_s,
            pose: Pose {
                position: motion.pose.position + motion.velocity_m_s * step_s + self.acceleration_m_s2 * half,
                attitude: motion.pose.attitude * UnitQuaternion::from_scaled_axis(turned),
            },
            velocity_m_s: motion.velocity_m_s + self.acceleration_m_s2 * step_s,
            rates_rad_s: motion.rates_rad_s + self.angular_acceleration_rad_s2 * step_s,
        })
    }
}
