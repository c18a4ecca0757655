//! Weight and buoyancy of a robot, and of a cluster of different ones.
//!
//! ```text
//! r_G = Σ mᵢ (p_O,i + Rᵢ r_G,i) / Σ mᵢ                                                   (3)
//! r_B = Σ ∇ᵢ (p_O,i + Rᵢ r_B,i) / Σ ∇ᵢ                                                   (4)
//! g(η) = −[ f_g + f_b ; r_G × f_g + r_B × f_b ],   f_g = Rᵀ[0, 0, W],  f_b = −Rᵀ[0, 0, B]      (5)
//! ```
//!
//! As printed, (3) and (4) weigh only R r by mass and volume, not p_O; a mean of points weighs both. Volumes enter as
//! buoyancies: ρ g is the same for all.
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | p_O,i, Rᵢ | origin and attitude of member i | cluster; m |
//! | r_G, r_B | centres of gravity and buoyancy | cluster; m |
//! | W, B | weight, buoyancy | N |
//! | g(η) | restoring wrench, on the left side of (7): what thrusters have to bring to hold still | body; N, N·m |
//!
//! Limits: fully submerged and rigid, so that the centres stay where they are.

use nalgebra::{Matrix3, Vector3, Vector6};
use reconfiguration::body::Body;

/// Weight, buoyancy and their centres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hydrostatics {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Weight W, N.
    pub weight_n: f64,
    /// Buoyancy B, N.
    pub buoyancy_n: f64,
    /// Centre of gravity r_G, m.
    pub r_g_m: Vector3<f64>,
    /// Centre of buoyancy r_B, m.
    pub r_b_m: Vector3<f64>,
}

impl Hydrostatics {
    /// Hydrostatics of one body in its own frame.
    #[must_use]
    pub fn of(body: &Body) -> Self {
        Self {
            mass_kg: body.mass_kg,
            weight_n: body.weight_n,
            buoyancy_n: body.buoyancy_n,
            r_g_m: body.r_g_m.into(),
            r_b_m: body.r_b_m.into(),
        }
    }

    /// The same seen from a frame in which the body's origin lies at `offset_m` and its axes are `rotation`'s columns.
    #[must_use]
    pub(super) fn carried(self, offset_m: &Vector3<f64>, rotation: &Matrix3<f64>) -> Self {
        Self { r_g_m: offset_m + rotation * self.r_g_m, r_b_m: offset_m + rotation * self.r_b_m, ..self }
    }

    /// Of both together (3), (4), in the frame that both are given in.
    #[must_use]
    pub(super) fn with(&self, other: &Self) -> Self {
        Self {
            mass_kg: self.mass_kg + other.mass_kg,
            weight_n: self.weight_n + other.weight_n,
            buoyancy_n: self.buoyancy_n + other.buoyancy_n,
            r_g_m: mean(self.mass_kg, &self.r_g_m, other.mass_kg, &other.r_g_m),
            r_b_m: mean(self.buoyancy_n, &self.r_b_m, other.buoyancy_n, &other.r_b_m),
        }
    }

    /// Stiffness S = z_G W − z_B B about a level axis at depth `z_m`, N·m: tilted by θ, S sin θ turns the body back.
    #[must_use]
    pub fn stiffness_nm(&self, z_m: f64) -> f64 {
        (self.r_g_m.z - z_m) * self.weight_n - (self.r_b_m.z - z_m) * self.buoyancy_n
    }

    /// Restoring wrench g(η) (5) when the world's downward axis is `down` in the body frame: Rᵀ[0, 0, 1].
    #[must_use]
    pub fn restoring(&self, down: &Vector3<f64>) -> Vector6<f64> {
        let (f_g, f_b) = (self.weight_n * down, -self.buoyancy_n * down);
        let force = -(f_g + f_b);
        let moment = -(self.r_g_m.cross(&f_g) + self.r_b_m.cross(&f_b));
        Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
    }
}

fn mean(a: f64, at: &Vector3<f64>, b: f64, bt: &Vector3<f64>) -> Vector3<f64> {
    // What displaces nothing has no centre of buoyancy, and its place does not matter.
    if a + b > 0.0 { (at * a + bt * b) / (a + b) } else { Vector3::zeros() }
}

