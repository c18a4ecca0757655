//! One log made ready: fixes averaged in bins, tails in strokes.
//!
//! Fixes come at 120 Hz or more and are averaged over [`BIN_S`]: the mean stamp, the mean pose, and how many they were. The structure
//! wobbles at the swim frequency (0.67 Hz) and at twice that, which bins of 40 ms leave as it is; noise of a mean of n is 1/√n of that of a
//! fix.

use modboat::observer::Fix;
use quantity::wrap_rad;

use super::constants::Values;
use super::data::{Boat, Recording};
use super::strokes::{Instant, Past, Track};

/// Width of a bin, s.
pub(crate) const BIN_S: f64 = 0.04;
/// Poses are not joined over a pause longer than this, s. *Assumed*.
const PAUSE_S: f64 = 1.0;

/// The mean of some fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bin {
    /// As stamped, s.
    pub t_s: f64,
    /// x, y and Θ, unwrapped: m, m, rad.
    pub pose: [f64; 3],
    /// How many.
    pub count: f64,
    /// Nothing is joined to what was before.
    pub begins: bool,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub bins: Vec<Bin>,
    tracks: Vec<Track>,
    past: Vec<Vec<Past>>,
    positions_m: Vec<[f64; 2]>,
    half_period_s: f64,
}

/// Impulse up to an instant: sway, surge, N·s, and yaw, N·m·s, about the centre.
pub(crate) type Impulse = [f64; 3];

/// Instants for each bin: half way from the one before, and its own.
pub(crate) const PER_BIN: usize = 2;

impl Prepared {
    pub(crate) fn new(boat: &Boat, recording: &Recording) -> Self {
        let starts_s: Vec<f64> = recording.cycles.iter().map(|cycle| cycle.start_s).collect();
        let tracks: Vec<Track> =
            (0..boat.modules()).map(|place| Track::new(&recording.tails, place, &starts_s)).collect();
        let past = tracks.iter().map(|track| track.past().collect()).collect();
        // Only while tails were reported.
        let known = match (recording.tails.first(), recording.tails.last()) {
            (Some(first), Some(last)) => first.t_s..=last.t_s,
            _ => 0.0..=f64::NEG_INFINITY,
        };
        let fixes = recording.fixes.iter().filter(|fix| {
            let finite = fix.position_m.iter().all(|x| x.is_finite()) && fix.heading_rad.is_finite();
            finite && known.contains(&fix.t_s)
        });
        Self {
            bins: bins(fixes, &recording.gaps),
            tracks,
            past,
            positions_m: boat.structure.positions_m(boat.belief.pitch_m),
            half_period_s: 0.5 * boat.belief.period_s,
        }
    }

    /// Time from one bin to before another, s.
    pub(crate) fn span_s(&self, from: usize, to: usize) -> f64 {
        let times = self.bins.get(from..to).unwrap_or_default();
        match (times.first(), times.last()) {
            (Some(first), Some(last)) => last.t_s - first.t_s,
            _ => 0.0,
        }
    }

    /// How each tail stood half way to and at each bin, whose stamps are `latency_s` late, by module.
    pub(crate) fn instants(&self, latency_s: f64) -> Vec<Vec<Instant>> {
        let mut times_s = Vec::with_capacity(PER_BIN * self.bins.len());
        let mut before_s = self.bins.first().map_or(0.0, |bin| bin.t_s);
        for bin in &self.bins {
            times_s.extend([0.5 * (before_s + bin.t_s) - latency_s, bin.t_s - latency_s]);
            before_s = bin.t_s;
        }
        let of = |track: &Track| times_s.iter().map(|&t_s| track.instant(t_s)).collect();
        self.tracks.iter().map(of).collect()
    }

