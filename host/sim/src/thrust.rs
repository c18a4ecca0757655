//! Thrust of one module from the actual angle of its tail, whatever was commanded.
//!
//! A *swing* runs from one turning point of the tail (the anchor φ_a) to the next, through the swept angle
//! s = |φ − φ_a|. With slope and offset of law (2), T the period for which that law was measured and
//! u(m) = (cos m, sin m), the impulse that a swing has given the structure so far is
//!
//! ```text
//! J(s) = (T/2)·max(0, ½·slope·s − offset)                                                         (t1)
//! P    = −J(s)·u(φ_a + (φ − φ_a)/2)            against the running midpoint of the swing           (t2)
//! f    = dP/dt                                                                                    (t3)
//! ```
//!
//! A whole swing of waveform (1) sweeps s = 2|A| about φ₀, so it ends with P = −F(A)·(T/2)·u(φ₀): averaged over a
//! cycle that is law (2) in the direction of (7), from the angle alone. The next swing starts with P = 0, and
//! what was delivered stays delivered.
//!
//! Physically: the flippers are passive. After a turn the tail sweeps some 2·offset/slope = 1.73 rad until they
//! have opened and push; a smaller wiggle stirs water and gives nothing. From then on a faster swing pushes
//! harder for a shorter time, with the same impulse. Turns are found where φ̇ changes sign, and where the tail
//! has slowed below `rest_speed_rad_s` and speeds up again.
//!
//! A neighbour in the way of the jet takes a share of it. The jet goes along u(m), m the running midpoint; with n_j to each docked
//! neighbour and κ the interaction, the impulse is
//!
//! ```text
//! P·(1 − κ·Σⱼ max(0, u(m)·n_j)²)                                                                  (t4)
//! ```
//!
//! so that a jet straight at a neighbour loses κ, and one along the free side nothing.
//!
//! Assumptions and limits: the paper gives the mean over a cycle only; how it spreads over the swing (t1) is
//! *assumed*. Independent of the structure's own speed through the water. A transition that sweeps more than
//! 1.73 rad pushes too: that is the disturbance the paper speaks of. One that runs on into a swim cycle in the same
//! direction without slowing down between them counts as one long swing with it. The direction (t2) is
//! meant for swings up to 2·2.6 rad; a tail spun on for turns pushes around and around.

use modboat::parameters::Parameters;
use quantity::ParameterError;
use quantity::{Range, check_ranges};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

use super::TailState;

/// The flippers as they really are: law (2), how it differs between modules, and how turning points are told. *Assumed.*
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThrustParameters {
    /// Below this tail speed the flippers fall shut, rad/s: the next swing is counted from here.
    pub(crate) rest_speed_rad_s: f64,
    /// Slope of law (2), N/rad; as in `[modboat]` if it is not given.
    pub(crate) slope_n_rad: Option<f64>,
    /// Offset of law (2), N; as in `[modboat]` if it is not given.
    pub(crate) offset_n: Option<f64>,
    /// The thrust of every module differs by at most this share from that law.
    pub(crate) spread: f64,
    /// Share of that law that each module's flippers give, beside the spread; empty: one.
    pub(crate) module_share: Vec<f64>,
    /// κ of (t4).
    pub(crate) interaction: f64,
}

impl Default for ThrustParameters {
    fn default() -> Self {
        Self {
            rest_speed_rad_s: 0.5,
            slope_n_rad: None,
            offset_n: None,
            spread: 0.0,
            module_share: Vec::new(),
            interaction: 0.0,
        }
    }
}

impl ThrustParameters {
    /// Refuses what no flippers of so many modules can have.
    pub(crate) fn validate(&self, modules: usize) -> Result<(), ParameterError> {
        check_ranges(&[
            ("rest_speed_rad_s", self.rest_speed_rad_s, "rad/s", Range::NonNegative),
            ("slope_n_rad", self.slope_n_rad.unwrap_or(1.0), "N/rad", Range::Positive),
            ("offset_n", self.offset_n.unwrap_or(0.0), "N", Range::NonNegative),
            ("spread", self.spread, "", Range::Share),
            ("interaction", self.interaction, "", Range::Share),
        ])?;
        for &share in &self.module_share {
            check_ranges(&[("module_share", share, "", Range::NonNegative)])?;
        }
        let count = self.module_share.len();
        if count != 0 && count != modules {
            let reason = "must be one for each module of the structure, or none";
            return Err(ParameterError { key: "module_share", value: count as f64, unit: "numbers", reason });
        }
        Ok(())
    }

    /// What the flippers of each module give of law (2), drawn from `seed`; those of `believed` where no `module_share` is said.
    pub(crate) fn shares(&self, believed: &Parameters, modules: usize, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let share = |module: usize| {
            let differs = self.spread * rng.random_range(-1.0..=1.0);
            self.module_share.get(module).copied().unwrap_or(believed.share(module)) * (1.0 + differs)
        };
        (0..modules).map(share).collect()
    }
}

