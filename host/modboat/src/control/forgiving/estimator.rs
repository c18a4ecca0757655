//! Where the structure is, how it moves, what pushes it beside its tails, and how far thrust and drag differ from what is believed:
//! all without the wobble of the swim.
//!
//! The motion is predicted with the mean wrench of the running cycle, fix by fix. At each decision the fixes of the last period, less their
//! predictions, are averaged, which lets no harmonic of the period through, and the mean corrects the states by (f2). One mean of 180 fixes
//! has little noise (0.04 mm), so that one or two cycles tell the velocity and the unknown acceleration: no lag but that of the window.
//!
//! ```text
//! v̇ = R(Θ)·[(k_F·F − c_L·D·v|v| + p)/M]_S + d      Ω̇ = (k_τ·τ − c_R·C_R·Ω|Ω| − m·M·v_x·v_y)/I + d_Θ   (s1)
//! p_x = (M_y − M_x)·Ω·v_y,  p_y = (M_y − M_x)·Ω·v_x
//! ```
//!
//! M and D are those of an axis of S: [`ForgivingConfig`] has their differences. m·M is by how much more mass with water the structure has in
//! surge than in sway: the Munk moment turns it across its way, or into it, and holds a heading or throws it off; p is what the momentum of the
//! one axis gives to the other in a turn (Kirchhoff's equations). v over ground stands for v through the water.
//!
//! d follows a random walk, slow in calm water and fast in gusts, as the innovations say; where the wrench changes, what is not known of it counts too. k and c hardly change: [`WANDER`].
//! A lasting d and a k cannot be told apart while the wrench is constant; the covariances know that, and k moves when the wrench does.

use std::collections::VecDeque;

use quantity::wrap_rad;

use super::ForgivingConfig;
use super::filter::{Filter, Slope};
use crate::control::Tails;
use crate::motion::Wrench;
use crate::observer::{Fix, ObserverParameters};
use crate::parameters::Parameters;
use crate::structure::Structure;

/// Longest step of the prediction, s.
const STEP_MAX_S: f64 = 0.02;
/// After a longer gap of fixes the pose is taken from the next, s.
const GAP_MAX_S: f64 = 1.0;
/// Standard deviation of the mean position of a window, m. *Assumed*: four times the noise of good cameras, or a wobble that is not quite
/// periodic.
const SEEN_M: f64 = 1.5e-4;
/// How fast the pace of d follows what innovations say, in a correction. *Assumed.*
const HEED: f64 = 0.15;
/// More than this times its variance an innovation does not count. *Assumed.*
const ODD: f64 = 8.0;
/// Growth of the standard deviation of k and c in a second. *Assumed*: 8 % in a minute.
const WANDER: f64 = 0.01;
/// How far a wrench may be off when it changes, as a share of the change. *Assumed.*
const INEXACT: f64 = 0.03;
/// How much later than its time a pose may be true, s. *Assumed*: a system that stamps on arrival.
const LATE_S: f64 = 0.2;
/// How far modules differ in thrust. *Assumed.*
const SPREAD: f64 = 0.1;
/// k and c stay within these. *Assumed.*
const FACTOR: [f64; 2] = [0.25, 4.0];

/// And m within this, either way: no hull has twice the mass one way that it has the other. *Assumed.*
const MUNK: f64 = 0.7;

/// (x, y, Θ) or any of their derivatives.
pub(super) type Axes = [f64; 3];

/// What the structure is believed to be.
#[derive(Clone, Debug)]
pub(super) struct Model {
    /// Mean of both axes.
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    /// In sway and surge.
    pub masses_kg: [f64; 2],
    /// In sway and surge.
    pub drag_n_s2_m2: [f64; 2],
    pub yaw_drag_n_m_s2: f64,
    /// J of one tail.
    pub tail_inertia_kg_m2: f64,
    /// Torque of a force whose modules differ by [`SPREAD`], m.
    pub lever_m: f64,
}

impl Model {
    /// p of (s1), N, at a velocity in S, m/s. Kirchhoff's equations tell accelerations in axes that turn; (s1) is about those in the world, which
    /// takes M·Ω·v of the own axis off.
    pub fn passed_n(&self, [sway, surge]: [f64; 2], omega: f64) -> [f64; 2] {
        let beyond_kg = self.masses_kg[1] - self.masses_kg[0];
        [beyond_kg * omega * surge, beyond_kg * omega * sway]
    }
}

/// k and c of (s1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// k_F.
    pub force: f64,
    /// c_L.
    pub drag: f64,
    /// k_τ.
    pub torque: f64,
    /// c_R.
    pub yaw_drag: f64,
    /// m: mass with water in surge less that in sway, over their mean.
    pub munk: f64,
}

