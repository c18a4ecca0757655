use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::DVector;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;

use super::super::power::{PowerCurve, limits_n};
use super::*;

fn bluerov1() -> Vehicle {
    Vehicle::built_in("bluerov1").unwrap()
}

fn cluster(poses: &[[f64; 4]]) -> ConfigurationMatrix {
    let robot = bluerov1();
    let members: Vec<_> = poses.iter().map(|pose| (&robot, Pose::from(*pose))).collect();
    ConfigurationMatrix::of_cluster(&members, &Pose::default()).unwrap()
}

fn laws() -> [PowerLaw; 3] {
    [PowerLaw::quadratic(0.14).unwrap(), PowerLaw::fitted(16.0).unwrap(), PowerLaw::table(16.0).unwrap()]
}

fn allocator(poses: &[[f64; 4]], law: &PowerLaw) -> Allocator {
    let matrix = cluster(poses);
    let limits = vec![limits_n(16.0).unwrap(); matrix.thrusters()];
    Allocator::new(matrix, &limits, law.clone()).unwrap()
}

/// Wings and two stems around the tool.
const T_SHAPE: [[f64; 4]; 4] =
    [[0.0, -0.33, 0.0, 0.0], [0.0, 0.33, 0.0, 0.0], [-0.483, 0.0, 0.0, 0.0], [-0.966, 0.0, 0.0, 0.0]];

fn random(rng: &mut ChaCha8Rng, size: f64) -> [f64; 6] {
    std::array::from_fn(|k| size * if k < 3 { 1.0 } else { 0.3 } * rng.random_range(-1.0..1.0))
}

fn distance(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn norm(a: &[f64; 6]) -> f64 {
    distance(a, &[0.0; 6])
}

/// Whether nothing of the demand is missing: told as exactly 1, never more ([`check`]).
fn all_of(found: &Allocation) -> bool {
    found.served >= 1.0
}

/// Served share of the demand made, limits kept, power and missing wrench as told.
fn check(allocator: &Allocator, demand: &[f64; 6], found: &Allocation, what: &str) {
    assert!((0.0..=1.0).contains(&found.served), "{what}: {}", found.served);
    let served = demand.map(|d| d * found.served);
    let off = distance(&allocator.wrench(&found.thrusts_n), &served);
    assert!(off <= 1e-8 * norm(demand), "{what}: {off} N off {demand:?}");
    for (u, (low, high)) in found.thrusts_n.iter().zip(&allocator.limits_n) {
        assert!((*low..=*high).contains(u), "{what}: {u} N outside {low}..{high}");
    }
    let power: f64 = found.thrusts_n.iter().map(|u| allocator.law.power_w(*u)).sum();
    assert!((found.power_w - power).abs() <= 1e-12 * power, "{what}");
    let told: [f64; 6] = std::array::from_fn(|k| served[k] + found.missing[k]);
    assert!(distance(&told, demand) <= 1e-12 * norm(demand), "{what}");
}

/// Least η Σu² for T u = τ within limits, or `None` if there is none, by an interior-point solver. With `share`, the
/// greatest share of τ instead.
fn interior_point(allocator: &Allocator, demand: &[f64; 6], share: bool) -> Option<f64> {
    let t = allocator.matrix.matrix();
    let n = t.ncols();
    let columns = n + usize::from(share);
    let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |row: usize, column: usize, value: f64| {
        i.push(row);
        j.push(column);
        v.push(value);
    };
    let mut b = vec![0.0; 6];
    for row in 0..6 {
        for column in 0..n {
            add(row, column, t[(row, column)]);
        }
        if share {
            add(row, n, -demand[row]);
        } else {
            b[row] = demand[row];
        }
    }
    let bounds: Vec<_> = allocator.limits_n.iter().copied().chain(share.then_some((0.0, 1.0))).collect();
    for (column, (low, high)) in bounds.iter().enumerate() {
        add(b.len(), column, 1.0);
        b.push(*high);
        add(b.len(), column, -1.0);
        b.push(-low);
    }
    let a = CscMatrix::new_from_triplets(b.len(), columns, i, j, v);
    let weight = if share { 0.0 } else { 2.0 * 0.14 };
    let p =
        CscMatrix::new_from_triplets(columns, columns, (0..n).collect(), (0..n).collect(), vec![weight; n]);
    let mut q = vec![0.0; columns];
    if share {
        q[n] = -1.0;
    }
    let cones = [SupportedConeT::ZeroConeT(6), SupportedConeT::NonnegativeConeT(2 * bounds.len())];
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(&p, &q, &a, &b, &cones, settings).unwrap();
    solver.solve();
    (format!("{:?}", solver.solution.status) == "Solved").then_some(solver.solution.obj_val)
}

#[test]
fn one_robot_has_one_solution_and_scales_it_at_its_limits() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for law in laws() {
        let allocator = allocator(&[[0.0; 4]], &law);
        assert!(allocator.direct.is_some());
        for _ in 0..200 {
            // Thrusts chosen first, some beyond the limits.
            let thrusts: [f64; 6] = std::array::from_fn(|_| rng.random_range(-70.0..70.0));
            let demand = allocator.wrench(&thrusts);
            let found = allocator.allocate(&demand).unwrap();
            check(&allocator, &demand, &found, "one robot");
            let (low, high) = limits_n(16.0).unwrap();
            let expected =
                thrusts.iter().map(|u| if *u < 0.0 { low / u } else { high / u }).fold(1.0, f64::min);
            assert!((found.served - expected).abs() < 1e-9);
            for (u, expected) in found.thrusts_n.iter().zip(thrusts.map(|u| u * found.served)) {
                assert!((u - expected).abs() < 1e-9 * 70.0);
            }
        }
    }
}

