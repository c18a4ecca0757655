//! `flotilla compare`: several planners on one scenario, with the same seeds, side by side.

use std::io::Write;
use std::path::PathBuf;

use modboat::planner_kind::PlannerKind;
use plot::compare::Compared;

use super::folder::{Files, Folder};
use super::planner::Kind;
use super::progress::Bar;
use super::run::{DEFAULT, failure, list};
use super::{Failure, all_said, bad, signal, untold};
use crate::run::compare::{Comparison, Contender, FIGURES, compare};
use crate::run::scenario::Scenario;

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla compare holonomic-4\n  \
                        flotilla compare station-keeping --planners exact,potential-field --seeds 20 --json")]
pub(super) struct Arguments {
    /// A scenario file, or one that comes with the program (`flotilla run --help` names them)
    #[arg(default_value = DEFAULT)]
    scenario: String,
    /// Which planners [default: all]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PLANNER,…")]
    planners: Vec<Kind>,
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

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = Scenario::open(&arguments.scenario).map_err(bad)?;
    let mut planners: Vec<PlannerKind> = arguments.planners.iter().map(|&kind| kind.into()).collect();
    if let Some(twice) = (1..planners.len()).find(|&k| planners[..k].contains(&planners[k])) {
        return Err(Failure::Bad(format!("--planners: {} is named twice", planners[twice].name())));
    }
    if planners.is_empty() {
        planners = PlannerKind::ALL.to_vec();
    }
    let first = arguments.seed.unwrap_or(scenario.seed);
    let seeds: Vec<u64> = (0..arguments.seeds).map(|k| first.saturating_add(k)).collect();
    let folder = Folder::of(arguments.out.as_deref(), &format!("{}-compared", scenario.name))?;
    signal::watch();
    let mut bar = Bar::new(&scenario.name);
    let compared = compare(&scenario, &planners, &seeds, &mut bar, &signal::STOP);
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

fn write(compared: &Comparison, json: String, folder: &Folder) -> Files {
    let mut files = folder.files();
    files.json(folder.path.join("summary.json"), Ok(json));
    let planners: Vec<_> =
        compared.planners.iter().map(|contender| (contender.planner, contender.records.as_slice())).collect();
    let pictures = Compared { scenario: &compared.scenario, planners: &planners };
    plot::write_comparison(&pictures, &folder.path).into_iter().for_each(|picture| files.add(picture));
    files
}

/// A row a figure, a column a planner; with several seeds the mean, and the worst behind it.
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
    for Contender { planner, .. } in planners {
        write!(out, "{planner:>24}")?;
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
            write!(out, "{cell:>24}")?;
        }
        writeln!(out)?;
    }
    writeln!(out)
}
