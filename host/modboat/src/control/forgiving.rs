//! The controller that forgives: it follows a reference that can be followed, takes off what pushes beside the tails, and learns how far
//! thrust and drag differ from what is believed.
//!
//! ```text
//! x̂(start) from the fixes until now and the committed cycle       the delay of one period is in the model      (c1)
//! a_fb = −K₁ (x̂ − x_r) − K₂ (v̂ − v_r)                              K of (g2), per axis of S and in yaw          (c2)
//! F = M [(a_r + (c_L·D·v|v| − p)/M − d)/k_F + a_fb/(k_F + σ_k)]     v: of the reference, in mid-interval         (c3)
//! τ likewise with I, C_R, d_Θ, k_τ, and the Munk moment m·M·v_x·v_y taken off
//! ```
//!
//! (s1) and (f2) of the estimator tell x̂, v̂, d, k and c; (r1) and (r2) are the reference. d is the integral action: it has no
//! limit to wind up to, since the estimator is told the wrench that was planned and not the one that was asked for. A demand beyond what the
//! modules can give is cut down, torque last, and the reference goes on from where the structure will be.
//!
//! σ_k, the standard deviation of k, makes the feedback cautious until k is known. Where little moves it is never known, and it need not be.
//!
//! Gains: the pole of (g2) has the time constants of [`ForgivingConfig`]. Margins of the sampled loop, k and c held, are in the
//! page on the controller and measured by `margins` in the tests.

use serde::{Deserialize, Serialize};

use quantity::{ParameterError, check_within};

use self::estimator::{Estimator, Motion};
use self::gains::Gains;
use self::reference::{Reference, at_most, turn};
use super::limits::Limits;
use super::{ControlConfig, Goal, Moment, Tails};
use crate::motion::Wrench;
use crate::observer::{Fix, ObserverParameters};
use crate::parameters::Parameters;
use crate::structure::Structure;

pub use self::estimator::Factors;

mod estimator;
mod filter;
mod gains;
mod reference;
#[cfg(test)]
mod tests;

/// Share of what can be given that the reference may ask for; the rest is for the feedback. *Assumed.*
const REFERENCE_SHARE: f64 = 0.97;
/// Weights of force, N, and torque, N·m, where what is planned is held against what was demanded.
const WEIGHTS: [f64; 3] = [1.0, 1.0, 10.0];
/// Planned with less than this share missing a demand counts as met. *Assumed.*
const SHORT: f64 = 0.05;
/// Where it is not, so much of the limits is asked for: at least this share of what was, and of the limits; with each that is met it grows
/// by so much. *Assumed.*
const LOST: f64 = 0.7;
const LEAST_REACH: f64 = 0.1;
const REGAINED: f64 = 1.1;
/// How far ahead of the structure the point of a velocity may be: a time at that velocity, s, and a distance besides, m. *Assumed.*
const LEAD: (f64, f64) = (3.0, 0.02);
/// To make up for what was lost, the reference is faster than asked by this share at most. *Assumed.*
const CATCH_UP: f64 = 0.25;
/// Share of the way to v* that the reference goes in one interval. *Assumed*: all of it would ask for a kick and a brake.
const EASE: f64 = 0.7;
/// A decision later than this, s, beyond the end of the last interval begins from where the structure is. *Assumed.*
const BREAK_S: f64 = 1.0;

