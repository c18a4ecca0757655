//! `--parallel`: several robots under way at once.

use clap::ValueEnum;
use reconfiguration::plan::Manner;
use reconfiguration::problem::Problem;
use rov::parallel::overlapped;
use rov::planner::{PlanError, Planned};
use rov::power::PowerLaw;

/// What a second is worth where time is what counts, J/s: more than any cluster draws.
const TIME_W: f64 = 1e3;

#[derive(clap::Args)]
pub(super) struct ParallelArguments {
    /// Several robots under way at once, where that pays [default: one after the other]
    #[arg(long, value_enum, value_name = "CRITERION")]
    parallel: Option<ParallelKind>,
    /// What a second is worth, J/s, instead of the criterion of --parallel
    #[arg(long, value_name = "WEIGHT", requires = "parallel")]
    weight: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ParallelKind {
    /// The least energy
    Energy,
    /// The least time, at no more energy than one after the other
    Time,
}

impl ParallelArguments {
    /// What is wrong with them.
    pub fn check(&self, manner: Manner) -> Result<(), String> {
        if self.parallel.is_some() && manner == Manner::Paper {
            return Err(
                "--parallel is for --manner best: by the paper's rules one robot moves after the other"
                    .to_owned(),
            );
        }
        match self.weight {
            Some(weight) if !(0.0..=1e6).contains(&weight) => {
                Err(format!("--weight {weight} J/s: must lie between 0 and 1e6"))
            }
            _ => Ok(()),
        }
    }

    /// The plan with its moves overlapping, if that is asked for.
    pub fn apply(&self, problem: &Problem, law: &PowerLaw, planned: Planned) -> Result<Planned, PlanError> {
        let Some(parallel) = self.parallel.filter(|_| planned.plan.manner == Manner::Best) else {
            return Ok(planned);
        };
        let usual = if parallel == ParallelKind::Time { TIME_W } else { 0.0 };
        let plan = overlapped(problem, &planned.plan, law, self.weight.unwrap_or(usual))?;
        Ok(Planned { plan, ..planned })
    }
}
