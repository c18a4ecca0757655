//! What bodies do that differ from what a host believes: mass off the centre, drag per axis with cross terms.

use super::*;

const DT_S: f64 = 1e-3;

fn body() -> Body {
    Body {
        mass_kg: 3.0,
        inertia_kg_m2: 0.054,
        centre_m: [0.05, -0.03],
        added_mass_kg: [2.5, 0.6],
        added_inertia_kg_m2: 0.03,
        drag_n_s2_m2: [0.0; 2],
        drag_cross_n_s2_m2: 0.0,
        drag_centre_m: [0.0; 2],
        yaw_drag_n_m_s2: 0.0,
        yaw_drag_speed_n_s2: [0.0; 2],
    }
}

fn moving() -> BodyState {
    BodyState { position_m: [0.3, -0.2], heading_rad: 0.7, velocity_s_m_s: [0.2, -0.35], yaw_rate_rad_s: 0.9 }
}

/// Momentum (world), angular momentum about the world's origin, kinetic energy in still water, from the motion of the centre of mass.
fn invariants(body: &Body, state: &BodyState) -> [f64; 4] {
    let ([x_g, y_g], [v_x, v_y], omega) = (body.centre_m, state.velocity_s_m_s, state.yaw_rate_rad_s);
    let ([m_x, m_y], m) = (body.added_mass_kg, body.mass_kg);
    let (c_x, c_y) = (v_x - omega * y_g, v_y + omega * x_g);
    let [p_x, p_y] = to_world(state.heading_rad, [m * c_x + m_x * v_x, m * c_y + m_y * v_y]);
    let spin = (body.inertia_kg_m2 + body.added_inertia_kg_m2) * omega + m * (x_g * c_y - y_g * c_x);
    let energy_j = 0.5
        * (m * (c_x * c_x + c_y * c_y)
            + m_x * v_x * v_x
            + m_y * v_y * v_y
            + (body.inertia_kg_m2 + body.added_inertia_kg_m2) * omega * omega);
    let [x, y] = state.position_m;
    [p_x, p_y, spin + x * p_y - y * p_x, energy_j]
}

#[test]
fn with_the_mass_off_the_centre_momentum_angular_momentum_and_energy_are_conserved() {
    let body = body();
    let mut state = moving();
    let before = invariants(&body, &state);
    for step in 0..60_000 {
        state = body.step(&state, DT_S, Wrench::default(), [0.0; 2]);
        for (now, then) in invariants(&body, &state).iter().zip(before) {
            assert!((now - then).abs() < 1e-9, "step {step}: {now} against {then}");
        }
    }
}

/// Without added mass it is a rigid body in empty space: its centre of mass goes straight on, and it spins evenly.
#[test]
fn in_empty_space_the_centre_of_mass_goes_straight_on() {
    let body = Body { added_mass_kg: [0.0; 2], added_inertia_kg_m2: 0.0, ..body() };
    let centre = |state: &BodyState| {
        let [dx, dy] = to_world(state.heading_rad, body.centre_m);
        [state.position_m[0] + dx, state.position_m[1] + dy]
    };
    let mut state = moving();
    let ([x, y], [x_g, y_g]) = (centre(&state), body.centre_m);
    let [u, v] = to_world(0.7, [0.2 - 0.9 * y_g, -0.35 + 0.9 * x_g]);
    for step in 1..=20_000 {
        state = body.step(&state, DT_S, Wrench::default(), [0.0; 2]);
        let t_s = f64::from(step) * DT_S;
        let [now_x, now_y] = centre(&state);
        assert!((now_x - x - u * t_s).hypot(now_y - y - v * t_s) < 1e-9, "{t_s} s");
        assert!((state.heading_rad - 0.7 - 0.9 * t_s).abs() < 1e-9, "{t_s} s");
    }
}

/// A push through the centre of mass of a body in empty space does not turn it; one through the origin turns it by m·a×r.
#[test]
fn a_push_through_the_centre_of_mass_does_not_turn_it() {
    let body = Body { added_mass_kg: [0.0; 2], added_inertia_kg_m2: 0.0, ..body() };
    let still = BodyState { velocity_s_m_s: [0.0; 2], yaw_rate_rad_s: 0.0, ..moving() };
    let [x_g, y_g] = body.centre_m;
    let (fx_n, fy_n) = (0.3, -0.2);
    let through = Wrench { fx_n, fy_n, tau_nm: x_g * fy_n - y_g * fx_n };
    let after = body.step(&still, DT_S, through, [0.0; 2]);
    assert!(after.yaw_rate_rad_s.abs() < 1e-15, "{after:?}");
    assert!((after.velocity_s_m_s[0] - 0.3 / 3.0 * DT_S).abs() < 1e-12, "{after:?}");
    let beside = body.step(&still, DT_S, Wrench { tau_nm: 0.0, ..through }, [0.0; 2]);
    let expected = -(x_g * fy_n - y_g * fx_n) / 0.054 * DT_S;
    assert!((beside.yaw_rate_rad_s / expected - 1.0).abs() < 1e-6, "{beside:?}, {expected}");
}

