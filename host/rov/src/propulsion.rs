//! Cost of motion: electric power, energy and time of straight legs and of turns in place, (12)–(15).
//!
//! ```text
//! τ(ν, ν̇) = M ν̇ + C(ν)ν + D_V ν + D_N(ν)ν + g(level)          after (7), (12)
//! P_e      = min Σ P_th(u_th)   over   T u = τ                    (9), (10)
//! E        = ∫ P_e dt                                             (15)
//! ```
//!
//! The paper's (13)–(15) multiply a power by ds/dt and integrate over s, which is not an energy; E = ∫P dt is. Its (12)
//! leaves out C(ν): for a hull whose added mass differs between axes an oblique course asks for a Munk moment, and the
//! thrusters that give it draw power. [`Steady::Whole`] counts it.
//!
//! A leg starts and ends at rest: up to its speed v at a, on at v, down at a (a triangle when the leg is too short for
//! v). With no acceleration given it is the paper's: v from end to end. Turns likewise, with yaw rate and yaw
//! acceleration.
//!
//! The best speed of a leg minimises E + λT, where λ is the power that all others draw meanwhile, so that E + λT is
//! the leg's part of (17).
//!
//! Assumptions and limits: level attitude; still water; thrust as at the bollard (the paper's section VI-A says why).

use nalgebra::Vector6;
use reconfiguration::problem::Rules;
use reconfiguration::vehicle::Vehicle;
use thiserror::Error;

use super::allocation::{AllocationError, Allocator};
use super::cluster::Cluster;
use super::configuration_matrix::{ConfigurationMatrix, ThrusterError};
use super::dynamics::{Dynamics, DynamicsError, coriolis};
use super::power::{self, PowerError, PowerLaw};

