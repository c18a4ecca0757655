//! Refusals of a module: invalid configurations, and cycles beyond its time or its limits.

use link::dispatcher::DispatcherEvent;
use link::identity::HostIdentity;
use protocol::configuration::{FORMAT, IMAGE_MAX, MAGIC};
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;
use protocol::{ModboatCycle, ModuleId, Motion, Refusal};
use qemu::bench::Bench;
use qemu::emulator::{Emulator, PATIENCE, Setup, free_port};
use qemu::provisioned;

const SEED: u64 = 6;
const SECOND: u64 = 1_000_000;

/// An image under a right checksum.
fn with_checksum(mut guarded: Vec<u8>) -> Vec<u8> {
    let step = |crc: u32| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
    let crc =
        guarded.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)));
    guarded.extend((!crc).to_le_bytes());
    guarded
}

#[test]
fn without_a_valid_configuration_it_blinks_and_says_nothing() {
    let host = HostIdentity::simulated(SEED, 0);
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a free port");
    let port = socket.local_addr().expect("bound").port();
    let configuration = provisioned::modboat(&host, ModuleId(3), port);
    let good = provisioned::image(&configuration);
    let guarded = good.len() - 4;

    let mut checksum = good.clone();
    checksum[guarded - 1] ^= 1;
    let mut version = good[..guarded].to_vec();
    version[MAGIC.len()..MAGIC.len() + 2].copy_from_slice(&(FORMAT + 1).to_le_bytes());
    // The number comes first, in seven bits a byte: 2000 = 0b1111_1010000.
    let mut content = good[8..guarded].to_vec();
    assert_eq!(content[0], 3, "the module's number");
    content.splice(..1, [0xd0, 0x0f]);
    let length = (content.len() as u16).to_le_bytes();
    let id = with_checksum([&good[..6], &length, &content].concat());

    // By instructions, of which each takes 64 ns: its seconds are shorter than this machine's.
    let arguments = &["-icount", "shift=6,sleep=off"][..];
    for (what, block, reason) in [
        ("erased", vec![0xff; IMAGE_MAX], "begins with [ff, ff, ff, ff]"),
        ("checksum", checksum, "checksum"),
        ("version", with_checksum(version), "format 4, this build reads 3"),
        ("id", id, "module 2000: numbers go from 1 to 1024"),
        ("cut short", good[..40].to_vec(), "checksum"),
    ] {
        let forward = Some((free_port(), port));
        let mut emulator = Emulator::start(&Setup {
            image: "qemu.elf",
            configuration: &block,
            forward,
            arguments,
            ..Setup::default()
        });
        let said =
            emulator.await_line("reason", |line| line.contains("not provisioned").then(|| line.to_owned()));
        assert!(said.contains(reason), "{what}: {said}");
        // Two flashes, a pause, and again.
        for _ in 0..3 {
            emulator.await_line("light", |line| (line == "status LED on").then_some(()));
            emulator.await_line("no light", |line| (line == "status LED off").then_some(()));
        }
        socket.set_nonblocking(true).expect("a socket");
        let heard = socket.recv_from(&mut [0; 64]);
        assert!(heard.is_err(), "{what}: it announced itself: {heard:?}");
        assert!(
            emulator.is_alive() && !emulator.lines().iter().any(|line| line.starts_with("tick")),
            "{what}"
        );
        println!("{what}: {said}");
    }
    // The same board with the good one.
    let forward = Some((free_port(), port));
    let _emulator =
        Emulator::start(&Setup { image: "qemu.elf", configuration: &good, forward, ..Setup::default() });
    socket.set_nonblocking(false).expect("a socket");
    socket.set_read_timeout(Some(PATIENCE)).expect("a socket");
    assert!(socket.recv_from(&mut [0; 600]).is_ok(), "it announces itself");
}

