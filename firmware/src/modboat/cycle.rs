//! One cycle of one module: a transition, then one swim cycle, beginning at an instant of the fleet clock.
//!
//! ```text
//!   start            start + t_trans                         start + t_trans + T = end
//!     │  one law of time │  φ₀ + A·cos(2πt/T)                     │
//!   start pose         φ₀ + A                                   φ₀ + A = end pose
//! ```
//!
//! The start pose is not sent: it is the end pose less the rotation, so the two halves always meet.
//!
//! Assumptions and limits: before its start it stands at its start pose, after its end at its end pose. Times
//! are subtracted as whole microseconds before anything becomes `f32`; spans beyond 71 minutes saturate.

use protocol::TransitionLaw;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;

use crate::modboat::reference::Reference;
use crate::modboat::transition::Transition;
use crate::modboat::waveform::Waveform;

/// Where in a cycle an instant lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Before its start.
    Waiting,
    /// In the transition.
    Turning,
    /// In the swim cycle.
    Swimming,
    /// At or after its end.
    Done,
}

/// Transition and swim cycle, numbered and dated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwimCycle {
    number: u32,
    start: FleetInstant,
    transition: Transition,
    waveform: Waveform,
}

impl SwimCycle {
    /// Cycle `number`, beginning at `start` (fleet time): turns by `rotation` within `transition` by `law`, then swims
    /// `waveform` once.
    #[must_use]
    pub fn new(
        number: u32,
        start: FleetInstant,
        rotation: Radians,
        (transition, law): (Duration, TransitionLaw),
        waveform: Waveform,
    ) -> Self {
        let transition = Transition::arriving_at(waveform.start_pose(), rotation, transition, law);
        Self { number, start, transition, waveform }
    }

    /// Its number k.
    #[must_use]
    pub const fn number(&self) -> u32 {
        self.number
    }

    /// Start of its transition, fleet time.
    #[must_use]
    pub const fn start(&self) -> FleetInstant {
        self.start
    }

    /// End of its swim cycle, fleet time.
    #[must_use]
    pub fn end(&self) -> FleetInstant {
        self.start.after(self.transition.duration()).after(self.waveform.period())
    }

    /// Its transition.
    #[must_use]
    pub const fn transition(&self) -> &Transition {
        &self.transition
    }

    /// Its swim cycle.
    #[must_use]
    pub const fn waveform(&self) -> &Waveform {
        &self.waveform
    }

    /// The pose it sets out from, in (−π, π].
    #[must_use]
    pub fn start_pose(&self) -> Radians {
        self.transition.start_pose()
    }

    /// The pose it ends at, φ₀ + A in (−π, π].
    #[must_use]
    pub const fn end_pose(&self) -> Radians {
        self.waveform.start_pose()
    }

    /// Where `now` (fleet time) lies in it.
    #[must_use]
    pub fn phase(&self, now: FleetInstant) -> Phase {
        if now < self.start {
            Phase::Waiting
        } else if now < self.start.after(self.transition.duration()) {
            Phase::Turning
        } else if now < self.end() {
            Phase::Swimming
        } else {
            Phase::Done
        }
    }

    /// What the tail is to do at `now` (fleet time).
    #[must_use]
    pub fn reference(&self, now: FleetInstant) -> Reference {
        let elapsed = now.since(self.start);
        match self.phase(now) {
            Phase::Waiting => Reference::at_rest(self.start_pose().0),
            Phase::Turning => self.transition.reference(elapsed),
            Phase::Swimming => {
                self.waveform.reference(Duration(elapsed.0.saturating_sub(self.transition.duration().0)))
            }
            Phase::Done => Reference::at_rest(self.end_pose().0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modboat::reference::wrap;
    use proptest::prelude::*;

    fn cycle(start: u64) -> SwimCycle {
        let waveform = Waveform::new(Radians(-1.0), Radians(2.0), Duration(1_500_000));
        let transition = (Duration(500_000), TransitionLaw::ConstantSpeed);
        SwimCycle::new(7, FleetInstant(start), Radians(-2.5), transition, waveform)
    }

    #[test]
    fn goes_through_its_phases_to_the_microsecond() {
        let cycle = cycle(1_000_000);
        for (now, phase) in [
            (0, Phase::Waiting),
            (999_999, Phase::Waiting),
            (1_000_000, Phase::Turning),
            (1_499_999, Phase::Turning),
            (1_500_000, Phase::Swimming),
            (2_999_999, Phase::Swimming),
            (3_000_000, Phase::Done),
            (u64::MAX, Phase::Done),
        ] {
            assert_eq!(cycle.phase(FleetInstant(now)), phase, "{now} µs");
        }
        assert_eq!(cycle.end(), FleetInstant(3_000_000));
    }

    #[test]
    fn stands_still_outside_and_turns_the_way_it_was_told() {
        let cycle = cycle(1_000_000);
        let before = cycle.reference(FleetInstant(999_999));
        assert!(wrap(before.angle_rad - 3.5).abs() < 1e-6 && before.rate_rad_s == 0.0);
        assert!((cycle.reference(FleetInstant(1_000_000)).rate_rad_s + 5.0).abs() < 1e-5);
        assert_eq!(cycle.reference(FleetInstant(3_000_000)), Reference::at_rest(1.0));
        assert!(
            (cycle.reference(FleetInstant(2_250_000)).angle_rad + 3.0).abs() < 1e-5,
            "φ₀ − A at half the period"
        );
    }

    #[test]
    fn is_as_precise_in_a_year_as_at_the_start() {
        let (early, late) = (cycle(0), cycle(31_557_600_000_000));
        for t_us in (0..2_000_000).step_by(777) {
            assert_eq!(
                early.reference(FleetInstant(t_us)),
                late.reference(FleetInstant(31_557_600_000_000 + t_us)),
                "{t_us} µs"
            );
        }
    }

    proptest! {
        #[test]
        fn takes_any_numbers(
            bits in any::<[u32; 3]>(), spans in any::<[u32; 2]>(), start in any::<u64>(), now in any::<u64>(),
        ) {
            let [centerline, amplitude, rotation] = bits.map(|b| Radians(f32::from_bits(b)));
            let [transition, period] = spans.map(Duration);
            let waveform = Waveform::new(centerline, amplitude, period);
            let law = TransitionLaw::RestToRest { ramp: period };
            let cycle = SwimCycle::new(1, FleetInstant(start), rotation, (transition, law), waveform);
            let _ = (cycle.reference(FleetInstant(now)), cycle.phase(FleetInstant(now)), cycle.end(), cycle.start_pose());
        }
    }
}
