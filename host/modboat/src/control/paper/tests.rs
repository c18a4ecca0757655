use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;

fn three() -> Structure {
    Structure::from_cells(&[[0, 0], [1, 0], [2, 0]]).expect("a row of three")
}

fn controller(config: &ControlConfig) -> Controller {
    Controller::new(&three(), &Parameters::default(), config)
}

/// Velocity gains zero: v_c = v_des, and (19) can be worked by hand.
fn feed_forward() -> Controller {
    controller(&ControlConfig { velocity_proportional_1_s: 0.0, ..Default::default() })
}

const REST: Observation = Observation {
    velocity_m_s: [0.0; 2],
    heading_rad: 0.0,
    yaw_rate_rad_s: 0.0,
    unknown_m_s2: [0.0; 2],
    unknown_rad_s2: 0.0,
};

#[test]
fn defaults_pass_and_nonsense_is_named() {
    assert_eq!(ControlConfig::default().validate(), Ok(()));
    let bad = ControlConfig { leak: f64::NAN, ..Default::default() };
    assert_eq!(bad.validate().map_err(|e| e.key), Err("leak"));
}

#[test]
fn forces_by_hand() {
    // Three modules, 4.5 N·s²/m² each, 0.04 m/s: 3·4.5·0.0016 = 0.0216 N; the interval is T, so it is not raised.
    // Θ = π/2: surge points north, sway east. Θ = 0: surge east, sway south. Θ = π: surge west, sway north.
    let f = 0.0216;
    let east = [0.04, 0.0];
    let north = [0.0, 0.04];
    for (theta, velocity, expected) in [
        (FRAC_PI_2, east, [f, 0.0]),
        (FRAC_PI_2, north, [0.0, f]),
        (0.0, east, [0.0, f]),
        (0.0, north, [-f, 0.0]),
        (PI, east, [0.0, -f]),
        (PI, north, [f, 0.0]),
        (FRAC_PI_2, [-0.04, 0.0], [-f, 0.0]),
    ] {
        let observed = Observation { heading_rad: theta, velocity_m_s: velocity, ..REST };
        let target = Target { velocity_m_s: velocity, heading_rad: theta };
        let demand = feed_forward().demand(&target, &observed, 1.5, 2.0);
        assert!((demand.fx_n - expected[0]).abs() < 1e-12, "Θ {theta}, v {velocity:?}: {demand:?}");
        assert!((demand.fy_n - expected[1]).abs() < 1e-12, "Θ {theta}, v {velocity:?}: {demand:?}");
        assert!(demand.tau_nm.abs() < 1e-12);
    }
}

#[test]
fn an_unknown_acceleration_is_taken_off() {
    // Θ = π/2: surge north. 3 kg · 1.5 · 1e-3 m/s² = 4.5e-3 N against a drift to the east and north.
    let observed = Observation { heading_rad: FRAC_PI_2, unknown_m_s2: [1e-3, 2e-3], ..REST };
    let target = Target { velocity_m_s: [0.0; 2], heading_rad: FRAC_PI_2 };
    let demand = feed_forward().demand(&target, &observed, 1.5, 2.0);
    assert!((demand.fx_n + 4.5e-3).abs() < 1e-12 && (demand.fy_n + 9e-3).abs() < 1e-12, "{demand:?}");
}

#[test]
fn drag_counts_per_axis() {
    // 45°: both axes carry 0.04·cos 45°, each squared by itself: half the force on each.
    let target = Target { velocity_m_s: [0.0, 0.04], heading_rad: PI / 4.0 };
    let observed = Observation { heading_rad: PI / 4.0, velocity_m_s: [0.0, 0.04], ..REST };
    let demand = feed_forward().demand(&target, &observed, 1.5, 2.0);
    assert!((demand.fx_n + 0.0108).abs() < 1e-12 && (demand.fy_n - 0.0108).abs() < 1e-12, "{demand:?}");
}

#[test]
fn the_demand_makes_up_for_the_time_without_thrust() {
    let target = Target { velocity_m_s: [0.02, 0.0], heading_rad: FRAC_PI_2 };
    let observed = Observation { heading_rad: FRAC_PI_2, velocity_m_s: [0.02, 0.0], ..REST };
    let with = feed_forward().demand(&target, &observed, 2.0, 2.0);
    let without = feed_forward().demand(&target, &observed, 1.5, 2.0);
    assert!((with.fx_n / without.fx_n - 2.0 / 1.5).abs() < 1e-12);
}

#[test]
fn torque_turns_towards_the_target_the_short_way() {
    let torque = |heading_rad: f64, observed: Observation| {
        let target = Target { velocity_m_s: [0.0; 2], heading_rad };
        feed_forward().demand(&target, &observed, 2.0, 2.0).tau_nm
    };
    assert!(torque(0.3, REST) > 0.0);
    assert!(torque(-0.3, REST) < 0.0);
    // From 3.0 to −3.0 the short way is counter-clockwise; so it is from an unwrapped heading.
    assert!(torque(-3.0, Observation { heading_rad: 3.0, ..REST }) > 0.0);
    assert!(torque(-3.0, Observation { heading_rad: 3.0 - 3.0 * TAU, ..REST }) > 0.0);
    // Turning fast towards the target is braked: the prediction lies beyond it.
    assert!(torque(0.3, Observation { yaw_rate_rad_s: 0.3, ..REST }) < 0.0);
}

