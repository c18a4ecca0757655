//! `flotilla plan`: a filter. One JSON request a line in, one JSON plan a line out, flushed; a line that is no request
//! gives an `{"error": …}` line and the stream goes on.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use modboat::distance::DistanceToCollision;
use modboat::distance_table::DistanceTable;
use modboat::motion::{Swing, Turn, Wrench};
use modboat::parameters::Parameters;
use modboat::plan::{Outcome, Plan};
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::structure::Structure;
use serde::Serialize;

use super::planner::PlannerArguments;
use super::progress::Bar;
use super::request::{Previous, Request, Tails};
use super::{Failure, bad, envelope, filter, tell};
use crate::run::distances;
use crate::run::scenario::Scenario;

/// Greatest angle that is taken for a tail's, rad.
const TAIL_MAX_RAD: f64 = 1e6;

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  echo '{\"cells\":[[0,0],[1,0],[2,0]],\
                        \"demand\":{\"fx_n\":0.02,\"fy_n\":0.0,\"tau_nm\":0.0},\"tail_rad\":null}' | flotilla plan\n  \
                        echo '{\"cells\":[[0,0],[1,0],[2,0]],\
                        \"demand\":{\"fx_n\":0.2,\"fy_n\":0.0,\"tau_nm\":0.01}}' \
                        | flotilla plan --envelope --plot envelope.svg\n\n\
                        \"tail_rad\" holds the tails' present angles (rad, unwrapped), null for a first cycle, or\n\
                        \"previous\" to go on from this stream's last plan.")]
pub(super) struct Arguments {
    #[command(flatten)]
    planner: PlannerArguments,
    /// Take modules and planner settings from this scenario
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Plan nothing: tell for each demand how far it lies inside or outside of what the modules could give together if
    /// no tail were in another's way
    #[arg(long, conflicts_with_all = ["planner", "loss_tolerant"])]
    envelope: bool,
    /// Draw the first request's envelope with the demands on it
    #[arg(long, value_name = "FILE", requires = "envelope")]
    plot: Option<PathBuf>,
}

#[derive(Serialize)]
struct Reply<'a> {
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

/// Planners and the last plan, kept from line to line.
struct Stream {
    parameters: Parameters,
    config: PlannerConfig,
    distance: Arc<DistanceToCollision>,
    table: Option<Arc<DistanceTable>>,
    planners: HashMap<Vec<[i32; 2]>, Planner>,
    previous: Option<Last>,
}

/// What the last plan leaves: for which structure, the plan, and where the tails end.
struct Last {
    cells: Vec<[i32; 2]>,
    plan: Plan,
    ends_rad: Vec<f64>,
    /// Nothing has moved since.
    is_over: bool,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let (parameters, mut config) = match &arguments.scenario {
        Some(name) => {
            let scenario = Scenario::open(name).map_err(bad)?;
            (scenario.modboat, scenario.planner)
        }
        None => (Parameters::default(), PlannerConfig::default()),
    };
    if arguments.envelope {
        return envelope::main(&parameters, arguments.plot.as_deref());
    }
    arguments.planner.apply(&mut config);
    let distance = Arc::new(DistanceToCollision::new(&parameters));
    // Shows itself on a terminal only, and only if there is a table to load.
    let table = distances::table(&parameters, &config, &mut Bar::new("plan"));
    let mut stream = Stream { parameters, config, distance, table, planners: HashMap::new(), previous: None };
    filter::run(|number, line| stream.answer(number, line))
}

