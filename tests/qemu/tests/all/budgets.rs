//! What the firmware takes of a processor: instructions, stack, and how late a tick is. Instructions are counted by the emulator, so the
//! figures are the same on every machine; `firmware/boards/costs.md` has them.

use std::net::UdpSocket;

use link::identity::HostIdentity;
use protocol::time::Duration;
use protocol::{Configuration, ModuleId};
use qemu::emulator::{Emulator, Setup};
use qemu::stepped::{Stepped, Steps};
use qemu::storm::Storm;
use qemu::{kept, provisioned};

const SEED: u64 = 1;

/// Instructions of any tick, at most: 10 µs at 150 MHz.
const TICK_MAX: u64 = 1_500;

/// Differences to the table that other versions of the compiler may make.
const TOLERANCE: f64 = 0.1;

/// What is counted, in the words of the table.
const COSTS: [(&str, &str); 10] = [
    ("tick", "a tick: encoder, servo, bridge, failsafe, link"),
    ("cycle", "a datagram with a cycle: opened, checked, scheduled"),
    ("duplicate", "the same again"),
    ("time-reply", "an exchange of clocks"),
    ("call", "a host's call: keys of a session"),
    ("damaged", "a damaged datagram"),
    ("forged", "a forged one"),
    ("forged-call", "a forged call that is looked at, a few for each announcement"),
    ("foreign-call", "a forged call while a host is heard"),
    ("sent", "a datagram sealed to be sent"),
];

/// An encoder that counts and has an index, for which the module looks by itself: its zero is there, as the measured cycles set out from zero.
const COUNTING: &str = "counts_per_turn = 4800\nhoming_speed_rad_s = 0.9\nhoming_after_s = 0.5";

/// With these lines of `[modboat.encoder]`, or an absolute encoder.
fn configuration(encoder: Option<&str>) -> Configuration {
    let host = HostIdentity::simulated(SEED, 0);
    // Reports as often as `flotilla provision` has them.
    let usual = provisioned::modboat_with(&host, ModuleId(1), 4870, encoder);
    Configuration { report_every: Duration(20_000), ..usual }
}

/// One count: how often, and instructions at least, on average and at most.
type Count = [u64; 4];

fn measured(encoder: Option<&str>) -> Vec<Count> {
    let configuration = provisioned::image(&configuration(encoder));
    let arguments = ["-icount", "shift=10,sleep=off"];
    let emulator = Emulator::start(&Setup {
        image: "measure.elf",
        configuration: &configuration,
        arguments: &arguments,
        ..Setup::default()
    });
    let (status, lines) = emulator.wait();
    assert!(status.success(), "{status}: {lines:?}");
    let of = |what: &str| {
        let line = lines.iter().find(|line| line.starts_with(&format!("cost {what} ")));
        let words: Vec<&str> = line.unwrap_or_else(|| panic!("no {what}: {lines:?}")).split(' ').collect();
        [3, 5, 7, 9].map(|place| words[place].parse().expect("a number"))
    };
    COSTS.iter().map(|(what, _)| of(what)).collect()
}

#[test]
fn the_core_takes_what_the_table_says() {
    let costs = measured(None);
    let counting = measured(Some(COUNTING))[0];
    for [_, _, _, most] in [costs[0], counting] {
        assert!(most <= TICK_MAX, "a tick takes {most} instructions, at most {TICK_MAX} are meant");
    }
    for ((_, words), cost) in COSTS.iter().zip(&costs) {
        kept::compare(words, cost, TOLERANCE);
    }
    kept::compare("a tick with an encoder that counts and has an index", &counting, TOLERANCE);
}

/// On a processor of 31 million instructions a second, a fifth of a board's. A step is no whole part of a tick, so that datagrams come at
/// every moment between two ticks.
#[test]
fn a_slow_processor_ticks_on_time_in_a_storm() {
    const STORM: usize = 20_000;
    const EACH_STEP: usize = 2;
    let host = HostIdentity::simulated(SEED, 0);
    let image = provisioned::image(&configuration(None));
    let steps = Steps { length: Duration(970), shift: 5, seed: SEED, words: &[] };
    let mut module = Stepped::start(&image, 4870, steps);
    // Of the first second it is not asked: the network comes up.
    let (_, before) = (module.next_report(), module.next_report());
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a free port");
    let mut storm = Storm::new(&host, ModuleId(1), SEED).take(STORM).peekable();
    while storm.peek().is_some() {
        for datagram in storm.by_ref().take(EACH_STEP) {
            socket.send_to(&datagram, module.address).expect("a socket");
            module.put();
        }
        module.go();
        module.stand();
    }
    let after = module.next_report();
    let reports = module.emulator.reports();
    let most = |name: &str| reports[2..].iter().map(|report| report.number(name)).max().expect("reports");
    let (latest_us, longest_us) = (most("late"), most("turn_us"));
    let during = |name: &str| after.number(name) - before.number(name);
    println!(
        "{STORM} datagrams at 31 MIPS: {} reached the firmware in {} ticks; {} missed, the latest {latest_us} µs late; longest turn of \
         the loop {longest_us} µs; stack {} bytes",
        during("corrupt"),
        during("tick"),
        during("missed") + during("stalled"),
        after.number("stack")
    );
    assert_eq!(during("corrupt"), STORM as u64, "{after:?}");
    assert_eq!((during("missed"), during("stalled")), (0, 0), "{after:?}");
    kept::compare(
        "latest tick in a storm of datagrams, at 31 million instructions a second",
        &[latest_us],
        TOLERANCE,
    );
}
