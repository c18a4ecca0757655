//! From reported tail angles to what the flippers deliver, as far as it does not depend on constants.
//!
//! A *stroke* runs from one turning point of a tail (the anchor φ_a) to the next. With slope κ and offset λ = κ·ρ of law (2), T its
//! period and u(m) = (cos m, sin m), a stroke that has swept s = |φ − φ_a| has given the structure the impulse
//!
//! ```text
//! P(s) = −(T/2)·κ·max(0, ½ s − ρ)·u(φ_a + (φ − φ_a)/2)                                           (i1)
//! ```
//!
//! which is (t1), (t2) of the simulated water (`sim::thrust`): a whole swing of waveform (1) gives the mean of law (2) in the direction
//! of (7). Sweep and direction follow from the angle alone; κ and ρ are what is looked for.
//!
//! Between two reports a tail follows the cubic that has both angles and both speeds. Turning points are where φ̇ changes sign,
//! where the tail has slowed below `REST_RAD_S` and speeds up again, and where a swim cycle starts by plan: a transition that goes on in the
//! direction of the first stroke rests between the two for a few milliseconds, which reports 20 ms apart may not show.
//!
//! Limits: reports 50 Hz apart or less; a tail that is not reported for longer than [`REPORT_GAP_S`] rests meanwhile.

use super::data::Tails;

/// Below this speed a tail counts as turning, rad/s. *Assumed*, as in the simulated water.
const REST_RAD_S: f64 = 0.5;
/// A tail that is slower than this where its cycle starts by plan has rested there, rad/s. *Assumed*: it speeds up for 20 ms at most.
const START_RAD_S: f64 = 3.0;
/// Step in which turning points are looked for, s.
const STEP_S: f64 = 0.005;
/// Longest pause between two reports that a tail is followed over, s. *Assumed*.
pub const REPORT_GAP_S: f64 = 0.25;

/// One tail over time.
#[derive(Clone, Debug)]
pub struct Track {
    t_s: Vec<f64>,
    angle_rad: Vec<f64>,
    rate_rad_s: Vec<f64>,
    strokes: Vec<Stroke>,
    /// ∫ φ̇|φ̇| dt up to each instant of a grid of [`STEP_S`], rad²/s.
    dragged: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Stroke {
    start_s: f64,
    anchor_rad: f64,
    /// Where the tail was when the next one began.
    end_rad: f64,
}

/// A tail at one instant, as far as impulses need it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// Strokes that are over.
    pub past: usize,
    /// s of the present one, rad.
    pub sweep_rad: f64,
    /// u of its running midpoint.
    pub along: [f64; 2],
    /// φ̇, rad/s.
    pub rate_rad_s: f64,
    /// ∫ φ̇|φ̇| dt so far, rad²/s.
    pub dragged: f64,
}

/// A stroke that is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past {
    /// s at its end, rad.
    pub sweep_rad: f64,
    /// u of its midpoint.
    pub along: [f64; 2],
}

fn midpoint(anchor_rad: f64, angle_rad: f64) -> (f64, [f64; 2]) {
    let swept_rad = angle_rad - anchor_rad;
    let (sin, cos) = (anchor_rad + 0.5 * swept_rad).sin_cos();
    (swept_rad.abs(), [cos, sin])
}

impl Track {
    /// Of the module at `place` of every report; reports that are out of order or not finite are left out. Its swim cycles start at
    /// `starts_s`, in order.
    #[must_use]
    pub fn new(reports: &[Tails], place: usize, starts_s: &[f64]) -> Self {
        let (mut t_s, mut angle_rad, mut rate_rad_s) = (Vec::new(), Vec::new(), Vec::new());
        for report in reports {
            let (Some(&angle), Some(&rate)) = (report.angle_rad.get(place), report.rate_rad_s.get(place))
            else {
                continue;
            };
            let is_new = t_s.last().is_none_or(|&last| report.t_s > last);
            if is_new && report.t_s.is_finite() && angle.is_finite() && rate.is_finite() {
                t_s.push(report.t_s);
                angle_rad.push(angle);
                rate_rad_s.push(rate);
            }
        }
        let mut track = Self { t_s, angle_rad, rate_rad_s, strokes: Vec::new(), dragged: Vec::new() };
        track.part(starts_s);
        track
    }

