//! Modules whose encoder counts edges: how they find their zero, and what they do before.

use core::f64::consts::TAU;

use protocol::configuration::ServoConstants;
use protocol::time::Duration;
use protocol::units::RadiansPerSecond;

use super::*;
use crate::modboat::homing::TURNS;
use crate::plant::RigIndexed;

/// Where the magnet begins, counter-clockwise.
pub(super) const MAGNET_RAD: f64 = -0.7;
/// Two edges of the encoder.
pub(super) const NEAR_RAD: f64 = 2.0 * TAU / 4_800.0;

const SPEED_RAD_S: f64 = 0.9;
/// Of 18 rad/s.
const DRIVE: f64 = 0.05;
const AFTER: u64 = 2_000 * MS;

impl Bench<RigIndexed> {
    pub(super) fn indexed(angle_rad: f64, homing: Homing) -> Self {
        Self::indexed_as(Some(identity(1)), angle_rad, homing)
    }

    fn indexed_as(identity: Option<crate::link::session::Identity>, angle_rad: f64, homing: Homing) -> Self {
        let rig = Rig::new(angle_rad);
        rig.put_magnet(Some(MAGNET_RAD));
        let endpoint = Endpoint::new(identity, ModboatRobot::new(TailLimits::default()));
        let boat = Modboat::new(endpoint, rig.indexed_tail(MAGNET_RAD)).with_homing(homing);
        Self::on(rig, boat)
    }

    /// By itself, and no stronger than it should.
    fn homing(angle_rad: f64) -> Self {
        let mut bench = Self::indexed(angle_rad, by_itself(AFTER));
        bench.search_drive = DRIVE + 0.001;
        bench
    }

    /// One millisecond after another until it is not in state Boot any more.
    pub(super) fn run_while_booting(&mut self, end: u64, mut each: impl FnMut(&mut Self)) {
        while self.state() == ModuleState::Boot {
            assert!(self.now.0 < end, "still looking at {} rad", self.rig.angle_rad());
            each(self);
            let said = self.run(self.now.0 + MS);
            assert!(said.is_empty() || self.state() != ModuleState::Boot, "{said:?}");
        }
    }

    /// It waits, turns counter-clockwise and gives up, from now on.
    fn searches_in_vain(&mut self) {
        let (began, from) = (self.now.0, self.rig.angle_rad());
        assert!(self.run(began + AFTER).is_empty(), "it has nothing to say yet");
        assert_eq!((self.rig.angle_rad(), self.rig.drive()), (from, 0.0), "it waits");
        let turns = f64::from(TURNS);
        let turning = (turns * TAU / SPEED_RAD_S * 1e6) as u64;
        assert!(self.run(began + AFTER + turning - 10 * MS).is_empty());
        assert_eq!(self.state(), ModuleState::Boot);
        assert!((self.rig.drive() - DRIVE).abs() < 0.001, "it turns: {}", self.rig.drive());
        let said = self.run(began + AFTER + turning + 400 * MS);
        assert_eq!((self.state(), self.faults()), (ModuleState::Stopped, Faults::BLIND));
        assert!(said.iter().any(|message| matches!(message, Message::Hello(_))), "it can be called");
        assert_eq!(self.rig.drive(), 0.0);
        let turned = (self.rig.angle_rad() - from) / TAU;
        assert!((turned - turns).abs() < 0.01, "{turned} turns");
    }

    /// Whether the tail knows its own angle.
    fn assert_knows_its_angle(&self) {
        self.assert_knows_its_angle_within(NEAR_RAD);
    }

    /// The same to so much.
    pub(super) fn assert_knows_its_angle_within(&self, near_rad: f64) {
        let known_rad = f64::from(self.boat.tail().counter().pose().unwrap().0);
        let off_rad = (known_rad - self.rig.angle_rad() + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        assert!(off_rad.abs() <= near_rad, "{known_rad} for {}", self.rig.angle_rad());
    }
}

fn by_itself(after: u64) -> Homing {
    let after = Duration(u32::try_from(after).unwrap());
    Homing::new(RadiansPerSecond(SPEED_RAD_S as f32), after, ServoConstants::default().no_load_speed)
}

/// From the magnet's edge to `angle_rad`, within half a turn.
fn beyond_magnet(angle_rad: f64) -> f64 {
    (angle_rad - MAGNET_RAD + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}

#[test]
fn before_it_knows_its_zero_it_says_and_drives_nothing() {
    let mut bench = Bench::indexed(2.0, Homing::by_hand());
    assert!(bench.run(5_000 * MS).is_empty());
    assert_eq!(bench.state(), ModuleState::Boot);
    // Over the magnet, but faster than its place can be told: 6 rad/s, three turns.
    for _ in 0..3_142 {
        bench.rig.turn(0.006);
        assert!(bench.run(bench.now.0 + MS).is_empty());
    }
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Boot, Faults(0)));
    assert_eq!(bench.rig.drive(), 0.0);
}

