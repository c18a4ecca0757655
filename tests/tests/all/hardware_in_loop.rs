//! Host, radio, firmware and tank together, with faults: a bad medium, a module that reboots, a motor that jams.

use std::f64::consts::{PI, TAU};

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, RunResult, run};
use host::run::fleet::{Fleet, InProcess};
use host::run::host::Controller;
use host::run::orders::Unattended;
use host::run::pilot::Pilot;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use host::run::summary::Summary;
use link::faults::{FaultCount, FaultParameters};
use modboat::structure::Structure;
use protocol::ModuleState;
use protocol::ledger::{Incoming, Outgoing};
use protocol::time::{Duration, FleetInstant};
use record::{CycleRecord, RunRecord};
use sim::module::TICK;
use tests::checker::{Modboat, check, check_without};
use tests::convert::of_cycle;
use tests::execution::planned_motion::share_turned;

fn scenario() -> Scenario {
    Scenario::open("holonomic-1").expect("built in")
}

/// A fault hook: at every tick, with time since the start of the first cycle, s, and the modules.
type Hook<'a> = &'a mut dyn FnMut(FleetInstant, f64, &mut InProcess);

/// Runs with a fault hook; also what is left of the fleet.
fn run_with(scenario: &Scenario, seed: u64, hook: Hook<'_>) -> (RunResult, InProcess) {
    let mut fleet = InProcess::boats(scenario, seed).expect("a fleet");
    let mut at = |now: FleetInstant, pilot: &Pilot, fleet: &mut InProcess| {
        let t_s = pilot.origin().map_or(-1.0, |origin| now.as_secs_f64() - origin.as_secs_f64());
        hook(now, t_s, fleet);
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut at };
    let result = run(scenario, seed, &mut fleet, drive, &mut Quiet);
    (result.unwrap_or_else(|error| panic!("seed {seed}: {error}")), fleet)
}

fn undisturbed(scenario: &Scenario, seed: u64) -> (RunResult, InProcess) {
    run_with(scenario, seed, &mut |_, _, _| {})
}

/// Where a tail should be by the cycles alone: a turn from rest to rest, then the cosine, then rest until the next cycle. Nothing
/// is known after the last: a cycle that the end of the run cuts short is not on record.
fn reference_rad(cycles: &[CycleRecord], module: usize, t_s: f64) -> Option<f64> {
    let index = cycles.iter().rposition(|cycle| cycle.start_s <= t_s)?;
    let cycle = &cycles[index];
    if index + 1 == cycles.len() && t_s > cycle.start_s + cycle.transition_s + cycle.period_s {
        return None;
    }
    let (turn, swing) = (cycle.turns[module], cycle.swings[module]);
    let since_s = t_s - cycle.start_s;
    if let Some(via) = cycle.via.as_ref().filter(|_| since_s < cycle.transition_s) {
        let second_s = since_s - via.turning_s - via.rest_s;
        let (via_rad, length_s) = (via.via_rad[module], cycle.transition_s - via.turning_s - via.rest_s);
        return Some(if second_s < 0.0 {
            let share = share_turned(since_s.min(via.turning_s), via.turning_s, cycle.ramps_s[0]);
            turn.from_rad + share * (via_rad - turn.from_rad)
        } else {
            via_rad + share_turned(second_s, length_s, cycle.ramps_s[1]) * (turn.to_rad - via_rad)
        });
    }
    if since_s < cycle.transition_s {
        let share = share_turned(since_s, cycle.transition_s, cycle.ramps_s[0]);
        return Some(turn.from_rad + share * (turn.to_rad - turn.from_rad));
    }
    let swum_s = (since_s - cycle.transition_s).min(cycle.period_s);
    Some(turn.to_rad + swing.amplitude_rad * ((TAU * swum_s / cycle.period_s).cos() - 1.0))
}