#[test]
fn without_limits_the_quadratic_law_gives_the_least_norm() {
    let allocator = allocator(&T_SHAPE, &PowerLaw::quadratic(0.14).unwrap());
    let pseudo_inverse = allocator.matrix.matrix().clone().pseudo_inverse(1e-12).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..100 {
        let demand = random(&mut rng, 20.0);
        let found = allocator.allocate(&demand).unwrap();
        let expected = &pseudo_inverse * Vector6::from(demand);
        let off = found.thrusts_n.iter().zip(expected.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 && all_of(&found), "{demand:?}: {off}");
    }
}

#[test]
fn the_quadratic_law_fulfils_kkt_and_agrees_with_an_interior_point_solver() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut at_limits = 0;
    for round in 0..60 {
        let mut allocator = allocator(&T_SHAPE, &PowerLaw::quadratic(0.14).unwrap());
        if round % 3 == 0 {
            // A failed thruster, a weak one and one that only pushes.
            allocator.limits_n[rng.random_range(0..24)] = (0.0, 0.0);
            allocator.limits_n[rng.random_range(0..24)] = (-2.0, 3.0);
            allocator.limits_n[rng.random_range(0..24)] = (0.0, 40.0);
        }
        let limits = allocator.limits_n.clone();
        let allocator = Allocator::new(allocator.matrix, &limits, allocator.law).unwrap();
        let demand = random(&mut rng, 200.0);
        let found = allocator.allocate(&demand).unwrap();
        check(&allocator, &demand, &found, "quadratic");
        let share = -interior_point(&allocator, &demand, true).unwrap();
        assert!((share - found.served).abs() < 1e-7, "round {round}: {share} {}", found.served);
        // At the end of the reach an interior point is hard to find: ask for a little less.
        let demand = if found.served < 1.0 { demand.map(|d| d * found.served * 0.999) } else { demand };
        let found = allocator.allocate(&demand).unwrap();
        assert!(all_of(&found), "round {round}: {}", found.served);
        let power = interior_point(&allocator, &demand, false).unwrap();
        assert!((power / found.power_w - 1.0).abs() < 1e-6, "round {round}: {power} {}", found.power_w);
        // 2ηu = Tᵀλ between the limits; λ from those thrusters, its sign checked at the others.
        let free: Vec<usize> = (0..24)
            .filter(|&k| found.thrusts_n[k] > limits[k].0 + 1e-9 && found.thrusts_n[k] < limits[k].1 - 1e-9)
            .collect();
        at_limits += 24 - free.len();
        let t = allocator.matrix.matrix();
        let own = DMatrix::from_fn(free.len(), 6, |row, axis| t[(axis, free[row])]);
        let marginal = DVector::from_fn(free.len(), |row, _| 0.28 * found.thrusts_n[free[row]]);
        let lambda = own.clone().svd(true, true).solve(&marginal, 1e-12).unwrap();
        let off = (own * &lambda - &marginal).amax();
        assert!(off < 1e-7, "round {round}: stationarity {off} W/N");
        if free.len() >= 6 {
            for k in (0..24).filter(|k| !free.contains(k) && limits[*k].1 > limits[*k].0) {
                let pull = t.column(k).dot(&lambda) - 0.28 * found.thrusts_n[k];
                let outwards = if found.thrusts_n[k] > limits[k].1 - 1e-9 { pull } else { -pull };
                assert!(outwards > -1e-6, "round {round}, thruster {k}: {outwards}");
            }
        }
    }
    assert!(at_limits > 20, "{at_limits} limits were met: demands too small for this test");
}

