use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::body::{Body, GRAVITY_M_S2};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;

use super::*;

fn vehicle(name: &str) -> Vehicle {
    Vehicle::built_in(name).expect(name)
}

/// Neutrally buoyant with coincident centres away from the origin, no damping.
fn frictionless(rng: &mut ChaCha8Rng, added: bool) -> Body {
    let mut some = |low: f64, high: f64| rng.random_range(low..high);
    let r_g_m = [some(-0.1, 0.1), some(-0.1, 0.1), some(-0.1, 0.1)];
    let added_mass = [(); 6].map(|()| if added { some(0.1, 3.0) } else { 0.0 });
    Body {
        mass_kg: some(1.0, 20.0),
        weight_n: 50.0,
        buoyancy_n: 50.0,
        r_g_m,
        r_b_m: r_g_m,
        inertia_kg_m2: [some(0.2, 0.3), some(0.2, 0.3), some(0.2, 0.3)],
        added_mass,
        linear_damping: [0.0; 6],
        quadratic_damping: [0.0; 6],
    }
}

fn dynamics(body: &Body) -> Dynamics {
    Dynamics::new(&Cluster::of(body)).expect("a body with mass")
}

fn tumbling(rng: &mut ChaCha8Rng) -> State {
    let eta = [(); 6].map(|()| rng.random_range(-1.5..1.5));
    State::from_eta(&eta, &[(); 6].map(|()| rng.random_range(-1.0..1.0)))
}

/// ½νᵀMν
fn kinetic_j(dynamics: &Dynamics, state: &State) -> f64 {
    0.5 * state.nu.dot(&(dynamics.mass_matrix() * state.nu))
}

/// Linear and angular momentum (with added mass: impulse) in the world, about the world's origin.
fn momentum(dynamics: &Dynamics, state: &State) -> Vector6<f64> {
    let local = dynamics.mass_matrix() * state.nu;
    let linear = state.attitude * Vector3::new(local[0], local[1], local[2]);
    let angular =
        state.attitude * Vector3::new(local[3], local[4], local[5]) + state.position_m.cross(&linear);
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

#[test]
fn coriolis_is_skew_symmetric_in_both_parts() {
    let seed = 11;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (rov, tool) = (vehicle("bluerov2"), vehicle("tool-20n"));
    let members = [(Pose::from([0.3, 0.1, -0.2, 0.7]), &rov), (Pose::from([-0.4, 0.2, 0.1, -2.0]), &tool)];
    let cluster = Cluster::new(&Pose::default(), &members).expect("two members");
    for _ in 0..100 {
        let nu = Vector6::from_fn(|_, _| rng.random_range(-2.0..2.0));
        for mass in [cluster.rigid_body_mass(), cluster.added_mass()] {
            let c = coriolis(mass, &nu);
            assert!((c + c.transpose()).amax() < 1e-12 && c.amax() > 1e-3, "seed {seed}: {c}");
            assert!(nu.dot(&(c * nu)).abs() < 1e-11, "seed {seed}");
        }
    }
}

/// Against the forces written out by hand for a diagonal M (Fossen 2011, (3.57) and (6.43)).
#[test]
fn coriolis_of_a_diagonal_mass_is_the_textbooks() {
    let (m, nu) = ([4.0, 5.0, 7.0, 0.3, 0.5, 0.8], [1.0, -0.6, 0.4, 0.7, -0.2, 0.9]);
    let [u, v, w, p, q, r] = nu;
    let force = coriolis(&Matrix6::from_diagonal(&m.into()), &nu.into()) * Vector6::from(nu);
    let expected = [
        m[2] * w * q - m[1] * v * r,
        m[0] * u * r - m[2] * w * p,
        m[1] * v * p - m[0] * u * q,
        (m[2] - m[1]) * v * w + (m[5] - m[4]) * q * r,
        (m[0] - m[2]) * u * w + (m[3] - m[5]) * p * r,
        (m[1] - m[0]) * u * v + (m[4] - m[3]) * p * q,
    ];
    assert!((force - Vector6::from(expected)).amax() < 1e-14, "{force}");
}

#[test]
fn frictionless_motion_keeps_energy_and_momentum() {
    let seed = 12;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut worst_energy, mut worst_momentum) = (0.0_f64, 0.0_f64);
    for trial in 0..20 {
        let dynamics = dynamics(&frictionless(&mut rng, trial % 2 == 1));
        let mut state = tumbling(&mut rng);
        let (energy_j, impulse) = (kinetic_j(&dynamics, &state), momentum(&dynamics, &state));
        for _ in 0..20 {
            dynamics.advance(&mut state, &Vector6::zeros(), 1.0, STEP_S);
            worst_energy = worst_energy.max((kinetic_j(&dynamics, &state) / energy_j - 1.0).abs());
            let drift = (momentum(&dynamics, &state) - impulse).norm() / impulse.norm();
            worst_momentum = worst_momentum.max(drift);
        }
    }
    println!("over 20 s, relative: energy {worst_energy:.1e}, momentum {worst_momentum:.1e}");
    assert!(worst_energy < 1e-9 && worst_momentum < 1e-9, "seed {seed}: {worst_energy:e} {worst_momentum:e}");
}

