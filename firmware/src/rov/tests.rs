#![expect(clippy::float_cmp, reason = "neutral and whole timer counts are exact")]

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::rc::Rc;
use std::vec::Vec;

use proptest::prelude::*;
use protocol::configuration::{BankConstants, EscConstants, LeaseLimits, ThrusterMounting};
use protocol::time::{Duration, FleetInstant};
use protocol::units::{Amperes, Newtons, PulseMicros, Volts};
use protocol::{
    Connectors, Cycle, Delivery, Faults, Message, ModuleState, Motion, Refusal, RovCycle, Verdict,
};

use super::*;
use crate::bench_host::{AHEAD, BenchHost, identity};
use crate::rov::thruster::law;

const SUPPLY: Supply = Supply { battery: Volts(16.0), current: Amperes(3.0) };
const TICK: u64 = 5_000;

/// A pin whose pulse, µs, the test reads. 25 counts a microsecond at 400 Hz.
#[derive(Clone, Default)]
struct Pin(Rc<RefCell<u16>>);

impl embedded_hal::pwm::ErrorType for Pin {
    type Error = Infallible;
}

impl SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        62_500
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        *self.0.borrow_mut() = duty;
        Ok(())
    }
}

/// One ROV of two thrusters on a bench.
struct Bench {
    rov: Rov<Pin>,
    pins: [Pin; 2],
    now: LocalInstant,
    host: BenchHost,
}

impl Bench {
    fn boot<P: SetDutyCycle + Clone>(pins: &[P; 2], life: u8) -> Rov<P> {
        let mountings = [0, 1].map(|output| ThrusterMounting { output, reversed: false });
        let esc = EscConstants { slew_n_s: 400.0, reversal_delay: Duration(20_000) };
        let settings = BankConstants { arming: Duration(500_000), esc, ..BankConstants::default() };
        let bank = Bank::new(pins.iter().cloned(), &mountings, settings).unwrap();
        let lease = ThrustLease::new(2, LeaseLimits::default());
        Rov::new(Endpoint::new(Some(identity(life)), lease), bank)
    }

    /// Booted and ticking, its clock synchronised: 1 s behind the fleet's.
    fn new() -> Self {
        let pins = [Pin::default(), Pin::default()];
        let rov = Self::boot(&pins, 1);
        let mut bench = Self { rov, pins, now: LocalInstant(0), host: BenchHost::new(1) };
        bench.run(300_000);
        assert_eq!(bench.rov.endpoint().state(bench.now), ModuleState::Arming);
        bench
    }

    fn handle_message(&mut self, message: &Message) {
        self.host.say(self.now, &mut self.rov, message);
    }

    /// Ticks until `end`, own clock; the host answers the clock exchanges. All else that was said comes back.
    fn run(&mut self, end: u64) -> Vec<Message> {
        let mut said = Vec::new();
        while self.now.0 < end {
            self.rov.tick(self.now, &SUPPLY).unwrap();
            said.extend(self.listen());
            self.now.0 += TICK;
        }
        said
    }

    fn listen(&mut self) -> Vec<Message> {
        self.host.listen(self.now, &mut self.rov)
    }

    /// A cycle that starts at `start` on the module's own clock.
    fn offer(&mut self, number: u32, start: u64, thrusts: [f32; 2], lease: u32) -> Verdict {
        let thrusts = thrusts.into_iter().map(Newtons).collect();
        let motion =
            Motion::Rov(RovCycle { thrusts, lease: Duration(lease), connectors: Connectors::Closed });
        let cycle = Cycle { number, start: FleetInstant(start + AHEAD), motion, delivery: Delivery::Direct };
        self.host.ask(self.now, &mut self.rov, &Message::Cycle(cycle))
    }

    fn pulses_us(&self) -> [f32; 2] {
        self.pins.each_ref().map(|pin| f32::from(*pin.0.borrow()) / 25.0)
    }
}

#[test]
fn thrust_comes_when_armed_grows_and_ends_with_the_lease_to_the_tick() {
    let mut bench = Bench::new();
    assert_eq!(bench.offer(1, 400_000, [10.0, -4.0], 300_000), Verdict::Accepted);
    bench.run(500_000);
    assert_eq!(bench.pulses_us(), [1500.0; 2], "executing, not armed");
    assert_eq!(bench.rov.endpoint().state(bench.now), ModuleState::Arming);
    // 400 N/s and 5 ms a tick: 2 N each.
    let wanted = [(2.0, -2.0), (4.0, -4.0), (6.0, -4.0), (8.0, -4.0), (10.0, -4.0), (10.0, -4.0)];
    for (ahead, astern) in wanted {
        bench.run(bench.now.0 + TICK);
        for (pulse_us, newtons) in bench.pulses_us().into_iter().zip([ahead, astern]) {
            let given = law::thrust(PulseMicros(pulse_us), SUPPLY.battery);
            assert!((given.0 - newtons).abs() < 0.01, "{given:?} at {:?}, not {newtons} N", bench.now);
        }
    }
    // The link is lost; the tick at 695 ms is the last of the lease.
    bench.run(700_000);
    assert_eq!(bench.rov.endpoint().state(LocalInstant(699_999)), ModuleState::Executing);
    assert!(bench.pulses_us()[0] > 1528.0 && bench.pulses_us()[1] < 1472.0);
    bench.run(700_001);
    assert_eq!(bench.pulses_us(), [1500.0; 2]);
    assert_eq!(bench.rov.endpoint().state(bench.now), ModuleState::Holding);
}

