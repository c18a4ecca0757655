//! Constants of ROVs, as they are told.

use std::io::Write;
use std::path::{Path, PathBuf};

use identify::rov::data::Recording;
use identify::rov::identify;
use identify::rov::outcome::{Outcome, Scale};
use plot::identified::{Identified, Velocities};
use reconfiguration::vehicle::Vehicle;
use serde::Serialize;

use super::super::{Failure, bad};
use super::{Arguments, Found, Known, doubts, residuals, row};
use crate::run::identified::keys;

/// The whole output as JSON.
#[derive(Serialize)]
struct Json<'a> {
    fleet: &'static str,
    vehicles: &'a [Outcome],
}

pub(super) fn main(arguments: &Arguments, kinds: &[(Vehicle, Vec<Recording>)]) -> Result<(), Failure> {
    let scale = match arguments.scale {
        None | Some(Known::Thrust) => Scale::Thrust,
        Some(Known::Mass) => Scale::Mass,
        Some(Known::Rotor) => {
            return Err(Failure::Bad("--scale rotor: of Modboats; these are logs of ROVs".to_owned()));
        }
    };
    // A kind that stays where it is is not asked about.
    let swam =
        |(_, recordings): &&(Vehicle, Vec<Recording>)| recordings.iter().any(|log| !log.swims.is_empty());
    let kinds: Vec<_> = kinds.iter().filter(swam).collect();
    if kinds.is_empty() {
        return Err(Failure::Bad("no robot swims alone in these logs".to_owned()));
    }
    let outcomes = kinds.iter().map(|(vehicle, recordings)| identify(vehicle, recordings, scale));
    let outcomes: Vec<Outcome> = outcomes.collect::<Result<_, _>>().map_err(bad)?;
    let tables = kinds.iter().zip(&outcomes).map(|((vehicle, _), outcome)| keys(vehicle, outcome));
    let found = Found {
        json: serde_json::to_string_pretty(&Json { fleet: "rovs", vehicles: &outcomes }),
        toml: tables.collect::<Vec<_>>().join("\n"),
        print: &|out| outcomes.iter().try_for_each(|outcome| print(out, outcome)),
        draw: &|folder| {
            outcomes.iter().flat_map(|outcome| pictures(outcome, outcomes.len(), folder)).collect()
        },
    };
    found.tell(arguments)
}

/// In a folder of their own where there are several kinds.
fn pictures(outcome: &Outcome, kinds: usize, folder: &Path) -> Vec<Result<PathBuf, plot::PlotError>> {
    let own = if kinds > 1 {
        folder.join(outcome.vehicle.replace(['/', ' '], "-").to_lowercase())
    } else {
        folder.into()
    };
    // If it cannot be made, the pictures say so.
    let _ = std::fs::create_dir_all(&own);
    let velocities: Vec<Velocities<4>> = outcome
        .foretold
        .iter()
        .map(|f| Velocities { t_s: f.t_s, measured: f.measured, predicted: f.predicted, start: f.start })
        .collect();
    let told = outcome.prediction.velocity_error.map_or_else(
        || "nothing foretold".to_owned(),
        |error| {
            format!(
                "velocity foretold {:.0} s ahead within {:.1} % RMS",
                outcome.prediction.horizon_s,
                100.0 * error
            )
        },
    );
    let line = format!("{} swims, {:.0} s; {told}", outcome.swims, outcome.duration_s);
    let identified = Identified {
        name: &outcome.vehicle,
        line: &line,
        from: "thrusts",
        velocity_titles: ["Surge, mm/s", "Sway, mm/s", "Heave, mm/s", "Yaw rate, mrad/s"],
        velocities: &velocities,
        residual_titles: ["North, mm", "East, mm", "Down, mm", "Yaw, mrad"],
        residuals: &outcome.errors,
    };
    plot::identified::write(&identified, &own)
}

fn print(out: &mut dyn Write, outcome: &Outcome) -> std::io::Result<()> {
    let Outcome { vehicle, logs, swims, duration_s, fixes, steps, robots, .. } = outcome;
    let robots: Vec<String> = robots.iter().map(u16::to_string).collect();
    writeln!(out, "{}: {vehicle}, robots {}", logs.join(", "), robots.join(", "))?;
    writeln!(out, "{swims} swims alone, {duration_s:.0} s, {fixes} poses; {steps} steps")?;
    writeln!(out, "\n  constant                                          95 % interval")?;
    outcome.constants.iter().try_for_each(|constant| row(out, constant))?;
    writeln!(out, "\n  thruster    gives over its law    95 % interval")?;
    for thruster in &outcome.thrusters {
        let (gain, doubt) = (&thruster.gain, if thruster.gain.shown { "" } else { "  hardly shown" });
        let (value, low, high) = (gain.value, gain.low, gain.high);
        writeln!(out, "  {:>8}    {value:>18.3}    {low:.3} … {high:.3}{doubt}", thruster.number)?;
    }
    doubts(out, &outcome.scale_text, &outcome.indistinct)?;
    let prediction = &outcome.prediction;
    if let Some(error) = prediction.velocity_error {
        writeln!(
            out,
            "\n  foretold   {:.0} s ahead in {:.0} s held back: velocity within {:.1} mm/s of {:.1} RMS ({:.1} %), yaw rate {:.1} of {:.1} mrad/s",
            prediction.horizon_s,
            prediction.held_back_s,
            1e3 * prediction.velocity_error_rms_m_s,
            1e3 * prediction.speed_rms_m_s,
            100.0 * error,
            1e3 * prediction.yaw_rate_error_rms_rad_s,
            1e3 * prediction.yaw_rate_rms_rad_s,
        )?;
    }
    residuals(out, &outcome.residuals, &["mm", "mm", "mm", "mrad"])?;
    outcome.notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))
}
