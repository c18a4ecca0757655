use std::vec::Vec;

use proptest::prelude::*;

use super::*;

fn exchange(t1: u64, t2: u64, t3: u64, t4: u64) -> Exchange {
    Exchange {
        request_sent: LocalInstant(t1),
        request_received: FleetInstant(t2),
        reply_sent: FleetInstant(t3),
        reply_received: LocalInstant(t4),
    }
}

/// Offset of the fleet clock to begin with, µs.
const AHEAD: i64 = 1_000_000;

/// Fleet time at `local` if the fleet clock runs `drift_ppm` faster.
fn fleet_of(local: u64, drift_ppm: i64) -> u64 {
    let local = i64::try_from(local).unwrap();
    u64::try_from(local + AHEAD + local * drift_ppm / 1_000_000).unwrap()
}

/// An exchange begun at `local`, with these delays there and back.
fn over(local: u64, there: u64, back: u64, drift_ppm: i64) -> Exchange {
    let t2 = fleet_of(local + there, drift_ppm);
    exchange(local, t2, t2, local + there + back)
}

/// Some exchanges from `from` to `until`, one every 50 ms, 1 ms each way and up to 0.9 ms more.
fn follow(clock: &mut FleetClock, from: u64, until: u64, drift_ppm: i64, busy: bool) {
    for k in from / 50_000..until / 50_000 {
        let (there, back) = (1000 + k * 7919 % 901, 1000 + k * 6007 % 907);
        assert!(clock.add(&over(k * 50_000, there, back, drift_ppm), busy), "exchange {k}");
    }
}

fn error(clock: &FleetClock, local: u64, drift_ppm: i64) -> u64 {
    clock.fleet(LocalInstant(local)).unwrap().0.abs_diff(fleet_of(local, drift_ppm))
}

fn unsure(clock: &FleetClock, local: u64) -> u32 {
    clock.uncertainty(LocalInstant(local)).unwrap().0
}

#[test]
fn hand_worked_exchange() {
    let mut clock = FleetClock::new();
    assert_eq!(clock.fleet(LocalInstant(5)), None);
    assert_eq!(clock.uncertainty(LocalInstant(5)), None);
    assert_eq!(clock.hard_bound(LocalInstant(5)), None);
    // Offset 1 000 000, 300 µs there, 500 µs back, 50 µs at the host: half of 200 µs is what it cannot see.
    assert!(clock.add(&exchange(10_000, 1_010_300, 1_010_350, 10_850), false));
    assert_eq!(clock.fleet(LocalInstant(10_850)), Some(FleetInstant(1_010_750)));
    assert_eq!(clock.local(FleetInstant(1_010_750)), Some(LocalInstant(10_850)));
    // Half of the delay of 800 µs, and two for the roundings; 300 µs more a second later, rounded down.
    assert_eq!(clock.uncertainty(LocalInstant(10_850)), Some(Duration(402)));
    assert_eq!(clock.hard_bound(LocalInstant(1_010_850)), Some(Duration(701)));
    assert!(!clock.is_synchronised() && !clock.is_sure(LocalInstant(10_850), Duration(1000)));
    assert_eq!(clock.exchange_pause(LocalInstant(10_850), Duration(1000)), PAUSE_LEARNING);
}

#[test]
fn leaves_out_what_cannot_be() {
    let mut clock = FleetClock::new();
    for (what, bad) in [
        ("reply before request", exchange(100, 1000, 1000, 99)),
        ("the host sent before it received", exchange(0, 1000, 999, 500)),
        ("the host took longer than the exchange", exchange(0, 1000, 1501, 500)),
        ("two seconds of delay", exchange(0, 1000, 1000, 2_000_000)),
        ("out of range", exchange(0, u64::MAX, u64::MAX, 500)),
    ] {
        assert!(!clock.add(&bad, false), "{what}");
    }
    assert!(clock.add(&exchange(5000, 5000, 5000, 5010), false));
    assert!(!clock.add(&exchange(1000, 1000, 1000, 1010), false), "older than the last");
    assert!(!clock.add(&exchange(5000, 5000, 5000, 5020), false), "the same once more");
    assert_eq!(clock.fleet(LocalInstant(6000)), Some(FleetInstant(5995)));
}