#[test]
fn torque_by_hand() {
    // I = 1.2·(3·0.003 + 2·0.15²) = 0.0648, α = 0.15·0.1 = 0.015: τ = 9.72e-4, and 4/3 of it for the interval.
    let target = Target { velocity_m_s: [0.0; 2], heading_rad: 0.1 };
    let demand = feed_forward().demand(&target, &REST, 2.0, 2.0);
    assert!((demand.tau_nm - 0.0648 * 0.015 * 4.0 / 3.0).abs() < 1e-12, "{demand:?}");
}

/// Heading after each of `n` intervals of 2 s, from an error of one radian, on a double integrator whose inertia is
/// `factor` times the assumed one. With thrust constant over the interval and no drag.
fn yaw_response(config: &ControlConfig, factor: f64, n: usize) -> Vec<f64> {
    let h = 2.0;
    let parameters = Parameters { yaw_drag_n_m_s2: 0.0, ..Default::default() };
    let structure = three();
    let mut controller = Controller::new(&structure, &parameters, config);
    controller.yaw_drag_n_m_s2 = 0.0;
    let inertia = factor * config.added_inertia_factor * structure.inertia_kg_m2(&parameters);
    let (mut heading, mut omega) = (1.0, 0.0);
    let target = Target { velocity_m_s: [0.0; 2], heading_rad: 0.0 };
    (0..n)
        .map(|_| {
            let observed = Observation { heading_rad: heading, yaw_rate_rad_s: omega, ..REST };
            // T of every h: the mean acceleration is that of the demand times T/h.
            let alpha =
                controller.demand(&target, &observed, h, h).tau_nm * parameters.period_s / h / inertia;
            heading += h * omega + 0.5 * h * h * alpha;
            omega += h * alpha;
            heading
        })
        .collect()
}

#[test]
fn yaw_converges_on_a_double_integrator() {
    let settled = |response: &[f64]| response.iter().all(|heading| heading.abs() < 0.02);
    let config = ControlConfig::default();
    let nominal = yaw_response(&config, 1.0, 30);
    assert!(settled(&nominal[15..]), "{nominal:?}");
    let overshoot = nominal.iter().fold(0.0, |worst: f64, heading| worst.max(-heading));
    assert!(overshoot < 0.15, "{nominal:?}");
    // Half as much inertia again more, or a third less.
    assert!(settled(&yaw_response(&config, 1.5, 40)[20..]));
    assert!(settled(&yaw_response(&config, 0.65, 60)[30..]));
    // The bound h·b < 2 is real: beyond it the loop does not settle.
    let hot = ControlConfig { yaw_derivative_1_s: 1.2, ..config };
    assert!(!settled(&yaw_response(&hot, 1.0, 200)[150..]));
}

/// Speed after `n` intervals of 2 s towards 0.04 m/s, on quadratic drag that is `drag` times the assumed one.
fn surge_response(drag: f64, n: usize) -> f64 {
    let parameters = Parameters::default();
    let mut controller = controller(&ControlConfig::default());
    let target = Target { velocity_m_s: [0.0, 0.04], heading_rad: FRAC_PI_2 };
    let (mass, c) = (3.0 * 1.3 * parameters.module_mass_kg, 3.0 * drag * parameters.drag_n_s2_m2);
    let mut v: f64 = 0.0;
    for _ in 0..n {
        let observed = Observation { velocity_m_s: [0.0, v], heading_rad: FRAC_PI_2, ..REST };
        let push = controller.demand(&target, &observed, 2.0, 2.0).fy_n;
        for step in 0..200 {
            let force = if step < 50 { 0.0 } else { push };
            v += 0.01 * (force - c * v * v.abs()) / mass;
        }
    }
    v
}

#[test]
fn speed_settles_near_the_target_though_the_drag_is_wrong() {
    for drag in [0.85, 1.0, 1.15] {
        let v = surge_response(drag, 40);
        assert!((v - 0.04).abs() < 0.05 * 0.04, "drag × {drag}: {v}");
    }
}

#[test]
fn inertia_is_paid_for_in_the_frame_of_the_structure() {
    // Still, heading east, wanted 0.04 m/s north (S: sway −x): a = 0.25·0.04, v_c = 0.04 + 2a.
    let mut controller = controller(&ControlConfig::default());
    let target = Target { velocity_m_s: [0.0, 0.04], heading_rad: 0.0 };
    let demand = controller.demand(&target, &REST, 1.5, 1.5);
    let (a, v_c) = (0.25 * 0.04, 0.04 + 1.5 * 0.25 * 0.04);
    let by_hand = -(3.0 * 4.5 * v_c * v_c + 1.5 * 3.0 * a);
    assert!((demand.fx_n - by_hand).abs() < 1e-9 && demand.fy_n.abs() < 1e-12, "{demand:?}, {by_hand}");
}

