//! `--task`: the goal is found, not given.

use std::path::Path;

use quantity::{Range, check_ranges};
use reader::Document;
use reader::file::{WRITTEN_MAX, text_of};
use reconfiguration::problem::Problem;
use reconfiguration::task::Task;
use rov::morphology::{Found, MorphologyError, goal_with};
use rov::planner::{PlanError, Request};

use super::super::{Failure, bad};
use super::search::GoalWatch;
use crate::answer::threads::Threads;

/// The problem with the goal of least energy for the task in a file, and what is to be said of it.
pub(super) fn found(
    problem: &Problem,
    path: &Path,
    request: &Request,
    watch: &mut GoalWatch<'_>,
) -> Result<(Problem, String), Failure> {
    let name = path.display();
    let text = text_of(path, WRITTEN_MAX).map_err(bad)?;
    let text = text.ok_or_else(|| Failure::Bad(format!("{name}: no such file")))?;
    let task: Task = Document::toml(&text)
        .and_then(|document| document.read())
        .map_err(|mistake| bad(mistake.in_file(&name.to_string())))?;
    sound(&task).map_err(|why| Failure::Bad(format!("{name}: {why}")))?;
    let found = goal_with(problem, &task, request, &Threads::new(), watch).map_err(|error| match error {
        MorphologyError::Incapable { .. }
        | MorphologyError::Plan(
            PlanError::Propulsion { .. } | PlanError::Power(_) | PlanError::TooMany { .. },
        ) => Failure::Bad(format!("{name}: {error}")),
        error => Failure::Could(format!("{name}: {error}")),
    })?;
    let Found { problem, planned, configurations, tried, bound_j, proved } = found;
    let energy_j = planned.plan.energy_total_j;
    let least = match bound_j {
        _ if proved => "proved least over configurations at right angles, by these routes".to_owned(),
        Some(bound_j) if bound_j > 0.0 => {
            format!("within {:.1} % of the least at right angles", 100.0 * (energy_j / bound_j - 1.0))
        }
        Some(_) => "the least found".to_owned(),
        None => "the least found; the dearest by their bounds were left out while configurations were grown"
            .to_owned(),
    };
    let said = format!(
        "goal: {configurations} configurations do the task, {tried} were planned for: {energy_j:.2} J, {least}"
    );
    Ok((problem, said))
}

fn sound(task: &Task) -> Result<(), quantity::ParameterError> {
    for service in &task.services {
        check_ranges(&service.place_m.map(|value| ("place_m", value, "m", Range::Finite)))?;
        check_ranges(&[("within_m", service.within_m, "m", Range::NonNegative)])?;
    }
    if let Some(passage) = &task.passage {
        check_ranges(&[
            ("heading_rad", passage.heading_rad, "rad", Range::Finite),
            ("width_m", passage.width_m, "m", Range::Positive),
            ("height_m", passage.height_m, "m", Range::Positive),
        ])?;
    }
    Ok(())
}
