//! The `flotilla-campaign` program. `flotilla campaign` starts it.
//!
//! Exit codes: 0 every row is there, whatever the runs came to; 1 could not; 2 bad usage or input.

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use crate::execute::{ExecuteError, Outcome, Watch, execute};
use crate::folder::{Folder, FolderError, Shard};
use crate::journal::JournalError;
use crate::merge::{merge, missing};
use crate::report::Report;
use crate::slurm::{self, Script};
use crate::study::Study;
use crate::table::{Format, Table};

const EXAMPLES: &str = "Examples:\n  flotilla campaign loss.toml                       every run, on all cores, and rows.parquet\n  \
                        flotilla campaign loss.toml --shard 3/8           a third shard of eight, here or on any machine\n  \
                        flotilla campaign merge runs/loss-campaign        eight shards as one file\n  \
                        flotilla campaign report runs/loss-campaign       means with intervals, and pictures\n  \
                        flotilla campaign loss.toml --slurm --shards 8 --sbatch=--partition=short\n\n\
                        A campaign that is killed goes on where it was, by the same command.\n\n\
                        A smallest campaign, 60 runs:\n  name = \"loss\"\n  scenarios = [\"holonomic-1\"]\n  \
                        planners = [\"exact\", \"potential-field\"]\n  seeds = 10\n\n  [grid]\n  \"radio.loss\" = [0.0, 0.1, 0.3]";

/// Run a study of many runs: scenarios, parameters, seeds and planners; one row a run.
#[derive(Parser)]
#[command(name = "flotilla-campaign", bin_name = "flotilla campaign", version, about, long_about = None, after_help = EXAMPLES)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Wish>,
    #[command(flatten)]
    run: RunArguments,
}

#[derive(Subcommand)]
enum Wish {
    /// The shards of a campaign as one file
    Merge(MergeArguments),
    /// Means and shares with 95 % intervals, and pictures of them
    Report(ReportArguments),
}

#[derive(clap::Args)]
struct RunArguments {
    /// The campaign's file
    #[arg(required = true)]
    file: Option<PathBuf>,
    /// One shard of several, such as 3/8
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with = "slurm")]
    shard: Option<Shard>,
    /// Folder for the rows [default: runs/NAME-campaign]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// How rows are written
    #[arg(long, value_enum, default_value_t = Format::Parquet)]
    format: Format,
    /// Runs at a time [default: as there are cores; with --slurm 1, the cores of a task]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4096))]
    jobs: Option<u64>,
    /// Submit the shards to Slurm as an array of jobs, follow it, and merge
    #[arg(long)]
    slurm: bool,
    /// How many shards, with --slurm [default: 8]
    #[arg(long, value_name = "N", requires = "slurm", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    shards: Option<u64>,
    /// An option of sbatch, such as --sbatch=--time=2:00:00; as often as wanted
    #[arg(long, value_name = "OPTION", requires = "slurm", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Submit, and do not follow
    #[arg(long, requires = "slurm")]
    detach: bool,
}

#[derive(clap::Args)]
struct MergeArguments {
    /// The campaign's folder
    folder: PathBuf,
    /// Merge the shards that are done
    #[arg(long)]
    partial: bool,
}

#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  flotilla campaign report runs/loss-campaign --figures passed,legs.0.heading_rms_rad"
)]
struct ReportArguments {
    /// The campaign's folder
    folder: PathBuf,
    /// Columns of numbers, or `passed` [default: a few, of those that there are]
    #[arg(long, value_delimiter = ',', value_name = "COLUMN,…")]
    figures: Vec<String>,
    /// Print JSON, and draw nothing
    #[arg(long)]
    json: bool,
}

/// How the program ended, if not well.
struct Failure {
    code: u8,
    message: String,
}

fn bad(error: impl Display) -> Failure {
    Failure { code: 2, message: error.to_string() }
}

fn could(error: impl Display) -> Failure {
    Failure { code: 1, message: error.to_string() }
}

/// Runs the program.
#[must_use]
pub fn main() -> ExitCode {
    let Arguments { command, run } = Arguments::parse();
    let outcome = match command {
        Some(Wish::Merge(arguments)) => merged(&arguments),
        Some(Wish::Report(arguments)) => reported(&arguments),
        None => campaign(&run),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { code, message }) => {
            tell(&format!("flotilla: {}", message.replace(char::is_control, " ")));
            ExitCode::from(code)
        }
    }
}

