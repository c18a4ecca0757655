//! Poses from topics of ROS 2, by way of a program of its own.
//!
//! ```text
//! a driver's topic ── DDS ──▶ flotilla-ros2 poses ── VRPN over loopback ──▶ this program
//! ```
//!
//! DDS stays in that program, with its threads, its discovery and its dependencies. It is started here and says on its standard output where
//! its VRPN server listens: `vrpn 127.0.0.1:41234`. It ends when its standard input does, so that it never outlives this program.
//!
//! | part of `ros2:[BODY=]/TOPIC[,…][@FRAME]` | what |
//! |---|---|
//! | `/TOPIC` | of `geometry_msgs/PoseStamped`, `nav_msgs/Odometry` or `tf2_msgs/TFMessage`; one body a topic, except for the last |
//! | `BODY` | how the body is called in the roster; without it [`body_of`] |
//! | `FRAME` | the frame of the poses; without it that of the first message. Transforms need it |

use std::ffi::OsStr;
use std::fmt;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::str::FromStr;

use thiserror::Error;

use crate::frame::{Arrival, Label};
use crate::source::{Source, SourceError, Status};
use crate::time::HostInstant;
use crate::vrpn::client::VrpnClient;

/// The program that knows DDS.
pub const PROGRAM: &str = "flotilla-ros2";
/// Where it is, for those who keep it elsewhere than beside this program or in `PATH`.
pub const VARIABLE: &str = "FLOTILLA_ROS2";
/// What it says before the address of its server.
pub const ANNOUNCEMENT: &str = "vrpn ";
/// What says nothing of a body at the end of a topic's name.
const KINDS: [&str; 4] = ["pose", "pose_stamped", "odom", "odometry"];

/// A topic, and the body that it is of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// How its body is called, where that was said.
    pub body: Option<String>,
    /// Its name, which begins with `/`.
    pub name: String,
}

/// Topics with poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topics {
    /// At least one.
    pub topics: Vec<Topic>,
    /// The frame of the poses, where that was said.
    pub frame: Option<String>,
}

/// Why text names no topics.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum TopicError {
    /// There is none.
    #[error("the topic is missing, as in ros2:/boat/pose")]
    Missing,
    /// A name that ROS does not have.
    #[error(
        "\"{0}\" is no topic: names in full, of letters, digits and \"_\", as in ros2:/boat/pose or ros2:blue=/boat/pose@map"
    )]
    Name(String),
    /// Nothing stands behind `@`, or before `=`.
    #[error("\"{0}\": a name is missing, as in ros2:blue=/boat/pose@map")]
    Empty(String),
}

/// Why the program does not run.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum StartError {
    /// It is not there.
    #[error(
        "the program {PROGRAM} is neither beside this program nor in PATH: build it by cargo build --release -p {PROGRAM}, or set \
         {VARIABLE} to where it is"
    )]
    Absent,
    /// It is there and does not start.
    #[error("{program}: {reason}")]
    Start {
        /// Which.
        program: String,
        /// What the operating system said.
        reason: String,
    },
    /// It has ended, or said something else than where it listens; it says why itself.
    #[error("{program} gave no poses to listen to; it said {said:?}")]
    Silent {
        /// Which.
        program: String,
        /// Its first line.
        said: String,
    },
}

/// How a body is called by the name of its topic, or of its frame: the last part of the name that does not only say what kind of message it is.
/// Names in ROS have no hyphen, so `module_3` is `module-3`, which is what a roster takes for granted.
#[must_use]
pub fn body_of(name: &str) -> String {
    let mut parts = name.split('/').filter(|part| !part.is_empty()).rev();
    let last = parts.next().unwrap_or_default();
    let body = if KINDS.contains(&last) { parts.next().unwrap_or(last) } else { last };
    match body.strip_prefix("module_") {
        Some(number) if number.bytes().all(|byte| byte.is_ascii_digit()) => format!("module-{number}"),
        _ => body.to_owned(),
    }
}

impl Topic {
    /// How its body is called.
    #[must_use]
    pub fn body(&self) -> String {
        self.body.clone().unwrap_or_else(|| body_of(&self.name))
    }
}

impl FromStr for Topics {
    type Err = TopicError;

    fn from_str(given: &str) -> Result<Self, TopicError> {
        let empty = || TopicError::Empty(given.to_owned());
        let (topics, frame) = match given.rsplit_once('@') {
            Some((_, "")) => return Err(empty()),
            Some((topics, frame)) => (topics, Some(frame.to_owned())),
            None => (given, None),
        };
        if topics.is_empty() {
            return Err(TopicError::Missing);
        }
        let topics = topics.split(',').map(|topic| {
            let (body, name) = match topic.split_once('=') {
                Some(("", _)) => return Err(empty()),
                Some((body, name)) => (Some(body.to_owned()), name),
                None => (None, topic),
            };
            if !is_name(name) {
                return Err(TopicError::Name(name.to_owned()));
            }
            Ok(Topic { body, name: name.to_owned() })
        });
        Ok(Self { topics: topics.collect::<Result<_, _>>()?, frame })
    }
}