/// Gains of the forgiving controller. *Assumed*: as fast as the margins in the module's text allow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ForgivingConfig {
    /// Time constant of the double pole of position and velocity where a velocity is asked for, s.
    pub position_time_s: f64,
    /// The same at a station, s.
    pub station_time_s: f64,
    /// The same at a station in gusts, s. Between the two by what the innovations say of the water.
    pub gust_time_s: f64,
    /// The same of the heading, s.
    pub heading_time_s: f64,
    /// K_Θ of (r2), 1/s.
    pub turn_1_s: f64,
    /// Greatest rate of a turn, rad/s.
    pub turn_max_rad_s: f64,
    /// Growth of the acceleration that nothing known explains in a second: its standard deviation in calm water, m/s².
    pub calm_m_s2: f64,
    /// The same in gusts. Which of the two it is nearer to is seen from the innovations.
    pub gusty_m_s2: f64,
    /// The same of yaw, rad/s².
    pub twist_rad_s2: f64,
    /// Growth of the velocity that no acceleration explains in a second: its standard deviation, m/s. It stands for thrust that is not
    /// what it is taken for: with more of it the velocity follows the fixes and not the model, and the loop forgives more.
    pub slip_m_s: f64,
    /// The same of yaw, rad/s.
    pub slip_rad_s: f64,
    /// Standard deviation of a cycle's mean heading about what it is taken for, rad.
    pub heading_seen_rad: f64,
    /// How far torque and yaw drag may differ from what is believed, as a share; 0: they are not learned.
    pub unsure_yaw: f64,
    /// How far thrust and drag may differ from what is believed, as a share; 0: they are not learned.
    pub unsure: f64,
    /// By how much more mass with water the structure has in surge than in sway, over their mean: what the Munk moment grows with.
    pub munk: f64,
    /// How far that may be off; 0: it is not learned.
    pub unsure_munk: f64,
    /// By how much more drag the structure has in surge than in sway, over their mean.
    pub drag_difference: f64,
    /// How far a module's share of law (2) may differ from the others'; 0: weak modules are not looked for.
    pub unsure_share: f64,
}

impl Default for ForgivingConfig {
    fn default() -> Self {
        Self {
            position_time_s: 4.0,
            station_time_s: 2.5,
            gust_time_s: 1.6,
            heading_time_s: 3.0,
            turn_1_s: 0.3,
            turn_max_rad_s: 0.2,
            calm_m_s2: 5e-5,
            gusty_m_s2: 1e-3,
            twist_rad_s2: 1e-3,
            slip_m_s: 3e-4,
            slip_rad_s: 1e-3,
            heading_seen_rad: 8e-4,
            unsure_yaw: 0.3,
            unsure: 0.3,
            munk: 0.0,
            unsure_munk: 0.0,
            drag_difference: 0.0,
            unsure_share: 0.2,
        }
    }
}

impl ForgivingConfig {
    /// Refuses what cannot work, by the first offending key.
    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let time = "must be from 0.5 to 100";
        check_within(&[
            ("position_time_s", self.position_time_s, "s", 0.5..=100.0, time),
            ("station_time_s", self.station_time_s, "s", 0.5..=100.0, time),
            ("gust_time_s", self.gust_time_s, "s", 0.5..=100.0, time),
            ("heading_time_s", self.heading_time_s, "s", 0.5..=100.0, time),
            ("turn_1_s", self.turn_1_s, "1/s", 0.01..=1.0, "must be from 0.01 to 1"),
            ("calm_m_s2", self.calm_m_s2, "m/s²", 1e-9..=1.0, "must be from 1e-9 to 1"),
            ("gusty_m_s2", self.gusty_m_s2, "m/s²", 1e-9..=1.0, "must be from 1e-9 to 1"),
            ("slip_m_s", self.slip_m_s, "m/s", 0.0..=1.0, "must be from 0 to 1"),
            ("slip_rad_s", self.slip_rad_s, "rad/s", 0.0..=1.0, "must be from 0 to 1"),
            ("heading_seen_rad", self.heading_seen_rad, "rad", 1e-6..=1.0, "must be from 0.000001 to 1"),
            ("unsure_yaw", self.unsure_yaw, "", 0.0..=1.0, "must be from 0 to 1"),
            ("twist_rad_s2", self.twist_rad_s2, "rad/s²", 0.0..=1.0, "must be from 0 to 1"),
            ("unsure", self.unsure, "", 0.0..=1.0, "must be from 0 to 1"),
            ("munk", self.munk, "", -0.7..=0.7, "must be from -0.7 to 0.7"),
            ("unsure_munk", self.unsure_munk, "", 0.0..=1.0, "must be from 0 to 1"),
            ("drag_difference", self.drag_difference, "", -1.9..=1.9, "must be from -1.9 to 1.9"),
            ("unsure_share", self.unsure_share, "", 0.0..=1.0, "must be from 0 to 1"),
            ("turn_max_rad_s", self.turn_max_rad_s, "rad/s", 0.001..=10.0, "must be from 0.001 to 10"),
        ])
    }
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Forgiving {
    config: ForgivingConfig,
    station_1_s: f64,
    station_max_m_s: f64,
    period_s: f64,
    limits: Limits,
    estimator: Estimator,
    reference: Option<Reference>,
    /// What was demanded last.
    demanded: Demanded,
    /// Share of the limits that is asked for: less than one where planners find less than they are asked for.
    reach: f64,
}

