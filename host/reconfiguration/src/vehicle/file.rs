//! A vehicle's TOML: its shape, and what is refused. A mistake is told as file:line: key = value unit: reason.

use quantity::{ParameterError, Range, check_ranges};
use reader::{Document, FileError, Mistake};
use serde::Deserialize;

use super::{Connector, Thruster, Vehicle};
use crate::body::{Body, GRAVITY_M_S2};
use crate::strip::{Strips, WATER_KG_M3};

/// The file's own shape. What it leaves out of hydrodynamics is estimated from the box.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    name: String,
    box_m: [f64; 3],
    mass_kg: f64,
    #[serde(default)]
    weight_in_water_n: f64,
    #[serde(default)]
    r_g_m: [f64; 3],
    #[serde(default)]
    r_b_m: [f64; 3],
    inertia_kg_m2: [f64; 3],
    added_mass: Option<[f64; 6]>,
    #[serde(default)]
    linear_damping: [f64; 6],
    quadratic_damping: Option<[f64; 6]>,
    #[serde(default)]
    thrusters: Vec<Thruster>,
    #[serde(default)]
    connectors: Vec<Connector>,
    #[serde(default)]
    capabilities: Vec<String>,
}

pub(super) fn parse(file: &str, text: &str) -> Result<Vehicle, FileError> {
    let document = Document::toml(text).map_err(|mistake| mistake.in_file(file))?;
    of(&document).map_err(|mistake| mistake.in_file(file))
}

fn of(document: &Document<'_>) -> Result<Vehicle, Mistake> {
    let tables: Tables = document.read()?;
    let number = |error: ParameterError| document.mistake(&[error.key], error.to_string());

    if tables.name.trim().is_empty() {
        return Err(document.mistake(&["name"], "name = \"\": must not be empty"));
    }
    check_ranges(&tables.box_m.map(|edge| ("box_m", edge, "m", Range::Positive))).map_err(number)?;
    let strips = Strips::of_box(tables.box_m, WATER_KG_M3);
    check_ranges(&[
        ("mass_kg", tables.mass_kg, "kg", Range::Positive),
        ("weight_in_water_n", tables.weight_in_water_n, "N", Range::Finite),
    ])
    .map_err(number)?;
    let weight_n = tables.mass_kg * GRAVITY_M_S2;
    let body = Body {
        mass_kg: tables.mass_kg,
        weight_n,
        buoyancy_n: weight_n - tables.weight_in_water_n,
        r_g_m: tables.r_g_m,
        r_b_m: tables.r_b_m,
        inertia_kg_m2: tables.inertia_kg_m2,
        added_mass: tables.added_mass.unwrap_or(strips.added_mass),
        linear_damping: tables.linear_damping,
        quadratic_damping: tables.quadratic_damping.unwrap_or(strips.quadratic_damping),
    };
    if body.buoyancy_n < 0.0 {
        return Err(number(ParameterError {
            key: "weight_in_water_n",
            value: tables.weight_in_water_n,
            unit: "N",
            reason: "must be at most the weight in air",
        }));
    }
    body.validate().map_err(number)?;
    let thrusters = tables.thrusters.iter().map(|t| ("thrusters", "direction", t.position_m, t.direction));
    let connectors = tables.connectors.iter().map(|c| ("connectors", "normal", c.position_m, c.normal));
    for (index, (table, key, position_m, direction)) in thrusters.enumerate().chain(connectors.enumerate()) {
        placed(key, position_m, direction)
            .map_err(|error| document.mistake_in(&[table, &index.to_string()], error.key, &error))?;
    }
    let Tables { name, box_m, thrusters, connectors, capabilities, .. } = tables;
    Ok(Vehicle { name, box_m, body, thrusters, connectors, capabilities })
}

