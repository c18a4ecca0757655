//! Preparation of curves: clipped to the window, thinned to what the eye can tell apart, averaged over a cycle.

/// A point on a picture, in the units of its axes.
pub type Point = (f64, f64);

/// An axis-parallel window that lines are clipped to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Left and right edge.
    pub x: (f64, f64),
    /// Lower and upper edge.
    pub y: (f64, f64),
}

/// The part of a segment inside the window (Liang and Barsky); `None` if nothing of it is.
#[must_use]
pub fn clip_segment(window: Window, a: Point, b: Point) -> Option<(Point, Point)> {
    if ![a.0, a.1, b.0, b.1].iter().all(|v| v.is_finite()) {
        return None;
    }
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (step, room) in
        [(-dx, a.0 - window.x.0), (dx, window.x.1 - a.0), (-dy, a.1 - window.y.0), (dy, window.y.1 - a.1)]
    {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step < 0.0 {
            enter = enter.max(room / step);
        } else {
            leave = leave.min(room / step);
        }
    }
    let at = |s: f64| (a.0 + s * dx, a.1 + s * dy);
    (enter <= leave).then(|| (at(enter), at(leave)))
}

/// The part of a polygon inside the window (Sutherland and Hodgman); empty if nothing of it is.
#[must_use]
pub fn clip_polygon(window: Window, polygon: &[Point]) -> Vec<Point> {
    /// Cuts with one half plane, given by the signed distance of a point from its edge.
    fn cut(polygon: &[Point], inside: impl Fn(Point) -> f64) -> Vec<Point> {
        let mut kept = Vec::with_capacity(polygon.len() + 2);
        let Some(&last) = polygon.last() else { return kept };
        let mut from = last;
        for &to in polygon {
            let (d_from, d_to) = (inside(from), inside(to));
            if (d_from < 0.0) != (d_to < 0.0) {
                let s = d_from / (d_from - d_to);
                kept.push((from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1)));
            }
            if d_to >= 0.0 {
                kept.push(to);
            }
            from = to;
        }
        kept
    }
    let polygon = cut(polygon, |p| p.0 - window.x.0);
    let polygon = cut(&polygon, |p| window.x.1 - p.0);
    let polygon = cut(&polygon, |p| p.1 - window.y.0);
    cut(&polygon, |p| window.y.1 - p.1)
}

/// Thins a curve over time to at most four points a column of the picture: the first, the least, the greatest and
/// the last, so that no peak is lost. Points must be in the order of their times; those not finite are left out.
#[must_use]
pub fn thin_series(points: &[Point], columns: usize) -> Vec<Point> {
    let finite: Vec<Point> = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    let columns = columns.max(1);
    let (Some(first), Some(last)) = (finite.first(), finite.last()) else { return finite };
    let width = (last.0 - first.0) / columns as f64;
    if finite.len() <= 4 * columns || width <= 0.0 {
        return finite;
    }
    let column = |p: &Point| ((p.0 - first.0) / width) as usize;
    let mut thin = Vec::new();
    for chunk in finite.chunk_by(|a, b| column(a) == column(b)) {
        let by_value = |a: &(usize, &Point), b: &(usize, &Point)| a.1.1.total_cmp(&b.1.1);
        let lowest = chunk.iter().enumerate().min_by(by_value).map_or(0, |(i, _)| i);
        let highest = chunk.iter().enumerate().max_by(by_value).map_or(0, |(i, _)| i);
        let mut kept = [0, lowest, highest, chunk.len() - 1];
        kept.sort_unstable();
        let mut before = None;
        for index in kept {
            if before != Some(index) {
                thin.extend(chunk.get(index));
            }
            before = Some(index);
        }
    }
    thin
}

/// Thins a path in the plane: leaves out points nearer than `distance` to the one before; keeps both ends.
#[must_use]
pub fn thin_path(points: &[Point], distance: f64) -> Vec<Point> {
    let mut thin: Vec<Point> = Vec::new();
    let finite: Vec<Point> = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    for (index, &point) in finite.iter().enumerate() {
        let far = thin.last().is_none_or(|&p| (p.0 - point.0).hypot(p.1 - point.1) >= distance);
        if far || index + 1 == finite.len() {
            thin.push(point);
        }
    }
    thin
}

