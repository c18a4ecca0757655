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

use reconfiguration::plan::{Action, ActionKind, Manner};

use super::super::clearance::{Clearance, Resting};
use super::super::order::{DESKS, Hop, State};
use super::super::route::Route;
use super::pricer::{Pricer, Way, half_m};

/// The least λ_k above zero, and the step from one to the next.
const LEAST_W: f64 = 0.05;
const STEP: f64 = 1.08;
/// What a bound loses where its route was found for another power than it is priced at: the price is flat there, λT being a part
/// of it that a mismatch of half a step changes by some 4 % times 2 %.
const MISMATCH: f64 = 0.999;
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
struct Seats(Vec<u64>);

impl Seats {
    fn of(seats: &[usize]) -> Self {
        let mut set = Self::default();
        for &seat in seats {
            set.add(seat);
        }
        set
    }

    fn add(&mut self, seat: usize) {
        if self.0.len() <= seat / 64 {
            self.0.resize(seat / 64 + 1, 0);
        }
        self.0[seat / 64] |= 1 << (seat % 64);
    }

    fn has(&self, seat: usize) -> bool {
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
struct Kept {
    around: Seats,
    meets: Seats,
    /// At the power that it was found for; infinite if there is none.
    cost: f64,
    route: Option<Arc<Route>>,
}

/// Hop, vehicle, and the power others draw, as bits.
type Key = (Hop, usize, u64);

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
    fn look(&self, key: Key, taken: &Seats) -> Known {
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
struct Known {
    /// The dearest of the routes around some of the seats, and its cost: no route around all costs less.
    nearest: Option<Kept>,
    least: f64,
    /// The cheapest route that runs into none, and whether one of them was found around a part of the seats.
    free: Option<Arc<Route>>,
    cost: f64,
    is_best: bool,
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

impl Pricer<'_> {
    /// The route of a hop while others draw `lambda_w`, found for `power_w`; not looked for to the end where it costs more
    /// than `most`.
    pub(super) fn route_of(
        &self,
        desk: usize,
        state: &State,
        hop: Hop,
        (lambda_w, power_w): (f64, f64),
        most: f64,
    ) -> Answer {
        let Some(way) = self.way(state, hop) else { return Answer::None };
        let taken = self.places.taken(&self.layout, state, hop.ends().0);
        if self.request.manner == Manner::Paper {
            let route = self.route(desk, &way, &self.bodies(&taken), power_w);
            return route.map_or(Answer::None, |route| Answer::Route(Arc::new(route)));
        }
        let key = (hop, way.vehicle, power_w.to_bits());
        let set = Seats::of(&taken);
        let known = self.routes.look(key, &set);
        if known.is_best
            && let Some(route) = known.free
        {
            return Answer::Route(route);
        }
        let share = if lambda_w.to_bits() == power_w.to_bits() { 1.0 } else { MISMATCH };
        let mut around = known.nearest.as_ref().map_or_else(
            || self.places.tools(),
            |kept| (taken.iter().copied()).filter(|&seat| kept.around.has(seat)).collect(),
        );
        let mut nearest = known.nearest;
        loop {
            let kept = nearest.take().unwrap_or_else(|| self.found(desk, key, &way, &around));
            let Some(route) = kept.route else { return Answer::None };
            let more: Vec<usize> = (taken.iter().copied())
                .filter(|&seat| kept.meets.has(seat) && !kept.around.has(seat))
                .collect();
            if more.is_empty() {
                // One that was found around other bodies may be a better one.
                let other = known.free.filter(|_| known.cost < kept.cost);
                return Answer::Route(other.unwrap_or(route));
            }
            let least = share * route.cost(self.request.criterion, lambda_w);
            if least > most {
                return Answer::AtLeast(least);
            }
            around.extend(more);
            around.sort_unstable();
        }
    }

    /// Looks for the route around some seats, and keeps it.
    fn found(&self, desk: usize, key: Key, way: &Way, around: &[usize]) -> Kept {
        let power_w = f64::from_bits(key.2);
        let route = self.route(desk, way, &self.bodies(around), power_w).map(Arc::new);
        let cost = |route: &Arc<Route>| route.cost(self.request.criterion, power_w);
        let kept = Kept {
            around: Seats::of(around),
            meets: route.as_ref().map_or_else(Seats::default, |route| self.met(way, route)),
            cost: route.as_ref().map_or(f64::INFINITY, cost),
            route,
        };
        let mut fresh = self.routes.fresh[desk].lock().unwrap_or_else(PoisonError::into_inner);
        fresh.push((key, kept.clone()));
        kept
    }

    /// What a hop costs around the tools alone while others draw so much; infinite if there is no way.
    pub(super) fn route_around_tools(&self, desk: usize, hop: Hop, way: &Way, power_w: f64) -> f64 {
        self.found(desk, (hop, way.vehicle, power_w.to_bits()), way, &self.places.tools()).cost
    }

    /// What a hop costs at least around the tools and one more seat while others draw the least that they may.
    pub(super) fn cost_beside(&self, desk: usize, hop: Hop, kind: u8, seat: usize) -> f64 {
        let way = self.way_of(hop, kind);
        let key = (hop, way.vehicle, self.lambda_least_w.to_bits());
        let mut around = self.places.tools();
        let direct = self.routes.look(key, &Seats::of(&around));
        if let Some(kept) = direct.nearest
            && !kept.meets.has(seat)
        {
            return kept.cost;
        }
        around.push(seat);
        around.sort_unstable();
        self.found(desk, key, &way, &around).cost
    }

    /// Every seat that a route runs into.
    fn met(&self, way: &Way, route: &Route) -> Seats {
        let mut clearance = self.clearance(way, &[]);
        let mut met = Seats::default();
        for seat in self.places.robots_and_tools() {
            let (pose, vehicle) = self.places.body(seat);
            clearance.resting = vec![Resting { pose, half_m: half_m(vehicle) }];
            if !is_free(&clearance, route) {
                met.add(seat);
            }
        }
        met
    }
}

/// Whether the hull runs into nothing on its route.
fn is_free(clearance: &Clearance, route: &Route) -> bool {
    route.actions.iter().all(|Action { kind, from, to, .. }| match kind {
        ActionKind::Leg => clearance.leg_is_free(from.position_m, to.position_m, from.yaw_rad),
        ActionKind::Turn => clearance.turn_is_free(from.position_m),
        ActionKind::Undock | ActionKind::Dock => true,
    })
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
