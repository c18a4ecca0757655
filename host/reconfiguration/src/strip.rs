//! Strip theory: added mass and quadratic damping of a closed box from its edges, for a vehicle whose file gives none.
//!
//! J. N. Newman, *Marine Hydrodynamics*, 1977, chapter 7; O. M. Faltinsen, *Sea Loads on Ships and Offshore Structures*,
//! 1990. The hull is cut into strips across x; each is taken for a piece of an endless rectangular cylinder:
//!
//! ```text
//! a(b, d) = ρ π C_A (b/2)²            per metre, b across the motion, d along it; C_A(b/d): DNV-RP-C205, table D-1
//! Y_v̇ = ∫ a(H, W) dx = a(H, W) L      N_ṙ = ∫ a(H, W) x² dx = a(H, W) L³/12
//! Z_ẇ = ∫ a(W, H) dx = a(W, H) L      M_q̇ = ∫ a(W, H) x² dx = a(W, H) L³/12
//! K_ṗ = ρ π β (max(W, H)/2)⁴ L        β(max/min): DNV-RP-C205, table D-1
//! X_u̇ = ρ C_A W H L                  strips say nothing along x: prism, C_A(L/√(WH)): DNV-RP-C205, table D-2
//! X_|u|u = ½ρ C_D W H,  Y_|v|v = ½ρ C_D H L,  Z_|w|w = ½ρ C_D W L
//! K_|p|p = ∫ ½ρ C_D L |s|³ ds over W and over H,  M_|q|q = ∫ ½ρ C_D W |x|³ dx,  N_|r|r = ∫ ½ρ C_D H |x|³ dx
//! ```
//!
//! so that N_|r|r = ρ C_D H L⁴/64. C_D = 1 (a cube's is 1.05, Hoerner 1965). Signs: all values here are positive.
//!
//! Limits: it is meant for slender hulls (L ≫ W, H) and sees neither the flow around the ends nor water inside. For a
//! stubby, open frame it is an upper bound: against the numbers used for the first BlueROV it gives 3 to 5 times the
//! added mass and 2 to 3 times the drag in translation. It gives no linear damping. Where measurements exist, use them.

use std::f64::consts::PI;

/// Density of fresh water at 20 °C, kg/m³.
pub const WATER_KG_M3: f64 = 998.2;
/// Drag coefficient of a strip. *Assumed*: that of a cube, rounded.
const DRAG: f64 = 1.0;

/// C_A of a rectangle by b/d (breadth across the motion over depth along it): DNV-RP-C205, table D-1.
const RECTANGLE: [(f64, f64); 7] =
    [(0.1, 2.23), (0.2, 1.98), (0.5, 1.70), (1.0, 1.51), (2.0, 1.36), (5.0, 1.21), (10.0, 1.14)];
/// β of a rectangle that rolls, by longer over shorter edge: DNV-RP-C205, table D-1.
const ROLL: [(f64, f64); 4] = [(1.0, 0.234), (2.0, 0.15), (5.0, 0.15), (10.0, 0.147)];
/// C_A of a square prism by length along the motion over edge: DNV-RP-C205, table D-2.
const PRISM: [(f64, f64); 8] =
    [(1.0, 0.68), (2.0, 0.36), (3.0, 0.24), (4.0, 0.19), (5.0, 0.15), (6.0, 0.13), (7.0, 0.11), (10.0, 0.08)];

/// What strip theory gives for a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strips {
    /// Diagonal of M_A, kg and kg·m².
    pub added_mass: [f64; 6],
    /// Diagonal of D_N at unit speed, N/(m/s)² and N·m/(rad/s)².
    pub quadratic_damping: [f64; 6],
}

