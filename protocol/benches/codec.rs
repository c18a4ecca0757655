//! Encode and decode of the datagram that matters most: one module's cycle.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use protocol::units::{Micros, MicrosSpan, Radians};
use protocol::{Cycle, Header, MAX_DATAGRAM, Message, ModboatCycle, ModuleId, Motion, decode, encode};

fn codec(c: &mut Criterion) {
    let header = Header { module: ModuleId(3), session: 0xC0FF_EE00, sequence: 300 };
    let message = Message::Cycle(Cycle {
        number: 42,
        start: Micros(12_345_678),
        motion: Motion::Modboat(ModboatCycle {
            rotation: Radians(-1.25),
            centerline: Radians(0.5),
            amplitude: Radians(-2.6),
            transition: MicrosSpan(500_000),
            period: MicrosSpan(1_500_000),
        }),
    });
    let mut buffer = [0; MAX_DATAGRAM];
    let datagram = encode(&header, &message, &mut buffer).expect("fits").to_vec();
    let mut group = c.benchmark_group("codec");
    group.bench_function("encode cycle", |b| {
        b.iter(|| encode(black_box(&header), black_box(&message), &mut buffer).map(<[u8]>::len));
    });
    group.bench_function("decode cycle", |b| b.iter(|| decode(black_box(&datagram))));
    group.finish();
}

criterion_group!(benches, codec);
criterion_main!(benches);
