//! Against the simulated water, which knows nothing of this crate: tails that swing at random, cameras that see the structure.

use std::f64::consts::{FRAC_PI_2, TAU};

use identify::data::{Boat, Cycle, Recording, Tails};
use identify::identify;
use identify::outcome::{Outcome, Scale};
use modboat::motion::Swing;
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use record::PoseSample;
use serde_json::json;
use sim::TailState;
use sim::mocap::{Mocap, MocapParameters};
use sim::tank::{Tank, TankParameters};

const ROTOR: f64 = 1.5e-4;
const DT_S: f64 = 1e-3;

struct Truth {
    parameters: Parameters,
    tank: TankParameters,
    added: [f64; 3],
    drag: [f64; 2],
    shares: Vec<f64>,
    current_m_s: [f64; 2],
    noise: f64,
    latency_s: f64,
}

fn boat(word: &str) -> Boat {
    let structure = Structure::from_word(word).expect("a size");
    let ids = (1..=structure.len() as u16).collect();
    Boat { structure, ids, belief: Parameters::default(), rotor_inertia_kg_m2: ROTOR }
}

/// Swings of all modules, each from where the last one ended, biased so that the structure goes somewhere for some cycles.
fn swings(rng: &mut ChaCha8Rng, pose_rad: &mut [f64], course_rad: f64) -> Vec<Swing> {
    pose_rad
        .iter_mut()
        .map(|pose_rad| {
            let best = (0..6)
                .map(|_| {
                    let size = rng.random_range(0.95..2.5);
                    let amplitude_rad = if rng.random_range(0.0..1.0) < 0.5 { size } else { -size };
                    Swing { centerline_rad: *pose_rad - amplitude_rad, amplitude_rad }
                })
                .max_by(|a, b| {
                    let along = |swing: &Swing| -(swing.centerline_rad - course_rad).cos();
                    along(a).total_cmp(&along(b))
                })
                .expect("six of them");
            *pose_rad = best.centerline_rad + best.amplitude_rad;
            best
        })
        .collect()
}

fn record(boat: &Boat, truth: &Truth, duration_s: f64, seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let modules = boat.structure.len();
    let start = PoseSample { heading_rad: FRAC_PI_2, ..PoseSample::default() };
    let mut tank = Tank::new(&boat.structure, &boat.belief, &truth.tank, &start, seed).expect("a tank");
    let noise = MocapParameters {
        position_noise_m: 5e-4 * truth.noise,
        heading_noise_rad: 2e-3 * truth.noise,
        ..MocapParameters::default()
    };
    let mut mocap = Mocap::new(&noise, seed ^ 7).expect("cameras");
    let mut recording = Recording { name: format!("seed {seed}"), ..Recording::default() };
    let mut pose_rad = vec![0.3; modules];
    let mut cycle: Option<Cycle> = None;
    let mut course_rad = 0.0;
    let omega = TAU / 1.5;
    for step in 0..(duration_s / DT_S) as u32 {
        if step % 1500 == 0 {
            if step % 7500 == 0 {
                course_rad = rng.random_range(-3.1..3.1);
            }
            let swings = swings(&mut rng, &mut pose_rad, course_rad);
            let begun = Cycle { start_s: f64::from(step) * DT_S, period_s: 1.5, swings };
            recording.cycles.extend(cycle.replace(begun));
        }
        let running = cycle.as_ref().expect("begun");
        let t_s = f64::from(step + 1) * DT_S;
        let (sin, cos) = (omega * (t_s - running.start_s)).sin_cos();
        let tails: Vec<TailState> = running
            .swings
            .iter()
            .map(|swing| TailState {
                angle_rad: swing.centerline_rad + swing.amplitude_rad * cos,
                rate_rad_s: -swing.amplitude_rad * omega * sin,
                acceleration_rad_s2: -swing.amplitude_rad * omega * omega * cos,
                inertia_kg_m2: ROTOR,
            })
            .collect();
        tank.step(DT_S, &tails);
        if step % 20 == 19 {
            recording.tails.push(Tails {
                t_s,
                angle_rad: tails.iter().map(|tail| tail.angle_rad).collect(),
                rate_rad_s: tails.iter().map(|tail| tail.rate_rad_s).collect(),
            });
        }
        if let Some(mut fix) = mocap.sample(tank.pose().t_s, &tank.pose()) {
            fix.t_s += truth.latency_s;
            recording.fixes.push(fix);
        }
    }
    recording
}

