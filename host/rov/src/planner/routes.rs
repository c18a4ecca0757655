//! Routes of hops, each found once: what it goes around, and what it would run into.
//!
//! Most bodies at rest are in no robot's way. So a route is looked for around the tools alone, and again around every body
//! that what was found runs into, until it runs into none. A route that goes around some of the bodies that rest, and
//! runs into none of the others, is the route for all of them: so it serves every state that keeps those bodies, and is told by two
//! comparisons of sets. What goes around fewer bodies costs no more, so each such route bounds the price from below before the
//! last one is found.
//!
//! What others draw while a robot moves, λ, differs from state to state by little. Routes are found for the nearest of a
//! few powers λ_k, and priced at λ:
//!
//! ```text
//! λ_k = 0, or LEAST_W·STEP^k        price = E_k + λT_k,  where E_k + λ_k T_k is least
//! ```
//!
//! To first order the price does not change with the power that the route was found for.
//!
//! What one desk finds the others see after the batch, so that the result does not depend on which is done first.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use super::super::order::{DESKS, Hop};
use super::super::route::Route;

/// The least λ_k above zero, and the step from one to the next.
const LEAST_W: f64 = 0.05;
const STEP: f64 = 1.08;
/// What a bound loses where its route was found for another power than it is priced at: the price is flat there, λT being a part
/// of it that a mismatch of half a step changes by some 4 % times 2 %.
pub(super) const MISMATCH: f64 = 0.999;
/// No more routes are kept, some 2 kB each.
const ROUTES_MOST: usize = 60_000;

/// The power that routes are found for where others draw `lambda_w`.
pub(super) fn nearest_power_w(lambda_w: f64) -> f64 {
    if lambda_w < 0.5 * LEAST_W {
        return 0.0;
    }
    LEAST_W * STEP.powf(((lambda_w / LEAST_W).ln() / STEP.ln()).round())
}

/// A set of seats.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Seats(Vec<u64>);

impl Seats {
    pub(super) fn of(seats: &[usize]) -> Self {
        let mut set = Self::default();
        for &seat in seats {
            set.add(seat);
        }
        set
    }

    pub(super) fn add(&mut self, seat: usize) {
        if self.0.len() <= seat / 64 {
            self.0.resize(seat / 64 + 1, 0);
        }
        self.0[seat / 64] |= 1 << (seat % 64);
    }

    pub(super) fn has(&self, seat: usize) -> bool {
        self.0.get(seat / 64).is_some_and(|bits| bits >> (seat % 64) & 1 == 1)
    }

    fn is_within(&self, other: &Self) -> bool {
        self.0.iter().enumerate().all(|(k, bits)| bits & !other.0.get(k).copied().unwrap_or(0) == 0)
    }

    fn meets(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).any(|(a, b)| a & b != 0)
    }
}

/// A route, or that there is none.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    pub(super) around: Seats,
    pub(super) meets: Seats,
    /// At the power that it was found for; infinite if there is none.
    pub(super) cost: f64,
    pub(super) route: Option<Arc<Route>>,
}

/// Hop, vehicle, and the power others draw, as bits.
pub(super) type Key = (Hop, usize, u64);

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Routes {
    known: RwLock<HashMap<Key, Vec<Kept>>>,
    /// Found since the last batch, by desk.
    fresh: Vec<Mutex<Vec<(Key, Kept)>>>,
    count: Mutex<usize>,
}

impl Routes {
    pub(super) fn new() -> Self {
        let fresh = (0..DESKS).map(|_| Mutex::default()).collect();
        Self { known: RwLock::default(), fresh, count: Mutex::default() }
    }

    /// Keeps what a desk has found.
    pub(super) fn keep(&self, desk: usize, key: Key, kept: Kept) {
        self.fresh[desk].lock().unwrap_or_else(PoisonError::into_inner).push((key, kept));
    }

    /// Lets all desks see what each has found.
    pub(super) fn share(&self) {
        let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
        let mut count = self.count.lock().unwrap_or_else(PoisonError::into_inner);
        for fresh in &self.fresh {
            for (key, kept) in fresh.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
                let own = known.entry(key).or_default();
                if *count < ROUTES_MOST && own.iter().all(|other| other.around != kept.around) {
                    own.push(kept);
                    *count += 1;
                }
            }
        }
    }

    /// What is known of a hop while these seats are taken.
    pub(super) fn look(&self, key: Key, taken: &Seats) -> Known {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let mut found = Known::default();
        for kept in known.get(&key).into_iter().flatten() {
            let is_part = kept.around.is_within(taken);
            if is_part && (found.nearest.is_none() || kept.cost > found.least) {
                found.least = kept.cost;
                found.nearest = Some(kept.clone());
            }
            if kept.route.is_some() && !kept.meets.meets(taken) {
                found.is_best |= is_part;
                if kept.cost < found.cost {
                    (found.cost, found.free) = (kept.cost, kept.route.clone());
                }
            }
        }
        found
    }
}

/// What is known of a hop while some seats are taken.
pub(super) struct Known {
    /// The dearest of the routes around some of the seats, and its cost: no route around all costs less.
    pub(super) nearest: Option<Kept>,
    pub(super) least: f64,
    /// The cheapest route that runs into none, and whether one of them was found around a part of the seats.
    pub(super) free: Option<Arc<Route>>,
    pub(super) cost: f64,
    pub(super) is_best: bool,
}

impl Default for Known {
    fn default() -> Self {
        Self { nearest: None, least: 0.0, free: None, cost: f64::INFINITY, is_best: false }
    }
}

/// The answer to the question for a route.
pub(super) enum Answer {
    /// This.
    Route(Arc<Route>),
    /// There is none.
    None,
    /// It costs at least this, which is more than was asked for.
    AtLeast(f64),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_seats_are_compared_beyond_one_word() {
        let (few, many) = (Seats::of(&[3, 70]), Seats::of(&[3, 5, 70, 200]));
        assert!(few.is_within(&many) && !many.is_within(&few) && few.is_within(&few));
        assert!(few.meets(&many) && !few.meets(&Seats::of(&[4, 71])) && !few.meets(&Seats::default()));
        assert!(few.has(70) && !few.has(71) && !few.has(1000));
    }

    #[test]
    fn powers_are_near_what_is_drawn() {
        for k in 1..2000 {
            let lambda_w = 0.05 * f64::from(k);
            let ratio = nearest_power_w(lambda_w) / lambda_w;
            assert!((0.96..1.05).contains(&ratio), "{lambda_w} W: {ratio}");
        }
        assert!(nearest_power_w(0.0).to_bits() == 0.0_f64.to_bits() && nearest_power_w(0.02) < 1e-9);
    }
}
