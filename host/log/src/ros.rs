//! Standard messages of ROS 2, as its `common_interfaces` and `geometry2` define them (Humble to Kilted alike).
//!
//! | message | where it is defined |
//! |---|---|
//! | `Time`, `Duration` | `builtin_interfaces` |
//! | `Header`, `ColorRGBA` | `std_msgs` |
//! | `Vector3` … `TransformStamped` | `geometry_msgs` |
//! | `Odometry` | `nav_msgs` |
//! | `JointState`, `BatteryState`, `CompressedImage` | `sensor_msgs` |
//! | `TFMessage` | `tf2_msgs` |
//! | `DiagnosticArray` … | `diagnostic_msgs` |
//! | `MarkerArray` … | `visualization_msgs` |

use super::cdr::{Cdr, CdrError, Decoder, Encoder};
use super::message::messages;

/// 6 × 6, row by row: x, y, z, and the rotations about them. Zero: not known.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance(pub [f64; 36]);

impl Default for Covariance {
    fn default() -> Self {
        Self([0.0; 36])
    }
}

impl Cdr for Covariance {
    fn ros_type() -> String {
        <[f64; 36]>::ros_type()
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.put_doubles(&self.0);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
        Cdr::decode(decoder).map(Self)
    }
}

// Without comments: definitions are compared with ROS's own.
#[expect(missing_docs, reason = "fields are documented by ROS")]
mod definitions {
    use super::{Covariance, messages};

    messages! {
        Time = "builtin_interfaces" { sec: i32, nanosec: u32, }
        Duration = "builtin_interfaces" { sec: i32, nanosec: u32, }
        Header = "std_msgs" { stamp: Time, frame_id: String, }
        ColorRGBA = "std_msgs" { r: f32, g: f32, b: f32, a: f32, }
        Vector3 = "geometry_msgs" { x: f64, y: f64, z: f64, }
        Point = "geometry_msgs" { x: f64, y: f64, z: f64, }
        Quaternion = "geometry_msgs" { x: f64, y: f64, z: f64, w: f64, }
        Pose = "geometry_msgs" { position: Point, orientation: Quaternion, }
        PoseStamped = "geometry_msgs" { header: Header, pose: Pose, }
        PoseWithCovariance = "geometry_msgs" { pose: Pose, covariance: Covariance, }
        Twist = "geometry_msgs" { linear: Vector3, angular: Vector3, }
        TwistWithCovariance = "geometry_msgs" { twist: Twist, covariance: Covariance, }
        Wrench = "geometry_msgs" { force: Vector3, torque: Vector3, }
        WrenchStamped = "geometry_msgs" { header: Header, wrench: Wrench, }
        Transform = "geometry_msgs" { translation: Vector3, rotation: Quaternion, }
        TransformStamped = "geometry_msgs" { header: Header, child_frame_id: String, transform: Transform, }
        TFMessage = "tf2_msgs" { transforms: Vec<TransformStamped>, }
        Odometry = "nav_msgs" {
            header: Header,
            child_frame_id: String,
            pose: PoseWithCovariance,
            twist: TwistWithCovariance,
        }
        JointState = "sensor_msgs" {
            header: Header,
            name: Vec<String>,
            position: Vec<f64>,
            velocity: Vec<f64>,
            effort: Vec<f64>,
        }
        BatteryState = "sensor_msgs", [
            "uint8 POWER_SUPPLY_STATUS_UNKNOWN=0" "uint8 POWER_SUPPLY_STATUS_CHARGING=1"
            "uint8 POWER_SUPPLY_STATUS_DISCHARGING=2" "uint8 POWER_SUPPLY_STATUS_NOT_CHARGING=3"
            "uint8 POWER_SUPPLY_STATUS_FULL=4" "uint8 POWER_SUPPLY_HEALTH_UNKNOWN=0"
            "uint8 POWER_SUPPLY_HEALTH_GOOD=1" "uint8 POWER_SUPPLY_HEALTH_OVERHEAT=2"
            "uint8 POWER_SUPPLY_HEALTH_DEAD=3" "uint8 POWER_SUPPLY_HEALTH_OVERVOLTAGE=4"
            "uint8 POWER_SUPPLY_HEALTH_UNSPEC_FAILURE=5" "uint8 POWER_SUPPLY_HEALTH_COLD=6"
            "uint8 POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE=7" "uint8 POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE=8"
            "uint8 POWER_SUPPLY_TECHNOLOGY_UNKNOWN=0" "uint8 POWER_SUPPLY_TECHNOLOGY_NIMH=1"
            "uint8 POWER_SUPPLY_TECHNOLOGY_LION=2" "uint8 POWER_SUPPLY_TECHNOLOGY_LIPO=3"
            "uint8 POWER_SUPPLY_TECHNOLOGY_LIFE=4" "uint8 POWER_SUPPLY_TECHNOLOGY_NICD=5"
            "uint8 POWER_SUPPLY_TECHNOLOGY_LIMN=6" "uint8 POWER_SUPPLY_TECHNOLOGY_TERNARY=7"
            "uint8 POWER_SUPPLY_TECHNOLOGY_VRLA=8"
        ] {
            header: Header,
            voltage: f32,
            temperature: f32,
            current: f32,
            charge: f32,
            capacity: f32,
            design_capacity: f32,
            percentage: f32,
            power_supply_status: u8,
            power_supply_health: u8,
            power_supply_technology: u8,
            present: bool,
            cell_voltage: Vec<f32>,
            cell_temperature: Vec<f32>,
            location: String,
            serial_number: String,
        }
        CompressedImage = "sensor_msgs" { header: Header, format: String, data: Vec<u8>, }
        KeyValue = "diagnostic_msgs" { key: String, value: String, }
        DiagnosticArray = "diagnostic_msgs" { header: Header, status: Vec<DiagnosticStatus>, }
        Marker = "visualization_msgs", [
            "int32 ARROW=0" "int32 CUBE=1" "int32 SPHERE=2" "int32 CYLINDER=3" "int32 LINE_STRIP=4" "int32 LINE_LIST=5"
            "int32 CUBE_LIST=6" "int32 SPHERE_LIST=7" "int32 POINTS=8" "int32 TEXT_VIEW_FACING=9"
            "int32 MESH_RESOURCE=10" "int32 TRIANGLE_LIST=11" "int32 ARROW_STRIP=12" "int32 ADD=0" "int32 MODIFY=0"
            "int32 DELETE=2" "int32 DELETEALL=3"
        ] {
            header: Header,
            ns: String,
            id: i32,
            r#type: i32,
            action: i32,
            pose: Pose,
            scale: Vector3,
            color: ColorRGBA,
            lifetime: Duration,
            frame_locked: bool,
            points: Vec<Point>,
            colors: Vec<ColorRGBA>,
            texture_resource: String,
            texture: CompressedImage,
            uv_coordinates: Vec<UVCoordinate>,
            text: String,
            mesh_resource: String,
            mesh_file: MeshFile,
            mesh_use_embedded_materials: bool,
        }
        UVCoordinate = "visualization_msgs" { u: f32, v: f32, }
        MeshFile = "visualization_msgs" { filename: String, data: Vec<u8>, }
        MarkerArray = "visualization_msgs" { markers: Vec<Marker>, }
    }

