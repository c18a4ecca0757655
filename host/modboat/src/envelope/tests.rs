use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::super::structure::Structure;
use super::*;

/// 0.022·2.6 − 0.019 N.
const F: f64 = 0.0382;
const D: f64 = 0.15;
const LONE: &str = "#";
const PAIR: &str = "##";
const LINE: &str = "###";
const COLUMN: &str = "#\n#\n#";
const CORNER: &str = "#.\n##";
const PLUS: &str = ".#.\n###\n.#.";
const RING: &str = "####\n#..#\n#..#\n####";
const HAMMER: &str = "####.....\n#########\n####.....";

fn positions(picture: &str) -> Vec<[f64; 2]> {
    Structure::from_picture(picture).unwrap().positions_m(D)
}

fn envelope(picture: &str) -> Envelope {
    Envelope::new(&positions(picture), &Parameters::default())
}

fn square(side: usize) -> String {
    vec!["#".repeat(side); side].join("\n")
}

fn wrench(fx_n: f64, fy_n: f64, tau_nm: f64) -> Wrench {
    Wrench { fx_n, fy_n, tau_nm }
}

fn close(found: f64, told: f64, what: &str) {
    assert!((found - told).abs() <= 1e-10 * told, "{what}: {found:.15e}, not {told:.15e}");
}

/// A point of the border and a normal there: every module pushes along Mᵢn.
fn border(positions_m: &[[f64; 2]], n: [f64; 3]) -> Wrench {
    positions_m.iter().fold(Wrench::default(), |sum, &[x, y]| {
        let (across, up) = (n[0] - n[2] * y, n[1] + n[2] * x);
        let size = across.hypot(up);
        let (u_x, u_y) = (F * across / size, F * up / size);
        sum + wrench(u_x, u_y, x * u_y - y * u_x)
    })
}

fn normal(rng: &mut ChaCha8Rng) -> [f64; 3] {
    [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), rng.random_range(-8.0..8.0)]
}

/// λ by an interior-point solver of cone programs: greatest λ for Σ (uᵢ, rᵢ × uᵢ) = λ·d, ‖uᵢ‖ ≤ 1; lengths in D.
fn interior_point(positions_m: &[[f64; 2]], d: [f64; 3]) -> f64 {
    let n = positions_m.len();
    let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |row: usize, column: usize, value: f64| {
        i.push(row);
        j.push(column);
        v.push(value);
    };
    let mut b = vec![0.0; 3 + 3 * n];
    for (row, demand) in d.iter().enumerate() {
        add(row, 2 * n, -demand);
    }
    for (k, [x, y]) in positions_m.iter().map(|r| r.map(|v| v / D)).enumerate() {
        let (across, up) = (2 * k, 2 * k + 1);
        add(0, across, 1.0);
        add(1, up, 1.0);
        add(2, across, -y);
        add(2, up, x);
        // (1, u) in the cone
        b[3 + 3 * k] = 1.0;
        add(4 + 3 * k, across, -1.0);
        add(5 + 3 * k, up, -1.0);
    }
    let a = CscMatrix::new_from_triplets(b.len(), 2 * n + 1, i, j, v);
    let mut q = vec![0.0; 2 * n + 1];
    q[2 * n] = -1.0;
    let cones = [&[SupportedConeT::ZeroConeT(3)][..], &vec![SupportedConeT::SecondOrderConeT(3); n]].concat();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-12,
        ..DefaultSettings::default()
    };
    let p = CscMatrix::zeros((2 * n + 1, 2 * n + 1));
    let mut solver = DefaultSolver::new(&p, &q, &a, &b, &cones, settings).expect("a problem");
    solver.solve();
    solver.solution.x[2 * n]
}

/// All push the same way: N·F, whatever the shape, and no torque about the centre of mass.
#[test]
fn a_pure_force_takes_all_modules() {
    for picture in [LONE, PAIR, LINE, COLUMN, CORNER, PLUS, RING, HAMMER, &square(9)] {
        let (envelope, n) = (envelope(picture), positions(picture).len() as f64);
        for turn in 0..12 {
            let (sin, cos) = (f64::from(turn) * 0.5).sin_cos();
            close(envelope.gauge(wrench(0.01 * cos, 0.01 * sin, 0.0)), 0.01 / (n * F), picture);
            close(envelope.support([cos, sin, 0.0]), n * F, picture);
        }
    }
}

