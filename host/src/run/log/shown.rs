//! What others' tools look at: standard messages of ROS 2.
//!
//! ```text
//! world (x east, y north, z up)
//! ├── estimate                    as the observer has it
//! └── base_link                   as it is, where that is known; x forward, y left, z up
//!     └── structure               S: x sway, to the right; y surge, forward
//!         ├── module_1, …
//! world
//! └── world_ned (x north, y east, z down)
//!     ├── robot_1, …              x forward, y right, z down
//! ```

pub(super) mod boats;
pub(super) mod modules;
pub(super) mod rovs;

use runlog::ros::{Header, Point, Quaternion, Transform, TransformStamped, Vector3};

fn transform(header: Header, child: String, [x, y, z]: [f64; 3], rotation: Quaternion) -> TransformStamped {
    let translation = Vector3 { x, y, z };
    TransformStamped { header, child_frame_id: child, transform: Transform { translation, rotation } }
}

fn point([x, y, z]: [f64; 3]) -> Point {
    Point { x, y, z }
}
