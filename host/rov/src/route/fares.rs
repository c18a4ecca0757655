//! Prices of legs and turns while others draw one power λ: the [tariff](super::tariff) at its best speeds, by direction and length.
//!
//! Searches for routes ask for some thousand prices each, and all of them at one λ. So the least price over speeds and accelerations is kept for
//! every direction of the tariff's net and for [`LENGTHS`] lengths, four to an octave, and is linear between them.
//!
//! ```text
//! ℓ_n = 2^(LEAST + ⌊n/4⌋)·(1 + (n mod 4)/4)
//! ```
//!
//! Shorter ways than the first length cost as its square root: they are ramps alone. The price is concave in the length, so that what is read is
//! below it, by 0.5 % at most.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::super::propulsion::Propulsion;
use super::tariff::{AZIMUTHS, ELEVATIONS, Tariff};

/// The first length is two to this power, m.
const LEAST: i32 = -6;
const OCTAVES: usize = 12;
const LENGTHS: usize = 4 * OCTAVES + 1;
/// Angles of turns, evenly up to half a turn.
const TURNS: usize = 64;

/// Which way a leg leads in the world, and how far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    /// Heading of the leg; `None` straight up or down.
    pub azimuth_rad: Option<f64>,
    /// In cells of the net.
    up: f64,
    /// m.
    pub way_m: f64,
}

impl Direction {
    /// Of a leg along `leg_m`.
    pub fn of(leg_m: [f64; 3]) -> Self {
        let [x, y, z] = leg_m;
        let level = (x * x + y * y).sqrt();
        let half = ELEVATIONS as f64 / 2.0;
        let up = if z == 0.0 { half } else { half + z.atan2(level) / PI * ELEVATIONS as f64 };
        Self { azimuth_rad: super::azimuth_rad(leg_m), up, way_m: (level * level + z * z).sqrt() }
    }
}

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Fares {
    lambda_w: f64,
    legs: Vec<OnceLock<Box<[f64; LENGTHS]>>>,
    /// To the left and to the right.
    turns: [[f64; TURNS + 1]; 2],
}

impl Fares {
    pub fn new(tariff: &Tariff, lambda_w: f64) -> Self {
        let turn = |sign: f64| {
            std::array::from_fn(|n| {
                let angle_rad = n as f64 * PI / TURNS as f64;
                if n == 0 { 0.0 } else { tariff.turn_price(sign * angle_rad, lambda_w) }
            })
        };
        let legs = (0..AZIMUTHS * (ELEVATIONS + 1)).map(|_| OnceLock::new()).collect();
        Self { lambda_w, legs, turns: [turn(-1.0), turn(1.0)] }
    }

    /// E + λT of a leg at a heading, J; more than [`BEYOND_J`](super::mover::BEYOND_J) beyond the thrusters' limits.
    pub fn leg(&self, tariff: &Tariff, propulsion: &Propulsion, direction: &Direction, yaw_rad: f64) -> f64 {
        let Direction { azimuth_rad, up, way_m } = *direction;
        if way_m == 0.0 {
            return 0.0;
        }
        let low = (up as usize).min(ELEVATIONS - 1);
        let above = up - low as f64;
        let round = azimuth_rad.map_or(0.0, |azimuth| (azimuth - yaw_rad) / TAU);
        let round = (round - round.floor()) * AZIMUTHS as f64;
        let left = (round as usize).min(AZIMUTHS - 1);
        let right = round - left as f64;
        let next = if left + 1 == AZIMUTHS { 0 } else { left + 1 };
        let (length, share, scale) = at(way_m);
        let mut price = 0.0;
        for (elevation, by_up) in [(low, 1.0 - above), (low + 1, above)] {
            for (azimuth, by_round) in [(left, 1.0 - right), (next, right)] {
                let weight = by_up * by_round;
                if weight > 1e-9 {
                    let node = self.node(tariff, propulsion, elevation, azimuth);
                    price += weight * (node[length] + share * (node[length + 1] - node[length]));
                }
            }
        }
        scale * price
    }

    /// E + λT of a turn by an angle within half a turn, J.
    pub fn turn(&self, angle_rad: f64) -> f64 {
        let at = (angle_rad.abs() / PI * TURNS as f64).min(TURNS as f64);
        let low = (at as usize).min(TURNS - 1);
        let turns = &self.turns[usize::from(angle_rad > 0.0)];
        if low == 0 {
            // As its square root: ramps alone.
            return at.sqrt() * turns[1];
        }
        turns[low] + (at - low as f64) * (turns[low + 1] - turns[low])
    }

    fn node(
        &self,
        tariff: &Tariff,
        propulsion: &Propulsion,
        elevation: usize,
        azimuth: usize,
    ) -> &[f64; LENGTHS] {
        // Straight up and down there is one direction.
        let azimuth = if elevation.is_multiple_of(ELEVATIONS) { 0 } else { azimuth };
        self.legs[elevation * AZIMUTHS + azimuth].get_or_init(|| {
            let price =
                |n: usize| tariff.leg_price(propulsion, (elevation, azimuth), length_m(n), self.lambda_w);
            Box::new(std::array::from_fn(price))
        })
    }
}

fn length_m(n: usize) -> f64 {
    (f64::from(LEAST) + (n / 4) as f64).exp2() * (1.0 + (n % 4) as f64 / 4.0)
}

/// The length below, the share of the way to the next one, and a factor.
fn at(way_m: f64) -> (usize, f64, f64) {
    // Exponent and the first two bits of the fraction count quarters of octaves.
    const FIRST: u64 = (((1023 + LEAST) as u64) << 52) >> 50;
    let bits = way_m.to_bits();
    match ((bits >> 50) as usize).checked_sub(FIRST as usize) {
        None => (0, 0.0, (way_m / length_m(0)).sqrt()),
        Some(n) if n + 1 < LENGTHS => {
            let low_m = f64::from_bits(bits >> 50 << 50);
            let step_m = f64::from_bits(((bits >> 50) + 1) << 50) - low_m;
            (n, (way_m - low_m) / step_m, 1.0)
        }
        Some(_) => {
            let [low_m, high_m] = [LENGTHS - 2, LENGTHS - 1].map(length_m);
            (LENGTHS - 2, (way_m - low_m) / (high_m - low_m), 1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_lies_between_its_neighbours() {
        for n in 0..LENGTHS {
            let (low, share, _) = at(length_m(n));
            assert!((low as f64 + share - n as f64).abs() < 1e-12, "{n}: {low} {share}");
        }
        for k in 1..20_000 {
            let way_m = 0.01 * f64::from(k);
            let (n, share, scale) = at(way_m);
            let read_m = length_m(n) + share * (length_m(n + 1) - length_m(n));
            let expected_m = if scale < 1.0 { length_m(0) } else { way_m };
            assert!((read_m - expected_m).abs() < 1e-9 * way_m.max(1.0), "{way_m} m: {read_m}");
        }
    }
}