/// Tail errors of one module, rad, with their times, s; whole turns do not count.
fn tail_errors(record: &RunRecord, module: usize) -> Vec<(f64, f64)> {
    let error = |(t_s, actual_rad): (f64, f64)| {
        let apart = (actual_rad - reference_rad(&record.cycles, module, t_s)?).rem_euclid(TAU);
        Some((t_s, if apart > PI { apart - TAU } else { apart }))
    };
    record.tails.iter().filter_map(|sample| error((sample.t_s, sample.actual_rad[module]))).collect()
}

fn rms(errors: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = errors.into_iter().fold((0.0, 0.0), |(sum, n), e: f64| (sum + e * e, n + 1.0));
    f64::sqrt(sum / count)
}

/// Twice what was seen: 0.01 % on the worst medium, 0.05 % with a pause for a module that came back.
const ON_TIME: f64 = 1.7e-3;
const WITH_A_PAUSE: f64 = 3e-3;

/// What every run must keep, however bad the medium; velocities within this share of what is demanded.
#[track_caller]
fn follows_its_demand(summary: &Summary, velocity: f64) {
    assert!(summary.complete, "ended after {} s", summary.duration_s);
    for leg in &summary.legs {
        assert!(leg.velocity_error <= velocity, "velocity off by {}", leg.velocity_error);
        assert!(leg.heading_rms_rad <= 0.0046, "heading RMS {} rad", leg.heading_rms_rad);
    }
}

/// Every count of the ledgers against the others and against what the medium did, in a run without reboots and
/// forgeries, which ended at `end`.
#[track_caller]
fn ledgers_balance(result: &RunResult, fleet: &mut InProcess, end: FleetInstant) {
    let summary = &result.summary;
    let host: FaultCount = fleet.radio().count();
    let radios = fleet.modules_mut().iter().map(|module| module.radio().count());
    let modules = radios.fold(FaultCount::default(), |sum, count| sum + count);
    assert!(host.is_balanced() && modules.is_balanced(), "{host:?}, {modules:?}");
    assert_eq!(summary.faults, Some(host + modules));

    // What the host sent is what its radio took; what it received is what the modules' radios gave.
    assert_eq!(summary.link.iter().map(|link| link.to_module.sent).sum::<u64>(), host.sent);
    let received = summary.link.iter().map(|link| &link.from_module).chain([&summary.strays]);
    assert_eq!(received.map(|counts| u64::from(counts.received)).sum::<u64>(), modules.delivered);
    let said = fleet.modules_mut().iter().map(|module| {
        let link = module.link().expect("it has power");
        (link.announced(), link.outgoing())
    });
    let said: Vec<(u64, Outgoing)> = said.collect();
    assert_eq!(said.iter().map(|(announced, out)| announced + out.sent).sum::<u64>(), modules.sent);

    // One tick more, and the modules have received what the host's radio gave; the host hears no more.
    fleet.advance(end.after(TICK)).expect("a loopback");
    let incoming = fleet.modules_mut().iter().map(|module| *module.link().expect("it has power").incoming());
    let incoming: Vec<Incoming> = incoming.collect();
    assert_eq!(incoming.iter().map(|counts| u64::from(counts.received)).sum::<u64>(), host.delivered);

    let ways = [("to the modules", host), ("to the host", modules)];
    let came = [incoming.clone(), summary.link.iter().map(|link| link.from_module).collect()];
    let strays = [0, summary.strays.corrupt];
    for (((way, medium), came), strays) in ways.iter().zip(&came).zip(strays) {
        let sum = |of: fn(&Incoming) -> u32| -> u64 { came.iter().map(|counts| u64::from(of(counts))).sum() };
        assert!(came.iter().all(Incoming::is_exact), "{way}: {came:?}");
        assert_eq!((sum(|i| i.forged), sum(|i| i.foreign)), (0, 0), "{way}");
        // One flipped bit is always found out.
        let undetected = medium.corrupted.checked_sub(sum(|i| i.corrupt) + u64::from(strays));
        assert!(undetected.is_some_and(|count| count <= medium.under_way), "{way}: {medium:?}, {came:?}");
        // What did not come was lost, or damaged, or is under way still; an announcement may have come when it was
        // used up.
        let (accepted, stale) = (sum(|i| i.accepted), sum(|i| i.stale));
        let missing = medium.sent - accepted;
        let most = medium.lost + medium.corrupted + medium.under_way + stale;
        assert!((medium.lost..=most).contains(&missing), "{way}: {missing} missing, {medium:?}");
        // What was doubled came twice, unless one of the two was damaged.
        let again = sum(|i| i.duplicate) + stale;
        let once = medium.duplicated.checked_sub(again);
        assert!(once.is_some_and(|n| n <= medium.corrupted + medium.under_way), "{way}: {again}, {medium:?}");
    }

    for ((link, incoming), (announced, out)) in summary.link.iter().zip(&incoming).zip(&said) {
        let l = &link.ledger;
        let open = l.cycles.checked_sub(l.acknowledged + l.late + l.refused + l.unanswered);
        assert!(open.is_some_and(|open| open <= 1), "module {}: {l:?}", link.module);
        // When the run ends, one cycle may be under way and two wait for their starts.
        let total = summary.cycles.total as u64;
        assert!((total..=total + 3).contains(&l.cycles), "module {}: {l:?}, {total} cycles", link.module);
        assert!(link.to_module.sent >= l.cycles + l.resent, "module {}: {l:?}", link.module);
        assert_eq!((link.boots, link.sessions), (1, 1), "module {}", link.module);
        // Each side is told of what came to the other, but for what came since the last word.
        let theirs = [u64::from(incoming.accepted), u64::from(link.from_module.accepted)];
        for (told, (accepted, announced)) in
            [link.to_module, *out].iter().zip(theirs.iter().zip([0, *announced]))
        {
            assert_eq!(told.sent, told.acknowledged + told.late + told.lost + told.under_way());
            assert!(
                told.acknowledged + told.late <= *accepted,
                "module {}: {told:?}, {accepted}",
                link.module
            );
            assert!(told.under_way() <= 400, "module {}: {told:?}", link.module);
            let unheard = accepted - told.acknowledged - told.late;
            assert!(
                unheard <= told.under_way() + announced + 5,
                "module {}: {told:?}, {accepted}",
                link.module
            );
        }
        let last_word = link.module_received.expect("it is said once a second");
        assert!(last_word.is_exact() && last_word.received <= incoming.received, "{last_word:?}");
    }
}

