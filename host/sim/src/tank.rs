//! The structure afloat in the tank: thrust of every tail, reaction of every rotor, current, gusts and waves.
//!
//! ```text
//! F = Σ fᵢ,   τ = Σ (xᵢ·f_yᵢ − yᵢ·f_xᵢ) − Σ Jᵢ·φ̈ᵢ − Σ c·φ̇ᵢ|φ̇ᵢ|                               (k1)
//! g(t + dt) = g(t)·e^(−dt/τ_g) + σ_g·√(1 − e^(−2dt/τ_g))·N(0, 1)          gust, per world axis      (k2)
//! F_w = Σ wᵢ,   τ_w = Σ (xᵢ·w_yᵢ − yᵢ·w_xᵢ),   wᵢ = (m₁ + M_A/N)·u̇(rᵢ)                           (k3)
//! ```
//!
//! fᵢ from the actual tail angle ([`super::thrust`]) at the module's centre (xᵢ, yᵢ); motion of the body as in the
//! module `body`. u̇ is the acceleration of waves at each module ([`super::waves`]); their velocity, averaged over the modules, is
//! added to that of the water. The motor turns its rotor against the structure, which takes −J·φ̈; the structure's moment of
//! inertia includes the rotors, so (I + I_a)·Ω + ΣJφ̇ changes by outside torques only. The water brakes the tail, and by way of the motor the
//! structure, with c·φ̇|φ̇|.
//!
//! Assumptions and limits: c is zero unless `[tank]` says otherwise, and beside the motor's own (`[motor] tail_drag_n_m_s2`), which no structure
//! feels. The numbers of [`TankParameters`] are *assumed*. No walls.

use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use quantity::ParameterError;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use record::PoseSample;

use super::TailState;
use super::body::{Body, BodyState, to_structure, to_world};
pub use super::contact::Contact;
use super::contact::ContactWatch;
use super::thrust::Thrust;
use super::waves::Waves;

pub use hull::Hull;
pub use parameters::TankParameters;

mod hull;
mod parameters;

/// What is drawn for one seed beside the gusts.
const SPREAD: u64 = 0x5B3E_AD00;
const SEA: u64 = 0x5EA0_0000;

/// The floating structure with its tails in the water.
#[derive(Debug)]
pub struct Tank {
    parameters: TankParameters,
    body: Body,
    state: BodyState,
    t_s: f64,
    positions_m: Vec<[f64; 2]>,
    thrusts: Vec<Thrust>,
    wrench: Wrench,
    gust_m_s: [f64; 2],
    waves: Waves,
    /// Velocity of the waves, averaged over the modules, world, m/s.
    wave_m_s: [f64; 2],
    rng: ChaCha8Rng,
    watch: ContactWatch,
}

impl Tank {
    /// The structure with pose and velocity as in `initial`, whose time the tank's clock goes on from. Gusts
    /// start from their steady distribution; they, the sea and the spread of thrust are drawn for `seed`. `believed` is what a host
    /// takes the modules for, and holds where `tank` says nothing else.
    ///
    /// # Errors
    /// As [`TankParameters::validate`].
    pub fn new(
        structure: &Structure,
        believed: &Parameters,
        tank: &TankParameters,
        initial: &PoseSample,
        seed: u64,
    ) -> Result<Self, ParameterError> {
        tank.validate(structure.len()).map_err(|(_, error)| error)?;
        let real = tank.real(believed);
        let body = tank.body(structure, &real);
        let shares = tank.thrust.shares(believed, structure.len(), seed ^ SPREAD);
        let flippers = Thrust::new(&real, &tank.thrust);
        let thrusts = shares.into_iter().zip(neighbours(structure));
        let thrusts = thrusts.map(|(share, sides)| flippers.clone().on_module(share, sides)).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let gust_m_s = [normal(&mut rng), normal(&mut rng)].map(|n| tank.gust_m_s * n);
        Ok(Self {
            parameters: tank.clone(),
            body,
            state: BodyState::of(initial),
            t_s: initial.t_s,
            positions_m: structure.positions_m(real.pitch_m),
            thrusts,
            wrench: Wrench::default(),
            gust_m_s,
            waves: Waves::new(&tank.wave, &tank.jonswap, seed ^ SEA),
            wave_m_s: [0.0; 2],
            rng,
            watch: ContactWatch::new(structure, &real),
        })
    }

