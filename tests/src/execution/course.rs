//! Where a tail should be by a decision of the host: formulas of its own, in double precision.
//!
//! ```text
//! φ(t) = from + (to − from)·s(t)                                          each step of a transition
//! s(t) = (h(t) − h(t − tᵣ) − h(t − D + tᵣ) + h(t − D)) / (tᵣ·(D − tᵣ)),   h(x) = ½·max(x, 0)²
//! φ(t) = φ₀ + A·cos(2πt/T)                                                 swim cycle               (1)
//! ```
//!
//! s is the sum of four ramps of speed: up, level, down, level; t/D where the ramps take no time.

use std::f64::consts::TAU;

/// A turn of less than this is none, rad.
const STILL_RAD: f64 = 1e-9;

/// What a tail is meant to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// It rests.
    Rest,
    /// It swings.
    Swing,
    /// It turns from one rest to another.
    Transition,
}

impl Phase {
    /// All of them; each stands at `self as usize`.
    pub const ALL: [Self; 3] = [Self::Rest, Self::Swing, Self::Transition];

    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Swing => "swing",
            Self::Transition => "transition",
        }
    }
}

/// One step of a transition, and the rest after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Where each tail is after it, rad (unwrapped).
    pub to_rad: Vec<f64>,
    /// How long it turns, D, s.
    pub turning_s: f64,
    /// Each of its two ramps, tᵣ, s; zero at constant speed.
    pub ramp_s: f64,
    /// How long it rests then, s.
    pub rest_s: f64,
}

/// One decision as modules carry it out: each step of the transition is an order of its own, the last one with the swim cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Number of the first order.
    pub number: u32,
    /// Its start, s of true time.
    pub start_s: f64,
    /// Where each tail is at the start, rad.
    pub from_rad: Vec<f64>,
    /// One step or two.
    pub steps: Vec<Step>,
    /// (φ₀, A) by module.
    pub swings: Vec<[f64; 2]>,
    /// T, s.
    pub period_s: f64,
    /// What tails are promised to keep of each other in it, m, if anything.
    pub guarantee_m: Option<f64>,
    /// Whether any module may lose its power in it.
    pub power_tolerant: bool,
}

impl Course {
    /// End of its swim cycle, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.steps.iter().fold(self.start_s + self.period_s, |t_s, step| t_s + step.turning_s + step.rest_s)
    }

    /// Whether an order of this number belongs to it.
    #[must_use]
    pub fn has(&self, number: u32) -> bool {
        self.step_of(number).is_some()
    }

    fn step_of(&self, number: u32) -> Option<usize> {
        let step = number.checked_sub(self.number)? as usize;
        (step < self.steps.len()).then_some(step)
    }

    /// What module `module` (from 0) should do at `t_s` by the order `number`: its angle (rad, up to whole turns) and phase. It
    /// rests before the order's start and after its end. Nothing for an order that is not of this decision.
    #[must_use]
    pub fn planned(&self, module: usize, number: u32, t_s: f64) -> Option<(f64, Phase)> {
        let k = self.step_of(number)?;
        let (before, step) = (&self.steps[..k], &self.steps[k]);
        let from_rad = before.last().map_or(self.from_rad[module], |step| step.to_rad[module]);
        let to_rad = step.to_rad[module];
        let start_s = before.iter().fold(self.start_s, |t_s, step| t_s + step.turning_s + step.rest_s);
        let turned_s = t_s - start_s;
        if turned_s < step.turning_s {
            let moves = turned_s >= 0.0 && (to_rad - from_rad).abs() > STILL_RAD;
            let share = share_turned(turned_s, step.turning_s, step.ramp_s);
            let phase = if moves { Phase::Transition } else { Phase::Rest };
            return Some((from_rad + (to_rad - from_rad) * share, phase));
        }
        if k + 1 < self.steps.len() || turned_s < 0.0 {
            return Some((if turned_s < 0.0 { from_rad } else { to_rad }, Phase::Rest));
        }
        let [centerline_rad, amplitude_rad] = self.swings[module];
        let swum_s = turned_s - step.turning_s;
        if swum_s >= self.period_s || amplitude_rad == 0.0 {
            return Some((centerline_rad + amplitude_rad, Phase::Rest));
        }
        // φ = φ₀ + A·cos(2πt/T)                                                                   (1)
        Some((centerline_rad + amplitude_rad * (TAU * swum_s / self.period_s).cos(), Phase::Swing))
    }
}

/// s(t), for t in [0, D]; 0 before it.
#[must_use]
pub fn share_turned(t_s: f64, turning_s: f64, ramp_s: f64) -> f64 {
    if t_s <= 0.0 || turning_s <= 0.0 {
        return 0.0;
    }
    if ramp_s <= 0.0 {
        return t_s / turning_s;
    }
    let h = |x: f64| 0.5 * x.max(0.0) * x.max(0.0);
    let sum = h(t_s) - h(t_s - ramp_s) - h(t_s - turning_s + ramp_s) + h(t_s - turning_s);
    sum / (ramp_s * (turning_s - ramp_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two orders: module 1 turns by 4.5 rad, then by −1; module 2 rests all the time. Then module 1 swings by 2 about −0.5.
    fn course() -> Course {
        let step = |to_rad: f64, rest_s: f64| Step {
            to_rad: vec![to_rad, 0.25],
            turning_s: 0.5,
            ramp_s: 0.05,
            rest_s,
        };
        Course {
            number: 7,
            start_s: 10.0,
            from_rad: vec![-2.0, 0.25],
            steps: vec![step(2.5, 0.1), step(1.5, 0.0)],
            swings: vec![[-0.5, 2.0], [0.25, 0.0]],
            period_s: 1.5,
            guarantee_m: None,
            power_tolerant: true,
        }
    }

    /// 4.5 rad in 0.5 s with ramps of 50 ms: 10 rad/s, 0.25 rad on each ramp.
    #[test]
    fn hand_worked_angles() {
        let course = course();
        for (number, t_s, rad, phase) in [
            (7, 9.0, -2.0, Phase::Rest),
            (7, 10.025, -1.9375, Phase::Transition),
            (7, 10.05, -1.75, Phase::Transition),
            (7, 10.25, 0.25, Phase::Transition),
            (7, 10.475, 2.4375, Phase::Transition),
            (7, 10.5, 2.5, Phase::Rest),
            (7, 20.0, 2.5, Phase::Rest),
            (8, 10.5, 2.5, Phase::Rest),
            (8, 10.85, 2.0, Phase::Transition),
            (8, 11.1, 1.5, Phase::Swing),
            (8, 11.475, -0.5, Phase::Swing),
            (8, 11.85, -2.5, Phase::Swing),
            (8, 12.7, 1.5, Phase::Rest),
        ] {
            let (found_rad, found) = course.planned(0, number, t_s).expect("its number");
            assert!((found_rad - rad).abs() < 1e-12, "{number} at {t_s} s: {found_rad}, {rad}");
            assert_eq!(found, phase, "{number} at {t_s} s");
            assert_eq!(course.planned(1, number, t_s), Some((0.25, Phase::Rest)), "{number} at {t_s} s");
        }
        assert!(course.planned(0, 6, 10.0).is_none() && course.planned(0, 9, 10.0).is_none());
    }

    #[test]
    fn without_ramps_the_speed_is_constant() {
        assert!((share_turned(0.2, 0.5, 0.0) - 0.4).abs() < 1e-15);
        assert!((share_turned(0.5, 0.5, 0.05) - 1.0).abs() < 1e-12);
    }
}
