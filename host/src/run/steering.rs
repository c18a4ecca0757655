//! Targets that an operator gives while a run goes on.

/// Another target, or none.
#[derive(Clone, Debug, PartialEq)]
pub enum Steering {
    /// A velocity in the world (x east, y north), m/s, for as long as it is asked for; and a heading, rad, if that is to change.
    Velocity([f64; 2], Option<f64>),
    /// A position in the world, to go to and to keep, m; the same.
    Station([f64; 2], Option<f64>),
    /// A heading Θ, rad; the rest stays.
    Heading(f64),
    /// Positions, one after the other, m; the last is kept. None: where it is.
    Waypoints(Vec<[f64; 2]>, Option<f64>),
    /// What the scenario asks for.
    Legs,
    /// None: the fleet finishes its cycle and holds, until the next target. Why.
    LetGo(&'static str),
}

impl Steering {
    /// In a few words, for the log.
    #[must_use]
    pub fn words(&self) -> String {
        let turned = |heading_rad: &Option<f64>| {
            heading_rad.map_or_else(String::new, |heading_rad| format!(", heading {heading_rad:.3} rad"))
        };
        match self {
            Self::Velocity([x, y], heading_rad) => {
                format!("velocity [{x:.4}, {y:.4}] m/s{}", turned(heading_rad))
            }
            Self::Station([x, y], heading_rad) => {
                format!("station [{x:.3}, {y:.3}] m{}", turned(heading_rad))
            }
            Self::Heading(heading_rad) => format!("heading {heading_rad:.3} rad"),
            Self::Waypoints(all, heading_rad) => {
                let places: Vec<String> = all.iter().map(|[x, y]| format!("[{x:.3}, {y:.3}]")).collect();
                format!("waypoints {} m{}", places.join(" "), turned(heading_rad))
            }
            Self::Legs => "back to the scenario's legs".to_owned(),
            Self::LetGo(why) => format!("no target ({why})"),
        }
    }
}