/// The greatest pure torque is F times the least sum of distances from any point to the modules.
#[test]
fn a_pure_torque_is_fermats_point() {
    let told = [
        // Between the two, anywhere: flat.
        (PAIR, D),
        // On the middle one: a kink.
        (LINE, 2.0 * D),
        (COLUMN, 2.0 * D),
        ("#####", 6.0 * D),
        // Flat between the middle two.
        ("####", 4.0 * D),
        (PLUS, 4.0 * D),
        // Fermat's point of a right-angled triangle with legs 1: (1 + √3)/√2.
        (CORNER, D * (1.0 + 3.0_f64.sqrt()) / 2.0_f64.sqrt()),
        // The crossing of the diagonals.
        ("##\n##", 2.0 * D * 2.0_f64.sqrt()),
    ];
    for (picture, sum_m) in told {
        for sign in [-1.0, 1.0] {
            close(envelope(picture).gauge(wrench(0.0, 0.0, sign * 0.001)), 0.001 / (F * sum_m), picture);
        }
        let boundary = envelope(picture).boundary(wrench(0.0, 0.0, 3.0));
        close(boundary.tau_nm, F * sum_m, picture);
    }
    // The support takes the normal as it is: the lever is that about the centre of mass.
    let sum_m: f64 = positions(CORNER).iter().map(|[x, y]| x.hypot(*y)).sum();
    close(envelope(CORNER).support([0.0, 0.0, 1.0]), F * sum_m, "levers");
}

/// Two side by side share the torque as ±u_y; what is left of each disc is force along the pair.
#[test]
fn two_modules_in_closed_form() {
    let envelope = envelope(PAIR);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..2000 {
        let [left, right] = [0; 2].map(|_| F * rng.random_range(-1.0..1.0_f64));
        let along = [left, right].map(|up| (F * F - up * up).sqrt()).iter().sum::<f64>();
        let torque = 0.5 * D * (right - left);
        let share = rng.random_range(0.1..3.0);
        let demand = [along, left + right, torque].map(|v| v * share);
        close(envelope.gauge(Wrench::from_array(demand)), share, &format!("{demand:?}"));
    }
}

/// What is pushed along Mᵢn lies on the border, and nothing of the envelope beyond its plane.
#[test]
fn points_of_the_border_have_gauge_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let long = "#".repeat(200);
    for (picture, cases) in
        [(LINE, 500), (CORNER, 500), (RING, 500), (HAMMER, 500), (&square(32), 50), (&long, 50)]
    {
        let (envelope, positions_m) = (envelope(picture), positions(picture));
        for case in 0..cases {
            let n = normal(&mut rng);
            let mut point = border(&positions_m, n);
            let what = format!("seed 3, case {case} of {picture}");
            let [fx, fy, tau] = point.to_array();
            close(n[0] * fx + n[1] * fy + n[2] * tau, envelope.support(n), &what);
            close(envelope.gauge(point), 1.0, &what);
            // A module that stands on the pole pushes nowhere in particular: still on the border.
            let mut others = positions_m.clone();
            let [x, y] = others.swap_remove(case % positions_m.len());
            let share = rng.random_range(0.0..1.0);
            let pole = [y, -x, 1.0];
            let (sin, cos) = rng.random_range(0.0..6.3_f64).sin_cos();
            let (u_x, u_y) = (F * share * cos, F * share * sin);
            point = border(&others, pole) + wrench(u_x, u_y, x * u_y - y * u_x);
            close(envelope.gauge(point), 1.0, &format!("{what}, about module {case}"));
            // And with the pole beside the module, as near as can be.
            let off = 10.0_f64.powf(rng.random_range(-14.0..-2.0));
            point = border(&positions_m, [pole[0] + off * cos, pole[1] + off * sin, 1.0]);
            close(envelope.gauge(point), 1.0, &format!("{what}, {off:e} m beside module {case}"));
        }
    }
}

/// Against a solver of cone programs, from the inside: thrusts in place of planes.
#[test]
fn the_multiple_is_that_of_a_cone_program() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for picture in [PAIR, LINE, COLUMN, CORNER, PLUS, RING, HAMMER, &square(6)] {
        let (envelope, positions_m) = (envelope(picture), positions(picture));
        for case in 0..40 {
            // Some along the axes: the kinks lie there.
            let axis = |rng: &mut ChaCha8Rng| if rng.random_range(0..3) > 0 { 1.0 } else { 0.0 };
            let d = [0; 3].map(|_| axis(&mut rng) * rng.random_range(-1.0..1.0));
            if d.iter().all(|v: &f64| v.abs() < 1e-3) {
                continue;
            }
            let gauge = envelope.gauge(wrench(d[0], d[1], d[2] * D));
            let told = 1.0 / (F * interior_point(&positions_m, d));
            assert!((gauge - told).abs() < 3e-9 * told, "seed 4, {picture} {case} {d:?}: {gauge} {told}");
        }
    }
}