#[test]
fn turned_by_hand_over_the_magnet_it_holds_the_pose_it_has() {
    // Either way round, at 1 rad/s.
    for by_rad in [0.001, -0.001] {
        let mut bench = Bench::indexed(2.0, Homing::by_hand());
        bench.host.tells_time = false;
        // The hand does not stop at once.
        let mut beyond = 0;
        bench.run_while_booting(8_000 * MS, |bench| {
            beyond += u32::from(bench.boat.tail().is_homed());
            if beyond <= 400 {
                bench.rig.turn(by_rad);
            }
        });
        assert_eq!(bench.state(), ModuleState::Unsynchronised);
        let found_rad = bench.rig.angle_rad();
        assert!((beyond_magnet(found_rad).abs() - 0.4).abs() <= NEAR_RAD, "found at {found_rad}");
        let said = bench.run(bench.now.0 + 1_000 * MS);
        assert_eq!((bench.state(), bench.faults()), (ModuleState::Unsynchronised, Faults(0)));
        assert!((bench.rig.angle_rad() - found_rad).abs() < 0.01, "it stays: {}", bench.rig.angle_rad());
        bench.assert_knows_its_angle();
        let told = said.iter().rev().find_map(|message| match message {
            Message::Telemetry(telemetry) => Some(f64::from(telemetry.tail.0)),
            _ => None,
        });
        let off_rad = (told.unwrap() - bench.rig.angle_rad()).rem_euclid(TAU);
        assert!(off_rad.min(TAU - off_rad) <= NEAR_RAD, "it says {told:?}");
        // Pushed, it comes back: it holds, and does not just lie there.
        for _ in 0..100 {
            bench.rig.turn(0.002);
            bench.run(bench.now.0 + MS);
        }
        assert!(bench.rig.drive() < 0.0, "{}", bench.rig.drive());
        bench.run(bench.now.0 + 1_000 * MS);
        assert!((bench.rig.angle_rad() - found_rad).abs() < 0.01, "{}", bench.rig.angle_rad());
        bench.host.tells_time = true;
        bench.run(bench.now.0 + 1_000 * MS);
        assert_eq!(bench.state(), ModuleState::Ready);
    }
}

#[test]
fn with_a_speed_it_waits_and_turns_to_its_zero() {
    // Some way before the magnet, just before it, on it, and just past its beginning: nearly a whole turn.
    for before_rad in [2.0, 0.1, TAU - 0.3, TAU - 0.01] {
        let mut bench = Bench::homing(MAGNET_RAD - before_rad);
        assert!(bench.run(AFTER).is_empty());
        assert_eq!((bench.state(), bench.rig.drive()), (ModuleState::Boot, 0.0), "it waits");
        let turn = (TAU / SPEED_RAD_S * 1e6) as u64;
        bench.run_while_booting(AFTER + turn + 100 * MS, |bench| {
            let (turning, drive) = (bench.now.0 > AFTER, bench.rig.drive());
            assert_eq!(turning, (drive - DRIVE).abs() < 0.001, "{drive} at {:?}", bench.now);
        });
        let found_rad = bench.rig.angle_rad();
        assert!((found_rad - MAGNET_RAD).abs() <= NEAR_RAD, "{before_rad} rad before: {found_rad}");
        bench.run(bench.now.0 + 1_500 * MS);
        assert_eq!((bench.state(), bench.faults()), (ModuleState::Ready, Faults(0)));
        assert!((bench.rig.angle_rad() - found_rad).abs() < 0.01, "it stays: {}", bench.rig.angle_rad());
        bench.assert_knows_its_angle();
        // And it swims from there.
        let pose_rad = bench.rig.angle_rad();
        assert_eq!(bench.ask(&cycle(1, bench.now.0 + 500 * MS, pose_rad, 1.0)), Verdict::Accepted);
        bench.run(bench.now.0 + 600 * MS);
        assert_eq!(bench.state(), ModuleState::Executing);
    }
}

#[test]
fn without_an_index_it_gives_up_until_it_is_released() {
    let mut bench = Bench::homing(0.4);
    bench.rig.put_magnet(None);
    bench.searches_in_vain();
    bench.run(bench.now.0 + 10_000 * MS);
    assert_eq!((bench.state(), bench.rig.drive()), (ModuleState::Stopped, 0.0), "it does not try again");
    bench.say(&Message::Release);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Boot, Faults(0)));
    bench.searches_in_vain();
    // The magnet is glued on.
    bench.rig.put_magnet(Some(MAGNET_RAD));
    bench.say(&Message::Release);
    bench.run_while_booting(bench.now.0 + 12_000 * MS, |_| ());
    assert!(beyond_magnet(bench.rig.angle_rad()).abs() <= NEAR_RAD, "{}", bench.rig.angle_rad());
    bench.run(bench.now.0 + 1_500 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Ready, Faults(0)));
    bench.assert_knows_its_angle();
}

#[test]
fn stopped_while_it_searches_it_coasts_and_waits_again_when_released() {
    let mut bench = Bench::homing(0.4);
    bench.rig.put_magnet(None);
    bench.searches_in_vain();
    // Only now it has a host that could stop it.
    bench.say(&Message::Release);
    bench.run(bench.now.0 + AFTER + 1_000 * MS);
    assert!(bench.rig.drive() > 0.0);
    bench.say(&Message::EmergencyStop);
    bench.run(bench.now.0 + MS);
    assert_eq!((bench.state(), bench.rig.drive()), (ModuleState::Stopped, 0.0));
    bench.run(bench.now.0 + 30_000 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::EMERGENCY));
    bench.say(&Message::Release);
    bench.searches_in_vain();
}

#[test]
fn unconfigured_it_never_searches() {
    // No waiting: it would turn in its first tick.
    let mut bench = Bench::indexed_as(None, 0.4, by_itself(0));
    let step = |bench: &mut Bench<RigIndexed>| {
        bench.boat.tick(bench.now, &FULL).unwrap();
        assert_eq!(bench.rig.drive(), 0.0, "at {:?}", bench.now);
        assert_eq!(bench.boat.poll_transmit(&mut [0; protocol::MAX_DATAGRAM]), None);
        bench.rig.step_ms();
        bench.now.0 += MS;
    };
    (0..5_000).for_each(|_| step(&mut bench));
    // Not when the tail is turned over the magnet by hand either.
    for _ in 0..10_000 {
        bench.rig.turn(0.001);
        step(&mut bench);
    }
    assert!(bench.boat.tail().is_homed());
    assert_eq!(bench.state(), ModuleState::Unprovisioned);
}
