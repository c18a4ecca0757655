//! Tails that do not follow: swapped leads, something in the way, weed, lost counts.

use protocol::time::Duration;

use super::*;
use crate::link::failsafe::Permission;
use crate::modboat::quadrature::TOLERANCE_PER_TURN;
use crate::plant::RigIndexed;

/// Within this a tail must be stopped: the time of the configuration and a tick.
const IN_TIME: u64 = 51 * MS;

/// Runs until it is stopped, at most for `most`; how long that took, in µs.
fn until_stopped<E: Encoder>(bench: &mut Bench<E>, most: u64) -> Option<u64> {
    let began = bench.now.0;
    while bench.now.0 < began + most {
        bench.run(bench.now.0 + MS);
        if bench.state() == ModuleState::Stopped {
            return Some(bench.now.0 - began);
        }
    }
    None
}

/// Braked, and told to the host.
fn assert_stopped<E: Encoder>(bench: &mut Bench<E>, fault: Faults) {
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, fault));
    assert_eq!(bench.boat.endpoint().failsafe().permission(), Permission::Brake);
    let said = bench.run(bench.now.0 + 25 * MS);
    assert!(bench.rig.drive() == 0.0 && bench.rig.is_shorted());
    assert!(said.iter().any(|m| matches!(m, Message::Telemetry(t) if t.faults == fault)), "{said:?}");
}

#[test]
fn swapped_leads_are_stopped_before_the_tail_has_turned_away() {
    for push_rad in [0.06, -0.06, 0.5] {
        let mut bench = Bench::boot(0.3);
        bench.rig.swap();
        bench.run(1_000 * MS);
        assert_eq!(bench.state(), ModuleState::Ready, "at rest there is nothing to see");
        // As a hand or a wave pushes it.
        bench.rig.turn(push_rad);
        // The jolt may take it past its place once, and the time runs again.
        let took = until_stopped(&mut bench, 1_000 * MS);
        assert!(took.is_some_and(|took| took <= 2 * IN_TIME), "{took:?}");
        assert_stopped(&mut bench, Faults::WRONG_WAY);
        bench.run(bench.now.0 + 500 * MS);
        let turned_rad = (bench.rig.angle_rad() - 0.3 - push_rad).abs();
        assert!(turned_rad < 1.0, "{turned_rad} rad");
    }
}

#[test]
fn swapped_leads_are_stopped_as_soon_as_it_swims() {
    let mut bench = Bench::boot(0.0);
    bench.rig.swap();
    bench.run(1_000 * MS);
    assert_eq!(bench.ask(&cycle(1, 1_200 * MS, 0.0, 2.0)), Verdict::Accepted);
    bench.run(1_200 * MS);
    let took = until_stopped(&mut bench, 500 * MS);
    assert!(took.is_some_and(|took| took <= 100 * MS), "{took:?}");
    assert_stopped(&mut bench, Faults::WRONG_WAY);
}

/// Blocked anywhere in a swing: the time runs from where the reference has left the tail behind.
#[test]
fn a_blocked_tail_is_stopped_wherever_it_is_held() {
    for at in [1_500, 1_600, 1_700, 1_875, 2_000, 2_250, 2_400, 2_900] {
        let mut bench = Bench::ready(0.0);
        assert_eq!(bench.ask(&cycle(1, 1_500 * MS, 0.0, 2.0)), Verdict::Accepted);
        bench.run(at * MS);
        bench.rig.block(true);
        let took = until_stopped(&mut bench, 1_000 * MS);
        // Near a turning point the reference itself stays for some time.
        assert!(took.is_some_and(|took| took <= IN_TIME + 40 * MS), "{took:?}, held at {at} ms");
        assert_stopped(&mut bench, Faults::STALLED);
    }
}

#[test]
fn weed_that_makes_the_tail_lag_stops_it() {
    let mut bench = Bench::ready(0.0);
    bench.rig.weed(0.65);
    assert_eq!(bench.ask(&cycle(1, 1_500 * MS, 0.0, 2.6)), Verdict::Accepted);
    bench.run(1_500 * MS);
    let mut worst_rad = 0.0_f64;
    while bench.state() != ModuleState::Stopped && bench.now.0 < 3_000 * MS {
        bench.run(bench.now.0 + MS);
        let reference = bench.boat.endpoint().reference(bench.now).unwrap();
        let error_rad = reference::wrap(reference.angle_rad - bench.rig.angle_rad() as f32);
        worst_rad = worst_rad.max(f64::from(error_rad).abs());
    }
    assert_stopped(&mut bench, Faults::FOLLOWING);
    assert!(worst_rad < 0.5, "behind by up to {worst_rad} rad");
}

