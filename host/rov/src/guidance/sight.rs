//! Line-of-sight steering: the velocity that leads a robot back to its course.
//!
//! ```text
//! γ = −atan(e_n/Δ)                    aim at the point Δ ahead on the course       (Fossen 2011, (10.75))
//! v_d = U cos γ·t + U sin γ·n + c·t
//! c = −ω_p e_t/√(1 + (e_t/Δ)²)        speed controller: what is behind catches up
//! Δ = U/ω_p,   U = max(ṡ, U₀)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | t, n | unit vectors along the course and across it, towards the robot | 1 |
//! | e_t, e_n | how far the robot is ahead of its reference, and beside the course | m |
//! | Δ | lookahead distance | m |
//! | ṡ, U₀ | speed of the reference, least speed to steer with | m/s |
//! | ω_p | how fast a small error is to vanish: v = −ω_p e | 1/s |
//!
//! The lookahead is what is swum in 1/ω_p: then small errors vanish alike along and across, and large ones are come
//! back from at no more than U. Fossen steers the course of a vessel that cannot but go ahead; these robots push in all
//! directions, so the same law steers their velocity and the heading stays free. Near the ends of a leg, and where
//! nothing is to move, U₀ stands in for the speed that is missing.
//!
//! Assumptions and limits: no current; an unknown one would need the integral term of Fossen's (10.78).

use nalgebra::Vector3;

/// U₀, m/s. *Assumed*: the least speed that plans give a leg.
pub const STEERING_M_S: f64 = 0.1;

/// v_d, world, m/s: for a robot that is `off_m` from a reference of velocity `velocity_m_s`.
#[must_use]
pub fn velocity(off_m: &Vector3<f64>, velocity_m_s: &Vector3<f64>, omega_p: f64) -> Vector3<f64> {
    let speed = velocity_m_s.norm();
    let steering = speed.max(STEERING_M_S);
    let lookahead_m = steering / omega_p;
    // How much of U points back, for an error of that size: sin atan(e/Δ).
    let back = |error_m: f64| error_m / error_m.hypot(lookahead_m);
    if speed == 0.0 {
        let error_m = off_m.norm();
        return if error_m > 0.0 { off_m * (-steering * back(error_m) / error_m) } else { Vector3::zeros() };
    }
    let t = velocity_m_s / speed;
    let ahead_m = off_m.dot(&t);
    let across = off_m - t * ahead_m;
    let beside_m = across.norm();
    let catch_up = -steering * back(ahead_m);
    let along = t * (speed * lookahead_m / beside_m.hypot(lookahead_m) + catch_up);
    if beside_m > 0.0 { along - across * (steering * back(beside_m) / beside_m) } else { along }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_aims_at_the_point_ahead_on_the_course() {
        let (course, omega_p) = (Vector3::new(0.0, 0.4, 0.0), 0.5);
        // Δ = 0.8 m; 0.6 m beside the course the velocity of 0.4 m/s points along (−0.6, 0.8).
        let v = velocity(&Vector3::new(0.6, 0.0, 0.0), &course, omega_p);
        assert!((v - Vector3::new(-0.24, 0.32, 0.0)).norm() < 1e-12, "{v}");
        let on = velocity(&Vector3::zeros(), &course, omega_p);
        assert!((on - course).norm() < 1e-12);
        // Behind by a millimetre: faster by ω_p times that.
        let late = velocity(&Vector3::new(0.0, -1e-3, 0.0), &course, omega_p);
        assert!((late.y - 0.4 - 0.5e-3).abs() < 1e-9, "{late}");
    }

    /// Integrated, the distance from the course dies out from any side, and never faster than U.
    #[test]
    fn errors_die_out() {
        for start in [[2.0, -1.0, 0.5], [-0.3, 0.0, 4.0], [0.0, 0.0, -0.01]] {
            for speed in [0.0, 0.05, 0.4] {
                let course = Vector3::new(speed, 0.0, 0.0);
                let mut off = Vector3::from(start);
                let mut before = off.norm();
                for _ in 0..20_000 {
                    let v = velocity(&off, &course, 0.7);
                    assert!((v - course).norm() <= 2.0 * speed.max(STEERING_M_S) + 1e-9 + speed);
                    off += (v - course) * 0.01;
                    // Coming back from the side costs speed ahead: the sum may grow for a while, far out.
                    assert!(off.norm() < before + 2e-3);
                    before = off.norm();
                }
                assert!(off.norm() < 1e-6, "from {start:?} at {speed} m/s: {off}");
            }
        }
    }
}