fn placed(key: &'static str, position_m: [f64; 3], direction: [f64; 3]) -> Result<(), ParameterError> {
    check_ranges(&position_m.map(|value| ("position_m", value, "m", Range::Finite)))?;
    check_ranges(&direction.map(|value| (key, value, "(no unit)", Range::Finite)))?;
    let length = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
    if (length - 1.0).abs() > 1e-6 {
        return Err(ParameterError {
            key,
            value: length,
            unit: "in length",
            reason: "must be a unit vector",
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::BUILT_IN;
    use super::*;

    const GOOD: &str = "name = \"t\"\nbox_m = [0.4, 0.3, 0.2]\nmass_kg = 4.0\n\
                        inertia_kg_m2 = [0.1, 0.1, 0.1]\nadded_mass = [1, 2, 3, 0.1, 0.1, 0.1]\n\
                        quadratic_damping = [1, 2, 3, 0.1, 0.1, 0.1]\n\
                        [[thrusters]]\nposition_m = [0.1, 0.0, 0.0]\ndirection = [1.0, 0.0, 0.0]\n";

    #[test]
    fn mistakes_are_named_with_their_line() {
        Vehicle::parse("t.toml", GOOD).expect("good");
        let six = "quadratic_damping = [1, 2, 3, 0.1, 0.1, 0.1]";
        for (text, expected) in [
            (GOOD.replace("\"t\"", "\" \""), "t.toml:1: name"),
            (GOOD.replace("0.3, 0.2]", "-0.3, 0.2]"), "t.toml:2: box_m = -0.3 m: must be"),
            (GOOD.replace("4.0", "nan"), "t.toml:3: mass_kg = NaN kg: must be"),
            (GOOD.replace("4.0", "\"four\""), "t.toml:3: mass_kg = \"four\": must be a number"),
            (
                GOOD.replace("= [0.1, 0.1, 0.1]", "= [0.1, 0.1]"),
                "t.toml:4: inertia_kg_m2 = [0.1, 0.1]: a list of 2 where 3 are",
            ),
            (
                GOOD.replace("= [0.1, 0.1, 0.1]", "= [0.1, 0.1, 0.1, 1]"),
                "t.toml:4: inertia_kg_m2 = [0.1, 0.1, 0.1, 1]: a list of 4 where 3 are",
            ),
            (GOOD.replace("= [0.1, 0.1, 0.1]", "= [0.1, 0.0, 0.1]"), "t.toml:4: inertia_kg_m2 = 0 kg·m²"),
            (
                GOOD.replace("[1, 2, 3, 0.1, 0.1, 0.1]\n[[", "[1, 2, 3, 0.1, -0.1, 0.1]\n[["),
                "t.toml:6: quadratic_damping = -0.1 N·m/(rad/s)²: must be",
            ),
            (GOOD.replace("mass_kg", "mass"), "t.toml:3: unknown field `mass`"),
            (
                GOOD.replace(six, "weight_in_water_n = 50.0"),
                "t.toml:6: weight_in_water_n = 50 N: must be at most",
            ),
            (
                GOOD.replace("[1.0, 0.0, 0.0]", "[1.0, 0.1, 0.0]"),
                "t.toml:9: [[thrusters]] 1: direction = 1.00",
            ),
            (
                GOOD.replace("[0.1, 0.0, 0.0]", "[inf, 0.0, 0.0]"),
                "t.toml:8: [[thrusters]] 1: position_m = inf m",
            ),
            (
                format!(
                    "{GOOD}[[connectors]]\nname = \"nose\"\nposition_m = [0, 0, 0]\nnormal = [0, 0, 0]\n"
                ),
                "t.toml:13: [[connectors]] 1: normal = 0 in length: must be a unit vector",
            ),
        ] {
            let complaint = Vehicle::parse("t.toml", &text).expect_err(&text).to_string();
            assert!(complaint.starts_with(expected), "{complaint}\nexpected {expected}");
        }
    }

    #[test]
    fn what_comes_with_the_program_can_be_read() {
        for (name, text) in BUILT_IN {
            let vehicle = Vehicle::parse(name, text).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(Vehicle::built_in(name), Some(vehicle));
        }
        assert_eq!(Vehicle::built_in("bluerov9"), None);
    }

    #[test]
    fn without_connectors_the_faces_of_the_box_dock() {
        let vehicle = Vehicle::parse("t.toml", GOOD).expect("good");
        let faces = vehicle.connectors();
        let right = faces.iter().find(|face| face.name == "right").expect("a right side");
        assert_eq!((faces.len(), right.position_m, right.normal), (6, [0.0, 0.15, 0.0], [0.0, 1.0, 0.0]));
        let text =
            format!("{GOOD}[[connectors]]\nname = \"nose\"\nposition_m = [0.2, 0, 0]\nnormal = [1, 0, 0]\n");
        assert_eq!(Vehicle::parse("t.toml", &text).expect("good").connectors()[0].name, "nose");
    }
}
