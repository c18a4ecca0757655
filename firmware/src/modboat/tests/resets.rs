//! Modules that the watchdog resets, whose encoder counts edges: when they keep their zero, and how a wrong one is found.

use super::homing::{MAGNET_RAD, NEAR_RAD};
use super::*;
use crate::modboat::homing::Homing;
use crate::modboat::kept_zero::REST_FOR;
use crate::plant::RigIndexed;

/// The loop hangs until the watchdog acts.
const HANGS: u64 = 10 * MS;

/// In reset and booting: the random numbers of a board may take that long.
const AWAY: u64 = 1_000 * MS;

/// What a drive that holds may turn the tail by while the loop hangs, and two counts.
const KEPT_RAD: f64 = 0.0144 + NEAR_RAD;

impl Bench<RigIndexed> {
    /// Homed by hand, in a session, and at rest for `rest`.
    fn rested(rest: u64) -> Self {
        let mut bench = Self::indexed(-1.2, Homing::by_hand());
        bench.run_while_booting(5_000 * MS, |bench| {
            if bench.rig.angle_rad() < -0.3 {
                bench.rig.turn(0.001);
            }
        });
        bench.run(bench.now.0 + 1_500 * MS);
        assert_eq!(bench.state(), ModuleState::Ready);
        let from_rad = bench.rig.angle_rad();
        let start = bench.now.0 + 200 * MS;
        assert_eq!(bench.ask(&cycle(1, start, from_rad, 1.0)), Verdict::Accepted);
        bench.run(start + 1_500 * MS + rest);
        bench
    }

    /// The loop hangs with its outputs as they are, and the board is reset and boots again; its host too, so that numbers begin again.
    fn reset(&mut self, by_watchdog: bool) {
        (0..HANGS / MS).for_each(|_| self.rig.step_ms());
        self.rig.reset(by_watchdog);
        (0..AWAY / MS).for_each(|_| self.rig.step_ms());
        let endpoint = Endpoint::new(Some(identity(2)), ModboatRobot::new(TailLimits::default()));
        let boat = Modboat::new(endpoint, self.rig.indexed_tail(MAGNET_RAD));
        *self = Self::on(self.rig.clone(), boat);
    }

    fn assert_goes_on(&mut self) {
        self.run(1_500 * MS);
        assert_eq!((self.state(), self.faults()), (ModuleState::Ready, Faults(0)));
        self.assert_knows_its_angle_within(KEPT_RAD);
    }

    /// Goes on to a tick whose drive leaves the tail where it is: a servo without friction never quite rests between two counts.
    fn until_calm(&mut self) {
        while self.rig.drive().abs() > 0.03 {
            self.run(self.now.0 + MS);
        }
    }

    fn assert_looks_for_its_zero(&mut self, why: &str) {
        assert!(self.run(1_500 * MS).is_empty(), "{why}");
        assert_eq!((self.state(), self.rig.drive()), (ModuleState::Boot, 0.0), "{why}");
        assert!(!self.boat.tail().is_homed(), "{why}");
    }
}

/// A quarter of a second longer than it must rest.
fn rested() -> Bench<RigIndexed> {
    Bench::rested(u64::from(REST_FOR.0) + 250 * MS)
}

#[test]
fn a_tail_that_rested_goes_on_with_its_zero_and_swims_over_its_index() {
    let mut bench = rested();
    bench.until_calm();
    bench.reset(true);
    bench.assert_goes_on();
    for number in 1..4 {
        let (from_rad, start) = (bench.rig.angle_rad(), bench.now.0 + 500 * MS);
        assert_eq!(bench.ask(&cycle(number, start, from_rad, 2.6)), Verdict::Accepted);
        bench.run(start + 1_600 * MS);
        assert_eq!((bench.state(), bench.faults()), (ModuleState::Holding, Faults(0)));
    }
    bench.assert_knows_its_angle_within(KEPT_RAD);
    // And again, from where it rests now.
    bench.run(bench.now.0 + 500 * MS);
    bench.reset(true);
    bench.assert_goes_on();
}

