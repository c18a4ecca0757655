//! Orders followed by the firmware of an ROV, over a link that loses, repeats and reorders what it carries.
//!
//! The test sees the order datagrams by their length and number, and knows from the firmware which of them came.

use std::collections::BTreeSet;

use firmware::link::endpoint::Endpoint;
use firmware::link::session::Identity;
use firmware::rov::lease::{Output, SURE_WITHIN, ThrustLease};
use protocol::configuration::LeaseLimits;
use protocol::time::{Duration, LocalInstant};
use protocol::units::{Amperes, PulseMicros, Volts};
use protocol::{Kind, MAX_DATAGRAM, ModuleState, Radio};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::super::super::faults::{FaultParameters, Faulty};
use super::super::super::loopback::{Ether, LoopbackRadio, Node};
use super::super::*;
use super::played::{HOST, KEY, thrust};

const STEP: Duration = Duration(2_000);
/// Fleet time at the module's boot: so late that a time takes five bytes and a reply is longer than any order.
const EPOCH: u64 = 1_000_000_000;
/// No order is longer, and no other message of a host in a session is shorter, bytes.
const ORDER_MOST: usize = 48;

/// Copies come after what was sent up to 0.2 s later.
const WEATHER: FaultParameters = FaultParameters {
    loss: 0.3,
    burst: 0.0,
    burst_s: 0.0,
    duplication: 0.4,
    corruption: 0.0,
    truncation: 0.0,
    delay_s: 0.002,
    jitter_s: 0.04,
    reordering: 0.3,
    reorder_s: 0.2,
    late: 0.0,
    late_s: 0.0,
    replay: 0.0,
    replay_s: 0.0,
    forgery: 0.0,
};

struct Bench {
    host: Dispatcher<Node>,
    module: Endpoint<ThrustLease>,
    radios: [Faulty<LoopbackRadio>; 2],
    now: u64,
    /// Numbers of the orders sent since the last change of mind, and of one of them that the module let in.
    sent: BTreeSet<u32>,
    came: bool,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let (ether, id) = (Ether::default(), ModuleId(1));
        let identity = Identity {
            module: id,
            fleet: KEY.fleet(),
            key: KEY.module(id),
            boot: [3; 12],
            report_every: Duration(20_000),
            sure_within: SURE_WITHIN,
        };
        let lease = ThrustLease::new(1, LeaseLimits::default());
        let radio = |node, seed| Faulty::new(ether.radio(Node(node)), FaultParameters::default(), seed);
        let mut bench = Self {
            host: Dispatcher::new(&[id], &KEY, HOST),
            module: Endpoint::new(Some(identity), lease),
            radios: [radio(0, 2 * seed), radio(1, 2 * seed + 1)],
            now: EPOCH,
            sent: BTreeSet::new(),
            came: false,
        };
        bench.run(2_000_000, |_| ());
        assert_eq!(bench.state(), ModuleState::Ready);
        bench.radios.iter_mut().for_each(|radio| radio.set_parameters(WEATHER));
        bench
    }

    fn at(&self) -> FleetInstant {
        FleetInstant(self.now)
    }

    fn local(&self) -> LocalInstant {
        LocalInstant(self.now - EPOCH)
    }

    fn state(&self) -> ModuleState {
        self.module.state(self.local())
    }

    /// The host changes its mind.
    fn order(&mut self, order: impl FnOnce(&mut Dispatcher<Node>, FleetInstant)) {
        self.transmit();
        (self.sent, self.came) = (BTreeSet::new(), false);
        order(&mut self.host, FleetInstant(self.now));
        self.transmit();
    }

    fn transmit(&mut self) {
        let (now, mut buffer) = (self.at(), [0; MAX_DATAGRAM]);
        while let Some((to, datagram)) = self.host.poll_transmit(now, &mut buffer) {
            let header = Frame::parse(datagram).expect("well made").header;
            if header.kind == Kind::ToModule && datagram.len() <= ORDER_MOST {
                self.sent.insert(header.sequence);
            }
            self.radios[0].send(now, to, datagram).expect("a loopback");
        }
    }

    fn step(&mut self) {
        self.now += u64::from(STEP.0);
        let (now, local, mut buffer) = (self.at(), self.local(), [0; MAX_DATAGRAM]);
        while let Ok(Some((length, _))) = self.radios[1].receive(now, &mut buffer) {
            let came = self.module.handle_datagram(local, &buffer[..length]).is_ok();
            let sequence = Frame::parse(&buffer[..length]).expect("undamaged").header.sequence;
            self.came |= came && self.sent.contains(&sequence);
        }
        let pulses = [PulseMicros(1_500.0)].into_iter().collect();
        let output = Output { pulses, battery: Volts(16.0), current: Amperes(0.0), armed: true };
        self.module.handle_timer(local, &output);
        while let Some(datagram) = self.module.poll_transmit(&mut buffer) {
            self.radios[1].send(now, Node(0), datagram).expect("a loopback");
        }
        while let Ok(Some((length, from))) = self.radios[0].receive(now, &mut buffer) {
            let _ = self.host.handle_datagram(now, from, &buffer[..length]);
        }
        self.host.handle_timer(now);
        self.transmit();
    }

    fn run(&mut self, us: u64, mut check: impl FnMut(&Self)) {
        for _ in 0..us / u64::from(STEP.0) {
            self.step();
            check(self);
        }
    }
}

