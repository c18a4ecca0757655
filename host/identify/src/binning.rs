//! Measured poses averaged in bins.
//!
//! Fixes come at 120 Hz or more and are averaged over [`BIN_S`]: the mean stamp, the mean pose, and how many they were. A structure of
//! Modboats wobbles at the swim frequency (0.67 Hz) and at twice that, which bins of 40 ms leave as it is; noise of a mean of n is 1/√n of
//! that of a fix.

use quantity::wrap_rad;

/// Width of a bin, s.
pub(crate) const BIN_S: f64 = 0.04;
/// Poses are not joined over a pause longer than this, s. *Assumed*.
const PAUSE_S: f64 = 1.0;

/// The mean of some fixes of N coordinates, of which the last one is a heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bin<const N: usize> {
    /// As stamped, s.
    pub t_s: f64,
    /// Place, m, and heading, unwrapped, rad.
    pub pose: [f64; N],
    /// How many.
    pub count: f64,
    /// Nothing is joined to what was before.
    pub begins: bool,
}

/// Means of `fixes` (stamp, s, and pose) over [`BIN_S`]; none is joined over a gap or a pause. A stamp that is not after the last is
/// dropped.
pub(crate) fn bins<const N: usize>(
    fixes: impl Iterator<Item = (f64, [f64; N])>,
    gaps: &[[f64; 2]],
) -> Vec<Bin<N>> {
    let mut bins: Vec<Bin<N>> = Vec::new();
    let mut sum: Option<(f64, Bin<N>)> = None;
    let mut last: Option<(f64, f64)> = None;
    let mut heading_rad = 0.0;
    let close = |bins: &mut Vec<Bin<N>>, sum: &mut Option<(f64, Bin<N>)>| {
        if let Some((_, mut bin)) = sum.take() {
            let share = 1.0 / bin.count;
            (bin.t_s, bin.pose) = (bin.t_s * share, bin.pose.map(|part| part * share));
            bins.push(bin);
        }
    };
    for (t_s, mut pose) in fixes {
        let measured_rad = pose[N - 1];
        let apart = last.is_none_or(|(last_s, _)| {
            let gap = gaps.iter().any(|&[from, to]| last_s < to && from < t_s);
            gap || t_s - last_s > PAUSE_S
        });
        if last.is_some_and(|(last_s, _)| t_s <= last_s) {
            continue;
        }
        heading_rad += last.map_or(measured_rad, |(_, last_rad)| wrap_rad(measured_rad - last_rad));
        last = Some((t_s, measured_rad));
        if apart || sum.as_ref().is_some_and(|(from_s, _)| t_s - from_s >= BIN_S - 1e-6) {
            close(&mut bins, &mut sum);
        }
        pose[N - 1] = heading_rad;
        let (_, bin) = sum.get_or_insert((t_s, Bin { t_s: 0.0, pose: [0.0; N], count: 0.0, begins: apart }));
        bin.t_s += t_s;
        bin.pose.iter_mut().zip(pose).for_each(|(sum, part)| *sum += part);
        bin.count += 1.0;
    }
    close(&mut bins, &mut sum);
    bins
}

/// Time from one bin to before another, s.
pub(crate) fn span_s<const N: usize>(bins: &[Bin<N>], from: usize, to: usize) -> f64 {
    let times = bins.get(from..to).unwrap_or_default();
    match (times.first(), times.last()) {
        (Some(first), Some(last)) => last.t_s - first.t_s,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(t_s: f64, x: f64, heading_rad: f64) -> (f64, [f64; 3]) {
        (t_s, [x, -x, wrap_rad(heading_rad)])
    }

    #[test]
    fn bins_are_means_and_headings_go_on_over_the_cut() {
        let made = bins((0..120).map(|n| f64::from(n) / 120.0).map(|t_s| fix(t_s, t_s, 3.0 + t_s)), &[]);
        assert!((made.iter().map(|bin| bin.count).sum::<f64>() - 120.0).abs() < 1e-9);
        for bin in &made {
            assert!((bin.pose[0] - bin.t_s).abs() < 1e-12 && (bin.pose[2] - 3.0 - bin.t_s).abs() < 1e-12);
        }
        assert!(made[0].begins && made.iter().skip(1).all(|bin| !bin.begins));
    }

    #[test]
    fn nothing_is_joined_over_a_gap_or_a_pause_and_stale_fixes_are_dropped() {
        let fixes = [fix(0.0, 0.0, 0.0), fix(0.01, 0.0, 0.0), fix(0.005, 9.0, 0.0), fix(2.0, 0.0, 0.0)];
        let made = bins(fixes.into_iter(), &[]);
        assert_eq!(made.iter().map(|bin| bin.begins).collect::<Vec<_>>(), [true, true]);
        assert!(made[0].pose[0].abs() < 1e-12 && (made[0].count - 2.0).abs() < 1e-9);
        let gapped = bins([fix(0.0, 0.0, 0.0), fix(0.1, 0.0, 0.0)].into_iter(), &[[0.02, 0.09]]);
        assert!(gapped[1].begins);
    }
}
