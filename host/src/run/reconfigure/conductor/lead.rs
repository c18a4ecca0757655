//! Commands that lead the propellers' lag.
//!
//! ```text
//! u_c = û + (u − û)/(1 − exp(−T/τ)),   on the side of u        û' = u_c + (û − u_c)·exp(−T/τ)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | u, u_c | thrust wanted, thrust commanded for the next period | N |
//! | û, û' | thrust that the propeller should give at the beginning, at the end of it | N |
//! | T, τ | period, time constant of the propeller ([`LAG_S`]) | s |
//!
//! A propeller told u gives u some 0.3 s later; told u_c it does at the end of the period. So the planned steps of
//! acceleration are given as planned, and draw what was planned: led by nothing, steps of half a second are smeared out
//! and draw a tenth less than planned, since power grows faster than thrust. No command crosses zero for this:
//! no propeller is reversed to stop it.
//!
//! Assumptions and limits: one lag for all, known; limits of thrust cut the lead.

use sim::rov::propellers::LAG_S;

/// What every propeller should give by now.
#[derive(Clone, Debug)]
pub(super) struct Lead {
    given_n: Vec<Vec<f64>>,
    limits_n: (f64, f64),
    /// exp(−T/τ).
    stays: f64,
}

impl Lead {
    /// For robots with so many thrusters each, at rest.
    pub fn new(thrusters: impl Iterator<Item = usize>, limits_n: (f64, f64), period_s: f64) -> Self {
        let given_n = thrusters.map(|count| vec![0.0; count]).collect();
        Self { given_n, limits_n, stays: (-period_s / LAG_S).exp() }
    }

    /// Thrusts wanted of a robot become commands for the next period. One that does not answer stands still.
    pub fn lead(&mut self, robot: usize, thrusts_n: &mut [f64], answers: bool) {
        let Some(given_n) = self.given_n.get_mut(robot) else { return };
        let (low_n, high_n) = self.limits_n;
        for (thrust_n, given_n) in thrusts_n.iter_mut().zip(given_n) {
            // u_c = û + (u − û)/(1 − exp(−T/τ))
            let leading_n = *given_n + (*thrust_n - *given_n) / (1.0 - self.stays);
            *thrust_n = match *thrust_n {
                ahead_n if ahead_n > 0.0 => leading_n.clamp(0.0, high_n),
                astern_n if astern_n < 0.0 => leading_n.clamp(low_n, 0.0),
                _ => 0.0,
            };
            let driven_n = if answers { *thrust_n } else { 0.0 };
            *given_n = driven_n + (*given_n - driven_n) * self.stays;
        }
    }
}

#[cfg(test)]
mod tests {
    use protocol::units::{Newtons, Volts};
    use sim::rov::propellers::Propellers;

    use super::*;

    /// On the simulated propellers: what is wanted is there at the end of the period, up and down, but for stops.
    #[test]
    fn a_period_later_the_propeller_gives_what_is_wanted() {
        let battery = Volts(16.0);
        let mut propellers = Propellers::new(&[false]);
        let mut lead = Lead::new([1].into_iter(), (-39.0, 50.0), 0.05);
        let mut before_n: f64 = 0.0;
        for wanted_n in [2.0, 6.0, 5.0, -3.0, -2.5, 0.0, 0.0, 1.0] {
            let mut command_n = [wanted_n];
            lead.lead(0, &mut command_n, true);
            assert!(command_n[0] * wanted_n >= 0.0, "{wanted_n} N: {command_n:?}");
            propellers
                .set_pulses([firmware::rov::thruster::law::pulse(Newtons(command_n[0] as f32), battery)]);
            for _ in 0..10 {
                propellers.step(0.005, battery);
            }
            let given_n = propellers.thrusts_n()[0];
            let expected_n = if wanted_n == 0.0 { before_n * (-0.5_f64).exp() } else { wanted_n };
            assert!((given_n - expected_n).abs() < 1e-3, "{wanted_n} N: {given_n} N");
            before_n = given_n;
        }
        // One that is silent is told the same, and is taken to stand when it is back.
        let mut command_n = [1.0];
        (0..60).for_each(|_| lead.lead(0, &mut command_n, false));
        let mut command_n = [1.0];
        lead.lead(0, &mut command_n, true);
        assert!((command_n[0] - 1.0 / (1.0 - (-0.5_f64).exp())).abs() < 1e-6, "{command_n:?}");
    }
}
