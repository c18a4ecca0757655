//! Corners of a route and a heading for each leg: what that costs, and the cheapest headings for given corners.
//!
//! A heading is the start's, the slot's, along the leg, against it, or an angle of its own. The hull turns at a corner
//! only where it has room, and every leg is free at its heading.

use std::f64::consts::PI;
use std::sync::Arc;

use quantity::wrap_rad;
use reconfiguration::plan::Criterion;

use super::super::vector::{length, offset};
use super::fares::{Direction, Fares};
use super::timeline::Timeline;
use super::{Route, RouteQuery, SAME_RAD};

/// Most corners, start and slot included.
pub(super) const MOST: usize = 10;
/// What a joule weighs against a metre under the Euclidean criterion, so that of equal lengths the cheaper is taken, m/J.
const TIE_M_PER_J: f64 = 1e-6;

/// Heading of a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    Start,
    Slot,
    Along,
    Against,
    At(f64),
}

/// The headings that are tried first.
pub(super) const CHOICES: [Mode; 4] = [Mode::Start, Mode::Slot, Mode::Along, Mode::Against];

/// Corners and headings; of a fixed size, so that trying one allocates nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polyline {
    /// Corners.
    pub points: [[f64; 3]; MOST],
    /// How many.
    pub count: usize,
    /// Headings of the legs.
    pub modes: [Mode; MOST - 1],
}

impl Polyline {
    /// With headings that are not yet chosen; `None` for too many corners.
    pub fn new(corners: &[[f64; 3]]) -> Option<Self> {
        let mut polyline = Self { points: [[0.0; 3]; MOST], count: 0, modes: [Mode::Start; MOST - 1] };
        for &corner in corners {
            let is_same = polyline.corners().last().is_some_and(|last| length(offset(*last, corner)) < 1e-9);
            if !is_same || polyline.count == 1 && corners.len() == 2 {
                *polyline.points.get_mut(polyline.count)? = corner;
                polyline.count += 1;
            }
        }
        Some(polyline)
    }

    /// Its corners.
    pub fn corners(&self) -> &[[f64; 3]] {
        &self.points[..self.count]
    }

    fn leg_m(&self, leg: usize) -> [f64; 3] {
        offset(self.points[leg], self.points[leg + 1])
    }

    /// With a corner more on a leg.
    pub fn with(&self, leg: usize, at_m: [f64; 3]) -> Option<Self> {
        if self.count >= MOST {
            return None;
        }
        let mut more = *self;
        more.points.copy_within(leg + 1..self.count, leg + 2);
        more.points[leg + 1] = at_m;
        more.modes.copy_within(leg..self.count - 1, leg + 1);
        more.count += 1;
        Some(more)
    }

    /// Without an inner corner; the leg that remains has the heading of the one before it, or after it.
    pub fn without(&self, corner: usize, keep_before: bool) -> Self {
        let mut less = *self;
        less.points.copy_within(corner + 1..self.count, corner);
        less.modes.copy_within(
            if keep_before { corner + 1 } else { corner }..MOST - 1,
            if keep_before { corner } else { corner - 1 },
        );
        less.count -= 1;
        less
    }
}

/// Prices polylines for one query.
pub(super) struct Pricer<'a> {
    pub query: &'a RouteQuery<'a>,
    pub criterion: Criterion,
    fares: Arc<Fares>,
}

impl<'a> Pricer<'a> {
    pub fn new(query: &'a RouteQuery<'a>, criterion: Criterion) -> Self {
        Self { query, criterion, fares: query.mover.fares(query.lambda_w) }
    }

    /// Whether start and slot have different headings.
    pub fn turns(&self) -> bool {
        let (start, slot) = (&self.query.clearance.start, &self.query.clearance.slot);
        wrap_rad(slot.yaw_rad - start.yaw_rad).abs() >= SAME_RAD
    }

    fn weigh(&self, length_m: f64, price_j: f64) -> f64 {
        match self.criterion {
            Criterion::Energy => price_j,
            Criterion::Euclidean => length_m + TIE_M_PER_J * price_j,
        }
    }

    /// Price of a leg.
    pub fn leg(&self, along: &Direction, yaw_rad: f64) -> f64 {
        self.weigh(along.way_m, self.query.mover.leg_price(&self.fares, along, yaw_rad))
    }

    /// Price of a turn.
    pub fn turn(&self, from_rad: f64, to_rad: f64) -> f64 {
        let angle_rad = wrap_rad(to_rad - from_rad);
        if angle_rad.abs() < SAME_RAD {
            return 0.0;
        }
        self.weigh(0.0, self.fares.turn(angle_rad))
    }

    /// Heading of a leg.
    pub fn heading(&self, mode: Mode, leg: &Direction) -> f64 {
        let start = self.query.clearance.start.yaw_rad;
        let along = || leg.azimuth_rad.unwrap_or(start);
        match mode {
            Mode::Start => start,
            Mode::Slot => self.query.clearance.slot.yaw_rad,
            Mode::Along => along(),
            Mode::Against => wrap_rad(along() + PI),
            Mode::At(yaw_rad) => yaw_rad,
        }
    }

