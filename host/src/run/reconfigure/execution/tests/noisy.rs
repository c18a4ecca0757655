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
    /// Robot, thruster, from 0, and the move that it fails in, from 0.
    dead: Option<(usize, usize, usize)>,
    /// Weight in water that no model knows, N, of every robot.
    heavier_n: f64,
    faults: Vec<Fault>,
    seed: u64,
}

fn plan_of(name: &str) -> (Problem, Plan, PowerLaw) {
    let problem = ReconfigureScenario::open(name).expect("built in").problem;
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("valid");
    let request = Request {
        criterion: Criterion::Energy,
        manner: Manner::Best,
        order: OrderRule::Exact,
        law: law.clone(),
    };
    let plan = rov::planner::plan(&problem, &request).expect("a plan").plan;
    (problem, plan, law)
}

/// Executes the plan of a built-in scenario with estimated states; what was said.
fn executed(name: &str, trouble: Trouble) -> (Summary, Vec<String>) {
    let (problem, plan, law) = plan_of(name);
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
        doubled: 0.0,
        clock_ahead_s: 1000.0,
    };
    let cameras = Cameras::new(parameters, axes, labels, trouble.faults, trouble.seed).expect("cameras");
    let site = Site {
        water: Some(water),
        poses: SimulatedBodies::new(cameras, axes, roster, numbers),
        fixes: Some(Fixes { hold_after_s: 1.0 }),
    };
    let mut hook = |_: FleetInstant, execution: &Execution<'_>, fleet: &mut InProcess<Thrusters>| {
        if let Some((robot, thruster, number)) = trouble.dead
            && execution.conductor().moving().is_some_and(|moving| moving >= number)
            && execution.conductor().reference().is_some()
        {
            fleet.modules_mut()[robot].set_failed(thruster);
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
    let mut heard = Heard::default();
    let log = (Log::default(), Title::default());
    let summary = run_with(log, &problem, &plan, &options, &mut fleet, drive, site, &mut heard).expect("begun").summary;
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
    (summary, heard.0)
}

fn calm(seed: u64) -> Trouble {
    Trouble { current_m_s: [0.0; 3], dead: None, heavier_n: 0.0, faults: Vec::new(), seed }
}

fn assert_docked(summary: &Summary, of: &str) {
    assert_eq!(summary.failure, None, "{of}");
    for figures in &summary.moves {
        let (off_m, off_rad) = (figures.end_m.unwrap_or(9.0), figures.end_rad.unwrap_or(9.0));
        assert!(off_m <= DOCK_M && off_rad <= DOCK_RAD, "{of}: robot {}: {off_m} m, {off_rad} rad", figures.robot);
    }
}

#[test]
fn robots_dock_by_noisy_poses_in_a_current() {
    for name in ["i-to-l", "t-to-i-far"] {
        for current_m_s in [[0.0; 3], [0.05, 0.0, 0.0], [-0.05, 0.0, 0.0], [0.0, 0.05, 0.0]] {
            let of = format!("{name} in {current_m_s:?} m/s");
            println!("{of}");
            let (summary, heard) = executed(name, Trouble { current_m_s, ..calm(1) });
            assert_docked(&summary, &of);
            assert!(heard.iter().all(|said| !said.contains("gives nothing")), "{of}: {heard:?}");
        }
    }
}