#[test]
fn too_much_is_cut_down_torque_first() {
    let parameters = Parameters::default();
    let config = ControlConfig { velocity_proportional_1_s: 0.0, ..ControlConfig::default() };
    let mut controller = controller(&config);
    let target = Target { velocity_m_s: [0.3, 0.5], heading_rad: 3.0 };
    let demand = controller.demand(&target, &REST, 2.0, 2.0);
    // By least-norm sharing every module stays within its share of the greatest thrust, and one reaches it.
    let limit = config.thrust_share * parameters.thrust_n(parameters.amplitude_max_rad);
    let lever = demand.tau_nm / 0.045;
    let shares: Vec<f64> =
        [-0.15, 0.0, 0.15].iter().map(|x| (demand.fx_n / 3.0).hypot(demand.fy_n / 3.0 + lever * x)).collect();
    let worst = shares.iter().copied().fold(0.0, f64::max);
    assert!((worst - limit).abs() < 1e-9, "{shares:?} {limit}");
    // Torque: 0.7 of the limit on two levers of 0.15 m. The force keeps its direction.
    assert!((demand.tau_nm - 0.7 * limit * 0.3).abs() < 1e-12, "{demand:?}");
    let wanted = feed_forward().drag_force([0.3, 0.5], 0.0);
    assert!((demand.fx_n * wanted[1] - demand.fy_n * wanted[0]).abs() < 0.02 * worst * wanted[1].abs());
}

#[test]
fn the_sum_does_not_wind_up_at_the_limit() {
    let config = ControlConfig::default();
    let mut controller = controller(&config);
    let hard = Target { velocity_m_s: [0.0, 0.5], heading_rad: FRAC_PI_2 };
    let observed = Observation { heading_rad: FRAC_PI_2, ..REST };
    for _ in 0..50 {
        controller.demand(&hard, &observed, 2.0, 2.0);
    }
    assert!(controller.sum_m_s2[1].abs() < 1e-3, "{:?}", controller.sum_m_s2);
    // Below the limit it does add up, towards a/(1 − γ).
    let easy = Target { velocity_m_s: [0.0, 0.005], heading_rad: FRAC_PI_2 };
    for _ in 0..400 {
        controller.demand(&easy, &observed, 2.0, 2.0);
    }
    let limit = config.velocity_proportional_1_s * 0.005 / (1.0 - config.leak);
    assert!((controller.sum_m_s2[1] - limit).abs() < 1e-6, "{:?}", controller.sum_m_s2);
}

#[test]
fn a_lone_module_is_not_asked_for_torque() {
    let structure = Structure::from_cells(&[[0, 0]]).expect("one");
    let mut controller = Controller::new(&structure, &Parameters::default(), &ControlConfig::default());
    let demand = controller.demand(&Target { velocity_m_s: [0.02, 0.0], heading_rad: 1.0 }, &REST, 2.0, 2.0);
    assert!(demand.tau_nm == 0.0 && demand.fy_n > 0.0, "{demand:?}");
}

#[test]
fn a_station_is_approached_at_a_bounded_speed_and_in_proportion_near_it() {
    let controller = ControlConfig::default();
    // 0.2·0.1 = 0.02 m/s; ten metres away on 3-4-5 it is 0.04 m/s, along the line.
    for (station, expected) in [([0.1, 0.0], [0.02, 0.0]), ([-6.0, 8.0], [-0.024, 0.032])] {
        let seen = controller.towards([1.0 + station[0], 2.0 + station[1]], [1.0, 2.0], &REST, 2.0);
        assert!((seen[0] - expected[0]).hypot(seen[1] - expected[1]) < 1e-12, "{seen:?} for {expected:?}");
    }
    // On its way there at such a speed that it arrives by itself, nothing more is asked for.
    let moving = Observation { velocity_m_s: [0.05, 0.0], ..REST };
    assert!(controller.towards([0.1, 0.0], [0.0; 2], &moving, 2.0)[0].abs() < 1e-12);
}

#[test]
fn an_unknown_torque_is_taken_off_little_by_little() {
    let mut controller = controller(&ControlConfig::default());
    let observed = Observation { unknown_rad_s2: 1e-3, ..REST };
    let target = Target { velocity_m_s: [0.0; 2], heading_rad: 0.0 };
    let taken: Vec<f64> = (0..40).map(|_| controller.demand(&target, &observed, 1.5, 1.8).tau_nm).collect();
    // Total inertia of three modules: 1.2·0.054 kg·m²; against the unknown, 0.15 of it at first, all of it in the end.
    let whole_nm = -1.2 * 0.054 * 1e-3;
    assert!((taken[0] - 0.15 * whole_nm).abs() < 1e-9, "{}", taken[0]);
    assert!((taken[39] - whole_nm).abs() < 2e-3 * whole_nm.abs(), "{}", taken[39]);
}
