use reconfiguration::problem::Tool;
use reconfiguration::vehicle::Thruster;

use super::*;

fn hull(name: &str, box_m: [f64; 3], thrusters: usize) -> Vehicle {
    let thruster =
        Thruster { position_m: [0.0; 3], direction: [1.0, 0.0, 0.0], reversed: false, failed: false };
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    Vehicle {
        name: name.to_owned(),
        box_m,
        body: robot.body,
        thrusters: vec![thruster; thrusters],
        connectors: Vec::new(),
        capabilities: Vec::new(),
    }
}

/// Tool at the origin, robots 1 and 2 in a row behind it; goal in a row before it.
fn good() -> Problem {
    let robot = |id, x| Robot { id, vehicle: 0, start: [x, 0.0, 0.0, 0.0].into(), capabilities: Vec::new() };
    let slot = |x| Slot { pose: [x, 0.0, 0.0, 0.0].into(), requires: Vec::new() };
    Problem {
        name: "good".to_owned(),
        description: String::new(),
        vehicles: vec![hull("robot", [0.4, 0.3, 0.2], 1), hull("tool", [0.4, 0.3, 0.2], 0)],
        robots: vec![robot(1, -0.4), robot(2, -0.8)],
        tools: vec![Tool { vehicle: 1, pose: Pose::default() }],
        slots: vec![slot(0.4), slot(0.8)],
        rules: Rules::default(),
        bounds: None,
    }
}

fn refused(change: impl FnOnce(&mut Problem)) -> String {
    let mut problem = good();
    change(&mut problem);
    problem.check().expect_err("refused").to_string()
}

#[test]
fn a_good_problem_passes_and_its_water_leaves_room() {
    let problem = good();
    assert_eq!(problem.check(), Ok(()));
    // Twice 1.5·0.4 around x −1 to 1, y ±0.15, z ±0.1.
    let expected = [-2.2, -1.35, -1.3, 2.2, 1.35, 1.3];
    for (value, expected) in problem.bounds_m().as_flattened().iter().zip(expected) {
        assert!((value - expected).abs() < 1e-12, "{value} for {expected}");
    }
    assert!((problem.clearance_m(&problem.vehicles[0]) - 0.6).abs() < 1e-12);
}