/// Swims over its index, loses `lost` counts on the way, and goes on; whether it is stopped within two swings.
fn loses(lost: i64) -> Bench<RigIndexed> {
    let rig = Rig::new(0.3);
    rig.put_magnet(Some(-0.7));
    let endpoint = Endpoint::new(Some(identity(1)), ModboatRobot::new(TailLimits::default()));
    let boat = Modboat::new(endpoint, rig.indexed_tail(-0.7));
    let mut bench = Bench::on(rig, boat);
    // By hand, slowly over the magnet and back.
    for by_rad in [-0.001, 0.001] {
        for _ in 0..1_200 {
            bench.rig.turn(by_rad);
            bench.run(bench.now.0 + MS);
        }
    }
    bench.run(4_000 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    // It holds its pose at the index since it was homed. A turn away from there, and a swing over it.
    let from_rad = bench.rig.angle_rad() as f32;
    let motion = Motion::Modboat(ModboatCycle {
        rotation: Radians(0.8),
        centerline: Radians(from_rad + 0.8 - 1.2),
        amplitude: Radians(1.2),
        transition: Duration(500_000),
        period: Duration(1_500_000),
        law: protocol::TransitionLaw::RestToRest { ramp: Duration(50_000) },
    });
    let start = FleetInstant(4_200 * MS + AHEAD);
    let swims = Message::Cycle(Cycle { number: 1, start, motion, delivery: Delivery::Direct });
    assert_eq!(bench.ask(&swims), Verdict::Accepted);
    bench.run(4_700 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
    // One after the other: many at once are an error that the servo follows, or is stopped for.
    for _ in 0..lost.abs() {
        bench.rig.lose(lost.signum());
        bench.run(bench.now.0 + MS);
    }
    bench.run(6_220 * MS);
    bench
}

#[test]
fn lost_counts_are_noticed_at_the_index() {
    // 4800 counts a turn, and up to some ten between two ticks at this speed.
    for lost in [60, -60, 400, -160_i64] {
        let mut bench = loses(lost);
        assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::INDEX), "{lost} counts");
        assert!(!bench.boat.tail().is_homed());
        let said = bench.run(bench.now.0 + 25 * MS);
        let told = |m: &Message| matches!(m, Message::TailUnknown(t) if t.faults == Faults::INDEX);
        assert!(said.iter().any(told), "where it is is unknown: {said:?}");
        // Released, it is homed again before it swims.
        bench.say(&Message::Release);
        bench.run(bench.now.0 + 1_000 * MS);
        assert_eq!((bench.state(), bench.rig.drive()), (ModuleState::Boot, 0.0));
        // Once round by hand.
        for _ in 0..6_300 {
            bench.rig.turn(0.001);
            bench.run(bench.now.0 + MS);
        }
        bench.run(bench.now.0 + 500 * MS);
        assert_eq!((bench.state(), bench.faults()), (ModuleState::Ready, Faults(0)));
        let seen_rad = f64::from(bench.boat.tail().counter().pose().unwrap().0);
        let off_rad = (seen_rad - bench.rig.angle_rad()).rem_euclid(core::f64::consts::TAU);
        assert!(
            off_rad.min(core::f64::consts::TAU - off_rad) < 0.01,
            "{seen_rad} at {}",
            bench.rig.angle_rad()
        );
    }
}

#[test]
fn a_count_or_two_is_within_the_tolerance_of_the_index() {
    let tolerance = 4_800 / i64::from(TOLERANCE_PER_TURN);
    for lost in [0, tolerance, -tolerance] {
        let bench = loses(lost);
        assert_eq!((bench.state(), bench.faults()), (ModuleState::Holding, Faults(0)), "{lost} counts");
    }
}

/// What a servo is told of its bound, it keeps: a wider one, longer.
#[test]
fn the_bound_and_its_time_are_those_of_the_configuration() {
    let rig = Rig::new(0.0);
    let servo = protocol::configuration::ServoConstants {
        following_error_max: Radians(0.1),
        following_error_time: Duration(200_000),
        ..Default::default()
    };
    let endpoint = Endpoint::new(Some(identity(1)), ModboatRobot::new(TailLimits::default()));
    let mut bench = Bench::on(rig.clone(), Modboat::new(endpoint, rig.tail_of(&servo)));
    bench.run(1_000 * MS);
    bench.rig.block(true);
    bench.rig.turn(0.09);
    bench.run(3_000 * MS);
    assert_eq!(bench.state(), ModuleState::Ready, "within its bound");
    bench.rig.turn(0.02);
    let took = until_stopped(&mut bench, 1_000 * MS);
    assert_eq!(took, Some(201 * MS));
}

/// A whole turn at constant speed, which no servo follows at its ends.
#[test]
fn a_step_of_speed_is_no_following_error_where_the_cycle_asks_for_one() {
    let mut bench = Bench::ready(0.0);
    let motion = Motion::Modboat(ModboatCycle {
        rotation: Radians(core::f32::consts::TAU),
        centerline: Radians(-1.0),
        amplitude: Radians(1.0),
        transition: Duration(500_000),
        period: Duration(1_500_000),
        law: protocol::TransitionLaw::ConstantSpeed,
    });
    let start = FleetInstant(1_500 * MS + AHEAD);
    let swims = Message::Cycle(Cycle { number: 1, start, motion, delivery: Delivery::Direct });
    assert_eq!(bench.ask(&swims), Verdict::Accepted);
    bench.run(4_000 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Holding, Faults(0)));
    // Once it is over the usual bound is in force.
    bench.rig.block(true);
    bench.rig.turn(0.05);
    let took = until_stopped(&mut bench, 200 * MS);
    assert!(took.is_some_and(|took| took <= IN_TIME), "{took:?}");
}
