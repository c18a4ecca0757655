//! The paper's four experiments: host, loopback radio, firmware and tank in a closed loop. Six seeds each; `FLOTILLA_EXPERIMENTS=20` runs
//! as many as the documentation quotes.

use host::run::experiment::{RunResult, simulate};
use host::run::scenario::Scenario;
use serde_json::json;
use tests::checker::{Modboat, check};
use tests::convert::of_cycle;
use tests::figures::mean;
use tests::seeds::number;
use tests::statistics::{Row, Statistic, rows};

const EXPERIMENTS: [&str; 4] = ["holonomic-1", "holonomic-2", "holonomic-3", "holonomic-4"];
/// Seeds of each as a check of every change has time for.
const SEEDS: u64 = 6;

/// By leg, at most twice the worst that was seen: velocity error, heading RMS (rad).
const BOUNDS: [&[(f64, f64)]; 4] =
    [&[(6.4e-4, 3.8e-3)], &[(4.2e-4, 3.8e-3)], &[(3.6e-4, 2e-3)], &[(1e-3, 4e-3), (0.025, 5e-3)]];

/// What must hold of the record of a run, and does not.
fn broken(RunResult { summary, record, .. }: &RunResult) -> Vec<String> {
    let mut broken = Vec::new();
    let mut must = |holds: bool, what: String| {
        if !holds {
            broken.push(what);
        }
    };
    must(summary.legs.len() == record.legs.len(), format!("figures of {} legs only", summary.legs.len()));
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

/// What must hold of the figures of a run, and does not.
fn missed(row: Row<'_>) -> Vec<String> {
    let (name, seed) = (row.text("scenario"), row.count("seed"));
    let mut missed = Vec::new();
    let mut must = |holds: bool, what: String| {
        if !holds {
            missed.push(format!("{name}, seed {seed}: {what}"));
        }
    };
    must(row.count("complete") == 1, format!("ended after {} s", row.number("duration_s")));
    must(row.count("broken.count") == 0, row.text("broken.list").to_owned());
    must(row.count("contacts.count") == 0, format!("contacts {}", row.text("contacts.list")));
    let [total, planned, held, repeated, refusals, reboots] =
        ["total", "planned", "held", "repeated", "refusals", "reboots"]
            .map(|key| row.count(&format!("cycles.{key}")));
    must(total > 0 && planned == total, format!("{planned} of {total} cycles planned"));
    must(held == 0 && repeated == 0, format!("{held} held, {repeated} repeated"));
    must(refusals == 0 && reboots == 0, format!("{refusals} refused, {reboots} reboots"));
    let experiment = EXPERIMENTS.iter().position(|known| *known == name).expect("one of the four");
    let bounds = BOUNDS[experiment];
    must(row.count("legs_count") == bounds.len() as u64, format!("{} legs", row.count("legs_count")));
    for (k, (velocity, heading_rad)) in bounds.iter().enumerate() {
        let [off, rms_rad] =
            ["velocity_error", "heading_rms_rad"].map(|key| row.number(&format!("legs.{k}.{key}")));
        must(off <= *velocity, format!("leg {}: velocity off by {off:.5}", k + 1));
        must(rms_rad <= *heading_rad, format!("leg {}: heading RMS {rms_rad:.5} rad", k + 1));
    }
    missed
}

#[test]
fn table_four_experiments_hold_for_every_seed() {
    let seeds = number("FLOTILLA_EXPERIMENTS").unwrap_or(SEEDS) as usize;
    let scenarios = EXPERIMENTS.map(|name| Scenario::open(name).expect(name));
    let row = |number: usize| {
        let (scenario, seed) = (&scenarios[number / seeds], 1 + (number % seeds) as u64);
        let run =
            simulate(scenario, seed).unwrap_or_else(|error| panic!("{}, {seed}: {error}", scenario.name));
        let mut row = serde_json::to_value(&run.summary).expect("figures");
        row["broken"] = json!(broken(&run));
        row["legs_count"] = json!(run.summary.legs.len());
        row
    };
    let runs = EXPERIMENTS.len() * seeds;
    let varied = format!("{seeds} seeds");
    let rows = rows(&Statistic { name: "experiments", of: "runs", runs, varied, row });

    println!("the paper's four experiments, {seeds} seeds each: mean and worst");
    println!(
        "experiment  leg | velocity error %  | heading RMS rad   | clearance mm      | cycles with transn | contacts"
    );
    for (name, bounds) in EXPERIMENTS.iter().zip(BOUNDS) {
        let of_one = || rows.iter().filter(|row| row.text("scenario") == *name);
        let all = |column: &str| of_one().map(|row| row.number(column)).collect::<Vec<f64>>();
        let mean_of = |values: &[f64]| mean(values.iter().copied());
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let clearances: Vec<f64> = of_one().filter_map(|row| row.perhaps("least_clearance_m")).collect();
        for leg in 0..bounds.len() {
            let velocity = all(&format!("legs.{leg}.velocity_error"));
            let heading = all(&format!("legs.{leg}.heading_rms_rad"));
            println!(
                "{name} {:>3} | {:>7.2} {:>9.2} | {:>7.4} {:>9.4} | {:>7.2} {:>9.2} | {:>6.1} {:>11.1} | {:>8}",
                leg + 1,
                100.0 * mean_of(&velocity),
                100.0 * most(&velocity),
                mean_of(&heading),
                most(&heading),
                1e3 * mean_of(&clearances),
                1e3 * clearances.iter().copied().fold(f64::INFINITY, f64::min),
                mean_of(&all("cycles.total")),
                mean_of(&all("cycles.with_transition")),
                all("contacts.count").iter().sum::<f64>(),
            );
        }
    }
    let missed: Vec<String> = rows.iter().flat_map(missed).collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
