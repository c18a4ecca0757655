//! Motion capture: the structure's pose at a fixed rate, with Gaussian noise.
//!
//! The paper's tank has an OptiTrack system at 120 Hz. The noise figures are *assumed* (a marker body of some
//! 15 cm seen by several cameras). Velocities are not measured: the host estimates them.
//!
//! Assumptions and limits: noise is white and independent per fix; no latency, no lost markers.

use modboat::observer::Fix;
use quantity::{ParameterError, Range, check_ranges, wrap_rad};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use record::PoseSample;
use serde::{Deserialize, Serialize};

/// Rate and noise of the motion capture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MocapParameters {
    /// Fixes per second, Hz. Paper, section IV.
    pub rate_hz: f64,
    /// Standard deviation of each coordinate, m. *Assumed.*
    pub position_noise_m: f64,
    /// Standard deviation of the heading, rad. *Assumed.*
    pub heading_noise_rad: f64,
}

impl Default for MocapParameters {
    fn default() -> Self {
        Self { rate_hz: 120.0, position_noise_m: 5e-4, heading_noise_rad: 2e-3 }
    }
}

impl MocapParameters {
    /// Refuses what no motion capture can have, by the first offending key.
    ///
    /// # Errors
    /// [`ParameterError`] with the key, its value and unit, and what is asked of it.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges(&[
            ("rate_hz", self.rate_hz, "Hz", Range::Positive),
            ("position_noise_m", self.position_noise_m, "m", Range::NonNegative),
            ("heading_noise_rad", self.heading_noise_rad, "rad", Range::NonNegative),
        ])
    }
}

/// The cameras. Frame n is due at n/rate; the first at time zero.
#[derive(Debug)]
pub struct Mocap {
    parameters: MocapParameters,
    next_frame: u64,
    rng: ChaCha8Rng,
}

impl Mocap {
    /// Cameras with their own noise for `seed`.
    ///
    /// # Errors
    /// As [`MocapParameters::validate`].
    pub fn new(parameters: &MocapParameters, seed: u64) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self { parameters: parameters.clone(), next_frame: 0, rng: ChaCha8Rng::seed_from_u64(seed) })
    }

    /// A noisy fix of the true pose, if a frame has become due by `t_s`. A frame is stamped with the time of the
    /// pose; frames that fell between two calls are lost.
    pub fn sample(&mut self, t_s: f64, pose: &PoseSample) -> Option<Fix> {
        // Half a microsecond of slack: the sum of many steps falls just short of n/rate.
        let frame = (t_s + 5e-7) * self.parameters.rate_hz;
        if frame < self.next_frame as f64 {
            return None;
        }
        self.next_frame = frame as u64 + 1;
        let mut noise = |deviation: f64| -> f64 {
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            deviation * normal
        };
        let (position_noise_m, heading_noise_rad) =
            (self.parameters.position_noise_m, self.parameters.heading_noise_rad);
        let position_m = pose.position_m.map(|x| x + noise(position_noise_m));
        let heading_rad = wrap_rad(pose.heading_rad + noise(heading_noise_rad));
        Some(Fix { t_s, position_m, heading_rad })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixes_come_at_120_hz_with_the_stated_noise() {
        let seed = 7;
        let mut mocap = Mocap::new(&MocapParameters::default(), seed).expect("valid");
        let truth = PoseSample { position_m: [1.0, -2.0], heading_rad: 10.0, ..PoseSample::default() };
        let mut fixes = Vec::new();
        let mut t_s = 0.0;
        for _ in 0..100_000 {
            fixes.extend(mocap.sample(t_s, &truth));
            t_s += 1e-3;
        }
        assert_eq!(fixes.len(), 12_000, "100 s");
        for (frame, fix) in fixes.iter().enumerate() {
            let late_s = fix.t_s - frame as f64 / 120.0;
            assert!((-1e-6..1e-3).contains(&late_s), "frame {frame} is {late_s} s late");
        }
        // 10 rad − 4π = −2.566 rad.
        let wrapped_rad = 10.0 - 2.0 * std::f64::consts::TAU;
        let statistics = |value: fn(&Fix) -> f64| {
            let n = fixes.len() as f64;
            let mean = fixes.iter().map(value).sum::<f64>() / n;
            (mean, (fixes.iter().map(|fix| (value(fix) - mean).powi(2)).sum::<f64>() / n).sqrt())
        };
        for (value, mean, deviation) in [
            ((|fix| fix.position_m[0]) as fn(&Fix) -> f64, 1.0, 5e-4),
            (|fix| fix.position_m[1], -2.0, 5e-4),
            (|fix| fix.heading_rad, wrapped_rad, 2e-3),
        ] {
            let (seen_mean, seen_deviation) = statistics(value);
            // Four standard errors: σ/√12000 = 0.009 σ of the mean, 0.0065 σ of the deviation.
            assert!((seen_mean - mean).abs() < 0.037 * deviation, "seed {seed}: mean {seen_mean}");
            assert!((seen_deviation / deviation - 1.0).abs() < 0.026, "seed {seed}: {seen_deviation}");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_noise_and_another_another() {
        let first = |seed| {
            let mut mocap = Mocap::new(&MocapParameters::default(), seed).expect("valid");
            mocap.sample(0.0, &PoseSample::default()).expect("first frame")
        };
        assert_eq!(first(1), first(1));
        assert_ne!(first(1), first(2));
    }

    #[test]
    fn frames_between_two_calls_are_lost_not_made_up() {
        let parameters =
            MocapParameters { position_noise_m: 0.0, heading_noise_rad: 0.0, ..Default::default() };
        let mut mocap = Mocap::new(&parameters, 0).expect("valid");
        let times =
            [0.0, 0.001, 1.0, 1.001, 1.009].map(|t_s| mocap.sample(t_s, &PoseSample::default()).is_some());
        assert_eq!(times, [true, false, true, false, true]);
    }
}
