//! `flotilla plan`: a filter. One JSON request a line in, one JSON plan a line out, flushed; a line that is no request
//! gives an `{"error": …}` line and the stream goes on.

use std::path::PathBuf;

use modboat::parameters::Parameters;
use modboat::planner_config::PlannerConfig;

use super::planner::PlannerArguments;
use super::progress::Bar;
use super::request::Request;
use super::{Failure, bad, envelope, filter, tell};
use crate::answer::plan::{Reply, Stream};
use crate::run::scenario::Scenario;

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
    // Shows itself on a terminal only, and only if there is a table to load.
    let mut stream = Stream::new(parameters, config, &mut Bar::new("plan"));
    filter::run(|number, line| answer(&mut stream, number, line))
}

fn answer(stream: &mut Stream, number: u64, line: &str) -> Result<String, String> {
    let request = Request::read(line)?;
    let planner = stream.planner();
    let (plan, took) = stream.plan(&request.cells, request.demand, request.tail_rad.into())?;
    if plan.outside_envelope {
        let share = 100.0 * (1.0 - plan.error);
        tell(&format!(
            "line {number}: the demand lies outside the envelope: {share:.1} % of it in the same direction (--envelope tells more)"
        ));
    }
    serde_json::to_string(&Reply::new(plan, planner, took)).map_err(|error| error.to_string())
}
