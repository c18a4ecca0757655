//! A structure of Modboats as messages of ROS: frames, odometry, target, wrenches, bodies and tails.

use std::f64::consts::FRAC_PI_2;

use protocol::time::FleetInstant;
use record::PoseSample;
use runlog::flotilla;
use runlog::ros::{
    ColorRGBA, Header, Marker, MarkerArray, Odometry, Point, Pose, PoseStamped, Quaternion, TFMessage,
    Vector3, Wrench, WrenchStamped,
};
use sim::TailState;

use super::super::super::pilot::Asked;
use super::super::super::scenario::{Demand, Scenario};
use super::super::stamp;
use super::{point, transform};

/// A demanded velocity is shown as the place where it leads within this time, s.
const AHEAD_S: f64 = 1.0;
/// Height of a module as it is drawn, m. *Assumed.*
const HEIGHT_M: f64 = 0.05;

/// See the module's documentation. Messages that come often are made once.
pub struct Scene {
    scenario: Scenario,
    ids: Vec<u16>,
    positions_m: Vec<[f64; 2]>,
    odometry: Odometry,
    transforms: TFMessage,
    bodies: MarkerArray,
    tails: MarkerArray,
}

impl Scene {
    /// Of this scenario with these modules.
    pub fn new(scenario: &Scenario, ids: &[u16]) -> Self {
        let positions_m = scenario.structure.positions_m(scenario.modboat.pitch_m);
        let mut scene = Self {
            scenario: scenario.clone(),
            ids: ids.to_vec(),
            positions_m,
            odometry: Odometry::default(),
            transforms: TFMessage::default(),
            bodies: MarkerArray::default(),
            tails: MarkerArray::default(),
        };
        scene.odometry.header.frame_id = "world".to_owned();
        scene.make_markers();
        scene
    }

    /// Frames within the structure.
    pub fn fixed(&self) -> TFMessage {
        let header = |frame: &str| Header { frame_id: frame.to_owned(), ..Header::default() };
        let upright = Quaternion::about_z(0.0);
        let turned = Quaternion::about_z(-FRAC_PI_2);
        let mut transforms = vec![transform(header("base_link"), "structure".to_owned(), [0.0; 3], turned)];
        for (&[x, y], id) in self.positions_m.iter().zip(&self.ids) {
            let module = format!("module_{id}");
            transforms.push(transform(header("structure"), module, [x, y, 0.0], upright.clone()));
        }
        TFMessage { transforms }
    }

    /// Motion in the world as odometry: the twist is in the body's own frame, x forward, y left.
    pub fn odometry(&mut self, now: FleetInstant, motion: &PoseSample, child: &str) -> &Odometry {
        let (sin, cos) = motion.heading_rad.sin_cos();
        let [vx, vy] = motion.velocity_m_s;
        let message = &mut self.odometry;
        message.header.stamp = stamp(now);
        if message.child_frame_id != child {
            child.clone_into(&mut message.child_frame_id);
        }
        message.pose.pose = pose(motion.position_m, motion.heading_rad);
        message.twist.twist.linear = Vector3 { x: vx * cos + vy * sin, y: vy * cos - vx * sin, z: 0.0 };
        message.twist.twist.angular.z = motion.yaw_rate_rad_s;
        message
    }

    /// Where the body is, and where the observer has it.
    pub fn transforms(
        &mut self,
        now: FleetInstant,
        base: Option<&PoseSample>,
        estimate: Option<&PoseSample>,
    ) -> &TFMessage {
        let frames = [("base_link", base), ("estimate", estimate)];
        self.transforms.transforms.clear();
        self.transforms.transforms.extend(frames.into_iter().filter_map(|(child, motion)| {
            let PoseSample { position_m: [x, y], heading_rad, .. } = *motion?;
            let header = Header { stamp: stamp(now), frame_id: "world".to_owned() };
            Some(transform(header, child.to_owned(), [x, y, 0.0], Quaternion::about_z(heading_rad)))
        }));
        &self.transforms
    }

