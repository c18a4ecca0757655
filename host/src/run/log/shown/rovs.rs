//! ROVs as messages of ROS: frames, and their boxes.

use std::f64::consts::FRAC_1_SQRT_2;

use protocol::time::FleetInstant;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use runlog::flotilla::{Robot, Robots};
use runlog::ros::{ColorRGBA, Header, Marker, MarkerArray, Odometry, Quaternion, TFMessage, Time, Vector3};

use super::super::{instant, stamp};
use super::transform;

/// See the module's documentation.
pub struct Scene {
    markers: MarkerArray,
    odometry: Odometry,
    /// Robots come first, then tools.
    robots: usize,
}

impl Scene {
    /// Of these bodies, whose first ones are robots with these numbers.
    pub fn new(bodies: &[(Pose, &Vehicle)], ids: &[u16]) -> Self {
        let markers = bodies.iter().enumerate().map(|(body, (pose, vehicle))| {
            let [x, y, z] = vehicle.box_m;
            let id = ids.get(body).map(|id| i32::from(*id));
            let (namespace, gray) = if id.is_some() { ("robots", 0.55) } else { ("tools", 0.8) };
            let mut marker = Marker {
                header: Header { frame_id: "world_ned".to_owned(), ..Header::default() },
                ns: namespace.to_owned(),
                id: id.unwrap_or(body as i32),
                r#type: Marker::CUBE,
                scale: Vector3 { x, y, z },
                color: ColorRGBA { r: gray, g: 0.6, b: 0.75, a: 1.0 },
                ..Marker::default()
            };
            marker.pose.position = super::point(pose.position_m);
            marker.pose.orientation = Quaternion::about_z(pose.yaw_rad);
            marker
        });
        let header = Header { frame_id: "world_ned".to_owned(), ..Header::default() };
        let odometry = Odometry { header, ..Odometry::default() };
        Self { markers: MarkerArray { markers: markers.collect() }, odometry, robots: ids.len() }
    }

    /// North is y, east is x, down is −z: half a turn about the horizontal between x and y.
    pub fn fixed(&self) -> TFMessage {
        let rotation = Quaternion { x: FRAC_1_SQRT_2, y: FRAC_1_SQRT_2, z: 0.0, w: 0.0 };
        let header = Header { stamp: stamp(FleetInstant(0)), frame_id: "world".to_owned() };
        TFMessage { transforms: vec![transform(header, "world_ned".to_owned(), [0.0; 3], rotation)] }
    }

    /// Where the robots are.
    pub fn transforms(&self, robots: &Robots) -> TFMessage {
        let transforms = robots.robots.iter().map(|robot| {
            let [x, y, z, roll, pitch, yaw] = robot.eta;
            let header = Header { stamp: stamp(instant(&robots.stamp)), frame_id: "world_ned".to_owned() };
            let rotation = Quaternion::from_euler([roll, pitch, yaw]);
            transform(header, format!("robot_{}", robot.id), [x, y, z], rotation)
        });
        TFMessage { transforms: transforms.collect() }
    }

    /// Motion of a robot; the twist is in its own frame.
    pub fn odometry(&mut self, stamp: &Time, robot: &Robot) -> &Odometry {
        let ([x, y, z, roll, pitch, yaw], [u, v, w, p, q, r]) = (robot.eta, robot.nu);
        let message = &mut self.odometry;
        message.header.stamp = stamp.clone();
        message.child_frame_id = format!("robot_{}", robot.id);
        message.pose.pose.position = super::point([x, y, z]);
        message.pose.pose.orientation = Quaternion::from_euler([roll, pitch, yaw]);
        message.twist.twist.linear = Vector3 { x: u, y: v, z: w };
        message.twist.twist.angular = Vector3 { x: p, y: q, z: r };
        message
    }

    /// Boxes of all bodies.
    pub fn markers(&mut self, robots: &Robots) -> &MarkerArray {
        for marker in &mut self.markers.markers {
            marker.header.stamp = robots.stamp.clone();
        }
        for (marker, robot) in self.markers.markers.iter_mut().take(self.robots).zip(&robots.robots) {
            let [x, y, z, roll, pitch, yaw] = robot.eta;
            marker.pose.position = super::point([x, y, z]);
            marker.pose.orientation = Quaternion::from_euler([roll, pitch, yaw]);
        }
        &self.markers
    }
}
