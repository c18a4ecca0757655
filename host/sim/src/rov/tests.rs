use super::remote::RemoteRov;
use link::dispatcher::{Dispatcher, DispatcherEvent};
use link::faults::{FaultParameters, Faulty};
use link::loopback::{Ether, LoopbackRadio, Node as Address};
use protocol::configuration::EscConstants;
use protocol::ledger::Class;
use protocol::units::Newtons;
use protocol::{Connectors, Delivery, FleetKey, ModuleId, ModuleState, Motion, RovCycle};

use crate::clock::ClockParameters;
use crate::node::Setup;

use super::*;

const REVERSED: [bool; 3] = [false, true, false];
const HOST: Address = Address(0);
const KEY: FleetKey = FleetKey::new([7; 32]);
const STEP_US: u64 = 5_000;
const PERIOD_US: u64 = 50_000;

type Medium = Faulty<LoopbackRadio>;

fn setup(seed: u64, clock: &ClockParameters) -> Setup<'_> {
    Setup {
        id: ModuleId(1),
        fleet: KEY.fleet(),
        key: KEY.module(ModuleId(1)),
        report_every: Duration(20_000),
        clock,
        seed,
    }
}

/// One ROV, its host, and what the host believes of its thrusts.
struct Bench {
    rov: SimRov<Medium>,
    host: Medium,
    dispatcher: Dispatcher<Address>,
    remote: RemoteRov,
    now: FleetInstant,
    number: u32,
    reboots: u32,
}

impl Bench {
    fn new(faults: FaultParameters, seed: u64) -> Self {
        let ether = Ether::default();
        let radio = Faulty::new(ether.radio(Address(1)), faults, seed);
        let host = Faulty::new(ether.radio(HOST), faults, seed + 1000);
        let thrusters = Thrusters::new(&REVERSED, 15.5).unwrap();
        let rov = SimRov::new(&setup(seed, &ClockParameters::default()), thrusters, radio, HOST).unwrap();
        let (dispatcher, remote) =
            (Dispatcher::new(&[ModuleId(1)], &KEY, [7; 12]), RemoteRov::new(&REVERSED));
        Self { rov, host, dispatcher, remote, now: FleetInstant(0), number: 0, reboots: 0 }
    }

    /// Goes on until `end`; with `thrusts` the host says so every 50 ms, 20 ms ahead.
    fn run(&mut self, end: u64, thrusts: Option<&dyn Fn(u64) -> [f32; 3]>, mut look: impl FnMut(&Self)) {
        let mut buffer = [0; protocol::MAX_DATAGRAM];
        while self.now.0 < end {
            let now = self.now;
            while let Ok(Some((length, from))) = self.host.receive(now, &mut buffer) {
                match self.dispatcher.handle_datagram(now, from, &buffer[..length]) {
                    Ok(Some(DispatcherEvent::Reported(0))) => {
                        let report = self.dispatcher.modules()[0].rov_telemetry().expect("a report");
                        self.remote.report(report, now);
                    }
                    Ok(Some(DispatcherEvent::Rebooted(0))) => self.reboots += 1,
                    // Nothing is damaged here; what the medium doubled comes twice, and what a reboot overtook is stale.
                    Ok(_) | Err(Class::Duplicate) => {}
                    Err(Class::Stale) if self.reboots > 0 => {}
                    Err(class) => panic!("{class:?}"),
                }
            }
            if let Some(thrusts) = thrusts.filter(|_| now.0.is_multiple_of(PERIOD_US)) {
                self.number += 1;
                let start = now.after(Duration(20_000));
                let thrusts = thrusts(start.0).into_iter().map(Newtons).collect();
                let motion = Motion::Rov(RovCycle {
                    thrusts,
                    lease: Duration(300_000),
                    connectors: Connectors::Closed,
                });
                self.dispatcher.dispatch(now, self.number, start, &[Some(motion)], Delivery::Direct);
            }
            self.dispatcher.handle_timer(now);
            while let Some((to, datagram)) = self.dispatcher.poll_transmit(now, &mut buffer) {
                self.host.send(now, to, datagram).unwrap();
            }
            self.rov.tick(now).unwrap();
            self.remote.step(now);
            look(self);
            self.now.0 += STEP_US;
        }
    }
}

