use std::vec::Vec as List;

use proptest::prelude::*;

use super::*;

const LEASE: Duration = Duration(200_000);

fn lease() -> ThrustLease {
    ThrustLease::new(2, LeaseLimits::default())
}

/// Two thrusts that tell the cycle's number.
fn cycle(number: u32, start: u64) -> Cycle {
    with(number, start, &[number as f32, -(number as f32)], LEASE)
}

fn with(number: u32, start: u64, thrusts: &[f32], lease: Duration) -> Cycle {
    let thrusts = thrusts.iter().copied().map(Newtons).collect();
    let motion = Motion::Rov(RovCycle { thrusts, lease, connectors: Connectors::Closed });
    Cycle { number, start: FleetInstant(start), motion, delivery: Delivery::Direct }
}

fn refused(refusal: Refusal) -> Verdict {
    Verdict::Refused(refusal)
}

/// Number that the thrusts at `now` tell; nothing at neutral.
fn number(lease: &ThrustLease, now: u64) -> Option<u32> {
    let told = lease.thrusts(FleetInstant(now)).first().map(|thrust| thrust.0 as u32);
    assert_eq!(told, lease.running(FleetInstant(now)));
    told
}

#[test]
fn runs_from_its_start_to_the_end_of_its_lease_and_no_longer() {
    let mut lease = lease();
    assert_eq!(lease.offer(FleetInstant(0), &cycle(1, 50_000)), Verdict::Accepted);
    assert_eq!(number(&lease, 49_999), None);
    assert_eq!(number(&lease, 50_000), Some(1));
    assert_eq!(number(&lease, 249_999), Some(1));
    assert_eq!(number(&lease, 250_000), None);
    assert_eq!(number(&lease, u64::MAX), None);
    assert_eq!(lease.latest(FleetInstant(u64::MAX)), Some(1));
}

/// Connectors are open for as long as a lease says so: without one a docked robot stays docked.
#[test]
fn connectors_close_when_the_lease_ends() {
    let mut lease = lease();
    let Motion::Rov(motion) = with(1, 50_000, &[1.0, 1.0], LEASE).motion else { panic!("an ROV's") };
    let motion = Motion::Rov(RovCycle { connectors: Connectors::Open, ..motion });
    let open = Cycle { motion, ..cycle(1, 50_000) };
    assert_eq!(lease.offer(FleetInstant(0), &open), Verdict::Accepted);
    for (at, expected) in [
        (49_999, Connectors::Closed),
        (50_000, Connectors::Open),
        (249_999, Connectors::Open),
        (250_000, Connectors::Closed),
    ] {
        assert_eq!(lease.connectors(FleetInstant(at)), expected, "{at} µs");
    }
    // The next cycle closes them at its start, and a hold at once.
    assert_eq!(lease.offer(FleetInstant(60_000), &cycle(2, 100_000)), Verdict::Accepted);
    assert_eq!(lease.connectors(FleetInstant(99_999)), Connectors::Open);
    assert_eq!(lease.connectors(FleetInstant(100_000)), Connectors::Closed);
}

#[test]
fn the_newest_that_has_begun_is_executed() {
    let mut lease = lease();
    for k in 1..=4 {
        assert_eq!(lease.offer(FleetInstant(0), &cycle(k, u64::from(k) * 50_000)), Verdict::Accepted);
    }
    assert_eq!(lease.offer(FleetInstant(0), &cycle(5, 250_000)), refused(Refusal::Conflict), "no room");
    for k in 1..=4 {
        assert_eq!(number(&lease, u64::from(k) * 50_000), Some(k));
        assert_eq!(number(&lease, u64::from(k) * 50_000 + 49_999), Some(k));
    }
    // A short one ends neutral; the longer lease of the one before it is over with its turn.
    assert_eq!(
        lease.offer(FleetInstant(220_000), &with(5, 230_000, &[5.0, 0.0], Duration(10_000))),
        Verdict::Accepted
    );
    assert_eq!([number(&lease, 239_999), number(&lease, 240_000)], [Some(5), None]);
}

#[test]
fn what_is_late_runs_for_what_is_left_of_its_lease() {
    let mut lease = lease();
    assert_eq!(lease.offer(FleetInstant(100_000), &cycle(1, 0)), Verdict::Accepted);
    assert_eq!([number(&lease, 100_000), number(&lease, 200_000)], [Some(1), None]);
    assert_eq!(lease.offer(FleetInstant(300_000), &cycle(2, 100_000)), refused(Refusal::Late));
    // Out of order: 4 before 3, each in its time, 3 no more once 4 has begun.
    assert_eq!(lease.offer(FleetInstant(300_000), &cycle(4, 400_000)), Verdict::Accepted);
    assert_eq!(lease.offer(FleetInstant(300_000), &cycle(3, 350_000)), Verdict::Accepted);
    assert_eq!([number(&lease, 350_000), number(&lease, 400_000)], [Some(3), Some(4)]);
    assert_eq!(lease.offer(FleetInstant(400_000), &cycle(3, 350_000)), refused(Refusal::AlreadyRun));
}

#[test]
fn a_newer_cycle_takes_the_place_of_a_waiting_one() {
    let mut lease = lease();
    assert_eq!(lease.offer(FleetInstant(0), &cycle(1, 50_000)), Verdict::Accepted);
    assert_eq!(lease.offer(FleetInstant(0), &cycle(2, 50_000)), Verdict::Accepted);
    assert_eq!(number(&lease, 50_000), Some(2));
    assert_eq!(
        lease.offer(FleetInstant(0), &cycle(1, 50_000)),
        refused(Refusal::Conflict),
        "it would never run"
    );
}

