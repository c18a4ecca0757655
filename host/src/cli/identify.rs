//! `flotilla identify`: constants of the boat from logs of its runs.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use identify::data::Boat;
use identify::outcome::{Constant, Outcome, Scale};
use plot::identified::{Identified, Velocities};

use super::folder::Folder;
use super::progress::Bar;
use super::run::list;
use super::{Failure, all_said, bad, could, untold, written};
use crate::run::identified;
use crate::run::identify::logged_files;
use crate::run::scenario::{EXPERIMENT_S, Scenario};

#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  flotilla run identify-3 --out trial           an experiment that shows the constants\n  \
                        flotilla identify trial/log.mcap --out found   constants, pictures, tables to paste\n  \
                        flotilla identify monday.mcap tuesday.mcap --toml\n  \
                        flotilla identify --experiment my-boats.toml > my-experiment.toml"
)]
pub(super) struct Arguments {
    /// Logs of runs of the same structure
    #[arg(required_unless_present = "experiment", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// What is taken as known, so that forces, masses and drags have a scale: poses alone show ratios of them
    #[arg(long, value_enum, default_value_t = Known::Rotor)]
    scale: Known,
    /// Print everything as JSON
    #[arg(long, conflicts_with = "toml")]
    json: bool,
    /// Print the tables to paste into a scenario
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
    /// The rotor's moment of inertia, [motor] rotor_inertia_kg_m2
    Rotor,
    /// The mean slope of law (2), [modboat] force_slope_n_rad
    Thrust,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(name) = &arguments.experiment {
        return experiment(name, arguments.duration);
    }
    let bar = |path: &Path| Bar::new(&path.display().to_string());
    let (boat, recordings) = logged_files(&arguments.logs, bar).map_err(Failure::Bad)?;
    let folder = arguments.out.as_deref().map(|path| Folder::of(Some(path), "")).transpose()?;
    let scale = match arguments.scale {
        Known::Rotor => Scale::Rotor,
        Known::Thrust => Scale::Thrust,
    };
    let outcome = identify::identify(&boat, &recordings, scale).map_err(bad)?;
    let json = || serde_json::to_string_pretty(&outcome);
    let toml = identified::tables(&boat, &outcome);
    let mut out = std::io::stdout().lock();
    let told = if arguments.json {
        let text = json().map_err(could)?;
        writeln!(out, "{text}")
    } else if arguments.toml {
        write!(out, "{toml}")
    } else {
        print(&mut out, &outcome, &toml)
    };
    let mut complaints = Vec::new();
    let mut listed = told.and_then(|()| out.flush());
    if let Some(folder) = folder {
        let mut files = folder.files();
        files.json(folder.path.join("identified.json"), json());
        let path = folder.path.join("identified.toml");
        let wrote = std::fs::write(&path, &toml).map(|()| path.clone());
        files.add(wrote.map_err(|error| format!("{}: cannot write: {error}", path.display())));
        pictures(&boat, &outcome, &folder.path).into_iter().for_each(|picture| files.add(picture));
        if !arguments.json && !arguments.toml {
            listed = listed.and_then(|()| list(&mut out, &files));
        }
        complaints.extend(files.complaints);
    }
    complaints.extend(untold(listed));
    all_said(complaints)
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

fn pictures(boat: &Boat, outcome: &Outcome, folder: &Path) -> Vec<Result<PathBuf, plot::PlotError>> {
    let velocities: Vec<Velocities> = outcome
        .foretold
        .iter()
        .flatten()
        .map(|f| Velocities { t_s: f.t_s, measured: f.measured, predicted: f.predicted, start: f.start })
        .collect();
    let residuals: Vec<(f64, [f64; 3])> = outcome.errors.concat();
    let name = format!("{} modules", boat.modules());
    let prediction = &outcome.prediction;
    let line = format!(
        "{:.0} s of {} log{}; velocity foretold {:.0} s ahead within {:.1} % RMS over {:.0} s that were held back",
        outcome.duration_s,
        outcome.logs.len(),
        if outcome.logs.len() == 1 { "" } else { "s" },
        identify::prediction::HORIZON_S,
        100.0 * prediction.velocity_error,
        prediction.held_back_s,
    );
    let identified = Identified { name: &name, line: &line, velocities: &velocities, residuals: &residuals };
    plot::identified::write(&identified, folder)
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

fn row(out: &mut impl Write, constant: &Constant) -> std::io::Result<()> {
    let Constant { name, value, low, high, belief, shown } = constant;
    let [value, low, high] = [value, low, high].map(|number| digits(*number));
    let belief = belief.map_or_else(String::new, |belief| format!("  (believed {})", digits(belief)));
    let doubt = if *shown { "" } else { "  hardly shown" };
    writeln!(out, "  {name:<34} {value:>11}   {low:>11} … {high:<11}{belief}{doubt}")
}

fn print(out: &mut impl Write, outcome: &Outcome, toml: &str) -> std::io::Result<()> {
    let battery = outcome.battery_v.map_or_else(String::new, |volts| format!(", battery {volts:.2} V"));
    let Outcome { duration_s, fixes, steps, .. } = outcome;
    writeln!(out, "{}: {duration_s:.0} s, {fixes} poses{battery}; {steps} steps", outcome.logs.join(", "))?;
    writeln!(out, "\n  constant, a module unless it says structure      95 % interval")?;
    outcome.constants.iter().try_for_each(|constant| row(out, constant))?;
    writeln!(out, "\n  ratios, whatever the scale")?;
    outcome.ratios.iter().try_for_each(|constant| row(out, constant))?;
    writeln!(out, "\n  module    thrust of the mean      95 % interval    lag")?;
    for module in &outcome.modules {
        let (gain, doubt) = (&module.gain, if module.gain.shown { "" } else { "  hardly shown" });
        let lag = module
            .lag_s
            .map_or_else(String::new, |[lag, half]| format!("{:.1} ± {:.1} ms", 1e3 * lag, 1e3 * half));
        let (value, low, high) = (gain.value, gain.low, gain.high);
        writeln!(out, "  {:>6}    {value:>18.3}      {low:.3} … {high:.3}    {lag}{doubt}", module.id)?;
    }
    writeln!(out, "\n  {}", outcome.scale_text)?;
    if outcome.indistinct.is_empty() {
        writeln!(out, "  nothing else is hard to tell apart")?;
    }
    for direction in &outcome.indistinct {
        writeln!(out, "  not told apart: {}", direction.text)?;
    }
    let prediction = &outcome.prediction;
    writeln!(
        out,
        "\n  foretold   {:.0} s ahead in {:.0} s held back: velocity within {:.1} mm/s of {:.1} RMS ({:.1} %), yaw rate {:.1} of {:.1} mrad/s",
        identify::prediction::HORIZON_S,
        prediction.held_back_s,
        1e3 * prediction.velocity_error_rms_m_s,
        1e3 * prediction.speed_rms_m_s,
        100.0 * prediction.velocity_error,
        1e3 * prediction.yaw_rate_error_rms_rad_s,
        1e3 * prediction.yaw_rate_rms_rad_s,
    )?;
    let [x, y, heading] = outcome.residuals.rms.map(|rms| 1e3 * rms);
    let [cx, cy, ch] = outcome.residuals.correlation;
    writeln!(
        out,
        "  residuals  {x:.2} mm, {y:.2} mm, {heading:.2} mrad RMS; from one to the next they correlate by {cx:.2}, {cy:.2}, {ch:.2}"
    )?;
    outcome.notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))?;
    writeln!(out, "\n{toml}")
}
