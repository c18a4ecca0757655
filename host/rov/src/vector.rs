//! Arithmetic of places and directions, m.

pub(super) use quantity::vector::{dot, length};

/// The way from `from` to `to`.
pub(super) fn offset(from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
}

/// A vector of a level body with heading `yaw_rad`, in the world.
pub(super) fn turned([x, y, z]: [f64; 3], yaw_rad: f64) -> [f64; 3] {
    let (sin, cos) = yaw_rad.sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}
