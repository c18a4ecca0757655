//! `flotilla compare`: several planners or controllers on one scenario, with the same seeds, side by side.

use std::io::Write;
use std::path::PathBuf;

use modboat::control::ControllerKind;
use modboat::planner_kind::PlannerKind;
use plot::compare::Compared;

use super::folder::{Files, Folder};
use super::planner::Kind;
use super::progress::Bar;
use super::run::{DEFAULT, failure, list};
use super::{Failure, all_said, bad, signal, untold};
use crate::run::compare::{Comparison, Contender, FIGURES, LoopMargins, compare};
use crate::run::scenario::Scenario;

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla compare holonomic-4\n  \
                        flotilla compare station-keeping --planners exact,potential-field --seeds 20 --json\n  \
                        flotilla compare holonomic-1 --controllers forgiving,paper")]
pub(super) struct Arguments {
    /// A scenario file, or one that comes with the program (`flotilla run --help` names them)
    #[arg(default_value = DEFAULT)]
    scenario: String,
    /// Which planners [default: all, or with --controllers the scenario's]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PLANNER,…")]
    planners: Vec<Kind>,
    /// Which controllers [default: the scenario's]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "CONTROLLER,…")]
    controllers: Vec<Controller>,
    /// How many seeds: the scenario's and those that follow it
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// The first seed, instead of the scenario's
    #[arg(long)]
    seed: Option<u64>,
    /// Folder for summary.json and the pictures [default: runs/NAME-compared, a new one each time]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print the figures, and those of every run, as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Controller {
    /// Follows a reference, takes off what pushes beside the tails, learns thrust and drag
    Forgiving,
    /// The laws of Qiao, Knizhnik and Yim, as corrected
    Paper,
}

impl From<Controller> for ControllerKind {
    fn from(controller: Controller) -> Self {
        match controller {
            Controller::Forgiving => Self::Forgiving,
            Controller::Paper => Self::Paper,
        }
    }
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = Scenario::open(&arguments.scenario).map_err(bad)?;
    let mut planners = each_once("--planners", &arguments.planners, PlannerKind::name)?;
    let mut controllers = each_once("--controllers", &arguments.controllers, ControllerKind::name)?;
    if planners.is_empty() {
        planners =
            if controllers.is_empty() { PlannerKind::ALL.to_vec() } else { vec![scenario.planner.kind] };
    }
    if controllers.is_empty() {
        controllers = vec![scenario.control.kind];
    }
    let contestants: Vec<_> = planners
        .iter()
        .flat_map(|&planner| controllers.iter().map(move |&controller| (planner, controller)))
        .collect();
    let first = arguments.seed.unwrap_or(scenario.seed);
    let seeds: Vec<u64> = (0..arguments.seeds).map(|k| first.saturating_add(k)).collect();
    let folder = Folder::of(arguments.out.as_deref(), &format!("{}-compared", scenario.name))?;
    signal::watch();
    let mut bar = Bar::new(&scenario.name);
    let compared = compare(&scenario, &contestants, &seeds, &mut bar, &signal::STOP);
    let compared = compared.map_err(|error| failure(error, "")).inspect_err(|_| folder.discard(&[]))?;
    drop(bar);
    let json = serde_json::to_string_pretty(&compared)
        .map_err(|error| Failure::Could(format!("summary: {error}")))?;
    let mut out = std::io::stdout().lock();
    let told = if arguments.json { writeln!(out, "{json}") } else { print(&mut out, &compared) };
    let told = told.and_then(|()| out.flush());
    let files = write(&compared, json, &folder);
    let listed = told.and_then(|()| if arguments.json { Ok(()) } else { list(&mut out, &files) });
    let complaints = compared.failure().into_iter().chain(files.complaints).chain(untold(listed));
    all_said(complaints.collect())
}

/// What an option lists, none of it twice.
fn each_once<T: Copy + Into<U>, U: PartialEq + Copy>(
    option: &str,
    listed: &[T],
    name: fn(U) -> &'static str,
) -> Result<Vec<U>, Failure> {
    let kinds: Vec<U> = listed.iter().map(|&kind| kind.into()).collect();
    match (1..kinds.len()).find(|&k| kinds[..k].contains(&kinds[k])) {
        Some(twice) => Err(Failure::Bad(format!("{option}: {} is named twice", name(kinds[twice])))),
        None => Ok(kinds),
    }
}

fn write(compared: &Comparison, json: String, folder: &Folder) -> Files {
    let mut files = folder.files();
    files.json(folder.path.join("summary.json"), Ok(json));
    let planners: Vec<_> = compared
        .planners
        .iter()
        .map(|contender| (compared.name(contender), contender.records.as_slice()))
        .collect();
    let pictures = Compared { scenario: &compared.scenario, planners: &planners };
    plot::write_comparison(&pictures, &folder.path).into_iter().for_each(|picture| files.add(picture));
    files
}

/// A row a figure, a column a contender; with several seeds the mean, and the worst behind it.
fn print(out: &mut impl Write, compared: &Comparison) -> std::io::Result<()> {
    let Comparison { scenario, modules, seeds, planners } = compared;
    let which = match seeds.as_slice() {
        [one] => format!("seed {one}"),
        [first, .., last] => format!("seeds {first} to {last}: mean, worst"),
        [] => String::new(),
    };
    writeln!(out, "{scenario}: {modules} modules, {which}")?;
    writeln!(out)?;
    write!(out, "  {:<36}", "")?;
    for contender in planners {
        let name = compared.name(contender);
        write!(out, "{name:>27}")?;
    }
    writeln!(out)?;
    for figure in &FIGURES {
        let spread = |contender: &Contender| contender.figures.get(figure.key).copied();
        if planners.iter().all(|contender| spread(contender).is_none()) {
            continue;
        }
        write!(out, "  {:<36}", figure.title)?;
        for contender in planners {
            let shown = |value: f64| format!("{:.*}", figure.decimals, figure.scale * value);
            let cell = match spread(contender) {
                None => "–".to_owned(),
                Some(spread) if seeds.len() == 1 => shown(spread.mean),
                Some(spread) => format!("{} {:>10}", shown(spread.mean), shown(spread.worst)),
            };
            write!(out, "{cell:>27}")?;
        }
        writeln!(out)?;
    }
    type Margin = (&'static str, fn(&LoopMargins) -> [f64; 2]);
    let rows: [Margin; 4] = [
        ("heading stable, thrust times", |of| [of.heading_least_gain, of.heading_gain]),
        ("heading, phase margin, °", |of| [of.heading_phase_rad.to_degrees(); 2]),
        ("station stable, thrust times", |of| [of.position_least_gain, of.position_gain]),
        ("station, phase margin, °", |of| [of.position_phase_rad.to_degrees(); 2]),
    ];
    for (title, of) in rows {
        write!(out, "  {title:<36}")?;
        for contender in planners {
            let cell = match contender.margins.as_ref().map(of) {
                None => "–".to_owned(),
                Some([least, most]) if least.to_bits() == most.to_bits() => format!("{most:.1}"),
                Some([least, most]) => format!("{least:.2} to {most:.2}"),
            };
            write!(out, "{cell:>27}")?;
        }
        writeln!(out)?;
    }
    writeln!(out)
}