#[test]
fn no_neighbour_within_the_limits_is_cheaper() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for law in laws() {
        let allocator = allocator(&T_SHAPE[..3], &law);
        let t = allocator.matrix.matrix().clone();
        let back = t.clone().pseudo_inverse(1e-12).unwrap();
        let mut beyond = 0;
        for round in 0..60 {
            let size = 10.0_f64.powf(rng.random_range(-1.0..3.2));
            let demand = random(&mut rng, size);
            let found = allocator.allocate(&demand).unwrap();
            check(&allocator, &demand, &found, "random demand");
            beyond += usize::from(found.served < 1.0);
            // The table's own power is no convex law: there its envelope is what is least.
            let cost = |u: &DVector<f64>| -> f64 {
                match &allocator.law {
                    PowerLaw::Table(_) => u.iter().map(|u| envelope_w(&allocator.law, *u)).sum(),
                    law => u.iter().map(|u| law.power_w(*u)).sum(),
                }
            };
            let here = DVector::from_vec(found.thrusts_n.clone());
            let least = cost(&here);
            for _ in 0..300 {
                let size = 10.0_f64.powf(rng.random_range(-3.0..1.0));
                let aside = DVector::from_fn(18, |_, _| size * rng.random_range(-1.0..1.0));
                // Into the null space: the wrench stays.
                let there = &here + &aside - &back * (&t * &aside);
                let inside =
                    there.iter().zip(&allocator.limits_n).all(|(u, (low, high))| u >= low && u <= high);
                assert!(
                    !inside || cost(&there) >= least - 1e-7 * least,
                    "seed 4, round {round}: {} W below {least} W for {demand:?}",
                    cost(&there)
                );
            }
        }
        assert!(beyond > 3 && beyond < 50, "{beyond} of 60 demands beyond the reach");
    }
}

fn envelope_w(law: &PowerLaw, u: f64) -> f64 {
    let mut pieces: Vec<_> = law.pieces().into_iter().filter(|piece| piece.forward == (u > 0.0)).collect();
    pieces.sort_by(|a, b| a.slope_w_n.total_cmp(&b.slope_w_n));
    let mut left = u.abs();
    pieces
        .iter()
        .map(|piece| {
            let part = left.min(piece.width_n);
            left -= part;
            part * piece.slope_w_n
        })
        .sum()
}