#[test]
fn the_gauge_is_a_norm() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for picture in [PAIR, LINE, CORNER, HAMMER] {
        let envelope = envelope(picture);
        for case in 0..200 {
            let [a, b] = [0; 2].map(|_| {
                let [x, y, tau] = normal(&mut rng);
                wrench(x, y, 0.01 * tau)
            });
            let what = format!("seed 5, {picture} {case}: {a:?} {b:?}");
            let gauge = envelope.gauge(a);
            for factor in [-1.0, 1e-9, 7.0, 1e6, 1e200, 1e-200] {
                let scaled = Wrench::from_array(a.to_array().map(|v| v * factor));
                close(envelope.gauge(scaled), gauge * factor.abs(), &what);
            }
            assert!(envelope.gauge(a + b) <= (gauge + envelope.gauge(b)) * (1.0 + 1e-10), "{what}");
            close(envelope.gauge(envelope.boundary(a)), 1.0, &what);
        }
    }
}

/// Mirrored across the surge axis and turned by a right angle, a square answers alike.
#[test]
fn a_symmetric_shape_has_a_symmetric_envelope() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for picture in [PLUS, RING, &square(5)] {
        let envelope = envelope(picture);
        for _ in 0..200 {
            let [x, y, tau] = normal(&mut rng);
            let gauge = envelope.gauge(wrench(x, y, 0.05 * tau));
            close(envelope.gauge(wrench(-x, y, -0.05 * tau)), gauge, picture);
            close(envelope.gauge(wrench(-y, x, 0.05 * tau)), gauge, picture);
        }
    }
}

#[test]
fn one_module_has_no_torque_and_zero_takes_nothing() {
    let lone = envelope(LONE);
    close(lone.gauge(wrench(0.03, -0.04, 0.0)), 0.05 / F, "a force");
    close(-lone.boundary(wrench(0.0, -2.0, 0.0)).fy_n, F, "a force");
    for demand in [wrench(0.0, 0.0, 1e-9), wrench(0.01, 0.0, -1e-9)] {
        assert!(lone.gauge(demand).is_infinite(), "{demand:?}");
        assert_eq!(lone.boundary(demand), Wrench::default());
    }
    for picture in [LONE, PAIR, RING] {
        let envelope = envelope(picture);
        assert!(envelope.gauge(Wrench::default()) == 0.0, "{picture}");
        assert_eq!(envelope.boundary(Wrench::default()), Wrench::default());
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(envelope.gauge(wrench(0.0, bad, 0.0)).is_infinite(), "{picture}: {bad}");
        }
    }
}

/// Shared out, a wrench is given back by the sum of the thrusts, and no thrust is greater than the gauge says.
#[test]
fn a_wrench_is_shared_out_by_least_greatest_thrusts() {
    let seed = 9;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut thrusts_n = Vec::new();
    for picture in [PAIR, LINE, CORNER, RING, HAMMER, &square(5)] {
        let (positions_m, envelope) = (positions(picture), envelope(picture));
        for _ in 0..100 {
            let share = rng.random_range(0.05..1.0);
            let asked =
                Wrench::from_array(border(&positions_m, normal(&mut rng)).to_array().map(|f| share * f));
            envelope.thrusts(asked, &mut thrusts_n);
            let given = thrusts_n.iter().zip(&positions_m).fold(Wrench::default(), |sum, (u, at)| {
                sum + wrench(u[0], u[1], at[0] * u[1] - at[1] * u[0])
            });
            let off = (given - asked).weighted_norm([1.0, 1.0, 10.0]);
            let norm = asked.weighted_norm([1.0, 1.0, 10.0]);
            assert!(off <= 1e-4 * norm, "seed {seed}, {picture}: {given:?} for {asked:?}");
            let most_n = thrusts_n.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
            assert!(most_n <= share * F * (1.0 + 1e-9), "seed {seed}, {picture}: {most_n} N at {share}");
        }
    }
    let lone = envelope(LONE);
    lone.thrusts(wrench(0.01, -0.02, 0.0), &mut thrusts_n);
    assert_eq!(thrusts_n, [[0.01, -0.02]]);
    lone.thrusts(wrench(0.0, 0.0, 0.01), &mut thrusts_n);
    assert!(thrusts_n.is_empty(), "it has no torque to give");
}