/// A boat that differs from the belief in everything.
fn hidden(modules: usize, seed: u64) -> Truth {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut factor = |low: f64, high: f64| -> f64 { rng.random_range(low.ln()..high.ln()).exp() };
    let believed = Parameters::default();
    let (thrust, mass) = (factor(0.6, 1.6), factor(0.67, 1.5));
    let drag = [factor(0.5, 2.0), factor(0.5, 2.0)].map(|factor| factor * believed.drag_n_s2_m2);
    let added = [factor(0.3, 0.9), factor(0.3, 0.9), factor(0.3, 0.9)];
    let shares: Vec<f64> = (0..modules).map(|_| rng.random_range(0.85..1.15)).collect();
    let current_m_s = [rng.random_range(-0.014..0.014), rng.random_range(-0.014..0.014)];
    let parameters = Parameters {
        force_slope_n_rad: thrust * believed.force_slope_n_rad,
        force_offset_n: thrust * believed.force_offset_n,
        module_mass_kg: mass,
        module_inertia_kg_m2: mass * believed.module_inertia_kg_m2,
        ..believed
    };
    let tank = json!({
        "module_mass_kg": parameters.module_mass_kg,
        "module_inertia_kg_m2": parameters.module_inertia_kg_m2,
        "added_mass_sway": added[0],
        "added_mass_surge": added[1],
        "added_inertia": added[2],
        "drag_sway_n_s2_m2": drag[0],
        "drag_surge_n_s2_m2": drag[1],
        "current_m_s": current_m_s,
        "gust_m_s": 0.005,
        "thrust": {
            "slope_n_rad": parameters.force_slope_n_rad,
            "offset_n": parameters.force_offset_n,
            "module_share": shares,
        },
    });
    Truth {
        parameters,
        tank: serde_json::from_value(tank).expect("a tank"),
        added,
        drag,
        shares,
        current_m_s,
        noise: rng.random_range(1.0..5.0),
        latency_s: rng.random_range(0.0..0.15),
    }
}

/// Names and true values of what is to be found.
fn expected(boat: &Boat, truth: &Truth) -> Vec<(&'static str, f64)> {
    let Truth { parameters, added, drag, .. } = truth;
    let mass = |axis: usize| (1.0 + added[axis]) * parameters.module_mass_kg;
    let inertia = (1.0 + added[2]) * boat.structure.inertia_kg_m2(parameters);
    let count = truth.shares.len() as f64;
    let mean = (truth.shares.iter().map(|share| share.ln()).sum::<f64>() / count).exp();
    let (slope, offset) = (mean * parameters.force_slope_n_rad, mean * parameters.force_offset_n);
    vec![
        ("drag_sway_n_s2_m2", drag[0]),
        ("drag_surge_n_s2_m2", drag[1]),
        ("mass_sway_kg", mass(0)),
        ("mass_surge_kg", mass(1)),
        ("structure_inertia_kg_m2", inertia),
        ("force_slope_n_rad", slope),
        ("force_offset_n", offset),
        ("current_east_m_s", truth.current_m_s[0]),
        ("current_north_m_s", truth.current_m_s[1]),
        ("latency_s", truth.latency_s),
        ("drag_over_mass_sway_1_m", drag[0] / mass(0)),
        ("drag_over_mass_surge_1_m", drag[1] / mass(1)),
        ("slope_over_mass_surge_m_s2_rad", slope / mass(1)),
        ("slope_over_drag_sway_m2_s2_rad", slope / drag[0]),
    ]
}

fn show(boat: &Boat, truth: &Truth, outcome: &Outcome) -> usize {
    let mut outside = 0;
    for (name, value) in expected(boat, truth) {
        let found = outcome.constant(name).expect(name);
        let inside = found.low <= value && value <= found.high;
        outside += usize::from(!inside);
        let mark = if inside { ' ' } else { '!' };
        println!(
            "{mark} {name:34} {value:>10.5} {:>10.5} [{:.5}, {:.5}]",
            found.value, found.low, found.high
        );
    }
    outside
}

#[test]
fn a_boat_that_differs_in_everything_is_found() {
    let boat = boat("3x1");
    for seed in [1, 2] {
        let truth = hidden(boat.modules(), seed);
        let recording = record(&boat, &truth, 180.0, seed);
        let outcome = identify(&boat, &[recording], Scale::Rotor).expect("identified");
        println!("seed {seed}: {} steps, converged {}", outcome.steps, outcome.converged);
        let outside = show(&boat, &truth, &outcome);
        println!("{:?}\n{:?}", outcome.prediction, outcome.residuals);
        outcome.indistinct.iter().for_each(|direction| println!("  {}", direction.text));
        assert!(outside <= 3, "seed {seed}: {outside} outside");
    }
}
