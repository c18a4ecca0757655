use super::*;
use crate::modboat::waveform::Waveform;
use proptest::prelude::*;
use std::vec::Vec;

const T: Duration = Duration(1_500_000);
const T_TRANS: Duration = Duration(500_000);

/// Cycle that ends at φ₀ + A and sets out from φ₀ + A − rotation.
fn cycle(number: u32, start: u64, centerline: f32, amplitude: f32, rotation: f32) -> SwimCycle {
    let waveform = Waveform::new(Radians(centerline), Radians(amplitude), T);
    SwimCycle::new(
        number,
        FleetInstant(start),
        Radians(rotation),
        (T_TRANS, protocol::TransitionLaw::ConstantSpeed),
        waveform,
    )
}

fn schedule() -> Schedule {
    Schedule::new(TailLimits::default(), Radians(0.0))
}

fn refused(verdict: Verdict) -> Refusal {
    match verdict {
        Verdict::Refused(refusal) => refusal,
        other => panic!("expected a refusal, got {other:?}"),
    }
}

#[test]
fn begins_each_cycle_at_its_start_and_holds_when_none_follows() {
    let mut schedule = schedule();
    assert_eq!(schedule.reference(FleetInstant(0)), Reference::at_rest(0.0));
    let (first, second) = (cycle(1, 1_000_000, 0.5, 1.0, 1.5), cycle(2, 3_000_000, 2.5, -1.0, 0.0));
    assert_eq!(schedule.offer(FleetInstant(0), first, Delivery::Direct), Verdict::Accepted);
    assert_eq!(schedule.running(FleetInstant(999_999)), None);
    assert_eq!(schedule.waiting(FleetInstant(999_999)).map(SwimCycle::number), Some(1));
    assert_eq!(schedule.reference(FleetInstant(999_999)), Reference::at_rest(0.0));
    assert_eq!(schedule.running(FleetInstant(1_000_000)), Some(1));
    assert_eq!(schedule.offer(FleetInstant(1_200_000), second, Delivery::Direct), Verdict::Accepted);
    assert_eq!(schedule.running(FleetInstant(2_999_999)), Some(1));
    assert_eq!(schedule.reference(FleetInstant(2_999_999)), first.reference(FleetInstant(2_999_999)));
    assert_eq!(schedule.running(FleetInstant(3_000_000)), Some(2));
    assert_eq!(schedule.reference(FleetInstant(4_000_000)), second.reference(FleetInstant(4_000_000)));
    assert_eq!(schedule.running(FleetInstant(5_000_000)), None);
    assert_eq!(schedule.reference(FleetInstant(u64::MAX)), Reference::at_rest(1.5));
    assert_eq!(schedule.pose_at_end(), Radians(1.5));
}

#[test]
fn says_why_it_refuses() {
    let mut schedule = schedule();
    let now = FleetInstant(20_000_000);
    assert_eq!(
        refused(schedule.offer(now, cycle(5, 19_999_000, 1.0, -1.0, 0.0), Delivery::Direct)),
        Refusal::Late { by: Duration(1000) }
    );
    assert_eq!(
        refused(schedule.offer(now, cycle(5, 30_000_007, 1.0, -1.0, 0.0), Delivery::Direct)),
        Refusal::TooFarAhead { by: Duration(7) }
    );
    assert!(matches!(
        refused(schedule.offer(now, cycle(5, 20_000_000, 1.0, 3.0, 0.0), Delivery::Direct)),
        Refusal::Limit(Violation::Amplitude(_))
    ));
    assert!(matches!(
        refused(schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.03, 0.0), Delivery::Direct)),
        Refusal::PoseMismatch { expected: Radians(0.0), offered } if (offered.0 + 0.03).abs() < 1e-6
    ));
    assert_eq!(
        schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.0, 0.0), Delivery::Direct),
        Verdict::Accepted
    );
    let now = FleetInstant(20_000_001);
    assert_eq!(
        schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.0, 0.0), Delivery::Direct),
        Verdict::Duplicate
    );
    assert_eq!(
        refused(schedule.offer(now, cycle(5, 23_000_000, 1.0, -1.0, 0.0), Delivery::Direct)),
        Refusal::Conflict
    );
    assert_eq!(
        refused(schedule.offer(now, cycle(4, 23_000_000, 1.0, -1.0, 0.0), Delivery::Direct)),
        Refusal::AlreadyRun { latest: 5 }
    );
    assert_eq!(
        refused(schedule.offer(now, cycle(6, 21_999_000, 1.0, -1.0, 0.0), Delivery::Direct)),
        Refusal::Overlap { by: Duration(1000) }
    );
    assert_eq!(
        schedule.offer(now, cycle(6, 22_000_000, 1.0, -1.0, 0.0), Delivery::Direct),
        Verdict::Accepted
    );
    assert_eq!(
        refused(schedule.offer(now, cycle(7, 24_000_000, 1.0, -1.0, 0.0), Delivery::Direct)),
        Refusal::Full { held: 6 }
    );
    // The running one and the waiting one are both recognised.
    assert_eq!(
        schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.0, 0.0), Delivery::Direct),
        Verdict::Duplicate
    );
    assert_eq!(
        schedule.offer(now, cycle(6, 22_000_000, 1.0, -1.0, 0.0), Delivery::Direct),
        Verdict::Duplicate
    );
}

