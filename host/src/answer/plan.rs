//! A stream of demands, and the plan for each: `flotilla plan`, and `Planner` of the Python package.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use modboat::distance::DistanceToCollision;
use modboat::distance_table::DistanceTable;
use modboat::motion::{Swing, Turn, Wrench};
use modboat::parameters::Parameters;
use modboat::plan::{Outcome, Plan, Previous};
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::structure::Structure;
use serde::Serialize;

use crate::run::distances;
use crate::run::progress::Progress;

/// Greatest angle that is taken for a tail's, rad.
const TAIL_MAX_RAD: f64 = 1e6;
/// Greatest force (N) and torque (N·m) that is taken for a demand.
const DEMAND_MAX: f64 = 1e6;
/// A stream about ever new structures must not grow without bound.
const PLANNERS_MAX: usize = 64;

/// What is known of the tails before a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Tails {
    /// Nothing.
    #[default]
    Unknown,
    /// Their present angles by module, rad, unwrapped.
    Angles(Vec<f64>),
    /// They are where this stream's last plan leaves them.
    Previous,
}

/// A plan as JSON.
#[derive(Serialize)]
pub struct Reply<'a> {
    outcome: &'static str,
    cycle: &'a [Swing],
    transition: Option<Vec<Rotation>>,
    wrench: Wrench,
    error: f64,
    travel_rad: f64,
    clearance_m: Option<f64>,
    /// Not said where nothing is guaranteed.
    #[serde(skip_serializing_if = "Option::is_none")]
    guarantee_m: Option<f64>,
    loss_tolerant: bool,
    /// Why nothing moves, where nothing does.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    planner: &'static str,
    solve_us: u64,
}

/// One module's part of a transition.
#[derive(Serialize)]
struct Rotation {
    #[serde(flatten)]
    turn: Turn,
    /// Where it is between the two steps of a transition that has two.
    #[serde(skip_serializing_if = "Option::is_none")]
    via_rad: Option<f64>,
}

impl<'a> Reply<'a> {
    /// Of a plan that this planner made in this time.
    #[must_use]
    pub fn new(plan: &'a Plan, planner: &'static str, took: Duration) -> Self {
        Self {
            outcome: plan.outcome.name(),
            cycle: &plan.cycle,
            transition: rotations(plan),
            wrench: plan.wrench,
            error: plan.error,
            travel_rad: plan.travel_rad,
            clearance_m: clearance_m(plan),
            guarantee_m: guarantee_m(plan),
            loss_tolerant: plan.loss_tolerant,
            reason: plan.reason.map(|reason| reason.to_string()),
            planner,
            solve_us: took.as_micros() as u64,
        }
    }
}

/// Least distance between two tails, m; `None` alone: a module has nothing to be clear of, and JSON has no infinity.
#[must_use]
pub fn clearance_m(plan: &Plan) -> Option<f64> {
    Some(plan.clearance_m).filter(|clearance_m| clearance_m.is_finite())
}

/// The same for tails with errors; `None` where nothing is guaranteed, or where no two tails can meet.
#[must_use]
pub fn guarantee_m(plan: &Plan) -> Option<f64> {
    plan.guarantee_m.filter(|guarantee_m| guarantee_m.is_finite())
}

fn rotations(plan: &Plan) -> Option<Vec<Rotation>> {
    let via = |module: usize| plan.via_rad.as_ref().map(|via| via[module]);
    let turns = plan.transition.as_ref()?.iter().enumerate();
    Some(turns.map(|(module, &turn)| Rotation { turn, via_rad: via(module) }).collect())
}

/// Planners and the last plan, kept from demand to demand.
pub struct Stream {
    parameters: Parameters,
    config: PlannerConfig,
    distance: Arc<DistanceToCollision>,
    table: Option<Arc<DistanceTable>>,
    planners: HashMap<Vec<[i32; 2]>, Planner>,
    previous: Option<Last>,
    /// What is written into next.
    spare: Plan,
}

/// What the last plan leaves: for which structure, the plan, and where the tails end.
struct Last {
    cells: Vec<[i32; 2]>,
    plan: Plan,
    ends_rad: Vec<f64>,
    /// Nothing has moved since.
    is_over: bool,
}

impl Stream {
    /// Of modules and a planner. A potential field may want a table, which takes time if it is not kept yet.
    pub fn new(parameters: Parameters, config: PlannerConfig, progress: &mut dyn Progress) -> Self {
        let distance = Arc::new(DistanceToCollision::new(&parameters));
        let table = distances::table(&parameters, &config, progress);
        Self {
            parameters,
            config,
            distance,
            table,
            planners: HashMap::new(),
            previous: None,
            spare: Plan::default(),
        }
    }

