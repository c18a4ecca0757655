//! The tick of a module and its parts: what the PC pays for each simulated millisecond.

use std::convert::Infallible;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use firmware::link::endpoint::Endpoint;
use firmware::link::session::{Identity, SURE_WITHIN};
use firmware::modboat::cycle::SwimCycle;
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;
use firmware::modboat::schedule::Schedule;
use firmware::modboat::servo::{NoSense, TailServo};
use firmware::modboat::tail::Tail;
use firmware::modboat::waveform::Waveform;
use firmware::module::{Module, Supply};
use firmware::rov::Rov;
use firmware::rov::lease::ThrustLease;
use firmware::rov::thruster::bank::Bank;
use protocol::configuration::{
    BankConstants, EncoderMounting, LeaseLimits, ServoConstants, TailLimits, ThrusterMounting,
};
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::{Amperes, Newtons, Radians, RadiansPerSecond, Volts};
use protocol::{
    Connectors, Cycle, Delivery, FleetKey, Frame, MAX_DATAGRAM, Message, ModuleId, Motion, Nonce, RovCycle,
    Session, Side, TimeReply,
};

/// An encoder that stands still, and outputs that go nowhere.
struct Board;

impl Encoder for Board {
    type Error = Infallible;
    const COUNTS_PER_TURN: u32 = 4096;

    fn counts(&mut self) -> Result<u32, Infallible> {
        Ok(black_box(700))
    }
}

impl embedded_hal::pwm::ErrorType for Board {
    type Error = Infallible;
}

impl SetDutyCycle for Board {
    fn max_duty_cycle(&self) -> u16 {
        1000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        black_box(duty);
        Ok(())
    }
}

impl embedded_hal::digital::ErrorType for Board {
    type Error = Infallible;
}

impl OutputPin for Board {
    fn set_low(&mut self) -> Result<(), Infallible> {
        black_box(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        black_box(true);
        Ok(())
    }
}

fn tick(criterion: &mut Criterion) {
    let mut schedule = Schedule::new(TailLimits::default(), Radians(2.0));
    let waveform = Waveform::new(Radians(0.5), Radians(1.5), Duration(1_500_000));
    let cycle = SwimCycle::new(
        1,
        FleetInstant(0),
        Radians(0.0),
        (Duration(500_000), protocol::TransitionLaw::ConstantSpeed),
        waveform,
    );
    schedule.offer(FleetInstant(0), cycle, Delivery::Direct);
    let swimming = FleetInstant(1_234_567);
    let reference = schedule.reference(swimming);
    assert!(reference.rate_rad_s.abs() > 0.1, "the bench evaluates the waveform, not a rest");

    criterion.bench_function("schedule reference", |bencher| {
        bencher.iter(|| schedule.reference(black_box(swimming)));
    });

    let parameters = ServoConstants::default();
    let mut servo = TailServo::new(&parameters).expect("the defaults are valid");
    criterion.bench_function("servo law", |bencher| {
        bencher.iter(|| {
            servo.tick(
                black_box(&reference),
                black_box(Radians(1.1)),
                black_box(RadiansPerSecond(-3.0)),
                None,
            )
        });
    });

    let bridge = Bridge::new(Board, Board, Board);
    let mut tail =
        Tail::new(Board, EncoderMounting::default(), NoSense, bridge, &parameters).expect("valid defaults");
    criterion.bench_function("whole tick: schedule, encoder, servo, bridge", |bencher| {
        bencher.iter(|| tail.tick(&schedule.reference(black_box(swimming))));
    });
}

/// Six thrusters ahead in the middle of a lease, synchronised and armed.
fn rov(criterion: &mut Criterion) {
    const N: usize = 6;
    let (key, module) = (FleetKey::new([0x42; 32]), ModuleId(1));
    let identity = Identity {
        module,
        fleet: key.fleet(),
        key: key.module(module),
        boot: [1; 12],
        report_every: Duration(20_000),
        sure_within: SURE_WITHIN,
    };
    let mountings: Vec<ThrusterMounting> =
        (0..N).map(|k| ThrusterMounting { output: k as u8, reversed: k % 2 == 1 }).collect();
    let settings = BankConstants { arming: Duration(0), ..BankConstants::default() };
    let pins = (0..N).map(|_| Board);
    let bank = Bank::new(pins, &mountings, settings).expect("valid defaults");
    let endpoint = Endpoint::new(Some(identity), ThrustLease::new(N, LeaseLimits::default()));
    let mut rov = Rov::new(endpoint, bank);
    let supply = Supply { battery: Volts(15.3), current: Amperes(4.0) };
    let mut buffer = [0; MAX_DATAGRAM];
    let _ = rov.tick(LocalInstant(0), &supply);
    let announcement = rov.poll_transmit(&mut buffer).expect("it announces itself");
    let boot = Frame::parse(announcement).expect("a datagram").header.nonce.expect("announcements have one");
    let key = (key.fleet(), key.module(module));
    let mut host = Session::new(Side::Host, key.0, module, &key.1, &boot, Nonce([2; 16]));
    rov.handle_datagram(LocalInstant(0), host.seal_call(&mut buffer).expect("fits")).expect("accepted");
    let mut deliver = |rov: &mut Rov<Board>, now: u64, message: &Message| {
        rov.handle_datagram(LocalInstant(now), host.seal(message, &mut buffer).expect("fits"))
            .expect("accepted");
    };
    for now in [1_000, 2_000, 3_000, 4_000].map(LocalInstant) {
        let reply = TimeReply { request_sent: now, received: FleetInstant(now.0), sent: FleetInstant(now.0) };
        deliver(&mut rov, now.0, &Message::TimeReply(reply));
    }
    let motion = RovCycle {
        thrusts: [Newtons(12.0); N].into_iter().collect(),
        lease: Duration(1_000_000),
        connectors: Connectors::Closed,
    };
    let cycle = Cycle {
        number: 1,
        start: FleetInstant(5_000),
        motion: Motion::Rov(motion),
        delivery: Delivery::Direct,
    };
    deliver(&mut rov, 5_000, &Message::Cycle(cycle));
    let _ = rov.tick(LocalInstant(5_000), &supply);
    let _ = rov.tick(LocalInstant(500_000), &supply);
    assert!(rov.bank().pulses().iter().all(|pulse| (pulse.0 - 1500.0).abs() > 50.0), "the bench drives");
    criterion.bench_function("whole ROV tick: lease, slew, pulse, six pins", |bencher| {
        bencher.iter(|| rov.tick(black_box(LocalInstant(500_000)), black_box(&supply)));
    });
}

criterion_group!(benches, tick, rov);
criterion_main!(benches);
