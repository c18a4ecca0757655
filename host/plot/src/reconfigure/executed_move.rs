//! Each move of a plan with the samples of its execution, from a record.

use reconfiguration::plan::{Criterion, Manner, Move, Plan};
use record::reconfigure::{Record, Sample};

/// One move and the samples of its execution.
#[derive(Clone, Copy, Debug)]
pub struct ExecutedMove<'r> {
    /// The move as planned.
    pub planned: &'r Move,
    /// The mover: index into the robots of the problem.
    pub robot: usize,
    /// While it was under way; empty if it never was.
    pub samples: &'r [Sample],
    /// The instant after it, or the last one of it.
    pub after: Option<&'r Sample>,
}

/// Every move of a record whose robot is known, in order.
#[must_use]
pub fn executed_moves(record: &Record) -> Vec<ExecutedMove<'_>> {
    let known = |m: &Move| record.problem.robots.iter().position(|r| r.id == m.robot);
    let moves = record.plan.moves.iter().enumerate();
    moves
        .filter_map(|(number, planned)| {
            let under_way = |s: &Sample| s.moving == Some(number);
            let first = record.samples.iter().position(under_way);
            let last = record.samples.iter().rposition(under_way);
            let (samples, after) = match (first, last) {
                (Some(first), Some(last)) => {
                    (record.samples.get(first..=last)?, record.samples.get(last + 1))
                }
                _ => (&record.samples[..0], None),
            };
            Some(ExecutedMove { planned, robot: known(planned)?, samples, after: after.or(samples.last()) })
        })
        .collect()
}

impl ExecutedMove<'_> {
    /// When it began and ended, s: as executed, or as planned if it was not.
    #[must_use]
    pub fn span_s(&self) -> (f64, f64) {
        let planned = (self.planned.start_s, self.planned.start_s + self.planned.duration_s);
        let executed = self.samples.first().zip(self.after).map(|(first, after)| (first.t_s, after.t_s));
        executed.filter(|(from, to)| from.is_finite() && to.is_finite()).unwrap_or(planned)
    }

    /// What all robots drew while it was under way, J; `None` if it was not executed.
    #[must_use]
    pub fn executed_j(&self) -> Option<f64> {
        let last = self.samples.last()?;
        let until = self.after.filter(|a| a.t_s > last.t_s);
        Some(cumulated_j(self.samples.iter().chain(until)).last()?.1)
    }
}

/// What all robots together draw, W.
#[must_use]
pub fn total_w(sample: &Sample) -> f64 {
    sample.robots.iter().map(|r| r.power_w).filter(|p| p.is_finite()).sum()
}

/// ∫ P dt of all robots from the first sample on, by trapezia: (s, J).
#[must_use]
pub fn cumulated_j<'s>(samples: impl Iterator<Item = &'s Sample>) -> Vec<(f64, f64)> {
    let mut energy_j = 0.0;
    let mut before: Option<(f64, f64)> = None;
    samples
        .filter(|s| s.t_s.is_finite())
        .map(|sample| {
            let now = (sample.t_s, total_w(sample));
            if let Some((t_s, power_w)) = before {
                energy_j += 0.5 * (power_w + now.1) * (now.0 - t_s);
            }
            before = Some(now);
            (sample.t_s, energy_j)
        })
        .collect()
}

/// What a plan is called beside others of the same problem.
#[must_use]
pub fn label(plan: &Plan) -> &'static str {
    match (plan.criterion, plan.manner) {
        (Criterion::Energy, Manner::Paper) => "Energy",
        (Criterion::Euclidean, Manner::Paper) => "Euclidean",
        (Criterion::Energy, Manner::Best) => "Best",
        (Criterion::Euclidean, Manner::Best) => "Euclidean, best rules",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconfigure::sample;

    #[test]
    fn moves_follow_each_other_and_share_out_all_energy() {
        let record = &sample::far()[0];
        let moves = executed_moves(record);
        assert_eq!(moves.iter().map(|c| c.robot).collect::<Vec<_>>(), [1, 0, 3, 2]);
        for pair in moves.windows(2) {
            assert!((pair[0].span_s().1 - pair[1].span_s().0).abs() < 1e-12);
        }
        let whole = cumulated_j(record.samples.iter()).last().expect("samples").1;
        let parts: f64 = moves.iter().filter_map(ExecutedMove::executed_j).sum();
        assert!((whole - parts).abs() < 1e-9 * whole, "{whole} J, in parts {parts} J");
    }

    #[test]
    fn a_constant_power_cumulates_in_a_straight_line() {
        let mut record = sample::far()[0].clone();
        for sample in &mut record.samples {
            for robot in &mut sample.robots {
                robot.power_w = 0.75;
            }
        }
        for (t_s, energy_j) in cumulated_j(record.samples.iter()) {
            assert!((energy_j - 3.0 * t_s).abs() < 1e-9);
        }
    }

    #[test]
    fn what_was_never_under_way_has_its_planned_times() {
        let mut record = sample::far()[0].clone();
        record.samples.clear();
        let moves = executed_moves(&record);
        assert_eq!(moves.len(), 4);
        for moved in moves {
            assert!((moved.span_s().0 - moved.planned.start_s).abs() < 1e-12);
            assert_eq!(moved.executed_j(), None);
        }
    }
}