    /// Advances the structure by `dt_s` (1 ms is meant), over which the tails came to `tails`: one of each
    /// module, in order.
    pub fn step(&mut self, dt_s: f64, tails: &[TailState]) {
        // F = Σ fᵢ,   τ = Σ (xᵢ·f_yᵢ − yᵢ·f_xᵢ) − Σ Jᵢ·φ̈ᵢ − Σ c·φ̇ᵢ|φ̇ᵢ|                          (k1)
        let mut wrench = Wrench::default();
        let mut reaction_nm = 0.0;
        for ((thrust, &[x_m, y_m]), tail) in self.thrusts.iter_mut().zip(&self.positions_m).zip(tails) {
            let [fx_n, fy_n] = thrust.step(dt_s, tail);
            wrench = wrench + Wrench { fx_n, fy_n, tau_nm: x_m * fy_n - y_m * fx_n };
            reaction_nm -= tail.inertia_kg_m2 * tail.acceleration_rad_s2;
            reaction_nm -= self.parameters.tail_drag_n_m_s2 * tail.rate_rad_s * tail.rate_rad_s.abs();
        }
        self.wrench = wrench;
        if self.parameters.gust_m_s > 0.0 {
            // g(t + dt) = g(t)·e^(−dt/τ_g) + σ_g·√(1 − e^(−2dt/τ_g))·N(0, 1)                        (k2)
            let ratio = dt_s / self.parameters.gust_time_s;
            let (keep, fresh_m_s) =
                ((-ratio).exp(), self.parameters.gust_m_s * (-(-2.0 * ratio).exp_m1()).sqrt());
            for gust_m_s in &mut self.gust_m_s {
                *gust_m_s = *gust_m_s * keep + fresh_m_s * normal(&mut self.rng);
            }
        }
        let total = wrench + Wrench { tau_nm: reaction_nm, ..Wrench::default() } + self.meet_waves();
        self.state = self.body.step(&self.state, dt_s, total, self.water_m_s());
        self.t_s += dt_s;
        self.watch.check(self.t_s, tails);
    }

    /// Takes the waves' velocity in, and gives their wrench about the origin, in S.
    fn meet_waves(&mut self) -> Wrench {
        let mut wrench = Wrench::default();
        if self.waves.is_calm() {
            return wrench;
        }
        let (Body { mass_kg, added_mass_kg, .. }, modules) = (&self.body, self.positions_m.len() as f64);
        let moved_kg = added_mass_kg.map(|added_kg| (mass_kg + added_kg) / modules);
        let (BodyState { heading_rad, position_m, .. }, mut sum_m_s) = (self.state, [0.0; 2]);
        for &[x_m, y_m] in &self.positions_m {
            let [dx, dy] = to_world(heading_rad, [x_m, y_m]);
            let (u, acceleration) = self.waves.at(self.t_s, [position_m[0] + dx, position_m[1] + dy]);
            sum_m_s = [sum_m_s[0] + u[0], sum_m_s[1] + u[1]];
            // F_w = Σ wᵢ,   τ_w = Σ (xᵢ·w_yᵢ − yᵢ·w_xᵢ),   wᵢ = (m₁ + M_A/N)·u̇(rᵢ)                 (k3)
            let [a_x, a_y] = to_structure(heading_rad, acceleration);
            let (fx_n, fy_n) = (moved_kg[0] * a_x, moved_kg[1] * a_y);
            wrench = wrench + Wrench { fx_n, fy_n, tau_nm: x_m * fy_n - y_m * fx_n };
        }
        self.wave_m_s = sum_m_s.map(|sum| sum / modules);
        wrench
    }