/// Kinetic and potential energy (weights sink, buoyancies rise) only ever become less.
#[test]
fn unforced_motion_loses_energy() {
    let seed = 13;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for name in ["bluerov1", "bluerov2", "bluerov2-heavy", "tool-20n"] {
        let body = vehicle(name).body;
        let dynamics = dynamics(&body);
        let total_j = |state: &State| {
            let depth = |r: [f64; 3]| (state.position_m + state.attitude * Vector3::from(r)).z;
            kinetic_j(&dynamics, state) - body.weight_n * depth(body.r_g_m)
                + body.buoyancy_n * depth(body.r_b_m)
        };
        let mut state = tumbling(&mut rng);
        let mut before_j = total_j(&state);
        for _ in 0..2000 {
            dynamics.advance(&mut state, &Vector6::zeros(), 0.01, STEP_S);
            let now_j = total_j(&state);
            assert!(now_j < before_j + 1e-12, "{name}, seed {seed}: {now_j} J after {before_j} J");
            before_j = now_j;
        }
    }
}

#[test]
fn a_neutral_body_with_coincident_centres_feels_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let dynamics = dynamics(&frictionless(&mut rng, true));
    let mut state = tumbling(&mut rng);
    state.nu = Vector6::zeros();
    let start = state;
    dynamics.advance(&mut state, &Vector6::zeros(), 10.0, STEP_S);
    assert!((flat(&state) - flat(&start)).amax() < 1e-15 && start.position_m.norm() > 0.0);
}

/// Small roll about a neutral body's centre of buoyancy at the origin, centre of gravity h below:
/// φ̈ (I_xx + m h² + K_ṗ − (m h)²/(m + Y_v̇)) = −W h φ, since sway follows freely.
#[test]
fn a_small_roll_swings_at_the_pendulums_period() {
    let (m, h, inertia, y_v, k_p) = (10.0, 0.03, 0.2, 8.0, 0.1);
    let weight_n = m * GRAVITY_M_S2;
    let body = Body {
        mass_kg: m,
        weight_n,
        buoyancy_n: weight_n,
        r_g_m: [0.0, 0.0, h],
        r_b_m: [0.0; 3],
        inertia_kg_m2: [inertia, 0.3, 0.3],
        added_mass: [5.0, y_v, 9.0, k_p, 0.1, 0.1],
        linear_damping: [0.0; 6],
        quadratic_damping: [0.0; 6],
    };
    let effective = inertia + m * h * h + k_p - (m * h).powi(2) / (m + y_v);
    let period_s = TAU * (effective / (weight_n * h)).sqrt();
    let dynamics = dynamics(&body);
    let mut state = State::from_eta(&[0.0, 0.0, 0.0, 1e-4, 0.0, 0.0], &[0.0; 6]);
    dynamics.advance(&mut state, &Vector6::zeros(), 10.25 * period_s, STEP_S);
    assert!(state.eta()[3].abs() < 1e-9, "a quarter after ten periods roll passes zero: {}", state.eta()[3]);
    dynamics.advance(&mut state, &Vector6::zeros(), 0.25 * period_s, STEP_S);
    assert!((state.eta()[3] + 1e-4).abs() < 1e-9, "{}", state.eta()[3]);
}