/// One line to standard error; a closed one is ignored.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// To standard output. A reader that has gone away has seen enough.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(could(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

fn shard(text: &str) -> Result<Shard, String> {
    let parts =
        text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
    match parts {
        Some((index, count)) if (1..=count).contains(&index) && count <= 100_000 => {
            Ok(Shard { index, count })
        }
        _ => Err("must be two numbers such as 3/8, the first from 1 to the second".to_owned()),
    }
}

fn folder_failure(error: FolderError) -> Failure {
    match error {
        FolderError::File { .. } => could(error),
        FolderError::None { .. } | FolderError::Other { .. } => bad(error),
    }
}

fn campaign(arguments: &RunArguments) -> Result<(), Failure> {
    let file = arguments.file.as_deref().unwrap_or(Path::new(""));
    let study = Study::open(file).map_err(bad)?;
    let out = arguments.out.clone().unwrap_or_else(|| study.folder());
    let shards = match (arguments.shard, arguments.slurm) {
        (Some(shard), _) => shard.count,
        (None, true) => arguments.shards.unwrap_or(8) as usize,
        (None, false) => 1,
    };
    if shards > study.runs() {
        return Err(bad(format!(
            "{shards} shards are more than the {} runs of {}",
            study.runs(),
            study.name
        )));
    }
    let folder = Folder::of(&study, &out, shards, arguments.format).map_err(folder_failure)?;
    if arguments.slurm {
        return on_slurm(arguments, file, &study, folder);
    }
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(cores, |jobs| jobs as usize);
    let bar = Bar::new(&study.name);
    let outcome = execute(&study, &folder, shard, jobs, &bar);
    bar.0.finish_and_clear();
    let outcome = outcome.map_err(|error| match error {
        ExecuteError::Journal(JournalError::Other { .. }) | ExecuteError::Rows { .. } => bad(error),
        error => could(error),
    })?;
    print(&told(&study, shard, jobs, &outcome, &folder.file(shard)))
}

/// What became of a shard, a few lines.
fn told(study: &Study, shard: Shard, jobs: usize, outcome: &Outcome, file: &Path) -> String {
    let Outcome { rows, made, took, failed, errors, first_error } = outcome;
    let part = match shard {
        Shard::WHOLE => String::new(),
        Shard { index, count } => format!(", shard {index} of {count}"),
    };
    let mut text = format!("{}{part}: {rows} runs ({})\n\n", study.name, study.told());
    if made < rows {
        text += &format!("  resumed    {} rows were there\n", rows - made);
    }
    if *made > 0 {
        let took_s = took.as_secs_f64();
        let rate = *made as f64 / took_s.max(1e-9);
        text += &format!("  made       {made} rows in {took_s:.1} s, {rate:.2} a second, {jobs} at a time\n");
    }
    text += &format!("  passed     {} of {rows}\n", rows - failed - errors);
    if *errors > 0 {
        text += &format!(
            "  no run     {errors}{}\n",
            first_error.as_ref().map_or(String::new(), |first| format!(": {first}"))
        );
    }
    text + &format!("  {}\n", file.display())
}

/// Progress on a terminal; silence in a pipe.
struct Bar(ProgressBar);

impl Bar {
    fn new(name: &str) -> Self {
        let bar = ProgressBar::new(1);
        if let Ok(style) =
            ProgressStyle::with_template("{prefix} {bar:24} {pos} of {len} runs  {msg} {eta} left")
        {
            bar.set_style(style.progress_chars("━╸─"));
        }
        bar.set_prefix(name.to_owned());
        bar.enable_steady_tick(Duration::from_millis(500));
        Self(bar)
    }
}

impl Watch for Bar {
    fn waits(&self) {
        tell("flotilla: another process runs this shard: waiting for its end");
    }

    fn rows(&self, done: usize, total: usize) {
        if self.0.length() != Some(total as u64) {
            self.0.set_length(total as u64);
            // What was there before says nothing of the rate.
            self.0.set_position(done as u64);
            self.0.reset_eta();
        }
        self.0.set_position(done as u64);
    }
}

/// How often Slurm is asked.
const ASKED_EVERY: Duration = Duration::from_secs(2);
/// After so many answers that did not come Slurm is asked no more.
const PATIENCE: u32 = 150;

