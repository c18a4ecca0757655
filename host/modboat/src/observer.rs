//! From motion capture fixes to the mean motion of the structure: what the controller (13)–(19) acts on.
//!
//! The structure wobbles at the swim period, as the tails push now to one side, now to the other and react on it.
//! A decision is made once a cycle, always at the same phase of that wobble, so what leaks of it into
//! the velocity is a bias, not a noise. The observer therefore predicts with the *mean* wrench of
//! the running cycle, which the host planned, corrects slowly, and averages its corrections over one period.
//!
//! ```text
//! ẋ = v + l₁·e        v̇ = R(Θ)·[(F − D·v|v|)/(m + m_a)]_S + d + l₂·e        ḋ = l₃·e             (o1)
//! Θ̇ = Ω + l₁·e_Θ      Ω̇ = (τ − C_R·Ω|Ω|)/(I + I_a) + d_Θ + l₂·e_Θ           ḋ_Θ = l₃·e_Θ         (o2)
//! (s + ω)²·(s + p) = s³ + l₁s² + l₂s + l₃                                                        (o3)
//! v_out = v − c + mean of c over the last T,        c = ∫ l₂·e dt                                 (o4)
//! x_out = s + mean of (fix − s) over the last T,    s = ∫ v_out dt                                 (o5)
//! d_out = mean of d over the last T                                                                (o6)
//! ```
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | e, e_Θ | m, rad | fix minus prediction (e_Θ wrapped) |
//! | d, d_Θ | m/s², rad/s² | acceleration the model does not know (current, wrong drag), world frame |
//! | ω, p | rad/s | double pole of the correction, pole of the unknown acceleration |
//! | c | m/s, rad/s | all that the fixes have added to the velocity |
//! | s | m, rad | the way by dead reckoning, from anywhere |
//!
//! By (o4) what the model predicts passes without lag, and what only the fixes know passes T/2 later, rid of every
//! harmonic of the period. The unknown acceleration takes away the lasting error that a current
//! would leave; the controller takes (o6) off what it demands. By (o5) the same holds for position and heading: three modules
//! with tails in phase yaw by J/(I + I_a)·|ΣA| = 0.007 rad either way, and the decision always falls at one phase of
//! that. Angular momentum says so, Θ(t) = Θ₀ − J/(I + I_a)·Σφᵢ(t), and experiment 2 shows it.
//!
//! Assumptions and limits: mass, added mass and drag as in [`ObserverParameters`] and [`Parameters`]; no Coriolis
//! terms. A transition breaks the periodicity, so for one period after it (o4) averages imperfectly.

use std::collections::VecDeque;

use quantity::{ParameterError, check_within, wrap_rad};
use serde::{Deserialize, Serialize};

use super::motion::Wrench;
use super::parameters::Parameters;
use super::structure::Structure;

/// Longest step of the prediction, s.
const STEP_MAX_S: f64 = 0.02;

/// After a gap of fixes longer than this, position and heading are taken from the next fix as they are, s.
const GAP_MAX_S: f64 = 1.0;

/// Longest span for which one fix counts as the correction, s.
const WEIGHT_MAX_S: f64 = 0.05;

/// One measured pose of the structure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fix {
    /// When it was true, s.
    pub t_s: f64,
    /// Centre of mass in the world, m.
    pub position_m: [f64; 2],
    /// Heading Θ in (−π, π], rad.
    pub heading_rad: f64,
}

/// The structure's motion without its wobble.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// When, s.
    pub t_s: f64,
    /// Centre of mass in the world, m, averaged over the wobble.
    pub position_m: [f64; 2],
    /// Velocity in the world, m/s, averaged over the wobble.
    pub velocity_m_s: [f64; 2],
    /// Heading Θ, rad, averaged over the wobble (unwrapped: counts turns since the first fix).
    pub heading_rad: f64,
    /// Angular velocity Ω, rad/s, averaged over the wobble.
    pub yaw_rate_rad_s: f64,
    /// Acceleration in the world that neither the planned wrench nor the drag explains, averaged over the wobble, m/s².
    pub unknown_m_s2: [f64; 2],
    /// The same of yaw, rad/s².
    pub unknown_rad_s2: f64,
}

/// What the observer believes of the structure, and how fast it corrects itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObserverParameters {
    /// Double pole ω of the correction, rad/s.
    pub bandwidth_rad_s: f64,
    /// Pole p of the unknown acceleration, rad/s.
    pub disturbance_rad_s: f64,
    /// Added mass as a fraction of the structure's mass. *Assumed.*
    pub added_mass: f64,
    /// Added moment of inertia as a fraction of the structure's. *Assumed.*
    pub added_inertia: f64,
}

