//! What a robot pays more than in open water because of one other: the pairs of [`Extra`].

use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use super::super::order::extra::{Extra, Pair, taken};
use super::super::order::{DESKS, GoesOn, Hop, Workers};
use super::pricer::Pricer;

/// Fewest robots that it is worked out for: for fewer all orders are soon looked at.
const LEAST: usize = 6;

/// A share of the bound that is no detour.
const ROUNDING: f64 = 1e-6;

impl Pricer<'_> {
    /// By pairs of starts and slots; none where robots may park, for few robots, and for several vehicles.
    pub(super) fn detours(
        &self,
        workers: &dyn Workers,
        goes_on: &mut GoesOn<'_>,
    ) -> ControlFlow<(), Option<Extra>> {
        let layout = &self.layout;
        let count = layout.robots();
        let is_asked = count >= LEAST && count == layout.slots() && layout.moves() == 1;
        if !is_asked || !self.places.has_one_vehicle() {
            return ControlFlow::Continue(None);
        }
        let mut pairs = vec![vec![None; count]; count];
        let numbers: Vec<usize> = (0..count * count).collect();
        for group in numbers.chunks(DESKS) {
            let found: Vec<Mutex<Option<Pair>>> = group.iter().map(|_| Mutex::default()).collect();
            workers.run(group.len(), &|desk| {
                let pair = self.pair(desk, group[desk] / count, group[desk] % count);
                *found[desk].lock().unwrap_or_else(PoisonError::into_inner) = pair;
            });
            self.routes.share();
            for (&number, found) in group.iter().zip(found) {
                pairs[number / count][number % count] =
                    found.into_inner().unwrap_or_else(PoisonError::into_inner);
            }
            goes_on()?;
        }
        Extra::new(&pairs, workers, goes_on)
    }

    /// Of a start and a slot; `None` where a robot may not rest.
    fn pair(&self, desk: usize, start: usize, slot: usize) -> Option<Pair> {
        let count = self.layout.robots();
        let (hop, kind) = (Hop::new(start, count + slot), self.layout.kind(start));
        let least = self.bound_of(start, kind, count + slot)?;
        let mut above = Vec::new();
        if !self.stays(hop) {
            for place in (0..2 * count).filter(|&place| place != start && place != count + slot) {
                let seat = self.places.seat(place, kind);
                let more = if self.places.is_blocked(count + slot, kind, &[seat]) {
                    f64::INFINITY
                } else {
                    self.cost_beside(desk, hop, kind, seat) - (1.0 + ROUNDING) * least
                };
                if more > 0.0 {
                    let bit =
                        if place < count { taken(1 << place, 0) } else { taken(0, 1 << (place - count)) };
                    above.push((bit, more));
                }
            }
        }
        Some(Pair { least, above })
    }
}
