//! Energies of legs and turns against fine numerical integrals, fine grids of speeds, and values by hand.

use super::*;

const BATTERY_V: f64 = 16.0;
const ACCELERATION_M_S2: f64 = 0.2;
const SPEEDS_M_S: [f64; 2] = [0.1, 0.5];
/// Ahead, astern, sideways, down, up, and slanting.
const DIRECTIONS: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [0.6, -0.64, 0.48],
];

fn propulsion(steady: Steady) -> Propulsion {
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    Propulsion::new(&robot, law, &Rules::default(), steady).expect("six thrusters")
}

/// ∫ P dt over a trapezoid of speed by the midpoint rule, and how long it lasts.
fn integral(p: &Propulsion, axis: [f64; 6], way: f64, speed: f64, acceleration: f64) -> (f64, f64) {
    const STEPS: usize = 20_000;
    let peak = speed.min((way * acceleration).sqrt());
    let (ramp_s, duration_s) = (peak / acceleration, way / peak + peak / acceleration);
    let step_s = duration_s / STEPS as f64;
    let power_w = |n: usize| {
        let t_s = (n as f64 + 0.5) * step_s;
        let (v, v_dot) = if t_s < ramp_s {
            (acceleration * t_s, acceleration)
        } else if t_s > duration_s - ramp_s {
            (acceleration * (duration_s - t_s), -acceleration)
        } else {
            (peak, 0.0)
        };
        p.power_w(&axis.map(|a| a * v), &axis.map(|a| a * v_dot)).expect("within the limits")
    };
    ((0..STEPS).map(power_w).sum::<f64>() * step_s, duration_s)
}

#[test]
fn legs_and_turns_are_worth_the_integral_of_their_power() {
    for steady in [Steady::Published, Steady::Whole] {
        let p = propulsion(steady);
        for [x, y, z] in DIRECTIONS {
            // Triangles and trapezoids.
            for (way_m, speed_m_s) in [(0.1, 0.3), (0.483, 0.2), (2.0, 0.1), (3.0, 0.5)] {
                let leg = p.leg([x, y, z], way_m, speed_m_s, Some(ACCELERATION_M_S2)).expect("possible");
                let axis = [x, y, z, 0.0, 0.0, 0.0];
                let (energy_j, duration_s) = integral(&p, axis, way_m, speed_m_s, ACCELERATION_M_S2);
                let off = (leg.energy_j / energy_j - 1.0).abs();
                assert!(off < 3e-3, "{x} {y} {z}: {way_m} m at {speed_m_s} m/s: {leg:?}, {energy_j} J");
                assert!((leg.duration_s - duration_s).abs() < 1e-9);
            }
        }
        for (angle_rad, rate_rad_s) in [(0.3, 1.31), (-1.5, 0.8), (3.0, 1.5)] {
            let turn = p.turn(angle_rad, rate_rad_s, Some(1.0)).expect("possible");
            let axis = [0.0, 0.0, 0.0, 0.0, 0.0, angle_rad.signum()];
            let (energy_j, duration_s) = integral(&p, axis, angle_rad.abs(), rate_rad_s, 1.0);
            let off = (turn.energy_j / energy_j - 1.0).abs();
            assert!(off < 3e-3 && (turn.duration_s - duration_s).abs() < 1e-9, "{turn:?}, {energy_j} J");
        }
    }
}