    /// What all tails have given up to each of these instants, by (i1), with reaction and drag of every tail about its motor axis:
    ///
    /// L = Σ (xᵢ·P_yᵢ − yᵢ·P_xᵢ) − Σ J·φ̇ᵢ − Σ c·∫φ̇ᵢ|φ̇ᵢ| dt                                            (i2)
    pub(crate) fn impulses(&self, values: &Values, instants: &[Vec<Instant>]) -> Vec<Impulse> {
        let mut sums = vec![[0.0; 3]; PER_BIN * self.bins.len()];
        for (module, (instants, past)) in instants.iter().zip(&self.past).enumerate() {
            let scale = -self.half_period_s * values.slope_n_rad.get(module).copied().unwrap_or_default();
            let [x_m, y_m] = self.positions_m[module];
            let push = |sweep_rad: f64, along: [f64; 2]| {
                let open = scale * (0.5 * sweep_rad - values.ratio_rad).max(0.0);
                along.map(|u| open * u)
            };
            let (mut done, mut strokes) = ([0.0; 2], 0);
            for (sum, now) in sums.iter_mut().zip(instants) {
                while strokes < now.past {
                    if let Some(stroke) = past.get(strokes) {
                        let [x, y] = push(stroke.sweep_rad, stroke.along);
                        done = [done[0] + x, done[1] + y];
                    }
                    strokes += 1;
                }
                let [x, y] = push(now.sweep_rad, now.along);
                let [x, y] = [done[0] + x, done[1] + y];
                let turn =
                    x_m * y - y_m * x - values.rotor_kg_m2 * now.rate_rad_s - values.tail_drag * now.dragged;
                *sum = [sum[0] + x, sum[1] + y, sum[2] + turn];
            }
        }
        sums
    }
}

/// Means of `fixes` over [`BIN_S`]; none is joined over a gap or a pause.
fn bins<'a>(fixes: impl Iterator<Item = &'a Fix>, gaps: &[[f64; 2]]) -> Vec<Bin> {
    let mut bins: Vec<Bin> = Vec::new();
    let mut sum: Option<(f64, Bin)> = None;
    let mut last: Option<Fix> = None;
    let mut heading_rad = 0.0;
    let close = |bins: &mut Vec<Bin>, sum: &mut Option<(f64, Bin)>| {
        if let Some((_, mut bin)) = sum.take() {
            let share = 1.0 / bin.count;
            (bin.t_s, bin.pose) = (bin.t_s * share, bin.pose.map(|part| part * share));
            bins.push(bin);
        }
    };
    for fix in fixes {
        let apart = last.is_none_or(|last| {
            let gap = gaps.iter().any(|&[from, to]| last.t_s < to && from < fix.t_s);
            gap || fix.t_s - last.t_s > PAUSE_S
        });
        if last.is_some_and(|last| fix.t_s <= last.t_s) {
            continue;
        }
        let turned_rad = last.map_or(fix.heading_rad, |last| wrap_rad(fix.heading_rad - last.heading_rad));
        heading_rad += turned_rad;
        last = Some(*fix);
        if apart || sum.as_ref().is_some_and(|(from_s, _)| fix.t_s - from_s >= BIN_S - 1e-6) {
            close(&mut bins, &mut sum);
        }
        let pose = [fix.position_m[0], fix.position_m[1], heading_rad];
        let (_, bin) =
            sum.get_or_insert((fix.t_s, Bin { t_s: 0.0, pose: [0.0; 3], count: 0.0, begins: apart }));
        bin.t_s += fix.t_s;
        bin.pose = [0, 1, 2].map(|axis| bin.pose[axis] + pose[axis]);
        bin.count += 1.0;
    }
    close(&mut bins, &mut sum);
    bins
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(t_s: f64, x: f64, heading_rad: f64) -> Fix {
        Fix { t_s, position_m: [x, -x], heading_rad: wrap_rad(heading_rad) }
    }

    #[test]
    fn bins_are_means_and_headings_go_on_over_the_cut() {
        let fixes: Vec<Fix> =
            (0..120).map(|n| f64::from(n) / 120.0).map(|t_s| fix(t_s, t_s, 3.0 + t_s)).collect();
        let made = bins(fixes.iter(), &[]);
        assert!((made.iter().map(|bin| bin.count).sum::<f64>() - 120.0).abs() < 1e-9);
        for bin in &made {
            assert!((bin.pose[0] - bin.t_s).abs() < 1e-12 && (bin.pose[2] - 3.0 - bin.t_s).abs() < 1e-12);
        }
        assert!(made[0].begins && made.iter().skip(1).all(|bin| !bin.begins));
    }

    #[test]
    fn nothing_is_joined_over_a_gap_or_a_pause_and_stale_fixes_are_dropped() {
        let fixes = [fix(0.0, 0.0, 0.0), fix(0.01, 0.0, 0.0), fix(0.005, 9.0, 0.0), fix(2.0, 0.0, 0.0)];
        let made = bins(fixes.iter(), &[]);
        assert_eq!(made.iter().map(|bin| bin.begins).collect::<Vec<_>>(), [true, true]);
        assert!(made[0].pose[0].abs() < 1e-12 && (made[0].count - 2.0).abs() < 1e-9);
        let gapped = bins([fix(0.0, 0.0, 0.0), fix(0.1, 0.0, 0.0)].iter(), &[[0.02, 0.09]]);
        assert!(gapped[1].begins);
    }
}