/// The flippers of one module: where its present swing began, and what that has delivered.
#[derive(Clone, Debug)]
pub struct Thrust {
    half_period_s: f64,
    slope_n_rad: f64,
    offset_n: f64,
    rest_speed_rad_s: f64,
    interaction: f64,
    /// n_j of (t4).
    neighbours: Vec<[f64; 2]>,
    /// φ_a of the present swing, rad; none before the first.
    anchor_rad: Option<f64>,
    /// Sign of φ̇ in the present swing.
    direction: f64,
    /// Where the next swing will be counted from, once it begins.
    turning_rad: Option<f64>,
    /// P of the present swing, N·s.
    delivered_n_s: [f64; 2],
}

impl Thrust {
    /// Flippers at rest wherever the first step finds the tail; T is the period of law (2) in `parameters`.
    #[must_use]
    pub fn new(parameters: &Parameters, thrust: &ThrustParameters) -> Self {
        Self {
            half_period_s: 0.5 * parameters.period_s,
            slope_n_rad: parameters.force_slope_n_rad,
            offset_n: parameters.force_offset_n,
            rest_speed_rad_s: thrust.rest_speed_rad_s,
            interaction: thrust.interaction,
            neighbours: Vec::new(),
            anchor_rad: None,
            direction: 0.0,
            turning_rad: None,
            delivered_n_s: [0.0; 2],
        }
    }

    /// The same flippers that give `share` of law (2), on a module with docked neighbours in these directions.
    pub(crate) fn on_module(self, share: f64, neighbours: Vec<[f64; 2]>) -> Self {
        let (slope_n_rad, offset_n) = (share * self.slope_n_rad, share * self.offset_n);
        Self { slope_n_rad, offset_n, neighbours, ..self }
    }

    /// The tail has come to where it is unseen: it pushes with the next swing that begins.
    pub(crate) fn forget(&mut self) {
        (self.anchor_rad, self.turning_rad) = (None, None);
        (self.direction, self.delivered_n_s) = (0.0, [0.0; 2]);
    }

    /// The mean force (x, y) in S, N, over the step of `dt_s` that ended with the tail as given.
    pub fn step(&mut self, dt_s: f64, tail: &TailState) -> [f64; 2] {
        let rate_rad_s = tail.rate_rad_s;
        let speeds_up = rate_rad_s * tail.acceleration_rad_s2 > 0.0;
        let slow = rate_rad_s.abs() < self.rest_speed_rad_s;
        if slow && !speeds_up {
            // Still slowing down or resting: the turn, if there is one, is not before here.
            self.turning_rad = Some(tail.angle_rad);
        } else {
            let unseen_turn = self.anchor_rad.is_none() || rate_rad_s * self.direction < 0.0;
            let turning_rad = self.turning_rad.take().or(unseen_turn.then_some(tail.angle_rad));
            if turning_rad.is_some() {
                self.anchor_rad = turning_rad;
                self.direction = rate_rad_s.signum();
                self.delivered_n_s = [0.0; 2];
            }
        }
        let impulse_n_s = self.impulse_n_s(tail.angle_rad);
        // f = dP/dt                                                                                (t3)
        let force_n = [0, 1].map(|axis| (impulse_n_s[axis] - self.delivered_n_s[axis]) / dt_s);
        self.delivered_n_s = impulse_n_s;
        force_n
    }

