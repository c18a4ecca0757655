//! A tank that differs from what the host believes: in thrust, in waves, and turned as a whole.

use std::f64::consts::TAU;

use super::tests::{DT_S, row, waveforms};
use super::*;
use crate::thrust::ThrustParameters;
use crate::waves::{JonswapParameters, WaveParameters};

const SWINGS: [[f64; 2]; 3] = [[-1.2, 1.4], [0.4, -2.0], [2.9, 1.1]];

/// The mean wrench of a cycle.
fn mean_wrench(tank: &TankParameters, seed: u64) -> Wrench {
    let mut tank =
        Tank::new(&row(), &Parameters::default(), tank, &PoseSample::default(), seed).expect("valid");
    let mut mean = [0.0; 3];
    for step in 1..=1500 {
        tank.step(DT_S, &waveforms(SWINGS, f64::from(step) * DT_S));
        let now = tank.last_wrench().to_array();
        mean = [0, 1, 2].map(|i| mean[i] + now[i] / 1500.0);
    }
    Wrench::from_array(mean)
}

/// By (7), with `law` of each module.
fn by_7(law: impl Fn(usize, f64) -> f64) -> Wrench {
    let positions_m = row().positions_m(0.15);
    SWINGS.iter().zip(positions_m).enumerate().fold(Wrench::default(), |sum, (module, (swing, [x, y]))| {
        let (sin, cos) = swing[0].sin_cos();
        let thrust_n = law(module, swing[1].abs());
        let (fx_n, fy_n) = (-thrust_n * cos, -thrust_n * sin);
        sum + Wrench { fx_n, fy_n, tau_nm: x * fy_n - y * fx_n }
    })
}

fn is_near(seen: Wrench, expected: Wrench) {
    let off = (Wrench::from_array([0, 1, 2].map(|i| seen.to_array()[i] - expected.to_array()[i])))
        .weighted_norm([1.0, 1.0, 10.0]);
    assert!(off < 1e-5, "{seen:?} against {expected:?}");
}

#[test]
fn thrust_follows_the_real_law_of_each_module() {
    let thrust = ThrustParameters {
        slope_n_rad: Some(0.03),
        offset_n: Some(0.02),
        module_share: vec![1.0, 0.5, 1.2],
        ..ThrustParameters::default()
    };
    let tank = TankParameters { thrust, ..TankParameters::default() };
    let shares = [1.0, 0.5, 1.2];
    is_near(mean_wrench(&tank, 3), by_7(|module, amplitude| shares[module] * (0.03 * amplitude - 0.02)));
}

#[test]
fn thrust_spreads_within_its_share_by_the_seed() {
    let thrust = ThrustParameters { spread: 0.15, ..ThrustParameters::default() };
    let mut drawn = Vec::new();
    for seed in 0..200 {
        let shares = thrust.shares(&Parameters::default(), 9, seed);
        assert_eq!(shares, thrust.shares(&Parameters::default(), 9, seed));
        assert!(shares.iter().all(|share| (0.85..=1.15).contains(share)), "seed {seed}: {shares:?}");
        drawn.extend(shares);
    }
    let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
    let deviation = (drawn.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / drawn.len() as f64).sqrt();
    // Uniform: 0.15/√3, over 1800 values.
    assert!((mean - 1.0).abs() < 0.01 && (deviation / 0.0866 - 1.0).abs() < 0.05, "{mean} ± {deviation}");
    assert_ne!(thrust.shares(&Parameters::default(), 9, 0), thrust.shares(&Parameters::default(), 9, 1));
    let tank = TankParameters { thrust: thrust.clone(), ..TankParameters::default() };
    let shares = thrust.shares(&Parameters::default(), 3, 8 ^ SPREAD);
    is_near(mean_wrench(&tank, 8), by_7(|module, amplitude| shares[module] * (0.022 * amplitude - 0.019)));
}

/// In a row the middle module has neighbours at ±x: of a jet along cos φ₀ it loses κ·cos²φ₀; those at the ends only towards the middle.
#[test]
fn a_neighbour_in_the_jet_takes_its_share() {
    let thrust = ThrustParameters { interaction: 0.2, ..ThrustParameters::default() };
    let tank = TankParameters { thrust, ..TankParameters::default() };
    let lost = |module: usize| {
        let cos = SWINGS[module][0].cos();
        let meets = match module {
            0 => cos > 0.0,
            2 => cos < 0.0,
            _ => true,
        };
        if meets { 0.2 * cos * cos } else { 0.0 }
    };
    is_near(
        mean_wrench(&tank, 0),
        by_7(|module, amplitude| (1.0 - lost(module)) * (0.022 * amplitude - 0.019)),
    );
}