#[test]
fn reports_what_it_puts_out() {
    let mut bench = Bench::new();
    bench.run(600_000);
    assert_eq!(bench.offer(7, 600_000, [5.0, 0.0], 200_000), Verdict::Accepted);
    let said = bench.run(700_000);
    let reports: Vec<_> = said
        .iter()
        .filter_map(|message| match message {
            Message::RovTelemetry(report) => Some(report),
            _ => None,
        })
        .collect();
    assert_eq!(reports.len(), 5, "every 20 ms");
    let report = reports.last().unwrap();
    assert_eq!((report.state, report.cycle), (ModuleState::Executing, 7));
    assert_eq!((report.battery, report.current), (SUPPLY.battery, SUPPLY.current));
    assert_eq!(report.pulses.iter().map(|pulse| pulse.0).collect::<Vec<_>>(), bench.pulses_us());
    assert!((law::thrust(report.pulses[0], report.battery).0 - 5.0).abs() < 0.01);
    assert_eq!(report.at.0 % 1_000, 0);
}

#[test]
fn turns_round_through_neutral() {
    let mut bench = Bench::new();
    bench.run(600_000);
    bench.offer(1, 600_000, [2.0, 2.0], 900_000);
    bench.run(650_000);
    bench.offer(2, 650_000, [-2.0, 2.0], 900_000);
    for _ in 0..4 {
        bench.run(bench.now.0 + TICK);
        assert_eq!(bench.pulses_us()[0], 1500.0, "{:?}", bench.now);
        assert!(bench.pulses_us()[1] > 1528.0, "the other goes on");
    }
    bench.run(bench.now.0 + TICK);
    assert!(bench.pulses_us()[0] < 1472.0, "20 ms are over");
}

#[test]
fn duplicates_change_nothing_and_a_reboot_begins_at_neutral() {
    let mut bench = Bench::new();
    bench.run(600_000);
    assert_eq!(bench.offer(3, 600_000, [4.0, 4.0], 500_000), Verdict::Accepted);
    bench.run(650_000);
    let before = bench.pulses_us();
    assert_eq!(bench.offer(3, 600_000, [4.0, 4.0], 500_000), Verdict::Duplicate);
    assert_eq!(bench.offer(3, 600_000, [9.0, 4.0], 500_000), Verdict::Refused(Refusal::Conflict));
    bench.run(bench.now.0 + TICK);
    assert_eq!(bench.pulses_us(), before);
    // Power is lost: its memory and the arming with it; the host calls it again.
    bench.rov = Bench::boot(&bench.pins, 2);
    bench.run(bench.now.0 + TICK);
    assert_eq!(bench.pulses_us(), [1500.0; 2]);
    assert_eq!(bench.offer(3, 600_000, [4.0, 4.0], 500_000), Verdict::Refused(Refusal::NotSynchronised));
    bench.run(950_000);
    assert_eq!(bench.offer(4, 950_000, [4.0, 4.0], 500_000), Verdict::Accepted);
    bench.run(1_100_000);
    assert_eq!(bench.pulses_us(), [1500.0; 2], "half a second of neutral again");
    bench.run(1_250_000);
    assert!(bench.pulses_us()[0] > 1528.0);
}

#[test]
fn a_stop_lasts_until_released() {
    let mut bench = Bench::new();
    bench.run(600_000);
    bench.offer(1, 600_000, [4.0, 4.0], 900_000);
    bench.run(650_000);
    bench.handle_message(&Message::EmergencyStop);
    bench.run(bench.now.0 + TICK);
    assert_eq!(bench.pulses_us(), [1500.0; 2]);
    assert_eq!(bench.rov.endpoint().state(bench.now), ModuleState::Stopped);
    let now = bench.now.0;
    assert_eq!(bench.offer(2, now, [4.0, 4.0], 900_000), Verdict::Refused(Refusal::Stopped));
    bench.handle_message(&Message::Release);
    bench.run(bench.now.0 + TICK);
    assert_eq!(bench.pulses_us(), [1500.0; 2], "what was dropped stays dropped");
    let now = bench.now.0;
    assert_eq!(bench.offer(3, now, [4.0, 4.0], 900_000), Verdict::Accepted);
    bench.run(bench.now.0 + 2 * TICK);
    assert!(bench.pulses_us()[0] > 1528.0);
}

