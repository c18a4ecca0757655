//! From rest to rest along a way: a trapezoid of speed, or a triangle where the way is too short for one.
//!
//! ```text
//! v̂ = min(v, √(L a))      t_r = v̂/a      T = L/v̂ + v̂/a
//! s(t) = ½ a t²                 0 ≤ t < t_r
//!        v̂ (t − t_r/2)          t_r ≤ t < T − t_r
//!        L − ½ a (T − t)²       T − t_r ≤ t ≤ T
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | L, s | whole way, way so far | m or rad |
//! | v, v̂ | greatest speed allowed, reached | m/s or rad/s |
//! | a | acceleration, up and down | m/s² or rad/s² |
//! | T, t_r | whole time, time of speeding up | s |

/// A motion from rest to rest: trapezoid or triangle of speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    way: f64,
    speed: f64,
    acceleration: f64,
}

/// One instant of a [`Profile`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// s.
    pub way: f64,
    /// ds/dt.
    pub speed: f64,
    /// d²s/dt².
    pub acceleration: f64,
}

impl Profile {
    /// Along `way` (zero if negative), no faster than `speed`; both of the others must be positive.
    #[must_use]
    pub fn new(way: f64, speed: f64, acceleration: f64) -> Self {
        let way = way.max(0.0);
        // v̂ = min(v, √(L a))
        Self { way, speed: speed.min((way * acceleration).sqrt()), acceleration }
    }

    /// Whole time T, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        // T = L/v̂ + v̂/a
        if self.speed > 0.0 { self.way / self.speed + self.speed / self.acceleration } else { 0.0 }
    }

    /// The instant `t_s` after the start; at rest before and after.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Progress {
        let Self { way, speed, acceleration } = *self;
        let left_s = self.duration_s() - t_s;
        if t_s < 0.0 || left_s <= 0.0 {
            return Progress { way: if t_s < 0.0 { 0.0 } else { way }, ..Progress::default() };
        }
        let ramp_s = speed / acceleration;
        if t_s < ramp_s {
            Progress { way: 0.5 * acceleration * t_s * t_s, speed: acceleration * t_s, acceleration }
        } else if left_s > ramp_s {
            Progress { way: speed * (t_s - 0.5 * ramp_s), speed, acceleration: 0.0 }
        } else {
            let way = way - 0.5 * acceleration * left_s * left_s;
            Progress { way, speed: acceleration * left_s, acceleration: -acceleration }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 m at 0.5 m/s and 0.5 m/s²: 1 s and 0.25 m up, 1 s on, 1 s down. 0.08 m: a triangle of 0.4 s and 0.2 m/s.
    #[test]
    fn trapezoid_and_triangle_worked_by_hand() {
        let long = Profile::new(1.0, 0.5, 0.5);
        assert!((long.duration_s() - 3.0).abs() < 1e-12);
        for (t_s, way, speed, acceleration) in
            [(0.5, 0.0625, 0.25, 0.5), (1.5, 0.5, 0.5, 0.0), (2.5, 0.9375, 0.25, -0.5), (9.0, 1.0, 0.0, 0.0)]
        {
            let at = long.at(t_s);
            let off =
                (at.way - way).abs() + (at.speed - speed).abs() + (at.acceleration - acceleration).abs();
            assert!(off < 1e-12, "{t_s} s: {at:?}");
        }
        let short = Profile::new(0.08, 0.5, 0.5);
        assert!((short.duration_s() - 0.8).abs() < 1e-12 && (short.at(0.4).speed - 0.2).abs() < 1e-12);
        let nowhere = Profile::new(0.0, 0.5, 0.5);
        assert!(nowhere.duration_s().abs() < 1e-12 && nowhere.at(0.0) == Progress::default());
    }

    /// The speed is the derivative of the way, the acceleration that of the speed, everywhere but in the corners.
    #[test]
    fn derivatives_agree() {
        let profile = Profile::new(0.7, 0.3, 0.2);
        let h = 1e-5;
        for step in 1..300 {
            let t_s = f64::from(step) * profile.duration_s() / 300.0 + 1e-4;
            let (before, here, after) = (profile.at(t_s - h), profile.at(t_s), profile.at(t_s + h));
            assert!(((after.way - before.way) / (2.0 * h) - here.speed).abs() < 1e-5, "{t_s} s");
            if (after.acceleration - before.acceleration).abs() < 1e-12 {
                assert!(
                    ((after.speed - before.speed) / (2.0 * h) - here.acceleration).abs() < 1e-6,
                    "{t_s} s"
                );
            }
        }
    }
}