#[test]
fn table_a_bad_medium_changes_nothing_that_matters() {
    let mut table = String::new();
    table += "one run of experiment 1 over a bad medium\n";
    table += "loss  dup  corrupt jitter | datagrams lost  doubled damaged | resent unanswered | tail RMS rad | velocity % | held | clearance mm\n";
    for (loss, duplication, corruption, jitter_s) in
        [(0.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.0), (0.3, 0.0, 0.0, 0.0), (0.3, 0.2, 0.01, 0.03)]
    {
        let mut scenario = scenario();
        scenario.radio = FaultParameters { loss, duplication, corruption, jitter_s, ..Default::default() };
        let mut end = FleetInstant(0);
        let (result, mut fleet) = run_with(&scenario, 7, &mut |now, _, _| end = now);
        let (summary, faults) = (&result.summary, result.summary.faults.expect("in process"));
        let errors = |module| tail_errors(&result.record, module).into_iter().map(|(_, e)| e);
        let worst_rms = (0..3).map(|module| rms(errors(module))).fold(0.0, f64::max);
        table += &format!(
            "{:>3.0} % {:>3.0} % {:>4.0} % {:>3.0} ms | {:>9} {:>5} {:>7} {:>7} | {:>6} {:>10} | {worst_rms:>12.4} | {:>10.2} | {:>4} | {:>6.2}\n",
            100.0 * loss,
            100.0 * duplication,
            100.0 * corruption,
            1e3 * jitter_s,
            faults.sent,
            faults.lost,
            faults.duplicated,
            faults.corrupted,
            summary.link.iter().map(|link| link.ledger.resent).sum::<u64>(),
            summary.link.iter().map(|link| link.ledger.unanswered).sum::<u64>(),
            100.0 * summary.legs[0].velocity_error,
            summary.cycles.held,
            1e3 * summary.least_clearance_m.expect("neighbours"),
        );
        ledgers_balance(&result, &mut fleet, end);
        follows_its_demand(summary, ON_TIME);
        assert!(summary.contacts.is_empty(), "{:?}", summary.contacts);
        assert!(summary.cycles.planned == summary.cycles.total, "{:?}", summary.cycles);
        // Every module executed every cycle: no tail was ever elsewhere than the cycles say.
        for module in 0..3 {
            let all = tail_errors(&result.record, module);
            for cycle in &result.record.cycles {
                let end_s = cycle.start_s + cycle.transition_s + cycle.period_s;
                let within = || all.iter().filter(|(t_s, _)| (cycle.start_s..end_s).contains(t_s));
                // 1.5 s at 50 Hz, at least.
                assert!(within().count() >= 70, "cycle {}: {} samples", cycle.number, within().count());
                let rms = rms(within().map(|&(_, e)| e));
                assert!(rms <= 0.009, "module {}, cycle {}: RMS {rms} rad", module + 1, cycle.number);
            }
        }
        // The medium was as bad as it was told to be: within five standard deviations.
        let near = |count: u64, of: u64, share: f64| {
            let (expected, of) = (share * of as f64, of as f64);
            (count as f64 - expected).abs() <= 5.0 * (of * share * (1.0 - share)).sqrt()
        };
        let kept = faults.sent - faults.lost;
        assert!(near(faults.lost, faults.sent, loss), "{faults:?}");
        assert!(near(faults.duplicated, kept, duplication), "{faults:?}");
        assert!(near(faults.corrupted, kept + faults.duplicated, corruption), "{faults:?}");
    }
    // In one piece, whatever else is printed meanwhile.
    print!("{table}");
}

