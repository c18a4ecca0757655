//! The constants that are looked for, as one vector θ.
//!
//! | θ | what | unit | in θ as |
//! |---|---|---|---|
//! | M_u, M_v, M_w | mass with the water that moves along: surge, sway, heave | kg | ln |
//! | M_r | moment of inertia about the downward axis, with water | kg·m² | ln |
//! | D1_u … D1_r | linear damping: surge, sway, heave, yaw | N/(m/s), N·m/(rad/s) | ln |
//! | D2_u … D2_r | quadratic damping at unit speed | N/(m/s)², N·m/(rad/s)² | ln |
//! | W | weight in water | N | W / [`WEIGHT_UNIT`] |
//! | σ_h, σ_d, σ_ψ | noise of a pose: north and east, down, yaw | m, m, rad | ln |
//! | q_h, q_w, q_r | accelerations that nothing explains, white | m/s²/√Hz, rad/s²/√Hz | ln |
//! | κᵢ | what thruster i gives over what it should | 1 | ln |
//! | c_n, c_e | mean current, of each log | m/s | c / [`CURRENT_UNIT`] |
//! | δ | by how much the water feels thrusts later than they are stamped, less the latency of poses; of each log | s | δ / [`DELAY_UNIT`] |
//!
//! Each has a weak prior about the belief, as those of a Modboat have.

use reconfiguration::vehicle::Vehicle;

/// Surge, sway, heave, yaw among the six axes of a body.
pub(crate) const AXES: [usize; 4] = [0, 1, 2, 5];
/// Their names.
pub(crate) const AXIS_NAMES: [&str; 4] = ["surge", "sway", "heave", "yaw"];

pub(crate) const MASS: [usize; 4] = [0, 1, 2, 3];
pub(crate) const LINEAR: [usize; 4] = [4, 5, 6, 7];
pub(crate) const QUADRATIC: [usize; 4] = [8, 9, 10, 11];
pub(crate) const WEIGHT: usize = 12;
const NOISE: [usize; 3] = [13, 14, 15];
const PUSH: [usize; 3] = [16, 17, 18];
const FIXED: usize = 19;

/// Unit of the weight in water in θ, N.
pub(crate) const WEIGHT_UNIT: f64 = 5.0;
/// Unit of currents in θ, m/s.
pub(crate) const CURRENT_UNIT: f64 = 0.05;
/// Unit of delays in θ, s.
pub(crate) const DELAY_UNIT: f64 = 0.1;

/// Speed at which a damping that a vehicle does not have in one form is taken from the other, m/s and rad/s. *Assumed*.
const TYPICAL: f64 = 0.2;
/// The share of it that then counts as a belief. *Assumed*.
const LITTLE: f64 = 0.1;
/// No pose is better than this, m and rad. *Assumed*: exact poses of a simulation have noise too, or nothing could be weighed.
const LEAST_NOISE: f64 = 2e-5;

/// Which element of θ is what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub thrusters: usize,
    pub logs: usize,
}

impl Layout {
    pub(crate) const fn len(self) -> usize {
        FIXED + self.thrusters + 3 * self.logs
    }

    pub(crate) const fn gain(self, thruster: usize) -> usize {
        FIXED + thruster
    }

    pub(crate) const fn current(self, log: usize, axis: usize) -> usize {
        FIXED + self.thrusters + 3 * log + axis
    }

    pub(crate) const fn delay(self, log: usize) -> usize {
        self.current(log, 2)
    }

    pub(crate) const fn log_of(self, index: usize) -> Option<usize> {
        let own = FIXED + self.thrusters;
        if index < own { None } else { Some((index - own) / 3) }
    }

    pub(crate) const fn is_noise(index: usize) -> bool {
        index >= NOISE[0] && index < FIXED
    }

