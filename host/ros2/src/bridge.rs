//! From a run to ROS 2, and back: one loop that blocks on nothing.
//!
//! | from ROS | to the run |
//! |---|---|
//! | `NAMESPACE/cmd_vel`, `geometry_msgs/Twist` | a velocity, for as long as it is asked for: [`crate::drive`] |
//! | `NAMESPACE/goal_pose`, `geometry_msgs/PoseStamped` in the world's frame | a station with a heading |
//! | `NAMESPACE/stop`, `hold`, `resume`, `release`, `std_srvs/Trigger` | the order of that name |
//!
//! What the run refuses is told on standard error and by `/rosout`, once until something else happens.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ros2_client::ros2::LogLevel;
use ros2_client::{Publisher, RmwRequestId, Server, ServiceMapping, Subscription, rosout};
use runlog::flotilla::{End, Fix, Scenario};
use runlog::message::Message as _;
use runlog::ros::Odometry;
use serde_json::{Value, json};
use thiserror::Error;

use crate::attach::{Address, Answered, AttachError, Came, Commands, Stream};
use crate::drive::{Asked, Drive, Wanted};
use crate::node::{NodeError, Ros};
use crate::shown::{Fleet, Place, Quality, WORLD};
use crate::wire::{PoseStamped, Quaternion, Ready, TriggerRequest, TriggerResponse, Twist};

/// Sockets and readers are looked at this often: a quarter of the shortest period of the log's messages.
const LOOK: Duration = Duration::from_millis(5);
/// A call that the run does not answer for this time has failed.
const PATIENCE: Duration = Duration::from_secs(5);
/// Orders that are services.
const SERVICES: [&str; 4] = ["stop", "hold", "resume", "release"];
/// Said where there is no token.
const NO_TOKEN: &str = "the bridge was started without the run's token, and only shows";

/// What is bridged, and how.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Of the run.
    pub address: Address,
    /// In front of topics: `/flotilla`, or nothing.
    pub namespace: String,
    /// What the world's frame is called in ROS.
    pub world: String,
    /// DDS domain.
    pub domain: u16,
    /// Whether everything is delivered reliably.
    pub reliable: bool,
    /// How services lie on DDS.
    pub mapping: ServiceMapping,
}

/// Why a bridge ended before its run.
#[derive(Debug, Error)]
pub enum BridgeError {
    /// The run.
    #[error(transparent)]
    Attach(#[from] AttachError),
    /// ROS.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// The token is that of another run.
    #[error("the run takes no commands from here: {0}")]
    Token(String),
}

/// What an answer of the run is for.
enum Purpose {
    Hello,
    /// A target, by what it came.
    Target(&'static str),
    /// A call, by number.
    Call(u64),
}

/// A call that waits for its answer.
struct Call {
    service: usize,
    request: RmwRequestId,
    since: Instant,
}

/// What comes from ROS.
struct Listening {
    velocities: Subscription<Twist>,
    goals: Subscription<PoseStamped>,
    services: Vec<Server<TriggerRequest, TriggerResponse>>,
}

struct Bridge {
    ros: Ros,
    fleet: Fleet,
    reliable: bool,
    stream: Stream,
    /// Without a token there are none.
    commands: Option<Commands<Purpose>>,
    listening: Listening,
    published: BTreeMap<u32, (Place, Publisher<Ready>)>,
    /// Topics of the log that say something to the bridge itself, by number.
    scenario: Option<u32>,
    odometry: Option<u32>,
    fix: Option<u32>,
    end: Option<u32>,
    /// Topics that wait until fleet time is known.
    waiting: Vec<(u32, String, String)>,
    heading_rad: Option<f64>,
    drive: Drive,
    calls: BTreeMap<u64, Call>,
    next_call: u64,
    complaint: String,
    dropped: u64,
    ended: bool,
}

/// Bridges until the run is over, or `stop` becomes true.
///
/// # Errors
/// [`BridgeError`].
pub fn run(settings: &Settings, stop: &AtomicBool) -> Result<(), BridgeError> {
    let mut bridge = Bridge::open(settings)?;
    let began = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        match bridge.look(began.elapsed().as_secs_f64()) {
            Ok(()) => std::thread::sleep(LOOK),
            Err(BridgeError::Attach(AttachError::Over)) => break,
            Err(BridgeError::Attach(AttachError::Lost(_))) if bridge.ended => break,
            Err(error) => return Err(error),
        }
    }
    if bridge.drive.is_on() && stop.load(Ordering::Relaxed) {
        bridge.give(json!({ "do": "let-go" }), Purpose::Target("cmd_vel"))?;
    }
    if bridge.dropped > 0 {
        eprintln!("flotilla-ros2: {} messages found no room, of readers that were too slow", bridge.dropped);
    }
    Ok(())
}

impl Bridge {
    fn open(settings: &Settings) -> Result<Self, BridgeError> {
        let Settings { address, namespace, world, domain, reliable, mapping } = settings;
        // The run first: without it there is nothing to show.
        let stream = Stream::open(address)?;
        let mut commands = None;
        if let Some(token) = &address.token {
            let mut opened = Commands::open(address)?;
            opened.give(json!({ "do": "hello", "token": token }), Purpose::Hello)?;
            commands = Some(opened);
        }
        let mut ros = Ros::open(*domain, namespace, "bridge")?;
        let own = |name: &str| format!("{namespace}/{name}");
        let services = SERVICES.map(|service| ros.trigger(&own(service), *mapping));
        let listening = Listening {
            services: services.into_iter().collect::<Result<_, _>>()?,
            velocities: ros.subscription(&own("cmd_vel"), ("geometry_msgs", "Twist"))?,
            goals: ros.subscription(&own("goal_pose"), ("geometry_msgs", "PoseStamped"))?,
        };
        let fleet = Fleet { namespace: namespace.clone(), world: world.clone(), began_ns: 0 };
        Ok(Self {
            ros,
            fleet,
            reliable: *reliable,
            stream,
            commands,
            listening,
            published: BTreeMap::new(),
            scenario: None,
            odometry: None,
            fix: None,
            end: None,
            waiting: Vec::new(),
            heading_rad: None,
            drive: Drive::default(),
            calls: BTreeMap::new(),
            next_call: 0,
            complaint: String::new(),
            dropped: 0,
            ended: false,
        })
    }

