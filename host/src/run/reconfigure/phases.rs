//! Where the energy of an execution went: planned and executed, by what the mover did meanwhile.
//!
//! | phase | from | to |
//! |---|---|---|
//! | hand-over | the beginning of a move | the robot lets go |
//! | transit | there | d of (19) before its slot, on the last leg |
//! | approach | there | the end of the last leg, by the plan |
//! | docking | the end by the plan | it takes hold |
//!
//! What the mover draws is to navigate, what all others draw meanwhile is to balance and to hold. The planned energy of a leg is shared
//! between transit and approach by time. Executed energies are sums over the samples of the record, each for the time until the next. A
//! move whose time stood still on the way counts that as docking.

use std::fmt::{self, Display, Formatter};

use quantity::vector::length;
use reconfiguration::plan::{ActionKind, Move};
use reconfiguration::problem::Rules;
use record::reconfigure::Record;
use rov::conditions::Conditions;
use rov::guidance::reference::ReferenceTrajectory;

use super::conductor::HAND_OVER_S;

const NAMES: [&str; 4] = ["hand-over", "transit", "approach", "docking"];

/// Time, s, and energy of the mover and of the others, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// s.
    pub time_s: f64,
    /// J.
    pub navigate_j: f64,
    /// J.
    pub balance_j: f64,
}

/// See the module's documentation: planned and executed, a row a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phases([[Share; 2]; 4]);

impl Phases {
    /// Of an execution.
    #[must_use]
    pub fn of(record: &Record) -> Self {
        let mut phases = Self::default();
        for (number, own) in record.plan.moves.iter().enumerate() {
            let problem = &record.problem;
            let Some(mover) = problem.robots.iter().position(|robot| robot.id == own.robot) else { continue };
            let Some(vehicle) = problem.vehicles.get(problem.robots[mover].vehicle) else { continue };
            let parts = parts(own, &problem.rules, problem.clearance_m(vehicle));
            phases.plan(own, &parts);
            let ends_s = [0, 1, 2]
                .map(|phase| parts.iter().filter(|part| part.0 <= phase).map(|part| part.1).sum::<f64>());
            let mut began_s = None;
            for pair in record.samples.windows(2) {
                let [sample, next] = pair else { continue };
                if sample.moving != Some(number) {
                    continue;
                }
                let since_s = sample.t_s - *began_s.get_or_insert(sample.t_s);
                let phase = ends_s.iter().take_while(|end_s| since_s >= **end_s).count();
                let [_, executed] = &mut phases.0[phase.min(3)];
                let dt_s = next.t_s - sample.t_s;
                executed.time_s += dt_s;
                for (robot, seen) in sample.robots.iter().enumerate() {
                    let of = if robot == mover { &mut executed.navigate_j } else { &mut executed.balance_j };
                    *of += seen.power_w * dt_s;
                }
            }
        }
        phases
    }

    /// Planned and executed, of a phase.
    #[must_use]
    pub fn rows(&self) -> &[[Share; 2]; 4] {
        &self.0
    }

    fn plan(&mut self, own: &Move, parts: &[(usize, f64, f64)]) {
        for &(phase, time_s, navigate_j) in parts {
            let [planned, _] = &mut self.0[phase];
            planned.time_s += time_s;
            planned.navigate_j += navigate_j;
            planned.balance_j += own.balance_w * time_s;
        }
    }
}

/// The parts of a move as it is executed: phase, time, s, and planned energy, J. The mover keeps `distance_m`, d of (19).
fn parts(own: &Move, rules: &Rules, distance_m: f64) -> Vec<(usize, f64, f64)> {
    let last = own.actions.iter().rposition(|action| action.kind == ActionKind::Leg);
    let mut parts = Vec::new();
    for (index, action) in own.actions.iter().enumerate() {
        let trajectory = ReferenceTrajectory::new(action, rules);
        let duration_s = trajectory.duration_s();
        match action.kind {
            ActionKind::Undock => parts.push((0, duration_s.max(HAND_OVER_S), action.energy_j)),
            ActionKind::Dock => parts.push((3, duration_s, action.energy_j)),
            _ if last == Some(index) => {
                // The way only grows: halve the time in which it comes that near.
                let (mut early_s, mut late_s) = (0.0, duration_s);
                for _ in 0..40 {
                    let middle_s = 0.5 * (early_s + late_s);
                    let place_m = trajectory.at(middle_s).pose.position_m;
                    let left_m = length([0, 1, 2].map(|k| action.to.position_m[k] - place_m[k]));
                    if left_m > distance_m { early_s = middle_s } else { late_s = middle_s }
                }
                let share = if duration_s > 0.0 { early_s / duration_s } else { 0.0 };
                parts.push((1, early_s, share * action.energy_j));
                parts.push((2, duration_s - early_s, (1.0 - share) * action.energy_j));
            }
            ActionKind::Leg | ActionKind::Turn => {
                let phase = if last.is_some_and(|last| index > last) { 2 } else { 1 };
                parts.push((phase, duration_s, action.energy_j));
            }
        }
    }
    parts
}

impl Display for Phases {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "  {:<12}{:>30}{:>33}", "J by phase", "planned", "executed")?;
        let heads = ["s", "navigate", "balance"];
        write!(f, "  {:<12}", "")?;
        for head in heads.iter().chain(&heads) {
            write!(f, "{head:>11}")?;
        }
        writeln!(f)?;
        for (name, row) in NAMES.iter().zip(&self.0) {
            write!(f, "  {name:<12}")?;
            for Share { time_s, navigate_j, balance_j } in row {
                write!(f, "{time_s:>11.1}{navigate_j:>11.2}{balance_j:>11.2}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
