//! Detection of a low battery.
//!
//! Low once U < U_low for the hold-off, and no longer once U ≥ U_recover for the hold-off.
//!
//! | symbol | Modboat, two lithium cells | ROV, four | unit |
//! |---|---|---|---|
//! | U_low | 6.4, *assumed* | 13.2, *assumed* | V |
//! | U_recover | 6.8, *assumed* | 13.6, *assumed* | V |
//! | hold-off | 2, *assumed* | 2, *assumed* | s |
//!
//! Assumptions and limits: the voltage sags under load, hence the hold-off, and comes back without it, hence the second
//! threshold. A voltage that is not a finite number is unknown and changes nothing: a board without a sensor gives NaN.

use protocol::configuration::BatteryLimits;
use protocol::time::LocalInstant;
use protocol::units::Volts;

use super::lasting::Lasting;

/// Detects a low battery, with hysteresis and a hold-off.
#[derive(Clone, Debug)]
pub struct BatteryWatch {
    limits: BatteryLimits,
    low: bool,
    crossed: Lasting,
}

impl BatteryWatch {
    /// Of a battery that is not low.
    #[must_use]
    pub const fn new(limits: BatteryLimits) -> Self {
        Self { limits, low: false, crossed: Lasting::new() }
    }

    /// Takes a measurement at `now`, own clock; whether the battery is low.
    pub fn update(&mut self, now: LocalInstant, battery: Volts) -> bool {
        if !battery.is_finite() {
            return self.low;
        }
        let BatteryLimits { low, recover, hold_off } = self.limits;
        let crossed = if self.low { battery >= low && battery >= recover } else { battery < low };
        if self.crossed.update(now, crossed, hold_off) {
            self.low = !self.low;
            self.crossed = Lasting::new();
        }
        self.low
    }

    /// Whether it was low at the last measurement.
    #[must_use]
    pub const fn is_low(&self) -> bool {
        self.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use protocol::time::Duration;

    /// Feeds a constant voltage every 10 ms over `span_ms`, and gives the last answer.
    fn feed(watch: &mut BatteryWatch, now_ms: &mut u64, span_ms: u64, volts: f32) -> bool {
        for _ in 0..span_ms / 10 {
            *now_ms += 10;
            watch.update(LocalInstant(*now_ms * 1000), Volts(volts));
        }
        watch.is_low()
    }

    #[test]
    fn sags_are_ridden_through() {
        let (mut watch, mut now) = (BatteryWatch::new(BatteryLimits::MODBOAT), 0);
        for _ in 0..10 {
            assert!(!feed(&mut watch, &mut now, 1990, 5.0), "a swing of the tail");
            assert!(!feed(&mut watch, &mut now, 10, 6.4), "the threshold itself is not low");
        }
        assert!(!feed(&mut watch, &mut now, 2000, 6.39));
        assert!(feed(&mut watch, &mut now, 10, 6.39));
    }

    #[test]
    fn recovers_above_the_second_threshold_only() {
        let (mut watch, mut now) = (BatteryWatch::new(BatteryLimits::ROV), 0);
        assert!(feed(&mut watch, &mut now, 3000, 12.0));
        assert!(feed(&mut watch, &mut now, 60_000, 13.59), "between the two nothing changes");
        assert!(feed(&mut watch, &mut now, 1990, 13.6));
        assert!(feed(&mut watch, &mut now, 10, 13.5), "a break restarts it");
        assert!(!feed(&mut watch, &mut now, 2010, 13.6));
        assert!(!feed(&mut watch, &mut now, 60_000, 13.3), "and between them from above");
    }

    #[test]
    fn what_is_unknown_changes_nothing() {
        let (mut watch, mut now) = (BatteryWatch::new(BatteryLimits::MODBOAT), 0);
        for volts in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(!feed(&mut watch, &mut now, 60_000, volts));
        }
        assert!(!feed(&mut watch, &mut now, 1000, 6.0));
        assert!(!feed(&mut watch, &mut now, 5000, f32::NAN), "it does not decide by itself");
        assert!(feed(&mut watch, &mut now, 10, 6.0), "nor does it break what lasts");
        for volts in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(feed(&mut watch, &mut now, 60_000, volts));
        }
    }

    #[test]
    fn thresholds_the_wrong_way_round_do_not_make_it_swing() {
        let limits = BatteryLimits { recover: Volts(6.0), hold_off: Duration(0), ..BatteryLimits::MODBOAT };
        let mut watch = BatteryWatch::new(limits);
        for now in 0..10 {
            assert!(watch.update(LocalInstant(now), Volts(6.2)));
        }
        let limits = BatteryLimits { low: Volts(f32::NAN), ..limits };
        assert!(!BatteryWatch::new(limits).update(LocalInstant(0), Volts(0.0)));
    }

    proptest! {
        /// It changes its mind at most once in a hold-off, whatever is measured.
        #[test]
        fn never_swings_faster_than_the_hold_off(volts in proptest::collection::vec(0.0_f32..9.0, 1..400)) {
            let mut watch = BatteryWatch::new(BatteryLimits { hold_off: Duration(20), ..BatteryLimits::MODBOAT });
            let (mut last, mut changed) = (false, None);
            for (now, volts) in (0_u64..).step_by(10).zip(volts) {
                let low = watch.update(LocalInstant(now), Volts(volts));
                if low != last {
                    prop_assert!(changed.is_none_or(|changed| now - changed > 20));
                    (last, changed) = (low, Some(now));
                }
            }
        }
    }
}
