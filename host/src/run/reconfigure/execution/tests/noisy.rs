//! Poses by simulated cameras in simulated time: 100 Hz, 2 mm and 0.01 rad of noise, 30 ms of latency, a current, a thruster that fails.

use pose::axes::{Axes, Unit, Up};
use pose::frame::Label;
use pose::roster::{Entry, Name, Roster};
use reconfiguration::vehicle::Vehicle;
use sim::lab::{CameraParameters, Cameras, Fault};

use super::super::super::super::progress::Progress;
use super::super::super::conductor::{DOCK_M, DOCK_RAD};
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
    /// The move, from 0, in which a thruster of a waiting robot fails: the one that pushes so manyth most, from 0.
    dead: Option<(usize, usize)>,
    /// Weight in water that no model knows, N, of every robot.
    heavier_n: f64,
    faults: Vec<Fault>,
    seed: u64,
}

/// Executes the plan of a built-in scenario with estimated states; what was said.
fn executed(name: &str, trouble: Trouble) -> (Summary, Vec<String>, Option<(usize, usize, f64)>) {
    let (problem, plan, law) = planned(name);
    let options = Options { seed: trouble.seed, radio: FaultParameters::default(), law };
    let mut fleet = InProcess::rovs(&problem, options.radio, options.seed).expect("valid");
    let conductor = Conductor::new(&problem, &plan, options.law.clone()).expect("fits");
    let heavier = |&(pose, vehicle): &(_, &Vehicle)| {
        let mut vehicle = vehicle.clone();
        vehicle.body.weight_n += if vehicle.thrusters.is_empty() { 0.0 } else { trouble.heavier_n };
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
        poses: SimulatedBodies::new(cameras, axes, roster, numbers),
        fixes: Some(Fixes { hold_after_s: 1.0 }),
    };
    let mut failed = None;
    let mut due = None;
    let mut hook = |now: FleetInstant, execution: &Execution<'_>, fleet: &mut InProcess<Thrusters>| {
        let conductor = execution.conductor();
        if let (None, Some((number, nth)), Some(_)) = (failed, trouble.dead, conductor.reference())
            && conductor.moving() == Some(number)
            && now >= *due.get_or_insert(now.after(protocol::time::Duration(15_000_000)))
        {
            let mut pushing: Vec<(usize, usize, f64)> = Vec::new();
            for (robot, module) in
                fleet.modules().iter().enumerate().filter(|(robot, _)| conductor.arrived()[*robot])
            {
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
    let log = (Log::default(), Title::default());
    let summary =
        run_with(log, &problem, &plan, &options, &mut fleet, drive, site, &mut heard).expect("begun").summary;
    println!(
        "{name}, seed {}: {:?}, executed {:.2} J of {:.2} J planned: {:.3}; docked {:?} m, {:?} rad; heard {:?}",
        trouble.seed,
        summary.failure,
        summary.executed.total_j,
        summary.planned.total_j,
        summary.ratio.unwrap_or(f64::NAN),
        summary.moves.iter().map(|figures| figures.end_m).collect::<Vec<_>>(),
        summary.moves.iter().map(|figures| figures.end_rad).collect::<Vec<_>>(),
        heard.0,
    );
    for figures in &summary.moves {
        println!(
            "  robot {}: planned {:.2} + {:.2} J in {:.1} s, executed {:.2} + {:.2} J in {:.1} s, beside {:.3} m",
            figures.robot,
            figures.planned.navigate_j,
            figures.planned.balance_j,
            figures.planned.time_s,
            figures.executed.navigate_j,
            figures.executed.balance_j,
            figures.executed.time_s,
            figures.cross_track_m
        );
    }
    (summary, heard.0, failed)
}

fn calm(seed: u64) -> Trouble {
    Trouble { current_m_s: [0.0; 3], dead: None, heavier_n: 0.0, faults: Vec::new(), seed }
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

/// What the same takes with exact poses in the same current, with no noise and no fault, J.
fn undisturbed_j(name: &str, current_m_s: [f64; 3]) -> f64 {
    let (problem, plan, law) = planned(name);
    let options = Options { seed: 1, radio: FaultParameters::default(), law };
    let mut fleet = InProcess::rovs(&problem, options.radio, options.seed).expect("valid");
    let mut site = Site::simulated(&problem, &plan, &options.law).expect("bodies");
    site.water.as_mut().expect("water").set_current(current_m_s);
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut |_, _, _| {} };
    let log = (Log::default(), Title::default());
    let summary =
        run_with(log, &problem, &plan, &options, &mut fleet, drive, site, &mut Quiet).expect("begun").summary;
    println!(
        "{name} in {current_m_s:?} m/s, exact poses: {:?}, {:.2} J",
        summary.failure, summary.executed.total_j
    );
    summary.executed.total_j
}

#[test]
fn robots_dock_by_noisy_poses_in_a_current() {
    for name in ["i-to-l", "t-to-i-far"] {
        for current_m_s in [[0.0; 3], [0.05, 0.0, 0.0], [-0.05, 0.0, 0.0], [0.0, 0.05, 0.0]] {
            let of = format!("{name} in {current_m_s:?} m/s");
            let least_j = undisturbed_j(name, current_m_s);
            let (summary, heard, _) = executed(name, Trouble { current_m_s, ..calm(1) });
            println!("{of}: {:.3} of undisturbed", summary.executed.total_j / least_j);
            assert_docked(&summary, &of);
            assert!(heard.iter().all(|said| !said.contains("gives nothing")), "{of}: {heard:?}");
            assert!(
                summary.executed.total_j <= 1.2 * least_j,
                "{of}: {} of {least_j} J",
                summary.executed.total_j
            );
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
        ("i-to-l", 0.0, 2),
        ("t-to-i-far", 1.5, 3),
        ("i-to-l", 1.5, 2),
    ] {
        let least_j = undisturbed_j(name, current_m_s);
        for nth in 0..most {
            let trouble = Trouble { current_m_s, dead: Some((2, nth)), heavier_n, ..calm(1) };
            let (summary, heard, failed) = executed(name, trouble);
            let (robot, thruster, thrust_n) = failed.expect("failed");
            let of = format!("{name}, thruster {} of robot {}, {thrust_n:.3} N", thruster + 1, robot + 1);
            let ratio = summary.executed.total_j / least_j;
            let named = format!("thruster {} of robot {} gives nothing", thruster + 1, robot + 1);
            let is_named = heard.iter().any(|said| said.contains(&named));
            println!("{of}: {ratio:.3} of undisturbed, named: {is_named}");
            assert_docked(&summary, &of);
            let others = heard.iter().filter(|said| said.contains("gives nothing") && !said.contains(&named));
            assert_eq!(others.count(), 0, "{of}: {heard:?}");
            assert!(is_named || thrust_n.abs() < 0.3, "{of}: {heard:?}");
            assert!(ratio <= 1.2 || heavier_n > 0.0, "{of}: {ratio}");
        }
    }
}

/// A robot that is heavier than its file says is held up by what the observer finds.
#[test]
fn a_wrong_buoyancy_is_taken_up() {
    let (summary, ..) = executed("i-to-l", Trouble { heavier_n: 1.0, ..calm(3) });
    assert_docked(&summary, "i-to-l, 1 N heavier");
}

/// Three seconds without a fix in mid-move: a hold with its name, and the plan goes on.
#[test]
fn a_blind_run_holds_and_goes_on() {
    let faults = vec!["blind@20+3".parse().expect("a fault")];
    let (summary, heard, _) = executed("i-to-l", Trouble { faults, ..calm(4) });
    assert_docked(&summary, "i-to-l, blind for 3 s");
    assert!(heard.iter().any(|said| said.starts_with("no fix of robot 1 for 1 s")), "{heard:?}");
    assert!(heard.iter().any(|said| said.starts_with("fixes come again")), "{heard:?}");
}