    /// The planner's name.
    #[must_use]
    pub fn planner(&self) -> &'static str {
        self.config.kind.name()
    }

    /// The plan for `demand`, and how long the planner took for it.
    ///
    /// # Errors
    /// Cells that are no structure, a demand or an angle that cannot be, a count of angles that is not that of the modules, tails
    /// at a previous plan that is not there. Then the stream is as it was.
    pub fn plan(
        &mut self,
        cells: &[[i32; 2]],
        demand: Wrench,
        tails: Tails,
    ) -> Result<(&Plan, Duration), String> {
        check_demand(demand)?;
        self.prepare(cells)?;
        let (tails, previous) = match tails {
            Tails::Unknown => (None, None),
            Tails::Angles(angles) => {
                check_tails(&angles, cells.len())?;
                let same = self.previous.as_ref().filter(|last| last.cells == cells);
                (Some(angles), same)
            }
            Tails::Previous => {
                let last =
                    self.previous.as_ref().ok_or("tail_rad is \"previous\", but no plan came before")?;
                if last.cells != cells {
                    return Err(
                        "tail_rad is \"previous\", but the plan before was for other cells".to_owned()
                    );
                }
                (Some(last.ends_rad.clone()), Some(last))
            }
        };
        let planner = self.planners.get_mut(cells).ok_or("no planner")?;
        let mut plan = std::mem::take(&mut self.spare);
        let began = Instant::now();
        let previous = previous.map(|last| Previous { is_over: last.is_over, ..last.plan.as_previous() });
        planner.plan_into(demand, tails.as_deref(), previous, &mut plan);
        let took = began.elapsed();
        let ends_rad = match (&plan.transition, tails) {
            (Some(turns), _) => turns.iter().map(|turn| turn.to_rad).collect(),
            (None, Some(tails)) => tails,
            (None, None) => plan.cycle.iter().map(|swing| swing.start_rad()).collect(),
        };
        // A held fleet swims nothing that could be repeated.
        if plan.outcome == Outcome::Held && self.previous.is_some() {
            if let Some(last) = &mut self.previous {
                (last.ends_rad, last.is_over) = (ends_rad, true);
            }
            self.spare = plan;
            return Ok((&self.spare, took));
        }
        let last = self.previous.insert(Last { cells: cells.to_vec(), plan, ends_rad, is_over: false });
        Ok((&last.plan, took))
    }

    /// A planner for `cells`, made if there is none yet.
    ///
    /// # Errors
    /// Cells that are no structure.
    pub fn prepare(&mut self, cells: &[[i32; 2]]) -> Result<&Planner, String> {
        if !self.planners.contains_key(cells) {
            let structure = Structure::from_cells(cells).map_err(|error| format!("cells: {error}"))?;
            let distance = Arc::clone(&self.distance);
            let mut planner = Planner::with_distance(&structure, &self.parameters, &self.config, distance);
            if let Some(table) = &self.table {
                planner = planner.with_table(Arc::clone(table));
            }
            if self.planners.len() >= PLANNERS_MAX {
                self.planners.clear();
            }
            self.planners.insert(cells.to_vec(), planner);
        }
        self.planners.get(cells).ok_or_else(|| "no planner".to_owned())
    }
}

/// Whether a demand can be computed with.
///
/// # Errors
/// Which of its numbers cannot, and what may be.
pub fn check_demand(demand: Wrench) -> Result<(), String> {
    let Wrench { fx_n, fy_n, tau_nm } = demand;
    for (key, value, unit) in [("fx_n", fx_n, "N"), ("fy_n", fy_n, "N"), ("tau_nm", tau_nm, "N·m")] {
        if !value.is_finite() || value.abs() > DEMAND_MAX {
            return Err(format!("demand.{key} = {value:e} {unit}: must be at most {DEMAND_MAX:e} in size"));
        }
    }
    Ok(())
}

/// Whether these can be the angles of the tails of so many modules.
///
/// # Errors
/// Which cannot, and what may be.
pub fn check_tails(angles_rad: &[f64], modules: usize) -> Result<(), String> {
    if angles_rad.len() != modules {
        return Err(format!("tail_rad has {} angles for {modules} cells", angles_rad.len()));
    }
    match angles_rad.iter().position(|angle| !angle.is_finite() || angle.abs() > TAIL_MAX_RAD) {
        Some(index) => Err(format!(
            "tail_rad[{index}] = {:e} rad: must be at most {TAIL_MAX_RAD:e} in size",
            angles_rad[index]
        )),
        None => Ok(()),
    }
}