    /// Short name, for correlations and directions that are not told apart.
    pub(crate) fn name(self, index: usize) -> String {
        let own = FIXED + self.thrusters;
        match index {
            WEIGHT => "weight in water".to_owned(),
            0..WEIGHT => {
                let what = ["mass", "linear damping", "quadratic damping"][index / 4];
                format!("{what} {}", AXIS_NAMES[index % 4])
            }
            _ if Self::is_noise(index) => format!("noise {}", index - NOISE[0]),
            _ if index < own => format!("thruster {}", index - FIXED + 1),
            _ => {
                let what = ["current north", "current east", "delay of thrusts"][(index - own) % 3];
                if self.logs > 1 { format!("{what}, log {}", (index - own) / 3 + 1) } else { what.to_owned() }
            }
        }
    }

    /// θ where the search begins, and the deviation of each element's prior.
    pub(crate) fn prior(self, vehicle: &Vehicle) -> (Vec<f64>, Vec<f64>) {
        let body = &vehicle.body;
        let mut theta = vec![0.0; self.len()];
        let mut deviation = vec![1.0; self.len()];
        for (place, &axis) in AXES.iter().enumerate() {
            theta[MASS[place]] = believed_mass(vehicle, axis).ln();
            let (linear, quadratic) = (body.linear_damping[axis], body.quadratic_damping[axis]);
            let floor = |other: f64| (LITTLE * other).max(1e-3);
            theta[LINEAR[place]] = linear.max(floor(TYPICAL * quadratic)).ln();
            theta[QUADRATIC[place]] = quadratic.max(floor(linear / TYPICAL)).ln();
            // What a vehicle file leaves out is no belief.
            for (index, value) in [(LINEAR[place], linear), (QUADRATIC[place], quadratic)] {
                deviation[index] = if value > 0.0 { 1.0 } else { 2.0 };
            }
        }
        theta[WEIGHT] = (body.weight_n - body.buoyancy_n) / WEIGHT_UNIT;
        for (index, value) in
            NOISE.into_iter().zip([2e-3, 2e-3, 5e-3]).chain(PUSH.into_iter().zip([3e-3, 3e-3, 6e-3]))
        {
            (theta[index], deviation[index]) = (f64::ln(value), 3.0);
        }
        // Thrusters of one make differ by some percent; one that is clogged gives half.
        (0..self.thrusters).for_each(|thruster| deviation[self.gain(thruster)] = 0.5);
        for log in 0..self.logs {
            (0..3).for_each(|own| deviation[self.current(log, own)] = 3.0);
        }
        (theta, deviation)
    }
}

/// Mass or moment of inertia about the body's origin with the water that moves along, of one of six axes.
pub(crate) fn believed_mass(vehicle: &Vehicle, axis: usize) -> f64 {
    let body = &vehicle.body;
    if axis < 3 {
        return body.mass_kg + body.added_mass[axis];
    }
    // Steiner: from the centre of gravity to the origin.
    let [x, y, _] = body.r_g_m;
    body.inertia_kg_m2[axis - 3] + body.mass_kg * (x * x + y * y) + body.added_mass[axis]
}

/// θ in units, for one log.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    pub mass: [f64; 4],
    pub linear: [f64; 4],
    pub quadratic: [f64; 4],
    pub weight_n: f64,
    pub noise: [f64; 4],
    pub push: [f64; 4],
    pub gain: Vec<f64>,
    pub current_m_s: [f64; 2],
}

impl Values {
    pub(crate) fn new(theta: &[f64], layout: Layout, log: usize) -> Self {
        let of = |index: usize| theta[index].exp();
        let [h, d, yaw] = NOISE.map(|index| of(index).hypot(LEAST_NOISE));
        let [push, heave, twist] = PUSH.map(of);
        Self {
            mass: MASS.map(of),
            linear: LINEAR.map(of),
            quadratic: QUADRATIC.map(of),
            weight_n: WEIGHT_UNIT * theta[WEIGHT],
            noise: [h, h, d, yaw],
            push: [push, push, heave, twist],
            gain: (0..layout.thrusters).map(|thruster| of(layout.gain(thruster))).collect(),
            current_m_s: [0, 1].map(|axis| CURRENT_UNIT * theta[layout.current(log, axis)]),
        }
    }
}
