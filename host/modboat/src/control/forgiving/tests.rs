use super::super::margins::{Axis, Loop};
use super::super::{ControllerKind, Target};
use super::*;

fn with<T>(kind: ControllerKind, use_it: impl Fn(&Loop<'_>) -> T) -> T {
    let structure = Structure::from_cells(&[[0, 0], [1, 0], [2, 0]]).expect("a row of three");
    let control = ControlConfig { kind, ..ControlConfig::default() };
    use_it(&Loop {
        structure: &structure,
        parameters: &Parameters::default(),
        control: &control,
        observer: &ObserverParameters::default(),
        lead_s: 0.3,
    })
}

/// The greatest demand late after a push, over the greatest at first.
fn left(sampled: &Loop<'_>, axis: Axis, gain: f64) -> f64 {
    let push = match axis {
        Axis::Surge => Wrench { fy_n: 1e-4, ..Wrench::default() },
        Axis::Heading => Wrench { tau_nm: 1e-5, ..Wrench::default() },
    };
    let demands = sampled.response(push, gain).expect("a response");
    let size =
        |demands: &[Wrench]| demands.iter().map(|w| w.weighted_norm([1.0, 1.0, 10.0])).fold(0.0, f64::max);
    let (first, last) = demands.split_at(demands.len() / 2);
    if demands.len() < 150 { f64::INFINITY } else { size(last) / size(first) }
}

#[test]
fn margins_are_where_the_loop_really_becomes_unstable() {
    for kind in ControllerKind::ALL {
        for axis in [Axis::Heading, Axis::Surge] {
            with(kind, |sampled| {
                let margins = sampled.margins(axis).expect("margins");
                println!(
                    "{} {axis:?}: thrust × {:.2} to {:.2}, {:.0}°",
                    kind.name(),
                    margins.least_gain,
                    margins.gain,
                    margins.phase_rad.to_degrees()
                );
                let [inside, outside] = [0.93, 1.1].map(|by| left(sampled, axis, by * margins.gain));
                assert!(
                    inside < 0.5 && outside > 0.9,
                    "{} {axis:?} {margins:?}: {inside} {outside}",
                    kind.name()
                );
            });
        }
    }
}

/// As the page on the controllers says: thrust times, phase in degrees.
#[test]
fn margins_of_the_default_are_those_stated() {
    with(ControllerKind::Forgiving, |sampled| {
        for (axis, most, least, phase) in [(Axis::Heading, 1.4, 0.32, 20.0), (Axis::Surge, 1.2, 0.4, 14.0)] {
            let margins = sampled.margins(axis).expect("margins");
            assert!(margins.gain > most && margins.least_gain < least, "{axis:?}: {margins:?}");
            assert!(margins.phase_rad.to_degrees() > phase, "{axis:?}: {margins:?}");
        }
    });
}

/// Three in a row that point north and swim east through water with the drag believed, `thrust` times the thrust believed, in a current.
struct Boat {
    controller: Forgiving,
    thrust: f64,
    current_m_s: f64,
    t_s: f64,
    east_m: f64,
    speed_m_s: f64,
    running: Wrench,
}

impl Boat {
    fn new(thrust: f64, current_m_s: f64) -> Self {
        let structure = Structure::from_cells(&[[0, 0], [1, 0], [2, 0]]).expect("a row of three");
        let (parameters, control) = (Parameters::default(), ControlConfig::default());
        let controller = Forgiving::new(&structure, &parameters, &control, &ObserverParameters::default());
        let (t_s, east_m, speed_m_s, running) = (0.0, 0.0, 0.0, Wrench::default());
        Self { controller, thrust, current_m_s, t_s, east_m, speed_m_s, running }
    }

    /// One cycle, with the decision on the next 0.3 s before its end; what was demanded.
    fn swim(&mut self, velocity_m_s: f64) -> Wrench {
        let mut next = Wrench::default();
        self.controller.set_wrench(self.t_s, self.running, None);
        for step in 1..=180 {
            let water = self.speed_m_s - self.current_m_s;
            // Heading north: sway is east. M = 4.5 kg, D = 13.5 N·s²/m².
            let force_n = self.thrust * self.running.fx_n - 13.5 * water * water.abs();
            self.speed_m_s += force_n / 4.5 / 120.0;
            self.east_m += self.speed_m_s / 120.0;
            self.t_s += 1.0 / 120.0;
            let heading_rad = std::f64::consts::FRAC_PI_2;
            self.controller.update(&Fix { t_s: self.t_s, position_m: [self.east_m, 0.0], heading_rad });
            if step == 144 {
                let target = Target { velocity_m_s: [velocity_m_s, 0.0], heading_rad };
                let goal = Goal { target, station_m: None, is_bounded: false };
                let moment = Moment { now_s: self.t_s, start_s: self.t_s + 0.3, interval_s: 1.5 };
                next = self.controller.demand(&goal, &moment);
            }
        }
        self.running = next;
        next
    }
}

/// Momentum of a hull whose axes carry different water, by Kirchhoff's equations in the axes of the hull, and a small step of time.
#[test]
fn a_hull_that_turns_moves_as_kirchhoffs_equations_say() {
    let structure = Structure::from_cells(&[[0, 0], [1, 0], [2, 0]]).expect("a row of three");
    let (parameters, observer) = (Parameters::default(), ObserverParameters::default());
    let forgiving = ForgivingConfig { munk: 0.5, drag_difference: -0.8, ..ForgivingConfig::default() };
    let control = ControlConfig { forgiving, ..ControlConfig::default() };
    let controller = Forgiving::new(&structure, &parameters, &control, &observer);
    // M = 4.5 kg, D = 13.5 N·s²/m².
    let ([m_x, m_y], [d_x, d_y]) = ([3.375, 5.625], [18.9, 8.1]);
    let (inertia, drag) = (controller.estimator.model.inertia_kg_m2, structure.yaw_drag_n_m_s2(&parameters));
    let (force, torque_nm, dt_s) = ([0.03, -0.02], 0.001, 1e-6);
    for (heading, sway, surge, omega) in
        [(0.0, 0.05, 0.02, 0.1), (1.2, -0.03, 0.06, -0.2), (-2.9, 0.04, -0.05, 0.3), (0.7, 0.0, 0.05, 0.2)]
    {
        let after = [
            sway + dt_s * (force[0] - d_x * sway * f64::abs(sway) + m_y * omega * surge) / m_x,
            surge + dt_s * (force[1] - d_y * surge * f64::abs(surge) - m_x * omega * sway) / m_y,
        ];
        let turned = (torque_nm - drag * omega * f64::abs(omega) - (m_y - m_x) * sway * surge) / inertia;
        let world = |heading: f64, [x, y]: [f64; 2]| {
            let (sin, cos) = heading.sin_cos();
            [sin * x + cos * y, -cos * x + sin * y]
        };
        let (then, now) = (world(heading + dt_s * omega, after), world(heading, [sway, surge]));
        let kirchhoff = [(then[0] - now[0]) / dt_s, (then[1] - now[1]) / dt_s, turned];
        let wrench = Wrench { fx_n: force[0], fy_n: force[1], tau_nm: torque_nm };
        let own = controller.estimator.acceleration(wrench, heading, [now[0], now[1], omega]);
        for (own, other) in own.into_iter().zip(kirchhoff) {
            assert!((own - other).abs() < 1e-6, "heading {heading}: {own} and {other}");
        }
    }
}

#[test]
fn thrust_is_learned_and_leaves_no_error() {
    for thrust in [0.6, 1.0, 2.0] {
        let mut boat = Boat::new(thrust, 0.0);
        for _ in 0..40 {
            boat.swim(0.04);
        }
        let found = boat.controller.factors().force;
        assert!((found / thrust - 1.0).abs() < 0.15, "× {thrust}: {found}");
        assert!((boat.speed_m_s - 0.04).abs() < 4e-4, "× {thrust}: {} m/s", boat.speed_m_s);
    }
}

#[test]
fn a_current_leaves_no_error() {
    for current_m_s in [-0.02, 0.02] {
        let mut boat = Boat::new(1.0, current_m_s);
        for _ in 0..40 {
            boat.swim(0.04);
        }
        assert!((boat.speed_m_s - 0.04).abs() < 4e-4, "{current_m_s}: {} m/s", boat.speed_m_s);
    }
}

#[test]
fn nothing_winds_up_beyond_the_limits() {
    let mut boat = Boat::new(1.0, 0.0);
    for _ in 0..60 {
        boat.swim(0.5);
    }
    let most_n = 3.0 * 0.9 * 0.0382;
    assert!(boat.running.fx_n > 0.9 * most_n && boat.running.fx_n < 1.001 * most_n, "{:?}", boat.running);
    // Told to stop, it brakes at once, and does not come back for what it missed.
    let told = boat.swim(0.0);
    assert!(told.fx_n < 0.0, "{told:?}");
    let mut least_m_s = f64::INFINITY;
    for _ in 0..20 {
        boat.swim(0.0);
        least_m_s = least_m_s.min(boat.speed_m_s);
    }
    assert!(least_m_s > -0.01 && boat.speed_m_s.abs() < 1e-3, "{least_m_s} {}", boat.speed_m_s);
}
