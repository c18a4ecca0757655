//! One log made ready: fixes averaged in bins, tails in strokes.

use super::binning::{self, Bin, bins};
use super::constants::Values;
use super::data::{Boat, Recording};
use super::strokes::{Instant, Past, Track};

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// East, north (m) and Θ (rad).
    pub bins: Vec<Bin<3>>,
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
            bins: bins(
                fixes.map(|fix| (fix.t_s, [fix.position_m[0], fix.position_m[1], fix.heading_rad])),
                &recording.gaps,
            ),
            tracks,
            past,
            positions_m: boat.structure.positions_m(boat.belief.pitch_m),
            half_period_s: 0.5 * boat.belief.period_s,
        }
    }

    /// Time from one bin to before another, s.
    pub(crate) fn span_s(&self, from: usize, to: usize) -> f64 {
        binning::span_s(&self.bins, from, to)
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
