//! Which body is which module, where it sits on it and how it is turned.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};
use thiserror::Error;

use crate::axes::Pose;
use crate::frame::Label;

/// A module's entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The module's number in the fleet.
    pub module: u16,
    /// How the server calls its body.
    pub body: Name,
    /// The body's origin on the module, m, from the module's pivot: x to the right (sway), y forward (surge), z up for a boat; x
    /// forward, y right, z down for an underwater vehicle.
    pub offset_m: Vector3<f64>,
    /// How the body's x axis is turned from the module's forward direction, counter-clockwise seen from above for a boat, clockwise for
    /// an underwater vehicle (about its z axis, which points down), rad.
    pub turn_rad: f64,
}

/// How an entry names its body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Name {
    /// By its name.
    Name(String),
    /// By its number.
    Number(i32),
}

impl Name {
    /// Whether a label is meant.
    pub fn means(&self, label: &Label) -> bool {
        match self {
            Self::Name(name) => label.name.as_deref() == Some(name),
            Self::Number(number) => label.number == Some(*number),
        }
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Name(name) => write!(f, "\"{name}\""),
            Self::Number(number) => write!(f, "number {number}"),
        }
    }
}

/// What is wrong with a roster.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum RosterError {
    /// One body for two modules.
    #[error("body {body} stands for module {first} and for module {second}")]
    Body {
        /// The body.
        body: Name,
        /// The one.
        first: u16,
        /// The other.
        second: u16,
    },
    /// Two bodies for one module.
    #[error("module {module} has two entries, body {first} and body {second}")]
    Module {
        /// The module.
        module: u16,
        /// The one.
        first: Name,
        /// The other.
        second: Name,
    },
    /// A number that is none.
    #[error("body {body} of module {module}: its offset and turn must be finite numbers")]
    NotFinite {
        /// The module.
        module: u16,
        /// The body.
        body: Name,
    },
}

/// All entries, each body and each module once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roster {
    entries: Vec<Entry>,
    /// The place of each entry by what it names its body.
    names: BTreeMap<String, usize>,
    numbers: BTreeMap<i32, usize>,
}

impl Roster {
    /// A roster of these entries.
    ///
    /// # Errors
    /// A body or a module that is named twice, an offset or turn that is no number.
    pub fn new(entries: Vec<Entry>) -> Result<Self, RosterError> {
        for (at, entry) in entries.iter().enumerate() {
            let (module, body) = (entry.module, entry.body.clone());
            if !entry.turn_rad.is_finite() || !entry.offset_m.iter().all(|number| number.is_finite()) {
                return Err(RosterError::NotFinite { module, body });
            }
            for other in entries.iter().take(at) {
                if other.body == body {
                    return Err(RosterError::Body { body, first: other.module, second: module });
                }
                if other.module == module {
                    return Err(RosterError::Module { module, first: other.body.clone(), second: body });
                }
            }
        }
        let mut roster = Self { entries, ..Self::default() };
        for (at, entry) in roster.entries.iter().enumerate() {
            match &entry.body {
                Name::Name(name) => roster.names.insert(name.clone(), at),
                Name::Number(number) => roster.numbers.insert(*number, at),
            };
        }
        Ok(roster)
    }

    /// The entries, in the order given.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The place of a body's entry among all.
    pub fn place_of(&self, label: &Label) -> Option<usize> {
        let by_name = label.name.as_deref().and_then(|name| self.names.get(name));
        by_name.or_else(|| self.numbers.get(&label.number?)).copied()
    }

    /// The entry of a body.
    pub fn of(&self, label: &Label) -> Option<&Entry> {
        self.entries.get(self.place_of(label)?)
    }

    /// Entries whose body is not among `labels`: bodies that are never seen.
    pub fn missing<'a>(&'a self, labels: &'a [Label]) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(|entry| !labels.iter().any(|label| entry.body.means(label)))
    }
}

