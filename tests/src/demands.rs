//! Seeded demands inside a share of a structure's envelope W: one by one, or in a sequence as a controller asks for
//! them.
//!
//! Both are uniform in volume over (Fx, Fy, τ): the chance of a gauge of at most s·share is s³ (s² for one module
//! alone, which has no torque).
//!
//! - [`Uniform`] throws into the bounding box of share·W and keeps what falls inside.
//! - [`Correlated`] walks: each demand is the last plus a normal step, its deviation a given part of the half box. A step
//!   that would leave share·W is reflected back along its line, where it leaves. With or without reflection a step
//!   leads from a to b as likely as from b to a, so the walk is uniform in the long run, and no demand comes twice.

use std::f64::consts::TAU;

use modboat::envelope::Envelope;
use modboat::motion::Wrench;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};

/// Independent demands.
pub struct Uniform {
    envelope: Envelope,
    share: f64,
    /// Half the bounding box of share·W: N, N, N·m.
    half: [f64; 3],
    rng: ChaCha8Rng,
}

impl Uniform {
    /// Inside `share` of `envelope`.
    #[must_use]
    pub fn new(envelope: Envelope, share: f64, seed: u64) -> Self {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let half = axes.map(|axis| share * envelope.support(axis));
        Self { envelope, share, half, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    fn holds(&self, wrench: [f64; 3]) -> bool {
        self.envelope.gauge(Wrench::from_array(wrench)) <= self.share
    }
}

impl Iterator for Uniform {
    type Item = Wrench;

    fn next(&mut self) -> Option<Wrench> {
        loop {
            let thrown = self.half.map(|half| half * self.rng.random_range(-1.0..1.0));
            if self.holds(thrown) {
                return Some(Wrench::from_array(thrown));
            }
        }
    }
}

/// Demands of which each is near the last.
pub struct Correlated {
    inside: Uniform,
    step: f64,
    last: Option<[f64; 3]>,
}

impl Correlated {
    /// Inside `share` of `envelope`, with steps of a standard deviation of `step` of the half box along each axis.
    #[must_use]
    pub fn new(envelope: Envelope, share: f64, step: f64, seed: u64) -> Self {
        Self { inside: Uniform::new(envelope, share, seed), step, last: None }
    }

    /// Where a line from `from` along `step` leaves the set, in steps.
    fn exit(&self, from: [f64; 3], step: [f64; 3]) -> f64 {
        let (mut inside, mut outside) = (0.0, 1.0);
        while self.inside.holds(along(from, step, outside)) {
            (inside, outside) = (outside, 2.0 * outside);
        }
        while outside - inside > 1e-9 * outside {
            let middle = 0.5 * (inside + outside);
            if self.inside.holds(along(from, step, middle)) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}

impl Iterator for Correlated {
    type Item = Wrench;

    fn next(&mut self) -> Option<Wrench> {
        let next = match self.last {
            None => self.inside.next()?.to_array(),
            Some(last) => {
                let deviations = [0; 3].map(|_| self.step * normal(&mut self.inside.rng));
                let step = [0, 1, 2].map(|k| deviations[k] * self.inside.half[k]);
                let mut next = along(last, step, 1.0);
                if !self.inside.holds(next) {
                    let high = self.exit(last, step);
                    let low = -self.exit(last, step.map(|v| -v));
                    next = along(last, step, folded(1.0, low, high));
                }
                next
            }
        };
        self.last = Some(next);
        Some(Wrench::from_array(next))
    }
}

fn along(from: [f64; 3], step: [f64; 3], steps: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| from[k] + steps * step[k])
}

/// A coordinate reflected between `low` and `high` as often as it takes.
fn folded(at: f64, low: f64, high: f64) -> f64 {
    let length = high - low;
    let round = (at - low).rem_euclid(2.0 * length);
    low + round.min(2.0 * length - round)
}

/// A standard normal variate (Box and Muller).
fn normal(rng: &mut impl Rng) -> f64 {
    let size = (-2.0 * (1.0 - rng.random_range(0.0..1.0_f64)).ln()).sqrt();
    size * (TAU * rng.random_range(0.0..1.0_f64)).cos()
}

#[cfg(test)]
mod tests {
    use modboat::parameters::Parameters;
    use modboat::structure::Structure;

    use super::*;

    fn envelope(size: &str) -> Envelope {
        let (structure, parameters) = (Structure::from_word(size).unwrap(), Parameters::default());
        Envelope::new(&structure.positions_m(parameters.pitch_m), &parameters)
    }

    /// Greatest distance between the distribution of gauges and (gauge/share)^power (Kolmogorov and Smirnov).
    fn misfit(envelope: &Envelope, demands: &[Wrench], share: f64, power: i32) -> f64 {
        let mut told: Vec<f64> = demands.iter().map(|d| (envelope.gauge(*d) / share).powi(power)).collect();
        told.sort_by(f64::total_cmp);
        let count = told.len() as f64;
        told.iter().enumerate().map(|(k, told)| (told - (k as f64 + 0.5) / count).abs()).fold(0.0, f64::max)
    }

    /// Of the demands, which share has each of the eight combinations of signs.
    fn octants(demands: &[Wrench]) -> [f64; 8] {
        let mut shares = [0.0; 8];
        for demand in demands {
            let signs = demand.to_array().map(|v| usize::from(v > 0.0));
            shares[signs[0] + 2 * signs[1] + 4 * signs[2]] += 1.0 / demands.len() as f64;
        }
        shares
    }

    #[test]
    fn uniform_demands_fill_the_share_by_volume() {
        // The misfit of 20 000 exceeds 1.95/√20 000 = 0.0138 once in a thousand.
        for (size, share, power) in
            [("3x1", 0.6, 3), ("1x2", 0.95, 3), ("3x3", 0.6, 3), ("5x2", 0.8, 3), ("1x1", 0.6, 2)]
        {
            let envelope = envelope(size);
            let demands: Vec<_> = Uniform::new(envelope.clone(), share, 11).take(20_000).collect();
            assert!(demands.iter().all(|d| envelope.gauge(*d) <= share));
            let misfit = misfit(&envelope, &demands, share, power);
            assert!(misfit < 0.0138, "seed 11, {size}: {misfit}");
            // Rectangles look alike in every octant; 5σ of 1/8.
            if power == 3 {
                let shares = octants(&demands);
                assert!(shares.iter().all(|s| (s - 0.125).abs() < 0.012), "seed 11, {size}: {shares:?}");
            }
        }
    }

    /// The part of the box that is kept is the volume of the envelope. For two modules, in units of F and d/2, with
    /// u_y of both and the length left for u_x: V = ∫∫ 2(√(1−a²) + √(1−b²))·2 da db = 8π over [−1, 1]²; the box has
    /// 4·4·4.
    #[test]
    fn the_volume_of_two_modules() {
        let mut demands = Uniform::new(envelope("2x1"), 1.0, 12);
        let kept = (0..20_000)
            .filter(|_| {
                let thrown = demands.half.map(|half| half * demands.rng.random_range(-1.0..1.0));
                demands.holds(thrown)
            })
            .count();
        let told = TAU / 16.0;
        // 5σ = 5·√(0.39·0.61/20 000)
        assert!((kept as f64 / 20_000.0 - told).abs() < 0.0175, "seed 12: {kept} of 20 000, not {told}");
    }

    #[test]
    fn a_walk_is_uniform_in_the_long_run_and_near_in_the_short() {
        let (share, step) = (0.6, 0.15);
        for (size, power) in [("3x1", 3), ("3x3", 3), ("1x1", 2)] {
            let envelope = envelope(size);
            let walk: Vec<_> = Correlated::new(envelope.clone(), share, step, 13).take(60_000).collect();
            assert!(walk.iter().all(|d| envelope.gauge(*d) <= share));
            // Every 60th knows little of the one before: as above, for 1000.
            let thin: Vec<_> = walk.iter().step_by(60).copied().collect();
            let misfit = misfit(&envelope, &thin, share, power);
            assert!(misfit < 0.0617, "seed 13, {size}: {misfit}");
            if power == 3 {
                // 5σ of 1/8 for 1000.
                let shares = octants(&thin);
                assert!(shares.iter().all(|s| (s - 0.125).abs() < 0.052), "seed 13, {size}: {shares:?}");
            }
            // Reflection can only shorten a step.
            let force_n = share * envelope.support([1.0, 0.0, 0.0]);
            let steps = walk.windows(2).map(|pair| (pair[1].fx_n - pair[0].fx_n) / force_n);
            let deviation = (steps.map(|s| s * s).sum::<f64>() / walk.len() as f64).sqrt();
            assert!(deviation <= 1.02 * step && deviation > 0.8 * step, "seed 13, {size}: {deviation}");
            assert!(walk.windows(2).all(|pair| pair[0] != pair[1]), "seed 13, {size}: the same demand twice");
        }
    }

    #[test]
    fn steps_longer_than_the_set_stay_inside_and_seeds_tell_walks_apart() {
        let envelope = envelope("2x2");
        let walk = |seed| Correlated::new(envelope.clone(), 0.6, 5.0, seed).take(2000).collect::<Vec<_>>();
        let demands = walk(14);
        assert!(demands.iter().all(|d| envelope.gauge(*d) <= 0.6));
        let misfit = misfit(&envelope, &demands, 0.6, 3);
        assert!(misfit < 0.0436, "seed 14: {misfit}");
        assert!(demands == walk(14) && demands != walk(15));
        for (at, told) in [(0.5, 0.5), (1.25, 0.75), (-0.25, 0.25), (2.25, 0.25), (-1.5, 0.5)] {
            assert!((folded(at, 0.0, 1.0) - told).abs() < 1e-12, "{at}");
        }
    }
}
