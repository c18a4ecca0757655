//! What docking takes: letting go, the way, taking hold, as executed and as planned.

use host::run::progress::Quiet;
use host::run::reconfigure::execution::{Options, execute};
use host::run::reconfigure::scenario::ReconfigureScenario;
use link::faults::FaultParameters;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::problem::Problem;
use rov::planner::{OrderRule, Request, plan};
use rov::power::PowerLaw;
use tests::figures::mean;
use tests::reconfigure::{Kind, problem};

/// Pause between two samples of a record, s.
const SAMPLE_S: f64 = 0.05;

/// Time, s, and energy of all robots, J.
#[derive(Clone, Copy, Default)]
struct Spent {
    time_s: f64,
    energy_j: f64,
}

#[test]
fn what_docking_takes_is_planned() {
    let mut problems: Vec<Problem> = ["t-to-i-far", "t-to-i-below", "i-to-l", "sonar-to-bow"]
        .map(|name| ReconfigureScenario::open(name).expect("built in").problem)
        .to_vec();
    for seed in 0..6 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kind = Kind { robots: 3 + seed as usize % 3, ..Kind::random(&mut rng) };
        let mut random = problem(kind, &mut rng);
        random.rules.grid_divisions = [1, 1, 1];
        problems.push(random);
    }
    let mut ratios = Vec::new();
    let mut all = [Vec::new(), Vec::new(), Vec::new()];
    println!(
        "problem, move: planned J, s; executed J, s, ratio; of that letting go, on the way, taking hold"
    );
    for problem in &problems {
        let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
        let (criterion, manner, order) = (Criterion::Energy, Manner::Best, OrderRule::Paper);
        let request = Request { criterion, manner, order, law: law.clone() };
        let Ok(planned) = plan(problem, &request) else { continue };
        let options = Options { seed: 1, radio: FaultParameters::default(), law };
        let executed = execute(problem, &planned.plan, &options, &mut Quiet).expect("begun");
        assert_eq!(executed.summary.failure, None, "{}", problem.name);
        for (number, own) in planned.plan.moves.iter().enumerate() {
            let robot = problem.robots.iter().position(|robot| robot.id == own.robot).expect("known");
            let mut phases = [Spent::default(); 3];
            let undock_s = own.actions.first().map_or(0.0, |undock| undock.duration_s);
            let dock_s = own.actions.last().map_or(0.0, |dock| dock.duration_s);
            for sample in executed.record.samples.iter().filter(|sample| sample.moving == Some(number)) {
                let on_its_way = own.duration_s - undock_s - dock_s;
                let phase = match sample.robots[robot].reference {
                    None => 0,
                    Some(_) if phases[1].time_s < on_its_way - SAMPLE_S / 2.0 => 1,
                    Some(_) => 2,
                };
                phases[phase].time_s += SAMPLE_S;
                phases[phase].energy_j += SAMPLE_S * sample.robots.iter().map(|of| of.power_w).sum::<f64>();
            }
            let figures = &executed.summary.moves[number];
            let ratio = figures.executed.total_j / figures.planned.total_j;
            let shown =
                phases.map(|spent| format!("{:.2} J {:.2} s", spent.energy_j, spent.time_s)).join(", ");
            println!(
                "{}, {}: {:.2} J {:.2} s; {:.2} J {:.2} s, {ratio:.3}; {shown}",
                problem.name,
                number + 1,
                figures.planned.total_j,
                figures.planned.time_s,
                figures.executed.total_j,
                figures.executed.time_s
            );
            ratios.push(ratio);
            for (all, spent) in all.iter_mut().zip(phases) {
                all.push(spent);
            }
        }
    }
    for (name, spent) in ["letting go", "on the way", "taking hold"].into_iter().zip(&all) {
        let energy_j = mean(spent.iter().map(|spent| spent.energy_j));
        println!(
            "{name}: {energy_j:.3} J in {:.3} s on average",
            mean(spent.iter().map(|spent| spent.time_s))
        );
    }
    let (mean, most) = (
        mean(ratios.iter().copied()),
        ratios.iter().fold(0.0, |most: f64, ratio| most.max((ratio - 1.0).abs())),
    );
    println!("{} moves: executed/planned {mean:.4} on average, off by {most:.4} at most", ratios.len());
    assert!(most < 0.03, "{most}");
}