    /// Where to: the station, or where the demanded velocity leads within [`AHEAD_S`].
    pub fn target(&self, now: FleetInstant, asked: &Asked, from_m: Option<[f64; 2]>) -> PoseStamped {
        let &Asked { demand, heading_rad, .. } = asked;
        let [x, y] = from_m.unwrap_or_default();
        let position_m = match demand {
            Demand::Station(position_m) => position_m,
            Demand::Velocity([vx, vy]) => [x + AHEAD_S * vx, y + AHEAD_S * vy],
        };
        let header = Header { stamp: stamp(now), frame_id: "world".to_owned() };
        PoseStamped { header, pose: pose(position_m, heading_rad) }
    }

    /// A wrench on the structure.
    pub fn wrench(&self, now: FleetInstant, wrench: &flotilla::Wrench) -> WrenchStamped {
        let &flotilla::Wrench { fx_n, fy_n, tau_nm } = wrench;
        WrenchStamped {
            header: Header { stamp: stamp(now), frame_id: "structure".to_owned() },
            wrench: Wrench {
                force: Vector3 { x: fx_n, y: fy_n, z: 0.0 },
                torque: Vector3 { x: 0.0, y: 0.0, z: tau_nm },
            },
        }
    }

    fn make_markers(&mut self) {
        let modboat = &self.scenario.modboat;
        let color = |r, g, b| ColorRGBA { r, g, b, a: 1.0 };
        let side_m = 0.96 * modboat.pitch_m;
        let modules = self.positions_m.iter().zip(&self.ids).map(|(&[x, y], &id)| {
            let mut marker = marker("modules", id, Marker::CUBE, color(0.75, 0.78, 0.82));
            marker.pose.position = point([x, y, 0.0]);
            marker.scale = Vector3 { x: side_m, y: side_m, z: HEIGHT_M };
            marker
        });
        let tails = self.ids.iter().map(|&id| {
            let mut marker = marker("tails", id, Marker::LINE_STRIP, color(0.85, 0.35, 0.1));
            marker.scale.x = modboat.tail_width_m;
            marker.points = vec![Point::default(); 2];
            marker
        });
        (self.bodies.markers, self.tails.markers) = (modules.collect(), tails.collect());
    }

    /// Bodies, which move with the structure's frame.
    pub fn bodies(&mut self, now: FleetInstant) -> &MarkerArray {
        for marker in &mut self.bodies.markers {
            marker.header.stamp = stamp(now);
        }
        &self.bodies
    }

    /// Tails as they are.
    pub fn tails(&mut self, now: FleetInstant, tails: &[TailState]) -> &MarkerArray {
        let length_m = self.scenario.modboat.tail_length_m;
        for ((marker, tail), &[x, y]) in self.tails.markers.iter_mut().zip(tails).zip(&self.positions_m) {
            marker.header.stamp = stamp(now);
            let (sin, cos) = tail.angle_rad.sin_cos();
            let ends = [[x, y, HEIGHT_M], [x + length_m * cos, y + length_m * sin, HEIGHT_M]];
            marker.points.clear();
            marker.points.extend(ends.map(point));
        }
        &self.tails
    }
}

fn pose([x, y]: [f64; 2], heading_rad: f64) -> Pose {
    Pose { position: point([x, y, 0.0]), orientation: Quaternion::about_z(heading_rad) }
}

fn marker(namespace: &str, id: u16, kind: i32, color: ColorRGBA) -> Marker {
    Marker {
        header: Header { frame_id: "structure".to_owned(), ..Header::default() },
        ns: namespace.to_owned(),
        id: i32::from(id),
        r#type: kind,
        pose: pose([0.0; 2], 0.0),
        color,
        frame_locked: true,
        ..Marker::default()
    }
}
