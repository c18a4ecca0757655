//! Margins of the sampled loop, from its own response: controller and observer as they are, a rigid body for the water.
//!
//! At a station at rest one cycle pushes by s beside what the controller demands. With u_n what it demands of cycle n, and s_n that push,
//!
//! ```text
//! L(ω) = −U(ω)/(U(ω) + S(ω)),    U(ω) = Σ u_n e^(−jωnT)                                            (m1)
//! ```
//!
//! is the open loop, cut where the thrust meets the body. Gain margins are 1/|L| where L is real and negative, the phase margin is the
//! least distance of its phase from π where |L| = 1.
//!
//! Assumptions: no drag (at rest its slope is zero, which is the hardest case), no wobble, no noise, thrust and drag not learned,
//! decisions one lead before each cycle.

use std::f64::consts::{PI, TAU};

use super::{ControlConfig, Controller, Goal, Moment, Observation, Target};
use crate::motion::Wrench;
use crate::observer::{Fix, Observer, ObserverParameters};
use crate::parameters::Parameters;
use crate::structure::Structure;

/// Fixes in a period.
const FIXES: u32 = 60;
/// Cycles after which nothing is left of the push.
const CYCLES: usize = 160;
/// Frequencies looked at, from a hundredth of the greatest one to that.
const FREQUENCIES: u32 = 600;

/// Which motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Along the surge axis.
    Surge,
    /// Yaw.
    Heading,
}

/// How far the loop is from its limit of stability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// The least factor above one on thrust over inertia at which it oscillates for ever.
    pub gain: f64,
    /// The greatest below one; 0 where there is none.
    pub least_gain: f64,
    /// Phase margin, rad.
    pub phase_rad: f64,
}

/// The loop: what is simulated for (m1).
pub struct Loop<'a> {
    /// Structure.
    pub structure: &'a Structure,
    /// Modules.
    pub parameters: &'a Parameters,
    /// The controller.
    pub control: &'a ControlConfig,
    /// The observer.
    pub observer: &'a ObserverParameters,
    /// Time from a decision to the start of its cycle, s.
    pub lead_s: f64,
}

