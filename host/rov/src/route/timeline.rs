//! Actions of one robot, one after the other.

use quantity::wrap_rad;
use reconfiguration::plan::{Action, ActionKind};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Rules;

use super::super::propulsion::Expense;
use super::{Route, SAME_RAD};

/// Where a robot is and what it has done.
pub(super) struct Timeline {
    /// Where it is now.
    pub at: Pose,
    dock_s: f64,
    path: Vec<[f64; 3]>,
    actions: Vec<Action>,
    now_s: f64,
    energy_j: f64,
}

impl Timeline {
    /// Undocks at `start`.
    pub fn new(start: Pose, rules: &Rules) -> Self {
        let mut timeline = Self {
            at: start,
            dock_s: rules.dock_s,
            path: vec![start.position_m],
            actions: Vec::new(),
            now_s: 0.0,
            energy_j: 0.0,
        };
        timeline.pause(ActionKind::Undock, rules.undock_s);
        timeline
    }

    fn pause(&mut self, kind: ActionKind, duration_s: f64) {
        self.push(kind, self.at, Expense { duration_s, ..Expense::default() });
    }

    /// Turns in place, unless there is nothing to turn by.
    pub fn turn(&mut self, angle_rad: f64, expense: Expense) {
        if angle_rad.abs() >= SAME_RAD {
            let to = Pose { yaw_rad: wrap_rad(self.at.yaw_rad + angle_rad), ..self.at };
            self.push(ActionKind::Turn, to, expense);
        }
    }

    /// Swims straight on.
    pub fn leg(&mut self, to_m: [f64; 3], expense: Expense) {
        self.path.push(to_m);
        let to = Pose { position_m: to_m, ..self.at };
        self.push(ActionKind::Leg, to, expense);
    }

    fn push(&mut self, kind: ActionKind, to: Pose, expense: Expense) {
        let Expense { duration_s, energy_j, speed, acceleration } = expense;
        let (from, start_s) = (self.at, self.now_s);
        self.actions.push(Action { kind, start_s, duration_s, from, to, speed, acceleration, energy_j });
        self.at = to;
        self.now_s += duration_s;
        self.energy_j += energy_j;
    }

    /// Docks.
    pub fn finish(mut self) -> Route {
        self.pause(ActionKind::Dock, self.dock_s);
        let Self { path, actions, now_s, energy_j, .. } = self;
        Route { path, actions, duration_s: now_s, energy_j }
    }
}
