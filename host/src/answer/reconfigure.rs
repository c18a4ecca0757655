//! Plans of ROVs that change their configuration, judged before they are handed out: `flotilla reconfigure`.

use clap::ValueEnum;
use reconfiguration::plan::Manner;
use reconfiguration::problem::Problem;
use rov::order::Progress;
use rov::parallel::overlapped;
use rov::planner::{OrderRule, PlanError, Planned, Request, plan_with};
use rov::power::{PowerError, PowerLaw};
use rov::pricing::price;
use serde::Deserialize;
use thiserror::Error;

use super::threads::Threads;

/// What a second is worth where time is what counts, J/s: more than any cluster draws.
const TIME_W: f64 = 1e3;

/// A law of power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PowerKind {
    /// The T200's measured table
    Table,
    /// A smooth law through its upper part
    Fitted,
    /// Proportional to the square of thrust, through the table's greatest forward thrust
    Quadratic,
}

impl PowerKind {
    /// As the table of results says it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Table => "the T200's table",
            Self::Fitted => "the smooth law",
            Self::Quadratic => "the square law",
        }
    }

    /// The law at a battery's voltage.
    ///
    /// # Errors
    /// Nothing is known of the thrusters at this voltage.
    pub fn law(self, battery_v: f64) -> Result<PowerLaw, PowerError> {
        match self {
            Self::Fitted => PowerLaw::fitted(battery_v),
            Self::Table => PowerLaw::table(battery_v),
            Self::Quadratic => {
                let table = PowerLaw::table(battery_v)?;
                let (_, forward_n) = rov::power::limits_n(battery_v)?;
                // P = η u² (10), through the end of the table
                PowerLaw::quadratic(table.power_w(forward_n) / (forward_n * forward_n))
            }
        }
    }
}

/// What counts where several robots may be under way at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ParallelKind {
    /// The least energy
    Energy,
    /// The least time, at no more energy than one after the other
    Time,
}

/// Whether several robots may be under way at once, and what that is worth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Together {
    /// What counts; `None`: one after the other.
    pub parallel: Option<ParallelKind>,
    /// What a second is worth, J/s, instead of what `parallel` says.
    pub weight: Option<f64>,
}

impl Together {
    /// Whether that can be asked for.
    ///
    /// # Errors
    /// Why it cannot.
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
    fn apply(&self, problem: &Problem, law: &PowerLaw, planned: Planned) -> Result<Planned, PlanError> {
        let Some(parallel) = self.parallel.filter(|_| planned.plan.manner == Manner::Best) else {
            return Ok(planned);
        };
        let usual = if parallel == ParallelKind::Time { TIME_W } else { 0.0 };
        let plan = overlapped(problem, &planned.plan, law, self.weight.unwrap_or(usual))?;
        Ok(Planned { plan, ..planned })
    }
}

/// Why there is no plan.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NotMade {
    /// No such robot can be planned for, by any rule.
    #[error("{0}")]
    Unfit(String),
    /// None was found.
    #[error("{0}")]
    NotFound(String),
    /// It breaks a condition, whichever planner made it: it is not handed out.
    #[error("the plan breaks a condition: {0}")]
    Refused(String),
}

/// How the order is found where nothing is said.
#[must_use]
pub const fn usual_order(manner: Manner) -> OrderRule {
    match manner {
        Manner::Best => OrderRule::Exact,
        Manner::Paper => OrderRule::Paper,
    }
}

/// A plan on all cores, priced in the current of its rules, unless the judge refuses it.
///
/// # Errors
/// [`NotMade`].
pub fn planned(
    problem: &Problem,
    request: &Request,
    together: &Together,
    progress: &mut dyn Progress,
) -> Result<Planned, NotMade> {
    let made = plan_with(problem, request, &Threads::new(), progress)
        .and_then(|planned| together.apply(problem, &request.law, planned));
    let mut planned = made.map_err(|error| match error {
        PlanError::Propulsion { .. } | PlanError::Power(_) | PlanError::TooMany { .. } => {
            NotMade::Unfit(error.to_string())
        }
        error => NotMade::NotFound(error.to_string()),
    })?;
    price(problem, &mut planned.plan, &request.law).map_err(|error| NotMade::NotFound(error.to_string()))?;
    match judge::verify(problem, &planned.plan).first() {
        None => Ok(planned),
        Some(violation) => Err(NotMade::Refused(violation.to_string())),
    }
}