impl Loop<'_> {
    /// Its margins; `None` for parameters that the observer does not take.
    #[must_use]
    pub fn margins(&self, axis: Axis) -> Option<Margins> {
        let push = match axis {
            Axis::Surge => Wrench { fy_n: 1e-4, ..Wrench::default() },
            Axis::Heading => Wrench { tau_nm: 1e-5, ..Wrench::default() },
        };
        let demands = self.response(push, 1.0)?;
        let part = |wrench: &Wrench| match axis {
            Axis::Surge => wrench.fy_n,
            Axis::Heading => wrench.tau_nm,
        };
        let size = part(&push);
        let mut margins = Margins { gain: f64::INFINITY, least_gain: 0.0, phase_rad: PI };
        let mut last: Option<[f64; 2]> = None;
        for step in 0..FREQUENCIES {
            // ωT from π/100 to π, the greatest that sampling knows.
            let angle = PI * 100.0_f64.powf(f64::from(step + 1) / f64::from(FREQUENCIES) - 1.0);
            let mut u = [0.0; 2];
            for (n, wrench) in demands.iter().enumerate() {
                let (sin, cos) = (angle * n as f64).sin_cos();
                u = [u[0] + part(wrench) / size * cos, u[1] - part(wrench) / size * sin];
            }
            // L = −U/(U + 1): the push is one cycle, n = 0.
            let below = (u[0] + 1.0).powi(2) + u[1] * u[1];
            let open = [-(u[0] * (u[0] + 1.0) + u[1] * u[1]) / below, -u[1] / below];
            margins.look(last, open);
            last = Some(open);
        }
        Some(margins)
    }

    /// What is demanded cycle by cycle after `push`, of a body whose thrust over inertia is `gain` times that believed.
    #[must_use]
    pub fn response(&self, push: Wrench, gain: f64) -> Option<Vec<Wrench>> {
        let still = Parameters { drag_n_s2_m2: 1e-9, yaw_drag_n_m_s2: 1e-12, ..self.parameters.clone() };
        let mut control = self.control.clone();
        (control.forgiving.unsure, control.forgiving.unsure_yaw) = (0.0, 0.0);
        // The faster of its two paces.
        control.forgiving.calm_m_s2 = control.forgiving.gusty_m_s2;
        let mut observer = Observer::new(self.structure, &still, self.observer).ok()?;
        let mut controller = Controller::new(self.structure, &still, &control, self.observer);
        let mass_kg = (1.0 + self.observer.added_mass) * self.structure.mass_kg(&still);
        let inertia_kg_m2 = (1.0 + self.observer.added_inertia) * self.structure.inertia_kg_m2(&still);
        let period_s = still.period_s;
        let dt_s = period_s / f64::from(FIXES);
        let lead = (self.lead_s / dt_s).round().clamp(1.0, f64::from(FIXES - 1)) as u32;
        let (mut x_m, mut v_m_s, mut theta_rad, mut omega_rad_s) = (0.0, 0.0, 0.0, 0.0);
        let mut running = Wrench::default();
        let mut demands = Vec::with_capacity(CYCLES);
        // Ten periods before the push.
        for cycle in 0..CYCLES + 10 {
            let pushed = if cycle == 10 { running + push } else { running };
            let mut next = Wrench::default();
            for step in 0..FIXES {
                let t_s = (cycle as f64 * f64::from(FIXES) + f64::from(step)) * dt_s;
                if step == 0 {
                    observer.set_wrench(t_s, running);
                    controller.set_wrench(t_s, running, None);
                }
                // Heading 0: surge along x.
                let (a, alpha) = (gain * pushed.fy_n / mass_kg, gain * pushed.tau_nm / inertia_kg_m2);
                x_m += dt_s * (v_m_s + 0.5 * dt_s * a);
                theta_rad += dt_s * (omega_rad_s + 0.5 * dt_s * alpha);
                (v_m_s, omega_rad_s) = (v_m_s + dt_s * a, omega_rad_s + dt_s * alpha);
                if !(x_m.abs() < 1e3 && theta_rad.abs() < 1e3) {
                    return Some(demands);
                }
                let now_s = t_s + dt_s;
                let fix =
                    Fix { t_s: now_s, position_m: [x_m, 0.0], heading_rad: quantity::wrap_rad(theta_rad) };
                observer.update(&fix);
                controller.update(&fix);
                if step + 1 == FIXES - lead {
                    let seen = observer.estimate()?;
                    let observed = Observation {
                        velocity_m_s: seen.velocity_m_s,
                        heading_rad: seen.heading_rad,
                        yaw_rate_rad_s: seen.yaw_rate_rad_s,
                        unknown_m_s2: seen.unknown_m_s2,
                        unknown_rad_s2: seen.unknown_rad_s2,
                    };
                    let moment =
                        Moment { now_s, start_s: now_s + f64::from(lead) * dt_s, interval_s: period_s };
                    let velocity_m_s =
                        self.control.towards([0.0; 2], seen.position_m, &observed, moment.horizon_s());
                    let target = Target { velocity_m_s, heading_rad: 0.0 };
                    let goal = Goal { target, station_m: Some([0.0; 2]), is_bounded: false };
                    next = controller.demand(&goal, &observed, &moment);
                }
            }
            if cycle >= 10 {
                demands.push(running);
            }
            running = next;
        }
        Some(demands)
    }
}

impl Margins {
    /// Takes what lies between two neighbouring points of the open loop.
    fn look(&mut self, before: Option<[f64; 2]>, [re, im]: [f64; 2]) {
        let Some([re_0, im_0]) = before else { return };
        if im_0 * im <= 0.0 && (im_0 - im).abs() > 0.0 {
            let share = im_0 / (im_0 - im);
            let crossing = re_0 + share * (re - re_0);
            if crossing < 0.0 {
                let factor = -1.0 / crossing;
                if factor >= 1.0 {
                    self.gain = self.gain.min(factor);
                } else {
                    self.least_gain = self.least_gain.max(factor);
                }
            }
        }
        let (size_0, size) = (re_0.hypot(im_0), re.hypot(im));
        if (size_0 - 1.0) * (size - 1.0) <= 0.0 && (size_0 - size).abs() > 0.0 {
            let share = (size_0 - 1.0) / (size_0 - size);
            let (re, im) = (re_0 + share * (re - re_0), im_0 + share * (im - im_0));
            let phase = im.atan2(re).rem_euclid(TAU);
            self.phase_rad = self.phase_rad.min((phase - PI).abs());
        }
    }
}
