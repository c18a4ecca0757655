//! Whole runs with emulated modules: the host plans, dispatches and observes as in `flotilla run --radio udp`, over real sockets and in
//! lock step with the modules, while things go wrong.

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, RunResult, run};
use host::run::fleet::Fleet;
use host::run::host::Controller;
use host::run::orders::Unattended;
use host::run::pilot::Pilot;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use protocol::ModuleId;
use protocol::time::FleetInstant;
use qemu::fleet::Emulated;
use qemu::storm::Storm;

const SEED: u64 = 1;

/// Datagrams of the storm, and how many come in each step of a millisecond: 5,000 a second.
const STORM: u32 = 100_000;
const STORM_STEP: u32 = 5;

/// Three modules in a row go sideways, as in experiment 1; one alone goes where it can.
fn scenario(size: &str, duration_s: u32) -> Scenario {
    let velocity = if size == "1x1" { "[0.0, 0.02]" } else { "[0.04, 0.0]" };
    let text = format!(
        "name = \"emulated\"\ndescription = \"Experiment 1, shortened\"\n[structure]\nsize = \"{size}\"\n[[leg]]\n\
         duration_s = {duration_s}.0\nvelocity_m_s = {velocity}\nheading_rad = 1.5707963267948966\n"
    );
    Scenario::parse("emulated.toml", &text).expect("a scenario")
}

/// Runs it; `hook` gets the seconds since the first cycle began.
fn swim(scenario: &Scenario, fleet: &mut Emulated, mut hook: impl FnMut(f64, &mut Emulated)) -> RunResult {
    let mut with_time = |now: FleetInstant, pilot: &Pilot, fleet: &mut Emulated| {
        if let Some(origin) = pilot.origin().filter(|origin| *origin <= now) {
            hook((now.0 - origin.0) as f64 * 1e-6, fleet);
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut with_time };
    run(scenario, SEED, fleet, drive, &mut Quiet).expect("a run")
}

/// What every run here must come to.
fn assert_well(result: &RunResult, duration_s: u32) {
    let summary = &result.summary;
    assert!(summary.complete, "{summary:?}");
    // With the longest transition a cycle takes 2 s; the last need not be over.
    assert!(summary.cycles.total as f64 >= f64::from(duration_s) / 2.0 - 1.0, "swam hardly: {summary:?}");
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
    // Number of its boot; 0 while it is off.
    let mut boot = 1;
    let result = swim(&scenario, &mut fleet, |t_s, fleet| {
        if boot == 1 && t_s > 5.0 {
            fleet.modules.kill(2);
            boot = 0;
        }
        if boot == 0 && t_s > 6.5 {
            fleet.modules.boot(2);
            boot = 2;
        }
    });
    assert_eq!(boot, 2);
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

#[test]
fn a_storm_at_a_swimming_module_changes_nothing() {
    let duration_s = 4 + STORM / STORM_STEP / 1_000 + 4;
    let scenario = scenario("1x1", duration_s);
    let mut fleet = Emulated::start(&scenario, SEED);
    let mut storm = Storm::new(fleet.host(), ModuleId(1), SEED).take(STORM as usize);
    let result = swim(&scenario, &mut fleet, |t_s, fleet| {
        if t_s > 4.0 {
            storm.by_ref().take(STORM_STEP as usize).for_each(|datagram| fleet.modules.disturb(0, &datagram));
        }
    });
    assert_eq!(storm.count(), 0, "all of it was sent");

    assert_well(&result, duration_s);
    let summary = &result.summary;
    assert!(summary.contacts.is_empty(), "{:?}", summary.contacts);
    assert!(summary.cycles.reboots == 0 && summary.cycles.held == 0, "{summary:?}");
    let link = &summary.link[0];
    assert_eq!((link.boots, link.sessions, link.ledger.unanswered), (1, 1, 0), "{link:?}");

    let module = fleet.modules.module(0);
    let last = module.next_report();
    let (put, received) = module.taken();
    assert_eq!(put, received, "what was put into its network reached it");
    let (reports, number) = (module.emulator.reports(), |name: &str| last.number(name));
    let longest_us = reports.iter().map(|report| report.number("turn_us")).max();
    println!(
        "{STORM} datagrams in {} s: {} reached the firmware with the host's, {} of all were damaged, {} accepted as from the host; {} \
         ticks, {} missed; longest turn of the loop {longest_us:?} µs",
        STORM / STORM_STEP / 1_000,
        number("received"),
        number("corrupt"),
        number("accepted"),
        number("tick"),
        number("missed") + number("stalled"),
    );
    // What else came is the host's: the storm let nothing in, and took nothing away.
    assert_eq!(number("corrupt"), u64::from(STORM), "{last:?}");
    assert_eq!(number("received"), u64::from(put), "{last:?}");
    assert_eq!(number("accepted") + u64::from(STORM), u64::from(put), "{last:?}");
    for name in ["missed", "stalled", "unheard", "duplicate", "stale", "forged", "foreign", "faults"] {
        assert_eq!(number(name), 0, "{name}: {last:?}");
    }
}
