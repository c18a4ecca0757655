//! Prices of legs and turns by direction: a table that is quick to ask, filled as it is asked.
//!
//! ```text
//! E + λT = R(v, a) + (ℓ − v²/a)/v·P(v) + λ(ℓ/v + v/a)      up to v, along, down again
//! E + λT = R(p, a) + 2λp/a,   p = √(ℓa)                    where ℓ is too short for v
//! R(v, a) = ∫₀ᵛ (P(u, a) + P(u, −a)) du / a                both ramps
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | ℓ | length of a leg, or angle of a turn | m, rad |
//! | v, a | greatest speed, acceleration | m/s, m/s²; rad/s, rad/s² |
//! | P(u, a) | power at speed u while that grows by a | W |
//! | λ | what all others draw | W |
//!
//! P and R are kept at [`SPEEDS`] speeds and three accelerations for every direction of a net over the sphere, and are linear between
//! its nodes: what is read is some 2 % from the price of the leg itself. It chooses ways, speeds and accelerations; the leg chosen is priced by itself.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::super::propulsion::Propulsion;

/// Nodes in azimuth, and cells in elevation.
pub(super) const AZIMUTHS: usize = 36;
pub(super) const ELEVATIONS: usize = 18;
/// Speeds of a table; [`LOWEST`] of them are below the least that may be asked for: ways too short for it.
const SPEEDS: usize = 10;
const LOWEST: usize = 1;
/// Shares of the greatest acceleration that are tried.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// What stands for a power beyond the thrusters' limits, W: finite, so that it can be weighted by zero.
const BEYOND_W: f64 = 1e12;

/// Speeds and accelerations that may be chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    speeds: [f64; SPEEDS],
    /// Time for a metre (or radian) at each.
    paces: [f64; SPEEDS],
    accelerations: [f64; 3],
}

impl Scale {
    pub fn new([low, high]: [f64; 2], acceleration: f64) -> Self {
        let growth = (high / low).ln() / (SPEEDS - 1 - LOWEST) as f64;
        let speed = |n: usize| match n.checked_sub(LOWEST) {
            Some(above) => low * (growth * above as f64).exp(),
            None => low * (n + 1) as f64 / (LOWEST + 1) as f64,
        };
        let speeds: [f64; SPEEDS] = std::array::from_fn(speed);
        let paces = speeds.map(|speed| 1.0 / speed);
        Self { speeds, paces, accelerations: SHARES.map(|share| share * acceleration) }
    }
}

/// Power at the speeds of a scale, and energy of the ramps up to them, in one direction.
#[derive(Clone, Debug)]
struct Prices {
    cruise_w: [f64; SPEEDS],
    ramps_j: [[f64; SPEEDS]; 3],
}

impl Prices {
    const NONE: Self = Self { cruise_w: [0.0; SPEEDS], ramps_j: [[0.0; SPEEDS]; 3] };

    /// Along `axis` of ν.
    fn new(propulsion: &Propulsion, axis: [f64; 6], scale: &Scale) -> Self {
        let power_w = |speed: f64, acceleration: f64| {
            let [nu, nu_dot] = [speed, acceleration].map(|size| axis.map(|component| component * size));
            propulsion.power_w(&nu, &nu_dot).unwrap_or(BEYOND_W)
        };
        let ramps_j = scale.accelerations.map(|a| {
            let (mut from, mut sum_j) = (0.0, 0.0);
            scale.speeds.map(|speed| {
                // By the midpoint: between neighbours P is all but straight.
                let middle = 0.5 * (from + speed);
                sum_j += (speed - from) / a * (power_w(middle, a) + power_w(middle, -a));
                from = speed;
                sum_j
            })
        });
        Self { cruise_w: scale.speeds.map(|speed| power_w(speed, 0.0)), ramps_j }
    }

    fn add(&mut self, other: &Self, weight: f64) {
        let pairs =
            self.ramps_j.iter_mut().zip(&other.ramps_j).chain([(&mut self.cruise_w, &other.cruise_w)]);
        for (own, other) in pairs {
            for (own, other) in own.iter_mut().zip(other) {
                *own += weight * other;
            }
        }
    }

    /// Energy of both ramps of a way too short for a speed.
    fn short_j(&self, ramp: usize, scale: &Scale, peak: f64) -> f64 {
        let per_speed = |n: usize| self.ramps_j[ramp][n] / scale.speeds[n];
        let above = scale.speeds.iter().position(|&speed| speed >= peak).unwrap_or(SPEEDS - 1);
        if above == 0 {
            return peak * per_speed(0);
        }
        let [low, high] = [scale.speeds[above - 1], scale.speeds[above]];
        let share = (peak - low) / (high - low).max(f64::MIN_POSITIVE);
        peak * ((1.0 - share) * per_speed(above - 1) + share * per_speed(above))
    }