/// A demand, where the structure will be when it begins, and the interval over the period.
#[derive(Clone, Copy, Debug, Default)]
struct Demanded {
    wrench: Wrench,
    ahead: Motion,
    duty: f64,
}

impl Forgiving {
    /// A controller that knows nothing yet.
    #[must_use]
    pub fn new(
        structure: &Structure,
        parameters: &Parameters,
        config: &ControlConfig,
        observer: &ObserverParameters,
    ) -> Self {
        Self {
            config: config.forgiving.clone(),
            station_1_s: config.position_proportional_1_s,
            station_max_m_s: config.position_speed_max_m_s,
            period_s: parameters.period_s,
            limits: Limits::new(structure, parameters, config),
            estimator: Estimator::new(structure, parameters, observer, &config.forgiving),
            reference: None,
            demanded: Demanded::default(),
            reach: 1.0,
        }
    }

    /// Takes a fix.
    pub fn update(&mut self, fix: &Fix) {
        self.estimator.update(fix);
    }

    /// The mean wrench of the tails from `t_s` on, transition included, and what they do.
    pub fn set_wrench(&mut self, t_s: f64, wrench: Wrench, tails: Option<Tails>) {
        self.estimator.set_wrench(t_s, wrench, tails);
    }

    /// The wrench that the tails have given since the last [`set_wrench`](Self::set_wrench) is taken for `wrench` from now on: what the modules give
    /// is known better. What was held for a push from outside is less by as much.
    pub fn correct_wrench(&mut self, wrench: Wrench) {
        self.estimator.correct_wrench(wrench);
    }

    /// m is known to be `munk`; what was held for a push from outside is less by as much.
    pub fn set_munk(&mut self, munk: f64) {
        self.estimator.set_munk(munk);
    }

    /// How far thrust and drag are found to differ from what is believed.
    #[must_use]
    pub fn factors(&self) -> Factors {
        self.estimator.factors
    }

    /// The wrench to demand of the cycle that starts at `moment.start_s`.
    pub fn demand(&mut self, goal: &Goal, moment: &Moment) -> Wrench {
        if !self.estimator.has_begun() {
            return Wrench::default();
        }
        self.estimator.correct();
        let h = moment.interval_s;
        let ahead = self.estimator.ahead(moment.start_s);
        let mut reference = self.reference_at(goal, moment, &ahead);
        // Pushing lasts T of every interval.
        let duty = (h / self.period_s).max(1.0);
        self.push(goal, h, duty, &mut reference);
        let time_s = self.time_s(goal);
        let (force_n, torque_nm) = self.follow(&reference, &ahead, h, time_s);
        let tau_nm = self.limits.clamp_torque(duty * torque_nm);
        let [fx_n, fy_n] = force_n.map(|force_n| duty * force_n);
        let scale = self.limits.force_scale([fx_n, fy_n].map(|force_n| force_n / self.reach), tau_nm);
        let wrench = Wrench { fx_n: scale * fx_n, fy_n: scale * fy_n, tau_nm };
        self.give_way(&mut reference, &ahead, scale, tau_nm - duty * torque_nm);
        self.reference = Some(reference);
        self.demanded = Demanded { wrench, ahead, duty };
        wrench
    }

