//! The contract of `flotilla simulate`, through the binary, against equations of motion written out here once more:
//! Newton and Euler for the rigid body, textbook terms for the water, Euler angles, an adaptive integrator.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::common::{Finished, Process};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};
use tempfile::tempdir;

type V3 = [f64; 3];
type Y = [f64; 12];

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn sum(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[derive(Clone)]
struct Rov {
    mass: f64,
    weight: f64,
    buoyancy: f64,
    rg: V3,
    rb: V3,
    inertia: V3,
    added: [f64; 6],
    linear: [f64; 6],
    quadratic: [f64; 6],
}

impl Rov {
    fn json(&self) -> Value {
        json!({"mass_kg": self.mass, "weight_n": self.weight, "buoyancy_n": self.buoyancy, "r_g_m": self.rg,
            "r_b_m": self.rb, "inertia_kg_m2": self.inertia, "added_mass": self.added,
            "linear_damping": self.linear, "quadratic_damping": self.quadratic})
    }

    /// The wrench that gives the acceleration `a` at the velocity `nu` and these angles.
    fn wrench(&self, angles: V3, nu: [f64; 6], a: [f64; 6]) -> [f64; 6] {
        let ([u, v, w, p, q, r], m) = (nu, self.added);
        let (vel, om) = ([u, v, w], [p, q, r]);
        let (dv, dom) = ([a[0], a[1], a[2]], [a[3], a[4], a[5]]);
        // Rigid body: F = m a_G, M_O = d/dt(I ω) + r_G × m a_G.
        let a_g = sum(sum(dv, cross(om, vel)), sum(cross(dom, self.rg), cross(om, cross(om, self.rg))));
        let force = a_g.map(|part| self.mass * part);
        let spin = [self.inertia[0] * p, self.inertia[1] * q, self.inertia[2] * r];
        let turn = [self.inertia[0] * dom[0], self.inertia[1] * dom[1], self.inertia[2] * dom[2]];
        let moment = sum(sum(turn, cross(om, spin)), cross(self.rg, force));
        // Added mass: Fossen 2011, (6.43) times ν.
        let water = [
            m[2] * w * q - m[1] * v * r,
            m[0] * u * r - m[2] * w * p,
            m[1] * v * p - m[0] * u * q,
            (m[2] - m[1]) * v * w + (m[5] - m[4]) * q * r,
            (m[0] - m[2]) * u * w + (m[3] - m[5]) * p * r,
            (m[1] - m[0]) * u * v + (m[4] - m[3]) * p * q,
        ];
        // Restoring: Fossen 2011, (4.6).
        let ([xg, yg, zg], [xb, yb, zb], wt, b) = (self.rg, self.rb, self.weight, self.buoyancy);
        let (sp, cp, st, ct) = (angles[0].sin(), angles[0].cos(), angles[1].sin(), angles[1].cos());
        let g = [
            (wt - b) * st,
            -(wt - b) * ct * sp,
            -(wt - b) * ct * cp,
            -(yg * wt - yb * b) * ct * cp + (zg * wt - zb * b) * ct * sp,
            (zg * wt - zb * b) * st + (xg * wt - xb * b) * ct * cp,
            -(xg * wt - xb * b) * ct * sp - (yg * wt - yb * b) * st,
        ];
        std::array::from_fn(|k| {
            let rigid = if k < 3 { force[k] } else { moment[k - 3] };
            rigid + m[k] * a[k] + water[k] + (self.linear[k] + self.quadratic[k] * nu[k].abs()) * nu[k] + g[k]
        })
    }

    fn rate(&self, y: &Y, tau: [f64; 6]) -> Y {
        let angles = [y[3], y[4], y[5]];
        let nu: [f64; 6] = std::array::from_fn(|k| y[6 + k]);
        // Columns of M: what a unit acceleration takes beyond none.
        let bias = self.wrench(angles, nu, [0.0; 6]);
        let mut rows = [[0.0; 7]; 6];
        for k in 0..6 {
            let mut unit = [0.0; 6];
            unit[k] = 1.0;
            let column = self.wrench(angles, nu, unit);
            for (row, (with, without)) in rows.iter_mut().zip(column.iter().zip(bias)) {
                row[k] = with - without;
            }
            rows[k][6] = tau[k] - bias[k];
        }
        // Gauss–Jordan; M is positive definite.
        for k in 0..6 {
            let pivot = rows[k].map(|entry| entry / rows[k][k]);
            for row in &mut rows {
                let factor = row[k];
                row.iter_mut().zip(pivot).for_each(|(entry, part)| *entry -= factor * part);
            }
            rows[k] = pivot;
        }
        let [u, v, w, p, q, r] = nu;
        let (s, c) = (angles.map(f64::sin), angles.map(f64::cos));
        [
            c[2] * c[1] * u + (c[2] * s[1] * s[0] - s[2] * c[0]) * v + (s[2] * s[0] + c[2] * c[0] * s[1]) * w,
            s[2] * c[1] * u + (c[2] * c[0] + s[0] * s[1] * s[2]) * v + (s[1] * s[2] * c[0] - c[2] * s[0]) * w,
            -s[1] * u + c[1] * s[0] * v + c[1] * c[0] * w,
            p + s[0] * s[1] / c[1] * q + c[0] * s[1] / c[1] * r,
            c[0] * q - s[0] * r,
            (s[0] * q + c[0] * r) / c[1],
            rows[0][6],
            rows[1][6],
            rows[2][6],
            rows[3][6],
            rows[4][6],
            rows[5][6],
        ]
    }

    /// Fehlberg 4(5), going on with the fifth order, at a tolerance of 1e-12.
    fn go(&self, mut y: Y, tau: [f64; 6], duration_s: f64) -> Y {
        const A: [&[f64]; 5] = [
            &[1.0 / 4.0],
            &[3.0 / 32.0, 9.0 / 32.0],
            &[1932.0 / 2197.0, -7200.0 / 2197.0, 7296.0 / 2197.0],
            &[439.0 / 216.0, -8.0, 3680.0 / 513.0, -845.0 / 4104.0],
            &[-8.0 / 27.0, 2.0, -3544.0 / 2565.0, 1859.0 / 4104.0, -11.0 / 40.0],
        ];
        const FIFTH: [f64; 6] =
            [16.0 / 135.0, 0.0, 6656.0 / 12825.0, 28561.0 / 56430.0, -9.0 / 50.0, 2.0 / 55.0];
        const FOURTH: [f64; 6] = [25.0 / 216.0, 0.0, 1408.0 / 2565.0, 2197.0 / 4104.0, -1.0 / 5.0, 0.0];
        let along = |y: &Y, h: f64, weights: &[f64], k: &[Y]| -> Y {
            std::array::from_fn(|n| y[n] + h * weights.iter().zip(k).map(|(a, k)| a * k[n]).sum::<f64>())
        };
        let (mut t, mut h) = (0.0, 1e-3);
        while t < duration_s {
            h = f64::min(h, duration_s - t);
            let mut k = vec![self.rate(&y, tau)];
            for row in A {
                k.push(self.rate(&along(&y, h, row, &k), tau));
            }
            let next = along(&y, h, &FIFTH, &k);
            let other = along(&y, h, &FOURTH, &k);
            let error = next.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if error <= 1e-12 {
                (y, t) = (next, t + h);
            }
            h *= (0.9 * (1e-12 / error.max(1e-30)).powf(0.2)).clamp(0.2, 2.0);
        }
        y
    }
}

fn ask(arguments: &[&str], input: &str) -> Finished {
    let folder = tempdir().expect("a folder");
    Process::given(folder.path(), &[&["simulate"], arguments].concat(), input)
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().expect("a list").iter().map(|item| item.as_f64().expect("a number")).collect()
}

/// A vehicle between a shoebox and a desk, its centre of gravity some way below that of buoyancy.
fn random(rng: &mut ChaCha8Rng) -> Rov {
    let mut some = |low: f64, high: f64| rng.random_range(low..high);
    let mass = some(3.0, 20.0);
    let weight = 9.81 * mass;
    Rov {
        mass,
        weight,
        buoyancy: weight + some(-2.0, 2.0),
        rg: [some(-0.02, 0.02), some(-0.02, 0.02), some(0.01, 0.04)],
        rb: [some(-0.02, 0.02), some(-0.02, 0.02), some(-0.02, 0.0)],
        inertia: [some(0.05, 0.4), some(0.05, 0.4), some(0.05, 0.4)],
        added: [
            some(0.0, 20.0),
            some(0.0, 20.0),
            some(0.0, 20.0),
            some(0.0, 0.3),
            some(0.0, 0.3),
            some(0.0, 0.3),
        ],
        linear: [
            some(0.0, 10.0),
            some(0.0, 10.0),
            some(0.0, 10.0),
            some(0.0, 0.5),
            some(0.0, 0.5),
            some(0.0, 0.5),
        ],
        quadratic: [
            some(5.0, 100.0),
            some(5.0, 100.0),
            some(5.0, 100.0),
            some(0.1, 1.5),
            some(0.1, 1.5),
            some(0.1, 1.5),
        ],
    }
}

#[test]
fn any_vehicle_moves_as_the_textbook_says() {
    let seed = 20_260_301;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let times = [1.0, 5.0, 20.0];
    let cases: Vec<_> = (0..20)
        .map(|_| {
            let rov = random(&mut rng);
            let eta: [f64; 6] = std::array::from_fn(|k| {
                rng.random_range(-1.0..1.0)
                    * if k < 3 {
                        5.0
                    } else if k == 5 {
                        PI
                    } else {
                        0.5
                    }
            });
            let nu: [f64; 6] = std::array::from_fn(|_| rng.random_range(-0.5..0.5));
            let tau: [f64; 6] =
                std::array::from_fn(|k| rng.random_range(-1.0..1.0) * if k < 3 { 15.0 } else { 0.5 });
            (rov, eta, nu, tau)
        })
        .collect();
    let input: String = cases
        .iter()
        .map(|(rov, eta, nu, tau)| {
            json!({"vehicle": rov.json(), "eta": eta, "nu": nu, "tau": tau, "at_s": times}).to_string() + "\n"
        })
        .collect();
    let finished = ask(&[], &input);
    assert_eq!((finished.code, finished.err.len(), finished.out.len()), (Some(0), 0, 20), "{finished:?}");
    let mut worst = 0.0_f64;
    for (index, ((rov, eta, nu, tau), line)) in cases.iter().zip(&finished.out).enumerate() {
        let reply: Value = serde_json::from_str(line).expect("JSON");
        let states = reply["states"].as_array().expect("a list");
        assert_eq!(states.len(), 3);
        let (mut y, mut t): (Y, f64) = (std::array::from_fn(|k| if k < 6 { eta[k] } else { nu[k - 6] }), 0.0);
        for (state, at_s) in states.iter().zip(times) {
            y = rov.go(y, *tau, at_s - t);
            t = at_s;
            assert_eq!(state["t_s"], json!(at_s));
            let mine = [numbers(&state["eta"]), numbers(&state["nu"])].concat();
            assert!(mine[3..6].iter().all(|angle| -PI < *angle && *angle <= PI), "{mine:?}");
            for (k, (mine, exact)) in mine.iter().zip(y).enumerate() {
                let apart = mine - exact;
                let apart =
                    if (3..6).contains(&k) { apart.sin().abs() + 1.0 - apart.cos() } else { apart.abs() };
                worst = worst.max(apart);
                assert!(apart < 1e-6, "seed {seed}, case {index}, {at_s} s, number {k}: {mine}, {exact}");
            }
        }
    }
    println!("20 vehicles over 20 s: off by at most {worst:.1e}");
}

#[test]
fn a_vehicle_may_be_named_or_come_from_the_command_line() {
    let rest = "\"eta\":[0,0,0,0,0,0],\"nu\":[0,0,0,0,0,0],\"tau\":[10,0,0,0,0,0],\"at_s\":[60]";
    let named = format!("{{\"vehicle\":\"bluerov1\",{rest}}}\n{{{rest}}}\n");
    let finished = ask(&["bluerov1"], &named);
    assert_eq!((finished.code, finished.out.len()), (Some(0), 2), "{finished:?}");
    assert_eq!(finished.out[0], finished.out[1]);
    let reply: Value = serde_json::from_str(&finished.out[0]).expect("JSON");
    // 10 = 4.03 u + 18.18 u²
    let steady = (-4.03 + (4.03_f64.powi(2) + 4.0 * 18.18 * 10.0).sqrt()) / (2.0 * 18.18);
    assert!((numbers(&reply["states"][0]["nu"])[0] - steady).abs() < 1e-8, "{reply}");
}

/// 1900 µs at 16 V: 5.25 kgf in the maker's table, on four vectored thrusters and then on none.
#[test]
fn pulses_push_as_the_table_says() {
    let with = |pulses: &str| {
        format!(
            "{{\"vehicle\":\"bluerov2-heavy\",\"eta\":[0,0,0,0,0,0],\"nu\":[0,0,0,0,0,0],\
             \"pwm_us\":{pulses},\"voltage_v\":16,\"at_s\":[0.001]}}\n"
        )
    };
    let still = with("[1500,1500,1500,1500,1500,1500,1500,1500]");
    let ahead = with("[1900,1900,1500,1500,1500,1500,1500,1500]");
    let finished = ask(&[], &(still + &ahead));
    assert_eq!((finished.code, finished.out.len()), (Some(0), 2), "{finished:?}");
    let speed = |line: &str| {
        let reply: Value = serde_json::from_str(line).expect("JSON");
        numbers(&reply["states"][0]["nu"])[0]
    };
    let force_n = 2.0 * FRAC_1_SQRT_2 * 5.25 * 9.80665;
    let expected = force_n / (13.5 + 6.36) * 0.001;
    let seen = speed(&finished.out[1]) - speed(&finished.out[0]);
    assert!((seen / expected - 1.0).abs() < 0.02, "{seen} m/s, {expected} m/s");
}

#[test]
fn mistakes_are_named_and_the_stream_goes_on() {
    let good = "{\"vehicle\":\"bluerov2\",\"eta\":[0,0,0,0,0,0],\"nu\":[0,0,0,0,0,0],\"tau\":[1,0,0,0,0,0],\"at_s\":[1]}";
    let body = r#"{"mass_kg":4,"weight_n":40,"buoyancy_n":40,"r_g_m":[0,0,0],"r_b_m":[0,0,0],"inertia_kg_m2":[1,1,1],
        "added_mass":[0,0,0,0,0,0],"linear_damping":[0,0,0,0,0,0],"quadratic_damping":[0,0,0,0,0,0]}"#
        .replace('\n', "");
    let other = |vehicle: &str| good.replace("\"bluerov2\"", vehicle);
    let pulses = |pulses: &str| good.replace("\"tau\":[1,0,0,0,0,0]", pulses);
    let cases = [
        (
            other("\"bluerov9\""),
            "column 12: vehicle = \"bluerov9\": there are bluerov1, bluerov2, bluerov2-heavy, tool-20n; did you mean bluerov1?",
        ),
        (other(&body.replace("\"mass_kg\":4", "\"mass_kg\":-4")), "vehicle: mass_kg = -4 kg: must be"),
        (other(&body.replace("\"mass_kg\":4,", "")), "column 12: vehicle: missing field `mass_kg`"),
        (other(&body.replace("[1,1,1]", "[1,0,1]")), "vehicle: inertia_kg_m2 = 0 kg·m²: must be"),
        (good.replace("\"tau\":[1,0,0,0,0,0]", "\"tau\":[1,0,0,0,0]"), "tau has 5 numbers: must be 6"),
        (good.replace("\"tau\":[1,", "\"tau\":[1e9,"), "tau[0] = 1e9 N: must be at most 1e6"),
        (good.replace("\"tau\":[1,0,0,0,0,0],", ""), "takes either tau, or pwm_us and voltage_v"),
        (good.replace("\"at_s\":[1]", "\"at_s\":[1,-2]"), "at_s[1] = -2 s: must lie between 0 and 3600"),
        (good.replace("\"nu\":[0,", "\"nu\":[NaN,"), "column "),
        (
            pulses("\"pwm_us\":[1500,1500,1500,1500,1500,1500],\"voltage_v\":24"),
            "voltage_v = 24 V: must lie between 10",
        ),
        (
            pulses("\"pwm_us\":[1500,1500,1500,1500,1500,2100],\"voltage_v\":16"),
            "pwm_us[5] = 2100 µs: must lie",
        ),
        (pulses("\"pwm_us\":[1500],\"voltage_v\":16"), "pwm_us has 1 pulses for 6 thrusters"),
        (good.replace("\"vehicle\":\"bluerov2\",", ""), "vehicle: neither the request nor the command line"),
        ("{".to_owned(), "column 1: "),
    ];
    let input: String = cases.iter().flat_map(|(line, _)| [line.as_str(), "\n", good, "\n"]).collect();
    let finished = ask(&[], &input);
    assert_eq!((finished.code, finished.out.len(), finished.err.len()), (Some(2), 28, 14), "{finished:?}");
    for (index, (line, expected)) in cases.iter().enumerate() {
        let [refusal, answer]: [Value; 2] =
            [0, 1].map(|k| serde_json::from_str(&finished.out[2 * index + k]).expect("JSON"));
        let said = refusal["error"].as_str().expect("a message");
        assert!(said.starts_with(expected), "{line}\n{said}\nexpected {expected}");
        assert_eq!(finished.err[index], format!("flotilla: line {}: {said}", 2 * index + 1));
        assert!(answer["states"].is_array(), "{answer}");
    }
    let finished = ask(&["bluerov9"], "");
    assert_eq!(finished.code, Some(2));
    assert!(
        finished.err[0].starts_with("flotilla: bluerov9: no such file, and no built-in vehicle"),
        "{finished:?}"
    );
}