    /// Does what is due.
    fn look(&mut self, now_s: f64) -> Result<(), BridgeError> {
        while let Some(came) = self.stream.poll()? {
            match came {
                Came::Topic(id, topic, kind) => self.topic(id, topic, kind)?,
                Came::Message(id, cdr) => self.message(id, &cdr)?,
                Came::Warning(text) => self.complain(text),
            }
        }
        self.answers()?;
        self.services()?;
        self.goals()?;
        self.velocities(now_s)
    }

    /// A topic of the log: subscribed to, if it is of use.
    fn topic(&mut self, id: u32, topic: String, kind: String) -> Result<(), BridgeError> {
        match topic.as_str() {
            "/scenario" => {
                self.scenario = Some(id);
                return Ok(self.stream.subscribe(id)?);
            }
            "/end" => {
                self.end = Some(id);
                return Ok(self.stream.subscribe(id)?);
            }
            // There is no odometry before the first cycle, for which the heading has to be known.
            "/fix" if self.odometry.is_none() => {
                self.fix = Some(id);
                return Ok(self.stream.subscribe(id)?);
            }
            "/odom" => self.odometry = Some(id),
            _ => {}
        }
        match self.fleet.began_ns {
            0 => self.waiting.push((id, topic, kind)),
            _ => self.show(id, &topic, &kind)?,
        }
        Ok(())
    }

    fn show(&mut self, id: u32, topic: &str, kind: &str) -> Result<(), BridgeError> {
        let Some(place) = self.fleet.place(topic, kind) else { return Ok(()) };
        let quality = match place.quality {
            Quality::Sensor if self.reliable => Quality::Reliable,
            quality => quality,
        };
        let publisher = self.ros.publisher(&place.topic, place.kind, quality)?;
        self.published.insert(id, (place, publisher));
        Ok(self.stream.subscribe(id)?)
    }

    fn message(&mut self, id: u32, cdr: &[u8]) -> Result<(), BridgeError> {
        if self.scenario == Some(id) {
            if let Ok(scenario) = Scenario::read(cdr) {
                self.fleet.began_ns = nanos(scenario.began_unix_s);
                for (id, topic, kind) in std::mem::take(&mut self.waiting) {
                    self.show(id, &topic, &kind)?;
                }
            }
            return Ok(());
        }
        if self.end == Some(id) {
            self.ended |= End::read(cdr).is_ok();
            return Ok(());
        }
        if self.fix == Some(id) {
            self.heading_rad = Fix::read(cdr).ok().map(|fix| fix.heading_rad).or(self.heading_rad);
            return Ok(());
        }
        if self.odometry == Some(id)
            && let Ok(odometry) = Odometry::read(cdr)
        {
            let runlog::ros::Quaternion { x, y, z, w } = odometry.pose.pose.orientation;
            self.heading_rad = Quaternion { x, y, z, w }.yaw_rad().or(self.heading_rad);
            if let Some(fix) = self.fix.take() {
                self.stream.unsubscribe(fix)?;
            }
        }
        let Some((place, publisher)) = self.published.get(&id) else { return Ok(()) };
        match place.message(cdr, &self.fleet) {
            Ok(message) => self.dropped += u64::from(publisher.publish(message).is_err()),
            Err(error) => {
                let text = format!("a message for {}: {error}", place.topic);
                self.complain(text);
            }
        }
        Ok(())
    }

