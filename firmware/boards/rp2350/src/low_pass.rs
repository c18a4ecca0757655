//! A first-order low-pass filter for measurements at a fixed interval.
//!
//! y ← y + (x − y)·Δt/(τ + Δt)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, y | measured, filtered | V |
//! | τ | time constant | s |
//! | Δt | interval | s |
//!
//! The first measurement is taken as it is.

/// A first-order low-pass filter, updated at a fixed interval.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    share: f32,
    state: Option<f32>,
}

impl LowPass {
    /// With a time constant τ, once every Δt; both in microseconds, not both zero.
    #[must_use]
    pub fn new(time_constant_us: u32, interval_us: u32) -> Self {
        let (time_constant, interval) = (time_constant_us as f32, interval_us as f32);
        Self { share: interval / (time_constant + interval), state: None }
    }

    /// Takes a measurement; what the filter shows then.
    pub fn update(&mut self, measured: f32) -> f32 {
        let former = self.state.unwrap_or(measured);
        *self.state.insert(former + (measured - former) * self.share)
    }

    /// What it shows; nothing before the first measurement.
    #[must_use]
    pub const fn get(&self) -> Option<f32> {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_with_its_time_constant() {
        let mut filter = LowPass::new(50_000, 1_000);
        assert_eq!(filter.get(), None);
        assert_eq!(filter.update(1.0), 1.0);
        let after_one = (0..50).map(|_| filter.update(3.0)).last().unwrap();
        // (1 + 1/50)⁻⁵⁰ of the step is left.
        assert!((after_one - (3.0 - 2.0 * 0.3715)).abs() < 1e-3, "{after_one}");
        let after_ten = (0..450).map(|_| filter.update(3.0)).last().unwrap();
        assert!((after_ten - 3.0).abs() < 1e-3 && filter.get() == Some(after_ten));
    }
}
