//! The cheapest of the cycles that a search finds, and whether they are as tolerant as they must be.

use super::search::CycleCandidate;
use crate::buffers::Buffers;
use crate::planner_config::LossTolerance;
use crate::setting::{Approach, Case};

/// The cheapest of what is offered: relative error, and the time of the transition by `travel_weight`.
pub(super) struct Cheapest<'a> {
    pub(super) case: Case<'a>,
    pub(super) tails: Option<&'a [f64]>,
    pub(super) found: Option<CycleCandidate>,
    pub(super) price: f64,
}

impl Cheapest<'_> {
    /// What the search asks of each motion holds of each: a tail that stops in the transition stands there in the swim too. So where
    /// any module may lose its power, the whole is judged.
    pub(super) fn is_kept(&self, found: &CycleCandidate) -> bool {
        let Self { case, tails, .. } = *self;
        case.tolerance != LossTolerance::Power
            || case.judge(&found.cycle, found.approach.as_ref(), tails).is_some_and(|judged| {
                is_kept(case.tolerance, judged.loss_tolerant, judged.power_tolerant, tails)
            })
    }

    /// True if nothing much better can come.
    pub(super) fn offer(&mut self, found: Option<CycleCandidate>, buffers: &mut Buffers) -> bool {
        let Some(found) = found else { return false };
        if !self.is_kept(&found) {
            found.discard(buffers);
            return false;
        }
        let weight = self.case.config.travel_weight;
        let transition_s = found.approach.as_ref().map_or(0.0, Approach::transition_s);
        let error = if found.met { 0.0 } else { found.error };
        let price = error + weight * transition_s / self.case.parameters.period_s;
        if price < self.price {
            self.price = price;
            found.replace(&mut self.found, buffers);
        } else {
            found.discard(buffers);
        }
        price <= weight
    }
}

/// Whether a plan is as tolerant as it must be.
pub(super) fn is_kept(
    asked: LossTolerance,
    loss_tolerant: bool,
    power_tolerant: bool,
    tails: Option<&[f64]>,
) -> bool {
    // With unknown angles no module could have stayed anywhere.
    let required = asked.is_required() && tails.is_some();
    loss_tolerant && (power_tolerant || asked != LossTolerance::Power) || !required
}