    /// ROS's `byte`: eight bits that are no number.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Byte(pub u8);

    impl super::Cdr for Byte {
        fn ros_type() -> String {
            "byte".to_owned()
        }

        fn encode(&self, encoder: &mut super::Encoder) {
            self.0.encode(encoder);
        }

        fn decode(decoder: &mut super::Decoder<'_>) -> Result<Self, super::CdrError> {
            super::Cdr::decode(decoder).map(Self)
        }
    }

    messages! {
        DiagnosticStatus = "diagnostic_msgs", ["byte OK=0" "byte WARN=1" "byte ERROR=2" "byte STALE=3"] {
            level: Byte,
            name: String,
            message: String,
            hardware_id: String,
            values: Vec<KeyValue>,
        }
    }
}

pub use definitions::*;

/// A joint of a scene: a solid cube, a line.
impl Marker {
    /// [`Marker::type`](Marker) of a box.
    pub const CUBE: i32 = 1;
    /// [`Marker::type`](Marker) of a line through points.
    pub const LINE_STRIP: i32 = 4;
}

impl Time {
    /// At so many nanoseconds.
    #[must_use]
    pub fn from_nanos(nanos: u64) -> Self {
        Self { sec: (nanos / 1_000_000_000) as i32, nanosec: (nanos % 1_000_000_000) as u32 }
    }

    /// As nanoseconds; before zero there is no time.
    #[must_use]
    pub fn nanos(&self) -> u64 {
        u64::try_from(self.sec).unwrap_or(0) * 1_000_000_000 + u64::from(self.nanosec)
    }
}

impl Quaternion {
    /// Of a turn about z, rad.
    #[must_use]
    pub fn about_z(angle_rad: f64) -> Self {
        let (sin, cos) = (0.5 * angle_rad).sin_cos();
        Self { x: 0.0, y: 0.0, z: sin, w: cos }
    }

    /// Of ZYX Euler angles: roll φ, pitch θ, yaw ψ, rad. Fossen, Handbook of Marine Craft (2021), (2.78) by half angles.
    #[must_use]
    pub fn from_euler([roll_rad, pitch_rad, yaw_rad]: [f64; 3]) -> Self {
        let (sr, cr) = (0.5 * roll_rad).sin_cos();
        let (sp, cp) = (0.5 * pitch_rad).sin_cos();
        let (sy, cy) = (0.5 * yaw_rad).sin_cos();
        Self {
            x: sr * cp * cy - cr * sp * sy,
            y: cr * sp * cy + sr * cp * sy,
            z: cr * cp * sy - sr * sp * cy,
            w: cr * cp * cy + sr * sp * sy,
        }
    }
}
