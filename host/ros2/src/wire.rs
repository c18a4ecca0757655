//! Messages of ROS 2 as they come and go.
//!
//! What goes is in CDR already, as the log has it. What comes is read by `serde`; of an odometry only the part in front of its covariances,
//! which is what is used.

use ros2_client::Message;
use runlog::cdr::ENCAPSULATION;
use serde::ser::SerializeTuple as _;
use serde::{Deserialize, Serialize, Serializer};

/// A message that is in CDR already, behind its encapsulation header. Bytes align to one, so that they go out as they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ready(Vec<u8>);

impl Ready {
    /// Of a message as the log has it, with its encapsulation header, which the writer makes by itself.
    #[must_use]
    pub fn new(cdr: &[u8]) -> Self {
        Self(cdr.strip_prefix(&ENCAPSULATION).unwrap_or(cdr).to_vec())
    }
}

impl Serialize for Ready {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}

/// `std_srvs/Trigger`: an empty request. A structure without members takes one byte on the wire, which rmw calls
/// `structure_needs_at_least_one_member`.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct TriggerRequest {
    structure_needs_at_least_one_member: u8,
}

/// What came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether it was done.
    pub success: bool,
    /// What was done, or why not.
    pub message: String,
}

impl Message for TriggerRequest {}
impl Message for TriggerResponse {}

/// `geometry_msgs/Vector3`, and `Point`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// i.
    pub x: f64,
    /// j.
    pub y: f64,
    /// k.
    pub z: f64,
    /// The real part.
    pub w: f64,
}

/// `geometry_msgs/Twist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// m/s.
    pub linear: Vector3,
    /// rad/s.
    pub angular: Vector3,
}

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// s since 1970.
    pub sec: i32,
    /// And ns.
    pub nanosec: u32,
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// When.
    pub stamp: Time,
    /// In which frame.
    pub frame_id: String,
}

/// `geometry_msgs/Pose`, and `Transform`, which lies alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// m.
    pub position: Vector3,
    /// The attitude.
    pub orientation: Quaternion,
}

/// `geometry_msgs/PoseStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When, and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// `geometry_msgs/TransformStamped`; and `nav_msgs/Odometry` up to the covariance of its pose, which lies alike.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// When, and in which frame.
    pub header: Header,
    /// What frame is there.
    pub child_frame_id: String,
    /// Where.
    pub transform: Pose,
}

/// `tf2_msgs/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transforms {
    /// All of them.
    pub transforms: Vec<Transform>,
}

impl Time {
    /// ns since 1970.
    #[must_use]
    pub fn nanos(self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }
}

impl Quaternion {
    /// Its turn about z, rad: of ZYX Euler angles the yaw. `None` where it is no attitude.
    #[must_use]
    pub fn yaw_rad(self) -> Option<f64> {
        let Self { x, y, z, w } = self;
        let norm = (x * x + y * y + z * z + w * w).sqrt();
        let is_unit = (norm - 1.0).abs() < 0.01;
        is_unit.then(|| (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    /// With the same angles by runlog's quaternion, which comes from Fossen's half angles.
    #[test]
    fn the_yaw_of_an_attitude_is_that_of_its_euler_angles() {
        for euler in [[0.0, 0.0, 0.3], [0.4, -0.5, 2.9], [-1.0, 1.2, -FRAC_PI_2], [3.0, 0.1, 1.0]] {
            let runlog::ros::Quaternion { x, y, z, w } = runlog::ros::Quaternion::from_euler(euler);
            let yaw_rad = Quaternion { x, y, z, w }.yaw_rad().expect("an attitude");
            assert!((yaw_rad - euler[2]).abs() < 1e-12, "{euler:?}: {yaw_rad}");
            let other = Quaternion { x: -x, y: -y, z: -z, w: -w }.yaw_rad().expect("the same attitude");
            assert!((other - yaw_rad).abs() < 1e-12);
        }
        let about = Quaternion { z: 1.0, ..Quaternion::default() };
        assert!(about.yaw_rad().is_some_and(|yaw_rad| (yaw_rad.abs() - PI).abs() < 1e-12));
        assert_eq!(Quaternion::default().yaw_rad(), None);
        assert_eq!(Quaternion { w: f64::NAN, ..Quaternion::default() }.yaw_rad(), None);
    }
}