#[test]
fn learns_the_drift_and_goes_on_alone() {
    for drift_ppm in [-100, 0, 40, 100] {
        let mut clock = FleetClock::new();
        follow(&mut clock, 0, 60_000_000, drift_ppm, false);
        let learnt_ppm = f64::from(clock.drift_ppb()) * 1e-3;
        assert!((learnt_ppm - drift_ppm as f64).abs() < 3.0, "{learnt_ppm} for {drift_ppm}");
        assert!(clock.is_sure(LocalInstant(60_000_000), Duration(500)));
        assert_eq!(clock.exchange_pause(LocalInstant(60_000_000), Duration(1000)), Duration(1_000_000));
        let mut before = unsure(&clock, 60_000_000);
        for local in [61_000_000, 70_000_000, 120_000_000, 600_000_000] {
            let after = unsure(&clock, local);
            assert!(after > before && error(&clock, local, drift_ppm) <= u64::from(after), "at {local}");
            before = after;
        }
        assert!(!clock.is_sure(LocalInstant(600_000_000), Duration(1000)));
        // Ten minutes later one exchange does not say much, but the drift is still known.
        follow(&mut clock, 600_000_000, 601_000_000, drift_ppm, false);
        assert!((f64::from(clock.drift_ppb()) * 1e-3 - drift_ppm as f64).abs() < 5.0);
    }
}

#[test]
fn steps_when_idle_and_slews_while_a_cycle_runs() {
    let mut busy = FleetClock::new();
    // Delay 9 ms, all of it on the way there: 4.5 ms wrong.
    for k in 0..5 {
        busy.add(&over(k * 50_000, 9_000, 0, 0), false);
    }
    let mut idle = busy.clone();
    let now = 300_000;
    assert_eq!(error(&busy, now, 0), 4_500);
    let good = over(now - 200, 100, 100, 0);
    assert!(idle.add(&good, false) && busy.add(&good, true));
    // The replies took no time and the last request 100 µs: half of that is wrong now.
    assert_eq!((error(&idle, now, 0), error(&busy, now, 0)), (50, 4_500));
    assert!((4_450..4_700).contains(&unsure(&busy, now)) && unsure(&idle, now) < 150);
    // 500 ppm: 1 ms in 2 s, once the drift is taken out.
    let drifted = i64::from(busy.drift_ppb()) / 500_000;
    assert!((error(&busy, now + 2_000_000, 0) as i64 - drifted - 3_500).abs() <= 1);
    assert!(busy.add(&over(now + 1_000_000, 100, 100, 0), false));
    assert!(error(&busy, now + 1_000_200, 0) <= 50, "no cycle runs any more");
}

#[test]
fn restarts_when_a_clock_jumped() {
    // Farther than the delay allows; nearer, but far beyond what the exchanges leave open.
    for jump in [-500_000_i64, 500_000, 20_000] {
        let mut clock = FleetClock::new();
        for k in 0..200_u64 {
            let queue = 15_000 + k * 7919 % 1009;
            assert!(clock.add(&over(k * 50_000, queue, queue, 20), false));
        }
        let now = 10_000_000_u64;
        assert!(clock.is_synchronised() && unsure(&clock, now) < 1_000);
        // Behind by the jump from now on.
        let told = clock.fleet(LocalInstant(now + 30_000)).unwrap();
        let Exchange { request_sent, request_received, reply_received, .. } = over(now, 15_000, 15_000, 20);
        let moved = request_received.0.checked_add_signed(jump).unwrap();
        assert!(clock.add(&exchange(request_sent.0, moved, moved, reply_received.0), true));
        assert!(!clock.is_synchronised() && unsure(&clock, now + 30_000) > 15_000, "{jump}");
        assert_eq!(clock.fleet(LocalInstant(now + 30_000)), Some(told), "a cycle runs");
        assert!(clock.add(&exchange(now + 50_000, moved + 50_000, moved + 50_000, now + 80_000), false));
        let told = clock.fleet(LocalInstant(now + 65_000)).unwrap().0;
        assert!(told.abs_diff(moved + 50_000) <= 30, "{told}");
    }
}

#[test]
fn a_disturbance_counts_until_new_exchanges_say_better() {
    let mut clock = FleetClock::new();
    follow(&mut clock, 0, 30_000_000, 50, false);
    let (now, by) = (30_000_000, Duration(3_000));
    let (before, hard) = (unsure(&clock, now), clock.hard_bound(LocalInstant(now)).unwrap().0);
    // A request that was under way.
    let early = over(now - 1_000, 1_000, 1_000, 50);
    clock.disturbed(LocalInstant(now), by);
    assert!(!clock.add(&early, false));
    assert_eq!(clock.hard_bound(LocalInstant(now)), Some(Duration(hard + by.0)));
    assert!(unsure(&clock, now) > before.max(2_900) && clock.is_synchronised());
    // It did jump.
    let jumped = |local: u64| fleet_of(local, 50) - 2_500;
    for k in 1..400_u64 {
        let (t1, queue) = (now + k * 50_000, 1000 + k * 7919 % 901);
        let t2 = jumped(t1 + queue);
        assert!(clock.add(&exchange(t1, t2, t2, t1 + 2 * queue), false));
        let told = clock.fleet(LocalInstant(t1 + 2 * queue)).unwrap().0;
        let wrong = told.abs_diff(jumped(t1 + 2 * queue));
        assert!(wrong <= u64::from(unsure(&clock, t1 + 2 * queue)), "exchange {k}: {wrong}");
    }
    assert!(clock.is_sure(LocalInstant(now + 20_000_000), Duration(700)));
    clock.reset();
    assert!(clock.fleet(LocalInstant(now)).is_none() && !clock.is_synchronised());
}