    /// What it costs, if that is below `limit` and it is free.
    pub fn below(&self, polyline: &Polyline, limit: f64) -> Option<f64> {
        let clearance = self.query.clearance;
        let mut headings = [0.0; MOST + 1];
        headings[0] = clearance.start.yaw_rad;
        let legs = polyline.count - 1;
        headings[legs + 1] = clearance.slot.yaw_rad;
        let mut sum = 0.0;
        for leg in 0..legs {
            let along = Direction::of(polyline.leg_m(leg));
            headings[leg + 1] = self.heading(polyline.modes[leg], &along);
            sum += self.leg(&along, headings[leg + 1]);
            if sum >= limit {
                return None;
            }
        }
        for corner in 0..=legs {
            sum += self.turn(headings[corner], headings[corner + 1]);
        }
        if sum >= limit {
            return None;
        }
        let turns = |corner: usize| wrap_rad(headings[corner + 1] - headings[corner]).abs() >= SAME_RAD;
        let is_free = (0..=legs)
            .all(|corner| !turns(corner) || clearance.turn_is_free(polyline.points[corner]))
            && (0..legs).all(|leg| {
                clearance.leg_is_free(polyline.points[leg], polyline.points[leg + 1], headings[leg + 1])
            });
        is_free.then_some(sum)
    }

    /// Gives every leg the best of four headings: over the legs in order, the least price of ending each at each. What it costs,
    /// `None` if no choice is free.
    pub fn choose(&self, polyline: &mut Polyline) -> Option<f64> {
        let clearance = self.query.clearance;
        let turn = |from: f64, to: f64, has_room: bool| {
            let same = wrap_rad(to - from).abs() < SAME_RAD;
            if same { Some(0.0) } else { has_room.then(|| self.turn(from, to)) }
        };
        let legs = polyline.count - 1;
        // By leg and choice: heading, least price of ending there, choice before.
        let mut stages = [[(0.0, f64::INFINITY, 0); CHOICES.len()]; MOST];
        for leg in 0..legs {
            let (from_m, to_m) = (polyline.points[leg], polyline.points[leg + 1]);
            let along = Direction::of(polyline.leg_m(leg));
            let has_room = clearance.turn_is_free(from_m);
            for (choice, &mode) in CHOICES.iter().enumerate() {
                let heading = self.heading(mode, &along);
                let (mut least, mut before) = (f64::INFINITY, 0);
                if leg == 0 {
                    least = turn(clearance.start.yaw_rad, heading, has_room).unwrap_or(f64::INFINITY);
                } else {
                    for (index, &(from, price, _)) in stages[leg - 1].iter().enumerate() {
                        let Some(turned) = turn(from, heading, has_room) else { continue };
                        if price + turned < least {
                            (least, before) = (price + turned, index);
                        }
                    }
                }
                if least < f64::INFINITY && clearance.leg_is_free(from_m, to_m, heading) {
                    stages[leg][choice] = (heading, least + self.leg(&along, heading), before);
                }
            }
        }
        let slot = &clearance.slot;
        let has_room = clearance.turn_is_free(slot.position_m);
        let ends = stages[legs - 1].iter().enumerate().filter(|(_, end)| end.1 < f64::INFINITY);
        let ends = ends.filter_map(|(index, &(heading, price, _))| {
            Some((index, price + turn(heading, slot.yaw_rad, has_room)?))
        });
        let (mut choice, price) = ends.min_by(|a, b| a.1.total_cmp(&b.1))?;
        for leg in (0..legs).rev() {
            polyline.modes[leg] = CHOICES[choice];
            choice = stages[leg][choice].2;
        }
        Some(price)
    }

    /// Its actions, each at its best speed; `None` if one is beyond the thrusters' limits.
    pub fn route(&self, polyline: &Polyline) -> Option<Route> {
        let RouteQuery { mover, clearance, rules, lambda_w, .. } = self.query;
        let mut timeline = Timeline::new(clearance.start, rules);
        let turn_to = |timeline: &mut Timeline, heading: f64| {
            let angle_rad = wrap_rad(heading - timeline.at.yaw_rad);
            if angle_rad.abs() >= SAME_RAD {
                timeline.turn(angle_rad, mover.turn(angle_rad, *lambda_w)?);
            }
            Some(())
        };
        for leg in 0..polyline.count - 1 {
            let leg_m = polyline.leg_m(leg);
            turn_to(&mut timeline, self.heading(polyline.modes[leg], &Direction::of(leg_m)))?;
            timeline.leg(polyline.points[leg + 1], mover.leg(leg_m, timeline.at.yaw_rad, *lambda_w)?);
        }
        turn_to(&mut timeline, clearance.slot.yaw_rad)?;
        Some(timeline.finish())
    }
}