impl Strips {
    /// A box of length, width and height `box_m` in water of `density_kg_m3`.
    #[must_use]
    pub fn of_box([length, width, height]: [f64; 3], density_kg_m3: f64) -> Self {
        let rho = density_kg_m3;
        // a(b, d) = ρ π C_A (b/2)²
        let section = |b: f64, d: f64| rho * PI * interpolate(&RECTANGLE, b / d) * (b / 2.0).powi(2);
        let (sway, heave) = (section(height, width), section(width, height));
        let (longer, shorter) = (width.max(height), width.min(height));
        let roll = rho * PI * interpolate(&ROLL, longer / shorter) * (longer / 2.0).powi(4);
        let surge = interpolate(&PRISM, length / (width * height).sqrt()) * rho * width * height * length;
        let second = length.powi(3) / 12.0;
        // ∫ ½ρ C_D b |s|³ ds over s = −e/2 … e/2
        let turning = |b: f64, e: f64| rho * DRAG * b * e.powi(4) / 64.0;
        let flat = |area: f64| 0.5 * rho * DRAG * area;
        Self {
            added_mass: [surge, sway * length, heave * length, roll * length, heave * second, sway * second],
            quadratic_damping: [
                flat(width * height),
                flat(height * length),
                flat(width * length),
                turning(length, width) + turning(length, height),
                turning(width, length),
                turning(height, length),
            ],
        }
    }
}

/// Between the rows of a table; the first and the last beyond its ends.
fn interpolate(table: &[(f64, f64)], x: f64) -> f64 {
    let after = table.partition_point(|&(at, _)| at < x);
    match (after.checked_sub(1).and_then(|before| table.get(before)), table.get(after)) {
        (Some(&(x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
        (Some(&(_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::Vehicle;

    /// A plate as wide as it is long would be endless: a thin wide section tends to the flat plate's ρ π (b/2)².
    #[test]
    fn sections_lie_between_the_table_and_the_flat_plate() {
        let plate = Strips::of_box([10.0, 2.0, 0.01], 1000.0);
        assert!((plate.added_mass[2] / (1.14 * 1000.0 * PI * 10.0) - 1.0).abs() < 1e-12, "{plate:?}");
        // Square section: sway and heave alike, C_A = 1.51; hand-worked for a beam of 0.2 m by 0.2 m by 2 m.
        let beam = Strips::of_box([2.0, 0.2, 0.2], 1000.0);
        assert!((beam.added_mass[1] - 94.88).abs() < 0.01, "{beam:?}");
        assert!((beam.added_mass[1] - beam.added_mass[2]).abs() < 1e-12);
        assert!((beam.added_mass[5] - 94.88 * 4.0 / 12.0).abs() < 0.01, "uniform along x: L²/12");
        // ½ρ C_D ∫ H |x|³ dx = 1000 · 0.2 · 2⁴ / 64
        assert!((beam.quadratic_damping[5] - 50.0).abs() < 1e-9);
        assert!((beam.quadratic_damping[0] - 20.0).abs() < 1e-9);
    }

    /// Against `bluerov1.toml`: yaw damping is the file's; the rest is another's measurement or estimate, and off by
    /// the factors that the module's text states.
    #[test]
    fn it_bounds_an_open_frame_from_above() {
        let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
        let strips = Strips::of_box(robot.box_m, WATER_KG_M3);
        let yaw = strips.quadratic_damping[5] / robot.body.quadratic_damping[5];
        assert!((yaw - 1.0).abs() < 0.01, "N_|r|r: {yaw}");
        for axis in 0..3 {
            let mass = strips.added_mass[axis] / robot.body.added_mass[axis];
            let drag = strips.quadratic_damping[axis] / robot.body.quadratic_damping[axis];
            println!("axis {axis}: added mass {mass:.2} times, drag {drag:.2} times the file's");
            assert!((3.0..6.0).contains(&mass) && (2.0..3.1).contains(&drag), "axis {axis}: {mass}, {drag}");
        }
    }

    #[test]
    fn a_file_may_leave_the_hydrodynamics_to_the_box() {
        let text = "name = \"box\"\nbox_m = [2.0, 0.2, 0.2]\nmass_kg = 80.0\ninertia_kg_m2 = [1, 27, 27]\n";
        let vehicle = Vehicle::parse("box.toml", text).expect("good");
        let strips = Strips::of_box(vehicle.box_m, WATER_KG_M3);
        assert_eq!(
            (vehicle.body.added_mass, vehicle.body.quadratic_damping),
            (strips.added_mass, strips.quadratic_damping)
        );
    }
}