impl Entry {
    /// The vehicle's pose of its body's, both in north-east-down.
    pub fn vehicle(&self, body: &Pose) -> Pose {
        let attitude = body.attitude * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -self.turn_rad);
        Pose { position: body.position - attitude * self.offset_m, attitude }
    }

    /// The body's pose of its vehicle's, both in north-east-down.
    pub fn body_of_vehicle(&self, vehicle: &Pose) -> Pose {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turn_rad);
        Pose {
            position: vehicle.position + vehicle.attitude * self.offset_m,
            attitude: vehicle.attitude * turn,
        }
    }

    /// The pivot of a boat's module and the module's attitude (x right, y forward, z up) of its body's pose in the world.
    pub fn boat(&self, body: &Pose) -> Pose {
        let attitude = body.attitude * self.boat_turn().inverse();
        Pose { position: body.position - attitude * self.offset_m, attitude }
    }

    /// The body's pose of a boat's module.
    pub fn body_of_boat(&self, module: &Pose) -> Pose {
        let attitude = module.attitude * self.boat_turn();
        Pose { position: module.position + module.attitude * self.offset_m, attitude }
    }

    /// From the body's axes to the module's: forward is a quarter turn from the module's x axis.
    fn boat_turn(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turn_rad + std::f64::consts::FRAC_PI_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(module: u16, body: Name) -> Entry {
        Entry { module, body, offset_m: Vector3::zeros(), turn_rad: 0.0 }
    }

    #[test]
    fn a_body_or_a_module_twice_is_named() {
        let name = |name: &str| Name::Name(name.into());
        let error = |entries| Roster::new(entries).expect_err("a fault").to_string();
        assert_eq!(
            error(vec![entry(1, name("a")), entry(2, Name::Number(7)), entry(3, name("a"))]),
            "body \"a\" stands for module 1 and for module 3"
        );
        assert_eq!(
            error(vec![entry(1, name("a")), entry(1, Name::Number(7))]),
            "module 1 has two entries, body \"a\" and body number 7"
        );
        let mut wrong = entry(4, name("d"));
        wrong.turn_rad = f64::NAN;
        assert!(error(vec![wrong]).contains("body \"d\" of module 4"));
        let roster = Roster::new(vec![entry(1, name("a")), entry(2, Name::Number(7))]).expect("sound");
        assert_eq!(roster.of(&Label::new(7, "b")).map(|entry| entry.module), Some(2));
        let missing: Vec<u16> = roster.missing(&[Label::named("a")]).map(|entry| entry.module).collect();
        assert_eq!(missing, [2]);
    }

    #[test]
    fn a_body_ahead_of_a_boat_that_heads_north() {
        // A body 0.1 m ahead of the pivot, its x axis pointing to the left of the boat.
        let entry = Entry {
            offset_m: Vector3::new(0.0, 0.1, 0.05),
            turn_rad: std::f64::consts::FRAC_PI_2,
            ..entry(1, Name::Number(1))
        };
        // Surge axis north: the module's axes are the world's.
        let module = Pose { position: Vector3::new(2.0, 3.0, 0.0), attitude: UnitQuaternion::identity() };
        let body = entry.body_of_boat(&module);
        assert!((body.position - Vector3::new(2.0, 3.1, 0.05)).norm() < 1e-12);
        // Left of north is west: half a turn from east.
        assert!((crate::axes::heading_rad(&body.attitude).abs() - std::f64::consts::PI).abs() < 1e-9);
        let back = entry.boat(&body);
        assert!((back.position - module.position).norm() < 1e-12);
        assert!(back.attitude.angle_to(&module.attitude) < 1e-7);
    }

    #[test]
    fn there_and_back_for_a_vehicle() {
        let entry =
            Entry { offset_m: Vector3::new(0.1, -0.2, -0.05), turn_rad: 0.7, ..entry(1, Name::Number(1)) };
        let vehicle = Pose {
            position: Vector3::new(1.0, 2.0, 3.0),
            attitude: UnitQuaternion::from_euler_angles(0.1, -0.2, 2.0),
        };
        let back = entry.vehicle(&entry.body_of_vehicle(&vehicle));
        assert!((back.position - vehicle.position).norm() < 1e-12);
        assert!(back.attitude.angle_to(&vehicle.attitude) < 1e-7);
    }
}