fn on_slurm(arguments: &RunArguments, file: &Path, study: &Study, folder: Folder) -> Result<(), Failure> {
    let absolute =
        |path: &Path| path.canonicalize().map_err(|error| could(format!("{}: {error}", path.display())));
    let folder = Folder { path: absolute(&folder.path)?, ..folder };
    let program =
        std::env::current_exe().map_err(|error| could(format!("this program's own path: {error}")))?;
    let under_way =
        slurm::submitted(&folder).filter(|&job| slurm::standing(job).is_ok_and(|tasks| !tasks.is_empty()));
    let left = missing(&folder);
    let job = match under_way {
        Some(job) => Some(job),
        None if left.is_empty() => None,
        None => {
            let jobs = arguments.jobs.unwrap_or(1) as usize;
            let file = absolute(file)?;
            let script = Script { program: &program, file: &file, jobs, options: &arguments.sbatch };
            Some(script.submit(&folder, &left).map_err(could)?)
        }
    };
    if let Some(job) = job {
        let what = if under_way.is_some() { "is under way" } else { "is submitted" };
        let (runs, shards) = (study.runs(), left.len());
        tell(&format!(
            "job {job} {what}: {shards} shards of {runs} runs; scancel {job} ends it, this command follows it again"
        ));
        if arguments.detach {
            return Ok(());
        }
        follow(job, &folder)?;
    }
    let left = missing(&folder);
    if !left.is_empty() {
        let logs = job.map_or(String::new(), |job| {
            format!("; see {}", folder.path.join(format!("slurm-{job}_*.log")).display())
        });
        let left = left.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        return Err(could(format!(
            "shards {left} ended and are not done{logs}; the same command submits them again"
        )));
    }
    let (path, rows) = merge(&folder, false).map_err(could)?;
    print(&format!("{}: {rows} runs ({})\n  {}\n", study.name, study.told(), path.display()))
}

/// Waits until no task of `job` is left.
fn follow(job: u64, folder: &Folder) -> Result<(), Failure> {
    let bar = Bar::new(&folder.manifest.campaign);
    let mut silent = 0;
    loop {
        let done = folder.shards().map(|shard| folder.done(shard)).sum();
        bar.rows(done, folder.manifest.runs);
        match slurm::standing(job) {
            Ok(tasks) if tasks.is_empty() => break,
            Ok(tasks) => {
                silent = 0;
                let states: Vec<String> =
                    tasks.iter().map(|(state, count)| format!("{count} {state}")).collect();
                bar.0.set_message(states.join(", "));
            }
            Err(error) => {
                silent += 1;
                bar.0.set_message(error.to_string());
                if silent >= PATIENCE {
                    return Err(could(format!("{error}; the same command follows job {job} again")));
                }
            }
        }
        std::thread::sleep(ASKED_EVERY);
    }
    bar.0.finish_and_clear();
    Ok(())
}

fn merged(arguments: &MergeArguments) -> Result<(), Failure> {
    let folder = Folder::open(&arguments.folder).map_err(folder_failure)?;
    let (path, rows) = merge(&folder, arguments.partial).map_err(could)?;
    print(&format!(
        "{}: {rows} of {} runs\n  {}\n",
        folder.manifest.campaign,
        folder.manifest.runs,
        path.display()
    ))
}

fn reported(arguments: &ReportArguments) -> Result<(), Failure> {
    let folder = Folder::open(&arguments.folder).map_err(folder_failure)?;
    let path = folder.rows();
    if !path.exists() {
        let hint = format!("flotilla campaign merge {}", arguments.folder.display());
        return Err(bad(format!("{}: there is none yet: {hint}", path.display())));
    }
    let table = Table::read(&path).map_err(could)?;
    let report = Report::new(&folder, table, &arguments.figures).map_err(bad)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&report).map_err(could)?;
        return print(&(json + "\n"));
    }
    print(&report.text())?;
    let mut complaints = Vec::new();
    let mut listed = String::from("\n");
    for picture in report.pictures(&folder.path) {
        match picture {
            Ok(path) => listed += &format!("  {}\n", path.display()),
            Err(error) => complaints.push(error.to_string()),
        }
    }
    print(&listed)?;
    if complaints.is_empty() { Ok(()) } else { Err(could(complaints.join("; "))) }
}