/// A structure that is short against a long wave floats along with the water.
#[test]
fn without_drag_the_structure_follows_a_long_wave() {
    let believed = Parameters { drag_n_s2_m2: 0.0, yaw_drag_n_m_s2: 0.0, ..Parameters::default() };
    let wave = WaveParameters { height_m: 0.02, period_s: 2.5, direction_rad: 0.6 };
    let parameters = TankParameters { wave, added_mass_sway: 0.9, ..TankParameters::default() };
    // At rest where and when the water turns: u(t) = aω·cos(ωt) at the origin, a = 0.01 m.
    let u_m_s = 0.01 * TAU / 2.5;
    let start = PoseSample {
        heading_rad: 0.3,
        velocity_m_s: [u_m_s * 0.6_f64.cos(), u_m_s * 0.6_f64.sin()],
        ..PoseSample::default()
    };
    let mut tank = Tank::new(&row(), &believed, &parameters, &start, 0).expect("valid");
    let rest = waveforms([[0.0, 0.0]; 3], 0.0);
    for step in 1..=5000 {
        tank.step(DT_S, &rest);
        let t_s = f64::from(step) * DT_S;
        let now_m_s = u_m_s * (TAU / 2.5 * t_s).cos();
        let v = tank.pose().velocity_m_s;
        // λ = 9.8 m against 0.3 m; it moves by 1 cm in the wave meanwhile.
        assert!(
            (v[0] - now_m_s * 0.6_f64.cos()).hypot(v[1] - now_m_s * 0.6_f64.sin()) < 0.01 * u_m_s,
            "{t_s} s"
        );
    }
}

/// Everything in it but gusts, whose axes are the world's.
fn rich(current_m_s: [f64; 2], direction_rad: f64) -> TankParameters {
    TankParameters {
        centre_of_mass_m: [0.02, 0.03],
        drag_sway_n_s2_m2: Some(8.0),
        drag_cross_n_s2_m2: 2.0,
        drag_centre_m: [0.03, 0.01],
        yaw_drag_speed: 1.0,
        current_m_s,
        thrust: ThrustParameters { spread: 0.1, interaction: 0.1, ..ThrustParameters::default() },
        wave: WaveParameters { height_m: 0.01, period_s: 0.9, direction_rad },
        jonswap: JonswapParameters { height_m: 0.01, direction_rad, ..JonswapParameters::default() },
        ..TankParameters::default()
    }
}

fn swum(tank: &TankParameters, start: &PoseSample) -> PoseSample {
    let mut tank = Tank::new(&row(), &Parameters::default(), tank, start, 4).expect("valid");
    (1..=20_000).for_each(|step| tank.step(DT_S, &waveforms(SWINGS, f64::from(step) * DT_S)));
    tank.pose()
}

#[test]
fn a_tank_turned_as_a_whole_gives_the_same_motion_turned() {
    let turn = |by_rad: f64, [x, y]: [f64; 2]| {
        let (sin, cos) = by_rad.sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    };
    let (current, place, velocity) = ([0.01, -0.02], [0.4, 1.1], [0.02, 0.01]);
    let run = |by_rad: f64| {
        let start = PoseSample {
            position_m: turn(by_rad, place),
            velocity_m_s: turn(by_rad, velocity),
            heading_rad: 0.2 + by_rad,
            ..PoseSample::default()
        };
        swum(&rich(turn(by_rad, current), 0.5 + by_rad), &start)
    };
    let plain = run(0.0);
    for by_rad in [0.9, -2.2, 3.0] {
        let turned = run(by_rad);
        for (seen, expected) in [
            (turned.position_m, turn(by_rad, plain.position_m)),
            (turned.velocity_m_s, turn(by_rad, plain.velocity_m_s)),
        ] {
            assert!(
                (seen[0] - expected[0]).hypot(seen[1] - expected[1]) < 1e-9,
                "{by_rad}: {seen:?} {expected:?}"
            );
        }
        assert!((turned.heading_rad - plain.heading_rad - by_rad).abs() < 1e-9, "{by_rad}");
    }
}

#[test]
fn in_flat_water_the_place_does_not_matter() {
    let calm = || {
        let mut parameters = rich([0.01, -0.02], 0.0);
        (parameters.wave, parameters.jonswap) = (WaveParameters::default(), JonswapParameters::default());
        parameters
    };
    let here = swum(&calm(), &PoseSample { heading_rad: 0.4, ..PoseSample::default() });
    let there =
        swum(&calm(), &PoseSample { position_m: [30.0, -7.0], heading_rad: 0.4, ..PoseSample::default() });
    let moved =
        [there.position_m[0] - 30.0 - here.position_m[0], there.position_m[1] + 7.0 - here.position_m[1]];
    assert!(moved[0].hypot(moved[1]) < 1e-9, "{moved:?}");
    assert!((here.heading_rad - there.heading_rad).abs() < 1e-12);
}

#[test]
fn the_same_seed_gives_the_same_sea_and_thrust_to_the_bit() {
    let end = |seed| {
        let mut tank =
            Tank::new(&row(), &Parameters::default(), &rich([0.0; 2], 0.4), &PoseSample::default(), seed)
                .expect("valid");
        (1..=3000).for_each(|step| tank.step(DT_S, &waveforms(SWINGS, f64::from(step) * DT_S)));
        tank.pose()
    };
    assert_eq!(end(3), end(3));
    assert_ne!(end(3), end(4));
}