/// Abscissae and weights of Gauss–Legendre quadrature with five points on [0, 1] (Abramowitz and Stegun, 25.4.29).
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_3),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_3),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// Why a vehicle cannot be costed.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PropulsionError {
    /// Its thrusters are none.
    #[error(transparent)]
    Thruster(#[from] ThrusterError),
    /// Its thrusters cannot push in every direction that is needed.
    #[error("{source}: {condition}")]
    Rank { source: ThrusterError, condition: &'static str },
    /// Nothing is known of its power.
    #[error(transparent)]
    Power(#[from] PowerError),
    /// It cannot be allocated to.
    #[error(transparent)]
    Allocation(#[from] AllocationError),
    /// It cannot move.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}

/// Energy and time of a leg or a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expense {
    /// Time, s.
    pub duration_s: f64,
    /// Electric energy, J.
    pub energy_j: f64,
    /// Greatest speed reached, m/s or rad/s.
    pub speed: f64,
    /// Acceleration up to it and down again, m/s² or rad/s²; `None` at constant speed.
    pub acceleration: Option<f64>,
}

impl Expense {
    /// Energy with what others draw meanwhile, E + λT, J.
    #[must_use]
    pub fn with_others(&self, lambda_w: f64) -> f64 {
        self.energy_j + lambda_w * self.duration_s
    }
}

/// Which wrench steady motion takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steady {
    /// As printed in (12): damping and restoring.
    Published,
    /// With the Munk moments that C(ν)ν asks for.
    Whole,
}

/// One kind of robot, ready to be costed.
#[derive(Clone, Debug)]
pub struct Propulsion {
    steady: Steady,
    dynamics: Dynamics,
    allocator: Allocator,
    thrusters: usize,
}

impl Propulsion {
    /// For a robot with full batteries, under the rules' voltage and limit of tilt. Roll and pitch that its working
    /// thrusters cannot push in are left to its stability.
    pub fn new(
        vehicle: &Vehicle,
        law: PowerLaw,
        rules: &Rules,
        steady: Steady,
    ) -> Result<Self, PropulsionError> {
        let matrix = ConfigurationMatrix::of_vehicle(vehicle)?;
        let limits_n: Vec<(f64, f64)> =
            power::limits_of(vehicle, power::limits_n(rules.battery_v)?).collect();
        let working: Vec<bool> = limits_n.iter().map(|(low, high)| high > low).collect();
        let rank = matrix.restricted(&working).require_full_rank();
        let dynamics = Dynamics::new(&Cluster::of(&vehicle.body))?;
        let stiffness_nm = dynamics.cluster().hydrostatics().stiffness_nm(0.0);
        let allocator =
            Allocator::new(matrix, &limits_n, law)?.with_passive(stiffness_nm * rules.tilt_limit_rad.sin());
        if let Err(source) = rank {
            // Without sway a robot gets everywhere, bow or stern ahead.
            for (axis, condition) in [
                (3, "roll is not balanced (v6)"),
                (4, "pitch is not balanced (v6)"),
                (0, "surge is needed to get to a slot (v1)"),
                (2, "heave is needed to get to a slot (v1)"),
                (5, "yaw is needed to get to a slot (v1)"),
            ] {
                if !allocator.reaches(&std::array::from_fn(|k| f64::from(u8::from(k == axis)))) {
                    return Err(PropulsionError::Rank { source, condition });
                }
            }
        }
        Ok(Self { steady, dynamics, allocator, thrusters: vehicle.thrusters.len() })
    }

    /// The wrench of moving level at `nu` while that changes by `nu_dot`, N and N·m.
    #[must_use]
    pub fn wrench(&self, nu: &[f64; 6], nu_dot: &[f64; 6]) -> [f64; 6] {
        let (mass, nu_vector) = (self.dynamics.mass_matrix(), Vector6::from(*nu));
        // τ = M ν̇ + C(ν)ν + D(ν)ν + g
        let steady = Vector6::from(self.dynamics.cluster().force_needed(nu));
        let inertial = mass * Vector6::from(*nu_dot);
        match self.steady {
            Steady::Published => (inertial + steady).into(),
            Steady::Whole => (inertial + coriolis(mass, &nu_vector) * nu_vector + steady).into(),
        }
    }

    /// Electric power, W, of moving level at `nu` while that changes by `nu_dot`; `None` beyond the thrusters' limits.
    #[must_use]
    pub fn power_w(&self, nu: &[f64; 6], nu_dot: &[f64; 6]) -> Option<f64> {
        let tau = self.wrench(nu, nu_dot);
        let mut thrusts_n = [0.0; 16];
        let thrusts_n = thrusts_n.get_mut(..self.thrusters)?;
        let served = self.allocator.allocate_into(&tau, thrusts_n).ok()?;
        (served >= 1.0 - 1e-9).then(|| self.allocator.power_w(thrusts_n))
    }

    /// A straight leg: `direction` is a unit vector in the body frame.
    #[must_use]
    pub fn leg(
        &self,
        direction: [f64; 3],
        length_m: f64,
        speed_m_s: f64,
        acceleration_m_s2: Option<f64>,
    ) -> Option<Expense> {
        let [x, y, z] = direction;
        self.stretch([x, y, z, 0.0, 0.0, 0.0], length_m, speed_m_s, acceleration_m_s2)
    }

    /// A turn in place by `angle_rad`, of either sign.
    #[must_use]
    pub fn turn(&self, angle_rad: f64, rate_rad_s: f64, acceleration_rad_s2: Option<f64>) -> Option<Expense> {
        let axis = [0.0, 0.0, 0.0, 0.0, 0.0, angle_rad.signum()];
        self.stretch(axis, angle_rad.abs(), rate_rad_s, acceleration_rad_s2)
    }

    /// From rest to rest, or at constant speed, along `axis` of ν.
    fn stretch(&self, axis: [f64; 6], way: f64, speed: f64, acceleration: Option<f64>) -> Option<Expense> {
        if way <= 0.0 {
            return Some(Expense::default());
        }
        let along = |size: f64| axis.map(|component| component * size);
        let Some(acceleration) = acceleration else {
            let duration_s = way / speed;
            let energy_j = self.power_w(&along(speed), &[0.0; 6])? * duration_s;
            return Some(Expense { duration_s, energy_j, speed, acceleration: None });
        };
        // A triangle where the way is too short: v²/a > way.
        let speed = speed.min((way * acceleration).sqrt());
        let (ramp_s, cruise_s) = (speed / acceleration, way / speed - speed / acceleration);
        let mut energy_j = 0.0;
        for (share, weight) in GAUSS {
            let nu = along(share * speed);
            let up = self.power_w(&nu, &along(acceleration))?;
            let down = self.power_w(&nu, &along(-acceleration))?;
            energy_j += weight * ramp_s * (up + down);
        }
        energy_j += cruise_s * self.power_w(&along(speed), &[0.0; 6])?;
        let duration_s = 2.0 * ramp_s + cruise_s;
        Some(Expense { duration_s, energy_j, speed, acceleration: Some(acceleration) })
    }

    /// The leg at its best speed within `speeds_m_s` and its best acceleration up to the given one.
    #[must_use]
    pub fn best_leg(
        &self,
        direction: [f64; 3],
        length_m: f64,
        speeds_m_s: [f64; 2],
        acceleration_m_s2: f64,
        lambda_w: f64,
    ) -> Option<Expense> {
        gentlest(length_m, speeds_m_s, acceleration_m_s2, lambda_w, |speed, acceleration| {
            self.leg(direction, length_m, speed, Some(acceleration))
        })
    }

    /// The turn at its best rate within `rates_rad_s` and its best acceleration up to the given one.
    #[must_use]
    pub fn best_turn(
        &self,
        angle_rad: f64,
        rates_rad_s: [f64; 2],
        acceleration_rad_s2: f64,
        lambda_w: f64,
    ) -> Option<Expense> {
        gentlest(angle_rad.abs(), rates_rad_s, acceleration_rad_s2, lambda_w, |rate, acceleration| {
            self.turn(angle_rad, rate, Some(acceleration))
        })
    }
}

/// Least E + λT over speeds and over the given acceleration, half and a quarter of it.
fn gentlest(
    way: f64,
    speeds: [f64; 2],
    acceleration: f64,
    lambda_w: f64,
    of: impl Fn(f64, f64) -> Option<Expense>,
) -> Option<Expense> {
    let best = [1.0, 0.5, 0.25].into_iter().filter_map(|share| {
        let acceleration = share * acceleration;
        // Where a way is too short for a speed, all higher ones are the same.
        let most = (way * acceleration).sqrt();
        least(speeds.map(|speed| speed.min(most)), lambda_w, |speed| of(speed, acceleration))
    });
    best.min_by(|a, b| a.with_others(lambda_w).total_cmp(&b.with_others(lambda_w)))
}

/// The speed in `range` of least E + λT, by golden sections: the sum falls, then rises, with the speed.
fn least(range: [f64; 2], lambda_w: f64, of: impl Fn(f64) -> Option<Expense>) -> Option<Expense> {
    const SECTION: f64 = 0.618_033_988_749_895;
    const STEPS: usize = 14;
    let price = |expense: &Option<Expense>| expense.map_or(f64::INFINITY, |e| e.with_others(lambda_w));
    let [mut low, mut high] = range;
    // The sum often rises from the slowest speed on.
    let (slowest, next) = (of(low)?, of((low + 1e-3).min(high)));
    if price(&Some(slowest)) <= price(&next) {
        return Some(slowest);
    }
    let (mut a, mut b) = (high - SECTION * (high - low), low + SECTION * (high - low));
    let (mut at_a, mut at_b) = (of(a), of(b));
    let mut best = [Some(slowest), of(high)].into_iter().min_by(|x, y| price(x).total_cmp(&price(y)))?;
    for _ in 0..STEPS {
        if high - low < 1e-4 {
            break;
        }
        if price(&at_a) <= price(&at_b) {
            (high, b, at_b) = (b, a, at_a);
            a = high - SECTION * (high - low);
            at_a = of(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + SECTION * (high - low);
            at_b = of(b);
        }
    }
    for candidate in [at_a, at_b] {
        if price(&candidate) < price(&best) {
            best = candidate;
        }
    }
    best
}

#[cfg(test)]
mod tests;
