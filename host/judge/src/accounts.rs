//! Checks of timing and energy: actions follow each other without gaps, energies add up.

use reconfiguration::plan::{Action, Move};

use super::{Condition, Judge};

/// Times that differ by less are the same, s.
pub(super) const SAME_S: f64 = 1e-6;
/// Sums may be off by this share.
const SHARE: f64 = 1e-6;

/// Whether a value is the sum that it should be.
pub(super) fn adds_up(value: f64, sum: f64) -> bool {
    (value - sum).abs() <= SHARE * sum.abs().max(1e-3)
}

/// Looks at times and sums of the whole plan.
pub(super) fn check(judge: &mut Judge<'_>) {
    let plan = judge.plan;
    let mut end_s = 0.0;
    for (index, own) in plan.moves.iter().enumerate() {
        if !plan.is_parallel() {
            follows(judge, index, own, end_s);
        }
        end_s = own.start_s + own.duration_s;
        times_of(judge, index, own);
        energies_of(judge, index, own);
    }
    if !plan.is_parallel() && (plan.time_s - end_s).abs() > SAME_S {
        let message = format!("time_s = {:.6} s, the last move ends at {end_s:.6} s", plan.time_s);
        judge.add(None, end_s, Condition::Timing, message);
    }
    let navigate_j = plan.moves.iter().map(|own| own.energy_navigate_j).sum();
    let balance_j = plan.moves.iter().map(|own| own.energy_balance_j).sum();
    for (key, value, sum) in [
        ("energy_navigate_j", plan.energy_navigate_j, navigate_j),
        ("energy_balance_j", plan.energy_balance_j, balance_j),
        ("energy_total_j", plan.energy_total_j, navigate_j + balance_j),
    ] {
        if !adds_up(value, sum) {
            let message = format!("{key} = {value:.6} J, the moves add up to {sum:.6} J");
            judge.add(None, end_s, Condition::Energy, message);
        }
    }
}

/// Whether a move begins when the one before it ends.
fn follows(judge: &mut Judge<'_>, index: usize, own: &Move, end_s: f64) {
    if own.start_s < end_s - SAME_S {
        let message = format!(
            "robot {} sets out at {:.3} s, {:.3} s before the move before it ends",
            own.robot,
            own.start_s,
            end_s - own.start_s
        );
        judge.add(Some(index), own.start_s, Condition::V1, message);
    } else if own.start_s > end_s + SAME_S {
        let message = format!("no robot moves from {end_s:.3} s to {:.3} s", own.start_s);
        judge.add(Some(index), own.start_s, Condition::Timing, message);
    }
}

fn times_of(judge: &mut Judge<'_>, index: usize, own: &Move) {
    let mut wrong = Vec::new();
    if own.duration_s < 0.0 {
        wrong.push(format!("duration_s = {} s", own.duration_s));
    }
    let mut end_s = own.start_s;
    for Action { kind, start_s, duration_s, .. } in &own.actions {
        if (start_s - end_s).abs() > SAME_S {
            wrong.push(format!("{kind:?} begins at {start_s:.6} s, what is before it ends at {end_s:.6} s"));
        }
        if *duration_s < 0.0 {
            wrong.push(format!("{kind:?} takes {duration_s} s"));
        }
        end_s = start_s + duration_s;
    }
    if (own.start_s + own.duration_s - end_s).abs() > SAME_S {
        let (duration_s, took_s) = (own.duration_s, end_s - own.start_s);
        wrong.push(format!("duration_s = {duration_s:.6} s, its actions take {took_s:.6} s"));
    }
    for message in wrong {
        judge.add(Some(index), own.start_s, Condition::Timing, message);
    }
}

fn energies_of(judge: &mut Judge<'_>, index: usize, own: &Move) {
    let mut wrong = Vec::new();
    let actions = own.actions.iter().map(|action| ("energy_j of an action", action.energy_j));
    for (key, value) in
        actions.chain([("energy_balance_j", own.energy_balance_j), ("balance_w", own.balance_w)])
    {
        if value < 0.0 {
            wrong.push(format!("{key} = {value} is negative"));
        }
    }
    let sum: f64 = own.actions.iter().map(|action| action.energy_j).sum();
    if !adds_up(own.energy_navigate_j, sum) {
        let value = own.energy_navigate_j;
        wrong.push(format!("energy_navigate_j = {value:.6} J, its actions add up to {sum:.6} J"));
    }
    // E_bal = ∫ P_bal dt over the move                                                                      (17)
    let balance_j = own.balance_w * own.duration_s;
    if !adds_up(own.energy_balance_j, balance_j) {
        let value = own.energy_balance_j;
        wrong.push(format!("energy_balance_j = {value:.6} J, {:.6} W take {balance_j:.6} J", own.balance_w));
    }
    for message in wrong {
        judge.add(Some(index), own.start_s, Condition::Energy, message);
    }
}
