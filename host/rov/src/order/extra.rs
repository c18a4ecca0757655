//! What moves cost at least above their bounds because others rest at starts and in slots: by pairs, over every order.
//!
//! Of two robots one leaves first, and the other's place is still taken then. Of two slots one is filled last, and the other is taken by then.
//! With e(i, j) the least that i pays above its bound, to whatever slot, while j rests at its start, and e′(s, t) that of whatever robot into s
//! while t is filled,
//!
//! ```text
//! D(∅) = 0,    D(S) = min over i in S of  D(S∖i) + max over j in S∖i of e(i, j)          starts that are taken
//! D′(all) = 0, D′(F) = min over s not in F of  D′(F∪s) + max over t in F of e′(s, t)     slots that are filled
//! ```
//!
//! are paid at least above an assignment at the bounds; a detour may serve both, so the greater of the two counts. Without parking.

use super::MOST;

/// `[i][j]`, J or m.
pub type Pairs = [[f64; MOST]; MOST];

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Extra {
    pairs: [Pairs; 2],
    /// By the starts that are taken, and by the slots that are filled.
    sums: [Vec<f64>; 2],
    count: usize,
}

impl Extra {
    /// Of as many robots as slots.
    #[must_use]
    pub fn new(leaving: Pairs, filling: Pairs, count: usize) -> Self {
        let all = 1_usize << count;
        let mut sums = [vec![0.0; all], vec![0.0; all]];
        for taken in 1..all {
            let least = members(taken, count).map(|i| {
                let others = taken & !(1 << i);
                sums[0][others] + most(&leaving[i], others, count)
            });
            sums[0][taken] = least.fold(f64::INFINITY, f64::min);
        }
        for filled in (0..all - 1).rev() {
            let least = members(!filled & (all - 1), count)
                .map(|s| sums[1][filled | 1 << s] + most(&filling[s], filled, count));
            sums[1][filled] = least.fold(f64::INFINITY, f64::min);
        }
        Self { pairs: [leaving, filling], sums, count }
    }

    /// What is paid at least above the bounds from a state on.
    #[must_use]
    pub fn of(&self, taken: u32, filled: u32) -> f64 {
        self.sums[0][taken as usize].max(self.sums[1][filled as usize])
    }

    /// What one hop costs at least above its bound.
    #[must_use]
    pub fn of_hop(&self, (start, slot): (usize, usize), taken: u32, filled: u32) -> f64 {
        let others = taken as usize & !(1 << start);
        most(&self.pairs[0][start], others, self.count).max(most(
            &self.pairs[1][slot],
            filled as usize,
            self.count,
        ))
    }
}

fn members(set: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count).filter(move |k| set >> k & 1 == 1)
}

fn most(row: &[f64; MOST], set: usize, count: usize) -> f64 {
    members(set, count).map(|k| row[k]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_that_are_in_each_others_way_pay_the_lesser_detour_once() {
        let mut leaving = [[0.0; MOST]; MOST];
        (leaving[0][1], leaving[1][0]) = (5.0, 3.0);
        let mut filling = [[0.0; MOST]; MOST];
        (filling[0][1], filling[1][0], filling[2][0]) = (2.0, 4.0, 9.0);
        let extra = Extra::new(leaving, filling, 3);
        // Robot 1 leaves first; slot 2, then slot 1, then slot 0.
        assert!((extra.of(0b111, 0b000) - 3.0).abs() < 1e-12);
        assert!((extra.of(0b001, 0b000) - 2.0).abs() < 1e-12);
        assert!((extra.of(0b000, 0b001) - 13.0).abs() < 1e-12);
        assert!(extra.of(0b100, 0b111).abs() < 1e-12);
        assert!((extra.of_hop((0, 2), 0b011, 0b000) - 5.0).abs() < 1e-12);
        assert!((extra.of_hop((2, 2), 0b111, 0b001) - 9.0).abs() < 1e-12);
    }
}
