//! Criterion benches of the link: one cycle sealed for, and sent to, a thousand modules, and their answers opened. The
//! demand is 20 ms of one core for a thousand modules.

use std::hint::black_box;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use link::dispatcher::{Dispatcher, DispatcherEvent};
use link::identity::HostIdentity;
use link::loopback::{Ether, Node};
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;
use protocol::{
    Acknowledge, Announcer, Cycle, Delivery, FleetKey, Frame, Hello, MAX_DATAGRAM, Message, ModboatCycle,
    ModuleId, ModuleKey, ModuleKind, Motion, Nonce, Radio, Session, Side, Verdict,
};

const MODULES: u16 = 1_000;
const LEAD: Duration = Duration(300_000);

fn identity() -> HostIdentity {
    HostIdentity::simulated(1, 0)
}

fn module_key(key: &FleetKey, id: ModuleId) -> ModuleKey {
    key.module(id)
}

fn boot(id: ModuleId) -> Nonce {
    let mut nonce = [7; 16];
    nonce[..2].copy_from_slice(&id.0.to_le_bytes());
    Nonce(nonce)
}

/// A host and the modules' ends of its sessions, at the addresses that `address` gives them.
fn fleet<A: Copy>(address: impl Fn(ModuleId) -> A) -> (Dispatcher<A>, Vec<Session>) {
    let HostIdentity { key, boot: host_boot } = identity();
    let ids: Vec<ModuleId> = (1..=MODULES).map(ModuleId).collect();
    let mut host = Dispatcher::new(&ids, &key, host_boot);
    let mut buffer = [0; MAX_DATAGRAM];
    let modules = ids.iter().map(|&id| {
        let (key, fleet, nonce) = (module_key(&key, id), key.fleet(), boot(id));
        let hello = Hello { kind: ModuleKind::Modboat, firmware: (0, 1, 0), session: 0 };
        let mut announcer = Announcer::new(fleet, id, &key, nonce);
        let datagram = announcer.seal(&Message::Hello(hello), &mut buffer).expect("room");
        host.handle_datagram(FleetInstant(1), address(id), datagram).expect("an announcement");
        let (_, call) = host.poll_transmit(FleetInstant(1), &mut buffer).expect("a call");
        let frame = Frame::parse(call).expect("a frame");
        let host_nonce = frame.header.nonce.expect("a call has the host's nonce");
        let mut session = Session::new(Side::Module, fleet, id, &key, &nonce, host_nonce);
        session.open(&frame).expect("the call of its host");
        let answer = session.seal(&Message::Health(protocol::Health::default()), &mut buffer).expect("room");
        let joined = host.handle_datagram(FleetInstant(1), address(id), answer).expect("a first word");
        assert!(matches!(joined, Some(DispatcherEvent::Joined(_))));
        session
    });
    let modules = modules.collect();
    (host, modules)
}

fn motion(index: usize) -> Option<Motion> {
    let angle = index as f32 * 1e-3;
    Some(Motion::Modboat(ModboatCycle {
        rotation: Radians(0.1 - angle),
        centerline: Radians(1.5 + angle),
        amplitude: Radians(-0.9 - angle),
        transition: Duration(500_000),
        period: Duration(1_500_000),
        law: protocol::TransitionLaw::ConstantSpeed,
    }))
}

/// Dispatches cycle after cycle, every two seconds of the host's time.
struct Cycles {
    motions: Vec<Option<Motion>>,
    number: u32,
}

impl Cycles {
    fn new() -> Self {
        Self { motions: (0..usize::from(MODULES)).map(motion).collect(), number: 0 }
    }

    fn dispatch<A: Copy>(&mut self, host: &mut Dispatcher<A>) -> FleetInstant {
        self.number += 1;
        let now = FleetInstant(u64::from(self.number) * 2_000_000);
        host.dispatch(now, self.number, now.after(LEAD), &self.motions, Delivery::Direct);
        now
    }
}

