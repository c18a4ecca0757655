#![expect(clippy::float_cmp, reason = "a drive of zero is exact")]

use std::vec::Vec;

use protocol::configuration::TailLimits;
use protocol::time::FleetInstant;
use protocol::units::{Radians, Volts};
use protocol::{Cycle, Delivery, Faults, Message, ModboatCycle, ModuleState, Motion, Refusal, Verdict};

use super::*;
use crate::bench_host::{AHEAD, BenchHost, identity};
use crate::link::failsafe::BLIND_FOR;
use crate::modboat::servo::NoSense;
use crate::plant::{Rig, RigEncoder, RigPin, RigPwm};

mod homing;
mod resets;
mod supervision;

const MS: u64 = 1_000;
const FULL: Supply = Supply { battery: Volts(7.4), current: Amperes(0.0) };

/// A whole Modboat on the rig, and its host.
struct Bench<E = RigEncoder> {
    rig: Rig,
    boat: Modboat<E, NoSense, RigPwm, RigPin, RigPin>,
    host: BenchHost,
    now: LocalInstant,
    supply: Supply,
    /// Greatest drive while it may not hold or swim.
    search_drive: f64,
}

impl Bench {
    fn boot(angle_rad: f64) -> Self {
        let rig = Rig::new(angle_rad);
        let endpoint = Endpoint::new(Some(identity(1)), ModboatRobot::new(TailLimits::default()));
        let boat = Modboat::new(endpoint, rig.tail());
        Self::on(rig, boat)
    }

    /// In a session and synchronised, at 1 s of its own clock.
    fn ready(angle_rad: f64) -> Self {
        let mut bench = Self::boot(angle_rad);
        bench.run(1_000 * MS);
        assert_eq!(bench.state(), ModuleState::Ready);
        bench
    }
}

impl<E: Encoder> Bench<E> {
    fn on(rig: Rig, boat: Modboat<E, NoSense, RigPwm, RigPin, RigPin>) -> Self {
        Self { rig, boat, host: BenchHost::new(1), now: LocalInstant(0), supply: FULL, search_drive: 0.0 }
    }

    fn run(&mut self, end: u64) -> Vec<Message> {
        let mut said = Vec::new();
        while self.now.0 < end {
            let may_drive = self.boat.endpoint().failsafe().may_drive();
            self.boat.tick(self.now, &self.supply).unwrap();
            assert!(may_drive || (0.0..=self.search_drive).contains(&self.rig.drive()), "at {:?}", self.now);
            said.extend(self.host.listen(self.now, &mut self.boat));
            self.rig.step_ms();
            self.now.0 += MS;
        }
        said
    }

    fn state(&self) -> ModuleState {
        self.boat.endpoint().state(self.now)
    }

    fn faults(&self) -> Faults {
        self.boat.endpoint().failsafe().faults()
    }

    fn ask(&mut self, message: &Message) -> Verdict {
        self.host.ask(self.now, &mut self.boat, message)
    }

    fn say(&mut self, message: &Message) {
        self.host.say(self.now, &mut self.boat, message);
    }
}

/// One that sets out from `from` and comes back to it, without a transition.
fn cycle(number: u32, start: u64, from: f64, amplitude: f32) -> Message {
    let motion = Motion::Modboat(ModboatCycle {
        rotation: Radians(0.0),
        centerline: Radians(from as f32 - amplitude),
        amplitude: Radians(amplitude),
        transition: Duration(0),
        period: Duration(1_500_000),
        law: protocol::TransitionLaw::ConstantSpeed,
    });
    Message::Cycle(Cycle { number, start: FleetInstant(start + AHEAD), motion, delivery: Delivery::Direct })
}

#[test]
fn swims_and_rests_where_it_set_out() {
    let mut bench = Bench::ready(0.4);
    assert_eq!(bench.ask(&cycle(1, 1_500 * MS, 0.4, 2.0)), Verdict::Accepted);
    bench.run(2_250 * MS);
    assert!((bench.rig.angle_rad() + 3.6).abs() < 0.1, "half way: {}", bench.rig.angle_rad());
    bench.run(3_200 * MS);
    assert!((bench.rig.angle_rad() - 0.4).abs() < 0.02, "{}", bench.rig.angle_rad());
    assert_eq!(bench.state(), ModuleState::Holding);
}

#[test]
fn a_stalled_motor_stops_until_released() {
    let mut bench = Bench::ready(0.0);
    assert_eq!(bench.ask(&cycle(1, 1_500 * MS, 0.0, 2.0)), Verdict::Accepted);
    assert_eq!(bench.ask(&Message::Commit(1)), Verdict::Duplicate);
    bench.run(1_700 * MS);
    bench.rig.block(true);
    bench.run(2_700 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::STALLED));
    for _ in 0..1000 {
        bench.run(bench.now.0 + MS);
        assert_eq!(bench.rig.drive(), 0.0, "it is braked");
    }
    let from = bench.rig.angle_rad();
    assert_eq!(bench.ask(&cycle(2, 4_000 * MS, from, 1.0)), Verdict::Refused(Refusal::Stopped));
    // What held it is gone, and the tail was turned.
    bench.rig.block(false);
    bench.rig.turn(0.5);
    bench.run(5_000 * MS);
    assert_eq!((bench.state(), bench.rig.drive()), (ModuleState::Stopped, 0.0));
    bench.say(&Message::Release);
    bench.run(5_500 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Ready, Faults(0)));
    let found = bench.rig.angle_rad();
    assert!((found - from - 0.5).abs() < 0.01, "it rests where it was found: {found}");
    assert_eq!(bench.ask(&cycle(3, 6_000 * MS, found, 1.0)), Verdict::Accepted);
    bench.run(6_100 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
}