    /// Goes on at `t_s` from where it is: what happened meanwhile was not seen, and is not made up.
    pub fn skip(&mut self, t_s: f64) {
        self.t_s = t_s;
        self.thrusts.iter_mut().for_each(Thrust::forget);
        self.watch.forget();
    }

    /// True pose and velocity over ground, now, of the mean of the modules' centres: what a motion capture sees.
    #[must_use]
    pub fn pose(&self) -> PoseSample {
        self.state.sample(self.t_s)
    }

    /// Thrust of all tails on the water over the last step, in S, without the rotors' reaction torque.
    #[must_use]
    pub fn last_wrench(&self) -> Wrench {
        self.wrench
    }

    /// Velocity of the water in the world now, current, gust and waves, m/s.
    #[must_use]
    pub fn water_m_s(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.parameters.current_m_s[axis] + self.gust_m_s[axis] + self.wave_m_s[axis])
    }

    /// Every time two tails touched so far.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        self.watch.contacts()
    }

    /// Least distance between the surfaces of two tails so far, m; infinite where no two can meet.
    #[must_use]
    pub fn least_clearance_m(&self) -> f64 {
        self.watch.least_clearance_m()
    }
}

/// Directions to the docked neighbours of every module, in S.
fn neighbours(structure: &Structure) -> Vec<Vec<[f64; 2]>> {
    let mut sides = vec![Vec::new(); structure.len()];
    for offset in [[1, 0], [0, 1]] {
        for (one, other) in structure.neighbours(offset) {
            let way = offset.map(f64::from);
            sides[one].push(way);
            sides[other].push(way.map(|share| -share));
        }
    }
    sides
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests_truth;

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use super::*;

    pub(super) const DT_S: f64 = 1e-3;

    pub(super) fn row() -> Structure {
        Structure::from_word("3x1").expect("three in a row")
    }

    fn tank(tank: &TankParameters, initial: &PoseSample, seed: u64) -> Tank {
        Tank::new(&row(), &Parameters::default(), tank, initial, seed).expect("valid")
    }

    /// Waveform (1) of three tails as (φ₀, A) each.
    pub(super) fn waveforms(swings: [[f64; 2]; 3], t_s: f64) -> [TailState; 3] {
        let w = TAU / 1.5;
        let (sin, cos) = (w * t_s).sin_cos();
        swings.map(|[centerline_rad, amplitude_rad]| TailState {
            angle_rad: centerline_rad + amplitude_rad * cos,
            rate_rad_s: -amplitude_rad * w * sin,
            acceleration_rad_s2: -amplitude_rad * w * w * cos,
            inertia_kg_m2: 1.5e-4,
        })
    }

    #[test]
    fn reaction_turns_the_structure_against_the_rotors_at_constant_angular_momentum() {
        // No drag, and amplitudes too small to push: body and rotors are alone with each other.
        let parameters = Parameters { drag_n_s2_m2: 0.0, yaw_drag_n_m_s2: 0.0, ..Parameters::default() };
        let still = PoseSample::default();
        let mut tank = Tank::new(&row(), &parameters, &TankParameters::default(), &still, 0).expect("valid");
        // 1.5·(3·0.003 + 2·0.0225) = 0.081 kg·m², and no torque from outside.
        let inertia_kg_m2 = 0.081;
        let w = TAU / 1.5;
        let mut rates_rad_s = [0.0; 3];
        let mut swung_rad_s: f64 = 0.0;
        for step in 1..=9000 {
            let t_s = f64::from(step) * DT_S;
            let mut tails = waveforms([[0.0, 0.8], [1.0, 0.5], [-2.0, 0.7]], t_s);
            for (tail, before_rad_s) in tails.iter_mut().zip(&mut rates_rad_s) {
                // The mean over the step, as the motor reports it.
                tail.acceleration_rad_s2 = (tail.rate_rad_s - *before_rad_s) / DT_S;
                *before_rad_s = tail.rate_rad_s;
            }
            tank.step(DT_S, &tails);
            let rotors: f64 = tails.iter().map(|tail| tail.inertia_kg_m2 * tail.rate_rad_s).sum();
            let total = inertia_kg_m2 * tank.pose().yaw_rate_rad_s + rotors;
            assert!(total.abs() < 1e-15, "{t_s} s: {total} N·m·s");
            swung_rad_s = swung_rad_s.max(tank.pose().yaw_rate_rad_s.abs());
        }
        assert_eq!(tank.last_wrench(), Wrench::default());
        // All three swing in phase: Ω = J·w·(0.8 + 0.5 + 0.7)/(I + I_a).
        assert!((swung_rad_s / (1.5e-4 * w * 2.0 / 0.081) - 1.0).abs() < 1e-3, "{swung_rad_s} rad/s");
    }

    /// A tail that is turned steadily: the water's torque on it is all that turns the body, Ω̇ = −c·φ̇²/(I + I_a).
    #[test]
    fn the_water_that_brakes_a_tail_turns_the_structure() {
        let parameters = Parameters { drag_n_s2_m2: 0.0, yaw_drag_n_m_s2: 0.0, ..Parameters::default() };
        let water = TankParameters { tail_drag_n_m_s2: 2e-5, ..TankParameters::default() };
        let mut tank = Tank::new(&row(), &parameters, &water, &PoseSample::default(), 0).expect("valid");
        let rest =
            TailState { angle_rad: 0.0, rate_rad_s: 0.0, acceleration_rad_s2: 0.0, inertia_kg_m2: 1.5e-4 };
        for step in 1..=100 {
            // Less than 1.73 rad: no thrust.
            let turning = TailState { angle_rad: -5.0 * DT_S * f64::from(step), rate_rad_s: -5.0, ..rest };
            tank.step(DT_S, &[rest, turning, rest]);
        }
        let expected_rad_s = 2e-5 * 25.0 * 0.1 / 0.081;
        let found_rad_s = tank.pose().yaw_rate_rad_s;
        assert!((found_rad_s / expected_rad_s - 1.0).abs() < 1e-9, "{found_rad_s} {expected_rad_s}");
    }

    #[test]
    fn the_mean_wrench_of_a_cycle_is_that_of_7() {
        let swings = [[-1.2, 1.4], [0.4, -2.0], [2.9, 1.1]];
        let parameters = Parameters::default();
        let planned =
            swings.iter().zip(row().positions_m(0.15)).fold(Wrench::default(), |sum, (swing, at)| {
                let swing = modboat::motion::Swing { centerline_rad: swing[0], amplitude_rad: swing[1] };
                sum + swing.wrench(&parameters, at)
            });
        let mut tank = tank(&TankParameters::default(), &PoseSample::default(), 0);
        let mut mean = [0.0; 3];
        for step in 1..=1500 {
            tank.step(DT_S, &waveforms(swings, f64::from(step) * DT_S));
            let now = tank.last_wrench().to_array();
            mean = [0, 1, 2].map(|i| mean[i] + now[i] / 1500.0);
        }
        let off = (Wrench::from_array(mean) - planned).weighted_norm([1.0, 1.0, 10.0]);
        assert!(off < 1e-5, "{mean:?} against {planned:?}");
    }

    #[test]
    fn tails_that_push_astern_drive_the_structure_forward_at_the_speed_of_the_drag_law() {
        // 2A sweeps astern (φ₀ = −π/2): 3·F(1.6) = 0.0486 N forward; √(0.0486/13.5) = 0.06 m/s northward, less
        // what the wobble adds to a quadratic drag.
        let north = PoseSample { heading_rad: FRAC_PI_2, ..PoseSample::default() };
        let mut tank = tank(&TankParameters::default(), &north, 0);
        let swings = [[-FRAC_PI_2, 1.6], [-FRAC_PI_2, -1.6], [-FRAC_PI_2, 1.6]];
        (1..=60_000).for_each(|step| tank.step(DT_S, &waveforms(swings, f64::from(step) * DT_S)));
        let before = tank.pose();
        (60_001..=75_000).for_each(|step| tank.step(DT_S, &waveforms(swings, f64::from(step) * DT_S)));
        let after = tank.pose();
        let speed_m_s = (after.position_m[1] - before.position_m[1]) / 15.0;
        assert!((0.055..0.0605).contains(&speed_m_s), "{speed_m_s} m/s");
    }

    #[test]
    fn a_current_takes_the_free_structure_along() {
        let parameters = TankParameters { current_m_s: [0.04, -0.02], ..TankParameters::default() };
        let mut tank = tank(&parameters, &PoseSample::default(), 0);
        let rest = waveforms([[0.0, 0.0]; 3], 0.0);
        let mut slip_m_s = f64::INFINITY;
        for second in 1..=600 {
            (0..1000).for_each(|_| tank.step(DT_S, &rest));
            let v = tank.pose().velocity_m_s;
            let now_m_s = (v[0] - 0.04).hypot(v[1] + 0.02);
            assert!(now_m_s < slip_m_s, "{second} s: {now_m_s} m/s");
            slip_m_s = now_m_s;
        }
        // Per axis v_r = v₀/(1 + v₀·t/l) with l = (m + m_a)/D = 1/3 m: after 600 s 0.00055 and 0.00054 m/s.
        let expected = f64::hypot(0.04 / (1.0 + 0.04 * 1800.0), 0.02 / (1.0 + 0.02 * 1800.0));
        assert!((slip_m_s / expected - 1.0).abs() < 1e-6, "{slip_m_s} m/s, expected {expected}");
    }

    #[test]
    fn gusts_have_the_stated_spread_and_memory() {
        let (gust_m_s, gust_time_s, seed) = (0.02, 0.5, 11);
        let parameters = TankParameters { gust_m_s, gust_time_s, ..TankParameters::default() };
        let mut tank = tank(&parameters, &PoseSample::default(), seed);
        let rest = waveforms([[0.0, 0.0]; 3], 0.0);
        let gusts: Vec<f64> = (0..400_000)
            .map(|_| {
                tank.step(DT_S, &rest);
                tank.water_m_s()[0]
            })
            .collect();
        let product = |lag: usize| {
            gusts.iter().zip(&gusts[lag..]).map(|(a, b)| a * b).sum::<f64>() / (gusts.len() - lag) as f64
        };
        // 400 s hold some 400 independent values: 3.5 % standard error of the deviation.
        assert!((product(0).sqrt() / gust_m_s - 1.0).abs() < 0.12, "seed {seed}: {}", product(0).sqrt());
        assert!((product(500) / product(0) - (-1.0_f64).exp()).abs() < 0.15, "seed {seed}");
    }

    #[test]
    fn the_same_seed_gives_the_same_run_to_the_bit() {
        let parameters = TankParameters { gust_m_s: 0.01, ..TankParameters::default() };
        let end = |seed| {
            let mut tank = tank(&parameters, &PoseSample::default(), seed);
            for step in 1..=5000 {
                tank.step(DT_S, &waveforms([[0.1, 1.5], [2.0, 2.0], [4.0, -1.0]], f64::from(step) * DT_S));
            }
            tank.pose()
        };
        assert_eq!(end(3), end(3));
        assert_ne!(end(3), end(4));
    }

    #[test]
    fn contacts_are_stamped_with_the_tanks_time() {
        let mut tank =
            tank(&TankParameters::default(), &PoseSample { t_s: 100.0, ..PoseSample::default() }, 0);
        // Tail 1 turns onto tail 0, which points at it.
        for step in 0..=1000 {
            let mut tails = waveforms([[0.0, 0.0], [FRAC_PI_2, 0.0], [FRAC_PI_2, 0.0]], 0.0);
            tails[1].angle_rad += FRAC_PI_2 * f64::from(step) * DT_S;
            tank.step(DT_S, &tails);
        }
        assert_eq!(tank.contacts().len(), 1, "{:?}", tank.contacts());
        assert_eq!(tank.contacts()[0].modules, (0, 1));
        assert!((100.1..101.0).contains(&tank.contacts()[0].t_s), "{:?}", tank.contacts());
        assert!(tank.least_clearance_m() < 0.0);
    }
}
