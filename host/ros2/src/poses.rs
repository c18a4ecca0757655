//! Poses of any driver, served to a run: topics of ROS 2 in, VRPN out.
//!
//! | message | bodies | frame |
//! |---|---|---|
//! | `geometry_msgs/PoseStamped` | one | `header.frame_id` |
//! | `nav_msgs/Odometry` | one; its twist is not used | `header.frame_id` |
//! | `tf2_msgs/TFMessage` | each child of the frame that is named | must be named |
//!
//! The type of a topic is that of its publisher, waited for as long as it takes. A stamp goes out as it came, so that the run learns how late
//! poses are; a message without one, and that is said, gets the time of its arrival.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::{Read as _, Write as _};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use pose::frame::{Body, Frame, Label};
use pose::ros2::{ANNOUNCEMENT, Topic, Topics, body_of};
use pose::server::{ServeError, Server as _};
use pose::time::{HostInstant, ServerInstant};
use pose::vrpn::server::VrpnServer;
use ros2_client::{ReadError, Subscription};
use thiserror::Error;

use crate::node::{NodeError, Ros};
use crate::wire::{Header, Pose, PoseStamped, Transform, Transforms};

/// Sockets and readers are looked at this often.
const LOOK: Duration = Duration::from_millis(1);
/// Publishers are looked for this often.
const DISCOVER: Duration = Duration::from_millis(100);
/// A topic without a publisher is told after this time.
const PATIENCE: Duration = Duration::from_secs(3);

/// What is relayed, and where to.
#[derive(Clone, Debug)]
pub struct Settings {
    /// From where.
    pub topics: Topics,
    /// Where VRPN is served.
    pub listen: SocketAddr,
    /// DDS domain.
    pub domain: u16,
    /// Whether to end when standard input does.
    pub attached: bool,
}

/// Why poses do not come, or no more.
#[derive(Debug, Error)]
pub enum PosesError {
    /// ROS.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// The port.
    #[error(transparent)]
    Serve(#[from] ServeError),
    /// A type that has no pose.
    #[error(
        "{topic} is of {package}/{kind}; poses come by geometry_msgs/PoseStamped, nav_msgs/Odometry and tf2_msgs/TFMessage"
    )]
    Kind {
        /// The topic.
        topic: String,
        /// Its type's package.
        package: String,
        /// And name.
        kind: String,
    },
    /// Transforms of which frame?
    #[error("{0} is of tf2_msgs/TFMessage: say the frame that bodies are children of, as in ros2:{0}@map")]
    Frame(String),
}

/// A topic that is listened to.
enum Reader {
    Poses(Subscription<PoseStamped>),
    Odometry(Subscription<Transform>),
    Transforms(Subscription<Transforms>),
}

struct Relay {
    ros: Ros,
    server: VrpnServer,
    /// The frame of the poses, once it is known.
    frame: Option<String>,
    readers: Vec<(Topic, Option<Reader>)>,
    said: BTreeSet<String>,
}

