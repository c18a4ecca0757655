//! Boards that find their zero, and boards on which something goes wrong: what the module does, and how soon.
//!
//! Everything is in lock step, so times are those of the module's own clock to a step, 1 ms.

use link::dispatcher::DispatcherEvent;
use link::identity::HostIdentity;
use protocol::configuration::ServoConstants;
use protocol::session::seal_stop;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;
use protocol::{Faults, MAX_DATAGRAM, ModboatCycle, ModuleId, ModuleState, Motion, Refusal, TransitionLaw};
use qemu::bench::Bench;
use qemu::modules::Board;
use qemu::report::Report;
use qemu::storm::forged_calls;

const SEED: u64 = 11;
const MS: u64 = 1_000;
const SECOND: u64 = 1_000_000;

/// When it goes wrong, by the module's own clock, which is the bench's to a few milliseconds.
const WRONG: u64 = 12 * SECOND;

/// Between the clocks of the bench and the module, and a report's way.
const SLACK: u64 = 8 * MS;

/// One that counts and has an index, for which it looks by itself; its zero is 0.7 rad beyond the magnet.
const INDEXED: &str =
    "counts_per_turn = 4800\nzero_counts = 7301\nhoming_speed_rad_s = 0.9\nhoming_after_s = 0.5";

/// A turn, if there is one, and a swing, from where the tail is and back to where it turned.
fn swing(from_rad: f32, rotation_rad: f32, amplitude_rad: f32) -> Motion {
    let turns = rotation_rad != 0.0;
    Motion::Modboat(ModboatCycle {
        rotation: Radians(rotation_rad),
        centerline: Radians(from_rad + rotation_rad - amplitude_rad),
        amplitude: Radians(amplitude_rad),
        transition: Duration(if turns { 500_000 } else { 0 }),
        period: Duration(1_500_000),
        law: if turns {
            TransitionLaw::RestToRest { ramp: Duration(50_000) }
        } else {
            TransitionLaw::ConstantSpeed
        },
    })
}

/// Where its tail is, by its last report.
fn tail_rad(bench: &Bench) -> f32 {
    bench.dispatcher.modules()[0].telemetry().expect("a report").tail.0
}

/// The same angle in −π to π.
fn wrapped(angle_rad: f32) -> f32 {
    (angle_rad + core::f32::consts::PI).rem_euclid(core::f32::consts::TAU) - core::f32::consts::PI
}

/// Runs to that time.
fn run_to(bench: &mut Bench, end: u64) -> Vec<DispatcherEvent> {
    let mut events = Vec::new();
    while bench.now().0 < end {
        events.extend(bench.turn());
    }
    events
}

/// Swims from before it goes wrong on: a cycle begins 100 ms before. The number of the last cycle.
fn swim_until_wrong(bench: &mut Bench, rotation_rad: f32) -> u32 {
    bench.until_ready();
    let from_rad = tail_rad(bench);
    let turn = if rotation_rad == 0.0 { 0 } else { 500 * MS };
    let begins = WRONG - 100 * MS - turn;
    assert!(bench.now().0 + 700 * MS < begins - 1_500 * MS, "ready at {:?} only", bench.now());
    bench.dispatch(1, FleetInstant(begins - 1_500 * MS), &[swing(from_rad, 0.0, 1.0)]);
    run_to(bench, begins - 700 * MS);
    bench.dispatch(2, FleetInstant(begins), &[swing(from_rad, rotation_rad, 1.2)]);
    run_to(bench, WRONG - 50 * MS);
    assert_eq!(bench.dispatcher.modules()[0].state(), Some(ModuleState::Executing));
    2
}

/// Goes on until the module prints its next report: in step with its host, which hears all that it says.
fn next_report(bench: &mut Bench) -> Report {
    let before = bench.modules.module(0).emulator.reports().len();
    loop {
        bench.turn();
        if let Some(report) = bench.modules.module(0).emulator.reports().get(before) {
            return report.clone();
        }
    }
}

