//! A structure of Modboats: where it is, where it is to go, what its tails give.

use runlog::flotilla::{BoatState, Bodies, Fix, Goal, Poses, Status, Wrench};
use runlog::message::Message as _;
use serde_json::{Map, Value, json};

/// See the module's documentation. The newest message of each topic.
#[derive(Default)]
pub struct Boats {
    truth: Option<BoatState>,
    estimate: Option<BoatState>,
    fix: Option<Fix>,
    poses: Option<Poses>,
    bodies: Option<Bodies>,
    /// What the fleet is steered by.
    pub goal: Option<Goal>,
}

/// East, north and heading.
pub type Point = [f64; 3];

impl Boats {
    /// Takes in a message; where the structure is, if that is new.
    pub fn take(&mut self, topic: &str, data: &[u8]) -> Option<Point> {
        let point =
            |position_m: [f64; 2], heading_rad: f64| Some([position_m[0], position_m[1], heading_rad]);
        match topic {
            "/truth/state" => {
                self.truth = BoatState::read(data).ok();
                let state = self.truth.as_ref()?;
                return point(state.position_m, state.heading_rad);
            }
            "/estimate/state" => {
                self.estimate = BoatState::read(data).ok();
                let state = self.estimate.as_ref().filter(|_| self.truth.is_none())?;
                return point(state.position_m, state.heading_rad);
            }
            "/fix" => {
                self.fix = Fix::read(data).ok();
                let fix = self.fix.as_ref().filter(|_| self.truth.is_none() && self.estimate.is_none())?;
                return point(fix.position_m, fix.heading_rad);
            }
            "/poses" => self.poses = Poses::read(data).ok(),
            "/bodies" => self.bodies = Bodies::read(data).ok(),
            "/goal" => self.goal = Goal::read(data).ok(),
            _ => {}
        }
        None
    }

    /// Puts it into `object`; nulls unless it `is` of boats.
    pub fn show(&self, is: bool, status: Option<&Status>, now_ns: u64, object: &mut Map<String, Value>) {
        let mut put =
            |key: &str, value: Value| object.insert(key.to_owned(), if is { value } else { Value::Null });
        put("truth", self.truth.as_ref().map_or(Value::Null, state));
        // Before the first cycle there is no estimate in a log.
        let fixed = self.fix.as_ref().map(|fix| BoatState {
            position_m: fix.position_m,
            heading_rad: fix.heading_rad,
            ..BoatState::default()
        });
        put("estimate", self.estimate.as_ref().or(fixed.as_ref()).map_or(Value::Null, state));
        put(
            "fix",
            self.fix.as_ref().map_or(Value::Null, |fix| {
                json!({
                    "age_s": now_ns as f64 * 1e-9 - fix.captured_s,
                    "position_m": fix.position_m,
                    "heading_rad": fix.heading_rad,
                })
            }),
        );
        put(
            "current",
            status.map_or(Value::Null, |status| {
                match (status.unknown_m_s2.as_slice(), status.unknown_rad_s2.first()) {
                    ([x, y], Some(turn)) => json!({ "force_m_s2": [x, y], "turn_rad_s2": turn }),
                    _ => Value::Null,
                }
            }),
        );
        put("poses", self.shown_poses(status));
        put("target", self.goal.as_ref().map_or(Value::Null, target));
    }

    fn shown_poses(&self, status: Option<&Status>) -> Value {
        let poses = self.poses.as_ref();
        let bodies = self.bodies.as_ref().map_or(&[][..], |bodies| &bodies.bodies);
        let trouble = status.map(|status| &status.poses).filter(|trouble| !trouble.is_empty());
        let body = |body: &runlog::flotilla::Body| {
            json!({
                "name": body.name,
                "module": Some(body.module).filter(|module| *module != 0),
                "position_m": body.position_m,
                "heading_rad": body.heading_rad,
                "used": body.used,
            })
        };
        json!({
            "source": poses.map(|poses| &poses.source),
            "trouble": trouble,
            "late_p50_s": poses.map(|poses| poses.late_p50_s),
            "frames": poses.map(|poses| poses.frames),
            "frames_accepted": poses.map(|poses| poses.frames_accepted),
            "bodies": bodies.iter().map(body).collect::<Vec<Value>>(),
        })
    }
}

fn state(state: &BoatState) -> Value {
    json!({
        "position_m": state.position_m,
        "heading_rad": state.heading_rad,
        "velocity_m_s": state.velocity_m_s,
        "yaw_rate_rad_s": state.yaw_rate_rad_s,
    })
}

fn target(goal: &Goal) -> Value {
    let pair = |values: &[f64]| match values {
        [x, y] => json!([x, y]),
        _ => Value::Null,
    };
    let waypoints = goal.waypoints_x_m.iter().zip(&goal.waypoints_y_m);
    json!({
        "kind": goal.kind,
        "from": goal.source,
        "velocity_m_s": pair(&goal.velocity_m_s),
        "station_m": pair(&goal.station_m),
        "heading_rad": goal.heading_rad,
        "waypoints_m": waypoints.map(|(x, y)| [*x, *y]).collect::<Vec<[f64; 2]>>(),
    })
}

/// Sway, surge, yaw.
pub(super) fn components(wrench: &Wrench) -> [f64; 3] {
    [wrench.fx_n, wrench.fy_n, wrench.tau_nm]
}