impl Default for ObserverParameters {
    fn default() -> Self {
        Self { bandwidth_rad_s: 1.2, disturbance_rad_s: 0.3, added_mass: 0.5, added_inertia: 0.5 }
    }
}

impl ObserverParameters {
    /// Refuses what cannot work, by the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (ten, hundred) = ("must lie in 0 … 10", "must lie in 0 … 100");
        check_within(&[
            ("bandwidth_rad_s", self.bandwidth_rad_s, "rad/s", 0.0..=10.0, ten),
            ("disturbance_rad_s", self.disturbance_rad_s, "rad/s", 0.0..=10.0, ten),
            ("added_mass", self.added_mass, "of the mass", 0.0..=100.0, hundred),
            ("added_inertia", self.added_inertia, "of the inertia", 0.0..=100.0, hundred),
        ])
    }
}

/// (x, y, Θ) or any of their derivatives.
type Axes = [f64; 3];

/// The estimator. Give it [`Observer::set_wrench`] at the start of every cycle and [`Observer::update`] every fix.
#[derive(Clone, Debug)]
pub struct Observer {
    /// l₁, l₂, l₃ of (o3).
    gains: [f64; 3],
    mass_kg: f64,
    inertia_kg_m2: f64,
    drag_n_s2_m2: f64,
    yaw_drag_n_m_s2: f64,
    period_s: f64,
    wrench: Wrench,
    t_s: Option<f64>,
    last_fix_s: f64,
    pose: Axes,
    rate: Axes,
    unknown: Axes,
    /// c of (o4).
    correction: Axes,
    /// Mean of c over the last period, less c: what (o4) adds to the velocity.
    smoothing: Axes,
    /// s of (o5).
    reckoned: Axes,
    /// Of the last period's fixes.
    last_period: VecDeque<Sample>,
}

/// What (o4) to (o6) average.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    t_s: f64,
    /// c.
    correction: Axes,
    /// fix − s.
    beyond: Axes,
    /// d.
    unknown: Axes,
}

impl Observer {
    /// An observer that waits for its first fix, taking the structure to lie still.
    pub fn new(
        structure: &Structure,
        parameters: &Parameters,
        observer: &ObserverParameters,
    ) -> Result<Self, ParameterError> {
        observer.validate()?;
        let (w, p) = (observer.bandwidth_rad_s, observer.disturbance_rad_s);
        Ok(Self {
            // (s + ω)²·(s + p) = s³ + l₁s² + l₂s + l₃                                              (o3)
            gains: [2.0 * w + p, w * w + 2.0 * w * p, w * w * p],
            mass_kg: structure.mass_kg(parameters) * (1.0 + observer.added_mass),
            inertia_kg_m2: structure.inertia_kg_m2(parameters) * (1.0 + observer.added_inertia),
            drag_n_s2_m2: structure.len() as f64 * parameters.drag_n_s2_m2,
            yaw_drag_n_m_s2: structure.yaw_drag_n_m_s2(parameters),
            period_s: parameters.period_s,
            wrench: Wrench::default(),
            t_s: None,
            last_fix_s: 0.0,
            pose: [0.0; 3],
            rate: [0.0; 3],
            unknown: [0.0; 3],
            correction: [0.0; 3],
            smoothing: [0.0; 3],
            reckoned: [0.0; 3],
            last_period: VecDeque::new(),
        })
    }

    /// The mean wrench in S that the tails give from `t_s` on: of swim cycle *and* the transition before it, so planned
    /// wrench · T/(t_trans + T), set once at the start of the transition; zero while the tails rest. In two steps
    /// (zero, then the planned wrench) it would follow the saw of the velocity, whose teeth are where the
    /// decisions fall. Where it is another one than so far, the observer goes on to `t_s` by the former.
    pub fn set_wrench(&mut self, t_s: f64, wrench: Wrench) {
        if wrench != self.wrench {
            self.predict(t_s);
            self.wrench = wrench;
        }
    }

    /// Goes on to `t_s` by the model alone. Nothing happens before the first fix or back in time.
    pub fn predict(&mut self, t_s: f64) {
        let Some(mut now_s) = self.t_s else { return };
        if !t_s.is_finite() {
            return;
        }
        while now_s < t_s {
            let dt_s = (t_s - now_s).min(STEP_MAX_S);
            self.predict_step(dt_s);
            // Never short of `t_s` by a rounding, which would loop on.
            now_s = if dt_s < STEP_MAX_S { t_s } else { now_s + dt_s };
        }
        self.t_s = Some(now_s);
    }