#[test]
fn of_three_parallel_thrusters_the_split_is_the_one_of_a_fine_grid() {
    let robot = Vehicle {
        thrusters: [-0.2, 0.0, 0.3]
            .map(|y| reconfiguration::vehicle::Thruster {
                position_m: [0.0, y, 0.0],
                direction: [1.0, 0.0, 0.0],
                reversed: false,
                failed: false,
            })
            .to_vec(),
        ..bluerov1()
    };
    let law = PowerLaw::fitted(16.0).unwrap();
    let limits = [(-20.0, 20.0), (-3.0, 3.0), (-20.0, 20.0)];
    let matrix = ConfigurationMatrix::of_vehicle(&robot).unwrap();
    let message = matrix.require_full_rank().unwrap_err().to_string();
    let allocator = Allocator::new(matrix, &limits, law.clone()).unwrap();
    assert_eq!(message, "thruster matrix of rank 2: cannot push in sway, heave, roll, pitch");
    for (surge_n, yaw_nm) in [(4.0, 0.0), (1.0, 1.5), (-12.0, 0.4), (25.0, -1.0)] {
        let demand = [surge_n, 0.0, 0.0, 0.0, 0.0, yaw_nm];
        let found = allocator.allocate(&demand).unwrap();
        check(&allocator, &demand, &found, "three parallel thrusters");
        assert!(all_of(&found));
        // u₁ + u₂ + u₃ = X, 0.2 u₁ − 0.3 u₃ = N: the middle thrust is free.
        let least = (-30_000..=30_000)
            .map(|step| f64::from(step) * 1e-4)
            .map(|u2| {
                let u1 = (yaw_nm + 0.3 * (surge_n - u2)) / 0.5;
                [u1, u2, surge_n - u1 - u2].map(|u| law.power_w(u)).iter().sum()
            })
            .fold(f64::INFINITY, f64::min);
        assert!((found.power_w - least).abs() < 1e-6 * least, "{} W, grid {least} W", found.power_w);
    }
    // Sway cannot be made at all, surge with sway neither: the direction counts.
    let found = allocator.allocate(&[1.0, 1.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!((found.served, found.power_w, found.missing[0]), (0.0, 0.0, 1.0));
}

#[test]
fn a_failed_thruster_rests_and_the_others_do_its_work() {
    for law in laws() {
        let whole = allocator(&T_SHAPE[2..], &law);
        let demand = [6.0, 1.0, -2.0, 0.1, 0.6, 0.3];
        let before = whole.allocate(&demand).unwrap();
        for failed in 0..12 {
            let mut limits = whole.limits_n.clone();
            limits[failed] = (0.0, 0.0);
            let lame = Allocator::new(whole.matrix.clone(), &limits, law.clone()).unwrap();
            let found = lame.allocate(&demand).unwrap();
            check(&lame, &demand, &found, "one failed");
            assert!(found.thrusts_n[failed] == 0.0 && all_of(&found));
            if !matches!(law, PowerLaw::Table(_)) {
                assert!(found.power_w >= before.power_w * (1.0 - 1e-9));
            }
        }
    }
    // One robot without its lateral thruster: what needs no sway is still done, sway and the direction it is part of not.
    let mut limits = vec![(-40.0, 50.0); 6];
    limits[5] = (0.0, 0.0);
    let lame = Allocator::new(cluster(&[[0.0; 4]]), &limits, PowerLaw::fitted(16.0).unwrap()).unwrap();
    let demand = [5.0, 0.0, 3.0, 0.2, 0.1, -0.3];
    let found = lame.allocate(&demand).unwrap();
    check(&lame, &demand, &found, "no lateral thruster");
    assert!(all_of(&found));
    let none = lame.allocate(&[0.0, 2.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    assert!(none.served == 0.0 && none.power_w == 0.0);
}

#[test]
fn a_demand_beyond_the_limits_keeps_its_direction() {
    for law in laws() {
        for poses in [&T_SHAPE[..1], &T_SHAPE[..2], &T_SHAPE[2..], &T_SHAPE[..]] {
            let allocator = allocator(poses, &law);
            for axis in 0..6 {
                for sign in [1.0, -1.0] {
                    let mut demand = [0.0; 6];
                    demand[axis] = 5000.0 * sign;
                    let found = allocator.allocate(&demand).unwrap();
                    check(&allocator, &demand, &found, AXES[axis]);
                    assert!(found.served > 0.0 && found.served < 0.5);
                    let share = -interior_point(&allocator, &demand.map(|d| d / 10.0), true).unwrap();
                    let served = (found.served * 10.0).min(1.0);
                    assert!((share - served).abs() < 1e-6, "{}: {share} {served}", AXES[axis]);
                    // Just within the reach everything is served, at less power.
                    let within = demand.map(|d| d * found.served * (1.0 - 1e-6));
                    let near = allocator.allocate(&within).unwrap();
                    assert!((near.served - 1.0).abs() < 1e-9, "{}: {}", AXES[axis], near.served);
                    if !matches!(law, PowerLaw::Table(_)) {
                        let ratio = near.power_w / found.power_w;
                        assert!((0.99..1.0).contains(&ratio), "{}: {ratio}", AXES[axis]);
                    }
                }
            }
        }
    }
}

#[test]
fn balancing_the_tool_costs_least_where_robots_lie_in_line_with_x() {
    // The tool's 0.6 N·m of pitch, robots docked face to face with its box of 0.483 × 0.33 × 0.267 m.
    let line = |xs: &[f64]| xs.iter().map(|x| [0.483 * x, 0.0, 0.0, 0.0]).collect::<Vec<_>>();
    // By the fitted law, and by the law that DESIGN §4 gives the figures for: 3.5 W, 2.3 W, 0.3–0.9 W.
    let cases = [
        ("one robot in front", line(&[1.0]), 3.1..3.5, 3.4..3.8),
        ("two wings", T_SHAPE[..2].to_vec(), 2.0..2.3, 2.2..2.5),
        ("two in front", line(&[1.0, 2.0]), 0.7..0.9, 0.8..0.95),
        ("in front and behind", line(&[1.0, -1.0]), 0.3..0.4, 0.35..0.45),
        ("three in line", line(&[1.0, 2.0, -1.0]), 0.15..0.3, 0.15..0.3),
        ("four in line", line(&[1.0, 2.0, 3.0, 4.0]), 0.15..0.3, 0.15..0.3),
    ];
    let known = PowerLaw::Fitted {
        forward: PowerCurve { coefficient: 0.80, exponent: 1.56 },
        reverse: PowerCurve { coefficient: 1.03, exponent: 1.60 },
    };
    for sign in [0.6, -0.6] {
        let demand = [0.0, 0.0, 0.0, 0.0, sign, 0.0];
        for (name, poses, by_fit, by_known) in &cases {
            let power = |law: &PowerLaw| allocator(poses, law).allocate(&demand).unwrap().power_w;
            let [_, fitted, table] = laws().map(|law| power(&law));
            let known = power(&known);
            println!("{sign:+} N·m of pitch, {name}: {fitted:.2} W; {known:.2} W; table {table:.2} W");
            assert!(by_fit.contains(&fitted), "{sign:+} N·m, {name}: {fitted} W");
            assert!(by_known.contains(&known), "{sign:+} N·m, {name}: {known} W");
        }
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let law = PowerLaw::fitted(16.0).unwrap();
    let make = |limits: &[(f64, f64)]| Allocator::new(cluster(&[[0.0; 4]]), limits, law.clone());
    let message = make(&[(-1.0, 1.0); 5]).unwrap_err().to_string();
    assert_eq!(message, "5 pairs of limits were given for 6 thrusters");
    for bad in [(1.0, 2.0), (-2.0, -1.0), (f64::NAN, 1.0), (-1.0, f64::INFINITY)] {
        let mut limits = [(-1.0, 1.0); 6];
        limits[3] = bad;
        let message = make(&limits).unwrap_err().to_string();
        assert!(message.contains("of thruster 4: rest, 0 N, must be between them"), "{message}");
    }
    let allocator = make(&[(-1.0, 1.0); 6]).unwrap();
    let message = allocator.allocate(&[0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0]).unwrap_err().to_string();
    assert_eq!(message, "the demand in pitch is NaN, a finite number of N or N·m is asked for");
    let message = allocator.allocate_into(&[0.0; 6], &mut [0.0; 4]).unwrap_err().to_string();
    assert_eq!(message, "room for 4 thrusts was given for 6 thrusters");
    let rest = allocator.allocate(&[0.0; 6]).unwrap();
    assert_eq!((rest.served, rest.power_w, rest.missing), (1.0, 0.0, [0.0; 6]));
}
