//! ROVs against the simulated water, which knows nothing of this crate: a robot that is pushed about at random, seen by cameras.

use std::f64::consts::TAU;

use identify::rov::data::{Pose, Recording, Swim, Thrusts};
use identify::rov::identify;
use identify::rov::outcome::{Outcome, Scale};
use nalgebra::{DMatrix, Vector6};
use quantity::wrap_rad;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::pose::Pose as Berth;
use reconfiguration::vehicle::Vehicle;
use rov::configuration_matrix::ConfigurationMatrix;
use sim::rov::basin::Basin;

const DT_S: f64 = 0.005;
/// Noise of poses, m and rad: what an underwater system with a calibration of its own day gives.
const NOISE_M: f64 = 2e-3;
const NOISE_RAD: f64 = 5e-3;

fn believed() -> Vehicle {
    Vehicle::built_in("bluerov2-heavy").expect("comes with the program")
}

/// A normal deviate (Box, Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(1e-12..1.0), rng.random_range(0.0..TAU));
    (-2.0 * u.ln()).sqrt() * v.cos()
}

/// What the water knows.
struct Truth {
    vehicle: Vehicle,
    gain: Vec<f64>,
    current_m_s: [f64; 2],
}

/// Damping, added mass and thrusters that differ from the belief.
fn hidden(seed: u64) -> Truth {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut vehicle = believed();
    let mut factor = |low: f64, high: f64| -> f64 { rng.random_range(low.ln()..high.ln()).exp() };
    for axis in [0, 1, 2, 5] {
        vehicle.body.added_mass[axis] *= factor(0.5, 1.8);
        vehicle.body.linear_damping[axis] = (vehicle.body.linear_damping[axis] * factor(0.5, 2.0)).max(0.5);
        vehicle.body.quadratic_damping[axis] *= factor(0.5, 2.0);
    }
    vehicle.body.buoyancy_n = vehicle.body.weight_n + factor(0.5, 2.0) - 2.0;
    let gain: Vec<f64> = vehicle.thrusters.iter().map(|_| factor(0.87, 1.15)).collect();
    // The scale is the thrusters' mean law, of those that push level and of those that push up: a common factor is none of the vehicle's.
    let scaled = |set: &[f64]| -> Vec<f64> {
        let mean = set.iter().map(|gain| gain.ln()).sum::<f64>() / set.len() as f64;
        set.iter().map(|gain| gain / mean.exp()).collect()
    };
    let gain = [scaled(&gain[..4]), scaled(&gain[4..])].concat();
    let current_m_s = [factor(0.5, 2.0) * 0.02 - 0.02, 0.01];
    Truth { vehicle, gain, current_m_s }
}

/// Swims of `swim_s` each: a new push every few seconds, roll and pitch held.
fn record(truth: &Truth, swims: usize, swim_s: f64, seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let matrix = ConfigurationMatrix::of_vehicle(&truth.vehicle).expect("thrusters");
    let columns = DMatrix::from_column_slice(6, matrix.thrusters(), matrix.matrix().as_slice());
    let allocate = columns.pseudo_inverse(1e-9).expect("full rank");
    let mut recording = Recording { name: format!("seed {seed}"), ..Recording::default() };
    let mut now_s = 10.0;
    for _ in 0..swims {
        let mut basin = Basin::new(&[(Berth::default(), &truth.vehicle)]).expect("a body");
        let [north, east] = truth.current_m_s;
        basin.set_current([north, east, 0.0]);
        let mut swim = Swim { robot: 1, ..Swim::default() };
        let (mut push, mut given_n) = ([0.0; 4], vec![0.0; matrix.thrusters()]);
        let mut told_n = given_n.clone();
        for step in 0..(swim_s / DT_S) as u32 {
            let t_s = now_s + f64::from(step) * DT_S;
            let state = basin.state(0);
            let eta = state.eta();
            if step % 400 == 0 && rng.random_range(0.0..1.0) < 0.7 {
                push = [15.0, 15.0, 15.0, 1.5].map(|most| rng.random_range(-most..most));
            }
            if step % 10 == 0 {
                let level = |axis: usize| -8.0 * eta[axis] - 4.0 * state.nu[axis];
                let wrench = Vector6::new(push[0], push[1], push[2], level(3), level(4), push[3]);
                told_n = (&allocate * wrench).iter().copied().collect();
            }
            if step % 2 == 0 {
                let mut seen = |at: usize, noise: f64| eta[at] + noise * normal(&mut rng);
                let position_m = [seen(0, NOISE_M), seen(1, NOISE_M), seen(2, NOISE_M)];
                let attitude_rad = [3, 4, 5].map(|axis| wrap_rad(seen(axis, NOISE_RAD)));
                swim.poses.push(Pose { t_s, position_m, attitude_rad });
            }
            let follows = 1.0 - (-DT_S / 0.1_f64).exp();
            given_n.iter_mut().zip(&told_n).for_each(|(given, told)| *given += (told - *given) * follows);
            if step % 10 == 0 {
                swim.thrusts.push(Thrusts { t_s, thrusts_n: given_n.clone() });
            }
            let felt_n: Vec<f64> = given_n.iter().zip(&truth.gain).map(|(n, gain)| n * gain).collect();
            basin.step(DT_S, &[felt_n]);
        }
        recording.swims.push(swim);
        now_s += swim_s + 20.0;
    }
    recording
}