#[test]
fn tails_follow_their_cycles() {
    let (result, _) = undisturbed(&scenario(), 3);
    for module in 0..3 {
        let errors: Vec<f64> = tail_errors(&result.record, module).into_iter().map(|(_, e)| e).collect();
        let (rms, most) = (rms(errors.iter().copied()), errors.iter().fold(0.0, |m: f64, e| m.max(e.abs())));
        println!("module {}: {} samples, RMS {rms:.4} rad, at most {most:.4} rad", module + 1, errors.len());
        // 90 s at 50 Hz, less a cycle that is cut short.
        assert!(
            errors.len() > 4300 && rms <= 0.007 && most <= 0.0125,
            "module {}: RMS {rms} rad",
            module + 1
        );
    }
}

#[test]
fn a_jammed_motor_stops_its_module_and_is_not_hidden() {
    let jam_s = 30.0;
    let mut end = FleetInstant(0);
    let (result, mut fleet) = run_with(&scenario(), 3, &mut |now, t_s, fleet| {
        end = now;
        if t_s >= jam_s {
            fleet.modules_mut()[0].motor_mut().set_jammed(true);
        }
    });
    let (summary, record) = (&result.summary, &result.record);
    // Two swings are enough to notice; no module begins a cycle afterwards.
    let noticed_s = jam_s + 2.0 * 2.0 + 0.5;
    let last = record.cycles.last().expect("cycles");
    println!("jammed at {jam_s} s; the last cycle begins at {:.2} s; {:?}", last.start_s, summary.failure);
    assert!((jam_s - 2.0..noticed_s).contains(&last.start_s), "{} s", last.start_s);
    let states: Vec<_> = fleet.modules_mut().iter().map(|module| module.state(end)).collect();
    let (stopped, holding) = (Some(ModuleState::Stopped), Some(ModuleState::Holding));
    assert_eq!(states, [stopped, holding, holding]);
    let faults: Vec<_> = summary.link.iter().map(|link| link.faults.clone()).collect();
    assert_eq!(faults, [vec!["motor stalled"], vec![], vec![]]);
    let failure = summary.failure.as_deref().expect("the fleet holds for good");
    let tells = failure.contains("tail contacts") || failure.ends_with("module 1 has stopped: motor stalled");
    assert!(tells && !summary.complete, "{failure}");
    // Until then it is off its planned motion, and the others are on theirs.
    let within = |module, from_s: f64, to_s: f64| {
        let errors = tail_errors(record, module).into_iter();
        rms(errors.filter(|(t_s, _)| (from_s..to_s).contains(t_s)).map(|(_, e)| e))
    };
    let end_s = last.start_s + last.transition_s + last.period_s;
    let (jammed, free) = (within(0, jam_s + 0.5, end_s), within(1, jam_s + 0.5, end_s));
    println!("tail RMS after the jam: {jammed:.3} rad at module 1, {free:.4} rad at module 2");
    // A tail that is jammed lies off its swing, of at least 0.9 rad to each side, by more than half of that.
    assert!(jammed > 0.5 && free < 0.004, "{jammed} and {free} rad");
    assert!(within(0, 0.0, jam_s) < 0.007);
}

