//! `--task`: the goal is found, not given.

use std::path::Path;

use quantity::{Range, check_ranges};
use reader::Document;
use reader::file::{WRITTEN_MAX, text_of};
use reconfiguration::problem::Problem;
use reconfiguration::task::Task;
use rov::morphology::{Found, MorphologyError, goal};
use rov::planner::{PlanError, Request};

use super::super::{Failure, bad};

/// The problem with the goal of least energy for the task in a file, and what is to be said of it.
pub(super) fn found(problem: &Problem, path: &Path, request: &Request) -> Result<(Problem, String), Failure> {
    let name = path.display();
    let text = text_of(path, WRITTEN_MAX).map_err(bad)?;
    let text = text.ok_or_else(|| Failure::Bad(format!("{name}: no such file")))?;
    let task: Task = Document::toml(&text)
        .and_then(|document| document.read())
        .map_err(|mistake| bad(mistake.in_file(&name.to_string())))?;
    sound(&task).map_err(|why| Failure::Bad(format!("{name}: {why}")))?;
    let found = goal(problem, &task, request).map_err(|error| match error {
        MorphologyError::Incapable { .. }
        | MorphologyError::Plan(
            PlanError::Propulsion { .. } | PlanError::Power(_) | PlanError::TooMany { .. },
        ) => Failure::Bad(format!("{name}: {error}")),
        error => Failure::Could(format!("{name}: {error}")),
    })?;
    let Found { problem, planned, configurations, tried, proved } = found;
    let least = if proved { "proved least" } else { "the least found" };
    let said = format!(
        "{configurations} configurations do the task, {tried} were planned for: {:.2} J, {least}",
        planned.plan.energy_total_j
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
