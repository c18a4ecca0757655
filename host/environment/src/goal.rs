//! What is asked of an episode, and what it costs to miss it.
//!
//! ```text
//! reward = −(Δt/T)·(e/e₀ + |wrap(Θ_des − Θ)|/Θ₀) − contacts
//! e, e₀  = ‖v̄ − v_des‖, 0.04 m/s          where a velocity is asked for, v̄ the mean over the step
//!        = ‖x_des − x‖, 0.15 m             where a station is
//! ```
//!
//! | symbol | meaning | value |
//! |---|---|---|
//! | Δt | length of the step, from decision to decision | s |
//! | T | period of waveform (1) | 1.5 s by default |
//! | e₀ | 0.04 m/s: the speed of the paper's experiments; 0.15 m: the pitch, a module's side | *assumed* |
//! | Θ₀ | 1 rad | *assumed* |
//!
//! By time and not by step: steps differ in length, and a policy shall not gain by long ones. Every agent of a structure has the same
//! reward.

use std::f64::consts::PI;

use host::run::scenario::{Demand, Scenario, Start};
use quantity::wrap_rad;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use record::PoseSample;

use crate::settings::Task;

/// e₀ of a velocity, m/s.
pub const SPEED_M_S: f64 = 0.04;
/// e₀ of a station, m.
pub const PLACE_M: f64 = 0.15;
/// Θ₀, rad.
pub const HEADING_RAD: f64 = 1.0;
/// Greatest distance of a drawn station from the start, m. *Assumed.*
pub const FAR_M: f64 = 0.5;

/// What is asked for at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Velocity or station, in the world.
    pub demand: Demand,
    /// Heading Θ, rad.
    pub heading_rad: f64,
}

impl Asked {
    /// Reward of a step of `interval_s` from `before` to `now`, without contacts; T is `period_s`.
    #[must_use]
    pub fn reward(&self, before: &PoseSample, now: &PoseSample, period_s: f64) -> f64 {
        let interval_s = now.t_s - before.t_s;
        let missed = match self.demand {
            Demand::Velocity(velocity_m_s) => {
                let mean_m_s = mean_velocity_m_s(before, now);
                let [x, y] = [0, 1].map(|axis| mean_m_s[axis] - velocity_m_s[axis]);
                x.hypot(y) / SPEED_M_S
            }
            Demand::Station(station_m) => {
                let [x, y] = [0, 1].map(|axis| station_m[axis] - now.position_m[axis]);
                x.hypot(y) / PLACE_M
            }
        };
        let turned = wrap_rad(self.heading_rad - now.heading_rad).abs() / HEADING_RAD;
        -(interval_s / period_s) * (missed + turned)
    }
}

/// Mean velocity in the world from `before` to `now`, m/s; zero where no time lies between them.
pub(crate) fn mean_velocity_m_s(before: &PoseSample, now: &PoseSample) -> [f64; 2] {
    let interval_s = now.t_s - before.t_s;
    if interval_s > 0.0 {
        [0, 1].map(|axis| (now.position_m[axis] - before.position_m[axis]) / interval_s)
    } else {
        [0.0; 2]
    }
}

/// The same of the heading, rad/s.
pub(crate) fn mean_yaw_rate_rad_s(before: &PoseSample, now: &PoseSample) -> f64 {
    let interval_s = now.t_s - before.t_s;
    if interval_s > 0.0 { (now.heading_rad - before.heading_rad) / interval_s } else { 0.0 }
}

/// Draws an episode: where the structure starts, into `start`, and what is asked for. Legs are those of the scenario, and so is their
/// start.
pub(crate) fn draw(task: Task, rng: &mut ChaCha8Rng, scenario: &Scenario, start: &mut Start) -> Asked {
    if task == Task::Legs {
        *start = scenario.start.clone();
        return asked(scenario, 0.0);
    }
    let mut angle_rad = || rng.random_range(-PI..PI);
    let (start_rad, heading_rad, way_rad) = (angle_rad(), angle_rad(), angle_rad());
    let share = rng.random::<f64>();
    let (sin, cos) = way_rad.sin_cos();
    *start = Start { position_m: [0.0; 2], heading_rad: Some(start_rad), tail_rad: scenario.start.tail_rad };
    let demand = match task {
        Task::Station => {
            // Uniform over the disc.
            let far_m = FAR_M * share.sqrt();
            Demand::Station([far_m * cos, far_m * sin])
        }
        _ => Demand::Velocity([SPEED_M_S * share * cos, SPEED_M_S * share * sin]),
    };
    Asked { demand, heading_rad }
}

/// What the legs ask for at `t_s`.
pub(crate) fn asked(scenario: &Scenario, t_s: f64) -> Asked {
    let leg = &scenario.legs[scenario.leg_at(t_s)];
    Asked { demand: leg.demand, heading_rad: leg.heading_rad }
}
