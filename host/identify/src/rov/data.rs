//! What constants of an ROV are identified from: poses and thrusts of one that swims alone.

use std::collections::BTreeMap;

use quantity::wrap_rad;

use super::super::binning::{Bin, bins};

/// Roll and pitch are lines through the poses of this time either way, s. *Assumed*: a robot rolls and pitches with a second or more.
const LEVELLED_S: f64 = 0.1;

/// A pose, north-east-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// When it was captured, fleet time, s.
    pub t_s: f64,
    /// North, east, down, m.
    pub position_m: [f64; 3],
    /// Roll, pitch, yaw (ZYX), (−π, π], rad.
    pub attitude_rad: [f64; 3],
}

/// What every thruster gave at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Thrusts {
    /// Fleet time, s.
    pub t_s: f64,
    /// Along each thruster's axis, in the order of the vehicle, N.
    pub thrusts_n: Vec<f64>,
}

/// A robot that swims alone, docked to nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Swim {
    /// Its number.
    pub robot: u16,
    /// In the order of their times.
    pub poses: Vec<Pose>,
    /// In the order of their times; between two they are taken to change evenly.
    pub thrusts: Vec<Thrusts>,
}

/// What robots of one kind did in one log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// What it is called in messages.
    pub name: String,
    /// One after the other, or side by side.
    pub swims: Vec<Swim>,
}

/// How a robot is tilted, as it was measured: no state of the filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tilt {
    pub roll_rad: f64,
    pub pitch_rad: f64,
    /// p and q, body, rad/s.
    pub rates_rad_s: [f64; 2],
}

impl Tilt {
    /// At `t_s`, by lines through the poses around; level where there are none.
    fn of(poses: &[Pose], t_s: f64) -> Self {
        let from = poses.partition_point(|pose| pose.t_s < t_s - LEVELLED_S);
        let to = poses.partition_point(|pose| pose.t_s <= t_s + LEVELLED_S);
        let near = poses.get(from..to).unwrap_or_default();
        let Some(first) = near.first() else { return Self::default() };
        let count = near.len() as f64;
        let mean_s = near.iter().map(|pose| pose.t_s - t_s).sum::<f64>() / count;
        let spread: f64 = near.iter().map(|pose| (pose.t_s - t_s - mean_s).powi(2)).sum();
        let [roll, pitch, yaw] = [0, 1, 2].map(|axis| {
            let angle = |pose: &Pose| wrap_rad(pose.attitude_rad[axis] - first.attitude_rad[axis]);
            let mean = near.iter().map(angle).sum::<f64>() / count;
            let along: f64 = near.iter().map(|pose| (pose.t_s - t_s - mean_s) * angle(pose)).sum();
            let rate = if spread > 1e-9 { along / spread } else { 0.0 };
            (first.attitude_rad[axis] + mean - rate * mean_s, rate)
        });
        // p = φ̇ − ψ̇·sin θ,   q = θ̇·cos φ + ψ̇·sin φ·cos θ
        let p = roll.1 - yaw.1 * pitch.0.sin();
        let q = pitch.1 * roll.0.cos() + yaw.1 * roll.0.sin() * pitch.0.cos();
        Self { roll_rad: roll.0, pitch_rad: pitch.0, rates_rad_s: [p, q] }
    }
}

/// Swims made ready: poses in bins, thrusts as impulses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Prepared {
    /// North, east, down, yaw.
    pub bins: Vec<Bin<4>>,
    /// Of each bin: which impulse is its swim's.
    swim: Vec<usize>,
    impulses: Vec<Impulse>,
    /// In the middle of the two halves of the time to each bin.
    pub tilts: Vec<[Tilt; 2]>,
}

/// ∫F dt of every thruster up to each instant at which F is known.
#[derive(Clone, Debug, Default)]
struct Impulse {
    t_s: Vec<f64>,
    /// Row by row, a row an instant.
    thrusts_n: Vec<f64>,
    sum_n_s: Vec<f64>,
}

impl Impulse {
    fn new(swim: &Swim, thrusters: usize) -> Self {
        let mut impulse = Self::default();
        let mut sum = vec![0.0; thrusters];
        // By time in µs: what was told twice counts once.
        let known: BTreeMap<u64, &Thrusts> =
            swim.thrusts.iter().map(|known| ((known.t_s.max(0.0) * 1e6) as u64, known)).collect();
        for known in known.into_values().filter(|known| known.thrusts_n.len() == thrusters) {
            if let Some(&before_s) = impulse.t_s.last() {
                let last = &impulse.thrusts_n[impulse.thrusts_n.len() - thrusters..];
                for ((sum, before), now) in sum.iter_mut().zip(last).zip(&known.thrusts_n) {
                    *sum += 0.5 * (before + now) * (known.t_s - before_s);
                }
            }
            impulse.t_s.push(known.t_s);
            impulse.thrusts_n.extend(&known.thrusts_n);
            impulse.sum_n_s.extend(&sum);
        }
        impulse
    }

