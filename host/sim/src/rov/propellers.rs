//! Speed controllers and propellers of one ROV: from the pulses at its pins to the thrusts that the water feels.
//!
//! ```text
//! τ·Ḟ = F(p, V) − F      F(p, V): the firmware's own table
//! ```
//!
//! Assumptions and limits: one lag τ for spinning up and down; a pulse that never comes (no power) stops the
//! propeller, as the controller does by itself. A failed thruster gives nothing and draws nothing.

use firmware::rov::thruster::law;
use protocol::units::{PulseMicros, Volts};

/// Time constant τ of thrust after a change of the pulse, s. *Assumed.*
pub const LAG_S: f64 = 0.1;

#[derive(Clone, Copy, Debug)]
struct Propeller {
    reversed: bool,
    failed: bool,
    pulse: PulseMicros,
}

/// All propellers of one ROV.
#[derive(Clone, Debug)]
pub struct Propellers {
    propellers: Vec<Propeller>,
    thrusts_n: Vec<f64>,
}

impl Propellers {
    /// At rest. One flag a thruster: whether its pulse is mirrored at neutral.
    #[must_use]
    pub fn new(reversed: &[bool]) -> Self {
        let at_rest = |&reversed| Propeller { reversed, failed: false, pulse: law::NEUTRAL };
        Self { propellers: reversed.iter().map(at_rest).collect(), thrusts_n: vec![0.0; reversed.len()] }
    }

    /// What the controllers read from now on. Without a pulse for it, a controller stops.
    pub fn set_pulses(&mut self, pulses: impl IntoIterator<Item = PulseMicros>) {
        let pulses = pulses.into_iter().chain(std::iter::repeat(law::NEUTRAL));
        for (propeller, pulse) in self.propellers.iter_mut().zip(pulses) {
            propeller.pulse = pulse;
        }
    }

    /// Breaks a thruster for good; an index beyond the last does nothing.
    pub fn set_failed(&mut self, index: usize) {
        if let Some(propeller) = self.propellers.get_mut(index) {
            propeller.failed = true;
            self.thrusts_n[index] = 0.0;
        }
    }

    /// Lets `dt_s` pass with the present pulses.
    pub fn step(&mut self, dt_s: f64, battery: Volts) {
        // F(t + Δt) = F(p, V) + (F(t) − F(p, V))·exp(−Δt/τ), exact while the pulse stays
        let stays = (-dt_s / LAG_S).exp();
        for (propeller, thrust_n) in self.propellers.iter().zip(&mut self.thrusts_n) {
            let steady_n = f64::from(law::thrust(propeller.ahead(), battery).0);
            *thrust_n = if propeller.failed { 0.0 } else { steady_n + (*thrust_n - steady_n) * stays };
        }
    }

    /// Thrusts along each thruster's axis, N.
    #[must_use]
    pub fn thrusts_n(&self) -> &[f64] {
        &self.thrusts_n
    }

    /// What the controllers read.
    pub fn pulses(&self) -> impl Iterator<Item = PulseMicros> {
        self.propellers.iter().map(|propeller| propeller.pulse)
    }

    /// What all of them draw from the battery, A.
    #[must_use]
    pub fn current_a(&self, battery: Volts) -> f64 {
        let running = self.propellers.iter().filter(|propeller| !propeller.failed);
        running.map(|propeller| f64::from(law::current(propeller.ahead(), battery).0)).sum()
    }
}

impl Propeller {
    /// The pulse that would give the same to one that is not reversed.
    fn ahead(&self) -> PulseMicros {
        if self.reversed { law::mirrored(self.pulse) } else { self.pulse }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BATTERY: Volts = Volts(16.0);

    #[test]
    fn thrust_follows_with_the_lag_and_the_flag_turns_the_pulse_round() {
        let mut propellers = Propellers::new(&[false, true, false]);
        propellers.set_failed(2);
        propellers.set_pulses([1700.0, 1300.0, 1700.0].map(PulseMicros));
        // One time constant in ten steps: 1 − 1/e of the table's 1700 µs at 16 V.
        for _ in 0..10 {
            propellers.step(0.01, BATTERY);
        }
        let steady_n = f64::from(law::thrust(PulseMicros(1700.0), BATTERY).0);
        let wanted_n = steady_n * (1.0 - (-1.0_f64).exp());
        let [ahead, mirrored, failed] = propellers.thrusts_n() else { panic!("three thrusters") };
        assert!(steady_n > 15.0 && (ahead - wanted_n).abs() < 1e-9, "{ahead} N");
        assert!((mirrored - ahead).abs() < 1e-12 && failed.abs() < 1e-12, "{mirrored} N, {failed} N");
        let one_a = f64::from(law::current(PulseMicros(1700.0), BATTERY).0);
        assert!((propellers.current_a(BATTERY) - 2.0 * one_a).abs() < 1e-9);
        propellers.set_pulses([]);
        propellers.step(2.0, BATTERY);
        assert!(propellers.thrusts_n().iter().all(|thrust_n| thrust_n.abs() < 1e-6));
    }
}