#[test]
fn whatever_the_drive_that_holds_it_the_zero_is_as_good_as_said() {
    for tick in 0..20 {
        let mut bench = Bench::rested(u64::from(REST_FOR.0) + (250 + tick) * MS);
        bench.reset(true);
        bench.assert_goes_on();
    }
}

#[test]
fn a_wrong_count_is_found_at_the_next_pass_of_the_index() {
    let mut bench = rested();
    // A hand turns it in the meantime: by more than a hanging loop and than the index may be off, 0.009 rad.
    bench.rig.turn(0.05);
    bench.reset(true);
    bench.run(1_500 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Ready, Faults(0)), "nothing can tell yet");
    let from_rad = bench.rig.angle_rad() - 0.05;
    let start = bench.now.0 + 500 * MS;
    assert_eq!(bench.ask(&cycle(1, start, from_rad, 2.0)), Verdict::Accepted);
    // From -0.3 rad by a cosine to the index at -0.7 rad: |A|·(1 − cos) = 0.4 after 0.15 s.
    bench.run(start + 200 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::INDEX));
    bench.say(&Message::Release);
    bench.run(bench.now.0 + 1_000 * MS);
    assert_eq!(bench.state(), ModuleState::Boot, "its zero is to be found");
    // Stopped or looking for its zero it keeps nothing.
    bench.reset(true);
    bench.assert_looks_for_its_zero("a wrong count");
}

#[test]
fn what_is_no_record_of_a_rest_before_the_watchdogs_reset_is_refused() {
    let mut bench = rested();
    bench.reset(false);
    bench.assert_looks_for_its_zero("a power-on");

    let mut bench = rested();
    bench.rig.retained(|words| words[1] ^= 1);
    bench.reset(true);
    bench.assert_looks_for_its_zero("a damaged record");

    let mut bench = Bench::rested(u64::from(REST_FOR.0) - 50 * MS);
    bench.reset(true);
    bench.assert_looks_for_its_zero("a tail that has hardly come to rest");

    let mut bench = rested();
    let (from_rad, start) = (bench.rig.angle_rad(), bench.now.0 + 500 * MS);
    assert_eq!(bench.ask(&cycle(2, start, from_rad, 1.0)), Verdict::Accepted);
    bench.run(start + 400 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
    bench.reset(true);
    bench.assert_looks_for_its_zero("a tail in mid-swing");

    let mut bench = rested();
    bench.say(&Message::EmergencyStop);
    bench.run(bench.now.0 + 1_000 * MS);
    bench.reset(true);
    bench.assert_looks_for_its_zero("a stopped module, which would come back without its stop");

    let mut bench = rested();
    // Off the magnet, which is over 0.63 rad.
    bench.rig.turn(0.5);
    bench.reset(true);
    bench.assert_looks_for_its_zero("an index that was on");

    let mut bench = rested();
    bench.reset(true);
    bench.run(100 * MS);
    bench.reset(true);
    bench.assert_looks_for_its_zero("a board that is reset over and over");
}

/// A loop that hangs in the tick that begins to turn the tail: its drive stays on until the watchdog acts.
#[test]
fn nothing_is_kept_from_the_first_tick_of_a_cycle_on() {
    let mut bench = rested();
    let (from_rad, start) = (bench.rig.angle_rad(), bench.now.0 + 500 * MS);
    assert_eq!(bench.ask(&cycle(2, start, from_rad, 0.9)), Verdict::Accepted);
    bench.run(start);
    assert_ne!(bench.rig.retained(|_| ()), [0; 4], "kept up to the start");
    bench.run(start + MS);
    assert_eq!(bench.rig.retained(|_| ()), [0; 4]);
}

/// A push makes it drive, so it rests no more: not even in the tick that feels it (the rig checks that of every drive).
#[test]
fn a_push_ends_the_rest() {
    let mut bench = rested();
    bench.rig.turn(0.015);
    bench.run(bench.now.0 + 2 * MS);
    assert_eq!(bench.rig.retained(|_| ()), [0; 4]);
    bench.run(bench.now.0 + 100 * MS);
    bench.reset(true);
    bench.assert_looks_for_its_zero("a tail that was pushed just now");
}
