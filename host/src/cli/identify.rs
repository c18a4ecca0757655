//! `flotilla identify`: constants of Modboats or ROVs from logs of their runs.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use identify::outcome::{Constant, Indistinct, Residuals};

use super::folder::Folder;
use super::progress::Bar;
use super::run::list;
use super::{Failure, all_said, bad, could, untold, written};
use crate::run::identify::{Logs, logged_files};
use crate::run::scenario::{EXPERIMENT_S, Scenario};

mod boats;
mod rovs;

#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  flotilla run identify-3 --out trial           an experiment that shows the constants\n  \
                        flotilla identify trial/log.mcap --out found   constants, pictures, tables to paste\n  \
                        flotilla identify monday.mcap tuesday.mcap --toml\n  \
                        flotilla identify moved/log-*.mcap --out rov   robots that swam alone in a reconfiguration\n  \
                        flotilla identify --experiment my-boats.toml > my-experiment.toml"
)]
pub(super) struct Arguments {
    /// Logs of runs of the same structure, or of reconfigurations
    #[arg(required_unless_present = "experiment", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// What is taken as known, so that forces, masses and drags have a scale: poses alone show ratios of them [default: rotor; of ROVs
    /// thrust]
    #[arg(long, value_enum)]
    scale: Option<Known>,
    /// Print everything as JSON
    #[arg(long, conflicts_with = "toml")]
    json: bool,
    /// Print the tables to paste into a scenario, or the keys of a vehicle file
    #[arg(long)]
    toml: bool,
    /// Folder for identified.json, identified.toml and the pictures [default: nothing is written]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print a scenario instead: this one with legs that show the constants, inside its [bounds]
    #[arg(long, value_name = "SCENARIO", conflicts_with_all = ["logs", "json", "toml", "out", "scale"])]
    experiment: Option<String>,
    /// How long the experiment is, s
    #[arg(long, value_name = "SECONDS", default_value_t = EXPERIMENT_S, requires = "experiment")]
    duration: f64,
}

/// What is taken as known.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Known {
    /// Modboats: the rotor's moment of inertia, [motor] rotor_inertia_kg_m2
    Rotor,
    /// The mean slope of law (2), [modboat] force_slope_n_rad; of ROVs: the mean of what thrusters give by their law
    Thrust,
    /// ROVs: the mass with the water that moves along, in surge and in heave
    Mass,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(name) = &arguments.experiment {
        return experiment(name, arguments.duration);
    }
    let bar = |path: &Path| Bar::new(&path.display().to_string());
    match logged_files(&arguments.logs, bar).map_err(Failure::Bad)? {
        Logs::Boats(boat, recordings) => boats::main(arguments, &boat, &recordings),
        Logs::Rovs(kinds) => rovs::main(arguments, &kinds),
    }
}

/// What is told, and how it is written.
struct Found<'a> {
    json: serde_json::Result<String>,
    toml: String,
    /// Prints it for a person.
    print: &'a dyn Fn(&mut dyn Write) -> std::io::Result<()>,
    /// Draws it into a folder.
    draw: &'a dyn Fn(&Path) -> Vec<Result<PathBuf, plot::PlotError>>,
}

impl Found<'_> {
    fn tell(self, arguments: &Arguments) -> Result<(), Failure> {
        let Self { json, toml, print, draw } = self;
        let folder = arguments.out.as_deref().map(|path| Folder::of(Some(path), "")).transpose()?;
        let json = json.map_err(could)?;
        let mut out = std::io::stdout().lock();
        let told = if arguments.json {
            writeln!(out, "{json}")
        } else if arguments.toml {
            write!(out, "{toml}")
        } else {
            print(&mut out).and_then(|()| writeln!(out, "\n{toml}"))
        };
        let mut complaints = Vec::new();
        let mut listed = told.and_then(|()| out.flush());
        if let Some(folder) = folder {
            let mut files = folder.files();
            files.json(folder.path.join("identified.json"), Ok(json));
            let path = folder.path.join("identified.toml");
            let wrote = std::fs::write(&path, &toml).map(|()| path.clone());
            files.add(wrote.map_err(|error| format!("{}: cannot write: {error}", path.display())));
            draw(&folder.path).into_iter().for_each(|picture| files.add(picture));
            if !arguments.json && !arguments.toml {
                listed = listed.and_then(|()| list(&mut out, &files));
            }
            complaints.extend(files.complaints);
        }
        complaints.extend(untold(listed));
        all_said(complaints)
    }
}

fn experiment(name: &str, duration_s: f64) -> Result<(), Failure> {
    if !(10.0..=1e4).contains(&duration_s) {
        return Err(Failure::Bad(format!("--duration {duration_s} s: must lie between 10 and 10000")));
    }
    let scenario = Scenario::open(name).map_err(bad)?;
    let scenario =
        scenario.into_experiment(duration_s).map_err(|reason| Failure::Bad(format!("{name}: {reason}")))?;
    written(write!(std::io::stdout().lock(), "{}", scenario.document()))
}

/// Five digits that count, without an exponent where that can be read.
fn digits(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let before = value.abs().max(1e-9).log10().floor() as i32;
        format!("{value:.*}", usize::try_from(3 - before).unwrap_or(0).min(7))
    } else {
        format!("{value:.3e}")
    }
}

fn row(out: &mut dyn Write, constant: &Constant) -> std::io::Result<()> {
    let Constant { name, value, low, high, belief, shown } = constant;
    let [value, low, high] = [value, low, high].map(|number| digits(*number));
    let belief = belief.map_or_else(String::new, |belief| format!("  (believed {})", digits(belief)));
    let doubt = if *shown { "" } else { "  hardly shown" };
    writeln!(out, "  {name:<34} {value:>11}   {low:>11} … {high:<11}{belief}{doubt}")
}

/// What is not told apart, and what the scale rests on.
fn doubts(out: &mut dyn Write, scale_text: &str, indistinct: &[Indistinct]) -> std::io::Result<()> {
    writeln!(out, "\n  {scale_text}")?;
    if indistinct.is_empty() {
        writeln!(out, "  nothing else is hard to tell apart")?;
    }
    indistinct.iter().try_for_each(|direction| writeln!(out, "  not told apart: {}", direction.text))
}

/// What is left of poses: their names, with thousandths of their units.
fn residuals(out: &mut dyn Write, residuals: &Residuals, units: &[&str]) -> std::io::Result<()> {
    let rms = residuals.rms.iter().zip(units).map(|(rms, unit)| format!("{:.2} {unit}", 1e3 * rms));
    let correlations = residuals.correlation.iter().map(|correlation| format!("{correlation:.2}"));
    let [rms, correlations] = [rms.collect::<Vec<_>>(), correlations.collect()].map(|list| list.join(", "));
    writeln!(out, "  residuals  {rms} RMS; from one to the next they correlate by {correlations}")
}
