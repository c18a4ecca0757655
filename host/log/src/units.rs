//! Units of ROS's own fields, which their names do not tell. Flotilla's names end with theirs.
//!
//! Source: REP 103 (SI, radians), and the comments in the definitions of `sensor_msgs`.

/// Unit of a field of a standard message, as the end of a column's name; for a vector the unit of its components.
#[must_use]
pub fn unit(message: &str, field: &str) -> Option<&'static str> {
    Some(match (message, field) {
        ("geometry_msgs/Point" | "geometry_msgs/Vector3", "x" | "y" | "z") => "m",
        ("geometry_msgs/Transform", "translation") | ("visualization_msgs/Marker", "scale") => "m",
        ("geometry_msgs/Twist", "linear") => "m_s",
        ("geometry_msgs/Twist", "angular") => "rad_s",
        ("geometry_msgs/Wrench", "force") => "n",
        ("geometry_msgs/Wrench", "torque") => "nm",
        ("sensor_msgs/JointState", "position") => "rad",
        ("sensor_msgs/JointState", "velocity") => "rad_s",
        ("sensor_msgs/JointState", "effort") => "nm",
        ("sensor_msgs/BatteryState", "voltage" | "cell_voltage") => "v",
        ("sensor_msgs/BatteryState", "temperature" | "cell_temperature") => "degc",
        ("sensor_msgs/BatteryState", "current") => "a",
        ("sensor_msgs/BatteryState", "charge" | "capacity" | "design_capacity") => "ah",
        _ => return None,
    })
}