impl Stream {
    fn answer(&mut self, number: u64, line: &str) -> Result<String, String> {
        let request = Request::read(line)?;
        let modules = request.cells.len();
        self.prepare(&request.cells)?;
        let (tails, previous) = match request.tail_rad {
            Tails::Unknown => (None, None),
            Tails::Angles(angles) => {
                check(&angles, modules)?;
                let same = self.previous.as_ref().filter(|last| last.cells == request.cells);
                (Some(angles), same)
            }
            Tails::Word(Previous::Previous) => {
                let last =
                    self.previous.as_ref().ok_or("tail_rad is \"previous\", but no plan came before")?;
                if last.cells != request.cells {
                    return Err(
                        "tail_rad is \"previous\", but the plan before was for other cells".to_owned()
                    );
                }
                (Some(last.ends_rad.clone()), Some(last))
            }
        };
        let planner = self.planners.get_mut(&request.cells).ok_or("no planner")?;
        let began = Instant::now();
        let previous =
            previous.map(|last| modboat::plan::Previous { is_over: last.is_over, ..last.plan.as_previous() });
        let mut plan = Plan::default();
        planner.plan_into(request.demand, tails.as_deref(), previous, &mut plan);
        let solve_us = began.elapsed().as_micros() as u64;
        if plan.outside_envelope {
            let share = 100.0 * (1.0 - plan.error);
            tell(&format!(
                "line {number}: the demand lies outside the envelope: {share:.1} % of it in the same direction (--envelope tells more)"
            ));
        }
        let reply = Reply {
            outcome: plan.outcome.name(),
            cycle: &plan.cycle,
            transition: rotations(&plan),
            wrench: plan.wrench,
            error: plan.error,
            travel_rad: plan.travel_rad,
            // Alone, a module has nothing to be clear of; JSON has no infinity.
            clearance_m: Some(plan.clearance_m).filter(|clearance_m| clearance_m.is_finite()),
            guarantee_m: plan.guarantee_m.filter(|guarantee_m| guarantee_m.is_finite()),
            loss_tolerant: plan.loss_tolerant,
            reason: plan.reason.map(|reason| reason.to_string()),
            planner: self.config.kind.name(),
            solve_us,
        };
        let answer = serde_json::to_string(&reply).map_err(|error| error.to_string())?;
        let ends_rad = match (&plan.transition, tails) {
            (Some(turns), _) => turns.iter().map(|turn| turn.to_rad).collect(),
            (None, Some(tails)) => tails,
            (None, None) => plan.cycle.iter().map(|swing| swing.start_rad()).collect(),
        };
        // A held fleet swims nothing that could be repeated.
        match &mut self.previous {
            Some(last) if plan.outcome == Outcome::Held => (last.ends_rad, last.is_over) = (ends_rad, true),
            previous => *previous = Some(Last { cells: request.cells, plan, ends_rad, is_over: false }),
        }
        Ok(answer)
    }

    /// Makes the planner for `cells` if there is none yet.
    fn prepare(&mut self, cells: &[[i32; 2]]) -> Result<(), String> {
        if !self.planners.contains_key(cells) {
            let structure = Structure::from_cells(cells).map_err(|error| format!("cells: {error}"))?;
            let distance = Arc::clone(&self.distance);
            let mut planner = Planner::with_distance(&structure, &self.parameters, &self.config, distance);
            if let Some(table) = &self.table {
                planner = planner.with_table(Arc::clone(table));
            }
            // A stream about ever new structures must not grow without bound.
            if self.planners.len() >= 64 {
                self.planners.clear();
            }
            self.planners.insert(cells.to_vec(), planner);
        }
        Ok(())
    }
}

fn rotations(plan: &Plan) -> Option<Vec<Rotation>> {
    let via = |module: usize| plan.via_rad.as_ref().map(|via| via[module]);
    let turns = plan.transition.as_ref()?.iter().enumerate();
    Some(turns.map(|(module, &turn)| Rotation { turn, via_rad: via(module) }).collect())
}

fn check(angles: &[f64], modules: usize) -> Result<(), String> {
    if angles.len() != modules {
        return Err(format!("tail_rad has {} angles for {modules} cells", angles.len()));
    }
    match angles.iter().position(|angle| !angle.is_finite() || angle.abs() > TAIL_MAX_RAD) {
        Some(index) => Err(format!(
            "tail_rad[{index}] = {:e} rad: must be at most {TAIL_MAX_RAD:e} in size",
            angles[index]
        )),
        None => Ok(()),
    }
}