/// One cycle to every module: sealed only, handed to the loopback of one process, handed to a socket.
fn dispatch(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("dispatch, 1,000 modules");
    group.sample_size(20).throughput(Throughput::Elements(u64::from(MODULES)));
    let mut buffer = [0; MAX_DATAGRAM];

    let (mut host, _modules) = fleet(|id| Node(id.0));
    let mut cycles = Cycles::new();
    group.bench_function("sealed", |b| {
        b.iter(|| {
            let now = cycles.dispatch(&mut host);
            let sent = std::iter::from_fn(|| host.poll_transmit(now, &mut buffer).map(|(_, d)| d.len()));
            assert_eq!(black_box(sent.count()), usize::from(MODULES));
        });
    });

    let ether = Ether::default();
    let mut radio = ether.radio(Node(0));
    let mut others: Vec<_> = (1..=MODULES).map(|id| ether.radio(Node(id))).collect();
    group.bench_function("sealed, loopback radio", |b| {
        b.iter_batched(
            // What the cycle before left is taken away outside of the measurement.
            || {
                for other in &mut others {
                    while let Ok(Some(_)) = other.receive(FleetInstant(0), &mut [0; 1]) {}
                }
            },
            |()| {
                let now = cycles.dispatch(&mut host);
                while let Some((to, datagram)) = host.poll_transmit(now, &mut buffer) {
                    let Ok(()) = radio.send(now, to, datagram);
                }
            },
            BatchSize::PerIteration,
        );
    });

    let sink = Sink::new();
    let (mut host, _modules) = fleet(|_| sink.address);
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a socket");
    let mut sent = 0_u64;
    group.bench_function("sealed, UDP on 127.0.0.1", |b| {
        b.iter(|| {
            let now = cycles.dispatch(&mut host);
            while let Some((to, datagram)) = host.poll_transmit(now, &mut buffer) {
                socket.send_to(datagram, to).expect("sent");
                sent += 1;
            }
        });
    });
    println!("UDP: {sent} sent, {} drained by the receiver's thread", sink.drained.load(Ordering::Relaxed));
    group.finish();
}

/// A socket that a thread drains.
struct Sink {
    address: SocketAddr,
    drained: &'static AtomicU64,
    end: &'static AtomicBool,
}

impl Sink {
    fn new() -> Self {
        static DRAINED: AtomicU64 = AtomicU64::new(0);
        static END: AtomicBool = AtomicBool::new(false);
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a socket");
        let address = socket.local_addr().expect("an address");
        socket.set_read_timeout(Some(std::time::Duration::from_millis(50))).expect("a timeout");
        std::thread::spawn(move || {
            let mut buffer = [0; MAX_DATAGRAM];
            while !END.load(Ordering::Relaxed) {
                DRAINED.fetch_add(u64::from(socket.recv(&mut buffer).is_ok()), Ordering::Relaxed);
            }
        });
        Self { address, drained: &DRAINED, end: &END }
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
    }
}

/// The acknowledgements of all modules, opened and followed.
fn acknowledge(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("acknowledge, 1,000 modules");
    group.sample_size(20).throughput(Throughput::Elements(u64::from(MODULES)));
    let (mut host, mut modules) = fleet(|id| Node(id.0));
    let (mut cycles, host) = (Cycles::new(), std::cell::RefCell::new(&mut host));
    let mut buffer = [0; MAX_DATAGRAM];
    group.bench_function("opened and followed", |b| {
        b.iter_batched(
            || {
                let mut host = host.borrow_mut();
                let now = cycles.dispatch(&mut host);
                while host.poll_transmit(now, &mut buffer).is_some() {}
                let answer = Acknowledge { cycle: cycles.number, verdict: Verdict::Accepted };
                let seal = |session: &mut Session| {
                    session.seal(&Message::Acknowledge(answer), &mut buffer).expect("room").to_vec()
                };
                (now.after(Duration(1_000)), modules.iter_mut().map(seal).collect::<Vec<_>>())
            },
            |(now, answers)| {
                let mut host = host.borrow_mut();
                for (id, answer) in (1..).zip(&answers) {
                    let event = host.handle_datagram(now, Node(id), answer);
                    assert!(matches!(event, Ok(Some(DispatcherEvent::Accepted { .. }))));
                }
            },
            BatchSize::PerIteration,
        );
    });
    group.finish();
}

/// One datagram.
fn one(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("one cycle datagram");
    let (key, id) = (identity().key, ModuleId(1));
    let (fleet, key) = (key.fleet(), module_key(&key, id));
    let ends = || {
        [Side::Host, Side::Module].map(|side| Session::new(side, fleet, id, &key, &boot(id), Nonce([3; 16])))
    };
    let motion = motion(0).expect("a motion");
    let message =
        Message::Cycle(Cycle { number: 1, start: FleetInstant(1), motion, delivery: Delivery::Direct });
    let mut buffer = [0; MAX_DATAGRAM];
    let [mut host, module] = ends();
    let length = host.seal(&message, &mut buffer).expect("room").len();
    println!("a cycle is a datagram of {length} bytes");
    group.bench_function("seal", |b| {
        b.iter(|| black_box(host.seal(black_box(&message), &mut buffer).expect("room").len()));
    });
    let [mut host, _] = ends();
    let datagram = host.seal(&message, &mut buffer).expect("room").to_vec();
    group.bench_function("parse and open", |b| {
        // A session opens a number once: each time a fresh copy of it.
        b.iter_batched_ref(
            || module.clone(),
            |module| black_box(module.open(&Frame::parse(black_box(&datagram)).expect("a frame"))),
            BatchSize::SmallInput,
        );
    });
    group.bench_function("session keys", |b| b.iter(|| black_box(ends())));
    group.finish();
}

criterion_group!(benches, dispatch, acknowledge, one);
criterion_main!(benches);
