//! A path along edges with straight legs where they are free: what Theta* is compared with.

use super::{ROUNDING, Space};

/// The smoothing that A* is compared with (A* PS in \[1\] of [`theta`](super)): from each vertex kept, on to the last one in a row that a free
/// leg reaches, unless that leg costs more than what it replaces.
#[must_use]
pub fn smooth(space: &impl Space, path: &[usize]) -> Vec<usize> {
    let (Some(&first), Some(&last)) = (path.first(), path.last()) else { return Vec::new() };
    let mut kept = vec![first];
    let (mut earlier, mut anchor) = (first, first);
    // Cost from the anchor to the vertex before, the turn at the anchor included.
    let mut so_far = 0.0;
    for pair in path.windows(2) {
        let [before, next] = [pair[0], pair[1]];
        let step = space.leg(before, next).unwrap_or(f64::INFINITY);
        let step = step + space.turn(if before == anchor { earlier } else { anchor }, before, next);
        let limit = (so_far + step) * (1.0 + ROUNDING);
        let direct = space.leg(anchor, next).map(|leg| leg + space.turn(earlier, anchor, next));
        match direct.filter(|&direct| direct <= limit) {
            Some(direct) => so_far = direct,
            None => {
                kept.push(before);
                (earlier, anchor) = (anchor, before);
                so_far = step;
            }
        }
    }
    if path.len() > 1 {
        kept.push(last);
    }
    kept
}
