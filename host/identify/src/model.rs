//! Motion of the structure in the water, as the filter predicts it.
//!
//! With w the velocity in a frame that the mean current c carries along and g the gust, both in S, r = w − g:
//!
//! ```text
//! M_x·ẇ_x = F_x − D_x·q(r_x) + Ω·M_y·w_y                                                          (i3)
//! M_y·ẇ_y = F_y − D_y·q(r_y) − Ω·M_x·w_x                                                          (i4)
//! I·Ω̇    = τ − C_R·q(Ω) − (M_y − M_x)·w_x·w_y                                                     (i5)
//! ẋ = R(Θ)·w + c,   Θ̇ = Ω,   ġ = −g/τ_g + noise                                                   (i6)
//! q(r) = r·√(r² + 2σ²)                                                                             (i7)
//! ```
//!
//! (b1)–(b3) of the simulated water, seen from water that is at rest: mass m and added mass appear only as their sums M. (i7) is the mean
//! of r|r| over what the filter is not sure of, its variance σ²: it is r² + σ² for r ≫ σ, and within 12 % of the exact mean below.
//! With σ = 0, a filter takes gusts for drag: (r + g)|r + g| has the mean r² + σ_g².
//!
//! Assumptions: a gust acts by drag alone; drag has no cross terms between the axes.

use super::constants::Values;
use super::filter::{Motion, Square, State, propagate, squared};
use super::log::{Impulse, PER_BIN};

/// Where a stretch of poses begins: deviation of each velocity, m/s and rad/s. *Assumed*.
const BEGINS_M_S: f64 = 0.05;
const BEGINS_RAD_S: f64 = 0.1;

/// The structure under the impulses of its tails. States: east, north (m), Θ (rad), w_x, w_y (m/s), Ω (rad/s), g east, g north (m/s).
pub(crate) struct Swimming<'a> {
    pub values: &'a Values,
    /// Up to [`PER_BIN`] instants of each bin.
    pub impulses: &'a [Impulse],
}

impl Motion<3> for Swimming<'_> {
    /// Sway, surge, N, yaw, N·m.
    type Force = [f64; 3];

    /// At rest over ground.
    fn begin(&self, pose: [f64; 3]) -> State {
        let (sin, cos) = pose[2].sin_cos();
        let [east, north] = self.values.current_m_s;
        let mut state = State::zeros();
        (state[0], state[1], state[2]) = (pose[0], pose[1], pose[2]);
        (state[3], state[4]) = (-(sin * east - cos * north), -(cos * east + sin * north));
        state
    }

    fn begins(&self) -> State {
        let gust = self.values.gust_m_s;
        State::from([0.0, 0.0, 0.0, BEGINS_M_S, BEGINS_M_S, BEGINS_RAD_S, gust, gust])
    }

    fn noise(&self) -> [f64; 3] {
        [self.values.position_noise_m, self.values.position_noise_m, self.values.heading_noise_rad]
    }

    fn halves(&self, index: usize, span_s: f64) -> [[f64; 3]; 2] {
        let at = PER_BIN * index;
        let [before, half, now] = [self.impulses[at - 1], self.impulses[at], self.impulses[at + 1]];
        let mean = |from: Impulse, to: Impulse| [0, 1, 2].map(|axis| 2.0 * (to[axis] - from[axis]) / span_s);
        [mean(before, half), mean(half, now)]
    }

    fn step(
        &self,
        state: &State,
        covariance: Option<&mut Square>,
        halves: [[f64; 3]; 2],
        dt_s: f64,
    ) -> State {
        let values = self.values;
        let spread = covariance.as_deref().map_or([0.0; 3], |covariance| spread(state, covariance));
        let fresh = || {
            let gust = values.gust_m_s.powi(2) * -(-2.0 * dt_s / values.gust_time_s).exp_m1();
            let (push, twist) = (values.push.powi(2) * dt_s, values.twist.powi(2) * dt_s);
            [(3, push), (4, push), (5, twist), (6, gust), (7, gust)]
        };
        propagate(state, covariance, halves, dt_s, |at, force| rates(values, at, force, spread), fresh)
    }
}