/// The cycle that starts first after `from_s` for which `fit` holds, in an undisturbed run.
fn cycle_after(record: &RunRecord, from_s: f64, fit: impl Fn(&CycleRecord) -> bool) -> CycleRecord {
    let mut later = record.cycles.iter().filter(|cycle| cycle.start_s > from_s);
    later.find(|cycle| fit(cycle)).expect("such a cycle").clone()
}

/// Whether the others stay clear of `module` if it alone misses `cycle`.
fn may_miss(record: &RunRecord, cycle: &CycleRecord, module: usize) -> bool {
    let (request, answer) = of_cycle(record, cycle);
    check_without(&Modboat::default(), &request, &answer, &[module]).is_ok()
}

/// The longest pause between the end of one cycle and the start of the next, s, and how many there are.
fn pauses(record: &RunRecord) -> (f64, usize) {
    let ended_s = |cycle: &CycleRecord| cycle.start_s + cycle.transition_s + cycle.period_s;
    let pauses = record.cycles.windows(2).map(|two| two[1].start_s - ended_s(&two[0]));
    let long: Vec<f64> = pauses.filter(|pause| *pause > 1e-3).collect();
    (long.iter().copied().fold(0.0, f64::max), long.len())
}

/// Reboots module 2 at `reboot_s` in a run like the one before.
fn rebooted(scenario: &Scenario, seed: u64, reboot_s: f64) -> RunResult {
    let mut done = false;
    let (result, _) = run_with(scenario, seed, &mut |now, t_s, fleet| {
        if t_s >= reboot_s && !done {
            fleet.modules_mut()[1].reboot(now, Duration(200_000));
            done = true;
        }
    });
    assert!(done);
    result
}

#[test]
fn a_module_that_reboots_between_cycles_is_taken_in_again() {
    let (scenario, seed) = (scenario(), 11);
    // The same run undisturbed says when cycles start, and which of them module 2 may miss.
    let (before, _) = undisturbed(&scenario, seed);
    assert_eq!(pauses(&before.record).1, 0);
    let cycle = cycle_after(&before.record, 10.0, |cycle| may_miss(&before.record, cycle, 1));
    let result = rebooted(&scenario, seed, cycle.start_s - 2e-3);
    let (pause_s, count) = pauses(&result.record);
    println!(
        "reboot at {:.2} s: {count} pause of {pause_s:.2} s, velocity off by {:.2} %, heading RMS {:.4} rad, contacts {:?}",
        cycle.start_s,
        100.0 * result.summary.legs[0].velocity_error,
        result.summary.legs[0].heading_rms_rad,
        result.summary.contacts
    );
    assert_eq!(result.summary.cycles.reboots, 1);
    assert!(count == 1 && pause_s < 0.6, "the fleet holds once, for {pause_s} s");
    follows_its_demand(&result.summary, WITH_A_PAUSE);
    assert!(result.summary.contacts.is_empty(), "{:?}", result.summary.contacts);
    // Module 2 swims with the others to the end.
    let late = tail_errors(&result.record, 1).into_iter().filter(|(t_s, _)| *t_s > 30.0).map(|(_, e)| e);
    assert!(rms(late) < 0.005);
}

