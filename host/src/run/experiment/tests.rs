//! The host is stopped while its fleet swims, by a clock of the test's own: modules live on, and the loop goes on from where time is.

use std::cell::Cell;
use std::time::Duration;

use super::super::clock::Fake;
use super::super::pilot::phase::Phase;
use modboat::motion::Wrench;

use super::*;
use sim::module::TICK;

#[derive(Default)]
struct Notes(Vec<String>);

impl Progress for Notes {
    fn at(&mut self, _t_s: f64, _duration_s: f64) {}

    fn note(&mut self, text: &str) {
        self.0.push(text.to_owned());
    }
}

/// A run whose host is stopped at `at_s` for `length_s`; what it told, and the phases that the pilot was in just before and after.
fn paused(text: &str, seed: u64, at_s: f64, length_s: f64) -> (RunResult, Vec<String>, [Phase; 2]) {
    let scenario = Scenario::parse("t.toml", text).expect("valid");
    let mut fleet = InProcess::boats(&scenario, seed).expect("valid");
    let time = Cell::new(Duration::ZERO);
    let (mut last, mut is_done, mut phases) = (FleetInstant(0), false, [Phase::Finished; 2]);
    let mut hook = |now: FleetInstant, pilot: &Pilot, fleet: &mut InProcess| {
        if now.0 - last.0 > 400_000 {
            phases[1] = pilot.phase();
        }
        // Whatever the host does, modules run on.
        while last.after(TICK) < now {
            last = last.after(TICK);
            fleet.advance(last).expect("a loopback");
        }
        last = now;
        if !is_done && now.as_secs_f64() >= at_s {
            (is_done, phases[0]) = (true, pilot.phase());
            time.set(time.get() + Duration::from_secs_f64(length_s));
        }
    };
    let drive = Drive { pace: Pace::Real, operator: &mut Unattended, hook: &mut hook };
    let clock = Clock::over(Pace::Real, Fake(&time));
    let mut notes = Notes::default();
    let site = Site::simulated(&scenario, seed).expect("valid");
    let result = run_by(clock, Log::default(), &scenario, seed, &mut fleet, drive, site, &mut notes);
    (result.unwrap_or_else(|error| panic!("seed {seed}: {error}")), notes.0, phases)
}

fn scenario(size: &str, duration_s: f64, more: &str) -> String {
    format!(
        "name = \"t\"\n[structure]\nsize = \"{size}\"\n[[leg]]\nduration_s = {duration_s}\nvelocity_m_s = [0.03, 0.01]\n\
         heading_rad = 1.5\n{more}"
    )
}

#[test]
fn a_host_that_was_stopped_goes_on_from_now() {
    for (size, seed, at_s, length_s) in [("3x1", 1, 10.0, 6.0), ("3x1", 2, 10.7, 15.0), ("2x2", 3, 11.3, 0.8)]
    {
        let of = format!("{size}, seed {seed}, stopped at {at_s} s for {length_s} s");
        let (result, notes, phases) = paused(&scenario(size, 90.0, ""), seed, at_s, length_s);
        let RunResult { summary, record, decisions, .. } = result;
        assert_eq!(phases, [Phase::Swimming, Phase::Waiting], "{of}");
        let said = notes.iter().filter(|note| note.starts_with("the host did not run for ")).count();
        assert_eq!(said, 1, "{of}: {notes:?}");
        let [gap] = summary.gaps[..] else { panic!("{of}: {:?}", summary.gaps) };
        // Time zero is the first swim; tails may turn before it.
        let first = decisions.iter().find(|decision| decision.plan.wrench != Wrench::default());
        let zero_s = first.expect("it swims").start.as_secs_f64();
        assert!((gap.start_s + zero_s - at_s).abs() < 0.005, "{of}: {gap:?}");
        assert!((length_s - 0.01..length_s + 0.1).contains(&gap.length_s), "{of}: {gap:?}");

        // Nothing is planned into it, and the fleet swims again after it.
        let end_s = gap.start_s + gap.length_s;
        let starts_s = || decisions.iter().map(|decision| decision.start.as_secs_f64() - zero_s);
        assert!(!starts_s().any(|start_s| (gap.start_s + 0.31..end_s).contains(&start_s)), "{of}");
        let again_s = starts_s().find(|start_s| *start_s >= end_s).expect("it begins again");
        assert!(again_s < end_s + 5.0, "{of}: only at {again_s} s");
        assert!(starts_s().filter(|start_s| *start_s > end_s).count() > 20, "{of}");

        // Nothing was seen in it.
        let within = |t_s: f64| (gap.start_s + 0.002..end_s - 0.002).contains(&t_s);
        assert!(!record.poses.iter().any(|pose| within(pose.t_s)), "{of}");
        assert!(!record.tails.iter().any(|tails| within(tails.t_s)), "{of}");
        assert_eq!(record.gaps.len(), 1, "{of}");
        let overlaps = record.cycles.iter().any(|cycle| {
            cycle.start_s < end_s && gap.start_s < cycle.start_s + cycle.transition_s + cycle.period_s
        });
        assert!(!overlaps, "{of}: a cycle that was not seen is on record");
        assert!(summary.contacts.is_empty() && summary.complete, "{of}: {:?}", summary.contacts);
        let held_s = summary.legs[0].held_s;
        assert!((gap.length_s..gap.length_s + 5.0).contains(&held_s), "{of}: held for {held_s} s");
        // A short one is no shortfall: what is left of the leg is swum as asked.
        assert_eq!(summary.failure, None, "{of}");
        assert!(summary.legs[0].velocity_error < 0.05, "{of}: {:?}", summary.legs[0]);
        let refused: u64 = summary.link.iter().map(|link| link.ledger.refused + link.ledger.late).sum();
        assert_eq!(refused, 0, "{of}: it was told to begin in the past");
    }
}

#[test]
fn a_gap_of_a_quarter_of_a_leg_is_a_shortfall() {
    let (result, ..) = paused(&scenario("3x1", 40.0, ""), 4, 12.0, 14.0);
    let complaints = result.summary.complaints();
    assert!(
        complaints.len() == 1
            && complaints[0].starts_with("leg 1: the fleet held for 1")
            && complaints[0].ends_with(": the host did not run"),
        "{complaints:?}"
    );
    assert_eq!(result.summary.failure.as_ref(), complaints.first());
}

/// Modules that were never waited for are not given up for the time in which the host did not look.
#[test]
fn a_gap_longer_than_a_host_waits_ends_no_run() {
    let (result, ..) = paused(&scenario("3x1", 60.0, "[timing]\njoin_s = 2\n"), 5, 11.0, 9.0);
    assert_eq!(result.summary.failure, None);
    // Nor before they have joined.
    let (result, ..) = paused(&scenario("3x1", 30.0, "[timing]\njoin_s = 2\n"), 6, 0.02, 9.0);
    assert_eq!((result.summary.failure, result.summary.gaps), (None, vec![]));
}

/// Stopped between the steps of a transition in two: the second is never sent.
#[test]
fn a_gap_in_any_phase_leaves_the_fleet_waiting() {
    for seed in 1..=6 {
        let at_s = 5.0 + 0.37 * seed as f64;
        let (result, _, [before, after]) = paused(&scenario("2x2", 60.0, ""), seed, at_s, 3.0);
        assert_eq!(after, Phase::Waiting, "seed {seed}: from {before:?}");
        assert!(result.summary.contacts.is_empty(), "seed {seed}: {:?}", result.summary.contacts);
        assert_eq!(result.summary.failure, None, "seed {seed}");
    }
}
