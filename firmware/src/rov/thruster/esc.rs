//! Limits of one speed controller from instant to instant.
//!
//! - Thrust grows by at most [`EscConstants::slew_n_s`]; it falls at once. Growth is what draws current from the
//!   battery, letting go is always safe, and neutral must come in the very tick in which a lease ends.
//! - Before the propeller turns the other way the controller is left at neutral for [`EscConstants::reversal_delay`].
//!
//! Both by the module's own clock. Assumptions and limits: a demand that is not a number is neutral.

use protocol::configuration::EscConstants;
use protocol::time::{Duration, LocalInstant};
use protocol::units::Newtons;

/// One controller's present.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Esc {
    thrust_n: f32,
    /// Its last thrust was astern, or ahead.
    astern: bool,
    /// Since when it is at neutral, after its last thrust.
    neutral_since: Option<LocalInstant>,
}

impl Esc {
    /// The thrust to put out at `now`, `elapsed` after the last tick, where `demand` is asked.
    pub fn tick(
        &mut self,
        now: LocalInstant,
        elapsed: Duration,
        demand: Newtons,
        rules: &EscConstants,
    ) -> Newtons {
        let demand_n = if demand.0.is_nan() { 0.0 } else { demand.0 };
        let (asked_n, astern) = (libm::fabsf(demand_n), demand_n < 0.0);
        let running_n = libm::fabsf(self.thrust_n);
        let turns = asked_n > 0.0 && astern != self.astern;
        let rested =
            self.neutral_since.is_none_or(|since| now >= since && now.since(since) >= rules.reversal_delay);
        let granted_n = if turns && (running_n > 0.0 || !rested) {
            0.0
        } else {
            // |F(t + Δt)| ≤ |F(t)| + s·Δt
            asked_n.min(running_n + rules.slew_n_s * elapsed.as_secs_f32())
        };
        if granted_n > 0.0 {
            (self.astern, self.neutral_since) = (astern, None);
        } else if running_n > 0.0 {
            self.neutral_since = Some(now);
        }
        self.thrust_n = if astern { -granted_n } else { granted_n };
        Newtons(self.thrust_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const MS: Duration = Duration(1_000);

    /// Thrust at every millisecond of the demands.
    fn follow(rules: &EscConstants, demands: impl IntoIterator<Item = f32>) -> Vec<f32> {
        let mut esc = Esc::default();
        (0..)
            .zip(demands)
            .map(|(ms, demand)| esc.tick(LocalInstant(ms * 1_000), MS, Newtons(demand), rules).0)
            .collect()
    }

    #[test]
    fn thrust_grows_slowly_and_falls_at_once() {
        let rules = EscConstants { slew_n_s: 1_000.0, reversal_delay: Duration(3_000) };
        let out = follow(&rules, [2.5, 2.5, 2.5, 2.5, 1.0, 0.0, 0.5]);
        assert_eq!(out, [1.0, 2.0, 2.5, 2.5, 1.0, 0.0, 0.5], "1 N a millisecond; the same way on, no rest");
    }

    #[test]
    fn the_sign_changes_after_a_rest_at_neutral() {
        let rules = EscConstants { slew_n_s: 1_000.0, reversal_delay: Duration(3_000) };
        let out = follow(&rules, [1.0, -1.5, -1.5, -1.5, -1.5, -1.5, 2.0, 2.0, 2.0, 2.0, f32::NAN]);
        assert_eq!(out, [1.0, 0.0, 0.0, 0.0, -1.0, -1.5, 0.0, 0.0, 0.0, 1.0, 0.0]);
        // Time already spent at neutral counts.
        let out = follow(&rules, [1.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
        assert_eq!(out, [1.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
        let out = follow(&rules, [-0.5, 0.5]);
        assert_eq!(out, [-0.5, 0.0], "nothing to wait for before the first thrust");
    }

    proptest! {
        #[test]
        fn no_demand_breaks_the_rules(bits in proptest::collection::vec(any::<u32>(), 1..80), rest in 0_u32..9) {
            let rules = EscConstants { slew_n_s: 500.0, reversal_delay: Duration(rest * 1_000) };
            let out = follow(&rules, bits.into_iter().map(f32::from_bits));
            let mut last_turning: Option<(usize, bool)> = None;
            let mut before = 0.0_f32;
            for (k, &now) in out.iter().enumerate() {
                prop_assert!(now.abs() <= before.abs() + 0.5 * 1.001, "{out:?}");
                if now != 0.0 {
                    if let Some((then, sign)) = last_turning && sign != (now < 0.0) {
                        prop_assert!(k - then > rest as usize, "{out:?}");
                    }
                    last_turning = Some((k, now < 0.0));
                }
                before = now;
            }
        }
    }
}