    /// What was given up to `t_s` is written to `into`: before the first and after the last instant a thrust stays.
    fn until(&self, t_s: f64, into: &mut [f64]) {
        let n = into.len();
        let after = self.t_s.partition_point(|&known_s| known_s <= t_s);
        let row = after.saturating_sub(1);
        let Some(&from_s) = self.t_s.get(row) else { return };
        let now = &self.thrusts_n[row * n..(row + 1) * n];
        let next = self.t_s.get(row + 1).filter(|_| t_s >= from_s);
        let past_s = t_s - from_s;
        for (thruster, into) in into.iter_mut().enumerate() {
            let rise = next.map_or(0.0, |next_s| {
                (self.thrusts_n[(row + 1) * n + thruster] - now[thruster]) / (next_s - from_s)
            });
            *into = self.sum_n_s[row * n + thruster] + past_s * (now[thruster] + 0.5 * past_s * rise);
        }
    }
}

impl Prepared {
    pub(crate) fn new(recording: &Recording, thrusters: usize) -> Self {
        let mut prepared = Self::default();
        for swim in &recording.swims {
            let impulse = Impulse::new(swim, thrusters);
            let (Some(&first_s), Some(&last_s)) = (impulse.t_s.first(), impulse.t_s.last()) else { continue };
            let known = swim.poses.iter().filter(|pose| {
                let finite = pose.position_m.iter().chain(&pose.attitude_rad).all(|x| x.is_finite());
                finite && (first_s..=last_s).contains(&pose.t_s)
            });
            let known: Vec<Pose> = known.copied().collect();
            let of = |pose: &Pose| {
                let [north, east, down] = pose.position_m;
                (pose.t_s, [north, east, down, pose.attitude_rad[2]])
            };
            let own = bins(known.iter().map(of), &[]);
            let mut before_s = own.first().map_or(0.0, |bin| bin.t_s);
            for bin in &own {
                let at = |share: f64| Tilt::of(&known, before_s + share * (bin.t_s - before_s));
                prepared.tilts.push([at(0.25), at(0.75)]);
                before_s = bin.t_s;
            }
            prepared.swim.extend(std::iter::repeat_n(prepared.impulses.len(), own.len()));
            prepared.bins.extend(own);
            prepared.impulses.push(impulse);
        }
        prepared
    }

    /// How long the swims are together, of the bins from one to before another, s.
    pub(crate) fn span_s(&self, from: usize, to: usize) -> f64 {
        let pairs = self.bins.get(from..to).unwrap_or_default().windows(2);
        pairs.filter(|pair| !pair[1].begins).map(|pair| pair[1].t_s - pair[0].t_s).sum()
    }

    /// Mean thrusts over the two halves of the time to each bin, if the water feels them `delay_s` late: thruster by thruster, N.
    pub(crate) fn halves(&self, thrusters: usize, delay_s: f64) -> Vec<f64> {
        let mut means = vec![0.0; 2 * thrusters * self.bins.len()];
        let mut sums = vec![vec![0.0; thrusters]; 3];
        for (index, (pair, into)) in
            self.bins.windows(2).zip(means.chunks_exact_mut(2 * thrusters).skip(1)).enumerate()
        {
            let [before, now] = pair else { continue };
            if now.begins {
                continue;
            }
            let impulse = &self.impulses[self.swim[index + 1]];
            let half_s = 0.5 * (before.t_s + now.t_s);
            for (sum, t_s) in sums.iter_mut().zip([before.t_s, half_s, now.t_s]) {
                impulse.until(t_s - delay_s, sum);
            }
            let scale = 2.0 / (now.t_s - before.t_s);
            for thruster in 0..thrusters {
                into[thruster] = scale * (sums[1][thruster] - sums[0][thruster]);
                into[thrusters + thruster] = scale * (sums[2][thruster] - sums[1][thruster]);
            }
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_are_integrals_of_thrusts_that_change_evenly() {
        let thrusts = [(1.0, 2.0), (2.0, 4.0), (4.0, 0.0)];
        let thrusts = thrusts.map(|(t_s, n)| Thrusts { t_s, thrusts_n: vec![n, -n] }).to_vec();
        let impulse = Impulse::new(&Swim { thrusts, ..Swim::default() }, 2);
        // ∫ from 1: 2t + t² in the first, 3 + 4t − t² in the second; before and after a thrust stays.
        for (t_s, sum) in
            [(0.5, -1.0), (1.0, 0.0), (1.5, 1.25), (2.0, 3.0), (3.0, 6.0), (4.0, 7.0), (5.0, 7.0)]
        {
            let mut into = [0.0; 2];
            impulse.until(t_s, &mut into);
            assert!((into[0] - sum).abs() < 1e-12 && (into[1] + sum).abs() < 1e-12, "{t_s}: {into:?}");
        }
    }
}