    /// Goes on to the time of `fix` and corrects by it. A fix from the past, or one that is no number, is ignored.
    pub fn update(&mut self, fix: &Fix) {
        let measured = [fix.position_m[0], fix.position_m[1], fix.heading_rad];
        if !fix.t_s.is_finite() || !measured.iter().all(|x| x.is_finite()) {
            return;
        }
        let Some(now_s) = self.t_s else {
            self.pose = measured;
            (self.t_s, self.last_fix_s) = (Some(fix.t_s), fix.t_s);
            self.remember(fix.t_s, measured);
            return;
        };
        if fix.t_s < now_s {
            return;
        }
        self.predict(fix.t_s);
        let gap_s = fix.t_s - self.last_fix_s;
        self.last_fix_s = fix.t_s;
        let mut error = [0, 1, 2].map(|axis| measured[axis] - self.pose[axis]);
        error[2] = wrap_rad(error[2]);
        if gap_s > GAP_MAX_S {
            // Too long alone to tell how it came here: take the pose, keep the velocity.
            (0..3).for_each(|axis| self.pose[axis] += error[axis]);
            self.last_period.clear();
            self.remember(fix.t_s, self.pose);
            return;
        }
        let unwrapped = [0, 1, 2].map(|axis| self.pose[axis] + error[axis]);
        let dt_s = gap_s.min(WEIGHT_MAX_S);
        let [l1, l2, l3] = self.gains;
        for (axis, e) in error.into_iter().enumerate() {
            self.pose[axis] += l1 * e * dt_s;
            self.rate[axis] += l2 * e * dt_s;
            self.unknown[axis] += l3 * e * dt_s;
            self.correction[axis] += l2 * e * dt_s;
        }
        self.remember(fix.t_s, unwrapped);
    }

    /// Keeps what (o4) to (o6) need of a fix, for a period.
    fn remember(&mut self, t_s: f64, fix: Axes) {
        let beyond = [0, 1, 2].map(|axis| fix[axis] - self.reckoned[axis]);
        self.last_period.push_back(Sample {
            t_s,
            correction: self.correction,
            beyond,
            unknown: self.unknown,
        });
        // Exactly one period: the oldest sample is the first after t − T (a microsecond of slack for rounding).
        while self.last_period.front().is_some_and(|sample| sample.t_s <= t_s - self.period_s + 1e-6) {
            self.last_period.pop_front();
        }
        self.smoothing = self.mean_of(|sample, axis| sample.correction[axis] - self.correction[axis]);
    }

    /// The mean over the last period's fixes, axis by axis.
    fn mean_of(&self, what: impl Fn(&Sample, usize) -> f64) -> Axes {
        let count = self.last_period.len().max(1) as f64;
        [0, 1, 2].map(|axis| self.last_period.iter().map(|at| what(at, axis)).sum::<f64>() / count)
    }

    /// The estimate at the time of the last prediction or fix; none before the first fix.
    #[must_use]
    pub fn estimate(&self) -> Option<Estimate> {
        let t_s = self.t_s?;
        // v_out = v − c + mean of c over the last T                                                (o4)
        let rate = [0, 1, 2].map(|axis| self.rate[axis] + self.smoothing[axis]);
        // x_out = s + mean of (fix − s) over the last T                                            (o5)
        let beyond = self.mean_of(|sample, axis| sample.beyond[axis]);
        // d_out = mean of d over the last T                                                        (o6)
        let unknown = self.mean_of(|sample, axis| sample.unknown[axis]);
        let pose = [0, 1, 2].map(|axis| self.reckoned[axis] + beyond[axis]);
        Some(Estimate {
            t_s,
            position_m: [pose[0], pose[1]],
            velocity_m_s: [rate[0], rate[1]],
            heading_rad: pose[2],
            yaw_rate_rad_s: rate[2],
            unknown_m_s2: [unknown[0], unknown[1]],
            unknown_rad_s2: unknown[2],
        })
    }

    /// One midpoint step of (o1), (o2) without the corrections.
    fn predict_step(&mut self, dt_s: f64) {
        let start = self.acceleration(self.pose[2], self.rate);
        let middle_rate: Axes = std::array::from_fn(|i| self.rate[i] + 0.5 * dt_s * start[i]);
        let middle = self.acceleration(self.pose[2] + 0.5 * dt_s * self.rate[2], middle_rate);
        for axis in 0..3 {
            self.pose[axis] += middle_rate[axis] * dt_s;
            self.reckoned[axis] += (middle_rate[axis] + self.smoothing[axis]) * dt_s;
            self.rate[axis] += middle[axis] * dt_s;
        }
    }

