//! Exact shortest lengths on a map of cells by a visibility graph, and whether a path is one: no code of the searches.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Free and blocked cells, with what is needed to look along a row at once.
pub struct Cells {
    pub width: i64,
    pub height: i64,
    /// How many cells of a row are blocked before each x, by row.
    blocked_before: Vec<Vec<u32>>,
}

impl Cells {
    pub fn new(width: i64, height: i64, is_free: impl Fn(i64, i64) -> bool) -> Self {
        let row = |y: i64| {
            let blocked = (0..width).scan(0, |sum, x| {
                *sum += u32::from(!is_free(x, y));
                Some(*sum)
            });
            [0].into_iter().chain(blocked).collect()
        };
        Self { width, height, blocked_before: (0..height).map(row).collect() }
    }

    pub fn is_free(&self, x: i64, y: i64) -> bool {
        self.are_free(x, x + 1, y)
    }

    /// Whether the cells from x to before `end` in row y are all free.
    fn are_free(&self, x: i64, end: i64, y: i64) -> bool {
        x >= 0 && end <= self.width && (0..self.height).contains(&y) && {
            let row = &self.blocked_before[y as usize];
            row[end as usize] == row[x as usize]
        }
    }

    /// The four cells around a vertex: up left, up right, down left, down right.
    fn around(&self, [x, y]: [i64; 2]) -> [bool; 4] {
        [self.is_free(x - 1, y - 1), self.is_free(x, y - 1), self.is_free(x - 1, y), self.is_free(x, y)]
    }

    /// Two diagonal blocks meet there.
    fn is_pinch(&self, at: [i64; 2]) -> bool {
        matches!(self.around(at), [true, false, false, true] | [false, true, true, false])
    }

    /// Whether the straight leg is free. Of each row of cells that it passes, those that it passes inside are found from where
    /// it meets the lines above and below, in whole numbers.
    pub fn sees(&self, from: [i64; 2], to: [i64; 2]) -> bool {
        let ([x, y], [x_to, y_to]) = if from[1] <= to[1] { (from, to) } else { (to, from) };
        let (dx, dy) = (x_to - x, y_to - y);
        if dy == 0 {
            let (low, high) = (x.min(x_to), x.max(x_to));
            return (low..high).all(|x| self.is_free(x, y - 1) || self.is_free(x, y))
                && (low + 1..high).all(|x| !self.is_pinch([x, y]));
        }
        if dx == 0 {
            return (y..y_to).all(|y| self.is_free(x - 1, y) || self.is_free(x, y))
                && (y + 1..y_to).all(|y| !self.is_pinch([x, y]));
        }
        // dy times the x at which it meets line y + k, from x on.
        let meets = |k: i64| dx * k;
        (0..dy).all(|k| {
            let (low, high) = (meets(k).min(meets(k + 1)), meets(k).max(meets(k + 1)));
            self.are_free(x + low.div_euclid(dy), x - (-high).div_euclid(dy), y + k)
                && (k == 0 || meets(k) % dy != 0 || !self.is_pinch([x + meets(k) / dy, y + k]))
        })
    }

    /// The length of a path, if all its legs are free and it turns at no pinch.
    pub fn length(&self, path: &[[i64; 2]]) -> Option<f64> {
        let inner = path.get(1..path.len().saturating_sub(1)).unwrap_or_default();
        let is_path = inner.iter().all(|&at| !self.is_pinch(at))
            && path.windows(2).all(|leg| self.sees(leg[0], leg[1]));
        is_path.then(|| path.windows(2).map(|leg| distance(leg[0], leg[1])).sum())
    }
}

pub fn distance(from: [i64; 2], to: [i64; 2]) -> f64 {
    ((to[0] - from[0]) as f64).hypot((to[1] - from[1]) as f64)
}

/// The corners at which a shortest path may turn, and which of them see each other.
pub struct Visibility<'c> {
    cells: &'c Cells,
    pub corners: Vec<[i64; 2]>,
    seen: Vec<Vec<u32>>,
}

impl<'c> Visibility<'c> {
    pub fn new(cells: &'c Cells) -> Self {
        let all = (0..=cells.height).flat_map(|y| (0..=cells.width).map(move |x| [x, y]));
        // A turn needs an obstacle on its inside and nothing else.
        let turns = |at: &[i64; 2]| cells.around(*at).iter().filter(|&&free| free).count() == 3;
        let corners: Vec<_> = all.filter(turns).collect();
        let mut seen = vec![Vec::new(); corners.len()];
        for (k, &corner) in corners.iter().enumerate() {
            for (earlier, &other) in corners.iter().enumerate().take(k) {
                if cells.sees(corner, other) {
                    seen[k].push(earlier as u32);
                    seen[earlier].push(k as u32);
                }
            }
        }
        Self { cells, corners, seen }
    }

    /// The shortest length; infinite where there is no path. A* with the straight line for a bound.
    pub fn shortest(&self, start: [i64; 2], goal: [i64; 2]) -> f64 {
        let open = |at: [i64; 2]| self.cells.around(at).contains(&true);
        if start == goal || !open(start) || !open(goal) {
            return if start == goal { 0.0 } else { f64::INFINITY };
        }
        if self.cells.sees(start, goal) {
            return distance(start, goal);
        }
        let mut length = vec![f64::INFINITY; self.corners.len()];
        let mut least = f64::INFINITY;
        let mut queue = BinaryHeap::new();
        for (k, &corner) in self.corners.iter().enumerate() {
            if self.cells.sees(start, corner) {
                length[k] = distance(start, corner);
                queue.push((Reverse((length[k] + distance(corner, goal)).to_bits()), k, length[k].to_bits()));
            }
        }
        while let Some((Reverse(f), k, g)) = queue.pop() {
            let (f, g, corner) = (f64::from_bits(f), f64::from_bits(g), self.corners[k]);
            if f >= least {
                break;
            }
            if g > length[k] {
                continue;
            }
            if f < least && self.cells.sees(corner, goal) {
                least = f;
            }
            for &next in &self.seen[k] {
                let next = next as usize;
                let along = g + distance(corner, self.corners[next]);
                if along < length[next] {
                    length[next] = along;
                    queue.push((
                        Reverse((along + distance(self.corners[next], goal)).to_bits()),
                        next,
                        along.to_bits(),
                    ));
                }
            }
        }
        least
    }
}