#[test]
fn says_why_it_refuses() {
    let mut lease = lease();
    let now = FleetInstant(1_000);
    let mut verdict = |thrusts: &[f32], span| lease.offer(now, &with(1, 2_000, thrusts, Duration(span)));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 66.1, -66.1] {
        assert_eq!(verdict(&[0.0, bad], 1_000), refused(Refusal::BeyondLimits), "{bad} N");
    }
    assert_eq!(verdict(&[1.0], 1_000), refused(Refusal::BeyondLimits), "one thrust for two");
    assert_eq!(verdict(&[1.0; 3], 1_000), refused(Refusal::BeyondLimits), "three thrusts for two");
    assert_eq!(verdict(&[1.0; 2], 0), refused(Refusal::BeyondLimits), "no lease");
    assert_eq!(verdict(&[1.0; 2], 1_000_001), refused(Refusal::BeyondLimits), "too long a lease");
    let far = 1_001 + u64::from(HORIZON.0);
    assert_eq!(lease.offer(now, &cycle(1, far)), refused(Refusal::TooFarAhead));
    assert_eq!(lease.offer(now, &cycle(3, 2_000)), Verdict::Accepted);
    assert_eq!(lease.offer(now, &cycle(3, 2_001)), refused(Refusal::Conflict));
    assert_eq!(lease.offer(now, &cycle(3, 2_000)), Verdict::Duplicate);
    assert_eq!(lease.offer(FleetInstant(2_000), &cycle(3, 2_000)), Verdict::Duplicate);
    assert_eq!(lease.offer(FleetInstant(2_000), &cycle(2, 3_000)), refused(Refusal::AlreadyRun));
    let boat = protocol::ModboatCycle {
        rotation: protocol::units::Radians(0.0),
        centerline: protocol::units::Radians(0.0),
        amplitude: protocol::units::Radians(0.0),
        transition: Duration(0),
        period: Duration(1_000_000),
        law: protocol::TransitionLaw::ConstantSpeed,
    };
    let motion = Motion::Modboat(boat);
    let boat = Cycle { number: 9, start: FleetInstant(3_000), motion, delivery: Delivery::Direct };
    assert_eq!(lease.offer(now, &boat), refused(Refusal::WrongKind));
    let prepared = Cycle { delivery: Delivery::Prepare, ..cycle(9, 3_000) };
    assert_eq!(lease.offer(now, &prepared), refused(Refusal::WrongKind), "thrusts stand for themselves");
    assert_eq!(lease.commit(now, 9), refused(Refusal::NotPrepared));
}

#[test]
fn hold_is_neutral_and_a_stop_stays() {
    let mut lease = lease();
    lease.offer(FleetInstant(0), &cycle(1, 10_000));
    lease.offer(FleetInstant(0), &cycle(2, 60_000));
    lease.hold(FleetInstant(20_000));
    assert_eq!([number(&lease, 20_000), number(&lease, 60_000)], [None, None]);
    assert_eq!(lease.offer(FleetInstant(20_000), &cycle(1, 10_000)), refused(Refusal::AlreadyRun));
    assert_eq!(lease.offer(FleetInstant(20_000), &cycle(2, 60_000)), Verdict::Accepted, "it had not begun");
    lease.emergency_stop(FleetInstant(60_000));
    assert_eq!(number(&lease, 60_000), None);
    assert_eq!(lease.offer(FleetInstant(60_000), &cycle(3, 70_000)), refused(Refusal::Stopped));
    lease.start_new_epoch(FleetInstant(60_000));
    assert_eq!(lease.offer(FleetInstant(60_000), &cycle(1, 70_000)), refused(Refusal::Stopped));
    lease.release();
    assert_eq!(lease.offer(FleetInstant(60_000), &cycle(1, 70_000)), Verdict::Accepted);
    assert_eq!([number(&lease, 69_999), number(&lease, 70_000)], [None, Some(1)]);
}

proptest! {
    /// Against a list of all that was accepted: what has the greatest number among those begun, if its lease lasts.
    #[test]
    fn executes_what_the_list_says(
        offers in proptest::collection::vec((0_u64..40, 1_u32..30, 0_u64..60, 1_u32..40), 1..60),
    ) {
        let mut lease = lease();
        let mut accepted: List<(u32, u64, u32)> = List::new();
        let mut now = 0_u64;
        for (pause, k, ahead, span) in offers {
            now += pause;
            let start = (now + ahead).saturating_sub(20);
            let offered = with(k, start, &[k as f32, 0.0], Duration(span));
            if lease.offer(FleetInstant(now), &offered) == Verdict::Accepted {
                prop_assert!(start + u64::from(span) > now);
                accepted.push((k, start, span));
            }
            for then in now..now + 5 {
                let newest = accepted.iter().filter(|(_, start, _)| *start <= then).max_by_key(|(k, ..)| *k);
                let wanted = newest.filter(|(_, start, span)| then < start + u64::from(*span)).map(|(k, ..)| *k);
                prop_assert_eq!(lease.running(FleetInstant(then)), wanted, "at {} of {:?}", then, accepted);
            }
        }
    }
}
