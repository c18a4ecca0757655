//! Routes of hops, looked for around ever more of what rests until they run into nothing; see [`routes`](super::routes).

use std::sync::Arc;

use reconfiguration::plan::{Action, ActionKind, Manner};

use super::super::clearance::{Clearance, Resting};
use super::super::order::{Hop, State};
use super::super::route::Route;
use super::places::half_m;
use super::pricer::{Pricer, Way};
use super::routes::{Answer, Kept, Key, MISMATCH, Seats};

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
        self.routes.keep(desk, key, kept.clone());
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
