//! Sealing and opening of the datagram that matters most: one module's cycle.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;
use protocol::{
    Cycle, Delivery, FleetKey, Frame, MAX_DATAGRAM, Message, ModboatCycle, ModuleId, Motion, Nonce, Session,
    Side,
};

fn codec(c: &mut Criterion) {
    let key = FleetKey::new([0x42; 32]);
    let module = ModuleId(3);
    let end = |side| {
        let (boot, host) = (Nonce([1; 16]), Nonce([2; 16]));
        Session::new(side, key.fleet(), module, &key.module(module), &boot, host)
    };
    let message = Message::Cycle(Cycle {
        number: 42,
        start: FleetInstant(12_345_678),
        motion: Motion::Modboat(ModboatCycle {
            rotation: Radians(-1.25),
            centerline: Radians(0.5),
            amplitude: Radians(-2.6),
            transition: Duration(500_000),
            period: Duration(1_500_000),
            law: protocol::TransitionLaw::ConstantSpeed,
        }),
        delivery: Delivery::Direct,
    });
    let (mut host, module) = (end(Side::Host), end(Side::Module));
    let mut buffer = [0; MAX_DATAGRAM];
    let datagram = host.seal(&message, &mut buffer).expect("fits").to_vec();
    let mut group = c.benchmark_group("codec");
    group.bench_function("seal cycle", |b| {
        b.iter(|| host.seal(black_box(&message), &mut buffer).map(<[u8]>::len));
    });
    group.bench_function("open cycle", |b| {
        // Each datagram is opened once: every time by a module that has not seen it.
        b.iter_batched_ref(
            || module.clone(),
            |module| module.open(&Frame::parse(black_box(&datagram)).expect("a datagram")),
            BatchSize::SmallInput,
        );
    });
    group.bench_function("session keys", |b| b.iter(|| end(black_box(Side::Module))));
    group.finish();
}

criterion_group!(benches, codec);
criterion_main!(benches);
