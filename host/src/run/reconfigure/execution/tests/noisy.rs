//! Poses by simulated cameras in simulated time: 100 Hz, 2 mm and 0.01 rad of noise, 30 ms of latency, a current, a thruster that fails.

use std::path::PathBuf;

use identify::rov::outcome::Scale;
use pose::axes::{Axes, Unit, Up};
use pose::frame::Label;
use pose::roster::{Entry, Name, Roster};
use quantity::bounds::Bounds;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::configuration::LevelBox;
use sim::lab::{CameraParameters, Cameras, Fault};

use super::super::super::super::identify::{Logged, logged_file};
use super::super::super::super::progress::{Progress, Quiet};
use super::super::super::conductor::{DOCK_M, DOCK_RAD};
use super::super::super::phases::Phases;
use super::super::super::poses::SimulatedBodies;
use super::*;

/// Keeps what is said.
#[derive(Default)]
struct Heard(Vec<String>);

impl Progress for Heard {
    fn note(&mut self, text: &str) {
        self.0.push(text.to_owned());
    }
    fn at(&mut self, _t_s: f64, _duration_s: f64) {}
}

/// What goes wrong.
struct Trouble {
    current_m_s: [f64; 3],
    /// The current that the scenario expects, which the plan is priced for.
    expected_m_s: [f64; 3],
    bounds: Option<Bounds>,
    /// The move, from 0, in which a thruster of a waiting robot fails: the one that pushes so manyth most, from 0.
    dead: Option<(usize, usize)>,
    /// Weight in water that no model knows, N, of every robot.
    heavier_n: f64,
    /// Damping over what the model has, of every robot.
    drag: f64,
    faults: Vec<Fault>,
    /// Where the log goes, if it is wanted.
    log: Option<PathBuf>,
    seed: u64,
}