/// Names of constants with their true values.
fn true_values(truth: &Truth) -> Vec<(String, f64)> {
    let body = &truth.vehicle.body;
    let mut list = vec![
        ("inertia_yaw_kg_m2".to_owned(), body.inertia_kg_m2[2] + body.added_mass[5]),
        ("linear_damping_yaw_n_m_s".to_owned(), body.linear_damping[5]),
        ("quadratic_damping_yaw_n_m_s2".to_owned(), body.quadratic_damping[5]),
        ("weight_in_water_n".to_owned(), body.weight_n - body.buoyancy_n),
        ("current_north_m_s".to_owned(), truth.current_m_s[0]),
        ("current_east_m_s".to_owned(), truth.current_m_s[1]),
    ];
    for (axis, name) in ["surge", "sway", "heave"].into_iter().enumerate() {
        list.push((format!("mass_{name}_kg"), body.mass_kg + body.added_mass[axis]));
        list.push((format!("linear_damping_{name}_n_s_m"), body.linear_damping[axis]));
        list.push((format!("quadratic_damping_{name}_n_s2_m2"), body.quadratic_damping[axis]));
        let drag_n = 0.2 * body.linear_damping[axis] + 0.04 * body.quadratic_damping[axis];
        list.push((format!("drag_{name}_at_0_2_m_s_n"), drag_n));
    }
    list
}

/// Each constant with its truth: (name, truth, value, low, high).
fn beside(truth: &Truth, outcome: &Outcome) -> Vec<(String, f64, f64, f64, f64)> {
    let constants = true_values(truth).into_iter().map(|(name, value)| {
        let found = outcome.constant(&name).unwrap_or_else(|| panic!("{name}"));
        (name, value, found.value, found.low, found.high)
    });
    let gains = outcome.thrusters.iter().zip(&truth.gain).map(|(found, &gain)| {
        (format!("gain {}", found.number), gain, found.gain.value, found.gain.low, found.gain.high)
    });
    constants.chain(gains).collect()
}

#[test]
fn intervals_hold_the_constants_of_hidden_vehicles() {
    const SEEDS: u64 = 4;
    let (mut within, mut all) = (0, 0);
    let mut far: Vec<(String, Vec<f64>)> = Vec::new();
    let found = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..SEEDS)
            .map(|seed| {
                scope.spawn(move || {
                    let truth = hidden(seed);
                    let recording = record(&truth, 4, 40.0, seed ^ 77);
                    let outcome = identify(&believed(), &[recording], Scale::Thrust).expect("identified");
                    (truth, outcome)
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().expect("identified")).collect::<Vec<_>>()
    });
    for (seed, (truth, outcome)) in (0..SEEDS).zip(found) {
        let error = outcome.prediction.velocity_error.expect("foretold");
        println!("seed {seed}: {} steps, velocity foretold within {:.1} %", outcome.steps, 100.0 * error);
        assert!(outcome.converged, "seed {seed}");
        assert!(error < 0.1, "seed {seed}: {error}");
        let delay = outcome.constant("thrust_delay_s").expect("a delay");
        assert!(delay.value.abs() < 0.006, "seed {seed}: {delay:?}");
        for (name, value, found, low, high) in beside(&truth, &outcome) {
            let holds = (low..=high).contains(&value);
            println!(
                "    {name:<34} {value:>9.3}  {found:>9.3}  {low:>9.3} … {high:<9.3}{}",
                if holds { "" } else { "  out" }
            );
            (within, all) = (within + u32::from(holds), all + 1);
            match far.iter_mut().find(|(known, _)| *known == name) {
                Some((_, list)) => list.push((found / value - 1.0).abs()),
                None => far.push((name, vec![(found / value - 1.0).abs()])),
            }
        }
    }
    for (name, errors) in &mut far {
        errors.sort_by(f64::total_cmp);
        println!("{name:<34} off by {:.1} % (median)", 100.0 * errors[errors.len() / 2]);
    }
    println!("{within} of {all} intervals hold the truth");
    let share = f64::from(within) / f64::from(all);
    assert!((0.88..=1.0).contains(&share), "{share}");
    let median = |name: &str| {
        let (_, errors) = far.iter().find(|(known, _)| known == name).expect("a constant");
        errors[errors.len() / 2]
    };
    for (name, most) in [
        ("mass_surge_kg", 0.1),
        ("mass_sway_kg", 0.1),
        ("mass_heave_kg", 0.1),
        ("inertia_yaw_kg_m2", 0.1),
        ("drag_surge_at_0_2_m_s_n", 0.05),
        ("drag_sway_at_0_2_m_s_n", 0.05),
        ("drag_heave_at_0_2_m_s_n", 0.05),
    ] {
        assert!(median(name) < most, "{name}: {}", median(name));
    }
}