/// When the first report of a stop came, and with which fault; then it is braked and drives nothing, whatever comes.
fn stopped(bench: &mut Bench, by: u64) -> (u64, Faults) {
    let is_stopped = |bench: &Bench| bench.dispatcher.modules()[0].state() == Some(ModuleState::Stopped);
    while !is_stopped(bench) {
        bench.turn();
        assert!(bench.now().0 < by, "it goes on at {:?}:\n{}", bench.now(), bench.modules.lines());
    }
    let (at, faults) = (bench.now().0, bench.dispatcher.modules()[0].faults());
    for _ in 0..2 {
        let report = next_report(bench);
        let pins = (report.state(), report.number("braked"), report.number("drive"), report.number("faults"));
        assert_eq!(pins, ("Stopped", 1, 0, u64::from(faults.0)));
    }
    (at, faults)
}

fn following_time() -> u64 {
    u64::from(ServoConstants::default().following_error_time.0)
}

#[test]
fn a_blocked_tail_is_stopped_in_time() {
    let mut bench = Bench::start_on(1, SEED, Board { words: &["block", "12000"], ..Board::default() });
    swim_until_wrong(&mut bench, 0.0);
    let (at, faults) = stopped(&mut bench, WRONG + SECOND);
    println!("blocked: stopped {} ms later", (at - WRONG) / MS);
    assert_eq!(faults, Faults::STALLED);
    // 10 ms until the swing has left the tail behind.
    assert!(at <= WRONG + 10 * MS + following_time() + SLACK, "{at}");
}

#[test]
fn swapped_leads_are_stopped_in_time() {
    let mut bench = Bench::start_on(1, SEED, Board { words: &["swap", "12000"], ..Board::default() });
    swim_until_wrong(&mut bench, 0.0);
    let (at, faults) = stopped(&mut bench, WRONG + SECOND);
    println!("leads swapped: stopped {} ms later", (at - WRONG) / MS);
    assert_eq!(faults, Faults::WRONG_WAY);
    assert!(at <= WRONG + 10 * MS + following_time() + SLACK, "{at}");
}

#[test]
fn lost_edges_are_stopped_at_the_next_pass_of_the_index() {
    let board = Board { words: &["lose", "12000"], encoder: Some(INDEXED) };
    let mut bench = Bench::start_on(1, SEED, board);
    // It was found at its index; from 0.8 rad beyond, a swing passes that twice.
    swim_until_wrong(&mut bench, 0.8);
    let (at, faults) = stopped(&mut bench, WRONG + 2 * SECOND);
    println!("edges lost: stopped {} ms later", (at - WRONG) / MS);
    assert_eq!(faults, Faults::INDEX);
    assert!(at <= WRONG + 1_500 * MS + SLACK, "{at}");
}

#[test]
fn a_board_that_counts_finds_its_zero_and_swims() {
    let mut bench = Bench::start_on(1, SEED, Board { encoder: Some(INDEXED), ..Board::default() });
    bench.until_ready();
    // The magnet begins at -0.7 rad, which the tail says with its zero there.
    let found_rad = tail_rad(&bench);
    assert!(wrapped(found_rad + 0.7).abs() < 0.01, "found at {found_rad} rad");
    let start = bench.now().after(Duration(800_000));
    bench.dispatch(1, start, &[swing(found_rad, 0.0, 1.2)]);
    run_to(&mut bench, start.0 + 750 * MS);
    assert!((tail_rad(&bench) - found_rad + 2.4).abs() < 0.05, "half way: {}", tail_rad(&bench));
    run_to(&mut bench, start.0 + 1_600 * MS);
    let link = &bench.dispatcher.modules()[0];
    assert_eq!((link.state(), link.faults()), (Some(ModuleState::Holding), Faults(0)));
    // The widest swings, with a turn before each, over the index at full speed.
    for number in 2..8 {
        let (from_rad, start) = (tail_rad(&bench), bench.now().after(Duration(800_000)));
        let amplitude_rad = if number % 2 == 0 { 2.6 } else { -2.6 };
        bench.dispatch(number, start, &[swing(from_rad, 2.0, amplitude_rad)]);
        run_to(&mut bench, start.0 + 2_100 * MS);
        let link = &bench.dispatcher.modules()[0];
        assert_eq!((link.state(), link.faults()), (Some(ModuleState::Holding), Faults(0)), "cycle {number}");
    }
}

