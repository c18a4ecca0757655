//! Where a level robot is: roll and pitch are held at zero by whoever moves or waits (condition v6).

use serde::{Deserialize, Serialize};

/// Position and heading in the world (north-east-down); written as `[x, y, z, yaw]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 4]", into = "[f64; 4]")]
pub struct Pose {
    /// Position of the body origin, m.
    pub position_m: [f64; 3],
    /// Heading ψ about the downward axis, rad.
    pub yaw_rad: f64,
}

impl From<[f64; 4]> for Pose {
    fn from([x, y, z, yaw_rad]: [f64; 4]) -> Self {
        Self { position_m: [x, y, z], yaw_rad }
    }
}

impl From<Pose> for [f64; 4] {
    fn from(pose: Pose) -> Self {
        let [x, y, z] = pose.position_m;
        [x, y, z, pose.yaw_rad]
    }
}
