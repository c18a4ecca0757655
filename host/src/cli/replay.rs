//! `flotilla replay`: summary and pictures again, from a log.

use std::io::Write;
use std::path::{Path, PathBuf};

use record::reconfigure::Record;
use runlog::reader::Extent;

use super::folder::{Files, Folder};
use super::progress::Bar;
use super::run::list;
use super::{Failure, all_said, bad, report, untold};
use crate::run::log::boats;
use crate::run::log::replay::{Replayed, replay_file};
use crate::run::log::rovs;

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla replay runs/holonomic-1/log.mcap\n  \
                        flotilla replay runs/holonomic-1/log.mcap --out again\n  \
                        flotilla replay runs/i-to-l/log-*.mcap --out again")]
pub(super) struct Arguments {
    /// The log of a run; of a reconfiguration that executed several plans, the logs of all
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Folder for summary.json and the pictures [default: nothing is written]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let (mut boats, mut rovs, mut complaints) = (Vec::new(), Vec::new(), Vec::new());
    for path in &arguments.logs {
        let mut bar = Bar::new(&path.display().to_string());
        let outcome = replay_file(path, &mut bar);
        drop(bar);
        let (replayed, extent) = outcome.map_err(|error| bad(format!("{}: {error}", path.display())))?;
        let ended = match replayed {
            Replayed::Boats(outcome) => {
                let ended = outcome.ended;
                boats.push(outcome);
                ended
            }
            Replayed::Rovs(outcome) => {
                let ended = outcome.ended;
                rovs.push(outcome);
                ended
            }
        };
        complaints.extend((!ended).then(|| cut(path, &extent)));
    }
    match (boats.as_slice(), rovs.is_empty()) {
        ([outcome], true) => swum(arguments, outcome, complaints),
        ([], false) => {
            rovs.sort_by_key(|outcome| outcome.title.index);
            reconfigured(arguments, &rovs, complaints)
        }
        _ => Err(Failure::Bad(
            "several logs make one summary only where they are of one reconfiguration".to_owned(),
        )),
    }
}

/// That a log has no end.
fn cut(path: &Path, extent: &Extent) -> String {
    format!(
        "{}: cut after {:.3} s: the end of the run is missing",
        path.display(),
        extent.end_ns as f64 * 1e-9
    )
}

fn swum(arguments: &Arguments, outcome: &boats::Outcome, mut complaints: Vec<String>) -> Result<(), Failure> {
    complaints.extend(outcome.summary.complaints());
    let json = || serde_json::to_string_pretty(&outcome.summary);
    let told = tell(arguments, json(), |out| report::print(out, &outcome.summary));
    write(arguments, told, complaints, |files, folder| {
        files.json(folder.join("summary.json"), json());
        plot::write_all(&outcome.record, folder).into_iter().for_each(|picture| files.add(picture));
    })
}

fn reconfigured(
    arguments: &Arguments,
    outcomes: &[Box<rovs::Outcome>],
    mut complaints: Vec<String>,
) -> Result<(), Failure> {
    for outcome in outcomes {
        let said = outcome.summary.complaints();
        complaints.extend(said.iter().map(|why| format!("{}: {why}", outcome.title.name)));
    }
    let summaries: serde_json::Map<_, _> = outcomes
        .iter()
        .filter_map(|outcome| {
            Some((outcome.title.name.clone(), serde_json::to_value(&outcome.summary).ok()?))
        })
        .collect();
    let json = || serde_json::to_string_pretty(&summaries);
    let told = tell(arguments, json(), |out| {
        outcomes.iter().try_for_each(|outcome| {
            let summary = &outcome.summary;
            writeln!(
                out,
                "{}, {}: {} moves; {:.2} J planned, {:.2} J executed in {:.2} s",
                summary.problem,
                outcome.title.name,
                summary.moves.len(),
                summary.planned.total_j,
                summary.executed.total_j,
                summary.executed.time_s
            )
        })
    });
    write(arguments, told, complaints, |files, folder| {
        files.json(folder.join("summary.json"), json());
        let records: Vec<Record> = outcomes.iter().map(|outcome| outcome.record.clone()).collect();
        let pictures = plot::reconfigure::write_all(&records, folder);
        pictures.into_iter().for_each(|picture| files.add(picture));
    })
}

fn tell(
    arguments: &Arguments,
    json: serde_json::Result<String>,
    print: impl FnOnce(&mut std::io::StdoutLock<'_>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    if arguments.json {
        writeln!(out, "{}", json.map_err(std::io::Error::other)?)?;
    } else {
        print(&mut out)?;
    }
    out.flush()
}

/// Writes files where that is asked for.
fn write(
    arguments: &Arguments,
    told: std::io::Result<()>,
    mut complaints: Vec<String>,
    save: impl FnOnce(&mut Files, &Path),
) -> Result<(), Failure> {
    let mut listed = told;
    if let Some(path) = &arguments.out {
        let folder = Folder::of(Some(path), "")?;
        let mut files = folder.files();
        save(&mut files, &folder.path);
        if !arguments.json {
            listed = listed.and_then(|()| list(&mut std::io::stdout().lock(), &files));
        }
        complaints.extend(files.complaints);
    }
    complaints.extend(untold(listed));
    all_said(complaints)
}