/// Mean motion at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    pub pose: Axes,
    pub rate: Axes,
}

#[derive(Clone, Debug)]
struct Sample {
    t_s: f64,
    /// Fix less prediction.
    beyond: Axes,
    drift: [[f64; 8]; 2],
    yaw: [[f64; 6]; 1],
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(super) struct Estimator {
    pub model: Model,
    period_s: f64,
    t_s: Option<f64>,
    last_fix_s: f64,
    corrected_s: f64,
    pub motion: Motion,
    /// d, d_Θ.
    pub unknown: Axes,
    pub factors: Factors,
    drift: Filter<2, 8>,
    yaw: Filter<1, 6>,
    wrench: Wrench,
    /// None before it was first told.
    tails: Option<Tails>,
    /// Growth of d, between calm and gusty, m/s² in a second.
    drift_m_s2: f64,
    window: VecDeque<Sample>,
    config: ForgivingConfig,
}

impl Estimator {
    pub(super) fn new(
        structure: &Structure,
        parameters: &Parameters,
        observer: &ObserverParameters,
        config: &ForgivingConfig,
    ) -> Self {
        let modules = structure.len() as f64;
        let positions_m = structure.positions_m(parameters.pitch_m);
        let squares_m2: f64 = positions_m.iter().map(|[x, y]| x * x + y * y).sum();
        let (unsure, unsure_yaw) = (config.unsure, config.unsure_yaw);
        let mass_kg = structure.mass_kg(parameters) * (1.0 + observer.added_mass);
        // Surge has `more` than sway, over their mean.
        let apart = |mean: f64, more: f64| [(1.0 - 0.5 * more) * mean, (1.0 + 0.5 * more) * mean];
        Self {
            model: Model {
                mass_kg,
                masses_kg: apart(mass_kg, config.munk),
                inertia_kg_m2: structure.inertia_kg_m2(parameters) * (1.0 + observer.added_inertia),
                drag_n_s2_m2: apart(modules * parameters.drag_n_s2_m2, config.drag_difference),
                yaw_drag_n_m_s2: structure.yaw_drag_n_m_s2(parameters),
                tail_inertia_kg_m2: parameters.tail_inertia_kg_m2,
                lever_m: SPREAD * squares_m2.sqrt() / modules,
            },
            period_s: parameters.period_s,
            t_s: None,
            last_fix_s: 0.0,
            corrected_s: 0.0,
            motion: Motion::default(),
            unknown: [0.0; 3],
            factors: Factors { force: 1.0, drag: 1.0, torque: 1.0, yaw_drag: 1.0, munk: config.munk },
            drift: Filter::new([1e-2, 1e-2, 2e-2, 2e-2, 2e-3, 2e-3, unsure, unsure]),
            yaw: Filter::new([1e-2, 2e-2, 2e-3, unsure_yaw, unsure_yaw, config.unsure_munk]),
            wrench: Wrench::default(),
            tails: None,
            drift_m_s2: config.calm_m_s2,
            window: VecDeque::new(),
            config: config.clone(),
        }
    }

    /// J/I.
    fn rotor_share(&self) -> f64 {
        self.model.tail_inertia_kg_m2 / self.model.inertia_kg_m2
    }

    /// Whether there has been a fix.
    pub(super) fn has_begun(&self) -> bool {
        self.t_s.is_some()
    }