    fn answers(&mut self) -> Result<(), BridgeError> {
        while let Some(Answered { purpose, outcome }) =
            self.commands.as_mut().map_or(Ok(None), Commands::poll)?
        {
            match (purpose, outcome) {
                (Purpose::Hello, Err(why)) => return Err(BridgeError::Token(why)),
                (Purpose::Hello, Ok(_)) => {}
                (Purpose::Target(_), Ok(_)) => self.complaint.clear(),
                (Purpose::Target(by), Err(why)) => self.complain(format!("{by}: {why}")),
                (Purpose::Call(number), outcome) => self.respond(number, outcome),
            }
        }
        let late: Vec<u64> = self
            .calls
            .iter()
            .filter(|(_, call)| call.since.elapsed() > PATIENCE)
            .map(|(number, _)| *number)
            .collect();
        for number in late {
            self.respond(number, Err(format!("the run did not answer within {} s", PATIENCE.as_secs())));
        }
        Ok(())
    }

    fn respond(&mut self, number: u64, outcome: Result<String, String>) {
        let Some(Call { service, request, .. }) = self.calls.remove(&number) else { return };
        let success = outcome.is_ok();
        let (Ok(message) | Err(message)) = outcome;
        if let Some(server) = self.listening.services.get(service)
            && let Err(error) = server.send_response(request, TriggerResponse { success, message })
        {
            self.complain(format!("a response: {error}"));
        }
    }

    fn services(&mut self) -> Result<(), BridgeError> {
        for (service, order) in SERVICES.iter().enumerate() {
            while let Some(asked) =
                self.listening.services.get(service).and_then(|server| server.receive_request().transpose())
            {
                let request = match asked {
                    Ok((request, _)) => request,
                    Err(error) => {
                        self.complain(format!("a call of {order}: {error}"));
                        break;
                    }
                };
                let number = self.next_call;
                self.next_call += 1;
                self.calls.insert(number, Call { service, request, since: Instant::now() });
                if !self.give(json!({ "do": order }), Purpose::Call(number))? {
                    self.respond(number, Err(NO_TOKEN.to_owned()));
                }
            }
        }
        Ok(())
    }

    fn goals(&mut self) -> Result<(), BridgeError> {
        while let Some(goal) = self.listening.goals.take().transpose() {
            let (header, pose) = match goal {
                Ok((PoseStamped { header, pose }, _)) => (header, pose),
                Err(error) => {
                    self.complain(format!("goal_pose: {error}"));
                    break;
                }
            };
            if header.frame_id != self.fleet.frame(WORLD) {
                let (given, world) = (header.frame_id, self.fleet.frame(WORLD));
                self.complain(format!("goal_pose: is in the frame \"{given}\", and must be in \"{world}\""));
                continue;
            }
            self.drive.forget();
            let station = json!({
                "do": "station",
                "position_m": [pose.position.x, pose.position.y],
                "heading_rad": pose.orientation.yaw_rad(),
            });
            self.target(station, "goal_pose")?;
        }
        Ok(())
    }

    fn velocities(&mut self, now_s: f64) -> Result<(), BridgeError> {
        while let Some(twist) = self.listening.velocities.take().transpose() {
            match (twist, self.heading_rad) {
                (Ok((Twist { linear, angular }, _)), Some(heading_rad)) => {
                    let wanted = Wanted { forward_m_s: linear.x, left_m_s: linear.y, turn_rad_s: angular.z };
                    self.drive.take(now_s, wanted, heading_rad);
                }
                (Ok(_), None) => self.complain("cmd_vel: the run does not know its heading yet"),
                (Err(error), _) => {
                    self.complain(format!("cmd_vel: {error}"));
                    break;
                }
            }
        }
        let heading_rad = self.heading_rad.unwrap_or_default();
        match self.drive.due(now_s, heading_rad) {
            Some(Asked::Velocity(velocity_m_s, heading_rad)) => {
                let velocity =
                    json!({ "do": "velocity", "velocity_m_s": velocity_m_s, "heading_rad": heading_rad });
                self.target(velocity, "cmd_vel")
            }
            Some(Asked::LetGo) => self.target(json!({ "do": "let-go" }), "cmd_vel"),
            None => Ok(()),
        }
    }

    fn target(&mut self, command: Value, by: &'static str) -> Result<(), BridgeError> {
        if !self.give(command, Purpose::Target(by))? {
            self.complain(format!("{by}: {NO_TOKEN}"));
        }
        Ok(())
    }

    /// Gives a command to the run; false where there is no token.
    fn give(&mut self, command: Value, purpose: Purpose) -> Result<bool, BridgeError> {
        let Some(commands) = &mut self.commands else { return Ok(false) };
        commands.give(command, purpose)?;
        Ok(true)
    }

    fn complain(&mut self, text: impl Display) {
        let text = text.to_string();
        if text != self.complaint {
            eprintln!("flotilla-ros2: {text}");
            rosout!(self.ros.node, LogLevel::Warn, "{text}");
            self.complaint = text;
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates; whole ns of a time since 1970"
)]
fn nanos(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}
