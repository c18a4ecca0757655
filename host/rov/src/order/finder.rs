//! What all ways to find an order share: prices of hops, the best order known, and the report after every batch.

use std::collections::HashMap;
use std::sync::OnceLock;

use super::remaining::Remaining;
use super::{Answer, DESKS, Hop, Known, MoveCosts, Order, Progress, State, Workers};

/// An order is better than another one that costs this share more; rounding apart.
const BETTER: f64 = 1.0 - 1e-9;

/// No more prices are kept, 48 bytes each; routes that are known give the others again.
const PRICES_MOST: usize = 2_000_000;

/// The search was told to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;

/// See the module's documentation.
pub struct Finder<'a, C> {
    costs: &'a C,
    workers: &'a dyn Workers,
    progress: &'a mut dyn Progress,
    prices: HashMap<(State, Hop), f64>,
    known: Known,
    best: Option<Order>,
    rule: Option<f64>,
}

impl<'a, C: MoveCosts> Finder<'a, C> {
    /// Knows nothing yet.
    pub fn new(costs: &'a C, workers: &'a dyn Workers, progress: &'a mut dyn Progress) -> Self {
        let known = Known::default();
        Self { costs, workers, progress, prices: HashMap::new(), known, best: None, rule: None }
    }

    pub(super) const fn costs(&self) -> &'a C {
        self.costs
    }

    /// How far it has come.
    #[must_use]
    pub const fn known(&self) -> &Known {
        &self.known
    }

    /// The best order known.
    #[must_use]
    pub const fn best(&self) -> Option<&Order> {
        self.best.as_ref()
    }

    /// Cost of the order of the paper's rule, where that was found.
    #[must_use]
    pub const fn rule(&self) -> Option<f64> {
        self.rule
    }

    pub(super) const fn set_rule(&mut self, cost: f64) {
        self.rule = Some(cost);
    }

    /// What costs this is not worth a look.
    pub(super) fn limit(&self) -> f64 {
        self.known.best.map_or(f64::INFINITY, |best| best * BETTER)
    }

    /// Takes an order for the best if it is better.
    pub(super) fn learn(&mut self, order: &Order) {
        if order.cost < self.limit() {
            self.known.best = Some(order.cost);
            self.best = Some(order.clone());
        }
    }

    /// No order costs less than this.
    pub(super) fn bounded(&mut self, bound: f64) {
        let bound = self.known.best.map_or(bound, |best| bound.min(best));
        self.known.bound = self.known.bound.max(bound);
    }

    /// The price of a hop, if it is known.
    pub(super) fn price(&self, state: &State, hop: Hop) -> Option<f64> {
        self.prices.get(&(*state, hop)).copied()
    }

    pub(super) fn report(&mut self) -> Result<(), Stopped> {
        if self.progress.report(&self.known).is_break() { Err(Stopped) } else { Ok(()) }
    }

    /// What is still to be paid, worked out as well as it is affordable.
    pub(super) fn remaining(&mut self, relax: bool) -> Result<Remaining, Stopped> {
        let (costs, workers) = (self.costs, self.workers);
        let found = Remaining::new(costs, workers, relax, &mut || self.progress.report(&self.known));
        found.continue_value().ok_or(Stopped)
    }

    /// What is known of at most [`DESKS`] hops: their prices, or that they cost more than `most` for certain.
    pub(super) fn answers(&mut self, hops: &[(State, Hop)], most: &[f64]) -> Result<Vec<Answer>, Stopped> {
        let mut answers: Vec<Option<Answer>> =
            hops.iter().map(|(state, hop)| self.price(state, *hop).map(Answer::Price)).collect();
        let open: Vec<usize> = (0..hops.len()).filter(|&k| answers[k].is_none()).collect();
        if !open.is_empty() {
            let costs = self.costs;
            // With whether it took a look for a route: what is known to be impossible before counts as nothing.
            let found: Vec<OnceLock<(Answer, bool)>> = open.iter().map(|_| OnceLock::new()).collect();
            self.workers.run(open.len(), &|desk| {
                let (state, hop) = &hops[open[desk]];
                let answer = match costs.bound_from(state, *hop) {
                    None => (Answer::Price(f64::INFINITY), false),
                    Some(bound) if bound > most[open[desk]] => (Answer::AtLeast(bound), false),
                    Some(_) => (costs.cost(desk, state, *hop, most[open[desk]]), true),
                };
                // Each number comes once.
                let _ = found[desk].set(answer);
            });
            costs.share();
            for (&k, found) in open.iter().zip(found) {
                let Some((answer, looked)) = found.into_inner() else { continue };
                answers[k] = Some(answer);
                if let Answer::Price(price) = answer {
                    self.known.priced += usize::from(looked);
                    if self.prices.len() < PRICES_MOST {
                        self.prices.insert(hops[k], price);
                    }
                }
            }
            self.report()?;
        }
        Ok(answers.into_iter().map(|answer| answer.unwrap_or(Answer::Price(f64::INFINITY))).collect())
    }

    /// Prices of hops, infinite for impossible ones.
    pub(super) fn prices(&mut self, hops: &[(State, Hop)]) -> Result<Vec<f64>, Stopped> {
        let mut prices = Vec::with_capacity(hops.len());
        for batch in hops.chunks(DESKS) {
            let answers = self.answers(batch, &[f64::INFINITY; DESKS])?;
            prices.extend(answers.into_iter().map(|answer| match answer {
                Answer::Price(price) | Answer::AtLeast(price) => price,
            }));
        }
        Ok(prices)
    }
}
