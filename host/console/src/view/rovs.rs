//! ROVs: where they are, what their thrusters do, how far the plan is.

use runlog::flotilla::{Moves, PARKED, Robot, Robots};
use serde_json::{Map, Value, json};

/// See the module's documentation.
#[derive(Default)]
pub struct Rovs {
    /// The newest set of robots.
    pub robots: Option<Robots>,
    /// Moves so far.
    pub moves: Option<Moves>,
}

impl Rovs {
    /// Puts it into `object`; nulls unless it `is` of ROVs.
    pub fn show(&self, is: bool, object: &mut Map<String, Value>) {
        let robots = self.robots.as_ref().filter(|_| is);
        let mover = self.mover();
        let all = robots.map(|all| all.robots.iter().map(|one| robot(one, mover)).collect::<Vec<Value>>());
        object.insert("robots".to_owned(), json!(all));
        object.insert("moves".to_owned(), if is { self.shown_moves() } else { Value::Null });
    }

    /// The robot that moves.
    fn mover(&self) -> Option<u16> {
        let moving = usize::try_from(self.robots.as_ref()?.moving).ok()?;
        self.moves.as_ref()?.moves.get(moving).map(|under_way| under_way.robot)
    }

    fn shown_moves(&self) -> Value {
        let moves = self.moves.as_ref().map_or(&[][..], |moves| &moves.moves);
        let done = moves.iter().map(|one| {
            json!({
                "robot": one.robot,
                "slot": (one.slot != PARKED).then_some(one.slot),
                "planned_j": one.planned.total_j,
                "expected_j": one.expected.total_j,
                "executed_j": one.executed.total_j,
                "time_s": one.executed.time_s,
                "cross_track_m": one.cross_track_m,
                "end_m": one.end_m,
                "end_rad": one.end_rad,
            })
        });
        let sum = |of: fn(&runlog::flotilla::Move) -> f64| moves.iter().map(of).sum::<f64>() + 0.0;
        json!({
            "moving": self.robots.as_ref().map_or(-1, |robots| robots.moving),
            "done": done.collect::<Vec<Value>>(),
            "planned_j": sum(|one| one.planned.total_j),
            "executed_j": sum(|one| one.executed.total_j),
        })
    }
}

fn robot(robot: &Robot, mover: Option<u16>) -> Value {
    let [x, y, z, roll, pitch, yaw] = robot.eta;
    let [u, v, w, p, q, r] = robot.nu;
    json!({
        "id": robot.id,
        "position_m": [x, y, z],
        "attitude_rad": [roll, pitch, yaw],
        "velocity_m_s": [u, v, w],
        "rates_rad_s": [p, q, r],
        "thrusts_n": robot.thrusts_n,
        "pulses_us": robot.pulses_us,
        "power_w": robot.power_w,
        "reference": robot.reference.as_ref().map(|place| [place.x_m, place.y_m, place.z_m, place.yaw_rad]),
        "arrived": robot.arrived,
        "moving": robot.reference.is_some() || mover == Some(robot.id),
    })
}
