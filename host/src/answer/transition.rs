//! Which way round each tail turns into a given cycle: the question of §II-E, one step, amplitudes negated all or none.

use std::sync::Arc;

use modboat::distance::DistanceToCollision;
use modboat::motion::{StepTime, Swing};
use modboat::parameters::Parameters;
use modboat::planner_config::PlannerConfig;
use modboat::setting::Setting;
use modboat::structure::Structure;
use modboat::transition::solver::Solver;
use modboat::transition::{self, Transition};

/// The transition of least travel from tails at `from_rad` into `cycle`, and its times. `None` where it is proved that there is none.
///
/// # Errors
/// Cells that are no structure; lists of another length than theirs.
pub fn least(
    cells: &[[i32; 2]],
    from_rad: &[f64],
    cycle: &[Swing],
    parameters: &Parameters,
    config: &PlannerConfig,
) -> Result<Option<(Transition, StepTime)>, String> {
    let structure = Structure::from_cells(cells).map_err(|error| format!("cells: {error}"))?;
    super::plan::check_tails(from_rad, structure.len())?;
    if cycle.len() != structure.len() {
        return Err(format!("the cycle has {} swings for {} cells", cycle.len(), structure.len()));
    }
    let whole = |value: f64| value.is_finite();
    if let Some(index) = cycle.iter().position(|s| !whole(s.centerline_rad) || !whole(s.amplitude_rad)) {
        return Err(format!("the swing of module {} is no number", index + 1));
    }
    let distance = Arc::new(DistanceToCollision::new(parameters));
    let setting = Setting::new(&structure, parameters, config, distance);
    let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| setting.may_turn(offset, from, to);
    let (mut solver, mut found) = (Solver::with_room(&setting.pairs), Transition::default());
    let limit_rad = setting.rotation_max_rad();
    if !transition::solve(&mut solver, &setting.pairs, from_rad, cycle, limit_rad, clear, &mut found) {
        return Ok(None);
    }
    let longest_rad = found.turns.iter().map(|turn| turn.rotation_rad().abs()).fold(0.0, f64::max);
    let times = if longest_rad == 0.0 { StepTime::default() } else { setting.step_time(longest_rad, false) };
    Ok(Some((found, times)))
}