#[test]
fn is_small() {
    assert!(size_of::<FleetClock>() <= 1024, "{}", size_of::<FleetClock>());
}

proptest! {
    /// Unequal delays and up to 280 ppm of drift: never beyond the hard bound.
    #[test]
    fn error_is_within_the_hard_bound(
        drift_ppm in -280_i64..280,
        ways in proptest::collection::vec((0_u64..20_000, 0_u64..20_000, 1_u64..2_000_000), 1..60),
    ) {
        let mut clock = FleetClock::new();
        let mut local = 2_000_000_000_u64;
        for (there, back, pause) in ways {
            let now = local + there + back;
            prop_assert!(clock.add(&over(local, there, back, drift_ppm), false));
            for at in [now, now + pause] {
                let hard = clock.hard_bound(LocalInstant(at)).unwrap();
                prop_assert!(error(&clock, at, drift_ppm) <= u64::from(hard.0) + 2);
                prop_assert!(clock.uncertainty(LocalInstant(at)).unwrap() <= hard);
                let back_again = clock.local(clock.fleet(LocalInstant(at)).unwrap()).unwrap();
                prop_assert!(back_again.0.abs_diff(at) <= 1);
            }
            local = now + pause;
        }
    }

    /// While a cycle runs time neither goes back nor jumps, whatever the exchanges say, even another clock.
    #[test]
    fn no_step_while_busy(
        drift_ppm in -280_i64..280,
        ways in proptest::collection::vec((0_u64..20_000, 0_u64..20_000, 1_u64..400_000, 0_u64..50), 2..40),
    ) {
        let mut clock = FleetClock::new();
        let mut local = 2_000_000_000_u64;
        prop_assert!(clock.add(&over(local, 10_000, 10_000, drift_ppm), false));
        for (there, back, pause, jump) in ways {
            let begun = local + 20_000;
            let told: Vec<u64> = (0..=10).map(|k| clock.fleet(LocalInstant(begun + pause * k / 10)).unwrap().0).collect();
            for pair in told.windows(2) {
                prop_assert!(pair[1] >= pair[0]);
                let steady = (pause as f64 * 0.1) * (1.0 + f64::from(clock.drift_ppb()) * 1e-9);
                // 500 ppm, a rounding of the output and one of the tenth of the pause at each end.
                prop_assert!(((pair[1] - pair[0]) as f64 - steady).abs() <= steady * 501e-6 + 3.0);
            }
            let mut other = over(begun + pause, there, back, drift_ppm);
            if jump == 0 {
                (other.request_received.0, other.reply_sent.0) = (3_000_000_000, 3_000_000_000);
            }
            let at = other.reply_received;
            let before = clock.fleet(at).unwrap();
            prop_assert!(clock.add(&other, true));
            prop_assert_eq!(clock.fleet(at).unwrap(), before);
            for later in 0..50 {
                prop_assert!(clock.fleet(LocalInstant(at.0 + later)) <= clock.fleet(LocalInstant(at.0 + later + 1)));
            }
            local = at.0;
        }
    }

    #[test]
    fn takes_any_numbers(
        times in proptest::collection::vec((any::<[u64; 4]>(), any::<bool>()), 1..20),
        local in any::<u64>(),
        by in any::<u32>(),
    ) {
        let mut clock = FleetClock::new();
        for ([t1, t2, t3, t4], busy) in times {
            clock.add(&exchange(t1, t2, t3, t4), busy);
            // Times that can be, anywhere.
            let (t1, t2) = (t1 >> 1, t2 >> 1);
            clock.add(&exchange(t1, t2, t2 + t3 % 1000, t1 + 1000 + t4 % 1_000_000), busy);
            for local in [local, t1, u64::MAX].map(LocalInstant) {
                let _ = (clock.fleet(local), clock.local(FleetInstant(local.0)), clock.uncertainty(local), clock.hard_bound(local));
                let pause = clock.exchange_pause(local, Duration(by));
                prop_assert!((50_000..=1_000_000).contains(&pause.0));
            }
            if busy {
                clock.disturbed(LocalInstant(t1), Duration(by));
            }
        }
    }
}
