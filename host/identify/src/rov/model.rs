//! Motion of an ROV whose tilt is measured, as the filter predicts it.
//!
//! With v = (u, v, w) the velocity through water that drifts with the current c and ω = (p, q, r), both in the body frame:
//!
//! ```text
//! M·v̇   = F + W·Rᵀẑ − (D1 + D2·q)·v − ω × (M·v),     M = diag(M_u, M_v, M_w)                        (i16)
//! M_r·ṙ = N − (D1_r + D2_r·q)·r − (M_v − M_u)·u·v                                                  (i17)
//! (ṅ, ė, ḋ) = R·v + c,     ψ̇ = (q·sin φ + r·cos φ)/cos θ                                            (i18)
//! (F, N) = Σ κᵢ·Tᵢ·Fᵢ                                                                              (i19)
//! ```
//!
//! (6)–(8) with M = M_RB + M_A and the centre of gravity on the body's vertical axis. Roll φ, pitch θ, p and q are taken as measured: they
//! are inputs, as thrusts are. q·r in the drag stands for (i7), the mean of r|r|. Tᵢ is the column of thruster i in the configuration matrix
//! (16), less its rows of roll and pitch.
//!
//! Assumptions: p·q·(I_y − I_x) is left out of (i17); no gusts with a memory: what the water does beside a steady current is white
//! acceleration.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::super::filter::{Motion, Square, State, propagate, squared};
use super::constants::Values;
use super::data::Tilt;

/// Where a swim begins: deviation of each velocity, m/s and rad/s. *Assumed*: it has just let go.
const BEGINS: f64 = 0.1;

/// A swim under its thrusts. States: north, east, down (m), ψ (rad), u, v, w (m/s), r (rad/s).
pub(crate) struct Swimming<'a> {
    pub values: &'a Values,
    /// Wrench of each thruster at 1 N: surge, sway, heave, N, yaw, N·m.
    pub columns: &'a [[f64; 4]],
    /// Mean thrusts over both halves of the time to each bin, see [`Prepared::halves`](super::data::Prepared::halves).
    pub halves_n: &'a [f64],
    /// In the middle of each half.
    pub tilts: &'a [[Tilt; 2]],
}

/// What pushes over half the time to a bin: surge, sway, heave, N, yaw, N·m; and how the robot is tilted meanwhile.
type Push = ([f64; 4], Tilt);

impl Swimming<'_> {
    fn wrench(&self, thrusts_n: &[f64]) -> [f64; 4] {
        let mut wrench = [0.0; 4];
        for ((column, gain), thrust_n) in self.columns.iter().zip(&self.values.gain).zip(thrusts_n) {
            wrench.iter_mut().zip(column).for_each(|(sum, part)| *sum += part * gain * thrust_n);
        }
        wrench
    }

    /// Rates of change and their derivatives by the state.
    fn rates(&self, state: &State, (wrench, tilt): Push, spread: [f64; 4]) -> (State, Square) {
        let Values { mass, linear, quadratic, weight_n, current_m_s, .. } = self.values;
        let Tilt { roll_rad, pitch_rad, rates_rad_s: [p, q] } = tilt;
        let (v, omega) = (Vector3::new(state[4], state[5], state[6]), Vector3::new(p, q, state[7]));
        let turn = *Rotation3::from_euler_angles(roll_rad, pitch_rad, state[3]).matrix();
        let (mut rate, mut by) = (State::zeros(), Square::zeros());
        // (ṅ, ė, ḋ) = R·v + c,   ψ̇ = (q·sin φ + r·cos φ)/cos θ                                       (i18)
        let way = turn * v;
        let yaw = [roll_rad.sin() / pitch_rad.cos(), roll_rad.cos() / pitch_rad.cos()];
        (rate[0], rate[1], rate[2]) = (way.x + current_m_s[0], way.y + current_m_s[1], way.z);
        rate[3] = yaw[0] * q + yaw[1] * omega.z;
        (by[(0, 3)], by[(1, 3)], by[(3, 7)]) = (-way.y, way.x, yaw[1]);
        by.fixed_view_mut::<3, 3>(0, 4).copy_from(&turn);
        // M·v̇ = F + W·Rᵀẑ − (D1 + D2·q)·v − ω × (M·v)                                              (i16)
        let masses = Matrix3::from_diagonal(&Vector3::new(mass[0], mass[1], mass[2]));
        let momentum = masses * v;
        let weight = turn.row(2) * *weight_n;
        let coupled = momentum.cross(&omega);
        let munk = (mass[1] - mass[0]) * v.x * v.y;
        let coupled = [coupled.x + weight[0], coupled.y + weight[1], coupled.z + weight[2], -munk];
        let by_v = -omega.cross_matrix() * masses;
        for axis in 0..4 {
            let (q, dq) = squared(state[4 + axis], spread[axis]);
            let drag = linear[axis] * state[4 + axis] + quadratic[axis] * q;
            rate[4 + axis] = (wrench[axis] - drag + coupled[axis]) / mass[axis];
            if axis < 3 {
                (0..3).for_each(|other| by[(4 + axis, 4 + other)] = by_v[(axis, other)] / mass[axis]);
            }
            by[(4 + axis, 4 + axis)] -= (linear[axis] + quadratic[axis] * dq) / mass[axis];
        }
        // ∂(M·v × ω)/∂r
        (by[(4, 7)], by[(5, 7)]) = (momentum.y / mass[0], -momentum.x / mass[1]);
        let munk = (mass[1] - mass[0]) / mass[3];
        (by[(7, 4)], by[(7, 5)]) = (-munk * v.y, -munk * v.x);
        (rate, by)
    }
}

impl Motion<4> for Swimming<'_> {
    type Force = Push;

    /// At rest over ground.
    fn begin(&self, pose: [f64; 4]) -> State {
        let (sin, cos) = pose[3].sin_cos();
        let [north, east] = self.values.current_m_s;
        let [n, e, d, yaw] = pose;
        State::from([n, e, d, yaw, -(cos * north + sin * east), sin * north - cos * east, 0.0, 0.0])
    }

    fn begins(&self) -> State {
        State::from([0.0, 0.0, 0.0, 0.0, BEGINS, BEGINS, BEGINS, BEGINS])
    }

    fn noise(&self) -> [f64; 4] {
        self.values.noise
    }

    fn halves(&self, index: usize, _: f64) -> [Push; 2] {
        let thrusters = self.columns.len();
        let own = self.halves_n.get(2 * thrusters * index..2 * thrusters * (index + 1)).unwrap_or_default();
        let (first, second) = own.split_at(own.len() / 2);
        let tilts = self.tilts.get(index).copied().unwrap_or_default();
        [(self.wrench(first), tilts[0]), (self.wrench(second), tilts[1])]
    }

    fn step(&self, state: &State, covariance: Option<&mut Square>, halves: [Push; 2], dt_s: f64) -> State {
        let spread = covariance.as_deref().map_or([0.0; 4], |p| [4, 5, 6, 7].map(|at| p[(at, at)].max(0.0)));
        let fresh = || {
            let of = |axis: usize| (4 + axis, self.values.push[axis].powi(2) * dt_s);
            [of(0), of(1), of(2), of(3), (0, 0.0)]
        };
        propagate(state, covariance, halves, dt_s, |at, force| self.rates(at, force, spread), fresh)
    }
}
