//! The figures of an executed reconfiguration: `summary.json`, and what is printed.

use link::faults::FaultCount;
use protocol::ledger::Incoming;
use reconfiguration::plan::{Criterion, Manner};
use serde::Serialize;

use super::super::shortfall::Shortfall;
use super::super::summary::{AbsenceFigures, GapFigures, LinkFigures, PoseFigures, complaints};

/// Energies and the time they were drawn in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// What the mover's thrusters draw (15), J.
    pub navigate_j: f64,
    /// What the thrusters of the waiting robots draw meanwhile (17), J.
    pub balance_j: f64,
    /// Their sum, J.
    pub total_j: f64,
    /// How long it takes, s.
    pub time_s: f64,
}

impl Energy {
    /// Of both parts.
    #[must_use]
    pub fn new(navigate_j: f64, balance_j: f64, time_s: f64) -> Self {
        Self { navigate_j, balance_j, total_j: navigate_j + balance_j, time_s }
    }
}

impl std::iter::Sum for Energy {
    fn sum<I: Iterator<Item = Self>>(energies: I) -> Self {
        energies.fold(Self::default(), |a, b| {
            Self::new(a.navigate_j + b.navigate_j, a.balance_j + b.balance_j, a.time_s + b.time_s)
        })
    }
}

/// One move's figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MoveFigures {
    /// The robot's id.
    pub robot: u16,
    /// Its slot, from 0; null where it parks.
    pub slot: Option<usize>,
    /// As the plan has it.
    pub planned: Energy,
    /// The same actions with acceleration counted, and the time to hand over the balance: what can be expected.
    pub expected: Energy,
    /// As it was, by the law of power of the plan.
    pub executed: Energy,
    /// As it was, by the measured table.
    pub by_table: Energy,
    /// Greatest distance from the path, m.
    pub cross_track_m: f64,
    /// Least gap between its hull and another one on the way, m; negative is an overlap of boxes. Docked ones touch.
    pub least_gap_m: Option<f64>,
    /// Distance from the slot when it was drawn in, m; nothing if it never was.
    pub end_m: Option<f64>,
    /// Angle then, rad.
    pub end_rad: Option<f64>,
}

/// The figures of one execution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the problem.
    pub problem: String,
    /// What was minimised.
    pub criterion: Criterion,
    /// By which rules.
    pub manner: Manner,
    /// Seed of everything random.
    pub seed: u64,
    /// What went wrong; null if every robot is in its slot, and all took part.
    pub failure: Option<String>,
    /// What was asked and not done, of that which ends no execution.
    pub shortfalls: Vec<Shortfall>,
    /// Spans in which the host did not run.
    pub gaps: Vec<GapFigures>,
    /// For how long robots took no part.
    pub absences: Vec<AbsenceFigures>,
    /// Every move begun, in order.
    pub moves: Vec<MoveFigures>,
    /// Σ of the moves begun, as planned.
    pub planned: Energy,
    /// With acceleration and hand-over.
    pub expected: Energy,
    /// As it was.
    pub executed: Energy,
    /// As it was, by the measured table.
    pub by_table: Energy,
    /// Executed over planned total energy; null for a plan of none.
    pub ratio: Option<f64>,
    /// Times a robot lost its memory under way.
    pub reboots: u64,
    /// Each robot's link, in the order of the problem, by its id.
    pub link: Vec<LinkFigures>,
    /// Datagrams that no robot can be charged with: damaged ones, other fleets', strangers'.
    pub strays: Incoming,
    /// What the simulated medium did, all radios together.
    pub faults: Option<FaultCount>,
    /// What came of a motion capture; not there where there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses: Option<PoseFigures>,
    /// Time the run took, s.
    pub wall_s: f64,
}

impl Summary {
    /// What is to be said of it, a line each.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        complaints(self.failure.as_deref(), &self.shortfalls)
    }

    /// Least gap between the mover's hull and another one in any move, m; negative is an overlap of boxes.
    #[must_use]
    pub fn least_gap_m(&self) -> Option<f64> {
        self.moves.iter().filter_map(|figures| figures.least_gap_m).reduce(f64::min)
    }
}