/// Whether ROS has such names in full: <https://design.ros2.org/articles/topic_and_service_names.html>.
fn is_name(name: &str) -> bool {
    let is_part = |part: &str| {
        part.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
            && !part.is_empty()
            && !part.starts_with(|first: char| first.is_ascii_digit())
            && !part.contains("__")
    };
    name.strip_prefix('/').is_some_and(|rest| rest.split('/').all(is_part))
}

impl fmt::Display for Topics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (topic, separator) in self.topics.iter().zip(std::iter::once("").chain(std::iter::repeat(","))) {
            write!(f, "{separator}")?;
            if let Some(body) = &topic.body {
                write!(f, "{body}=")?;
            }
            write!(f, "{}", topic.name)?;
        }
        self.frame.iter().try_for_each(|frame| write!(f, "@{frame}"))
    }
}

/// The program, and what it sends.
#[derive(Debug)]
pub struct Relay {
    child: Child,
    client: VrpnClient,
}

impl Relay {
    /// Starts the program, which takes a moment.
    ///
    /// # Errors
    /// A program that is not there, or that ends at once.
    pub fn start(topics: &Topics) -> Result<Self, StartError> {
        let program = program().ok_or(StartError::Absent)?;
        let name = program.display().to_string();
        let mut command = Command::new(&program);
        command.args([OsStr::new("poses"), OsStr::new(&topics.to_string())]);
        command.args(["--listen", "127.0.0.1:0", "--attached"]);
        // What it has to say to a person goes where this program's own words go.
        let started = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let mut child = started
            .map_err(|error| StartError::Start { program: name.clone(), reason: error.to_string() })?;
        let mut said = String::new();
        if let Some(out) = child.stdout.take() {
            // It keeps its end of the pipe, and says nothing more.
            let _ = BufReader::new(out).read_line(&mut said);
        }
        let server: Option<SocketAddr> =
            said.strip_prefix(ANNOUNCEMENT).and_then(|address| address.trim().parse().ok());
        let Some(server) = server else {
            end(&mut child);
            return Err(StartError::Silent { program: name, said: said.trim().to_owned() });
        };
        Ok(Self { child, client: VrpnClient::new(server, &[]) })
    }
}

/// Where the program is: as the variable says, beside this one, or in `PATH`.
fn program() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(VARIABLE) {
        return Some(named.into());
    }
    let beside = std::env::current_exe().ok().and_then(|this| this.parent().map(Path::to_path_buf));
    let path = std::env::var_os("PATH").unwrap_or_default();
    beside
        .into_iter()
        .chain(std::env::split_paths(&path))
        .map(|folder| folder.join(PROGRAM))
        .find(|p| p.is_file())
}

fn end(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}

impl Source for Relay {
    fn poll(&mut self, now: HostInstant) -> Result<Option<Arrival>, SourceError> {
        if let Ok(Some(status)) = self.child.try_wait() {
            return Err(SourceError::Ended { program: PROGRAM, status: status.to_string() });
        }
        self.client.poll(now)
    }

    fn status(&self) -> &Status {
        self.client.status()
    }

    fn bodies(&self) -> &[Label] {
        self.client.bodies()
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        end(&mut self.child);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        for given in ["/pose", "blue=/a/pose,/b/odom", "/tf@map", "a=/x,b=/y_1@lab/frame"] {
            assert_eq!(given.parse::<Topics>().expect(given).to_string(), given);
        }
    }

    #[test]
    fn names_that_ros_does_not_have_are_refused() {
        for given in ["pose", "/", "/a//b", "/a/", "/1a", "/a__b", "/a-b", "/a,b", "x=y", "/a b"] {
            assert!(matches!(given.parse::<Topics>(), Err(TopicError::Name(_))), "{given}");
        }
        assert_eq!("".parse::<Topics>(), Err(TopicError::Missing));
        assert_eq!("@map".parse::<Topics>(), Err(TopicError::Missing));
        assert!(matches!("/a@".parse::<Topics>(), Err(TopicError::Empty(_))));
        assert!(matches!("=/a".parse::<Topics>(), Err(TopicError::Empty(_))));
    }

    #[test]
    fn bodies_are_called_as_their_topics_and_frames() {
        for (name, body) in [
            ("/vrpn_mocap/blue_boat/pose", "blue_boat"),
            ("/module_3/pose", "module-3"),
            ("/module_3", "module-3"),
            ("/module_x/odom", "module_x"),
            ("/pose", "pose"),
            ("fleet/module_12", "module-12"),
            ("base_link", "base_link"),
        ] {
            assert_eq!(body_of(name), body);
        }
    }
}
