//! The motion that is to be followed: no step of it asks for more than the modules can give.
//!
//! ```text
//! v* = v_des + w,   w = K_x (p − x_r) at most w_max;   a = s·0.7 (v* − v_r)/h,   s ∈ [0, 1] the greatest that can be given  (r1)
//! ω* = K_Θ e, as fast as it can still be stopped at most,   α = (ω* − Ω_r)/h,   |α| ≤ α_max                                        (r2)
//! ```
//!
//! A velocity is followed as a point p that moves with it: what is lost while speed is gained is made up for, and no steady error of the
//! velocity can remain. A station is a point that rests.

use quantity::wrap_rad;

/// State of one axis or more at the beginning of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reference {
    /// When, s.
    pub t_s: f64,
    /// Position in the world, m; heading, rad.
    pub pose: [f64; 3],
    /// Their rates.
    pub rate: [f64; 3],
    /// Accelerations for `for_s` from `t_s`.
    pub acceleration: [f64; 3],
    /// How long these last, s.
    pub for_s: f64,
    /// p, m.
    pub point_m: [f64; 2],
    /// Its velocity: what is asked for, m/s.
    pub asked_m_s: [f64; 2],
}

impl Reference {
    /// At `t_s`, a time after this one.
    pub(super) fn at(&self, t_s: f64) -> Self {
        let elapsed_s = t_s - self.t_s;
        let pushed_s = elapsed_s.min(self.for_s);
        let mut then = *self;
        then.t_s = t_s;
        for axis in 0..3 {
            let rate = self.rate[axis] + self.acceleration[axis] * pushed_s;
            let mean = self.rate[axis] + 0.5 * self.acceleration[axis] * pushed_s;
            then.pose[axis] += mean * pushed_s + rate * (elapsed_s - pushed_s);
            then.rate[axis] = rate;
        }
        (0..2).for_each(|k| then.point_m[k] += self.asked_m_s[k] * elapsed_s);
        then
    }
}

/// A vector shortened to `most` where it is longer.
pub(super) fn at_most([x, y]: [f64; 2], most: f64) -> [f64; 2] {
    let size = x.hypot(y);
    if size > most { [x * most / size, y * most / size] } else { [x, y] }
}

/// α of (r2) towards `heading_rad` over an interval h: the turn slows down as it can be stopped.
pub(super) fn turn(
    reference: &Reference,
    heading_rad: f64,
    interval_s: f64,
    gain_1_s: f64,
    rate_max_rad_s: f64,
    most_rad_s2: f64,
) -> f64 {
    let error_rad = wrap_rad(heading_rad - reference.pose[2]);
    // ω h + ω²/2α = |e| is the fastest from which it can still be stopped; half of α keeps some in hand.
    let braking = 0.5 * most_rad_s2;
    let stops =
        braking * ((interval_s.powi(2) + 2.0 * error_rad.abs() / braking.max(1e-9)).sqrt() - interval_s);
    let wanted = (gain_1_s * error_rad.abs()).min(stops).min(rate_max_rad_s).copysign(error_rad);
    ((wanted - reference.rate[2]) / interval_s).clamp(-most_rad_s2, most_rad_s2)
}
