//! Constants of Modboats, as they are told.

use std::io::Write;
use std::path::{Path, PathBuf};

use identify::data::{Boat, Recording};
use identify::outcome::{Outcome, Scale};
use plot::identified::{Identified, Velocities};

use super::super::{Failure, bad};
use super::{Arguments, Found, Known, doubts, residuals, row};
use crate::run::identified;

pub(super) fn main(arguments: &Arguments, boat: &Boat, recordings: &[Recording]) -> Result<(), Failure> {
    let scale = match arguments.scale {
        None | Some(Known::Rotor) => Scale::Rotor,
        Some(Known::Thrust) => Scale::Thrust,
        Some(Known::Mass) => {
            return Err(Failure::Bad("--scale mass: of ROVs; these are logs of Modboats".to_owned()));
        }
    };
    let outcome = identify::identify(boat, recordings, scale).map_err(bad)?;
    let found = Found {
        json: serde_json::to_string_pretty(&outcome),
        toml: identified::tables(boat, &outcome),
        print: &|out| print(out, &outcome),
        draw: &|folder| pictures(boat, &outcome, folder),
    };
    found.tell(arguments)
}

fn pictures(boat: &Boat, outcome: &Outcome, folder: &Path) -> Vec<Result<PathBuf, plot::PlotError>> {
    let velocities: Vec<Velocities<3>> = outcome
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
    let identified = Identified {
        name: &name,
        line: &line,
        from: "tail angles",
        velocity_titles: ["Sway, mm/s", "Surge, mm/s", "Yaw rate, mrad/s"],
        velocities: &velocities,
        residual_titles: ["East, mm", "North, mm", "Heading, mrad"],
        residuals: &residuals,
    };
    plot::identified::write(&identified, folder)
}

fn print(out: &mut dyn Write, outcome: &Outcome) -> std::io::Result<()> {
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
    doubts(out, &outcome.scale_text, &outcome.indistinct)?;
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
    residuals(out, &outcome.residuals, &["mm", "mm", "mrad"])?;
    outcome.notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))
}
