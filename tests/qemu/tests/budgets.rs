//! What the firmware takes of a processor: instructions, stack, and how late a tick is. Instructions are counted by the emulator, so the
//! figures are the same on every machine; `firmware/boards/costs.md` has them.

use std::time::Duration;

use host::link::identity::HostIdentity;
use protocol::units::MicrosSpan;
use protocol::{Configuration, ModuleId};
use qemu::emulator::{Emulator, Setup, free_port};
use qemu::report::Report;
use qemu::{kept, provisioned, storm};

const SEED: u64 = 1;

/// Instructions of a tick on average, at most: 10 µs at 150 MHz.
const TICK_MAX: u64 = 1_500;

/// Differences to the table that other versions of the compiler may make.
const TOLERANCE: f64 = 0.1;

/// What is counted, in the words of the table.
const COSTS: [(&str, &str); 8] = [
    ("tick", "a tick: encoder, servo, bridge, failsafe, link"),
    ("cycle", "a datagram with a cycle: opened, checked, scheduled"),
    ("duplicate", "the same again"),
    ("time-reply", "an exchange of clocks"),
    ("call", "a host's call: keys of a session"),
    ("damaged", "a damaged datagram"),
    ("forged", "a forged one"),
    ("sent", "a datagram sealed to be sent"),
];

fn configuration() -> Configuration {
    let host = HostIdentity::simulated(SEED, 0);
    // Reports as often as `flotilla provision` has them.
    Configuration { report_every: MicrosSpan(20_000), ..provisioned::modboat(&host, ModuleId(1), 4870) }
}

/// One count: how often, and instructions at least, on average and at most.
type Count = [u64; 4];

fn measured() -> Vec<Count> {
    let configuration = provisioned::image(&configuration());
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
    let costs = measured();
    let [_, _, mean, _] = costs[0];
    assert!(mean <= TICK_MAX, "a tick takes {mean} instructions, at most {TICK_MAX} are meant");
    for ((_, words), cost) in COSTS.iter().zip(&costs) {
        kept::compare(words, cost, TOLERANCE);
    }
}

/// On a processor of 31 million instructions a second, a fifth of a board's, whatever the PC does: here the emulator's time goes on
/// with its instructions alone. It has less time for its network then, and loses some of the storm before the firmware can.
#[test]
fn a_slow_processor_ticks_on_time_in_a_storm() {
    const STORM: u32 = 20_000;
    const STORM_HZ: f64 = 2_000.0;
    let host = HostIdentity::simulated(SEED, 0);
    let (outside, inside) = (free_port(), 4870);
    let image = provisioned::image(&configuration());
    let mut emulator = Emulator::start(&Setup {
        image: "qemu.elf",
        configuration: &image,
        forward: Some((outside, inside)),
        word: "awake",
        arguments: &["-icount", "shift=5"],
        ..Setup::default()
    });
    let next = |emulator: &mut Emulator| emulator.await_line("report", Report::read);
    // Of the first second it is not asked: the network comes up.
    let (_, before) = (next(&mut emulator), next(&mut emulator));
    let to = emulator.address.expect("it is forwarded");
    let sender = storm::start(&host, ModuleId(1), to, STORM, STORM_HZ, SEED);
    let (mut latest_us, mut longest_us, mut after) = (0, 0, before.clone());
    while !sender.is_finished() {
        after = next(&mut emulator);
        latest_us = latest_us.max(after.number("late"));
        longest_us = longest_us.max(after.number("turn_us"));
    }
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(sender.join().expect("it sent"), STORM);
    let during = |name: &str| after.number(name) - before.number(name);
    println!(
        "{STORM} datagrams at 31 MIPS: {} reached the firmware in {} ticks; {} missed, the latest {latest_us} µs late; longest turn of \
         the loop {longest_us} µs; stack {} bytes",
        during("corrupt"),
        during("tick"),
        during("missed") + during("stalled"),
        after.number("stack")
    );
    assert!(during("corrupt") >= u64::from(STORM) / 4, "{after:?}");
    assert_eq!((during("missed"), during("stalled")), (0, 0), "{after:?}");
    // Whether one comes just before a tick is luck: half of it more or less is the same.
    kept::compare(
        "latest tick in a storm of datagrams, at 31 million instructions a second",
        &[latest_us],
        0.5,
    );
}