#[test]
fn follows_thrusts_over_a_lossy_link_and_stops_when_the_host_falls_silent() {
    let faults =
        FaultParameters { loss: 0.3, duplication: 0.1, delay_s: 0.002, jitter_s: 0.02, ..Default::default() };
    for seed in 1..=5 {
        let mut bench = Bench::new(faults, seed);
        bench.run(3_500_000, None, |bench| assert!(bench.rov.thrusts_n().iter().all(|n| n.abs() < 1e-12)));
        assert_eq!(bench.rov.state(bench.now), Some(ModuleState::Ready), "seed {seed}: armed");
        // A slow swing; its fastest change is 8·2π/4 = 12.6 N/s, far below the slew limit.
        let demand = |at_us: u64| {
            let swing = (8.0 * (std::f64::consts::TAU * (at_us as f64 * 1e-6) / 4.0).sin()) as f32;
            [swing, 10.0, -3.0]
        };
        let (mut worst_n, mut apart_n, mut silent_ticks) = (0.0_f64, 0.0_f64, 0);
        bench.run(12_000_000, Some(&demand), |bench| {
            if bench.now.0 < 4_500_000 {
                return;
            }
            for ((thrust_n, wanted_n), shown_n) in
                bench.rov.thrusts_n().iter().zip(demand(bench.now.0)).zip(bench.remote.thrusts_n())
            {
                worst_n = worst_n.max((thrust_n - f64::from(wanted_n)).abs());
                apart_n = apart_n.max((thrust_n - shown_n).abs());
            }
            silent_ticks += u32::from(bench.rov.state(bench.now) != Some(ModuleState::Executing));
        });
        let ledger = *bench.dispatcher.modules()[0].ledger();
        println!("seed {seed}: off by {worst_n:.2} N at most, seen from the host {apart_n:.2} N; {ledger:?}");
        // The lag (0.1 s), a period and two lost cycles in a row, at 12.6 N/s.
        assert!(worst_n < 12.6 * 0.35, "seed {seed}: {worst_n} N");
        assert!(apart_n < 12.6 * 0.2, "seed {seed}: {apart_n} N");
        assert_eq!(silent_ticks, 0, "seed {seed}: six cycles to a lease");
        assert_eq!(ledger.cycles, u64::from(bench.number));
        assert!(ledger.open() <= 1 && ledger.acknowledged * 2 > ledger.cycles, "seed {seed}: {ledger:?}");
        assert_eq!(ledger.refused, 0, "seed {seed}");
        // Silence. The last cycle starts 20 ms after it is sent and holds for 300 ms.
        let last_sent = bench.now.0 - PERIOD_US;
        bench.run(last_sent + 320_000 + 2 * STEP_US, None, |_| ());
        assert!(bench.rov.pulses_us().iter().all(|us| (us - 1500.0).abs() < 1e-3), "seed {seed}: neutral");
        bench.run(last_sent + 1_500_000, None, |_| ());
        assert!(bench.rov.thrusts_n().iter().all(|n| n.abs() < 1e-3), "seed {seed}");
        assert!(bench.remote.thrusts_n().iter().all(|n| n.abs() < 0.05), "seed {seed}");
    }
}

#[test]
fn a_reboot_stops_it_until_it_has_armed_again() {
    let mut bench = Bench::new(FaultParameters::default(), 1);
    let demand = |_| [10.0, 10.0, 10.0];
    bench.run(5_000_000, Some(&demand), |_| ());
    assert!(bench.rov.thrusts_n().iter().all(|n| (n - 10.0).abs() < 0.02), "{:?}", bench.rov.thrusts_n());
    // The reversed one is driven to the other side of neutral.
    let pulses_us = bench.rov.pulses_us();
    assert!(pulses_us[0] > 1528.0 && (pulses_us[0] + pulses_us[1] - 3000.0).abs() < 0.1, "{pulses_us:?}");
    bench.rov.set_failed(2);
    bench.run(5_100_000, Some(&demand), |_| ());
    assert!(bench.rov.thrusts_n()[2].abs() < 1e-12 && bench.rov.thrusts_n()[0] > 9.9);
    bench.rov.reboot(bench.now, Duration(100_000));
    assert_eq!(bench.rov.state(bench.now), None);
    let armed_at = 5_200_000 + u64::from(BankConstants::default().arming.0);
    bench.run(armed_at, Some(&demand), |bench| {
        assert!(bench.rov.pulses_us().iter().all(|us| (us - 1500.0).abs() < 1e-3), "{:?}", bench.now);
    });
    bench.run(armed_at + 1_000_000, Some(&demand), |_| ());
    assert!(bench.rov.thrusts_n()[0] > 9.9, "{:?}", bench.rov.thrusts_n());
    assert_eq!((bench.reboots, bench.dispatcher.modules()[0].boots()), (1, 2));
    assert!(EscConstants::default().slew_n_s > 100.0, "or it would not be there within a second");
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |reversed: &[bool], battery_v: f64| {
        let (clock, radio) = (ClockParameters::default(), Ether::default().radio(Address(1)));
        let rov = Thrusters::new(reversed, battery_v);
        rov.and_then(|rov| SimRov::new(&setup(1, &clock), rov, radio, HOST)).map(|_| ()).unwrap_err()
    };
    for volts in [9.99, 20.01, f64::NAN] {
        assert!(matches!(refused(&REVERSED, volts), RovError::Parameter(_)), "{volts} V");
    }
    assert_eq!(refused(&[], 16.0), BankError::Count { thrusters: 0, pins: 0 }.into());
    assert_eq!(refused(&[false; 9], 16.0), BankError::Count { thrusters: 9, pins: 9 }.into());
}