    /// The best speed at one acceleration.
    fn best(&self, ramp: usize, scale: &Scale, way: f64, lambda_w: f64) -> Offer {
        let a = scale.accelerations[ramp];
        let (inverse, most) = (1.0 / a, way * a);
        let (mut least, mut at) = (f64::INFINITY, LOWEST);
        let mut n = LOWEST;
        while n < SPEEDS && scale.speeds[n] * scale.speeds[n] <= most {
            let (whole_s, ramp_s) = (way * scale.paces[n], scale.speeds[n] * inverse);
            let price =
                self.ramps_j[ramp][n] + self.cruise_w[n] * (whole_s - ramp_s) + lambda_w * (whole_s + ramp_s);
            if price < least {
                (least, at) = (price, n);
            }
            n += 1;
        }
        let beside = |n: usize| scale.speeds[n.clamp(LOWEST, SPEEDS - 1)];
        let between = [beside(at.saturating_sub(1)), beside(at + 1)];
        let mut best = Offer { price: least, speed: scale.speeds[at], between, acceleration: a };
        if n < SPEEDS {
            // Too short for the next speed.
            let peak = most.sqrt();
            let price = self.short_j(ramp, scale, peak) + 2.0 * lambda_w * peak * inverse;
            if price < least {
                let between = [beside(n.saturating_sub(1)).min(peak), peak];
                best = Offer { price, speed: peak, between, acceleration: a };
            }
        }
        // The next speed may be beyond what the way allows.
        best.between[1] = best.between[1].min((way * a).sqrt()).max(best.speed);
        best
    }
}

/// A speed and an acceleration, and what a way costs with them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offer {
    /// E + λT by the table, J.
    pub price: f64,
    /// Greatest speed.
    pub speed: f64,
    /// The speeds of the table below and above it, where the best speed is.
    pub between: [f64; 2],
    /// Acceleration.
    pub acceleration: f64,
}

/// The whole table of one kind of robot.
#[derive(Debug)]
pub(super) struct Tariff {
    legs: Scale,
    turns: Scale,
    nodes: Vec<OnceLock<Box<Prices>>>,
    left_right: [Prices; 2],
}

impl Tariff {
    pub fn new(propulsion: &Propulsion, legs: Scale, turns: Scale) -> Self {
        let turn = |sign: f64| Prices::new(propulsion, [0.0, 0.0, 0.0, 0.0, 0.0, sign], &turns);
        let nodes = (0..AZIMUTHS * (ELEVATIONS + 1)).map(|_| OnceLock::new()).collect();
        Self { legs, turns, nodes, left_right: [turn(-1.0), turn(1.0)] }
    }

    fn node(&self, propulsion: &Propulsion, elevation: usize, azimuth: usize) -> &Prices {
        // Straight up and down there is one direction.
        let azimuth = if elevation.is_multiple_of(ELEVATIONS) { 0 } else { azimuth };
        self.nodes[elevation * AZIMUTHS + azimuth].get_or_init(|| {
            let (sin, cos) = (azimuth as f64 / AZIMUTHS as f64 * TAU).sin_cos();
            let (up, level) = ((elevation as f64 / ELEVATIONS as f64 - 0.5) * PI).sin_cos();
            Box::new(Prices::new(propulsion, [level * cos, level * sin, up, 0.0, 0.0, 0.0], &self.legs))
        })
    }

    /// Prices of a leg that leads along `body_m` in the robot's frame.
    fn prices(&self, propulsion: &Propulsion, [x, y, z]: [f64; 3]) -> Prices {
        let up = (z.atan2(x.hypot(y)) / PI + 0.5) * ELEVATIONS as f64;
        let round = (y.atan2(x) / TAU).rem_euclid(1.0) * AZIMUTHS as f64;
        let low = (up as usize).min(ELEVATIONS - 1);
        let left = (round as usize) % AZIMUTHS;
        let (above, right) = (up - low as f64, round - round.floor());
        let mut mixed = Prices::NONE;
        for (elevation, by_up) in [(low, 1.0 - above), (low + 1, above)] {
            for (azimuth, by_round) in [(left, 1.0 - right), ((left + 1) % AZIMUTHS, right)] {
                let weight = by_up * by_round;
                if weight > 1e-9 {
                    mixed.add(self.node(propulsion, elevation, azimuth), weight);
                }
            }
        }
        mixed
    }

    /// E + λT of a leg at its best, along a direction of the net, J.
    pub fn leg_price(
        &self,
        propulsion: &Propulsion,
        (elevation, azimuth): (usize, usize),
        way_m: f64,
        lambda_w: f64,
    ) -> f64 {
        let prices = self.node(propulsion, elevation, azimuth);
        let offers = (0..SHARES.len()).map(|ramp| prices.best(ramp, &self.legs, way_m, lambda_w).price);
        offers.fold(f64::INFINITY, f64::min)
    }

    /// E + λT of a turn at its best, J.
    pub fn turn_price(&self, angle_rad: f64, lambda_w: f64) -> f64 {
        let offers = self.turn(angle_rad, lambda_w).map(|offer| offer.price);
        offers.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The best speed of a leg along `body_m` at each acceleration.
    pub fn leg(&self, propulsion: &Propulsion, body_m: [f64; 3], way_m: f64, lambda_w: f64) -> [Offer; 3] {
        let prices = self.prices(propulsion, body_m);
        std::array::from_fn(|ramp| prices.best(ramp, &self.legs, way_m, lambda_w))
    }

    /// The best rate of a turn at each acceleration.
    pub fn turn(&self, angle_rad: f64, lambda_w: f64) -> [Offer; 3] {
        let prices = &self.left_right[usize::from(angle_rad > 0.0)];
        std::array::from_fn(|ramp| prices.best(ramp, &self.turns, angle_rad.abs(), lambda_w))
    }
}