/// A board with an index whose control loop hangs at [`WRONG`], at rest off its index or in mid-swing, until its watchdog resets it and it
/// announces itself again: how long that took, without the time for which it stood still.
fn restarts(words: &'static [&'static str], at_rest: bool) -> (Bench, u64) {
    let mut bench = Bench::start_on(1, SEED, Board { words, encoder: Some(INDEXED) });
    bench.until_ready();
    let from_rad = tail_rad(&bench);
    // 2 s, and it has rested for half a second; or half a second of its swing.
    let begins = WRONG - if at_rest { 2_500 } else { 1_000 } * MS;
    assert!(bench.now().0 + 500 * MS < begins, "ready at {:?} only", bench.now());
    bench.dispatch(1, FleetInstant(begins), &[swing(from_rad, 0.8, 1.2)]);
    run_to(&mut bench, WRONG - 100 * MS);
    let state = if at_rest { ModuleState::Holding } else { ModuleState::Executing };
    assert_eq!(bench.dispatcher.modules()[0].state(), Some(state));
    let boot = bench.announced;
    bench.until("another boot", |bench, _| bench.announced != boot);
    let took = bench.now().0 - WRONG;
    bench.until("it to be ready", |bench, _| {
        bench.dispatcher.modules()[0].state() == Some(ModuleState::Ready)
    });
    bench.until_ready();
    println!("at rest: {at_rest}; announced {} ms after the reset", took / MS);
    (bench, took)
}

/// A module that looks for its zero says nothing, and waits for half a second first.
const LOOKS: u64 = 500 * MS;

#[test]
fn a_board_that_its_watchdog_resets_at_rest_keeps_its_zero() {
    let (mut bench, took) = restarts(&["hang", "12000"], true);
    assert!(took < LOOKS, "{} ms", took / MS);
    // 0.8 rad beyond the magnet, which begins at -0.7 rad.
    let rests_rad = tail_rad(&bench);
    let off_rad = wrapped(rests_rad - 0.1);
    assert!(off_rad.abs() < 0.015, "it takes itself to be at {rests_rad} rad");
    // Over the index, at full speed and back.
    let start = bench.now().after(Duration(800_000));
    bench.dispatch(2, start, &[swing(rests_rad, 2.0, 2.6)]);
    run_to(&mut bench, start.0 + 2_100 * MS);
    let link = &bench.dispatcher.modules()[0];
    assert_eq!((link.state(), link.faults()), (Some(ModuleState::Holding), Faults(0)));
}

#[test]
fn a_tail_that_was_turned_meanwhile_is_found_out_at_its_index() {
    let (mut bench, took) = restarts(&["hang", "12000", "turned", "50"], true);
    assert!(took < LOOKS, "{} ms", took / MS);
    let start = bench.now().after(Duration(800_000));
    bench.dispatch(2, start, &[swing(tail_rad(&bench), 0.0, 1.2)]);
    let (at, faults) = stopped(&mut bench, start.0 + SECOND);
    println!("turned by 0.05 rad: stopped {} ms after the swing began", (at - start.0) / MS);
    assert_eq!(faults, Faults::INDEX);
}

#[test]
fn a_board_that_its_watchdog_resets_in_mid_swing_looks_for_its_zero() {
    let (mut bench, took) = restarts(&["hang", "12000"], false);
    assert!(took > LOOKS, "{} ms", took / MS);
    let off_rad = wrapped(tail_rad(&bench) + 0.7);
    assert!(off_rad.abs() < 0.01, "found at {} rad", tail_rad(&bench));
    assert_eq!(next_report(&mut bench).number("faults"), 0);
}

