//! One kind of robot and what its motion costs: shared by all searches, in all threads.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};

use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::problem::Rules;

use super::super::cost_per_metre::{CostPerMetre, Heading, PowerMap};
use super::super::propulsion::{Expense, Propulsion};
use super::super::vector::length;
use super::bound::{Bound, BoundAt};
use super::fares::{Direction, Fares};
use super::in_body;
use super::tariff::{Offer, Scale, Tariff};

/// An acceleration whose price by the table is above the best by less than this share is tried as well.
const CLOSE: f64 = 0.03;

/// Beyond the limits a price is a larger number than this, J.
pub(super) const BEYOND_J: f64 = 1e9;
/// Most powers of others that prices are kept for, some 0.3 MB each at most.
const FARES_MOST: usize = 128;

/// One kind of robot, with the costs of its motion under the rules of a problem.
#[derive(Debug)]
pub struct Mover {
    pub(super) propulsion: Propulsion,
    /// At the paper's speed.
    constant: PowerMap,
    tariff: Tariff,
    fares: RwLock<HashMap<u64, Arc<Fares>>>,
    /// By the paper's rules, and by Flotilla's.
    bounds: [Bound; 2],
}

impl Mover {
    /// A mover under the rules' speeds and accelerations.
    #[must_use]
    pub fn new(propulsion: Propulsion, rules: &Rules) -> Self {
        let constant = PowerMap::new(&propulsion, [rules.speed_m_s; 2]);
        let any = PowerMap::new(&propulsion, rules.speeds_m_s);
        let legs = Scale::new(rules.speeds_m_s, rules.acceleration_m_s2);
        let turns = Scale::new(rules.yaw_rates_rad_s, rules.yaw_acceleration_rad_s2);
        let tariff = Tariff::new(&propulsion, legs, turns);
        let bounds = [Bound::new(&constant, true), Bound::new(&any, false)];
        Self { propulsion, constant, tariff, fares: RwLock::default(), bounds }
    }

    /// What a metre costs by the paper's rules while others draw `lambda_w`.
    pub(super) fn paper_cost_per_metre(&self, lambda_w: f64) -> CostPerMetre {
        CostPerMetre::energy(&self.constant, Heading::Along, lambda_w)
    }

    /// Lower bound of what any route along `way_m` costs under a criterion, J or m.
    #[must_use]
    pub fn bound(&self, criterion: Criterion, manner: Manner, way_m: [f64; 3], lambda_w: f64) -> f64 {
        match criterion {
            Criterion::Euclidean => length(way_m),
            Criterion::Energy => self.bound_at(manner, lambda_w).of(way_m),
        }
    }

    pub(super) fn bound_at(&self, manner: Manner, lambda_w: f64) -> BoundAt {
        self.bounds[usize::from(manner == Manner::Best)].at(lambda_w)
    }

    /// Prices of the table while others draw `lambda_w`.
    pub(super) fn fares(&self, lambda_w: f64) -> Arc<Fares> {
        let key = lambda_w.to_bits();
        if let Some(known) = self.fares.read().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return Arc::clone(known);
        }
        let mut fares = self.fares.write().unwrap_or_else(PoisonError::into_inner);
        if fares.len() >= FARES_MOST {
            fares.clear();
        }
        Arc::clone(fares.entry(key).or_insert_with(|| Arc::new(Fares::new(&self.tariff, lambda_w))))
    }

    /// E + λT of a leg by the table, J; infinite beyond the thrusters' limits.
    pub(super) fn leg_price(&self, fares: &Fares, direction: &Direction, yaw_rad: f64) -> f64 {
        let price = fares.leg(&self.tariff, &self.propulsion, direction, yaw_rad);
        if price < BEYOND_J { price } else { f64::INFINITY }
    }

    /// A leg along `leg_m` with the heading held, at its best speed.
    pub(super) fn leg(&self, leg_m: [f64; 3], yaw_rad: f64, lambda_w: f64) -> Option<Expense> {
        let way_m = length(leg_m);
        if way_m == 0.0 {
            return Some(Expense::default());
        }
        let body = in_body(leg_m, yaw_rad);
        let direction = body.map(|component| component / way_m);
        let offers = self.tariff.leg(&self.propulsion, body, way_m, lambda_w);
        gentlest(&offers, lambda_w, |speed, a| self.propulsion.leg(direction, way_m, speed, Some(a)))
    }

    /// A turn at its best rate.
    pub(super) fn turn(&self, angle_rad: f64, lambda_w: f64) -> Option<Expense> {
        let offers = self.tariff.turn(angle_rad, lambda_w);
        gentlest(&offers, lambda_w, |rate, a| self.propulsion.turn(angle_rad, rate, Some(a)))
    }
}

fn least(offers: &[Offer]) -> f64 {
    let price = offers.iter().map(|offer| offer.price).fold(f64::INFINITY, f64::min);
    if price < BEYOND_J { price } else { f64::INFINITY }
}

/// The best of the offers, its speed improved between the two of the table beside it.
fn gentlest(offers: &[Offer], lambda_w: f64, of: impl Fn(f64, f64) -> Option<Expense>) -> Option<Expense> {
    let limit = least(offers) * (1.0 + CLOSE);
    let near = offers.iter().filter(|offer| offer.price <= limit);
    let exact = near.filter_map(|offer| improved(offer, lambda_w, |speed| of(speed, offer.acceleration)));
    exact.min_by(|a, b| a.with_others(lambda_w).total_cmp(&b.with_others(lambda_w)))
}

/// The least price between the speeds beside an offer's, by parabolas through three points in the logarithm of the speed.
fn improved(offer: &Offer, lambda_w: f64, of: impl Fn(f64) -> Option<Expense>) -> Option<Expense> {
    const PARABOLAS: usize = 3;
    let price = |expense: &Option<Expense>| expense.map_or(f64::INFINITY, |e| e.with_others(lambda_w));
    let [low, high] = offer.between;
    let mut middle = (offer.speed, of(offer.speed));
    // At the least speed: not worth a step up if the smallest one costs.
    if low >= offer.speed && (high <= low || price(&of(low * 1.002)) >= price(&middle.1)) {
        return middle.1;
    }
    let at_edge = |speed: f64| (speed, of(speed));
    let (mut left, mut right) = (at_edge(low), at_edge(high));
    if low >= offer.speed || high <= offer.speed {
        let between = (low * high).sqrt();
        middle = (between, of(between));
    }
    for _ in 0..PARABOLAS {
        let [a, b, c] = [&left, &middle, &right].map(|(speed, expense)| (speed.ln(), price(expense)));
        let (up, down) = ((b.0 - a.0) * (b.1 - c.1), (b.0 - c.0) * (b.1 - a.1));
        let lowest = b.0 - 0.5 * ((b.0 - a.0) * up - (b.0 - c.0) * down) / (up - down);
        if !lowest.is_finite() || lowest <= a.0 || lowest >= c.0 || (lowest - b.0).abs() < 1e-4 {
            break;
        }
        let speed = lowest.exp();
        let next = (speed, of(speed));
        let (inner, outer) = if speed < middle.0 { (next, middle) } else { (middle, next) };
        if price(&inner.1) <= price(&outer.1) {
            (middle, right) = (inner, outer);
        } else {
            (left, middle) = (inner, outer);
        }
    }
    [left.1, middle.1, right.1].into_iter().min_by(|a, b| price(a).total_cmp(&price(b)))?
}