/// Relays until `stop` becomes true.
///
/// # Errors
/// [`PosesError`].
pub fn run(settings: &Settings, stop: &'static AtomicBool) -> Result<(), PosesError> {
    let Settings { topics, listen, domain, attached } = settings;
    let named = |topic: &Topic| Label::named(&topic.body());
    let server = VrpnServer::new(*listen, &[])?;
    let ros = Ros::open(*domain, "", "flotilla_poses")?;
    let readers = topics.topics.iter().map(|topic| (topic.clone(), None)).collect();
    let mut relay = Relay { ros, server, frame: topics.frame.clone(), readers, said: BTreeSet::new() };
    let _ = writeln!(std::io::stdout(), "{ANNOUNCEMENT}{}", relay.server.address());
    if *attached {
        end_with_input(stop);
    }
    let began = Instant::now();
    let mut discovered: Option<Instant> = None;
    while !stop.load(Ordering::Relaxed) {
        let now = HostInstant(began.elapsed());
        if discovered.is_none_or(|last| last.elapsed() >= DISCOVER) {
            discovered = Some(Instant::now());
            relay.discover(now, named)?;
            if began.elapsed() > PATIENCE {
                relay.tell_silent();
            }
        }
        relay.server.poll(now);
        relay.pass(now);
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// What started this is gone when its end of the pipe is.
fn end_with_input(stop: &'static AtomicBool) {
    std::thread::spawn(|| {
        let mut buffer = [0; 64];
        while std::io::stdin().read(&mut buffer).is_ok_and(|length| length > 0) {}
        stop.store(true, Ordering::Relaxed);
    });
}

impl Relay {
    /// Listens to topics whose type is known now.
    fn discover(&mut self, now: HostInstant, label: impl Fn(&Topic) -> Label) -> Result<(), PosesError> {
        let Self { ros, server, frame, readers, .. } = self;
        for (topic, reader) in readers.iter_mut().filter(|(_, reader)| reader.is_none()) {
            let Some((package, kind)) = ros.kind_of(&topic.name) else { continue };
            let (name, full) = (topic.name.as_str(), (package.as_str(), kind.as_str()));
            *reader = Some(match full {
                ("geometry_msgs", "PoseStamped") => Reader::Poses(ros.subscription(name, full)?),
                ("nav_msgs", "Odometry") => Reader::Odometry(ros.subscription(name, full)?),
                ("tf2_msgs", "TFMessage") if frame.is_none() => {
                    return Err(PosesError::Frame(topic.name.clone()));
                }
                ("tf2_msgs", "TFMessage") => Reader::Transforms(ros.subscription(name, full)?),
                _ => return Err(PosesError::Kind { topic: topic.name.clone(), package, kind }),
            });
            if !matches!(reader, Some(Reader::Transforms(_))) {
                server.add(now, &label(topic));
            }
        }
        Ok(())
    }

    fn tell_silent(&mut self) {
        let silent: Vec<String> = self
            .readers
            .iter()
            .filter(|(_, reader)| reader.is_none())
            .map(|(topic, _)| topic.name.clone())
            .collect();
        for name in silent {
            self.say(format!("{name} has no publisher yet"));
        }
    }

    /// Passes on what has come.
    fn pass(&mut self, now: HostInstant) {
        let mut came = Vec::new();
        let mut failed = Vec::new();
        for (topic, reader) in &self.readers {
            let outcome = match reader {
                None => Ok(()),
                Some(Reader::Poses(reader)) => all(reader, |PoseStamped { header, pose }| {
                    came.push((topic.body(), false, header, pose));
                }),
                Some(Reader::Odometry(reader)) => all(reader, |Transform { header, transform, .. }| {
                    came.push((topic.body(), false, header, transform));
                }),
                Some(Reader::Transforms(reader)) => all(reader, |Transforms { transforms }| {
                    came.extend(transforms.into_iter().map(
                        |Transform { header, child_frame_id, transform }| {
                            (body_of(&child_frame_id), true, header, transform)
                        },
                    ));
                }),
            };
            failed.extend(outcome.err().map(|error| format!("{}: {error}", topic.name)));
        }
        failed.into_iter().for_each(|text| self.say(text));
        for (body, one_of_many, header, pose) in came {
            self.send(now, &body, one_of_many, header, &pose);
        }
    }

    fn send(&mut self, now: HostInstant, body: &str, one_of_many: bool, header: Header, pose: &Pose) {
        let Header { stamp, frame_id } = header;
        let frame = self.frame.get_or_insert_with(|| frame_id.clone());
        if *frame != frame_id {
            // Transforms between other frames are others' business.
            if !one_of_many {
                let text =
                    format!("{body} is in the frame \"{frame_id}\", the poses are in \"{frame}\": not used");
                self.say(text);
            }
            return;
        }
        let label = Label::named(body);
        self.server.add(now, &label);
        let captured = match stamp.nanos() {
            0 => {
                self.say(format!("{body} comes without a stamp: it gets the time of its arrival"));
                arrival()
            }
            nanos => ServerInstant(nanos),
        };
        let (p, q) = (pose.position, pose.orientation);
        let body = Body {
            label,
            position: nalgebra::Vector3::new(p.x, p.y, p.z),
            attitude: nalgebra::Quaternion::new(q.w, q.x, q.y, q.z),
            tracked: true,
            error: None,
        };
        self.server.send(now, &Frame { number: None, captured, bodies: vec![body] });
    }

    fn say(&mut self, text: impl Display) {
        let text = text.to_string();
        if self.said.insert(text.clone()) {
            eprintln!("flotilla-ros2: {text}");
        }
    }
}

/// All that a reader has.
fn all<M: serde::de::DeserializeOwned + 'static>(
    reader: &Subscription<M>,
    mut take: impl FnMut(M),
) -> Result<(), ReadError> {
    while let Some((message, _)) = reader.take()? {
        take(message);
    }
    Ok(())
}

/// Now, by the clock that stamps are taken from.
fn arrival() -> ServerInstant {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    ServerInstant(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