/// The mean of a curve over a window of `width` seconds centred on each point, for those points that have the whole
/// window around them: half of one would show the stroke, not the mean.
#[must_use]
pub fn moving_mean(points: &[Point], width: f64) -> Vec<Point> {
    let finite: Vec<Point> = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    // A sample on both edges of the window would count one instant of the stroke twice.
    let half = 0.5 * width - 1e-9;
    let mut sums = Vec::with_capacity(finite.len() + 1);
    let mut sum = 0.0;
    sums.push(0.0);
    for point in &finite {
        sum += point.1;
        sums.push(sum);
    }
    let (Some(first), Some(last)) = (finite.first(), finite.last()) else { return finite };
    finite
        .iter()
        .filter(|p| first.0 <= p.0 - half && p.0 + half <= last.0)
        .filter_map(|&(t, _)| {
            let low = finite.partition_point(|p| p.0 < t - half - 2e-9);
            let high = finite.partition_point(|p| p.0 < t + half);
            let sum = sums.get(high)? - sums.get(low)?;
            (high > low).then(|| (t, sum / (high - low) as f64))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Window = Window { x: (0.0, 1.0), y: (0.0, 1.0) };

    #[test]
    fn segments_are_cut_at_the_edges() {
        assert_eq!(clip_segment(UNIT, (-1.0, 0.5), (2.0, 0.5)), Some(((0.0, 0.5), (1.0, 0.5))));
        assert_eq!(clip_segment(UNIT, (0.2, 0.2), (0.8, 0.4)), Some(((0.2, 0.2), (0.8, 0.4))));
        assert_eq!(clip_segment(UNIT, (-1.0, 0.5), (0.5, 2.0)), None);
        assert_eq!(clip_segment(UNIT, (1.5, 0.0), (1.5, 1.0)), None);
        assert_eq!(clip_segment(UNIT, (f64::NAN, 0.0), (0.5, 0.5)), None);
    }

    #[test]
    fn a_polygon_keeps_the_area_it_has_inside() {
        // Diamond of half diagonal 1 around a corner: a triangle with legs 1 is inside.
        let diamond = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        let inside = clip_polygon(UNIT, &diamond);
        let area: f64 = (0..inside.len())
            .map(|i| {
                let (a, b) = (inside[i], inside[(i + 1) % inside.len()]);
                0.5 * (a.0 * b.1 - b.0 * a.1)
            })
            .sum();
        assert!((area.abs() - 0.5).abs() < 1e-12, "area {area}");
        assert!(clip_polygon(UNIT, &[(2.0, 2.0), (3.0, 2.0), (3.0, 3.0)]).is_empty());
    }

    #[test]
    fn thinning_keeps_peaks_and_order() {
        let mut points: Vec<Point> =
            (0..50_000).map(|i| (f64::from(i) * 0.02, (f64::from(i) * 0.1).sin())).collect();
        points[31_234].1 = 9.0;
        points[777].1 = f64::NAN;
        let thin = thin_series(&points, 300);
        assert!(thin.len() <= 4 * 301, "{} points", thin.len());
        assert!(thin.is_sorted_by(|a, b| a.0 < b.0));
        assert!(thin.contains(&points[31_234]), "the peak is lost");
        assert_eq!(thin.last(), points.last());
        let path = thin_path(&[(0.0, 0.0), (0.1, 0.0), (1.0, 0.0), (1.05, 0.0)], 0.5);
        assert_eq!(path, [(0.0, 0.0), (1.0, 0.0), (1.05, 0.0)]);
    }

    #[test]
    fn the_mean_over_a_period_removes_a_sine_and_keeps_a_slope() {
        let points: Vec<Point> = (0..=2000)
            .map(|i| f64::from(i) * 0.01)
            .map(|t| (t, 0.3 * t + (std::f64::consts::TAU * t / 2.0).sin()))
            .collect();
        let means = moving_mean(&points, 2.0);
        assert!((means[0].0 - 1.0).abs() < 0.02 && (means[means.len() - 1].0 - 19.0).abs() < 0.02);
        for (t, mean) in means {
            assert!((mean - 0.3 * t).abs() < 0.005, "at {t} s: {mean}");
        }
        assert!(moving_mean(&[], 2.0).is_empty());
    }
}