#[test]
fn poses_are_compared_on_the_circle() {
    let mut schedule = Schedule::new(TailLimits::default(), Radians(3.135));
    // Sets out from −3.135 rad: 0.0132 rad away across the seam.
    assert_eq!(
        schedule.offer(FleetInstant(0), cycle(1, 0, -4.135, 1.0, 0.0), Delivery::Direct),
        Verdict::Accepted
    );
}

#[test]
fn a_hold_finishes_what_runs_and_frees_the_number_of_what_waits() {
    let mut schedule = schedule();
    let running = cycle(1, 0, 1.0, -1.0, 0.0);
    assert_eq!(schedule.offer(FleetInstant(0), running, Delivery::Direct), Verdict::Accepted);
    assert_eq!(
        schedule.offer(FleetInstant(10), cycle(2, 2_000_000, 1.0, -1.0, 0.0), Delivery::Direct),
        Verdict::Accepted
    );
    schedule.hold(FleetInstant(1_000_000));
    assert_eq!(schedule.reference(FleetInstant(1_500_000)), running.reference(FleetInstant(1_500_000)));
    assert_eq!(schedule.running(FleetInstant(2_500_000)), None);
    assert_eq!(schedule.reference(FleetInstant(2_500_000)), Reference::at_rest(0.0));
    assert_eq!(
        schedule.offer(FleetInstant(2_500_000), cycle(2, 3_000_000, -1.0, 1.0, 0.0), Delivery::Direct),
        Verdict::Accepted
    );
}

#[test]
fn an_emergency_stop_freezes_at_once_and_keeps_everything_out() {
    let mut schedule = schedule();
    let running = cycle(3, 0, 1.0, -1.0, 0.0);
    assert_eq!(schedule.offer(FleetInstant(0), running, Delivery::Direct), Verdict::Accepted);
    let now = FleetInstant(1_000_000);
    let frozen = Reference::at_rest(running.reference(now).angle_rad);
    assert!(frozen.angle_rad > 0.4, "the test stops it in mid swing");
    schedule.emergency_stop(now);
    assert!(schedule.is_stopped());
    assert_eq!(schedule.reference(FleetInstant(1_000_001)), frozen);
    assert_eq!(schedule.running(FleetInstant(1_000_001)), None);
    schedule.emergency_stop(FleetInstant(1_100_000));
    assert_eq!(schedule.reference(FleetInstant(5_000_000)), frozen);
    assert_eq!(
        refused(schedule.offer(
            FleetInstant(5_000_000),
            cycle(4, 6_000_000, 1.0, -1.0, 0.0),
            Delivery::Direct
        )),
        Refusal::Stopped
    );
    schedule.resume(Radians(0.6));
    assert_eq!(schedule.reference(FleetInstant(5_000_000)), Reference::at_rest(0.6));
    assert_eq!(
        refused(schedule.offer(
            FleetInstant(5_000_000),
            cycle(3, 6_000_000, 1.6, -1.0, 0.0),
            Delivery::Direct
        )),
        Refusal::AlreadyRun { latest: 3 }
    );
    assert_eq!(
        schedule.offer(FleetInstant(5_000_000), cycle(4, 6_000_000, 1.6, -1.0, 0.0), Delivery::Direct),
        Verdict::Accepted
    );
}

