//! Whether the demand of a leg has settled.
//!
//! Rest poses are chosen for the demands of a start or a turn, which are great. Once those are over, the one that lasts may be met from
//! rest poses that are better otherwise, which is worth a transition.

use modboat::motion::Wrench;

/// So many decisions of a leg in a row tell. *Assumed.*
const DECISIONS: usize = 4;
/// They differ from their mean by this share of it at most. *Assumed*: the noise of motion capture makes up 3 % of it.
const SPREAD: f64 = 0.2;
/// At so many decisions of a leg it counts as settled: what was not found then is not to be had.
const TIMES: u32 = 4;
/// After so many of these it is told by other demands.
const AGAIN: u32 = 2;

/// The demands of the last decisions.
#[derive(Debug, Default)]
pub(super) struct Settling {
    leg: usize,
    last: [Wrench; DECISIONS],
    count: usize,
    times: u32,
}

impl Settling {
    /// Whether it has at the decision that asks for `demand`, at a few decisions of each leg.
    pub(super) fn is_settled(&mut self, leg: usize, demand: Wrench, weights: &[f64; 3]) -> bool {
        if leg != self.leg {
            (self.leg, self.count, self.times) = (leg, 0, 0);
        }
        self.last[self.count % DECISIONS] = demand;
        self.count += 1;
        if self.count < DECISIONS || self.times >= TIMES {
            return false;
        }
        let mean = self.last.iter().fold(Wrench::default(), |sum, &demand| sum + demand);
        let mean = Wrench::from_array(mean.to_array().map(|component| component / DECISIONS as f64));
        let near_n = SPREAD * mean.weighted_norm(*weights);
        let settled = self.last.iter().all(|&demand| (demand - mean).weighted_norm(*weights) <= near_n);
        if settled {
            self.times += 1;
            self.count = if self.times == AGAIN { 0 } else { self.count };
        }
        settled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEIGHTS: [f64; 3] = [1.0, 1.0, 10.0];

    fn surge(fy_n: f64) -> Wrench {
        Wrench { fy_n, ..Wrench::default() }
    }

    #[test]
    fn a_demand_settles_once_it_lasts_and_for_a_few_decisions_of_each_leg() {
        let mut settling = Settling::default();
        for leg in 0..2 {
            let asked = [
                0.08, 0.05, 0.03, 0.022, 0.021, 0.0216, 0.0217, 0.0216, 0.0216, 0.0216, 0.0216, 0.0216,
                0.0216, 0.0216,
            ];
            let seen: Vec<bool> =
                asked.iter().map(|&fy_n| settling.is_settled(leg, surge(fy_n), &WEIGHTS)).collect();
            assert_eq!(
                seen,
                [
                    false, false, false, false, false, false, true, true, false, false, false, true, true,
                    false
                ],
                "leg {leg}"
            );
        }
    }

    #[test]
    fn a_torque_that_comes_and_goes_does_not_settle() {
        let mut settling = Settling::default();
        for k in 0..20 {
            let demand = Wrench { tau_nm: if k % 2 == 0 { 1e-3 } else { -1e-3 }, ..surge(0.02) };
            assert!(!settling.is_settled(0, demand, &WEIGHTS));
        }
    }
}