    /// What the planner found for the last demand. Where that is less, the reference goes on by what it gives, and less is asked for until
    /// demands are met again: a demand that outgrows what can be planned makes plans worse, not better.
    pub fn planned(&mut self, wrench: Wrench) {
        let Demanded { wrench: demand, ahead, duty } = self.demanded;
        let size = demand.weighted_norm(WEIGHTS);
        let missing = (demand - wrench).weighted_norm(WEIGHTS);
        if missing <= SHORT * size {
            self.reach = (self.reach * REGAINED).min(1.0);
            return;
        }
        self.reach = (self.reach * (1.0 - missing / size).max(LOST)).max(LEAST_REACH);
        if let Some(reference) = &mut self.reference {
            let mean = Wrench::from_array(wrench.to_array().map(|component| component / duty));
            (reference.pose, reference.rate) = (ahead.pose, ahead.rate);
            reference.acceleration = self.estimator.acceleration(mean, ahead.pose[2], ahead.rate);
        }
    }

    /// The reference at the start: where the last one has come to, or where the structure will be.
    fn reference_at(&self, goal: &Goal, moment: &Moment, ahead: &Motion) -> Reference {
        let here = [ahead.pose[0], ahead.pose[1]];
        let asked_m_s = if goal.station_m.is_some() { [0.0; 2] } else { goal.target.velocity_m_s };
        let goes_on = self.reference.filter(|last| {
            !goal.is_bounded && (0.0..last.for_s + BREAK_S).contains(&(moment.start_s - last.t_s))
        });
        let mut reference = match goes_on {
            Some(last) => last.at(moment.start_s),
            None => Reference {
                t_s: moment.start_s,
                pose: ahead.pose,
                rate: ahead.rate,
                acceleration: [0.0; 3],
                for_s: 0.0,
                point_m: here,
                asked_m_s,
            },
        };
        if let Some(station_m) = goal.station_m {
            reference.point_m = station_m;
        } else if goal.is_bounded
            || [0, 1].iter().any(|&k| (asked_m_s[k] - reference.asked_m_s[k]).abs() > 0.0)
        {
            reference.point_m = [reference.pose[0], reference.pose[1]];
        } else {
            // The point does not run away from a structure that cannot follow.
            let speed = asked_m_s[0].hypot(asked_m_s[1]);
            let lead = at_most([0, 1].map(|k| reference.point_m[k] - here[k]), LEAD.0 * speed + LEAD.1);
            reference.point_m = [0, 1].map(|k| here[k] + lead[k]);
        }
        reference.asked_m_s = asked_m_s;
        reference
    }

    /// Accelerations of the reference over the interval, by (r1) and (r2).
    fn push(&self, goal: &Goal, h: f64, duty: f64, reference: &mut Reference) {
        let ForgivingConfig { turn_1_s, turn_max_rad_s, .. } = self.config;
        let model = &self.estimator.model;
        let most = REFERENCE_SHARE * self.limits.torque_nm() * self.estimator.factors.torque.min(1.0)
            / (duty * model.inertia_kg_m2);
        let alpha = turn(reference, goal.target.heading_rad, h, turn_1_s, turn_max_rad_s, most);
        reference.acceleration = [0.0, 0.0, alpha];
        reference.for_s = h;
        // v* = v_des + w,  a = s·0.7 (v* − v_r)/h                                                       (r1)
        let behind = [0, 1].map(|k| self.station_1_s * (reference.point_m[k] - reference.pose[k]));
        let speed = reference.asked_m_s[0].hypot(reference.asked_m_s[1]);
        let most = if goal.station_m.is_some() { self.station_max_m_s } else { CATCH_UP * speed };
        let more = at_most(behind, most);
        let wanted = [0, 1].map(|k| EASE * (reference.asked_m_s[k] + more[k] - reference.rate[k]) / h);
        let fits = |share: f64| {
            let mut tried = *reference;
            (0..2).for_each(|k| tried.acceleration[k] = share * wanted[k]);
            let motion = Motion { pose: tried.pose, rate: tried.rate };
            let (force_n, torque_nm) = self.follow(&tried, &motion, h, self.time_s(goal));
            let force_n = force_n.map(|force_n| duty * force_n / (REFERENCE_SHARE * self.reach));
            self.limits.force_scale(force_n, self.limits.clamp_torque(duty * torque_nm)) >= 1.0
        };
        let share = if fits(1.0) {
            1.0
        } else {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..10 {
                let middle = 0.5 * (low + high);
                if fits(middle) { low = middle } else { high = middle }
            }
            low
        };
        (0..2).for_each(|k| reference.acceleration[k] = share * wanted[k]);
    }