    /// P of the present swing with the tail at `angle_rad`, N·s.
    fn impulse_n_s(&self, angle_rad: f64) -> [f64; 2] {
        let anchor_rad = self.anchor_rad.unwrap_or(angle_rad);
        let swept_rad = angle_rad - anchor_rad;
        // J(s) = (T/2)·max(0, ½·slope·s − offset)                                                  (t1)
        let mean_n = 0.5 * self.slope_n_rad * swept_rad.abs() - self.offset_n;
        if mean_n <= 0.0 {
            return [0.0; 2];
        }
        // P = −J(s)·u(φ_a + (φ − φ_a)/2)                                                           (t2)
        let (sin, cos) = (anchor_rad + 0.5 * swept_rad).sin_cos();
        // P·(1 − κ·Σⱼ max(0, u(m)·n_j)²)                                                            (t4)
        let against = self.neighbours.iter().map(|[x, y]| (cos * x + sin * y).max(0.0).powi(2));
        let impulse_n_s = self.half_period_s * mean_n * (1.0 - self.interaction * against.sum::<f64>());
        [-impulse_n_s * cos, -impulse_n_s * sin]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const DT_S: f64 = 1e-3;

    fn flippers() -> Thrust {
        Thrust::new(&Parameters::default(), &ThrustParameters::default())
    }

    /// Waveform (1) and its derivatives at t.
    fn waveform(centerline_rad: f64, amplitude_rad: f64, t_s: f64) -> TailState {
        let w = TAU / 1.5;
        let (sin, cos) = (w * t_s).sin_cos();
        TailState {
            angle_rad: centerline_rad + amplitude_rad * cos,
            rate_rad_s: -amplitude_rad * w * sin,
            acceleration_rad_s2: -amplitude_rad * w * w * cos,
            inertia_kg_m2: 1.5e-4,
        }
    }

    /// Impulse over steps `from..=to` of 1 ms, N·s.
    fn impulse(thrust: &mut Thrust, from: u32, to: u32, tail: impl Fn(f64) -> TailState) -> [f64; 2] {
        (from..=to).fold([0.0; 2], |sum, step| {
            let force_n = thrust.step(DT_S, &tail(f64::from(step) * DT_S));
            [sum[0] + force_n[0] * DT_S, sum[1] + force_n[1] * DT_S]
        })
    }

    #[test]
    fn the_waveform_gives_law_2_opposite_the_centerline() {
        for amplitude_rad in [0.9, 1.0, 1.3, 1.7, 2.1, 2.6, -0.9, -1.5, -2.6] {
            for centerline_rad in [-7.0, -1.5, -0.4, 0.0, 0.3, 1.1, 2.0, 3.1, 9.0] {
                let mut thrust = flippers();
                // From rest: the first cycle already counts in full.
                for cycle in 0..3 {
                    let [x, y] = impulse(&mut thrust, cycle * 1500 + 1, (cycle + 1) * 1500, |t_s| {
                        waveform(centerline_rad, amplitude_rad, t_s)
                    });
                    let (sin, cos) = f64::sin_cos(centerline_rad);
                    let law_n = 0.022 * f64::abs(amplitude_rad) - 0.019;
                    let (along, across) = (-(x * cos + y * sin) / 1.5, (y * cos - x * sin) / 1.5);
                    assert!(
                        (along - law_n).abs() < 1e-6 && across.abs() < 1e-6,
                        "A {amplitude_rad} φ₀ {centerline_rad} cycle {cycle}: {along} against {law_n}, {across} across"
                    );
                }
            }
        }
    }

    #[test]
    fn wiggles_below_the_opening_angle_and_rest_give_nothing() {
        let mut thrust = flippers();
        for step in 1..6000 {
            let tail = waveform(0.4, 0.86, f64::from(step) * DT_S);
            assert!(thrust.step(DT_S, &tail).iter().all(|&f| f == 0.0), "step {step}");
        }
        let mut thrust = flippers();
        for step in 1..100_000_u32 {
            // Held with a jitter of an encoder count, creeping around and around.
            let jitter_rad = if step % 7 < 3 { 1.5e-3 } else { 0.0 };
            let rate_rad_s = if step % 7 == 0 { 0.4 } else { 0.1 };
            let tail = TailState {
                angle_rad: 1e-4 * f64::from(step) + jitter_rad,
                rate_rad_s,
                acceleration_rad_s2: if step % 7 == 0 { 300.0 } else { -50.0 },
                inertia_kg_m2: 1.5e-4,
            };
            assert!(thrust.step(DT_S, &tail).iter().all(|&f| f == 0.0), "step {step}");
        }
    }

    #[test]
    fn a_transition_pushes_by_the_hand_worked_impulse() {
        // 3 rad in 0.5 s from φ = 0: J = 0.75·(0.011·3 − 0.019) = 0.0105 N·s against the midpoint at 1.5 rad.
        let turn = |t_s: f64| TailState {
            angle_rad: 6.0 * t_s,
            rate_rad_s: 6.0,
            acceleration_rad_s2: 0.0,
            inertia_kg_m2: 1.5e-4,
        };
        let mut thrust = flippers();
        thrust.step(DT_S, &TailState::default());
        let [x, y] = impulse(&mut thrust, 1, 500, turn);
        let (sin, cos) = 1.5_f64.sin_cos();
        assert!((x + 0.0105 * cos).abs() < 1e-12 && (y + 0.0105 * sin).abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn a_stop_within_a_swing_parts_it_in_two() {
        let at = |angle_rad: f64, rate_rad_s: f64, acceleration_rad_s2: f64| TailState {
            angle_rad,
            rate_rad_s,
            acceleration_rad_s2,
            inertia_kg_m2: 1.5e-4,
        };
        let mut thrust = flippers();
        thrust.step(DT_S, &at(0.0, 0.0, 0.0));
        // 1.5 rad, a stop, 1.5 rad more: neither opens the flippers. In one go they would push.
        for (from_rad, stop) in [(0.0, false), (1.5, true)] {
            if stop {
                thrust.step(DT_S, &at(from_rad, 0.0, -100.0));
            }
            for step in 1..=300 {
                let force_n = thrust.step(DT_S, &at(from_rad + 0.005 * f64::from(step), 5.0, 0.0));
                assert!(force_n.iter().all(|&f| f == 0.0), "{from_rad} + {step}");
            }
        }
    }
}
