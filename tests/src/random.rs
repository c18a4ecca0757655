//! Seeded shapes and demands.

use std::f64::consts::PI;

use rand::{Rng, RngExt};

use crate::checker::Modboat;

/// A connected shape of `modules` cells, grown from one by docking each next module to a random free side.
pub fn shape(modules: usize, rng: &mut impl Rng) -> Vec<[i32; 2]> {
    let mut cells = vec![[0, 0]];
    while cells.len() < modules {
        let [col, row] = cells[rng.random_range(0..cells.len())];
        let [right, up] = [[1, 0], [-1, 0], [0, 1], [0, -1]][rng.random_range(0..4)];
        let cell = [col + right, row + up];
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    cells
}

/// A wrench (Fx, Fy, τ) on the border of what the structure could give if no tail were in another's way.
///
/// Module i at (x, y) turns a thrust f into (f_x, f_y, x·f_y − y·f_x). For a random direction u of the wrench,
/// weighted, every module thrusts with the greatest force in the direction that serves u most: the support point of
/// the envelope. A share of it is that share of the envelope.
pub fn border(modboat: &Modboat, cells: &[[i32; 2]], rng: &mut impl Rng) -> [f64; 3] {
    let azimuth_rad = rng.random_range(-PI..PI);
    let height = rng.random_range(-1.0..1.0_f64);
    let across = (1.0 - height * height).sqrt();
    // The torque's part in proportion to the weights.
    let [u_x, u_y, u_tau] =
        [across * azimuth_rad.cos(), across * azimuth_rad.sin(), height * modboat.weights[2]];
    let thrust_n = modboat.thrust_n(modboat.amplitude_max_rad);
    modboat.positions_m(cells).into_iter().fold([0.0; 3], |[fx, fy, tau], [x, y]| {
        let [serves_x, serves_y] = [u_x - u_tau * y, u_y + u_tau * x];
        let serves = serves_x.hypot(serves_y).max(f64::MIN_POSITIVE);
        let (f_x, f_y) = (thrust_n * serves_x / serves, thrust_n * serves_y / serves);
        [fx + f_x, fy + f_y, tau + x * f_y - y * f_x]
    })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    use super::*;

    #[test]
    fn shapes_are_connected_and_without_duplicates() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for modules in 1..=12 {
            let cells = shape(modules, &mut rng);
            assert_eq!(cells.len(), modules);
            for (k, [col, row]) in cells.iter().enumerate().skip(1) {
                let docked = |[c, r]: &[i32; 2]| (c - col).abs() + (r - row).abs() == 1;
                assert!(cells[..k].iter().any(docked) && !cells[..k].contains(&[*col, *row]));
            }
        }
    }

    #[test]
    fn the_border_of_one_module_is_its_greatest_thrust() {
        let modboat = Modboat::default();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..100 {
            let [fx, fy, tau] = border(&modboat, &[[3, 5]], &mut rng);
            // 0.022·2.6 − 0.019 = 0.0382 N, at the centre of mass.
            assert!((fx.hypot(fy) - 0.0382).abs() < 1e-12 && tau.abs() < 1e-15);
        }
    }
}