#[test]
fn a_scale_of_mass_shows_the_thrusters_gain_and_headings_and_places_do_not_matter() {
    let mut truth = hidden(3);
    for axis in [0, 2] {
        truth.vehicle.body.added_mass[axis] = believed().body.added_mass[axis];
    }
    truth.gain.iter_mut().for_each(|gain| *gain *= 0.8);
    let recording = record(&truth, 3, 40.0, 11);
    let outcome = identify(&believed(), std::slice::from_ref(&recording), Scale::Mass).expect("identified");
    let gain = outcome.constant("thruster_gain").expect("its scale is another");
    assert!((gain.low..=gain.high).contains(&0.8) && gain.high / gain.low < 1.3, "{gain:?}");
    // The same swims 700 m away, turned by 130°.
    let (sin, cos) = 2.27_f64.sin_cos();
    let mut moved = recording;
    for pose in moved.swims.iter_mut().flat_map(|swim| &mut swim.poses) {
        let [n, e, d] = pose.position_m;
        pose.position_m = [700.0 + cos * n - sin * e, sin * n + cos * e - 300.0, d + 40.0];
        pose.attitude_rad[2] = wrap_rad(pose.attitude_rad[2] + 2.27);
    }
    let turned = identify(&believed(), &[moved], Scale::Mass).expect("identified");
    for name in ["mass_sway_kg", "quadratic_damping_surge_n_s2_m2", "thruster_gain"] {
        let [a, b] = [&outcome, &turned].map(|outcome| outcome.constant(name).expect(name).value);
        assert!((a / b - 1.0).abs() < 2e-3, "{name}: {a}, {b}");
    }
}

#[test]
fn what_says_nothing_is_refused_and_what_is_not_shown_is_said() {
    let truth = hidden(1);
    let mut recording = record(&truth, 1, 5.0, 1);
    let refused = identify(&believed(), std::slice::from_ref(&recording), Scale::Thrust);
    assert!(refused.is_err_and(|error| error.to_string().contains("alone for 4.9 s")));
    // A robot that is only pushed ahead shows nothing of sway, heave and yaw.
    recording = record(&truth, 1, 40.0, 1);
    let matrix = ConfigurationMatrix::of_vehicle(&truth.vehicle).expect("thrusters");
    assert_eq!(matrix.thrusters(), 8);
    for known in &mut recording.swims[0].thrusts {
        known.thrusts_n = vec![0.0; 8];
    }
    for pose in &mut recording.swims[0].poses {
        pose.position_m = [0.0; 3].map(|rest: f64| rest + 1e-4 * (1e3 * pose.t_s).sin());
        pose.attitude_rad = [0.0; 3];
    }
    let outcome = identify(&believed(), &[recording], Scale::Thrust).expect("identified");
    let shown = |name: &str| outcome.constant(name).expect(name).shown;
    assert!(!shown("mass_sway_kg") && !shown("quadratic_damping_heave_n_s2_m2"));
    assert!(!outcome.indistinct.is_empty() && outcome.notes.iter().any(|note| note.contains("hardly shown")));
}
