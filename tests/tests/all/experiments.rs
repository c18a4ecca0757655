//! The paper's four experiments: host, loopback radio, firmware and tank in a closed loop. Six seeds each; `FLOTILLA_EXPERIMENTS=20` runs
//! as many as the documentation quotes.

use host::run::experiment::{RunResult, simulate};
use host::run::scenario::Scenario;
use host::run::summary::Summary;
use tests::checker::{Modboat, check};
use tests::convert::of_cycle;
use tests::figures::mean;
use tests::seeds::{number, on_all_cores};

const EXPERIMENTS: [&str; 4] = ["holonomic-1", "holonomic-2", "holonomic-3", "holonomic-4"];
/// Seeds of each as a check of every change has time for.
const SEEDS: u64 = 6;

/// By leg, at most twice the worst that was seen: velocity error, heading RMS (rad).
const BOUNDS: [&[(f64, f64)]; 4] =
    [&[(6.4e-4, 3.8e-3)], &[(4.2e-4, 3.8e-3)], &[(8e-4, 2e-3)], &[(1e-3, 4e-3), (0.025, 0.012)]];

/// What must hold, and does not.
fn broken(RunResult { summary, record, .. }: &RunResult) -> Vec<String> {
    let mut broken = Vec::new();
    let mut must = |holds: bool, what: String| {
        if !holds {
            broken.push(format!("{}, seed {}: {what}", summary.scenario, summary.seed));
        }
    };
    must(summary.complete, format!("ended after {} s", summary.duration_s));
    must(summary.legs.len() == record.legs.len(), format!("figures of {} legs only", summary.legs.len()));
    let experiment = EXPERIMENTS.iter().position(|name| *name == summary.scenario).expect("one of the four");
    must(summary.legs.len() == BOUNDS[experiment].len(), format!("{} legs", summary.legs.len()));
    for (k, (leg, &(velocity, heading_rad))) in summary.legs.iter().zip(BOUNDS[experiment]).enumerate() {
        let leg_of = |what: &str| format!("leg {}: {what}", k + 1);
        must(leg.velocity_error <= velocity, leg_of(&format!("velocity off by {:.5}", leg.velocity_error)));
        must(
            leg.heading_rms_rad <= heading_rad,
            leg_of(&format!("heading RMS {:.5} rad", leg.heading_rms_rad)),
        );
    }
    must(summary.contacts.is_empty(), format!("contacts {:?}", summary.contacts));
    let cycles = &summary.cycles;
    must(cycles.total > 0 && cycles.planned == cycles.total, format!("not all planned: {cycles:?}"));
    must(cycles.held == 0 && cycles.repeated == 0, format!("held or repeated: {cycles:?}"));
    must(cycles.refusals == 0 && cycles.reboots == 0, format!("refused or rebooted: {cycles:?}"));
    for cycle in &record.cycles {
        let (request, answer) = of_cycle(record, cycle);
        let checked = check(&Modboat::default(), &request, &answer);
        must(checked.is_ok(), format!("cycle {}: {checked:?}", cycle.number));
    }
    for two in record.cycles.windows(2) {
        // Unless a module was late, a cycle begins where the one before it ended, in time and in pose.
        let end_s = two[0].start_s + two[0].transition_s + two[0].period_s;
        must((two[1].start_s - end_s).abs() < 1e-6, format!("a pause after cycle {}", two[0].number));
        let goes_on =
            two[0].turns.iter().zip(&two[1].turns).all(|(a, b)| (a.to_rad - b.from_rad).abs() < 1e-9);
        must(goes_on, format!("a leap after cycle {}", two[0].number));
    }
    broken
}

#[test]
fn table_four_experiments_hold_for_every_seed() {
    let seeds = number("FLOTILLA_EXPERIMENTS").unwrap_or(SEEDS) as usize;
    let scenarios = EXPERIMENTS.map(|name| Scenario::open(name).expect(name));
    let results = on_all_cores(0..(EXPERIMENTS.len() * seeds) as u64, |index| {
        let (scenario, seed) = (&scenarios[index as usize / seeds], 1 + index % seeds as u64);
        simulate(scenario, seed).map_err(|e| format!("{}, {seed}: {e}", scenario.name))
    });
    let runs: Vec<RunResult> = results.into_iter().map(|run| run.unwrap_or_else(|e| panic!("{e}"))).collect();
    assert_eq!(runs.len(), EXPERIMENTS.len() * seeds);
    let summaries: Vec<&Summary> = runs.iter().map(|run| &run.summary).collect();

    println!("the paper's four experiments, {seeds} seeds each: mean and worst");
    println!(
        "experiment  leg | velocity error %  | heading RMS rad   | clearance mm      | cycles with transn | contacts"
    );
    for (name, of_one) in EXPERIMENTS.iter().zip(summaries.chunks(seeds)) {
        let clearances = || of_one.iter().filter_map(|s| s.least_clearance_m).map(|c| 1e3 * c);
        let contacts: usize = of_one.iter().map(|s| s.contacts.len()).sum();
        for leg in 0..of_one[0].legs.len() {
            let velocity = || of_one.iter().map(|s| 100.0 * s.legs[leg].velocity_error);
            let heading = || of_one.iter().map(|s| s.legs[leg].heading_rms_rad);
            println!(
                "{name} {:>3} | {:>7.2} {:>9.2} | {:>7.4} {:>9.4} | {:>7.2} {:>9.2} | {:>6.1} {:>11.1} | {contacts:>8}",
                leg + 1,
                mean(velocity()),
                velocity().fold(0.0, f64::max),
                mean(heading()),
                heading().fold(0.0, f64::max),
                mean(clearances()),
                clearances().fold(f64::INFINITY, f64::min),
                mean(of_one.iter().map(|s| s.cycles.total as f64)),
                mean(of_one.iter().map(|s| s.cycles.with_transition as f64)),
            );
        }
    }
    let broken: Vec<String> = runs.iter().flat_map(broken).collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