/// From rest at zero and back: at most 2.6 rad of amplitude and 13 rad/s are allowed.
fn swing(amplitude: f32, period_s: f32) -> ModboatCycle {
    ModboatCycle {
        rotation: Radians(0.0),
        centerline: Radians(-amplitude),
        amplitude: Radians(amplitude),
        transition: Duration(0),
        period: Duration((period_s * 1e6) as u32),
        law: protocol::TransitionLaw::ConstantSpeed,
    }
}

#[test]
fn cycles_beyond_its_time_or_its_limits_are_refused_reported_and_not_executed() {
    let mut bench = Bench::start(1, SEED);
    bench.until_ready();
    // Two that it runs, so that there is one that was run and one that ran last.
    let good = swing(1.0, 1.5);
    for number in 1..=2 {
        let start = bench.now().after(Duration(300_000));
        bench.dispatch(number, start, &[Motion::Modboat(good)]);
        bench.until("end of a good one", |bench, _| bench.now().0 > start.0 + 2 * SECOND);
    }
    let swung = bench.seen[0].iter().map(|seen| seen.telemetry.tail.0).fold(0.0_f32, f32::min);
    assert!((swung + 2.0).abs() < 0.1, "it swung: {swung} rad");
    let at_rest = bench.seen[0].len();

    let soon = 400_000_i64;
    let far = ModboatCycle { centerline: Radians(1500.0), ..good };
    let fast_turn = ModboatCycle { rotation: Radians(6.0), transition: Duration(200_000), ..good };
    let not_a_number = ModboatCycle { amplitude: Radians(f32::NAN), ..good };
    for (what, cycle, starts_in_us, of_number, reason) in [
        ("a cycle that was run", good, soon, 1, Refusal::AlreadyRun),
        ("another under the number of the last", good, soon, 2, Refusal::Conflict),
        ("a start in the past", good, -(SECOND as i64), 3, Refusal::Late),
        ("a start in an hour", good, 3600 * SECOND as i64, 10, Refusal::TooFarAhead),
        ("an amplitude of 2.7 rad", swing(2.7, 2.0), soon, 11, Refusal::BeyondLimits),
        ("an amplitude that is no number", not_a_number, soon, 12, Refusal::BeyondLimits),
        ("a centerline of 1500 rad", far, soon, 13, Refusal::BeyondLimits),
        ("a swing at 20 rad/s", swing(1.6, 0.5), soon, 14, Refusal::BeyondLimits),
        ("a turn at 30 rad/s", fast_turn, soon, 15, Refusal::BeyondLimits),
    ] {
        let start = FleetInstant(bench.now().0.saturating_add_signed(starts_in_us));
        bench.dispatch(of_number, start, &[Motion::Modboat(cycle)]);
        let refused = |event: &DispatcherEvent| match event {
            DispatcherEvent::Refused { cycle, reason, .. } if *cycle == of_number => Some(*reason),
            _ => None,
        };
        let events = bench.until("refusal", |_, events| events.iter().any(|event| refused(event).is_some()));
        assert_eq!(events.iter().find_map(refused), Some(reason), "{what}");
        println!("{what}: refused, {reason:?}");
        // Past its start, had it been taken.
        let until = bench.now().0 + SECOND;
        bench.until("a second", |bench, _| bench.now().0 > until);
    }
    let moved =
        bench.seen[0][at_rest..].iter().map(|seen| seen.telemetry.tail.0.abs()).fold(0.0_f32, f32::max);
    assert!(moved < 0.02, "the tail moved by {moved} rad");
    let ran = bench.seen[0].iter().map(|seen| seen.telemetry.cycle).max();
    assert_eq!(ran, Some(2), "no other cycle ever ran");
    let ledger = bench.dispatcher.modules()[0].ledger();
    // No answer is awaited to one whose start has passed.
    assert_eq!(
        (ledger.acknowledged, ledger.late + ledger.unanswered, ledger.refused),
        (2, 1, 8),
        "{ledger:?}"
    );
}