#[test]
fn a_low_battery_ends_with_the_lease() {
    let mut bench = Bench::new();
    bench.run(600_000);
    let low = Supply { battery: Volts(13.0), ..SUPPLY };
    let mut number = 0;
    while bench.now.0 < 2_400_000 {
        number += 1;
        assert_eq!(bench.offer(number, bench.now.0, [4.0, 4.0], 400_000), Verdict::Accepted);
        for _ in 0..20 {
            bench.rov.tick(bench.now, &low).unwrap();
            bench.listen();
            bench.now.0 += TICK;
        }
    }
    for _ in 0..50 {
        bench.rov.tick(bench.now, &low).unwrap();
        bench.listen();
        bench.now.0 += TICK;
    }
    assert_eq!(bench.rov.endpoint().state(bench.now), ModuleState::Executing, "the lease lasts");
    assert!(bench.pulses_us()[0] > 1528.0);
    let now = bench.now.0;
    assert_eq!(bench.offer(number + 1, now, [4.0, 4.0], 400_000), Verdict::Refused(Refusal::LowBattery));
    bench.run(bench.now.0 + 500_000);
    assert_eq!(bench.pulses_us(), [1500.0; 2]);
}

proptest! {
    #[test]
    fn no_datagram_and_no_battery_drives_a_pin_out_of_range(
        storm in proptest::collection::vec(
            (0_u64..30_000, any::<[u32; 2]>(), any::<u32>(), 0_u64..200_000, any::<u32>(), any::<bool>()),
            1..60,
        ),
        noise in proptest::collection::vec(any::<u8>(), 0..80),
    ) {
        let mut bench = Bench::new();
        bench.run(600_000);
        for (number, (pause, thrust_bits, volt_bits, ahead, lease, usual)) in (1..).zip(storm) {
            let _ = bench.rov.handle_datagram(bench.now, &noise);
            let thrusts = thrust_bits.map(|bits| match usual {
                true => f32::from_bits(bits) % 60.0,
                false => f32::from_bits(bits),
            });
            let lease = if usual { lease % 1_000_000 } else { lease };
            bench.offer(number, bench.now.0 + ahead, thrusts, lease);
            let end = LocalInstant(bench.now.0 + pause);
            let supply = Supply { battery: Volts(f32::from_bits(volt_bits)), ..SUPPLY };
            while bench.now < end {
                bench.rov.tick(bench.now, &supply).unwrap();
                bench.listen();
                for pulse_us in bench.pulses_us() {
                    prop_assert!((1100.0..=1900.0).contains(&pulse_us), "{} µs", pulse_us);
                }
                bench.now.0 += TICK;
            }
        }
    }
}

/// A pin that works until it is told to fail.
#[derive(Clone, Default)]
struct Failing(Pin, Rc<Cell<bool>>);

#[derive(Debug, PartialEq)]
struct Broken;

impl embedded_hal::pwm::Error for Broken {
    fn kind(&self) -> embedded_hal::pwm::ErrorKind {
        embedded_hal::pwm::ErrorKind::Other
    }
}

impl embedded_hal::pwm::ErrorType for Failing {
    type Error = Broken;
}

impl SetDutyCycle for Failing {
    fn max_duty_cycle(&self) -> u16 {
        self.0.max_duty_cycle()
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Broken> {
        if self.1.get() {
            return Err(Broken);
        }
        self.0.set_duty_cycle(duty).map_err(|never| match never {})
    }
}

#[test]
fn an_output_that_fails_stops_the_rov() {
    for (fails_for, stops) in [(90_000, false), (200_000, true)] {
        let pins = [Failing::default(), Failing::default()];
        let mut rov = Bench::boot(&pins, 1);
        let (mut host, mut said) = (BenchHost::new(1), Vec::new());
        let lease = Duration(500_000);
        for now in (0..2_000_000).step_by(TICK as usize).map(LocalInstant) {
            let fails = (1_500_000..1_500_000 + fails_for).contains(&now.0);
            pins[1].1.set(fails);
            assert_eq!(rov.tick(now, &SUPPLY).is_err(), fails);
            said.extend(host.listen(now, &mut rov));
            if now.0 == 1_300_000 {
                let thrusts = [4.0, 4.0].into_iter().map(Newtons).collect();
                let motion = Motion::Rov(RovCycle { thrusts, lease, connectors: Connectors::Closed });
                let start = FleetInstant(now.0 + AHEAD);
                let cycle = Cycle { number: 1, start, motion, delivery: Delivery::Direct };
                assert_eq!(host.ask(now, &mut rov, &Message::Cycle(cycle)), Verdict::Accepted);
            }
            let stopped = rov.endpoint().failsafe().state() == ModuleState::Stopped;
            assert_eq!(stopped, stops && now.0 >= 1_600_000, "{fails_for} at {now:?}");
            let working_us = f32::from(*pins[0].0.0.borrow()) / 25.0;
            if stopped && now.0 > 1_600_000 {
                assert_eq!(working_us, 1_500.0, "the thruster that works goes to neutral");
            }
        }
        let told = |message: &Message| match message {
            Message::RovTelemetry(report) => report.faults == Faults::OUTPUT,
            _ => false,
        };
        assert_eq!(said.iter().any(told), stops);
    }
}