/// m·v̇ = F − D·v² from rest is v = v∞·tanh(√(F·D)·t/m), v∞ = √(F/D), for each axis with its own drag and mass.
#[test]
fn each_axis_comes_to_its_own_terminal_velocity_by_the_known_law() {
    let body = Body { centre_m: [0.0; 2], drag_n_s2_m2: [20.0, 9.0], drag_cross_n_s2_m2: 6.0, ..body() };
    for (axis, mass_kg, drag) in [(0, 5.5, 20.0_f64), (1, 3.6, 9.0)] {
        for force_n in [0.05_f64, -0.02] {
            let mut push = [0.0; 2];
            push[axis] = force_n;
            let wrench = Wrench { fx_n: push[0], fy_n: push[1], tau_nm: 0.0 };
            let mut state = BodyState {
                velocity_s_m_s: [0.0; 2],
                yaw_rate_rad_s: 0.0,
                heading_rad: 2.0,
                position_m: [0.0; 2],
            };
            for step in 1..=40_000 {
                state = body.step(&state, DT_S, wrench, [0.0; 2]);
                let t_s = f64::from(step) * DT_S;
                let end_m_s = (force_n.abs() / drag).sqrt();
                let expected =
                    force_n.signum() * end_m_s * ((force_n.abs() * drag).sqrt() * t_s / mass_kg).tanh();
                assert!((state.velocity_s_m_s[axis] - expected).abs() < 1e-9, "{axis} {t_s} s: {expected}");
            }
            assert!(state.velocity_s_m_s[1 - axis].abs() < 1e-12 && state.yaw_rate_rad_s.abs() < 1e-12);
        }
    }
}

/// D_y = D_c = D: along a diagonal each axis meets 2·D·v², so that √(F/(2·D)) is its end.
#[test]
fn the_cross_term_slows_an_oblique_course() {
    let body = Body {
        centre_m: [0.0; 2],
        added_mass_kg: [1.0; 2],
        drag_n_s2_m2: [10.0; 2],
        drag_cross_n_s2_m2: 10.0,
        ..body()
    };
    let mut state = BodyState { velocity_s_m_s: [0.0; 2], yaw_rate_rad_s: 0.0, ..moving() };
    let wrench = Wrench { fx_n: 0.03, fy_n: -0.03, tau_nm: 0.0 };
    (0..60_000).for_each(|_| state = body.step(&state, DT_S, wrench, [0.0; 2]));
    let end_m_s = (0.03_f64 / 20.0).sqrt();
    assert!((state.velocity_s_m_s[0] - end_m_s).abs() < 1e-9, "{state:?}");
    assert!((state.velocity_s_m_s[1] + end_m_s).abs() < 1e-9, "{state:?}");
}

/// Drag of every kind at once only takes energy, wherever its centre lies.
#[test]
fn no_drag_gives_energy() {
    let body = Body {
        drag_n_s2_m2: [20.0, 9.0],
        drag_cross_n_s2_m2: 6.0,
        drag_centre_m: [-0.08, 0.12],
        yaw_drag_n_m_s2: 0.03,
        yaw_drag_speed_n_s2: [0.2, 0.4],
        ..body()
    };
    let mut state = moving();
    let mut energy_j = invariants(&body, &state)[3];
    let first_j = energy_j;
    for step in 0..60_000 {
        state = body.step(&state, DT_S, Wrench::default(), [0.0; 2]);
        let now_j = invariants(&body, &state)[3];
        assert!(now_j < energy_j, "step {step}: {now_j} J after {energy_j} J");
        energy_j = now_j;
    }
    assert!(energy_j < 5e-3 * first_j, "{energy_j} J of {first_j} J left");
}

/// Strip theory: while Ω·r is small against v, the damping is that of every module at its own velocity through the water.
#[test]
fn damping_in_yaw_by_speed_is_that_of_strips() {
    let (speed, rate) = (0.2, 1e-4);
    let arms = [-0.15, 0.0, 0.15];
    let per_module = 4.5;
    let damping = |omega: f64| -> f64 {
        arms.iter()
            .map(|x| {
                let v = speed + omega * x;
                -x * per_module * v * v.abs()
            })
            .sum()
    };
    let second_m2: f64 = arms.iter().map(|x| x * x).sum();
    let body = Body {
        centre_m: [0.0; 2],
        added_mass_kg: [0.0; 2],
        added_inertia_kg_m2: 0.0,
        yaw_drag_speed_n_s2: [0.0, 2.0 * per_module * second_m2],
        ..body()
    };
    let state = BodyState { velocity_s_m_s: [0.0, speed], yaw_rate_rad_s: rate, ..moving() };
    let after = body.step(&state, 1e-6, Wrench::default(), [0.0; 2]);
    let seen = (after.yaw_rate_rad_s - rate) / 1e-6 * 0.054;
    assert!((seen / damping(rate) - 1.0).abs() < 1e-3, "{seen} for {}", damping(rate));
}
