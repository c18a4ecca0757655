//! "A cycle reaches all of 25 modules before its start with probability 1 − 10⁻⁶ at 30 % loss": calculated, and counted where misses
//! are frequent enough to be counted, with the real dispatcher and the firmware's links.

mod calculation;
mod leads;
mod rig;

use calculation::{DelayUs, TwoPhase, any, least_lead_us, miss, sends, two_phase};
use host::run::scenario::Timing;
use link::delivery::COMMIT_LEAD;
use link::faults::FaultParameters;
use protocol::Delivery;
use protocol::time::Duration;
use rig::Rig;

const MODULES: u16 = 25;
const N: usize = MODULES as usize;

fn lead_us() -> u64 {
    (Timing::default().lead_s * 1e6).round() as u64
}

fn weather(loss: f64, delay: &DelayUs) -> FaultParameters {
    let [delay_s, jitter_s] = [*delay.start(), delay.end() - delay.start()].map(|us| us as f64 * 1e-6);
    FaultParameters { loss, delay_s, jitter_s, ..FaultParameters::default() }
}

/// Prints a count beside what was calculated; they must not be further apart than five standard deviations.
fn compare(what: &str, count: usize, trials: usize, share: f64) {
    let expected = trials as f64 * share;
    let sigma = (expected * (1.0 - share)).sqrt();
    println!("{what:<72} {count:>6} of {trials:<7} calculated {expected:>9.3} ± {sigma:.3}");
    assert!(
        (count as f64 - expected).abs() <= 5.0 * sigma + 1.0,
        "{what}: {count}, not {expected} ± {sigma}"
    );
}

/// Counts the modules that missed a cycle.
fn direct(loss: f64, delay: &DelayUs, cycles: usize, seed: u64) {
    let mut rig = Rig::new(MODULES, seed);
    let lead = Duration(lead_us() as u32);
    let cycle = |_| N - rig.cycle(weather(loss, delay), lead, Delivery::Direct).modules;
    let missed: usize = (0..cycles).map(cycle).sum();
    let what = format!("direct, {:.0} % loss, {delay:?} µs: modules that missed it", 100.0 * loss);
    compare(&what, missed, cycles * N, miss(loss, delay, lead_us()));
}

/// Counts prepared cycles that were dropped, or split.
fn prepared(loss: f64, delay_us: u64, lead_us: u64, cycles: usize, seed: u64) {
    let mut rig = Rig::new(MODULES, seed);
    let (weather, lead) = (weather(loss, &(delay_us..=delay_us)), Duration(lead_us as u32));
    let reached: Vec<_> = (0..cycles).map(|_| rig.cycle(weather, lead, Delivery::Prepare)).collect();
    assert!(
        reached.iter().all(|reached| !reached.dropped || reached.modules == 0),
        "dropped, and a module ran it"
    );
    // The commit lead follows what is measured.
    let each = reached.iter().map(|reached| {
        let commit_lead_us = u64::from(reached.commit_lead.0);
        two_phase(loss, delay_us, lead_us, commit_lead_us, N)
    });
    let mean = |of: &dyn Fn(TwoPhase) -> f64| each.clone().map(of).sum::<f64>() / cycles as f64;
    let expected = TwoPhase { dropped: mean(&|one| one.dropped), split: mean(&|one| one.split) };
    let what = format!("prepared {} ms ahead, {:.0} % loss, {delay_us} µs", lead_us / 1_000, 100.0 * loss);
    let dropped = reached.iter().filter(|reached| reached.dropped).count();
    compare(&format!("{what}: cycles dropped"), dropped, cycles, expected.dropped);
    let split = reached.iter().filter(|reached| (1..N).contains(&reached.modules)).count();
    compare(&format!("{what}: committed to some, not all"), split, cycles, expected.split);
}

#[test]
fn counted_at_thirty_per_cent() {
    direct(0.3, &(0..=0), 1_000, 1);
    direct(0.3, &(5_000..=35_000), 1_000, 2);
}

#[test]
fn counted_where_misses_are_frequent() {
    direct(0.6, &(5_000..=35_000), 1_000, 3);
    direct(0.7, &(0..=0), 1_000, 4);
    direct(0.7, &(35_000..=35_000), 1_000, 5);
}

#[test]
fn counted_in_two_phases() {
    prepared(0.3, 0, lead_us(), 1_000, 6);
    prepared(0.3, 20_000, lead_us(), 1_000, 7);
    // Where about a sixth is dropped, with a longer commit lead.
    prepared(0.6, 0, 900_000, 400, 8);
}

#[test]
fn calculated() {
    let lead_us = lead_us();
    let delays: [(&str, DelayUs); 4] =
        [("0", 0..=0), ("20", 20_000..=20_000), ("20 ± 15", 5_000..=35_000), ("35", 35_000..=35_000)];
    println!("\n{MODULES} modules, sent {} s ahead: {} times", lead_us as f64 * 1e-6, sends(lead_us).len());
    println!(
        "loss  delay, ms   a module misses it   not all have it   least lead   dropped if prepared   split   least lead"
    );
    for loss in [0.1, 0.2, 0.3, 0.4, 0.5] {
        for (name, delay) in &delays {
            let one = miss(loss, delay, lead_us);
            let least = least_lead_us(|lead_us| any(miss(loss, delay, lead_us), N));
            // Of varying delays the worst.
            let commit_lead_us = u64::from(COMMIT_LEAD.0);
            let phases = two_phase(loss, *delay.end(), lead_us, commit_lead_us, N);
            let both = least_lead_us(|lead_us| {
                let phases = two_phase(loss, *delay.end(), lead_us, commit_lead_us, N);
                phases.dropped + phases.split
            });
            let seconds =
                |us: Option<u64>| us.map_or("—".to_owned(), |us| format!("{:.2} s", us as f64 * 1e-6));
            println!(
                "{:3.0} % {name:>9} {one:>20.1e} {:>17.1e} {:>12} {:>21.1e} {:>9.1e} {:>10}",
                100.0 * loss,
                any(one, N),
                seconds(least),
                phases.dropped,
                phases.split,
                seconds(both),
            );
        }
    }
    println!();
    for (name, delay) in &delays {
        let not_all = any(miss(0.3, delay, lead_us), N);
        assert!(not_all <= 1e-6, "30 % loss, {name} ms: not all have it once in {:.0}", 1.0 / not_all);
    }
}
