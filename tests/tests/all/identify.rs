//! Constants of boats that differ from what is believed of them, from the logs of one experiment each.
//!
//! `FLOTILLA_BOATS` boats of three modules and as many of nine (default: two and none), each drawn from its seed: drag of each axis
//! ×0.5 to 2, dry mass ×0.5 to 1.5, added mass, thrust ×0.6 to 1.6, ±15 % from module to module, latency up to 0.15 s stamped on arrival,
//! noise up to fivefold, current up to 0.02 m/s, gusts of 0.005 m/s. The host that runs the experiment knows nothing of it.

use std::fmt::Write;
use std::path::Path;

use ::identify::outcome::{Outcome, Scale};
use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run_into};
use host::run::fleet::InProcess;
use host::run::identify::logged_file;
use host::run::log::Log;
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::seeds::{number, on_all_cores};

struct Hidden {
    tables: String,
    truth: Vec<(&'static str, f64)>,
    shares: Vec<f64>,
}

/// The `[tank]` and `[mocap]` of a boat, and the true values of what is to be found.
fn hidden(scenario: &Scenario, seed: u64) -> Hidden {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (belief, structure) = (&scenario.modboat, &scenario.structure);
    let mut factor = |low: f64, high: f64| -> f64 { rng.random_range(low.ln()..high.ln()).exp() };
    let drag = [0, 1].map(|_| factor(0.5, 2.0) * belief.drag_n_s2_m2);
    let (mass, thrust) = (factor(0.5, 1.5) * belief.module_mass_kg, factor(0.6, 1.6));
    let added = [0, 1, 2].map(|_| factor(0.25, 0.9));
    let shares: Vec<f64> = structure.cells().iter().map(|_| rng.random_range(0.85..1.15)).collect();
    let (speed, course) = (rng.random_range(0.0..0.02), rng.random_range(0.0..std::f64::consts::TAU));
    let current = [speed * f64::cos(course), speed * f64::sin(course)];
    let (latency, noise) = (rng.random_range(0.0..0.15), rng.random_range(1.0..5.0));
    let (slope, offset) = (thrust * belief.force_slope_n_rad, thrust * belief.force_offset_n);
    let inertia = mass * belief.module_inertia_kg_m2 / belief.module_mass_kg;
    let mut tables = String::new();
    let _ = write!(
        tables,
        "[tank]\nmodule_mass_kg = {mass}\nmodule_inertia_kg_m2 = {inertia}\nadded_mass_sway = {}\nadded_mass_surge = {}\n\
         added_inertia = {}\ndrag_sway_n_s2_m2 = {}\ndrag_surge_n_s2_m2 = {}\ncurrent_m_s = [{}, {}]\ngust_m_s = 0.005\n\
         [tank.thrust]\nslope_n_rad = {slope}\noffset_n = {offset}\nmodule_share = {shares:?}\n\
         [mocap]\nposition_noise_m = {}\nheading_noise_rad = {}\nlatency_s = {latency}\nstamped_on_arrival = true\n",
        added[0],
        added[1],
        added[2],
        drag[0],
        drag[1],
        current[0],
        current[1],
        5e-4 * noise,
        2e-3 * noise,
    );
    let mean = (shares.iter().map(|share| share.ln()).sum::<f64>() / shares.len() as f64).exp();
    let wet = |axis: usize| (1.0 + added[axis]) * mass;
    let (slope, offset) = (mean * slope, mean * offset);
    let positions = structure.positions_m(belief.pitch_m);
    let square: f64 = positions.iter().map(|[x, y]| x * x + y * y).sum();
    let wet_inertia = (1.0 + added[2]) * (structure.len() as f64 * inertia + mass * square);
    // (p3): a module at rᵢ meets the water across rᵢ.
    let yaw = |[x, y]: &[f64; 2]| {
        let r = x.hypot(*y);
        let along_surge = if r > 0.0 { (x / r).powi(2) } else { 0.0 };
        (drag[0] + (drag[1] - drag[0]) * along_surge) * r.powi(3) + belief.yaw_drag_n_m_s2
    };
    let truth = vec![
        ("structure_yaw_drag_n_m_s2", positions.iter().map(yaw).sum()),
        ("drag_sway_n_s2_m2", drag[0]),
        ("drag_surge_n_s2_m2", drag[1]),
        ("mass_sway_kg", wet(0)),
        ("mass_surge_kg", wet(1)),
        ("structure_inertia_kg_m2", wet_inertia),
        ("force_slope_n_rad", slope),
        ("force_offset_n", offset),
        ("current_east_m_s", current[0]),
        ("current_north_m_s", current[1]),
        ("latency_s", latency),
        ("drag_over_mass_sway_1_m", drag[0] / wet(0)),
        ("drag_over_mass_surge_1_m", drag[1] / wet(1)),
        ("slope_over_mass_surge_m_s2_rad", slope / wet(1)),
        ("slope_over_drag_sway_m2_s2_rad", slope / drag[0]),
        ("slope_over_drag_surge_m2_s2_rad", slope / drag[1]),
    ];
    Hidden { tables, truth, shares: shares.iter().map(|share| share / mean).collect() }
}

/// Runs the experiment `name` with the boat of this seed, and identifies it from the log.
fn found(name: &str, seed: u64) -> (Hidden, Outcome) {
    let believed = Scenario::open(name).expect(name);
    let hidden = hidden(&believed, seed);
    let document = believed.document();
    let (before, rest) = document.split_once("[tank]\n").expect("a tank");
    let (_, motor) = rest.split_once("[motor]\n").expect("motors");
    let (motor, mocap) = motor.split_once("[mocap]\n").expect("cameras");
    let (_, radio) = mocap.split_once("[radio]\n").expect("a radio");
    let text = format!("{before}{}[motor]\n{motor}[radio]\n{radio}", hidden.tables);
    let scenario = Scenario::parse(name, &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{seed}.mcap"));
    let mut fleet = InProcess::boats(&scenario, seed).expect("modules");
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut |_, _, _| {} };
    let log = Log::create(&path).expect("a log");
    let result = run_into(log, &scenario, seed, &mut fleet, drive, &mut Quiet).expect("a run");
    assert!(result.log_failure.is_none(), "{:?}", result.log_failure);
    assert!(result.summary.contacts.is_empty(), "{name}, seed {seed}: {:?}", result.summary.contacts);
    let logged = logged_file(&path, &mut Quiet).expect("the log");
    let _ = std::fs::remove_file(&path);
    let recordings = [logged.recording];
    let outcome = ::identify::identify(&logged.boat, &recordings, Scale::Rotor).expect("identified");
    if seed == 1 {
        // The same log, the same outcome to the last digit.
        let again = ::identify::identify(&logged.boat, &recordings, Scale::Rotor).expect("identified");
        let [one, other] = [&outcome, &again].map(|outcome| serde_json::to_string(outcome).expect("JSON"));
        assert_eq!(one, other, "{name}");
    }
    (hidden, outcome)
}

/// Of one quantity over all boats.
#[derive(Default)]
struct Tally {
    inside: usize,
    count: usize,
    errors: Vec<f64>,
}

impl Tally {
    fn take(&mut self, truth: f64, value: f64, low: f64, high: f64, against: f64) {
        self.count += 1;
        self.inside += usize::from(low <= truth && truth <= high);
        self.errors.push((value - truth).abs() / against);
    }

