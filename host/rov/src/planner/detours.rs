//! What a robot pays more than in open water because of one other: the pairs of [`Extra`].

use std::sync::{Mutex, PoisonError};

use super::super::order::extra::{Extra, Pairs};
use super::super::order::{DESKS, Hop, Layout, MOST, Workers};
use super::pricer::Pricer;

/// Fewest robots that it is worked out for: for fewer all orders are soon looked at.
const LEAST: usize = 6;

/// A share of the bound that is no detour.
const ROUNDING: f64 = 1e-6;

/// Its number, and what is paid for every other one.
type Row = (usize, [f64; MOST]);

impl Pricer<'_> {
    /// By pairs of starts and pairs of slots; `None` where robots may park, for few robots, and for several vehicles.
    pub(super) fn detours(&self, workers: &dyn Workers) -> Option<Extra> {
        let layout = &self.layout;
        let count = layout.robots();
        let is_asked = count >= LEAST && count == layout.slots() && layout.moves() == 1;
        if !is_asked || !self.places.has_one_vehicle() {
            return None;
        }
        let found: Vec<Mutex<Vec<Row>>> = (0..DESKS).map(|_| Mutex::default()).collect();
        workers.run(DESKS, &|desk| {
            let rows = (0..2 * count).skip(desk).step_by(DESKS);
            let rows = rows.map(|row| (row, self.row(desk, row, count, layout))).collect();
            *found[desk].lock().unwrap_or_else(PoisonError::into_inner) = rows;
        });
        self.routes.share();
        let mut pairs: [Pairs; 2] = [[[0.0; MOST]; MOST]; 2];
        for rows in found {
            for (row, extra) in rows.into_inner().unwrap_or_else(PoisonError::into_inner) {
                pairs[row / count][row % count] = extra;
            }
        }
        let [leaving, filling] = pairs;
        Some(Extra::new(leaving, filling, count))
    }

    /// Of one robot at its start, or of one slot, for every other one.
    fn row(&self, desk: usize, row: usize, count: usize, layout: &Layout) -> [f64; MOST] {
        let (side, own) = (row / count * count, row % count);
        let mut extra = [0.0; MOST];
        for other in (0..count).filter(|&other| other != own) {
            let body = self.places.seat(side + other, layout.kind(0));
            let mut least = f64::INFINITY;
            for end in 0..count {
                let (start, slot) = if side == 0 { (own, end) } else { (end, own) };
                let hop = Hop::new(start, count + slot);
                least = least.min(self.detour(desk, hop, layout.kind(start), body));
                if least == 0.0 {
                    break;
                }
            }
            extra[other] = least;
        }
        extra
    }

    /// What a hop costs above its bound while this seat is taken.
    fn detour(&self, desk: usize, hop: Hop, kind: u8, body: usize) -> f64 {
        let (from, to) = hop.ends();
        let Some(bound) = self.bound_of(from, kind, to) else { return f64::INFINITY };
        if self.stays(hop) {
            return 0.0;
        }
        (self.cost_beside(desk, hop, kind, body) - (1.0 + ROUNDING) * bound).max(0.0)
    }
}
