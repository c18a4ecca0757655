//! Where the energy of an execution went: planned and executed, by what the mover did meanwhile.
//!
//! | phase | from | to |
//! |---|---|---|
//! | hand-over | the beginning of a move | the robot lets go |
//! | transit | there | the last leg of its plan |
//! | approach | the last leg | its end, by the plan |
//! | docking | the end by the plan | it takes hold |
//!
//! What the mover draws is to navigate, what all others draw meanwhile is to balance and to hold. Executed energies are sums over the
//! samples of the record, each for the time until the next. A move whose time stood still on the way counts that as docking.

use std::fmt::{self, Display, Formatter};

use reconfiguration::plan::{ActionKind, Move};
use reconfiguration::problem::Rules;
use record::reconfigure::Record;
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
            let ends_s = ends_s(own, &record.problem.rules);
            phases.plan(own, ends_s);
            let Some(mover) = record.problem.robots.iter().position(|robot| robot.id == own.robot) else {
                continue;
            };
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

    fn plan(&mut self, own: &Move, ends_s: [f64; 3]) {
        let last = own.actions.iter().rposition(|action| action.kind == ActionKind::Leg);
        for (index, action) in own.actions.iter().enumerate() {
            let phase = match action.kind {
                ActionKind::Undock => 0,
                ActionKind::Dock => 3,
                ActionKind::Leg | ActionKind::Turn => 1 + usize::from(last.is_some_and(|last| index >= last)),
            };
            let [planned, _] = &mut self.0[phase];
            planned.navigate_j += action.energy_j;
        }
        let mut since_s = 0.0;
        for (phase, end_s) in ends_s.into_iter().enumerate() {
            let [planned, _] = &mut self.0[phase];
            planned.time_s += end_s - since_s;
            planned.balance_j += own.balance_w * (end_s - since_s);
            since_s = end_s;
        }
    }
}

/// When hand-over, transit and approach of a move end as it is executed, s from its beginning.
fn ends_s(own: &Move, rules: &Rules) -> [f64; 3] {
    let last = own.actions.iter().rposition(|action| action.kind == ActionKind::Leg);
    let mut ends_s = [0.0; 3];
    let mut now_s = 0.0;
    for (index, action) in own.actions.iter().enumerate() {
        let duration_s = ReferenceTrajectory::new(action, rules).duration_s();
        match action.kind {
            ActionKind::Undock => now_s += duration_s.max(HAND_OVER_S),
            ActionKind::Dock => {}
            ActionKind::Leg | ActionKind::Turn => now_s += duration_s,
        }
        let phase = match action.kind {
            ActionKind::Undock => 0,
            _ if last.is_some_and(|last| index >= last) => 2,
            _ => 1,
        };
        for end_s in &mut ends_s[phase..] {
            *end_s = now_s;
        }
    }
    ends_s
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