#[test]
fn a_prepared_cycle_runs_once_it_is_committed_and_not_before() {
    let mut schedule = schedule();
    let offered = cycle(1, 1_000_000, 1.0, -1.0, 0.0);
    assert_eq!(schedule.offer(FleetInstant(0), offered, Delivery::Prepare), Verdict::Prepared);
    assert_eq!(schedule.offer(FleetInstant(1), offered, Delivery::Prepare), Verdict::Prepared, "again");
    assert!(schedule.is_uncommitted(FleetInstant(2)));
    assert_eq!(schedule.pose_at_end(), Radians(0.0), "it is not sure to run");
    let mut forgotten = schedule.clone();
    assert_eq!(schedule.commit(FleetInstant(500_000), 1), Verdict::Accepted);
    assert_eq!(schedule.commit(FleetInstant(500_001), 1), Verdict::Duplicate);
    assert_eq!(schedule.offer(FleetInstant(500_002), offered, Delivery::Prepare), Verdict::Duplicate);
    assert!(!schedule.is_uncommitted(FleetInstant(500_003)));
    assert_eq!(schedule.running(FleetInstant(1_000_000)), Some(1));
    assert_eq!(schedule.commit(FleetInstant(1_200_000), 1), Verdict::Duplicate, "while it runs");
    assert_eq!(schedule.commit(FleetInstant(9_000_000), 1), Verdict::Duplicate, "and after");
    // Without one the tail holds, and the number is free.
    assert_eq!(forgotten.running(FleetInstant(1_000_000)), None);
    assert_eq!(forgotten.reference(FleetInstant(1_500_000)), Reference::at_rest(0.0));
    assert_eq!(refused(forgotten.commit(FleetInstant(1_000_000), 1)), Refusal::NotPrepared, "late");
    assert_eq!(forgotten.reference(FleetInstant(1_500_000)), Reference::at_rest(0.0));
    assert_eq!(
        forgotten.offer(FleetInstant(1_000_001), cycle(1, 3_000_000, 1.0, -1.0, 0.0), Delivery::Prepare),
        Verdict::Prepared
    );
}

#[test]
fn a_prepared_cycle_gives_way_to_a_greater_number_and_a_direct_one_does_not() {
    let mut schedule = schedule();
    let offer = |schedule: &mut Schedule, number, start, delivery| {
        schedule.offer(FleetInstant(0), cycle(number, start, 1.0, -1.0, 0.0), delivery)
    };
    assert_eq!(offer(&mut schedule, 3, 1_000_000, Delivery::Prepare), Verdict::Prepared);
    assert_eq!(refused(offer(&mut schedule, 2, 1_000_000, Delivery::Direct)), Refusal::Full { held: 3 });
    assert_eq!(refused(offer(&mut schedule, 3, 1_000_001, Delivery::Prepare)), Refusal::Conflict);
    assert_eq!(offer(&mut schedule, 4, 1_500_000, Delivery::Prepare), Verdict::Prepared);
    assert_eq!(refused(schedule.commit(FleetInstant(0), 3)), Refusal::NotPrepared, "it is gone");
    assert_eq!(schedule.commit(FleetInstant(0), 4), Verdict::Accepted);
    assert_eq!(refused(offer(&mut schedule, 5, 1_500_000, Delivery::Prepare)), Refusal::Full { held: 4 });
    assert_eq!([1_499_999, 1_500_000].map(|at| schedule.running(FleetInstant(at))), [None, Some(4)]);
    let mut schedule = self::schedule();
    assert_eq!(offer(&mut schedule, 1, 1_000_000, Delivery::Direct), Verdict::Accepted);
    assert_eq!(refused(offer(&mut schedule, 2, 1_000_000, Delivery::Prepare)), Refusal::Full { held: 1 });
    assert_eq!(schedule.commit(FleetInstant(0), 1), Verdict::Duplicate, "it needs none");
}

#[test]
fn a_hold_and_a_stop_drop_what_is_prepared() {
    for stops in [false, true] {
        let mut schedule = schedule();
        let offered = cycle(1, 1_000_000, 1.0, -1.0, 0.0);
        assert_eq!(schedule.offer(FleetInstant(0), offered, Delivery::Prepare), Verdict::Prepared);
        if stops {
            schedule.emergency_stop(FleetInstant(1));
        } else {
            schedule.hold(FleetInstant(1));
        }
        let expected = if stops { Refusal::Stopped } else { Refusal::NotPrepared };
        assert_eq!(refused(schedule.commit(FleetInstant(2), 1)), expected);
        schedule.resume(Radians(0.0));
        assert_eq!(refused(schedule.commit(FleetInstant(2), 1)), Refusal::NotPrepared);
        assert_eq!(schedule.running(FleetInstant(1_000_000)), None);
    }
}