    fn median(&mut self) -> f64 {
        self.errors.sort_by(f64::total_cmp);
        self.errors.get(self.errors.len() / 2).copied().unwrap_or_default()
    }
}

#[test]
fn hidden_boats_are_found_within_their_intervals() {
    let boats = number("FLOTILLA_BOATS").unwrap_or(0);
    let runs: &[(&str, u64)] =
        if boats == 0 { &[("identify-3", 2)] } else { &[("identify-3", boats), ("identify-9", boats)] };
    for &(name, boats) in runs {
        let mut tallies: Vec<(&str, Tally)> = Vec::new();
        let mut foretold = Vec::new();
        for (seed, (hidden, outcome)) in (1..).zip(on_all_cores(1..boats + 1, |seed| found(name, seed))) {
            assert!(outcome.converged, "{name}, seed {seed}: {} steps", outcome.steps);
            let mut take = |name: &'static str, truth: f64, found: &::identify::outcome::Constant| {
                let at = tallies.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
                    tallies.push((name, Tally::default()));
                    tallies.len() - 1
                });
                let against = match name {
                    "current_east_m_s" | "current_north_m_s" => 0.02,
                    "latency_s" => 0.1,
                    _ => truth.abs(),
                };
                tallies[at].1.take(truth, found.value, found.low, found.high, against);
            };
            for &(quantity, truth) in &hidden.truth {
                take(quantity, truth, outcome.constant(quantity).expect(quantity));
            }
            for (module, &share) in outcome.modules.iter().zip(&hidden.shares) {
                take("gain", share, &module.gain);
            }
            foretold.push(outcome.prediction.velocity_error);
        }
        foretold.sort_by(f64::total_cmp);
        println!(
            "{name}: {boats} boats; velocity foretold 20 s ahead within {:.1} % (median)",
            100.0 * foretold[foretold.len() / 2]
        );
        println!("  {:34} inside   median error", "quantity");
        let (mut inside, mut count) = (0, 0);
        for (quantity, tally) in &mut tallies {
            (inside, count) = (inside + tally.inside, count + tally.count);
            let share = 100.0 * tally.inside as f64 / tally.count as f64;
            let median = tally.median();
            println!("  {quantity:34} {share:>5.1} %  {:>5.1} %", 100.0 * median);
            let limit = if quantity.contains("drag") || quantity.contains("slope") { 0.05 } else { 0.1 };
            if boats >= 50 {
                assert!((90.0..=98.0).contains(&share), "{name}: {quantity}: {share} % inside");
                assert!(median <= limit, "{name}: {quantity}: median error {median}");
            } else {
                assert!(median <= 3.0 * limit, "{name}: {quantity}: median error {median}");
            }
        }
        let share = inside as f64 / count as f64;
        println!("  {:34} {:>5.1} %", "all", 100.0 * share);
        assert!(share > 0.8, "{name}: {share} of all intervals hold the truth");
    }
}