    fn acceleration(&self, heading_rad: f64, [v_x, v_y, omega]: Axes) -> Axes {
        let (sin, cos) = heading_rad.sin_cos();
        // World → S: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
        let (sway, surge) = (sin * v_x - cos * v_y, cos * v_x + sin * v_y);
        // v̇ = R(Θ)·[(F − D·v|v|)/(m + m_a)]_S + d                                                  (o1)
        let a_sway = (self.wrench.fx_n - self.drag_n_s2_m2 * sway * sway.abs()) / self.mass_kg;
        let a_surge = (self.wrench.fy_n - self.drag_n_s2_m2 * surge * surge.abs()) / self.mass_kg;
        // Ω̇ = (τ − C_R·Ω|Ω|)/(I + I_a) + d_Θ                                                       (o2)
        let a_yaw = (self.wrench.tau_nm - self.yaw_drag_n_m_s2 * omega * omega.abs()) / self.inertia_kg_m2;
        [
            sin * a_sway + cos * a_surge + self.unknown[0],
            -cos * a_sway + sin * a_surge + self.unknown[1],
            a_yaw + self.unknown[2],
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    use super::*;

    /// Three in a row: m + m_a = 4.5 kg, D = 13.5 N·s²/m², I + I_a = 0.081 kg·m².
    fn observer() -> Observer {
        let structure = Structure::from_word("3x1").expect("three in a row");
        Observer::new(&structure, &Parameters::default(), &ObserverParameters::default()).expect("valid")
    }

    fn fix(t_s: f64, position_m: [f64; 2], heading_rad: f64) -> Fix {
        Fix { t_s, position_m, heading_rad: wrap_rad(heading_rad) }
    }

    #[test]
    fn there_is_no_estimate_before_the_first_fix() {
        let mut observer = observer();
        observer.predict(5.0);
        observer.update(&fix(f64::NAN, [0.0; 2], 0.0));
        observer.update(&fix(5.0, [0.0, f64::INFINITY], 0.0));
        assert_eq!(observer.estimate(), None);
        observer.update(&fix(5.0, [1.0, 2.0], 0.5));
        let estimate = observer.estimate().expect("has a fix");
        assert_eq!((estimate.t_s, estimate.position_m, estimate.velocity_m_s), (5.0, [1.0, 2.0], [0.0; 2]));
    }

    #[test]
    fn prediction_accelerates_as_the_wrench_says_and_ends_at_the_drag_law() {
        let mut observer = observer();
        // Surge axis at 60° from world x.
        observer.update(&fix(0.0, [0.0; 2], PI / 3.0));
        observer.set_wrench(0.0, Wrench { fx_n: 0.0, fy_n: 0.0216, tau_nm: 0.0 });
        for t_s in [1.0_f64, 5.0, 100.0] {
            observer.predict(t_s);
            let [v_x, v_y] = observer.estimate().expect("has a fix").velocity_m_s;
            // v̇ = (F − D·v²)/M from rest: v = V·tanh(t·√(F·D)/M), V = √(F/D) = 0.04 m/s.
            let speed_m_s = 0.04 * (t_s * (0.0216_f64 * 13.5).sqrt() / 4.5).tanh();
            assert!((v_x - 0.5 * speed_m_s).abs() < 1e-6, "{t_s} s: {v_x}");
            assert!((v_y - 0.75_f64.sqrt() * speed_m_s).abs() < 1e-6, "{t_s} s: {v_y}");
        }
    }

    #[test]
    fn sway_pushes_to_the_right_of_surge() {
        let mut observer = observer();
        observer.update(&fix(0.0, [0.0; 2], 0.0));
        observer.set_wrench(0.0, Wrench { fx_n: 0.045, fy_n: 0.0, tau_nm: 0.0 });
        observer.predict(0.1);
        // Heading along world x: right is −y; 0.045 N / 4.5 kg · 0.1 s.
        let [v_x, v_y] = observer.estimate().expect("has a fix").velocity_m_s;
        assert!(v_x.abs() < 1e-12 && (v_y + 0.001).abs() < 1e-6, "{v_x} {v_y}");
    }

    #[test]
    fn a_steady_drift_and_spin_unknown_to_the_model_are_found_across_the_wrap() {
        let mut observer = observer();
        for frame in 0..120 * 60 {
            let t_s = f64::from(frame) / 120.0;
            observer.update(&fix(t_s, [0.03 * t_s, -0.01 * t_s], 3.0 + 0.2 * t_s));
        }
        let estimate = observer.estimate().expect("has fixes");
        // The drag per axis changes as it turns, and the unknown force with it: that much lag remains.
        assert!((estimate.velocity_m_s[0] - 0.03).abs() < 1e-3, "{estimate:?}");
        assert!((estimate.velocity_m_s[1] + 0.01).abs() < 1e-3, "{estimate:?}");
        assert!((estimate.yaw_rate_rad_s - 0.2).abs() < 1e-3, "{estimate:?}");
        // Unwrapped from the first fix on: nearly two turns by now.
        assert!((estimate.heading_rad - (3.0 + 0.2 * estimate.t_s)).abs() < 1e-3, "{estimate:?}");
    }

    #[test]
    fn averaged_corrections_let_no_harmonic_of_the_period_through() {
        // A body at rest whose fixes wobble by 5 mm and 0.05 rad at the first and second harmonic.
        let mut observer = observer();
        let (mut leak_m_s, mut leak_rad_s) = (0.0_f64, 0.0_f64);
        for frame in 0..120 * 60 {
            let t_s = f64::from(frame) / 120.0;
            let phase = TAU * t_s / 1.5;
            observer.update(&fix(t_s, [5e-3 * phase.sin(), 5e-3 * (2.0 * phase).cos()], 0.05 * phase.cos()));
            if t_s > 40.0 {
                let estimate = observer.estimate().expect("has fixes");
                leak_m_s = leak_m_s.max(estimate.velocity_m_s[0].hypot(estimate.velocity_m_s[1]));
                leak_rad_s = leak_rad_s.max(estimate.yaw_rate_rad_s.abs());
            }
        }
        // The true rates are 5e-3·2π/1.5 = 0.021 m/s and 0.21 rad/s.
        println!("leak {leak_m_s:.6} m/s, {leak_rad_s:.6} rad/s");
        assert!(leak_m_s < 0.02 * 0.021 && leak_rad_s < 0.02 * 0.21, "{leak_m_s} m/s {leak_rad_s} rad/s");
    }

    #[test]
    fn an_unknown_force_is_found_and_no_wobble_of_it() {
        // A drift of 0.03 m/s east that no wrench drives, with a wobble as above: d = D·v²/M = 13.5·9e-4/4.5 m/s² holds it.
        let mut observer = observer();
        let mut worst = 0.0_f64;
        for frame in 0..120 * 90 {
            let t_s = f64::from(frame) / 120.0;
            let phase = TAU * t_s / 1.5;
            observer.update(&fix(
                t_s,
                [0.03 * t_s + 1e-3 * (2.0 * phase).sin(), 1e-3 * phase.cos()],
                FRAC_PI_2,
            ));
            if t_s > 60.0 {
                let [d_x, d_y] = observer.estimate().expect("has fixes").unknown_m_s2;
                worst = worst.max((d_x - 2.7e-3).abs()).max(d_y.abs());
            }
        }
        assert!(worst < 2e-5, "{worst} m/s²");
    }

    #[test]
    fn after_a_long_gap_the_pose_is_taken_as_it_is() {
        let mut observer = observer();
        for frame in 0..1200 {
            observer.update(&fix(f64::from(frame) / 120.0, [0.0; 2], 1.0));
        }
        observer.update(&fix(30.0, [2.0, -1.0], 1.5));
        let estimate = observer.estimate().expect("has fixes");
        assert!((estimate.position_m[0] - 2.0).abs() < 1e-12 && (estimate.heading_rad - 1.5).abs() < 1e-12);
        assert!(estimate.velocity_m_s[0].abs() < 1e-9, "no jump of the velocity: {estimate:?}");
        // Out of order: ignored.
        observer.update(&fix(29.0, [9.0, 9.0], 0.0));
        assert_eq!(observer.estimate(), Some(estimate));
    }

    #[test]
    fn impossible_parameters_are_refused_by_name() {
        let structure = Structure::from_word("2x1").expect("two");
        for (parameters, key) in [
            (ObserverParameters { bandwidth_rad_s: 50.0, ..Default::default() }, "bandwidth_rad_s"),
            (ObserverParameters { added_mass: -1.0, ..Default::default() }, "added_mass"),
            (ObserverParameters { added_inertia: f64::NAN, ..Default::default() }, "added_inertia"),
        ] {
            let error = Observer::new(&structure, &Parameters::default(), &parameters).expect_err(key);
            assert_eq!(error.key, key);
        }
    }
}