/// A neutral body that moves ahead with its nose a little above its way (w > 0) is pitched up, further across it:
/// (I_yy + M_q̇) q̇ = (Z_ẇ − X_u̇) u w.
#[test]
fn the_munk_moment_turns_a_body_across_its_way() {
    let body = vehicle("bluerov2").body;
    let still = [0.0; 6];
    let neutral = Body {
        linear_damping: still,
        quadratic_damping: still,
        r_g_m: [0.0; 3],
        buoyancy_n: body.weight_n,
        ..body
    };
    let dynamics = dynamics(&neutral);
    let state = State::from_eta(&[0.0; 6], &[0.8, 0.0, 0.05, 0.0, 0.0, 0.0]);
    let pitching = dynamics.acceleration(&state, &Vector6::zeros())[4];
    // Wu 2018: X_u̇ = 5.5 kg, Z_ẇ = 14.57 kg, M_q̇ = 0.12 kg·m², I_yy = 0.16 kg·m².
    let expected = (14.57 - 5.5) * 0.8 * 0.05 / (0.16 + 0.12);
    assert!(pitching > 0.0 && (pitching - expected).abs() < 1e-12, "{pitching}, by hand {expected} rad/s²");
}

/// Blue Robotics gives 1.5 m/s for the BlueROV2 and 14 kgf of forward bollard thrust. Wu's drag is too small for that
/// and von Benzon's, for a Heavy with its tether, too large: the vehicles that come with the program bracket it.
#[test]
fn the_published_speed_lies_between_the_published_drags() {
    let thrust_n = 14.0 * GRAVITY_M_S2;
    let [fast, slow] = ["bluerov2", "bluerov2-heavy"].map(|name| {
        let body = vehicle(name).body;
        // Only surge: held level and neutral.
        let neutral = Body { r_g_m: [0.0; 3], r_b_m: [0.0; 3], buoyancy_n: body.weight_n, ..body.clone() };
        let mut state = State::from_eta(&[0.0; 6], &[0.0; 6]);
        let tau = Vector6::new(thrust_n, 0.0, 0.0, 0.0, 0.0, 0.0);
        dynamics(&neutral).advance(&mut state, &tau, 60.0, STEP_S);
        // X = d u + q u²
        let (d, q) = (body.linear_damping[0], body.quadratic_damping[0]);
        let steady_m_s = (-d + (d * d + 4.0 * q * thrust_n).sqrt()) / (2.0 * q);
        assert!((state.nu[0] - steady_m_s).abs() < 1e-9, "{name}: {} m/s, {steady_m_s} m/s", state.nu[0]);
        steady_m_s
    });
    assert!(slow < 1.5 && 1.5 < fast, "{slow} m/s, {fast} m/s");
}

/// (6), (8): the Euler angles that are read off change as J(η)ν says.
#[test]
fn euler_angles_follow_the_kinematics() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let dynamics = dynamics(&vehicle("bluerov1").body);
    for _ in 0..50 {
        let state = tumbling(&mut rng);
        let [_, _, _, phi, theta, psi] = state.eta();
        let [u, v, w, p, q, r]: [f64; 6] = state.nu.into();
        let (s, c) = ([phi.sin(), theta.sin(), psi.sin()], [phi.cos(), theta.cos(), psi.cos()]);
        let rate = [
            c[2] * c[1] * u + (c[2] * s[1] * s[0] - s[2] * c[0]) * v + (s[2] * s[0] + c[2] * c[0] * s[1]) * w,
            s[2] * c[1] * u + (c[2] * c[0] + s[0] * s[1] * s[2]) * v + (s[1] * s[2] * c[0] - c[2] * s[0]) * w,
            -s[1] * u + c[1] * s[0] * v + c[1] * c[0] * w,
            p + s[0] * s[1] / c[1] * q + c[0] * s[1] / c[1] * r,
            c[0] * q - s[0] * r,
            (s[0] * q + c[0] * r) / c[1],
        ];
        let dt_s = 1e-6;
        let mut later = state;
        dynamics.step(&mut later, &Vector6::zeros(), dt_s);
        for (axis, rate) in rate.into_iter().enumerate() {
            let seen = wrap_rad(later.eta()[axis] - state.eta()[axis]) / dt_s;
            assert!((seen - rate).abs() < 1e-3 * (1.0 + rate.abs()), "axis {axis}: {seen}, {rate}");
        }
    }
}