#[test]
fn a_blind_tail_coasts_and_stops() {
    let mut bench = Bench::ready(0.0);
    assert_eq!(bench.ask(&cycle(1, 1_500 * MS, 0.0, 2.0)), Verdict::Accepted);
    bench.run(1_800 * MS);
    bench.rig.fail_encoder(true);
    let blind = bench.now;
    bench.run(blind.0 + 10 * MS);
    assert_eq!(bench.rig.drive(), 0.0, "coasts");
    bench.run(blind.after(BLIND_FOR).0);
    assert_eq!((bench.state(), bench.rig.drive()), (ModuleState::Executing, 0.0), "it may see again");
    let said = bench.run(blind.after(BLIND_FOR).0 + 100 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::BLIND));
    let told = |message: &Message| matches!(message, Message::Telemetry(t) if t.faults == Faults::BLIND);
    assert!(said.iter().any(told), "and says so");
    // Released while still blind it looks in vain.
    bench.say(&Message::Release);
    assert_eq!(bench.state(), ModuleState::Boot);
    bench.run(bench.now.0 + 50 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::BLIND));
    bench.rig.fail_encoder(false);
    bench.rig.turn(-0.3);
    let found = bench.rig.angle_rad();
    bench.run(bench.now.0 + 50 * MS);
    bench.say(&Message::Release);
    bench.run(bench.now.0 + 500 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert!((bench.rig.angle_rad() - found).abs() < 0.01, "{} {found}", bench.rig.angle_rad());
}

#[test]
fn an_encoder_dead_from_the_start_is_said() {
    let mut bench = Bench::boot(0.0);
    bench.rig.fail_encoder(true);
    let said = bench.run(500 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::BLIND));
    assert!(said.iter().any(|message| matches!(message, Message::Hello(_))), "it can be called");
    let told = |message: &Message| matches!(message, Message::TailUnknown(t) if t.faults == Faults::BLIND);
    assert!(said.iter().any(told), "{said:?}");
    assert_eq!(bench.rig.drive(), 0.0);
}

#[test]
fn a_low_battery_finishes_the_cycle_and_refuses_the_next() {
    let mut bench = Bench::ready(0.0);
    bench.supply.battery = Volts(6.0);
    bench.run(2_900 * MS);
    assert_eq!(bench.ask(&cycle(1, 2_950 * MS, 0.0, 1.0)), Verdict::Accepted, "it may be the load");
    bench.run(3_100 * MS);
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Executing, Faults::LOW_BATTERY));
    assert_eq!(bench.ask(&cycle(2, 4_450 * MS, 0.0, 1.0)), Verdict::Refused(Refusal::LowBattery));
    bench.run(4_600 * MS);
    assert_eq!(bench.state(), ModuleState::Holding);
    assert!((bench.rig.angle_rad()).abs() < 0.02 && bench.boat.endpoint().failsafe().may_drive());
    bench.supply = FULL;
    bench.run(7_000 * MS);
    assert_eq!((bench.faults(), bench.ask(&cycle(3, 7_500 * MS, 0.0, 1.0))), (Faults(0), Verdict::Accepted));
}

#[test]
fn stopped_by_the_host_it_brakes_and_released_it_rests_where_it_was_turned() {
    let mut bench = Bench::ready(0.0);
    assert_eq!(bench.ask(&cycle(1, 1_500 * MS, 0.0, 2.0)), Verdict::Accepted);
    bench.run(1_900 * MS);
    let before = bench.rig.angle_rad();
    bench.say(&Message::EmergencyStop);
    bench.run(bench.now.0 + MS);
    assert!(bench.rig.drive() == 0.0 && bench.rig.is_shorted(), "at the next tick");
    assert_eq!((bench.state(), bench.faults()), (ModuleState::Stopped, Faults::EMERGENCY));
    bench.run(2_100 * MS);
    let stands = bench.rig.angle_rad();
    // 8 rad/s and a time constant of 20 ms; it would have gone on by 3 rad.
    assert!((stands - before).abs() < 0.2, "{before} to {stands}");
    bench.run(4_000 * MS);
    assert!((bench.rig.angle_rad() - stands).abs() < 0.005, "it stands");
    bench.rig.turn(0.4);
    bench.run(4_100 * MS);
    assert_eq!(bench.rig.drive(), 0.0, "not even to hold its pose");
    bench.say(&Message::Release);
    bench.run(4_500 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert!((bench.rig.angle_rad() - stands - 0.4).abs() < 0.02, "{} {stands}", bench.rig.angle_rad());
}

#[test]
fn unprovisioned_it_never_drives() {
    let rig = Rig::new(0.3);
    let mut boat = Modboat::new(Endpoint::new(None, ModboatRobot::new(TailLimits::default())), rig.tail());
    let mut host = Bench::ready(0.3);
    host.host.seal(&cycle(1, 2_000 * MS, 0.3, 1.0));
    for (k, datagram) in (0..).zip(host.host.recorded.iter().cycle().take(3_000)) {
        assert_eq!(boat.handle_datagram(LocalInstant(k * MS), datagram), Err(Class::Foreign));
        boat.tick(LocalInstant(k * MS), &FULL).unwrap();
        rig.step_ms();
        rig.turn(0.001);
        assert_eq!(rig.drive(), 0.0);
        assert_eq!(boat.poll_transmit(&mut [0; protocol::MAX_DATAGRAM]), None);
    }
}