#[cfg(test)]
mod tests {
    use reconfiguration::pose::Pose;
    use reconfiguration::vehicle::Vehicle;

    use super::*;
    use crate::cluster::Cluster;

    fn vehicle(name: &str) -> Vehicle {
        Vehicle::built_in(name).expect(name)
    }

    /// Section VIII-A: the tool asks for 0.6 N·m, whatever is docked to it and wherever the origin is.
    #[test]
    fn the_papers_tool_asks_for_its_moment() {
        let (robot, tool) = (vehicle("bluerov1"), vehicle("tool-20n"));
        for origin in [[0.0; 4], [0.7, -1.0, 0.2, 0.0]] {
            let members = [
                (Pose::from([1.0, 0.0, 0.0, 0.0]), &tool),
                (Pose::from([0.5, 0.0, 0.0, 0.0]), &robot),
                (Pose::from([0.5, 0.33, 0.0, 1.57]), &robot),
            ];
            let cluster = Cluster::new(&origin.into(), &members).expect("three members");
            let g = cluster.hydrostatics().restoring(&Vector3::z());
            let expected = [0.0, 0.0, 0.0, 0.0, 0.6, 0.0];
            for (axis, expected) in expected.into_iter().enumerate() {
                assert!((g[axis] - expected).abs() < 1e-5, "axis {axis} from {origin:?}: {g}");
            }
        }
        // Turned to the east, its weight rolls the north-facing frame: a mass to the right rolls it right.
        let members = [(Pose::from([0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2]), &tool)];
        let cluster = Cluster::new(&Pose::default(), &members).expect("a member");
        let g = cluster.hydrostatics().restoring(&Vector3::z());
        assert!((g[3] + 0.6).abs() < 1e-5 && g[4].abs() < 1e-9, "{g}");
    }

    /// 3 kg at x = 1 and 1 kg at x = 5, weighed by hand; buoyancies of 10 N and 30 N.
    #[test]
    fn centres_are_means_by_mass_and_volume() {
        let at = |mass_kg, buoyancy_n, x| {
            let offset = Vector3::new(x, 0.0, 0.5);
            let point = Vector3::zeros();
            Hydrostatics { mass_kg, weight_n: 9.0, buoyancy_n, r_g_m: point, r_b_m: point }
                .carried(&offset, &Matrix3::identity())
        };
        let both = at(3.0, 10.0, 1.0).with(&at(1.0, 30.0, 5.0));
        assert!((both.r_g_m - Vector3::new(2.0, 0.0, 0.5)).norm() < 1e-12, "{}", both.r_g_m);
        assert!((both.r_b_m - Vector3::new(4.0, 0.0, 0.5)).norm() < 1e-12, "{}", both.r_b_m);
        assert!(
            (both.mass_kg - 4.0).abs() + (both.weight_n - 18.0).abs() + (both.buoyancy_n - 40.0).abs()
                < 1e-12
        );
    }

    /// Fossen 2011, (4.6), written out for W, B and both centres.
    #[test]
    fn restoring_is_the_textbooks() {
        let (w, b) = (112.8, 114.8);
        let (xg, yg, zg, xb, yb, zb) = (0.01, -0.02, 0.03, 0.005, 0.004, -0.02);
        let (phi, theta) = (0.4_f64, -0.7_f64);
        let body = Hydrostatics {
            mass_kg: 11.5,
            weight_n: w,
            buoyancy_n: b,
            r_g_m: Vector3::new(xg, yg, zg),
            r_b_m: Vector3::new(xb, yb, zb),
        };
        let (sp, cp, st, ct) = (phi.sin(), phi.cos(), theta.sin(), theta.cos());
        let g = body.restoring(&Vector3::new(-st, ct * sp, ct * cp));
        let expected = Vector6::new(
            (w - b) * st,
            -(w - b) * ct * sp,
            -(w - b) * ct * cp,
            -(yg * w - yb * b) * ct * cp + (zg * w - zb * b) * ct * sp,
            (zg * w - zb * b) * st + (xg * w - xb * b) * ct * cp,
            -(xg * w - xb * b) * ct * sp - (yg * w - yb * b) * st,
        );
        assert!((g - expected).amax() < 1e-12, "{g}, {expected}");
    }
}