#[test]
fn the_last_order_is_followed_whatever_comes_late() {
    for seed in 0..60 {
        let mut bench = Bench::new(seed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut stops, mut came) = (0, 0);
        for _ in 0..12 {
            let stop = rng.random_bool(0.5);
            bench.order(|host, now| match stop {
                true => host.emergency_stop(now),
                false if rng.random_bool(0.5) => host.release(now),
                false => assert!(host.release_one(now, ModuleId(1))),
            });
            // Often before the one before has come.
            let gap = rng.random_range(1_000..400_000);
            bench.run(gap, |bench| {
                // Nothing that was sent before the stop ends it.
                let followed = !stop || !bench.came || bench.state() == ModuleState::Stopped;
                assert!(followed, "seed {seed}, {} µs: {:?}", bench.now - EPOCH, bench.state());
            });
            stops += u32::from(stop);
            came += u32::from(stop && bench.came);
        }
        assert!(stops == 0 || came > 0, "seed {seed}: no stop of {stops} came");
        for stop in [true, false] {
            bench.order(|host, now| if stop { host.emergency_stop(now) } else { host.release(now) });
            bench.run(1_500_000, |_| ());
            let is_stopped = bench.state() == ModuleState::Stopped;
            assert_eq!(is_stopped, stop, "seed {seed}: {:?}", bench.state());
        }
    }
}

/// Dispatches thrusts that begin so much later; whether the module ran that cycle within the next 1.5 s.
fn dispatch(bench: &mut Bench, number: u32, ahead: u32) {
    let (now, start) = (bench.at(), bench.at().after(Duration(ahead)));
    let motion = Some(thrust(Duration(400_000)));
    bench.host.dispatch(now, number, start, &[motion], Delivery::Direct);
}

fn runs(bench: &mut Bench, number: u32) -> bool {
    let mut ran = false;
    bench.run(1_500_000, |bench| ran |= bench.module.running(bench.local()) == Some(number));
    ran
}

#[test]
fn a_hold_is_not_lost_and_drops_nothing_that_was_sent_after_it() {
    let mut lost = 0;
    for seed in 0..60 {
        let mut bench = Bench::new(seed);
        // As far ahead as a plan is made.
        dispatch(&mut bench, 1, 1_000_000);
        bench.run(300_000, |_| ());
        bench.order(|host, _| host.hold());
        bench.run(60_000, |_| ());
        lost += u32::from(!bench.came);
        assert!(!runs(&mut bench, 1), "seed {seed}: the hold did not come");
        // Copies of a hold come after the cycle that was sent after it.
        dispatch(&mut bench, 2, 1_000_000);
        bench.run(200_000, |_| ());
        bench.host.hold();
        bench.run(100_000, |_| ());
        dispatch(&mut bench, 3, 600_000);
        assert!(runs(&mut bench, 3), "seed {seed}: a hold of before it dropped it");
    }
    println!("{lost} of 60 holds were not there after 60 ms");
    assert!(lost >= 5, "a weather in which one hold would do: {lost}");
}
