//! The lead of a prepared cycle keeps its promise: counted at the modules, by fleet and loss.
//!
//! `FLOTILLA_CYCLES=2000 cargo test -p tests --test all reach::leads -- --nocapture` counts more cycles of each.

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run};
use host::run::fleet::InProcess;
use host::run::orders::Unattended;
use host::run::pilot::Pilot;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use link::delivery::COMMIT_LEAD;
use link::faults::FaultParameters;
use link::lead::{UNCOMMITTED, UNPREPARED};
use modboat::parameters::Parameters;
use modboat::planner_config::LossTolerance;
use modboat::planner_kind::PlannerKind;
use protocol::Delivery;
use protocol::time::{Duration, FleetInstant};
use tests::seeds::{number, on_all_cores};

use super::calculation::two_phase;
use super::rig::Rig;

/// Cycles in which the losses are measured first.
const WARM_UP: usize = 10;
const FLEETS: [u16; 4] = [3, 9, 25, 49];
const LOSSES: [f64; 4] = [0.0, 0.1, 0.3, 0.4];
/// Time under way, s: the shortest, and what is drawn beyond it.
const DELAY_S: [f64; 2] = [0.005, 0.01];

/// What became of the cycles of one fleet at one loss.
#[derive(Clone, Copy, Default)]
struct Count {
    cycles: usize,
    /// Every module could run it at its start.
    in_time: usize,
    dropped: usize,
    /// Some modules could run it, and others not.
    split: usize,
    lead_s: f64,
}

fn span(seconds: f64) -> Duration {
    Duration((seconds * 1e6).round() as u32)
}

/// Cycles that are sent with the lead that suits what is measured, or always 0.3 s ahead.
fn count(modules: u16, loss: f64, suits: bool, cycles: usize) -> Count {
    let seed = u64::from(modules) * 1_000 + (loss * 100.0) as u64;
    let mut rig = Rig::new(modules, seed);
    let [delay_s, jitter_s] = DELAY_S;
    let weather = FaultParameters { loss, delay_s, jitter_s, ..FaultParameters::default() };
    let (least, most) = (super::lead_us() as u32, span(Parameters::default().period_s));
    let mut count = Count::default();
    for cycle in 0..WARM_UP + cycles {
        let measured = rig.lead().total().min(most).max(Duration(least));
        let lead = if suits { measured } else { Duration(least) };
        let reached = rig.cycle(weather, lead, Delivery::Prepare);
        if cycle < WARM_UP {
            continue;
        }
        count.cycles += 1;
        count.in_time += usize::from(reached.modules == usize::from(modules));
        count.split += usize::from((1..usize::from(modules)).contains(&reached.modules));
        count.dropped += usize::from(reached.dropped);
        count.lead_s += f64::from(lead.as_secs_f32()) / cycles as f64;
    }
    count
}

/// At most so many of `cycles` that happen with probability `share` at most: five standard deviations, and one.
fn at_most(cycles: usize, share: f64) -> usize {
    let expected = cycles as f64 * share;
    (expected + 5.0 * expected.sqrt() + 1.0) as usize
}

#[test]
fn prepared_cycles_are_committed_in_time_at_any_loss_that_is_measured() {
    let cycles = number("FLOTILLA_CYCLES").unwrap_or(60) as usize;
    let all = on_all_cores(0..32, |index| {
        let (fleet, loss, suits) = (index / 8, index / 2 % 4, index % 2 == 1);
        count(FLEETS[fleet as usize], LOSSES[loss as usize], suits, cycles)
    });
    println!(
        "\n{cycles} cycles each, {DELAY_S:?} s under way\nmodules  loss    0.3 s ahead   as measured    lead"
    );
    for (pair, both) in all.chunks(2).enumerate() {
        let (modules, loss) = (FLEETS[pair / 4], LOSSES[pair % 4]);
        let [fixed, suited] = both else { unreachable!("chunks of two") };
        // With the least commit lead, as without a measurement.
        let mean_us = (1e6 * (DELAY_S[0] + 0.5 * DELAY_S[1])) as u64;
        let least_us = u64::from(COMMIT_LEAD.0);
        let before = two_phase(loss, mean_us, super::lead_us(), least_us, usize::from(modules));
        let share = |count: &Count| 100.0 * count.in_time as f64 / count.cycles as f64;
        println!(
            "{modules:>7} {:>3.0} % {:>22.2} % {:>11.2} % {:>11.2} % {:>5.0} ms",
            100.0 * loss,
            100.0 * (1.0 - before.dropped - before.split),
            share(fixed),
            share(suited),
            1e3 * suited.lead_s
        );
        let what = format!("{modules} modules, {loss}: {} dropped, {} split", suited.dropped, suited.split);
        assert!(suited.dropped <= at_most(cycles, UNPREPARED), "{what}");
        assert!(suited.split <= at_most(cycles, UNCOMMITTED), "{what}");
        assert_eq!(suited.in_time + suited.dropped + suited.split, cycles, "{what}");
        // Nothing is waited for that is not needed.
        assert!(loss > 0.0 || suited.lead_s < 0.301, "{modules} modules without loss: {} s", suited.lead_s);
    }
    let lossy = all.iter().step_by(2).skip(3).step_by(4);
    let dropped: usize = lossy.map(|fixed| fixed.dropped).sum();
    assert!(dropped > cycles / 10, "the rig drops nothing at a fixed lead: {dropped}");
}

/// Swims plans that not every module may miss, by the paper's planner, at 30 % loss: how many there were, and how many were given up.
fn swim(seed: u64) -> (usize, u32) {
    let mut scenario = Scenario::open("nine").expect("built in");
    scenario.planner.kind = PlannerKind::PotentialField;
    scenario.planner.loss_tolerant = LossTolerance::Off;
    scenario.radio = FaultParameters { loss: 0.3, delay_s: 0.01, ..FaultParameters::default() };
    scenario.timing.join_s = 60.0;
    let mut fleet = InProcess::boats(&scenario, seed).expect("a fleet");
    let (mut for_all, mut dropped) = (0, 0);
    let mut watch = |_: FleetInstant, pilot: &Pilot, _: &mut InProcess| {
        for_all = pilot.decisions().iter().filter(|decision| !decision.plan.loss_tolerant).count();
        dropped = pilot.dropped();
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut watch };
    run(&scenario, seed, &mut fleet, drive, &mut Quiet)
        .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    (for_all, dropped)
}

/// At a lead of 0.3 s at least one in twenty is.
#[test]
fn a_fleet_whose_plans_are_for_all_or_none_gives_few_up() {
    let all = on_all_cores(0..4, swim);
    let (for_all, dropped) = all.iter().fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1 as usize));
    println!("nine modules, 30 % loss: {dropped} of {for_all} plans for all or none were given up: {all:?}");
    assert!(for_all >= 40, "{for_all} plans for all or none are too few to judge by");
    // The first of a run are sent before anything is measured.
    assert!(dropped <= at_most(for_all, UNPREPARED) + all.len(), "{dropped} of {for_all}");
}
