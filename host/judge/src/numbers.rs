//! Check of numbers: every number of a plan is finite, and not negative where it cannot be.

use super::{Condition, Judge};

/// Looks at every number.
pub(super) fn check(judge: &mut Judge<'_>) {
    let plan = judge.plan;
    let mut bad: Vec<(Option<usize>, f64, String)> = Vec::new();
    let mut see = |index, values: &[f64], what: &str| {
        for &value in values.iter().filter(|value| !value.is_finite()) {
            bad.push((index, 0.0, format!("{what} = {value}")));
        }
    };
    see(
        None,
        &[plan.energy_navigate_j, plan.energy_balance_j, plan.energy_total_j, plan.time_s],
        "a sum of the plan",
    );
    see(None, plan.lower_bound_j.as_slice(), "lower_bound_j");
    see(None, plan.gap.as_slice(), "gap");
    for placed in &plan.robots {
        see(None, &<[f64; 4]>::from(placed.start), &format!("start of robot {}", placed.id));
    }
    for (number, slot) in plan.slots.iter().enumerate() {
        see(None, &<[f64; 4]>::from(*slot), &format!("slot {}", number + 1));
    }
    for (index, own) in plan.moves.iter().enumerate() {
        let at = Some(index);
        see(at, own.path.as_flattened(), "a corner of the path");
        if let Some(to) = own.to {
            see(at, &<[f64; 4]>::from(to), "where it parks");
        }
        see(at, &[own.start_s, own.duration_s], "a time");
        see(at, &[own.energy_navigate_j, own.energy_balance_j, own.balance_w], "an energy or power");
        for holding in &own.balance {
            see(at, &holding.thrusts_n, &format!("a thrust of robot {}", holding.robot));
        }
        for action in &own.actions {
            see(at, &<[f64; 4]>::from(action.from), "where an action begins");
            see(at, &<[f64; 4]>::from(action.to), "where an action ends");
            see(
                at,
                &[action.start_s, action.duration_s, action.speed, action.energy_j],
                "a number of an action",
            );
            see(at, action.acceleration.as_slice(), "an acceleration");
        }
    }
    for interval in &plan.intervals {
        see(None, &[interval.start_s, interval.duration_s, interval.balance_w], "a number of an interval");
        for holding in &interval.balance {
            see(None, &holding.thrusts_n, &format!("a thrust of robot {}", holding.robot));
        }
    }
    for (index, time_s, message) in bad {
        judge.add(index, time_s, Condition::Number, message);
    }
}