/// Rates of change and their derivatives by the state, at `state`; `spread` are the variances of r_x, r_y and Ω.
fn rates(values: &Values, state: &State, force: [f64; 3], spread: [f64; 3]) -> (State, Square) {
    let (sin, cos) = state[2].sin_cos();
    let (w, omega) = ([state[3], state[4]], state[5]);
    let [mx, my] = values.mass_kg;
    let inertia = values.inertia_kg_m2;
    // x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ)
    let axes = [[sin, -cos], [cos, sin]];
    let gust = axes.map(|axis| axis[0] * state[6] + axis[1] * state[7]);
    let (qx, dqx) = squared(w[0] - gust[0], spread[0]);
    let (qy, dqy) = squared(w[1] - gust[1], spread[1]);
    let (qt, dqt) = squared(omega, spread[2]);
    let mut rate = State::zeros();
    let mut by = Square::zeros();
    rate[0] = axes[0][0] * w[0] + axes[1][0] * w[1] + values.current_m_s[0];
    rate[1] = axes[0][1] * w[0] + axes[1][1] * w[1] + values.current_m_s[1];
    rate[2] = omega;
    // M_x·ẇ_x = F_x − D_x·q(r_x) + Ω·M_y·w_y                                                        (i3)
    rate[3] = (force[0] - values.drag[0] * qx + omega * my * w[1]) / mx;
    // M_y·ẇ_y = F_y − D_y·q(r_y) − Ω·M_x·w_x                                                        (i4)
    rate[4] = (force[1] - values.drag[1] * qy - omega * mx * w[0]) / my;
    // I·Ω̇ = τ − C_R·q(Ω) − (M_y − M_x)·w_x·w_y                                                      (i5)
    rate[5] = (force[2] - values.yaw_drag * qt - (my - mx) * w[0] * w[1]) / inertia;
    rate[6] = -state[6] / values.gust_time_s;
    rate[7] = -state[7] / values.gust_time_s;
    by[(0, 2)] = cos * w[0] - sin * w[1];
    by[(1, 2)] = sin * w[0] + cos * w[1];
    for (axis, [east, north]) in axes.into_iter().enumerate() {
        by[(0, 3 + axis)] = east;
        by[(1, 3 + axis)] = north;
    }
    by[(2, 5)] = 1.0;
    let (bx, bb) = (values.drag[0] * dqx / mx, values.drag[1] * dqy / my);
    by[(3, 3)] = -bx;
    by[(3, 4)] = omega * my / mx;
    by[(3, 5)] = my * w[1] / mx;
    by[(4, 4)] = -bb;
    by[(4, 3)] = -omega * mx / my;
    by[(4, 5)] = -mx * w[0] / my;
    for world in 0..2 {
        by[(3, 6 + world)] = bx * axes[0][world];
        by[(4, 6 + world)] = bb * axes[1][world];
        by[(6 + world, 6 + world)] = -1.0 / values.gust_time_s;
    }
    by[(5, 5)] = -values.yaw_drag * dqt / inertia;
    by[(5, 3)] = -(my - mx) * w[1] / inertia;
    by[(5, 4)] = -(my - mx) * w[0] / inertia;
    (rate, by)
}

/// Variances of r_x, r_y and Ω by the covariance of the state.
fn spread(state: &State, covariance: &Square) -> [f64; 3] {
    let (sin, cos) = state[2].sin_cos();
    let of = |axis: usize, [east, north]: [f64; 2]| {
        let p = |i: usize, j: usize| covariance[(i, j)];
        let gust = east * east * p(6, 6) + north * north * p(7, 7) + 2.0 * east * north * p(6, 7);
        let both = east * p(axis, 6) + north * p(axis, 7);
        (p(axis, axis) + gust - 2.0 * both).max(0.0)
    };
    [of(3, [sin, -cos]), of(4, [cos, sin]), covariance[(5, 5)].max(0.0)]
}
