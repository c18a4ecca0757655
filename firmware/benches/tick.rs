//! The 1 kHz tick of a module and its parts: what the PC pays for each simulated millisecond.

use std::convert::Infallible;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use firmware::cycle::SwimCycle;
use firmware::encoder::{Encoder, Mounting};
use firmware::limits::Limits;
use firmware::motor::Bridge;
use firmware::schedule::Schedule;
use firmware::servo::{NoSense, ServoParameters, TailServo};
use firmware::tail::Tail;
use firmware::waveform::Waveform;
use protocol::units::{Micros, MicrosSpan, Radians, RadiansPerSecond};

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
    let mut schedule = Schedule::new(Limits::default(), Radians(2.0));
    let waveform = Waveform::new(Radians(0.5), Radians(1.5), MicrosSpan(1_500_000));
    schedule.offer(Micros(0), SwimCycle::new(1, Micros(0), Radians(0.0), MicrosSpan(500_000), waveform));
    let swimming = Micros(1_234_567);
    let reference = schedule.reference(swimming);
    assert!(reference.rate_rad_s.abs() > 0.1, "the bench evaluates the waveform, not a rest");

    criterion.bench_function("schedule reference", |bencher| {
        bencher.iter(|| schedule.reference(black_box(swimming)));
    });

    let parameters = ServoParameters::default();
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
        Tail::new(Board, Mounting::default(), NoSense, bridge, &parameters).expect("valid defaults");
    criterion.bench_function("whole tick: schedule, encoder, servo, bridge", |bencher| {
        bencher.iter(|| tail.tick(&schedule.reference(black_box(swimming))));
    });
}

criterion_group!(benches, tick);
criterion_main!(benches);