#[test]
fn every_refusal_names_its_value() {
    let edge = |p: &mut Problem, far: f64| {
        let edge_m = vec![[-far, -far], [far, -far], [far, far], [-far, far]];
        p.bounds = Some(quantity::bounds::Bounds { edge_m, margin_m: 0.1 });
    };
    let bounds = |p: &mut Problem, far: f64| p.rules.bounds_m = Some([[-far; 3], [far; 3]]);
    type Case<'a> = (&'a str, Box<dyn FnOnce(&mut Problem) + 'a>);
    let cases: Vec<Case<'_>> = vec![
        ("a reconfiguration needs at least one robot", Box::new(|p| p.robots.clear())),
        ("robot id = 0: ids count from 1", Box::new(|p| p.robots[0].id = 0)),
        ("robot id = 2 stands twice", Box::new(|p| p.robots[0].id = 2)),
        ("robot 1: x = NaN m", Box::new(|p| p.robots[0].start.position_m[0] = f64::NAN)),
        ("tool 1: yaw = inf rad", Box::new(|p| p.tools[0].pose.yaw_rad = f64::INFINITY)),
        ("slot 2: z = -2000000 m", Box::new(|p| p.slots[1].pose.position_m[2] = -2e6)),
        ("robot 2: vehicle 7 of 2", Box::new(|p| p.robots[1].vehicle = 7)),
        ("robot 1: robot: box_m = [0.4, 0.0, 0.2] m", Box::new(|p| p.vehicles[0].box_m[1] = 0.0)),
        ("robot 2: tool has no thrusters", Box::new(|p| p.robots[1].vehicle = 1)),
        ("1 slots for 2 robots", Box::new(|p| drop(p.slots.pop()))),
        (
            "slot 1 requires \"sonar\", which no robot brings",
            Box::new(|p| p.slots[0].requires.push("sonar".to_owned())),
        ),
        ("robot 2 at [-0.8, 0.0, 0.0] m does not fit into the water", Box::new(|p| bounds(p, 0.9))),
        (
            "slot 2 at [0.8, 0.0, 9.0] m does not fit",
            Box::new(|p| {
                bounds(p, 5.0);
                p.slots[1].pose.position_m[2] = 9.0;
            }),
        ),
        (
            "robot 1 and robot 2 are both at [-0.4, 0.0, 0.0] m",
            Box::new(|p| p.robots[1].start = p.robots[0].start),
        ),
        ("robot 1 and tool 1 overlap by 0.010 m", Box::new(|p| p.robots[0].start.position_m[0] = -0.39)),
        ("slot 1 and slot 2 are both at", Box::new(|p| p.slots[1].pose = p.slots[0].pose)),
        ("slot 1 and slot 2 overlap by 0.020 m", Box::new(|p| p.slots[1].pose.position_m[0] = 0.78)),
        ("slot 1 and tool 1 are both at", Box::new(|p| p.slots[0].pose = Pose::default())),
        (
            "tool 1 is left alone: it has no connection at the start",
            Box::new(|p| {
                p.robots.iter_mut().for_each(|robot| robot.start.position_m[1] = 0.5);
            }),
        ),
        (
            "tool 1 is left alone: it has no connection at the goal",
            Box::new(|p| {
                p.slots.iter_mut().for_each(|slot| slot.pose.position_m[1] = 0.5);
            }),
        ),
        ("robot 2 has no connection at the start", Box::new(|p| p.robots[1].start.position_m[2] = 0.5)),
        ("slot 2 has no connection at the goal", Box::new(|p| p.slots[1].pose.position_m[0] = 0.82)),
        (
            "[rules] battery_v = 9.5 V: the table of the thrusters covers 10 to 20 V",
            Box::new(|p| {
                p.rules.battery_v = 9.5;
            }),
        ),
        ("[rules] battery_v = NaN V", Box::new(|p| p.rules.battery_v = f64::NAN)),
        ("[rules] speed_m_s = 0 m/s", Box::new(|p| p.rules.speed_m_s = 0.0)),
        ("[rules] speeds_m_s = 0.6 m/s: the least", Box::new(|p| p.rules.speeds_m_s[0] = 0.6)),
        ("[rules] yaw_rates_rad_s = inf rad/s", Box::new(|p| p.rules.yaw_rates_rad_s[1] = f64::INFINITY)),
        ("[rules] dock_s = -1 s", Box::new(|p| p.rules.dock_s = -1.0)),
        ("[rules] current_m_s = -11 m/s", Box::new(|p| p.rules.current_m_s[1] = -11.0)),
        ("robot 2 is -0.200 m from the edge of [bounds]: 0.1 m are asked", Box::new(|p| edge(p, 0.8))),
        (
            "slot 2 is 0.050 m from the edge of [bounds]: 0.1 m are asked",
            Box::new(|p| {
                edge(p, 3.0);
                p.bounds.as_mut().expect("bounds").edge_m[1][0] = 1.05;
                p.bounds.as_mut().expect("bounds").edge_m[2][0] = 1.05;
            }),
        ),
        (
            "[bounds] edge_m: has 2 vertices",
            Box::new(|p| {
                edge(p, 3.0);
                p.bounds.as_mut().expect("bounds").edge_m.truncate(2);
            }),
        ),
        ("[rules] grid_divisions = 0 cells", Box::new(|p| p.rules.grid_divisions[1] = 0)),
        ("[rules] bounds_m = NaN m", Box::new(|p| bounds(p, f64::NAN))),
        ("[rules] bounds_m = [[1.0, 1.0, 1.0], [-1.0, -1.0, -1.0]] m", Box::new(|p| bounds(p, -1.0))),
    ];
    for (expected, change) in cases {
        let said = refused(change);
        assert!(said.starts_with(expected), "{said}\nexpected {expected}");
    }
}