#[test]
fn turning_costs_what_two_thrusters_draw() {
    let p = propulsion(Steady::Published);
    // N = 0.07 r + 0.227 r² = 0.4813 N·m at 1.31 rad/s, by two thrusters 0.109 m off the axis: ±2.208 N.
    let thrust_n = (0.07 * 1.31 + 0.227 * 1.31 * 1.31) / (2.0 * 0.109);
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    let power_w = law.power_w(thrust_n) + law.power_w(-thrust_n);
    assert!((thrust_n - 2.208).abs() < 1e-3 && (power_w - 6.02).abs() < 0.05, "{thrust_n} N, {power_w} W");
    for angle_rad in [2.0, -2.0] {
        let turn = p.turn(angle_rad, 1.31, None).expect("possible");
        assert!((turn.duration_s - 2.0 / 1.31).abs() < 1e-12);
        assert!((turn.energy_j - power_w * 2.0 / 1.31).abs() < 1e-9, "{turn:?}, {power_w} W");
    }
    assert_eq!(p.turn(0.0, 1.31, None), Some(Expense::default()));
}

#[test]
fn the_best_speed_is_that_of_a_fine_grid() {
    const GRID: u32 = 2000;
    const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
    let p = propulsion(Steady::Whole);
    for direction in DIRECTIONS {
        for way_m in [0.12, 0.5, 2.5] {
            for lambda_w in [0.0, 0.8, 3.2, 40.0] {
                let what = format!("{direction:?}, {way_m} m, λ = {lambda_w} W");
                let best =
                    p.best_leg(direction, way_m, SPEEDS_M_S, ACCELERATION_M_S2, lambda_w).expect("possible");
                let leg = |n: u32, share: f64| {
                    let v = SPEEDS_M_S[0] + (SPEEDS_M_S[1] - SPEEDS_M_S[0]) * f64::from(n) / f64::from(GRID);
                    p.leg(direction, way_m, v, Some(share * ACCELERATION_M_S2))
                };
                let grid = (0..=GRID).flat_map(|n| SHARES.map(|share| leg(n, share)));
                let least = grid.flatten().map(|leg| leg.with_others(lambda_w)).fold(f64::INFINITY, f64::min);
                let found = best.with_others(lambda_w);
                assert!((found / least - 1.0).abs() < 1e-4, "{what}: {found} J, {least} J on the grid");
                assert!(best.speed <= SPEEDS_M_S[1] + 1e-12, "{what}: {best:?}");
            }
        }
    }
    for angle_rad in [0.2, 1.57, 3.1] {
        let best = p.best_turn(angle_rad, [0.2, 1.5], 1.0, 3.2).expect("possible");
        let rates = (0..=GRID).map(|n| 0.2 + 1.3 * f64::from(n) / f64::from(GRID));
        let turns = rates.flat_map(|rate| SHARES.map(|share| p.turn(angle_rad, rate, Some(share))));
        let least = turns.flatten().map(|turn| turn.with_others(3.2)).fold(f64::INFINITY, f64::min);
        let found = best.with_others(3.2);
        assert!((found / least - 1.0).abs() < 1e-4, "{angle_rad} rad: {found} J, {least} J on the grid");
    }
}

#[test]
fn a_long_leg_costs_its_steady_power() {
    let p = propulsion(Steady::Whole);
    let nu = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    let power_w = p.power_w(&nu, &[0.0; 6]).expect("possible");
    // By hand, thrusters 2 cm below the centre, whose pitch the upright ones take: at least the two that push.
    let drag_n = 4.03 * 0.3 + 18.18 * 0.09;
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    assert!(
        power_w > 2.0 * law.power_w(drag_n / 2.0) && power_w < 2.2 * law.power_w(drag_n / 2.0),
        "{power_w} W"
    );
    for (way_m, most) in [(10.0, 0.2), (1000.0, 2e-3)] {
        let leg = p.leg([1.0, 0.0, 0.0], way_m, 0.3, Some(ACCELERATION_M_S2)).expect("possible");
        let off = leg.energy_j / (power_w * way_m / 0.3) - 1.0;
        assert!(off.abs() < most, "{way_m} m: off by {off}");
        let constant = p.leg([1.0, 0.0, 0.0], way_m, 0.3, None).expect("possible");
        assert!((constant.energy_j - power_w * way_m / 0.3).abs() < 1e-9 * constant.energy_j);
    }
}
