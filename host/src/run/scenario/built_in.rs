//! The scenarios that come with the program.

/// By name; the first is run when none is named.
pub const BUILT_IN: [(&str, &str); 11] = [
    ("holonomic-1", include_str!("../../../scenarios/holonomic-1.toml")),
    ("holonomic-2", include_str!("../../../scenarios/holonomic-2.toml")),
    ("holonomic-3", include_str!("../../../scenarios/holonomic-3.toml")),
    ("holonomic-4", include_str!("../../../scenarios/holonomic-4.toml")),
    ("six", include_str!("../../../scenarios/six.toml")),
    ("nine", include_str!("../../../scenarios/nine.toml")),
    ("twenty-five", include_str!("../../../scenarios/twenty-five.toml")),
    ("ring", include_str!("../../../scenarios/ring.toml")),
    ("line-12", include_str!("../../../scenarios/line-12.toml")),
    ("station-keeping", include_str!("../../../scenarios/station-keeping.toml")),
    ("square-path", include_str!("../../../scenarios/square-path.toml")),
];
