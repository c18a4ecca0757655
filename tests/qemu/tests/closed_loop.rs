//! Whole runs with emulated modules: the host plans, dispatches and observes as in `flotilla run --radio udp`, while things go wrong.

use std::sync::atomic::AtomicBool;

use host::run::experiment::{Pace, Quiet, RunResult, run};
use host::run::fleet::Fleet;
use host::run::scenario::Scenario;
use protocol::ModuleId;
use protocol::units::Micros;
use qemu::fleet::Emulated;
use qemu::report::Report;
use qemu::storm;

const SEED: u64 = 1;

/// Datagrams of the storm, and how many a second.
const STORM: u32 = 100_000;
const STORM_HZ: f64 = 5_000.0;

/// Three modules in a row go sideways, as in experiment 1; one alone goes where it can.
fn scenario(size: &str, duration_s: u32) -> Scenario {
    let velocity = if size == "1x1" { "[0.0, 0.02]" } else { "[0.04, 0.0]" };
    let text = format!(
        "name = \"emulated\"\ndescription = \"Experiment 1, shortened\"\n[structure]\nsize = \"{size}\"\n[[leg]]\n\
         duration_s = {duration_s}.0\nvelocity_m_s = {velocity}\nheading_rad = 1.5707963267948966\n"
    );
    Scenario::parse("emulated.toml", &text).expect("a scenario")
}

/// Runs it; `drill` gets the seconds since the first cycle began.
fn swim(scenario: &Scenario, fleet: &mut Emulated, mut drill: impl FnMut(f64, &mut Emulated)) -> RunResult {
    let stop = AtomicBool::new(false);
    let mut with_time = |now: Micros, origin: Option<Micros>, fleet: &mut Emulated| {
        if let Some(origin) = origin.filter(|origin| *origin <= now) {
            drill((now.0 - origin.0) as f64 * 1e-6, fleet);
        }
    };
    run(scenario, SEED, fleet, Pace::Real, &mut Quiet, &stop, &mut with_time).expect("a run")
}

/// What every run here must come to.
fn assert_well(result: &RunResult, duration_s: u32) {
    let summary = &result.summary;
    assert!(summary.complete, "{summary:?}");
    assert!(summary.cycles.total as f64 >= 0.55 * f64::from(duration_s), "swam hardly: {summary:?}");
    let ([vx, vy], [wx, wy]) = (summary.legs[0].mean_m_s, summary.legs[0].demand_m_s);
    assert!((vx - wx).hypot(vy - wy) < 0.01, "asked for {wx}, {wy} m/s: {vx}, {vy}");
    for link in &summary.link {
        // One that has just come back may not be sure of the time yet, and says so.
        let refused = if link.boots > 1 { 0..=2 } else { 0..=0 };
        assert!(refused.contains(&link.ledger.refused) && link.ledger.late == 0, "{link:?}");
        assert!(link.faults.is_empty(), "{link:?}");
        let received = link.module_received.expect("its health");
        assert!(received.is_exact() && link.from_module.is_exact(), "{link:?}");
    }
}

#[test]
fn a_module_that_is_killed_and_started_again_swims_on() {
    let scenario = scenario("3x1", 20);
    let mut fleet = Emulated::start(&scenario, SEED);
    let mut lives = 1;
    let result = swim(&scenario, &mut fleet, |t_s, fleet| {
        if lives == 1 && t_s > 5.0 {
            fleet.modules[2].kill();
            lives = 0;
        }
        if lives == 0 && t_s > 6.5 {
            fleet.restart(2);
            lives = 2;
        }
    });
    assert_eq!(lives, 2);
    assert_well(&result, 20);
    let summary = &result.summary;
    assert!(summary.cycles.reboots >= 1, "{summary:?}");
    let boots: Vec<u32> = summary.link.iter().map(|link| link.boots).collect();
    assert_eq!(boots, [1, 1, 2]);
    // It swims again: the last reports of all three are of the same cycle.
    let last: Vec<u32> =
        fleet.seen.iter().map(|seen| seen.last().expect("reports").telemetry.cycle).collect();
    assert!(last.iter().all(|cycle| *cycle == last[0] && *cycle > 8), "{last:?}");
    // Its tail stops in mid-swing, and the emulator's new motor begins at zero: whether two tails met is luck, and told.
    println!(
        "{} cycles, {} contacts, velocity off by {:.1} %; the third module ran {} of {} cycles",
        summary.cycles.total,
        summary.contacts.len(),
        100.0 * summary.legs[0].velocity_error,
        summary.link[2].ledger.acknowledged,
        summary.link[0].ledger.acknowledged
    );
}