    /// Angle, speed and acceleration at `t_s`: rad, rad/s, rad/s².
    #[must_use]
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        let after = self.t_s.partition_point(|&t| t <= t_s);
        let (Some(before), true) = (after.checked_sub(1), after < self.t_s.len()) else {
            let end = if after == 0 { self.angle_rad.first() } else { self.angle_rad.last() };
            return [end.copied().unwrap_or_default(), 0.0, 0.0];
        };
        let span_s = self.t_s[after] - self.t_s[before];
        if span_s > REPORT_GAP_S {
            return [self.angle_rad[before], 0.0, 0.0];
        }
        let s = (t_s - self.t_s[before]) / span_s;
        // Cubic Hermite: φ(s) = φ₀ + s·m₀ + s²(3Δ − 2m₀ − m₁) + s³(m₀ + m₁ − 2Δ), m = rate·span
        let delta = self.angle_rad[after] - self.angle_rad[before];
        let (m0, m1) = (self.rate_rad_s[before] * span_s, self.rate_rad_s[after] * span_s);
        let (c2, c3) = (3.0 * delta - 2.0 * m0 - m1, m0 + m1 - 2.0 * delta);
        [
            self.angle_rad[before] + s * (m0 + s * (c2 + s * c3)),
            (m0 + s * (2.0 * c2 + s * 3.0 * c3)) / span_s,
            (2.0 * c2 + 6.0 * s * c3) / (span_s * span_s),
        ]
    }

    /// Parts the motion into strokes.
    fn part(&mut self, starts_s: &[f64]) {
        let (Some(&first_s), Some(&last_s)) = (self.t_s.first(), self.t_s.last()) else { return };
        let mut strokes = vec![Stroke { start_s: first_s, anchor_rad: self.at(first_s)[0], end_rad: 0.0 }];
        let (mut direction, mut turning, mut sum) = (0.0, None, 0.0);
        let steps = ((last_s - first_s) / STEP_S).ceil() as usize;
        let mut dragged = Vec::with_capacity(steps + 1);
        for step in 0..=steps {
            let t_s = first_s + STEP_S * step as f64;
            let [angle_rad, rate_rad_s, acceleration_rad_s2] = self.at(t_s);
            dragged.push(sum);
            sum += rate_rad_s * rate_rad_s.abs() * STEP_S;
            let next = starts_s.partition_point(|&start_s| start_s <= t_s - STEP_S);
            if starts_s.get(next).is_some_and(|&start_s| start_s <= t_s) && rate_rad_s.abs() < START_RAD_S {
                turning = Some((t_s, angle_rad));
            }
            if rate_rad_s.abs() < REST_RAD_S && rate_rad_s * acceleration_rad_s2 <= 0.0 {
                turning = Some((t_s, angle_rad));
                continue;
            }
            let unseen = (rate_rad_s * direction < 0.0).then_some((t_s, angle_rad));
            if let Some((start_s, anchor_rad)) = turning.take().or(unseen) {
                if let Some(last) = strokes.last_mut() {
                    last.end_rad = anchor_rad;
                }
                strokes.push(Stroke { start_s, anchor_rad, end_rad: anchor_rad });
            }
            direction = rate_rad_s.signum();
        }
        (self.strokes, self.dragged) = (strokes, dragged);
    }

    /// Strokes in order, each as it was at its end.
    pub fn past(&self) -> impl Iterator<Item = Past> + '_ {
        self.strokes.iter().map(|stroke| {
            let (sweep_rad, along) = midpoint(stroke.anchor_rad, stroke.end_rad);
            Past { sweep_rad, along }
        })
    }

    /// How the tail stands at `t_s`.
    #[must_use]
    pub fn instant(&self, t_s: f64) -> Instant {
        let [angle_rad, rate_rad_s, _] = self.at(t_s);
        let begun = self.strokes.partition_point(|stroke| stroke.start_s <= t_s);
        let past = begun.saturating_sub(1);
        let anchor_rad = self.strokes.get(past).map_or(angle_rad, |stroke| stroke.anchor_rad);
        let (sweep_rad, along) = if begun == 0 { (0.0, [1.0, 0.0]) } else { midpoint(anchor_rad, angle_rad) };
        let first_s = self.t_s.first().copied().unwrap_or_default();
        let place = ((t_s - first_s) / STEP_S).clamp(0.0, self.dragged.len().saturating_sub(1) as f64);
        let (low, share) = (place.floor(), place.fract());
        let of = |index: usize| self.dragged.get(index).or(self.dragged.last()).copied().unwrap_or_default();
        let (before, after) = (of(low as usize), of(low as usize + 1));
        Instant { past, sweep_rad, along, rate_rad_s, dragged: before + share * (after - before) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Waveform (1), reported at 50 Hz.
    fn waveform(centerline_rad: f64, amplitude_rad: f64, cycles: f64) -> Vec<Tails> {
        let omega = TAU / 1.5;
        (0..=(cycles * 75.0) as u32)
            .map(|step| {
                let t_s = 10.0 + f64::from(step) * 0.02;
                let (sin, cos) = (omega * (t_s - 10.0)).sin_cos();
                Tails {
                    t_s,
                    angle_rad: vec![centerline_rad + amplitude_rad * cos],
                    rate_rad_s: vec![-amplitude_rad * omega * sin],
                }
            })
            .collect()
    }

    #[test]
    fn a_cycle_gives_the_mean_of_the_law_against_its_centerline() {
        let (slope, ratio) = (0.022, 0.019 / 0.022);
        for (centerline_rad, amplitude_rad) in [(0.3, 1.2), (-2.0, -1.9), (4.0, 2.6)] {
            let track = Track::new(&waveform(centerline_rad, amplitude_rad, 4.0), 0, &[]);
            let past: Vec<Past> = track.past().collect();
            let impulse = |t_s: f64| {
                let now = track.instant(t_s);
                let one = |sweep: f64, along: [f64; 2]| along.map(|u| (0.5 * sweep - ratio).max(0.0) * u);
                let mut sum = one(now.sweep_rad, now.along);
                for stroke in past.iter().take(now.past) {
                    let more = one(stroke.sweep_rad, stroke.along);
                    sum = [sum[0] + more[0], sum[1] + more[1]];
                }
                sum.map(|part| -0.75 * slope * part)
            };
            // One whole period, wherever it begins in the swing.
            for from_s in [11.5, 11.9, 12.3] {
                let (before, after) = (impulse(from_s), impulse(from_s + 1.5));
                let mean = [0, 1].map(|k| (after[k] - before[k]) / 1.5);
                let law_n = 0.022 * f64::abs(amplitude_rad) - 0.019;
                let (sin, cos) = f64::sin_cos(centerline_rad);
                if from_s < 11.6 {
                    assert!((mean[0] + law_n * cos).abs() < 1e-3 * law_n.max(0.01), "{mean:?} {law_n}");
                    assert!((mean[1] + law_n * sin).abs() < 1e-3 * law_n.max(0.01), "{mean:?} {law_n}");
                }
                assert!(mean.iter().all(|part| part.is_finite()));
            }
        }
    }

    /// A turn of 0.9 rad, and after it a swing of 1.2 rad the same way: between two reports the tail has slowed to 1.5 rad/s at least, and
    /// whether it has stopped, only the plan says.
    #[test]
    fn a_start_by_plan_parts_a_stroke_in_two() {
        let reports: Vec<Tails> = (0..30)
            .map(|step| {
                let t_s = 0.01 + f64::from(step) * 0.02;
                let moves = (0.04..0.42).contains(&t_s);
                // 6 rad/s, less the half of a way of 20 ms about 0.2 s.
                let way_rad = 6.0 * (t_s.clamp(0.04, 0.42) - 0.04) - if t_s > 0.2 { 0.06 } else { 0.0 };
                Tails { t_s, angle_rad: vec![way_rad], rate_rad_s: vec![if moves { 6.0 } else { 0.0 }] }
            })
            .collect();
        let longest = |starts_s: &[f64]| {
            let track = Track::new(&reports, 0, starts_s);
            let now = track.instant(0.41);
            let past = track.past().take(now.past).map(|stroke| stroke.sweep_rad);
            past.chain([now.sweep_rad]).fold(0.0, f64::max)
        };
        assert!((longest(&[]) - 2.16).abs() < 0.1, "{}", longest(&[]));
        assert!((longest(&[0.2]) - 1.23).abs() < 0.1, "{}", longest(&[0.2]));
    }

    #[test]
    fn a_tail_between_reports_is_where_the_waveform_has_it_and_rests_over_a_gap() {
        let mut reports = waveform(0.5, 2.0, 2.0);
        let track = Track::new(&reports, 0, &[]);
        for step in 0..300 {
            let t_s = 10.0 + f64::from(step) * 0.01;
            let expected = 0.5 + 2.0 * (TAU / 1.5 * (t_s - 10.0)).cos();
            assert!((track.at(t_s)[0] - expected).abs() < 1e-4, "{t_s}");
        }
        reports.drain(50..80);
        let held = Track::new(&reports, 0, &[]);
        assert!((held.at(11.2)[0] - reports[49].angle_rad[0]).abs() < 1e-12 && held.at(11.2)[1] == 0.0);
        assert!(Track::new(&[], 0, &[]).at(3.0).iter().all(|&part| part == 0.0));
    }
}
