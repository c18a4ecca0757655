//! Which topic of the log goes to which topic of ROS, and what is changed on the way.
//!
//! | of the log | goes to | quality |
//! |---|---|---|
//! | `/tf`, `/tf_static` | the same: ROS's tools look for them there | [`Quality::Transforms`], [`Quality::Latched`] |
//! | `/diagnostics` | the same (REP 107) | [`Quality::Reliable`] |
//! | `/odom`, `/truth/odom`, `/robot_N/odom` | `NAMESPACE/odom` … | [`Quality::Sensor`] |
//! | `/tails` | `NAMESPACE/joint_states` | [`Quality::Sensor`] |
//! | `/module_N/battery` | `NAMESPACE/module_N/battery` | [`Quality::Reliable`] |
//! | `/markers` | `NAMESPACE/markers` | [`Quality::Reliable`] |
//!
//! Stamps, which are fleet time in the log, become the time of the host's clock. Frames get the namespace in front, so that two fleets do not
//! share a `base_link`; all but the world, which they do share.

use runlog::cdr::{CdrError, Encoder};
use runlog::message::Message;
use runlog::ros::{
    BatteryState, DiagnosticArray, Header, JointState, MarkerArray, Odometry, TFMessage, Time,
};

use crate::wire::Ready;

/// The world's frame in the log.
pub const WORLD: &str = "world";

/// How a topic is delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Best effort, the newest 5: what comes often.
    Sensor,
    /// Reliable, the newest 100: as tf2 listens.
    Transforms,
    /// Reliable and transient local, the newest: comes to those who are late, too.
    Latched,
    /// Reliable, the newest 10.
    Reliable,
}

/// Where messages of a topic go.
#[derive(Clone, Debug)]
pub struct Place {
    /// The topic in ROS, in full.
    pub topic: String,
    /// Its type: package and name.
    pub kind: (&'static str, &'static str),
    /// How it is delivered.
    pub quality: Quality,
    adopt: Adopt,
}

/// What a fleet is in ROS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fleet {
    /// In front of topics: `/flotilla`, or nothing.
    pub namespace: String,
    /// What the world's frame is called in ROS.
    pub world: String,
    /// When fleet time was 0, ns since 1970; zero as long as that is not known.
    pub began_ns: u64,
}

impl Fleet {
    /// Where the messages of a topic of the log go; `None` for those that stay.
    #[must_use]
    pub fn place(&self, topic: &str, kind: &str) -> Option<Place> {
        let own = |name: &str| format!("{}{name}", self.namespace);
        let (topic, quality) = match topic {
            "/tf" => (topic.to_owned(), Quality::Transforms),
            "/tf_static" => (topic.to_owned(), Quality::Latched),
            "/diagnostics" => (topic.to_owned(), Quality::Reliable),
            "/tails" => (own("/joint_states"), Quality::Sensor),
            "/markers" => (own(topic), Quality::Reliable),
            _ if topic.ends_with("/odom") => (own(topic), Quality::Sensor),
            _ if topic.ends_with("/battery") => (own(topic), Quality::Reliable),
            _ => return None,
        };
        let (kind, adopt) = [
            entry::<TFMessage>(),
            entry::<Odometry>(),
            entry::<JointState>(),
            entry::<BatteryState>(),
            entry::<DiagnosticArray>(),
            entry::<MarkerArray>(),
        ]
        .into_iter()
        .find(|(name, _)| *name == kind)?;
        let kind = kind.split_once("/msg/")?;
        Some(Place { topic, kind, quality, adopt })
    }

    fn stamp(&self, time: &mut Time) {
        *time = Time::from_nanos(self.began_ns.saturating_add(time.nanos()));
    }

    /// A frame of the log as it is called in ROS.
    #[must_use]
    pub fn frame(&self, frame: &str) -> String {
        match frame {
            "" => String::new(),
            WORLD => self.world.clone(),
            _ => match self.namespace.strip_prefix('/') {
                Some(prefix) => format!("{prefix}/{frame}"),
                None => frame.to_owned(),
            },
        }
    }

    fn header(&self, header: &mut Header) {
        self.stamp(&mut header.stamp);
        header.frame_id = self.frame(&header.frame_id);
    }
}

impl Place {
    /// A message of the log as it goes out.
    ///
    /// # Errors
    /// [`CdrError`] for one that is none of its type.
    pub fn message(&self, cdr: &[u8], fleet: &Fleet) -> Result<Ready, CdrError> {
        (self.adopt)(cdr, fleet)
    }
}