/// What the storm did to the module that it was for.
struct Stormy {
    sent: u32,
    before: Report,
    after: Report,
    result: RunResult,
}

fn swim_through_a_storm() -> Stormy {
    let duration_s = 4 + (f64::from(STORM) / STORM_HZ) as u32 + 4;
    let scenario = scenario("1x1", duration_s);
    let mut fleet = Emulated::start(&scenario, SEED);
    let mut storm = None;
    let result = swim(&scenario, &mut fleet, |t_s, fleet| {
        if storm.is_none() && t_s > 4.0 {
            let before = fleet.modules[0].reports().pop().expect("reports");
            let to = fleet.modules[0].address.expect("it is forwarded");
            let sender = storm::start(fleet.host(), ModuleId(1), to, STORM, STORM_HZ, SEED);
            storm = Some((before, sender));
        }
    });
    let (before, sender) = storm.expect("it swam");
    let sent = sender.join().expect("it sent");
    let after = fleet.modules[0].reports().pop().expect("reports");
    Stormy { sent, before, after, result }
}

/// On a machine that gives the emulator no processor for a while, a turn of the control loop takes as long as that: such a run says
/// nothing about ticks, and is repeated. (Where time goes on with instructions alone, `budgets.rs` has the ticks on time.)
#[test]
fn a_storm_at_a_swimming_module_changes_nothing() {
    for attempt in 1..=5 {
        let Stormy { sent, before, after, result } = swim_through_a_storm();
        assert_well(&result, result.summary.planned_s as u32);
        let summary = &result.summary;
        assert!(summary.contacts.is_empty(), "{:?}", summary.contacts);
        assert!(summary.cycles.reboots == 0 && summary.cycles.held == 0, "{summary:?}");
        for link in &summary.link {
            assert_eq!((link.boots, link.sessions, link.ledger.unanswered), (1, 1, 0), "{link:?}");
        }
        let during = |name: &str| after.number(name) - before.number(name);
        println!(
            "{sent} datagrams in {:.0} s: {} reached the firmware, {} of them were damaged, {} accepted as from the host; {} ticks, {} \
             missed, {} came late for want of a processor; longest turn of the loop {} µs in the last second",
            f64::from(STORM) / STORM_HZ,
            during("received"),
            during("corrupt"),
            during("accepted"),
            during("tick"),
            during("missed"),
            during("stalled"),
            after.number("turn_us"),
        );
        assert_eq!(sent, STORM);
        // The controller's own buffer overflows now and then, when the emulator is kept from its processor.
        assert!(during("corrupt") >= u64::from(STORM) * 95 / 100, "they came: {after:?}");
        assert!(during("corrupt") <= u64::from(STORM), "{after:?}");
        // What else came is the host's: the storm let nothing in.
        let link = &summary.link[0];
        let received = link.module_received.expect("its health");
        assert!(u64::from(received.accepted) <= link.to_module.sent, "{link:?}");
        for class in ["duplicate", "stale", "forged", "foreign", "faults"] {
            assert_eq!(after.number(class), 0, "{class}: {after:?}");
        }
        if during("missed") == 0 {
            return;
        }
        println!("attempt {attempt}: {} ticks missed", during("missed"));
    }
    panic!("ticks were missed in five runs of five");
}