/// Executes the plan of a built-in scenario with estimated states; what was said, and the thruster that failed.
fn executed(name: &str, trouble: Trouble) -> (Executed, Vec<String>, Option<(usize, usize, f64)>) {
    let (problem, plan, law) = planned_in(name, |problem| {
        problem.rules.current_m_s = trouble.expected_m_s;
        problem.bounds = trouble.bounds;
    });
    let options = Options { seed: trouble.seed, radio: FaultParameters::default(), law };
    let mut fleet = InProcess::rovs(&problem, options.radio, options.seed).expect("valid");
    let conductor = Conductor::new(&problem, &plan, options.law.clone()).expect("fits");
    let heavier = |&(pose, vehicle): &(_, &Vehicle)| {
        let mut vehicle = vehicle.clone();
        if !vehicle.thrusters.is_empty() {
            vehicle.body.weight_n += trouble.heavier_n;
            vehicle.body.linear_damping = vehicle.body.linear_damping.map(|damping| trouble.drag * damping);
            vehicle.body.quadratic_damping =
                vehicle.body.quadratic_damping.map(|damping| trouble.drag * damping);
        }
        (pose, vehicle)
    };
    let real: Vec<_> = conductor.bodies().iter().map(heavier).collect();
    let real: Vec<_> = real.iter().map(|(pose, vehicle)| (*pose, vehicle)).collect();
    let mut water = Water::new(&real).expect("bodies");
    water.set_current(trouble.current_m_s);
    let numbers: Vec<u16> = (1..=real.len() as u16).collect();
    let entry = |&module: &u16| Entry {
        module,
        body: Name::Name(format!("body-{module}")),
        offset_m: nalgebra::Vector3::zeros(),
        turn_rad: 0.0,
    };
    let roster = Roster::new(numbers.iter().map(entry).collect()).expect("a roster");
    let labels = numbers.iter().map(|number| Label::named(&format!("body-{number}"))).collect();
    let axes = Axes::new(Up::Z, Unit::Millimetre);
    let parameters = CameraParameters {
        rate_hz: 100.0,
        position_noise_m: 0.002,
        attitude_noise_rad: 0.01,
        latency_s: 0.03,
        jitter_s: 0.005,
        loss: 0.02,
        clock_ahead_s: 1000.0,
    };
    let cameras = Cameras::new(parameters, axes, labels, trouble.faults, trouble.seed).expect("cameras");
    let site = Site {
        water: Some(water),
        poses: SimulatedBodies::new(cameras, axes, roster),
        fixes: Some(Fixes { hold_after_s: 1.0 }),
    };
    let mut failed = None;
    let mut due = None;
    let mut hook = |now: FleetInstant, execution: &Execution<'_>, fleet: &mut InProcess<Thrusters>| {
        let conductor = execution.conductor();
        if let (None, Some((number, nth)), Some(_)) =
            (failed, trouble.dead, conductor.followed().iter().find(|mover| mover.reference.is_some()))
            && conductor.moving() == Some(number)
            && now >= *due.get_or_insert(now.after(protocol::time::Duration(15_000_000)))
        {
            let mut pushing: Vec<(usize, usize, f64)> = Vec::new();
            // Of one that is still to move: without a thruster it would not steer.
            let stays = |&(robot, _): &(usize, _)| conductor.arrived()[robot];
            for (robot, module) in fleet.modules().iter().enumerate().filter(stays) {
                let thrusts_n = module.thrusts_n().iter().enumerate();
                pushing.extend(thrusts_n.map(|(thruster, thrust_n)| (robot, thruster, *thrust_n)));
            }
            pushing.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
            let (robot, thruster, thrust_n) = pushing[nth];
            println!("thruster {} of robot {} fails, which gave {thrust_n:.3} N", thruster + 1, robot + 1);
            fleet.modules_mut()[robot].set_failed(thruster);
            failed = Some((robot, thruster, thrust_n));
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
    let mut heard = Heard::default();
    let log = trouble.log.as_deref().map_or_else(Log::default, |path| Log::create(path).expect("a log"));
    let log = (log, Title::default());
    let outcome =
        run_with(log, &problem, &plan, &options, &mut fleet, drive, site, &mut heard).expect("begun");
    let summary = &outcome.summary;
    println!(
        "{name} in {:?} m/s, seed {}: {:?}, executed {:.2} J of {:.2} J planned: {:.3}; docked {:?} m, {:?} rad; heard {:?}",
        trouble.current_m_s,
        trouble.seed,
        summary.failure,
        summary.executed.total_j,
        summary.planned.total_j,
        summary.ratio.unwrap_or(f64::NAN),
        summary.moves.iter().map(|figures| figures.end_m).collect::<Vec<_>>(),
        summary.moves.iter().map(|figures| figures.end_rad).collect::<Vec<_>>(),
        heard.0,
    );
    println!("{}", Phases::of(&outcome.record));
    (outcome, heard.0, failed)
}

fn calm(seed: u64) -> Trouble {
    Trouble {
        current_m_s: [0.0; 3],
        expected_m_s: [0.0; 3],
        bounds: None,
        dead: None,
        heavier_n: 0.0,
        drag: 1.0,
        faults: Vec::new(),
        log: None,
        seed,
    }
}

/// In a current that the scenario states.
fn flowing(current_m_s: [f64; 3], seed: u64) -> Trouble {
    Trouble { current_m_s, expected_m_s: current_m_s, ..calm(seed) }
}

fn assert_docked(summary: &Summary, of: &str) {
    let failure = summary.failure.as_deref();
    assert!(failure.is_none_or(|why| why.starts_with("thruster ")), "{of}: {failure:?}");
    for figures in &summary.moves {
        let (off_m, off_rad) = (figures.end_m.unwrap_or(9.0), figures.end_rad.unwrap_or(9.0));
        assert!(
            off_m <= DOCK_M && off_rad <= DOCK_RAD,
            "{of}: robot {}: {off_m} m, {off_rad} rad",
            figures.robot
        );
    }
}

/// A plan that is priced for the current is executed within 1.2 of it: I to L, and T to I with a tool to balance, whichever way the water
/// flows.
#[test]
fn robots_dock_by_noisy_poses_in_a_current() {
    for name in ["i-to-l", "t-to-i-far"] {
        for current_m_s in [[0.0; 3], [0.05, 0.0, 0.0], [-0.05, 0.0, 0.0], [0.0, 0.05, 0.0]] {
            let of = format!("{name} in {current_m_s:?} m/s");
            let (Executed { summary, .. }, heard, _) = executed(name, flowing(current_m_s, 1));
            assert_docked(&summary, &of);
            assert!(heard.iter().all(|said| !said.contains("gives nothing")), "{of}: {heard:?}");
            let (executed_j, planned_j) = (summary.executed.total_j, summary.planned.total_j);
            assert!(executed_j <= 1.2 * planned_j, "{of}: {executed_j} of {planned_j} J");
        }
    }
}

/// In the third move a thruster of a robot that waits gives nothing any more: every robot docks, and the thruster is named where it is
/// missed at all.
#[test]
fn a_thruster_that_fails_is_allocated_around_and_named() {
    let current_m_s = [0.05, 0.0, 0.0];
    for (name, heavier_n, most) in [
        ("t-to-i-far", 0.0, 3),
        ("t-to-i-below", 0.0, 2),
        ("i-to-l", 0.0, 1),
        ("t-to-i-far", 1.0, 1),
        ("i-to-l", 1.5, 1),
    ] {
        for nth in 0..most {
            let trouble = Trouble { dead: Some((2, nth)), heavier_n, ..flowing(current_m_s, 1) };
            let (Executed { summary, .. }, heard, failed) = executed(name, trouble);
            let (robot, thruster, thrust_n) = failed.expect("failed");
            let of = format!("{name}, thruster {} of robot {}, {thrust_n:.3} N", thruster + 1, robot + 1);
            let named = format!("thruster {} of robot {} gives nothing", thruster + 1, robot + 1);
            let is_named = heard.iter().any(|said| said.contains(&named));
            println!("{of}: {:.3} of planned, named: {is_named}", summary.ratio.unwrap_or(f64::NAN));
            assert_docked(&summary, &of);
            let others = heard.iter().filter(|said| said.contains("gives nothing") && !said.contains(&named));
            assert_eq!(others.count(), 0, "{of}: {heard:?}");
            assert!(is_named || thrust_n.abs() < 0.3, "{of}: {heard:?}");
        }
    }
}

/// A robot that is heavier than its file says is held up by what the observer finds.
#[test]
fn a_wrong_buoyancy_is_taken_up() {
    let (outcome, ..) = executed("i-to-l", Trouble { heavier_n: 1.0, ..calm(3) });
    assert_docked(&outcome.summary, "i-to-l, 1 N heavier");
}

/// Three seconds without a fix in mid-move: a hold with its name, and the plan goes on.
#[test]
fn a_blind_run_holds_and_goes_on() {
    let faults = vec!["blind@20+3".parse().expect("a fault")];
    let (outcome, heard, _) = executed("i-to-l", Trouble { faults, ..calm(4) });
    assert_docked(&outcome.summary, "i-to-l, blind for 3 s");
    assert!(heard.iter().any(|said| said.starts_with("no fix of robot 1 for 1 s")), "{heard:?}");
    assert!(heard.iter().any(|said| said.starts_with("fixes come again")), "{heard:?}");
}

/// The labels of the robot that moves and of one that waits are swapped for five seconds: the run says so and holds, then goes on. So it
/// does when a docked robot's body is seen elsewhere: that is no fix of its cluster.
#[test]
fn swapped_labels_and_a_body_astray_are_named_and_hold() {
    for (fault, said_of_it) in [
        ("swap:1,3@20+5", "no pose: the bodies of modules 1 and 3 have each other's label"),
        ("swap:1,2@20+5", "no pose: the bodies of modules 1 and 2 have each other's label"),
    ] {
        let faults = vec![fault.parse().expect("a fault")];
        let (outcome, heard, _) = executed("i-to-l", Trouble { faults, ..calm(5) });
        assert_docked(&outcome.summary, fault);
        assert!(heard.iter().any(|said| said.starts_with(said_of_it)), "{fault}: {heard:?}");
        assert!(heard.iter().any(|said| said.starts_with("no fix of robot")), "{fault}: {heard:?}");
        assert!(heard.iter().any(|said| said.starts_with("fixes come again")), "{fault}: {heard:?}");
    }
}

/// A current that no plan expects carries the robots towards the edge of the water as soon as it lets go. The plan waits until they are
/// back, then goes on, and no hull is ever outside.
#[test]
fn robots_that_drift_towards_the_edge_are_brought_back() {
    // Half a hull, 0.165 m, and little more than the margin.
    let edge_m = vec![[-1.5, -0.22], [5.0, -0.22], [5.0, 3.0], [-1.5, 3.0]];
    let bounds = Bounds { edge_m, margin_m: 0.05 };
    let trouble = Trouble { current_m_s: [0.0, -0.15, 0.0], bounds: Some(bounds.clone()), ..calm(6) };
    let (outcome, heard, _) = executed("i-to-l", trouble);
    assert_docked(&outcome.summary, "a current towards the edge");
    let vehicle = Vehicle::built_in("bluerov1").expect("built in");
    let hulls = outcome.record.samples.iter().flat_map(|sample| &sample.robots);
    let room_m = hulls.map(|robot| {
        let pose = Pose::from([robot.eta[0], robot.eta[1], robot.eta[2], robot.eta[5]]);
        bounds.room_m(&LevelBox::around(pose, &vehicle).outline_m())
    });
    let least_m = room_m.fold(f64::INFINITY, f64::min);
    println!("least room of a hull: {least_m:.3} m");
    assert!(
        heard.iter().any(|said| said.contains("from the edge of the water: the plan waits")),
        "{heard:?}"
    );
    assert!(heard.iter().any(|said| said.starts_with("no robot is too near to the edge")), "{heard:?}");
    assert!(least_m > 0.0 && least_m < 0.05, "{least_m} m");
}

/// What the water has and no model knows is found from the log of the run: by poses as they were measured, and thrusts as the host has them.
#[test]
fn constants_are_found_from_the_log_of_a_reconfiguration() {
    let path = std::env::temp_dir().join(format!("flotilla-rovs-{}.mcap", std::process::id()));
    let trouble =
        Trouble { heavier_n: 0.4, drag: 1.3, log: Some(path.clone()), ..flowing([0.04, -0.02, 0.0], 5) };
    executed("t-to-i-far", trouble);
    let Logged::Rovs(kinds) = logged_file(&path, &mut Quiet).expect("the log") else { panic!("of Modboats") };
    let _ = std::fs::remove_file(&path);
    let [kind] = &kinds[..] else { panic!("{} kinds", kinds.len()) };
    assert_eq!(kind.recording.swims.len(), 4, "one a robot");
    let body = &kind.vehicle.body;
    let outcome =
        ::identify::rov::identify(&kind.vehicle, std::slice::from_ref(&kind.recording), Scale::Thrust);
    let outcome = outcome.expect("identified");
    for (name, truth, within) in [
        ("mass_surge_kg", body.mass_kg + body.added_mass[0], 0.03),
        ("mass_heave_kg", body.mass_kg + body.added_mass[2], 0.03),
        ("linear_damping_surge_n_s_m", 1.3 * body.linear_damping[0], 0.06),
        ("linear_damping_heave_n_s_m", 1.3 * body.linear_damping[2], 0.06),
        ("weight_in_water_n", 0.4, 0.05),
        ("current_north_m_s", 0.04, 0.05),
        ("current_east_m_s", -0.02, 0.05),
    ] {
        let found = outcome.constant(name).expect(name);
        println!("{name}: {truth:.4}, found {:.4}, {:.4} … {:.4}", found.value, found.low, found.high);
        assert!((found.value / truth - 1.0).abs() < within, "{name}: {truth}, {found:?}");
    }
    let error = outcome.prediction.velocity_error.expect("foretold");
    assert!(error < 0.06, "{error}");
}