    fn time_s(&self, goal: &Goal) -> f64 {
        let ForgivingConfig { position_time_s, station_time_s, gust_time_s, .. } = self.config;
        if goal.station_m.is_none() {
            return position_time_s;
        }
        station_time_s * (gust_time_s / station_time_s).powf(self.estimator.gustiness())
    }

    /// Mean force in S and torque that make a structure at `ahead` follow `reference` over h, by (c2) and (c3).
    fn follow(&self, reference: &Reference, ahead: &Motion, h: f64, time_s: f64) -> ([f64; 2], f64) {
        let Estimator { model, factors, unknown, .. } = &self.estimator;
        let [unsure_force, unsure_torque] = self.estimator.unsure();
        let middle = reference.at(reference.t_s + 0.5 * h);
        let (sin, cos) = (ahead.pose[2] + 0.5 * h * middle.rate[2]).sin_cos();
        // World → S: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
        let to_s = |[x, y]: [f64; 2]| [x * sin - y * cos, x * cos + y * sin];
        let apart = |axis: usize| ahead.pose[axis] - reference.pose[axis];
        let faster = |axis: usize| ahead.rate[axis] - reference.rate[axis];
        let (apart_m, faster_m_s) = (to_s([apart(0), apart(1)]), to_s([faster(0), faster(1)]));
        let velocity = to_s([middle.rate[0], middle.rate[1]]);
        let wanted = to_s([0, 1].map(|k| reference.acceleration[k] - unknown[k]));
        let omega = middle.rate[2];
        let passed_n = model.passed_n(velocity, omega);
        let force_n = [0, 1].map(|k| {
            let mass_kg = model.masses_kg[k];
            let drag_1_m = factors.drag * model.drag_n_s2_m2[k] / mass_kg;
            let slope_1_s = 2.0 * drag_1_m * velocity[k].abs();
            let gains = Gains::placed(h, slope_1_s, time_s);
            // a_fb = −K₁ (x̂ − x_r) − K₂ (v̂ − v_r)                                                 (c2)
            let feedback = gains.against(apart_m[k], faster_m_s[k]);
            // F = M [(a_r + (c_L·D·v|v| − p)/M − d)/k_F + a_fb/(k_F + σ_k)]                         (c3)
            let known = wanted[k] + drag_1_m * velocity[k] * velocity[k].abs() - passed_n[k] / mass_kg;
            mass_kg * (known / factors.force + feedback / (factors.force + unsure_force))
        });
        let drag = factors.yaw_drag * model.yaw_drag_n_m_s2 / model.inertia_kg_m2;
        let gains = Gains::placed(h, 2.0 * drag * omega.abs(), self.config.heading_time_s);
        let feedback = gains.against(apart(2), faster(2));
        let munk = factors.munk * self.estimator.munk_rad_s2(velocity[0], velocity[1]);
        let known = reference.acceleration[2] - unknown[2] + drag * omega * omega.abs() + munk;
        let torque_nm =
            model.inertia_kg_m2 * (known / factors.torque + feedback / (factors.torque + unsure_torque));
        (force_n, torque_nm)
    }

    /// What cannot be given is not asked for later: the reference goes on from where the structure is.
    fn give_way(&self, reference: &mut Reference, ahead: &Motion, scale: f64, cut_nm: f64) {
        if scale < 1.0 {
            for axis in 0..2 {
                (reference.pose[axis], reference.rate[axis]) = (ahead.pose[axis], ahead.rate[axis]);
                reference.acceleration[axis] *= scale;
            }
        }
        if cut_nm != 0.0 {
            (reference.pose[2], reference.rate[2]) = (ahead.pose[2], ahead.rate[2]);
        }
    }
}