#[test]
fn a_loop_through_the_vertical_is_no_hurdle() {
    let still = [0.0; 6];
    let body = vehicle("bluerov1").body;
    let body = Body { linear_damping: still, quadratic_damping: still, ..body };
    let dynamics = dynamics(&body);
    let mut state = State::from_eta(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.5], &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    for step in 1..=628 {
        dynamics.advance(&mut state, &Vector6::zeros(), 0.01, STEP_S);
        let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.5)
            * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.01 * f64::from(step));
        assert!(state.attitude.angle_to(&turned) < 1e-7, "after {step} steps");
        // And the angles say the same.
        let back = State::from_eta(&state.eta(), &[0.0; 6]);
        assert!(back.attitude.angle_to(&state.attitude) < 1e-7, "after {step} steps: {:?}", state.eta());
    }
    for (theta, psi) in [(FRAC_PI_2, 0.3), (-FRAC_PI_2, -2.0)] {
        let straight = State::from_eta(&[0.0, 0.0, 0.0, 0.4, theta, psi], &[0.0; 6]);
        let back = State::from_eta(&straight.eta(), &[0.0; 6]);
        assert!(back.attitude.angle_to(&straight.attitude) < 1e-7, "{:?}", straight.eta());
    }
    assert!((State::from_eta(&[0.0, 0.0, 0.0, -PI, 0.0, -PI], &[0.0; 6]).eta()[5] - PI).abs() < 1e-12);
}

type Flat = nalgebra::SVector<f64, 13>;

fn flat(state: &State) -> Flat {
    let (p, q, nu) = (state.position_m, state.attitude.coords, state.nu);
    Flat::from_iterator(p.iter().chain(q.iter()).chain(nu.iter()).copied())
}

/// Dormand–Prince 5(4) at a relative tolerance of 1e-12 over the same equations.
fn tight(dynamics: &Dynamics, start: &State, tau: &Vector6<f64>, duration_s: f64) -> Flat {
    const A: [&[f64]; 6] = [
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
        &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ];
    const E: [f64; 7] =
        [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
    let rate = |y: &Flat| {
        let state = State {
            position_m: Vector3::new(y[0], y[1], y[2]),
            attitude: UnitQuaternion::new_normalize(Quaternion::new(y[6], y[3], y[4], y[5])),
            nu: y.fixed_rows::<6>(7).into(),
        };
        let Rate { position, attitude, nu } = dynamics.rate(&state, tau);
        Flat::from_iterator(position.iter().chain(attitude.coords.iter()).chain(nu.iter()).copied())
    };
    let (mut y, mut t, mut h) = (flat(start), 0.0, 1e-3);
    while t < duration_s {
        h = f64::min(h, duration_s - t);
        let mut k = vec![rate(&y)];
        let mut next = y;
        for row in A {
            next = y + h * row.iter().zip(&k).map(|(a, k)| *a * k).sum::<Flat>();
            k.push(rate(&next));
        }
        let error = h * E.iter().zip(&k).map(|(e, k)| *e * k).sum::<Flat>().amax();
        let allowed = 1e-12 * (1.0 + y.amax());
        if error <= allowed {
            (y, t) = (next, t + h);
        }
        h *= (0.9 * (allowed / error.max(1e-30)).powf(0.2)).clamp(0.2, 2.0);
    }
    let length = y.fixed_rows::<4>(3).norm();
    y.fixed_rows_mut::<4>(3).unscale_mut(length);
    y
}

#[test]
fn the_default_step_is_fine_enough() {
    let seed = 16;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut worst = 0.0_f64;
    for trial in 0..24 {
        let name = ["bluerov1", "bluerov2", "bluerov2-heavy", "tool-20n"][trial % 4];
        let dynamics = dynamics(&vehicle(name).body);
        let start = tumbling(&mut rng);
        let reach = [20.0, 20.0, 20.0, 1.0, 1.0, 1.0];
        let tau = Vector6::from_iterator(reach.map(|most| rng.random_range(-most..most)));
        let exact = tight(&dynamics, &start, &tau, 20.0);
        let mut state = start;
        dynamics.advance(&mut state, &tau, 20.0, STEP_S);
        let mut mine = flat(&state);
        if mine.fixed_rows::<4>(3).dot(&exact.fixed_rows::<4>(3)) < 0.0 {
            mine.fixed_rows_mut::<4>(3).neg_mut();
        }
        let error = (mine - exact).amax();
        worst = worst.max(error);
        assert!(error < 1e-6, "seed {seed}, {name}, trial {trial}: {error:e} after 20 s");
    }
    println!("{STEP_S} s steps: off by at most {worst:.1e} after 20 s");
}

#[test]
fn what_has_no_mass_has_no_motion() {
    let body = Body { mass_kg: -1.0, added_mass: [0.0; 6], ..vehicle("bluerov1").body };
    let refused = Dynamics::new(&Cluster::of(&body)).expect_err("no mass").to_string();
    assert!(refused.starts_with("the least eigenvalue of the mass matrix is -1e0"), "{refused}");
}