#[test]
fn a_module_that_reboots_in_mid_swing_is_taken_in_again() {
    let (scenario, seed) = (scenario(), 12);
    let (before, _) = undisturbed(&scenario, seed);
    let cycle = cycle_after(&before.record, 10.0, |_| true);
    let reboot_s = cycle.start_s + cycle.transition_s + 0.25 * cycle.period_s;
    let result = rebooted(&scenario, seed, reboot_s);
    let (pause_s, count) = pauses(&result.record);
    println!(
        "reboot at {reboot_s:.2} s, in mid-swing: {count} pauses of up to {pause_s:.2} s, velocity off by {:.2} %, contacts {:?}",
        100.0 * result.summary.legs[0].velocity_error,
        result.summary.contacts
    );
    assert_eq!(result.summary.cycles.reboots, 1);
    assert!(count >= 1 && pause_s < 0.6, "{count} pauses of up to {pause_s} s");
    follows_its_demand(&result.summary, WITH_A_PAUSE);
    // A tail that coasts without power may meet another; if it does, the summary says so and the run fails.
    let after = |contact: &host::run::summary::ContactFigures| contact.t_s >= reboot_s - 1e-3;
    assert!(result.summary.contacts.iter().all(after), "{:?}", result.summary.contacts);
    assert_eq!(result.summary.passed(), result.summary.contacts.is_empty());
    assert_eq!(
        result.summary.least_clearance_m.is_some_and(|least_m| least_m < 0.0),
        !result.summary.contacts.is_empty()
    );
}

#[test]
fn a_module_that_falls_silent_ends_the_run_and_not_what_was_measured() {
    let mut scenario = scenario();
    scenario.timing.join_s = 3.0;
    let mut gone = false;
    let (result, _) = run_with(&scenario, 1, &mut |now, t_s, fleet| {
        if !gone && t_s >= 30.0 {
            gone = true;
            fleet.modules_mut()[1].reboot(now, Duration(u32::MAX));
        }
    });
    let failure = result.summary.failure.as_deref().expect("it failed");
    // A contact is the graver news; otherwise the message names the missing module.
    assert!(failure.contains("tail contacts") || failure.contains("module 2 did not answer"), "{failure}");
    assert!((30.0..40.0).contains(&result.summary.duration_s), "{}", result.summary.duration_s);
    assert!(result.record.cycles.len() >= 14 && !result.summary.complete);
}

#[test]
fn twenty_five_modules_swim_without_a_touch() {
    let mut scenario = scenario();
    scenario.structure = Structure::from_word("5x5").expect("a square");
    scenario.legs[0].duration_s = 40.0;
    let (result, _) = undisturbed(&scenario, 4);
    let (summary, record) = (&result.summary, &result.record);
    println!(
        "5 x 5: least clearance {:.2} mm in the tank, {:.2} mm as planned; {:?}",
        1e3 * summary.least_clearance_m.expect("neighbours"),
        1e3 * record.cycles.iter().map(|cycle| cycle.clearance_m).fold(f64::INFINITY, f64::min),
        summary.cycles
    );
    assert!(summary.complete && summary.contacts.is_empty(), "{:?}", summary.contacts);
    assert_eq!(summary.cycles.planned, summary.cycles.total);
    for cycle in &record.cycles {
        let (request, answer) = of_cycle(record, cycle);
        if let Err(broken) = check(&Modboat::default(), &request, &answer) {
            panic!("cycle {}: {broken}", cycle.number);
        }
    }
}

/// Without what the machine's speed decides.
fn timeless(mut summary: Summary) -> Summary {
    summary.wall_s = 0.0;
    (summary.cycles.solve_us_median, summary.cycles.solve_us_max) = (0, 0);
    summary
}

#[test]
fn a_seed_is_a_run() {
    let mut scenario = scenario();
    scenario.legs[0].duration_s = 30.0;
    scenario.radio = FaultParameters { loss: 0.1, jitter_s: 0.01, ..Default::default() };
    let summary = |seed| timeless(undisturbed(&scenario, seed).0.summary);
    let first = summary(5);
    assert_eq!(first, summary(5));
    let mut other = summary(6);
    other.seed = 5;
    assert_ne!(first, other);
}