#[test]
fn two_pairs_are_not_one_cluster() {
    let said = refused(|p| {
        p.tools.clear();
        for (x, id) in [(-2.0, 3), (-2.4, 4)] {
            p.robots.push(Robot { id, start: [x, 0.0, 0.0, 0.0].into(), ..p.robots[0].clone() });
            p.slots.push(Slot { pose: [x, 0.0, 1.0, 0.0].into(), requires: Vec::new() });
        }
    });
    assert_eq!(said, "the start is not one cluster: no chain of connections from robot 1 to robot 3");
}

#[test]
fn robots_that_crowd_into_too_few_slots_are_named() {
    let sonar = || vec!["sonar".to_owned()];
    let said = refused(|p| {
        p.robots[1].capabilities = sonar();
        p.slots.iter_mut().for_each(|slot| slot.requires = sonar());
    });
    assert_eq!(said, "robots 1 fit only into no slot: no one-to-one assignment");
    let said = refused(|p| {
        p.robots.push(Robot { id: 3, start: [-1.2, 0.0, 0.0, 0.0].into(), ..p.robots[0].clone() });
        p.slots.push(Slot { pose: [1.2, 0.0, 0.0, 0.0].into(), requires: sonar() });
        p.slots[1].requires = sonar();
        p.robots[1].capabilities = sonar();
    });
    assert_eq!(said, "robots 1, 3 fit only into slots 1: no one-to-one assignment");
}

#[test]
fn what_a_choice_of_robots_can_mend_is_no_mistake() {
    // More slots than robots: one that hangs loose may stay empty, overlapping ones are refused still.
    let mut problem = good();
    problem.slots.push(Slot { pose: [3.0, 0.0, 0.0, 0.0].into(), requires: Vec::new() });
    assert_eq!(problem.check(), Ok(()));
    // A longer robot fits the same slots only where there is room for it.
    let mut problem = good();
    problem.vehicles.push(hull("long", [0.6, 0.3, 0.2], 1));
    problem.robots[1].vehicle = 2;
    problem.robots[1].start.position_m[0] = -0.9;
    problem.slots[1].pose.position_m[0] = 0.9;
    assert_eq!(problem.check(), Ok(()));
    // Only the long one may go to the first slot: certain to overlap the tool.
    problem.robots[1].capabilities = vec!["sonar".to_owned()];
    problem.slots[0].requires = vec!["sonar".to_owned()];
    let said = problem.check().expect_err("overlap").to_string();
    assert_eq!(said, "slot 1 and tool 1 overlap by 0.100 m");
}

/// A long robot fits beside a short one in a gap for both; two long ones do not, wherever they are put.
#[test]
fn boxes_that_overlap_in_every_assignment_are_named() {
    let with = |long: usize| {
        let mut problem = good();
        problem.tools.clear();
        problem.vehicles.push(hull("long", [0.6, 0.3, 0.2], 1));
        problem.slots.push(Slot { pose: [1.3, 0.0, 0.0, 0.0].into(), requires: Vec::new() });
        problem.slots[1].pose.position_m[0] = 0.9;
        problem.robots.push(Robot {
            id: 3,
            start: [-1.2, 0.0, 0.0, 0.0].into(),
            ..problem.robots[0].clone()
        });
        // In a row, docked: the long ones last.
        let mut x = -0.2;
        for (n, robot) in problem.robots.iter_mut().enumerate() {
            let (vehicle, length) = if n + long >= 3 { (2, 0.6) } else { (0, 0.4) };
            robot.vehicle = vehicle;
            robot.start.position_m[0] = x - length / 2.0;
            x -= length;
        }
        problem.check()
    };
    // Slots at 0.4, 0.9 and 1.3: the long one goes to the first.
    assert_eq!(with(1), Ok(()));
    assert_eq!(with(2).expect_err("two long ones").to_string(), ProblemError::NoFit.to_string());
}
