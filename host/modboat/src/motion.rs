//! Types that planner, dispatcher and plots share: a wrench, one module's swim cycle, one module's transition.

use serde::{Deserialize, Serialize};

use super::parameters::Parameters;

/// Forces along sway (x) and surge (y) and the yaw torque (counter-clockwise positive), structure frame S.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wrench {
    /// Sway force Fx, N.
    pub fx_n: f64,
    /// Surge force Fy, N.
    pub fy_n: f64,
    /// Yaw torque τ, N·m.
    pub tau_nm: f64,
}

impl Wrench {
    /// The three components as an array (N, N, N·m).
    #[must_use]
    pub const fn to_array(self) -> [f64; 3] {
        [self.fx_n, self.fy_n, self.tau_nm]
    }

    /// From three components (N, N, N·m).
    #[must_use]
    pub const fn from_array([fx_n, fy_n, tau_nm]: [f64; 3]) -> Self {
        Self { fx_n, fy_n, tau_nm }
    }

    /// ‖w ∘ F‖ with the weights w of (4); N.
    #[must_use]
    pub fn weighted_norm(self, weights: [f64; 3]) -> f64 {
        self.to_array().iter().zip(weights).map(|(f, w)| (f * w).powi(2)).sum::<f64>().sqrt()
    }
}

impl std::ops::Add for Wrench {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (a, b) = (self.to_array(), other.to_array());
        Self::from_array([a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    }
}

impl std::ops::Mul<f64> for Wrench {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::from_array(self.to_array().map(|component| factor * component))
    }
}

impl std::ops::Sub for Wrench {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        let (a, b) = (self.to_array(), other.to_array());
        Self::from_array([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
    }
}

/// One module's parameters of waveform (1): φ(t) = φ₀ + A·cos(2πt/T).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// Centerline φ₀, rad, counter-clockwise from sway axis x_S.
    pub centerline_rad: f64,
    /// Amplitude A, rad; its sign chooses the end at which the cycle starts. Zero: the tail rests at φ₀.
    pub amplitude_rad: f64,
}

impl Swing {
    /// The pose φ₀ + A at which the cycle starts and ends, rad.
    #[must_use]
    pub fn start_rad(self) -> f64 {
        self.centerline_rad + self.amplitude_rad
    }

    /// The mean wrench of one module at (x, y) m in S over one cycle:
    ///
    /// F = (−F(A)·cos φ₀, −F(A)·sin φ₀, −F(A)·sin φ₀·x + F(A)·cos φ₀·y)             (7)
    ///
    /// A resting module (A = 0) pushes nothing.
    #[must_use]
    pub fn wrench(self, parameters: &Parameters, [x_m, y_m]: [f64; 2]) -> Wrench {
        if self.amplitude_rad == 0.0 {
            return Wrench::default();
        }
        let thrust_n = parameters.thrust_n(self.amplitude_rad);
        let (sin, cos) = self.centerline_rad.sin_cos();
        Wrench {
            fx_n: -thrust_n * cos,
            fy_n: -thrust_n * sin,
            tau_nm: -thrust_n * sin * x_m + thrust_n * cos * y_m,
        }
    }
}

/// The mean wrench of the cycles of all modules at `positions_m` (7), each with its [`share`](Parameters::share) of law (2).
#[must_use]
pub fn wrench(cycle: &[Swing], parameters: &Parameters, positions_m: &[[f64; 2]]) -> Wrench {
    let each = cycle.iter().zip(positions_m).enumerate();
    each.fold(Wrench::default(), |sum, (place, (swing, &at))| {
        sum + swing.wrench(parameters, at) * parameters.share(place)
    })
}

/// Both ends of a swim cycle of two modules in their phase space (φᵢ, φⱼ).
#[must_use]
pub fn ends(i: Swing, j: Swing) -> [[f64; 2]; 2] {
    let far = |swing: Swing| swing.centerline_rad - swing.amplitude_rad;
    [[i.start_rad(), j.start_rad()], [far(i), far(j)]]
}

/// One module's rotation between two cycles, by the fleet's common law of time: from `from_rad` to `to_rad`, both unwrapped, so
/// that the sign of `to_rad − from_rad` is the direction (positive: counter-clockwise).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turn {
    /// Pose before, rad.
    pub from_rad: f64,
    /// Pose after, rad; ≡ φ₀ + A of the next cycle (mod 2π).
    pub to_rad: f64,
}

impl Turn {
    /// Signed rotation, rad.
    #[must_use]
    pub fn rotation_rad(self) -> f64 {
        self.to_rad - self.from_rad
    }
}

/// The times of one step of a transition.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepTime {
    /// All of it, s.
    pub duration_s: f64,
    /// Each of the two ramps from and to rest, s; zero at constant speed.
    pub ramp_s: f64,
}