    /// How gusty the water is by the innovations, 0 … 1.
    pub(super) fn gustiness(&self) -> f64 {
        let ForgivingConfig { calm_m_s2, gusty_m_s2, .. } = self.config;
        let span = (gusty_m_s2 / calm_m_s2).ln();
        if span > 0.0 { ((self.drift_m_s2 / calm_m_s2).ln() / span).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Standard deviations of k_F and k_τ.
    pub(super) fn unsure(&self) -> [f64; 2] {
        [self.drift.deviation(6), self.yaw.deviation(3)]
    }

    /// The mean wrench of the tails from `t_s` on, as [`Observer::set_wrench`](crate::observer::Observer::set_wrench).
    /// A tail that turns by Δφ turns the structure by −J Δφ/I, and leaves it there.
    pub(super) fn set_wrench(&mut self, t_s: f64, wrench: Wrench, tails: Option<Tails>) {
        let tails = tails.or(self.tails).unwrap_or_default();
        // The first turn begins where the tails rested all along.
        let before_rad = self.tails.map_or(tails.from_rad, |before| before.about_rad);
        let turned_rad = tails.about_rad - before_rad;
        if self.tails.unwrap_or_default() != tails {
            self.predict(t_s);
            self.motion.pose[2] -= self.rotor_share() * turned_rad;
            self.tails = Some(tails);
        }
        if wrench == self.wrench {
            return;
        }
        self.predict(t_s);
        let change = wrench - self.wrench;
        self.wrench = wrench;
        let force_n = change.fx_n.hypot(change.fy_n);
        let off_m_s2 = INEXACT * force_n / self.model.mass_kg;
        let off_rad_s2 =
            (self.model.lever_m * force_n).hypot(INEXACT * change.tau_nm) / self.model.inertia_kg_m2;
        [4, 5].into_iter().for_each(|state| self.drift.loosen(state, off_m_s2.powi(2), f64::INFINITY));
        self.yaw.loosen(2, off_rad_s2.powi(2), f64::INFINITY);
        // Seen late, the change comes late.
        let late_m_s = LATE_S * force_n / self.model.mass_kg;
        let late_rad_s = LATE_S * change.tau_nm.abs() / self.model.inertia_kg_m2;
        [2, 3].into_iter().for_each(|state| self.drift.loosen(state, late_m_s.powi(2), f64::INFINITY));
        self.yaw.loosen(1, late_rad_s.powi(2), f64::INFINITY);
    }

    /// The running wrench is, and has been, `wrench`; d was the larger for it.
    pub(super) fn correct_wrench(&mut self, wrench: Wrench) {
        let more = wrench - self.wrench;
        let (sin, cos) = self.motion.pose[2].sin_cos();
        let Factors { force, torque, .. } = self.factors;
        let [x, y] = [more.fx_n, more.fy_n].map(|force_n| force * force_n / self.model.mass_kg);
        self.unknown[0] -= sin * x + cos * y;
        self.unknown[1] -= -cos * x + sin * y;
        self.unknown[2] -= torque * more.tau_nm / self.model.inertia_kg_m2;
        self.wrench = wrench;
    }

    /// m is, and has been, `munk`; d_Θ was the larger for it.
    pub(super) fn set_munk(&mut self, munk: f64) {
        let munk = munk.clamp(-MUNK, MUNK);
        let (sin, cos) = self.motion.pose[2].sin_cos();
        let [v_x, v_y, _] = self.motion.rate;
        let (sway, surge) = (sin * v_x - cos * v_y, cos * v_x + sin * v_y);
        self.unknown[2] += (munk - self.factors.munk) * self.munk_rad_s2(sway, surge);
        self.factors.munk = munk;
    }

    /// Takes a fix; one from the past, or that is no number, is ignored.
    pub(super) fn update(&mut self, fix: &Fix) {
        let measured = [fix.position_m[0], fix.position_m[1], fix.heading_rad];
        if !fix.t_s.is_finite() || !measured.iter().all(|value| value.is_finite()) {
            return;
        }
        let Some(now_s) = self.t_s else {
            self.motion.pose = measured;
            (self.t_s, self.last_fix_s, self.corrected_s) = (Some(fix.t_s), fix.t_s, fix.t_s);
            return;
        };
        if fix.t_s < now_s {
            return;
        }
        self.predict(fix.t_s);
        let gap_s = fix.t_s - self.last_fix_s;
        self.last_fix_s = fix.t_s;
        let mut beyond: Axes = std::array::from_fn(|axis| measured[axis] - self.motion.pose[axis]);
        // Rotors turn the structure against what the tails are past the angles that they swing about.
        let swung_rad = self.tails.map_or(0.0, |tails| tails.beyond_rad(fix.t_s, self.period_s));
        beyond[2] = wrap_rad(beyond[2] + self.rotor_share() * swung_rad);
        if gap_s > GAP_MAX_S {
            (0..3).for_each(|axis| self.motion.pose[axis] += beyond[axis]);
            self.window.clear();
            self.corrected_s = fix.t_s;
            return;
        }
        let (drift, yaw) = (self.drift.rows(), self.yaw.rows());
        self.window.push_back(Sample { t_s: fix.t_s, beyond, drift, yaw });
        while self.window.front().is_some_and(|sample| sample.t_s <= fix.t_s - self.period_s + 1e-6) {
            self.window.pop_front();
        }
        // No decision takes it: nothing swims.
        if fix.t_s - self.corrected_s > 1.6 * self.period_s {
            self.correct();
        }
    }

    /// Corrects by the last period's fixes, if they are all from after the last correction. Once a decision.
    pub(super) fn correct(&mut self) {
        let Some(now_s) = self.t_s else { return };
        let since_s = now_s - self.corrected_s;
        // Two frames of slack.
        if self.window.is_empty() || since_s < self.period_s - 0.02 {
            return;
        }
        self.corrected_s = now_s;
        let share = 1.0 / self.window.len() as f64;
        let (mut errors, mut drift, mut yaw) = ([0.0; 3], [[0.0; 8]; 2], [[0.0; 6]; 1]);
        for sample in &self.window {
            (0..3).for_each(|axis| errors[axis] += share * sample.beyond[axis]);
            for (row, seen) in drift.iter_mut().zip(&sample.drift) {
                row.iter_mut().zip(seen).for_each(|(sum, value)| *sum += share * value);
            }
            yaw[0].iter_mut().zip(&sample.yaw[0]).for_each(|(sum, value)| *sum += share * value);
        }
        self.window.clear();
        let ForgivingConfig {
            calm_m_s2,
            gusty_m_s2,
            twist_rad_s2,
            heading_seen_rad,
            unsure,
            unsure_yaw,
            unsure_munk,
            ..
        } = self.config;
        let odd: f64 =
            drift.iter().zip(errors).map(|(row, e)| e * e / self.drift.spread(row, SEEN_M.powi(2))).sum();
        // The innovations of a filter that is right have their variance.
        let pace = self.drift_m_s2 * (HEED * ((0.5 * odd).min(ODD) - 1.0)).exp();
        self.drift_m_s2 = pace.min(gusty_m_s2).max(calm_m_s2);
        let [x, y, v_x, v_y, d_x, d_y, k, c] =
            self.drift.correct(&drift, [errors[0], errors[1]], SEEN_M.powi(2));
        let [theta, omega, d_theta, k_tau, c_r, m] =
            self.yaw.correct(&yaw, [errors[2]], heading_seen_rad.powi(2));
        for (value, change) in self.motion.pose.iter_mut().zip([x, y, theta]) {
            *value += change;
        }
        for (value, change) in self.motion.rate.iter_mut().zip([v_x, v_y, omega]) {
            *value += change;
        }
        for (value, change) in self.unknown.iter_mut().zip([d_x, d_y, d_theta]) {
            *value += change;
        }
        let within = |value: f64| value.clamp(FACTOR[0], FACTOR[1]);
        let Factors { force, drag, torque, yaw_drag, munk } = self.factors;
        self.factors = Factors {
            force: within(force + k),
            drag: within(drag + c),
            torque: within(torque + k_tau),
            yaw_drag: within(yaw_drag + c_r),
            munk: (munk + m).clamp(-MUNK, MUNK),
        };
        let drifted = self.drift_m_s2.powi(2) * since_s;
        [4, 5].into_iter().for_each(|state| self.drift.loosen(state, drifted, f64::INFINITY));
        self.yaw.loosen(2, twist_rad_s2.powi(2) * since_s, f64::INFINITY);
        let (slip_m_s, slip_rad_s) = (self.config.slip_m_s, self.config.slip_rad_s);
        [2, 3]
            .into_iter()
            .for_each(|state| self.drift.loosen(state, slip_m_s.powi(2) * since_s, f64::INFINITY));
        self.yaw.loosen(1, slip_rad_s.powi(2) * since_s, f64::INFINITY);
        let wander = WANDER.powi(2) * since_s;
        [6, 7].into_iter().for_each(|state| self.drift.loosen(state, wander, unsure.powi(2)));
        [3, 4].into_iter().for_each(|state| self.yaw.loosen(state, wander, unsure_yaw.powi(2)));
        self.yaw.loosen(5, wander, unsure_munk.powi(2));
    }

    /// The motion at `t_s`, if the wrench goes on as it is.
    pub(super) fn ahead(&self, t_s: f64) -> Motion {
        let mut motion = self.motion;
        let Some(mut now_s) = self.t_s else { return motion };
        while now_s < t_s {
            let dt_s = (t_s - now_s).min(STEP_MAX_S);
            motion = self.moved(&motion, dt_s);
            now_s = if dt_s < STEP_MAX_S { t_s } else { now_s + dt_s };
        }
        motion
    }

    fn predict(&mut self, t_s: f64) {
        let Some(mut now_s) = self.t_s else { return };
        if !t_s.is_finite() {
            return;
        }
        while now_s < t_s {
            let dt_s = (t_s - now_s).min(STEP_MAX_S);
            let (drift, yaw) = self.slopes();
            self.drift.step(dt_s, &drift);
            self.yaw.step(dt_s, &yaw);
            self.motion = self.moved(&self.motion, dt_s);
            // Never short of `t_s` by a rounding, which would loop on.
            now_s = if dt_s < STEP_MAX_S { t_s } else { now_s + dt_s };
        }
        self.t_s = Some(now_s);
    }

    /// One midpoint step of (s1).
    fn moved(&self, motion: &Motion, dt_s: f64) -> Motion {
        let start = self.acceleration(self.wrench, motion.pose[2], motion.rate);
        let middle: Axes = std::array::from_fn(|axis| motion.rate[axis] + 0.5 * dt_s * start[axis]);
        let then = self.acceleration(self.wrench, motion.pose[2] + 0.5 * dt_s * motion.rate[2], middle);
        Motion {
            pose: std::array::from_fn(|axis| motion.pose[axis] + dt_s * middle[axis]),
            rate: std::array::from_fn(|axis| motion.rate[axis] + dt_s * then[axis]),
        }
    }

    /// By (s1) with this mean wrench.
    pub(super) fn acceleration(&self, wrench: Wrench, heading_rad: f64, [v_x, v_y, omega]: Axes) -> Axes {
        let (sin, cos) = heading_rad.sin_cos();
        let Model { masses_kg, inertia_kg_m2, drag_n_s2_m2, yaw_drag_n_m_s2, .. } = self.model;
        let (k, c) = (self.factors.force, self.factors.drag);
        // World → S: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
        let (sway, surge) = (sin * v_x - cos * v_y, cos * v_x + sin * v_y);
        // v̇ = R(Θ)·[(k_F·F − c_L·D·v|v| + p)/M]_S + d                                              (s1)
        let passed = self.model.passed_n([sway, surge], omega);
        let pushed = |axis: usize, force_n: f64, v: f64| {
            (k * force_n - c * drag_n_s2_m2[axis] * v * v.abs() + passed[axis]) / masses_kg[axis]
        };
        let (a_sway, a_surge) = (pushed(0, wrench.fx_n, sway), pushed(1, wrench.fy_n, surge));
        let drag_nm = self.factors.yaw_drag * yaw_drag_n_m_s2 * omega * omega.abs();
        [
            sin * a_sway + cos * a_surge + self.unknown[0],
            -cos * a_sway + sin * a_surge + self.unknown[1],
            (self.factors.torque * wrench.tau_nm - drag_nm) / inertia_kg_m2 + self.unknown[2]
                - self.factors.munk * self.munk_rad_s2(sway, surge),
        ]
    }

    /// What the Munk moment of m = 1 turns the structure by, at this velocity in S, m/s.
    pub(super) fn munk_rad_s2(&self, sway: f64, surge: f64) -> f64 {
        self.model.mass_kg * sway * surge / self.model.inertia_kg_m2
    }

    /// u, and what (s1) changes by with the state, of (f1).
    fn slopes(&self) -> (Slope<2, 2>, Slope<1, 3>) {
        let (sin, cos) = self.motion.pose[2].sin_cos();
        let [v_x, v_y, omega] = self.motion.rate;
        let Model { masses_kg, inertia_kg_m2, drag_n_s2_m2, yaw_drag_n_m_s2, .. } = self.model;
        let (sway, surge) = (sin * v_x - cos * v_y, cos * v_x + sin * v_y);
        let world = |x: f64, y: f64| [sin * x + cos * y, -cos * x + sin * y];
        let [d_x, d_y] = [0, 1].map(|axis| drag_n_s2_m2[axis] / masses_kg[axis]);
        let [j_x, j_y] = [(d_x, sway), (d_y, surge)].map(|(d, v)| 2.0 * self.factors.drag * d * v.abs());
        let drift = Slope {
            drag_1_s: [
                [sin * sin * j_x + cos * cos * j_y, sin * cos * (j_y - j_x)],
                [sin * cos * (j_y - j_x), cos * cos * j_x + sin * sin * j_y],
            ],
            spring_1_s2: [0.0; 2],
            factors: [
                world(self.wrench.fx_n / masses_kg[0], self.wrench.fy_n / masses_kg[1]),
                world(-d_x * sway * sway.abs(), -d_y * surge * surge.abs()),
            ],
        };
        let d = yaw_drag_n_m_s2 / inertia_kg_m2;
        let yaw = Slope {
            drag_1_s: [[2.0 * self.factors.yaw_drag * d * omega.abs()]],
            // ∂(v_x·v_y)/∂Θ = v_y² − v_x²: S turns under the velocity.
            spring_1_s2: [self.factors.munk * (self.munk_rad_s2(surge, surge) - self.munk_rad_s2(sway, sway))],
            factors: [
                [self.wrench.tau_nm / inertia_kg_m2],
                [-d * omega * omega.abs()],
                [-self.munk_rad_s2(sway, surge)],
            ],
        };
        (drift, yaw)
    }
}
