//! The figures of plans beside each other, like Table I of the paper.

use std::io::Write;

use reconfiguration::plan::{ActionKind, Criterion};
use reconfiguration::problem::Problem;

use rov::planner::Planned;

use super::{Column, Made};
use crate::run::reconfigure::phases::Phases;
use crate::run::reconfigure::summary::Summary;

/// Prints a row a figure, a column a plan.
pub(super) fn print(
    out: &mut impl Write,
    problem: &Problem,
    columns: &[Column],
    power: &str,
) -> std::io::Result<()> {
    writeln!(
        out,
        "{}: {}, {}, {}; power by {power}",
        problem.name,
        count(problem.robots.len(), "robot"),
        count(problem.slots.len(), "slot"),
        count(problem.tools.len(), "tool")
    )?;
    writeln!(out)?;
    write!(out, "  {:<34}", "")?;
    for column in columns {
        write!(out, "{:>11}", column.title)?;
    }
    writeln!(out)?;
    let mut row = |name: &str, of: &dyn Fn(&Made) -> f64| -> std::io::Result<()> {
        write!(out, "  {name:<34}")?;
        for column in columns {
            write!(out, "{:>11}", figure(column.made().map_or(f64::NAN, of)))?;
        }
        writeln!(out)
    };
    row("planned: to navigate, J", &|c| c.planned.plan.energy_navigate_j)?;
    row("         to balance, J", &|c| c.planned.plan.energy_balance_j)?;
    row("         total, J", &|c| c.planned.plan.energy_total_j)?;
    row("         time, s", &|c| c.planned.plan.time_s)?;
    if columns.iter().filter_map(Column::made).all(|made| made.executed.is_some()) {
        let energy =
            |c: &Made, of: fn(&Summary) -> f64| c.executed.as_ref().map_or(f64::NAN, |e| of(&e.summary));
        row("executed: to navigate, J", &|c| energy(c, |s| s.executed.navigate_j))?;
        row("          to balance, J", &|c| energy(c, |s| s.executed.balance_j))?;
        row("          total, J", &|c| energy(c, |s| s.executed.total_j))?;
        row("          time, s", &|c| energy(c, |s| s.executed.time_s))?;
        row("          total over planned", &|c| energy(c, |s| s.ratio.unwrap_or(f64::NAN)))?;
        row("          total over expected", &|c| energy(c, |s| s.executed.total_j / s.expected.total_j))?;
        row("          least gap of hulls, mm", &|c| {
            energy(c, |s| 1e3 * s.least_gap_m().unwrap_or(f64::NAN))
        })?;
        row("          by the T200 table, J", &|c| energy(c, |s| s.by_table.total_j))?;
    }
    writeln!(out)?;
    for Column { title, made, .. } in columns {
        let planned = match made {
            Ok(made) => &made.planned,
            Err(why) => {
                writeln!(out, "  {title}: no plan: {why}")?;
                continue;
            }
        };
        if planned.plan.moves.is_empty() {
            writeln!(out, "  {title}: nothing to do, every robot is in a slot")?;
            continue;
        }
        let unit = match planned.plan.criterion {
            Criterion::Energy => "J",
            Criterion::Euclidean => "m",
        };
        let proof = proof(planned);
        writeln!(out, "  {title}: {:.2} {unit}{proof} ({} moves priced)", planned.cost, planned.priced)?;
        match planned.rule_cost {
            Some(rule) if planned.proved => writeln!(
                out,
                "    the paper's order, least g + h next, would take {rule:.2} {unit}: {:.1} % more",
                100.0 * (rule / planned.cost - 1.0)
            )?,
            None => writeln!(out, "    the paper's order, least g + h next, ends where no robot can move")?,
            Some(_) => {}
        }
        for part in &planned.plan.moves {
            let turns = part.actions.iter().filter(|action| action.kind == ActionKind::Turn).count();
            writeln!(
                out,
                "    robot {} to {}: {} legs, {turns} turns, {:.1} s, {:.1} J and {:.2} W to balance",
                part.robot,
                part.destination(),
                part.path.len().saturating_sub(1),
                part.duration_s,
                part.energy_navigate_j,
                part.balance_w
            )?;
        }
    }
    for column in columns {
        let title = column.title;
        if let Some(executed) = column.executed() {
            writeln!(out, "  {title}:\n{}", Phases::of(&executed.record))?;
        }
        let Some(summary) = column.executed().map(|executed| &executed.summary) else { continue };
        for gap in &summary.gaps {
            writeln!(
                out,
                "  {title}: the host did not run for {:.1} s at {:.1} s",
                gap.length_s, gap.start_s
            )?;
        }
        for shortfall in &summary.shortfalls {
            writeln!(out, "  {title}: {shortfall}")?;
        }
    }
    writeln!(out)
}

/// What is known of the order, and over what.
fn proof(planned: &Planned) -> String {
    if planned.plan.proved.is_none() {
        return String::new();
    }
    let over = match planned.moves {
        1 => "over all orders and assignments, one move a robot, by these routes".to_owned(),
        n => format!(
            "over all orders and assignments with at most {n} moves a robot, by these routes and parking places"
        ),
    };
    match planned.gap() {
        _ if planned.proved => format!(", proved least {over}"),
        Some(gap) if planned.samples_sets => format!(
            ", within {:.1} % of the least {over}, unless robots at rest that were not looked at balance for less",
            100.0 * gap
        ),
        Some(gap) => format!(", within {:.1} % of the least {over}", 100.0 * gap),
        None => format!(", the best known {over}"),
    }
}

/// With two decimals; a dash for what there is none of, no minus before zero.
fn figure(value: f64) -> String {
    match format!("{value:.2}") {
        _ if !value.is_finite() => "–".to_owned(),
        zero if zero == "-0.00" => "0.00".to_owned(),
        digits => digits,
    }
}

fn count(number: usize, what: &str) -> String {
    match number {
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    }
}
