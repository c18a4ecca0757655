//! The paper's rule: of all robots and slots left, the pair of least g + h moves next.

use super::finder::{Finder, Stopped};
use super::{MoveCosts, Order, State};

/// Why the rule gives no order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoRule {
    /// In this state no robot can move.
    DeadEnd(State),
    /// It was stopped.
    Stopped,
}

impl<C: MoveCosts> Finder<'_, C> {
    /// The order of the paper's rule, one move a robot. It is known to the search from then on.
    ///
    /// # Errors
    /// [`NoRule`].
    pub fn by_paper(&mut self) -> Result<Order, NoRule> {
        let costs = self.costs();
        let layout = costs.layout();
        let mut state = State::default();
        let mut order = Order { moves: Vec::new(), cost: 0.0 };
        for _ in 0..layout.robots() {
            let hops: Vec<_> = (layout.hops(&state))
                .filter(|&(hop, kind)| {
                    let (from, to) = hop.ends();
                    layout.slot(to).is_some()
                        && costs.bound(from, kind, to).is_some()
                        && costs.may_fill(layout.filled(&layout.after(&state, hop)))
                })
                .map(|(hop, _)| (state, hop))
                .collect();
            let prices = self.prices(&hops).map_err(|Stopped| NoRule::Stopped)?;
            let best = hops.iter().zip(prices).filter(|(_, price)| price.is_finite());
            let best = best.min_by(|a, b| a.1.total_cmp(&b.1));
            let (&(_, hop), cost) = best.ok_or(NoRule::DeadEnd(state))?;
            order.moves.push(hop);
            order.cost += cost;
            state = layout.after(&state, hop);
        }
        self.set_rule(order.cost);
        self.learn(&order);
        Ok(order)
    }
}
