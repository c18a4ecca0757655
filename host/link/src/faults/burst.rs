//! Burst losses: the medium is good or bad, and nothing gets through a bad one.
//!
//! ```text
//! P(bad at t + Δ) = p + ([bad at t] − p)·exp(−Δ / (T·(1 − p)))
//! ```
//!
//! The model of Gilbert and Elliott with a loss of 0 and 1, as a Markov chain in continuous time, so that bursts last
//! equally long whatever the traffic: T⁻¹ leads out of the bad state, p/((1 − p)·T) into it, and their sum is the rate
//! above. Asked at any moments, the chain so sampled has the law of one followed throughout, at one draw a question.
//!
//! | symbol | parameter | unit |
//! |---|---|---|
//! | p | `burst`, share of time in the bad state | |
//! | T | `burst_s`, mean length of a bad state | s |
//!
//! Every radio has bursts of its own.

use protocol::time::FleetInstant;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use super::FaultParameters;

/// The state of the medium, when it was last asked.
#[derive(Debug)]
pub(super) struct Burst {
    rng: ChaCha8Rng,
    last: Option<(FleetInstant, bool)>,
}

impl Burst {
    pub(super) fn new(rng: ChaCha8Rng) -> Self {
        Self { rng, last: None }
    }

    /// Whether the medium is bad at `now`. Draws nothing while bursts are off.
    pub(super) fn is_bad(&mut self, now: FleetInstant, parameters: &FaultParameters) -> bool {
        let share = parameters.burst;
        if share <= 0.0 {
            self.last = None;
            return false;
        }
        let probability = match self.last {
            None => share,
            Some((then, bad)) if now <= then => return bad,
            Some((then, bad)) => {
                let elapsed_s = (now.0 - then.0) as f64 * 1e-6;
                let kept = (-elapsed_s / (parameters.burst_s * (1.0 - share))).exp();
                share + (f64::from(u8::from(bad)) - share) * kept
            }
        };
        let bad = self.rng.random_bool(probability.clamp(0.0, 1.0));
        self.last = Some((now, bad));
        bad
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    /// Share of time in the bad state and mean length of one, s, asked every `step_us` for an hour.
    fn measured(parameters: &FaultParameters, step_us: u64, seed: u64) -> (f64, f64) {
        let mut burst = Burst::new(ChaCha8Rng::seed_from_u64(seed));
        let steps = 3_600_000_000 / step_us;
        let states: Vec<bool> =
            (0..steps).map(|step| burst.is_bad(FleetInstant(step * step_us), parameters)).collect();
        let bad = states.iter().filter(|&&bad| bad).count() as f64;
        let ends = states.windows(2).filter(|pair| pair[0] && !pair[1]).count() as f64;
        (bad / steps as f64, bad * step_us as f64 * 1e-6 / ends)
    }

    #[test]
    fn share_and_mean_length_are_those_asked_for() {
        for (burst, burst_s) in [(0.05, 0.2), (0.2, 0.5), (0.5, 0.1), (0.8, 1.0)] {
            let parameters = FaultParameters { burst, burst_s, ..Default::default() };
            for seed in 0..3 {
                let (share, mean_s) = measured(&parameters, 1000, seed);
                assert!((share / burst - 1.0).abs() < 0.1, "{burst} {burst_s} seed {seed}: share {share}");
                assert!((mean_s / burst_s - 1.0).abs() < 0.1, "{burst} {burst_s} seed {seed}: {mean_s} s");
                // Time counts, not traffic: asked two hundred times more rarely, the share stays.
                let (share, _) = measured(&parameters, 200_000, seed);
                assert!((share / burst - 1.0).abs() < 0.15, "{burst} {burst_s} seed {seed}: rarely {share}");
            }
        }
    }

    #[test]
    fn the_ends_of_the_range_hold() {
        let always = FaultParameters { burst: 1.0, burst_s: 0.1, ..Default::default() };
        let mut burst = Burst::new(ChaCha8Rng::seed_from_u64(1));
        assert!((0..1000).all(|ms| burst.is_bad(FleetInstant(ms * 1000), &always)));
        // The clock may stand still or go back; the state stays.
        assert!(burst.is_bad(FleetInstant(0), &always));
        assert!(!burst.is_bad(FleetInstant(2_000_000), &FaultParameters::default()), "off is good at once");
    }
}
