//! What a page shows: made of the log's messages, the same of a live run and of a file.
//!
//! | part | made of |
//! |---|---|
//! | scene | `/scenario`, once |
//! | snapshot | the newest message of each topic |
//! | trail, events, decisions | all of them, up to a limit: [`history`] |
//!
//! Keys and units: `host/console/docs/protocol.md`.

use runlog::flotilla;
use runlog::message::Message as _;
use serde_json::{Value, json};

pub mod boats;
pub mod history;
pub mod modules;
pub mod rovs;

use boats::Boats;
use history::History;
use modules::Modules;
use rovs::Rovs;

/// What the scene of a run is: from the first message of its log to an object with the keys `duration_s`, `interactive`, `boats` and
/// `rovs`. The program that made the log knows how to read what was asked.
pub type Stage = dyn Fn(&flotilla::Scenario) -> Result<Value, String> + Send;

/// What a server can do besides showing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Can {
    /// It takes orders.
    pub order: bool,
    /// It takes targets.
    pub steer: bool,
    /// It plays a log.
    pub play: bool,
}

/// See the module's documentation.
#[derive(Default)]
pub struct View {
    head: Option<flotilla::Scenario>,
    scene: Option<Value>,
    now_ns: u64,
    end: Option<flotilla::End>,
    status: Option<flotilla::Status>,
    modules: Modules,
    boats: Boats,
    rovs: Rovs,
    history: History,
}

/// Reads a message and hands it to `$take`. One that cannot be read is left out: a page shows what it can.
macro_rules! read {
    ($data:expr, $type:ty, $take:expr) => {
        if let Ok(message) = <$type>::read($data) {
            $take(message);
        }
    };
}

impl View {
    /// Takes in a message of `topic` at `at_ns`.
    pub fn take(&mut self, topic: &str, at_ns: u64, data: &[u8], stage: &Stage) {
        self.now_ns = self.now_ns.max(at_ns);
        match topic {
            "/scenario" => read!(data, flotilla::Scenario, |head: flotilla::Scenario| {
                self.scene = stage(&head).ok();
                self.modules.ids.clone_from(&head.modules);
                self.head = Some(head);
            }),
            "/begin" => read!(data, flotilla::Begin, |begin: flotilla::Begin| {
                self.history.begin(begin.origin_us.saturating_mul(1000));
            }),
            "/end" => read!(data, flotilla::End, |end| self.end = Some(end)),
            "/status" => read!(data, flotilla::Status, |status| self.status = Some(status)),
            "/links" => read!(data, flotilla::Links, |links| self.modules.links(&links)),
            "/robots" => read!(data, flotilla::Robots, |robots: flotilla::Robots| {
                self.history.robots(at_ns, &robots);
                self.rovs.robots = Some(robots);
            }),
            "/moves" => read!(data, flotilla::Moves, |moves| self.rovs.moves = Some(moves)),
            "/tails" => read!(data, runlog::ros::JointState, |tails: runlog::ros::JointState| {
                self.modules.tails = tails.position;
            }),
            _ => {
                self.history.take(topic, at_ns, data);
                if let Some(point) = self.boats.take(topic, data) {
                    self.history.boat(at_ns, point);
                }
            }
        }
    }

    /// Whether a message of `topic` says more than how things stand at its time. Others may be left out on the way to another place in a
    /// log, up to shortly before it.
    #[must_use]
    pub fn is_lasting(topic: &str) -> bool {
        !matches!(
            topic,
            "/tails"
                | "/tf"
                | "/tf_static"
                | "/odom"
                | "/truth/odom"
                | "/markers"
                | "/diagnostics"
                | "/fix"
                | "/bodies"
                | "/acknowledgement"
                | "/target"
        ) && !topic.ends_with("/battery")
    }

    /// The scene, with what this server `can` do.
    #[must_use]
    pub fn scene(&self, can: Can) -> Value {
        let (head, scene) = (self.head.as_ref(), self.scene.as_ref());
        let of = |key: &str| scene.and_then(|scene| scene.get(key)).cloned().unwrap_or(Value::Null);
        json!({
            "kind": "scene",
            "source": if can.play { "log" } else { "run" },
            "program": head.map(|head| &head.program),
            "name": head.map(|head| &head.name),
            "fleet": head.map(|head| &head.fleet),
            "seed": head.map(|head| head.seed),
            "began_unix_s": head.map(|head| head.began_unix_s),
            "duration_s": of("duration_s"),
            "interactive": of("interactive"),
            "modules": self.modules.ids,
            "boats": of("boats"),
            "rovs": of("rovs"),
            "can": { "order": can.order, "steer": can.steer, "play": can.play },
        })
    }

    /// Whether it is known what is run.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.head.is_some()
    }

    /// How things stand, for the snapshot `number`.
    #[must_use]
    pub fn snapshot(&self, number: u64) -> Value {
        let status = self.status.as_ref();
        let word = |text: Option<&String>| text.filter(|text| !text.is_empty()).cloned();
        let mut snapshot = json!({
            "kind": "snapshot",
            "n": number,
            "t_s": self.history.t_s(self.now_ns),
            "fleet_s": self.now_ns as f64 * 1e-9,
            "status": status.map(|status| &status.fleet),
            "order": word(status.map(|status| &status.order)),
            "deadman": word(status.map(|status| &status.deadman)),
            "ended": self.end.as_ref().map(|end| end.why.clone().unwrap_or_default()),
            "modules": self.modules.show(status),
            "wrench": self.history.wrench(),
        });
        if let Value::Object(object) = &mut snapshot {
            let is_rovs = self.head.as_ref().is_some_and(|head| head.fleet == "rovs");
            self.rovs.show(is_rovs, object);
            self.boats.show(!is_rovs, status, self.now_ns, object);
        }
        snapshot
    }

    /// What the fleet is steered by.
    #[must_use]
    pub fn goal(&self) -> Option<&flotilla::Goal> {
        self.boats.goal.as_ref()
    }

    /// Trail, events and decisions so far. What is new then was told.
    pub fn history(&mut self) -> Value {
        self.history.fresh();
        self.history.all()
    }

    /// Events and decisions since the last call.
    pub fn fresh(&mut self) -> Vec<Value> {
        self.history.fresh()
    }
}