type Adopt = fn(&[u8], &Fleet) -> Result<Ready, CdrError>;

fn entry<M: Message + Adopted>() -> (&'static str, Adopt) {
    (M::NAME, |cdr, fleet| {
        let mut message = M::read(cdr)?;
        message.adopt(fleet);
        let mut encoder = Encoder::default();
        message.write(&mut encoder);
        Ok(Ready::new(encoder.bytes()))
    })
}

/// A message that names instants and frames.
trait Adopted {
    fn adopt(&mut self, fleet: &Fleet);
}

impl Adopted for TFMessage {
    fn adopt(&mut self, fleet: &Fleet) {
        for transform in &mut self.transforms {
            fleet.header(&mut transform.header);
            transform.child_frame_id = fleet.frame(&transform.child_frame_id);
        }
    }
}

impl Adopted for Odometry {
    fn adopt(&mut self, fleet: &Fleet) {
        fleet.header(&mut self.header);
        self.child_frame_id = fleet.frame(&self.child_frame_id);
    }
}

impl Adopted for JointState {
    fn adopt(&mut self, fleet: &Fleet) {
        fleet.header(&mut self.header);
    }
}

impl Adopted for BatteryState {
    fn adopt(&mut self, fleet: &Fleet) {
        fleet.header(&mut self.header);
    }
}

impl Adopted for DiagnosticArray {
    fn adopt(&mut self, fleet: &Fleet) {
        fleet.header(&mut self.header);
        // Several fleets tell theirs by one topic.
        if let Some(prefix) = fleet.namespace.strip_prefix('/') {
            self.status.iter_mut().for_each(|status| status.name = format!("{prefix}: {}", status.name));
        }
    }
}

impl Adopted for MarkerArray {
    fn adopt(&mut self, fleet: &Fleet) {
        self.markers.iter_mut().for_each(|marker| fleet.header(&mut marker.header));
    }
}

#[cfg(test)]
mod tests {
    use runlog::ros::TransformStamped;

    use super::*;

    fn fleet(namespace: &str) -> Fleet {
        Fleet {
            namespace: namespace.to_owned(),
            world: "map".to_owned(),
            began_ns: 1_780_000_000_250_000_000,
        }
    }

    #[test]
    fn topics_go_into_the_namespace_and_those_that_ros_shares_do_not() {
        let odometry = "nav_msgs/msg/Odometry";
        for (topic, kind, expected) in [
            ("/tf", "tf2_msgs/msg/TFMessage", Some("/tf")),
            ("/odom", odometry, Some("/a/b/odom")),
            ("/robot_3/odom", odometry, Some("/a/b/robot_3/odom")),
            ("/tails", "sensor_msgs/msg/JointState", Some("/a/b/joint_states")),
            ("/module_2/battery", "sensor_msgs/msg/BatteryState", Some("/a/b/module_2/battery")),
            ("/scenario", "flotilla_msgs/msg/Scenario", None),
            ("/odom", "flotilla_msgs/msg/Scenario", None),
        ] {
            let place = fleet("/a/b").place(topic, kind);
            assert_eq!(place.as_ref().map(|place| place.topic.as_str()), expected, "{topic}");
        }
        assert_eq!(fleet("").place("/odom", odometry).map(|place| place.topic).as_deref(), Some("/odom"));
    }

    #[test]
    fn stamps_and_frames_are_changed_and_nothing_else() {
        let header =
            Header { stamp: Time { sec: 3, nanosec: 900_000_000 }, frame_id: "structure".to_owned() };
        let mut transform =
            TransformStamped { header, child_frame_id: "world".to_owned(), ..Default::default() };
        transform.transform.translation.y = 0.25;
        let mut expected = transform.clone();
        let mut encoder = Encoder::default();
        TFMessage { transforms: vec![transform] }.write(&mut encoder);
        let fleet = fleet("/flotilla");
        let place = fleet.place("/tf", "tf2_msgs/msg/TFMessage").expect("a place");
        assert_eq!((place.kind, place.quality), (("tf2_msgs", "TFMessage"), Quality::Transforms));
        let written = place.message(encoder.bytes(), &fleet).expect("a message");
        expected.header.stamp = Time { sec: 1_780_000_004, nanosec: 150_000_000 };
        expected.header.frame_id = "flotilla/structure".to_owned();
        expected.child_frame_id = "map".to_owned();
        TFMessage { transforms: vec![expected] }.write(&mut encoder);
        assert_eq!(written, Ready::new(encoder.bytes()));
        assert!(place.message(&encoder.bytes()[..40], &fleet).is_err());
    }
}