#[test]
fn a_low_battery_ends_the_cycle_and_refuses_the_next() {
    let mut bench = Bench::start_on(1, SEED, Board { words: &["sag", "9600"], ..Board::default() });
    // Two seconds of hold-off: low from 11.6 s on, in the cycle that begins at 11.9.
    swim_until_wrong(&mut bench, 0.0);
    let link = &bench.dispatcher.modules()[0];
    assert_eq!((link.state(), link.faults()), (Some(ModuleState::Executing), Faults::LOW_BATTERY));
    let end = WRONG + 1_400 * MS;
    bench.dispatch(3, FleetInstant(end), &[swing(0.0, 0.0, 1.0)]);
    let events = run_to(&mut bench, end + 100 * MS);
    let refused = DispatcherEvent::Refused { module: 0, cycle: 3, reason: Refusal::LowBattery };
    assert!(events.contains(&refused), "{events:?}");
    assert_eq!(
        bench.dispatcher.modules()[0].state(),
        Some(ModuleState::Holding),
        "the cycle was run to its end"
    );
    // It recovers 4 s after it sagged, with the same hold-off.
    run_to(&mut bench, 9_600 * MS + 6_200 * MS);
    let start = bench.now().after(Duration(700_000));
    bench.dispatch(4, start, &[swing(tail_rad(&bench), 0.0, 1.0)]);
    run_to(&mut bench, start.0 + 100 * MS);
    let link = &bench.dispatcher.modules()[0];
    assert_eq!((link.state(), link.faults()), (Some(ModuleState::Executing), Faults(0)));
}

/// A hundred thousand calls under right checksums, at a module that swims for its host; then a stop of another host, in mid-cycle.
#[test]
fn forged_calls_delay_nothing_and_a_stop_of_any_host_stops_it() {
    const CALLS: usize = 100_000;
    const EACH_STEP: usize = 5;
    let host = HostIdentity::simulated(SEED, 0);
    let mut bench = Bench::start(1, SEED);
    bench.until_ready();
    let before = next_report(&mut bench);
    let mut calls = forged_calls(&host, ModuleId(1), SEED).take(CALLS).peekable();
    let (mut number, mut next, mut accepted) = (0, FleetInstant(0), 0);
    while calls.peek().is_some() {
        for call in calls.by_ref().take(EACH_STEP) {
            bench.modules.disturb(0, &call);
        }
        let events = bench.turn();
        accepted += events.iter().filter(|event| matches!(event, DispatcherEvent::Accepted { .. })).count();
        if bench.now() > next {
            number += 1;
            let start = bench.now().after(Duration(500_000));
            next = start.after(Duration(1_100_000));
            bench.dispatch(number, start, &[swing(0.0, 0.0, 1.2)]);
        }
    }
    let after = next_report(&mut bench);
    let during = |name: &str| after.number(name) - before.number(name);
    println!(
        "{CALLS} forged calls in {} ticks: {} came, {} cycles taken",
        during("tick"),
        during("foreign"),
        accepted
    );
    assert_eq!((during("missed"), during("stalled"), during("forged")), (0, 0, 0), "{after:?}");
    assert!(during("foreign") >= CALLS as u64 * 9 / 10, "{after:?}");
    assert!(accepted as u32 + 1 >= number && number >= 5, "{accepted} of {number}");

    bench.until("a cycle", |bench, _| bench.dispatcher.modules()[0].state() == Some(ModuleState::Executing));
    // The second host has the key, and hears the module's announcements.
    let (id, boot) = (ModuleId(1), bench.announced.expect("it announces itself"));
    let mut buffer = [0; MAX_DATAGRAM];
    let stop =
        seal_stop(host.key.fleet(), id, &host.key.module(id), boot, &mut buffer).expect("fits").to_vec();
    let said = bench.now().0;
    bench.modules.disturb(0, &stop);
    let (at, faults) = stopped(&mut bench, said + SECOND);
    println!("stopped by another host {} ms later", (at - said) / MS);
    assert_eq!(faults, Faults::EMERGENCY);
    assert!(at <= said + 5 * MS, "{} ms", (at - said) / MS);
    bench.modules.disturb(0, &stop);
    bench.dispatcher.release(bench.now());
    bench.until("a release", |bench, _| bench.dispatcher.modules()[0].state() == Some(ModuleState::Ready));
    bench.modules.disturb(0, &stop);
    let later = bench.now().0 + 200 * MS;
    run_to(&mut bench, later);
    assert_eq!(bench.dispatcher.modules()[0].state(), Some(ModuleState::Ready), "a stop that was used up");
}