/// Arguments of a plausible cycle: its number and start relative to what went before, and its motion.
fn steps() -> impl Strategy<Value = Vec<(u32, u32, f32, f32, f32, u8)>> {
    let step = (0_u32..3, 0_u32..2_500_000, -3.0_f32..3.0, 0.9_f32..2.6, -6.0_f32..6.0, 0_u8..12);
    proptest::collection::vec(step, 1..40)
}

proptest! {
    /// A host that follows the module's pose: whatever it offers, held or stopped in between, the reference
    /// never steps faster than the speed limit allows, no cycle runs outside its time, and what is
    /// offered twice changes nothing.
    #[test]
    fn reference_is_continuous_and_punctual(steps in steps()) {
        const TICK_US: u64 = 1000;
        let mut schedule = schedule();
        let (mut now, mut number) = (0_u64, 0_u32);
        let mut accepted: Vec<SwimCycle> = Vec::new();
        let mut last = schedule.reference(FleetInstant(now));
        // What the tolerance let through of the last accepted cycle.
        let mut apart_rad = 0.0;
        for (advance, wait, centerline, amplitude, rotation, event) in steps {
            number += advance;
            // Sets out from where the tail will be.
            let start_rad = schedule.pose_at_end().0;
            let amplitude = if event % 2 == 0 { amplitude } else { -amplitude };
            let centerline = if event == 0 { centerline } else { start_rad + rotation - amplitude };
            let start = now + u64::from(wait);
            let offered = cycle(number, start, centerline, amplitude, rotation);
            let verdict = schedule.offer(FleetInstant(now), offered, Delivery::Direct);
            prop_assert!(verdict == Verdict::Accepted || event == 0 || !accepted.is_empty());
            if verdict == Verdict::Accepted {
                accepted.push(offered);
                apart_rad = wrap(offered.start_pose().0 - start_rad).abs();
                prop_assert!(apart_rad <= POSE_TOLERANCE.0 && (event == 0 || apart_rad < 1e-5));
                let before = schedule.clone();
                prop_assert_eq!(schedule.offer(FleetInstant(now), offered, Delivery::Direct), Verdict::Duplicate);
                prop_assert_eq!(schedule.reference(FleetInstant(start + 1)), before.reference(FleetInstant(start + 1)));
            }
            for _ in 0..1200 {
                now += TICK_US;
                let at = schedule.reference(FleetInstant(now));
                let step_rad = wrap(at.angle_rad - last.angle_rad).abs();
                prop_assert!(step_rad <= 13.0 * 1e-3 + 1e-4 + apart_rad, "{step_rad} rad in one tick at {now} µs");
                last = at;
                if let Some(running) = schedule.running(FleetInstant(now)) {
                    let it = accepted.iter().rfind(|c| c.number() == running).unwrap();
                    prop_assert!(it.start() <= FleetInstant(now) && FleetInstant(now) < it.end());
                }
            }
            match event {
                10 => schedule.hold(FleetInstant(now)),
                11 => {
                    schedule.emergency_stop(FleetInstant(now));
                    last = schedule.reference(FleetInstant(now));
                    schedule.resume(Radians(last.angle_rad));
                }
                _ => {}
            }
        }
    }

    #[test]
    fn takes_any_numbers(
        offers in proptest::collection::vec(any::<([u32; 3], [u32; 3], u64, u64, u8)>(), 1..20),
    ) {
        let mut schedule = Schedule::new(TailLimits::default(), Radians(f32::NAN));
        for (bits, [number, t_trans, period], start, now, event) in offers {
            let [c, a, r] = bits.map(|b| Radians(f32::from_bits(b)));
            let waveform = Waveform::new(c, a, Duration(period));
            let offered = SwimCycle::new(number, FleetInstant(start), r, (Duration(t_trans), protocol::TransitionLaw::ConstantSpeed), waveform);
            schedule.offer(FleetInstant(now), offered, Delivery::Direct);
            match event % 8 {
                0 => schedule.hold(FleetInstant(now)),
                1 => schedule.emergency_stop(FleetInstant(now)),
                2 => schedule.resume(c),
                _ => {}
            }
            prop_assert!(schedule.reference(FleetInstant(now)).is_finite());
            let _ = (schedule.running(FleetInstant(now)), schedule.waiting(FleetInstant(now)), schedule.pose_at_end());
        }
    }
}
