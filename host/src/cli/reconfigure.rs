//! `flotilla reconfigure`: plans how ROVs change their configuration, judges the plans, executes them in simulation.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueEnum;
use link::faults::FaultParameters;
use link::identity::HostIdentity;
use link::udp::UdpRadio;
use protocol::ModuleId;
use reader::Document;
use reader::file::{MADE_MAX, text_from, text_of};
use reconfiguration::plan::{Criterion, Manner, Plan};
use reconfiguration::problem::Problem;
use record::reconfigure::Record;
use rov::planner::{OrderRule, Planned, Request};

use super::console::{Attended, Console, ServeArguments, console};
use super::folder::{Files, Folder};
use super::operator::socket::Desk;
use super::poses::{PoseArguments, rovs};
use super::progress::Bar;
use super::run::{RadioKind, list};
use super::{Failure, all_said, bad, could, keygen, signal, tell, untold, written};
use crate::answer::reconfigure::{NotMade, PowerKind, planned, usual_order};
use crate::run::closed_loop::Drive;
use crate::run::experiment::Pace;
use crate::run::fleet::{InProcess, OverUdp};
use crate::run::log::Log;
use crate::run::log::rovs::Title;
use crate::run::progress::Progress;
use crate::run::reconfigure::controller::Fixes;
use crate::run::reconfigure::execution::{Executed, Options, Site, run_into, run_with};
use crate::run::reconfigure::poses::LabBodies;
use crate::run::reconfigure::scenario::ReconfigureScenario;

mod search;
mod table;
mod task;
mod together;

use search::{GoalWatch, Watch};

/// The scenario that is planned when none is named.
const DEFAULT: &str = "t-to-i-far";

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla reconfigure\n  \
                        flotilla reconfigure i-to-l --criterion energy --json > plan.json\n  \
                        flotilla reconfigure i-to-l --verify plan.json\n  \
                        flotilla reconfigure i-to-l --criterion energy --serve\n  \
                        flotilla reconfigure i-to-l --criterion energy --parallel time\n  \
                        flotilla reconfigure i-to-l --criterion energy --radio udp --listen 127.0.0.1:4870\n  \
                        flotilla reconfigure i-to-l --criterion energy --radio udp --pose qtm:192.168.1.10 --up z")]
pub(super) struct Arguments {
    /// A scenario file, or one that comes with the program: t-to-i-far, t-to-i-below, i-to-l, sonar-to-bow
    #[arg(default_value = DEFAULT)]
    scenario: String,
    /// What to minimise [default: both, by the paper's rules, and energy at its best, beside each other]
    #[arg(long, value_enum)]
    criterion: Option<CriterionKind>,
    /// How robots move
    #[arg(long, value_enum, default_value_t = MannerKind::Best)]
    manner: MannerKind,
    /// How order and assignment are found [default: as the manner does]
    #[arg(long, value_enum)]
    order: Option<OrderKind>,
    /// How long a better order and assignment is looked for, s; the best one known is taken then. With --task, first as long for a better goal
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    time_limit: f64,
    /// What thrust costs
    #[arg(long, value_enum, default_value_t = PowerKind::Table)]
    power: PowerKind,
    /// Find the goal too: the configuration of least energy that does this task, instead of the scenario's slots
    #[arg(long, value_name = "FILE", conflicts_with = "verify")]
    task: Option<PathBuf>,
    #[command(flatten)]
    together: together::ParallelArguments,
    /// Judge this plan (a file, or - for standard input) instead of making one
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["criterion", "order"])]
    verify: Option<PathBuf>,
    /// Plan only: nothing is executed
    #[arg(long)]
    plan_only: bool,
    /// Seed of everything random in the execution, instead of the scenario's
    #[arg(long)]
    seed: Option<u64>,
    /// Share of datagrams lost
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    loss: f64,
    /// What carries the datagrams; udp needs a --criterion
    #[arg(long, value_enum, default_value_t = RadioKind::Loopback)]
    radio: RadioKind,
    /// Where to listen for ROVs (flotilla module --rov), with --radio udp
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:4870")]
    listen: String,
    /// The fleet's key file, with --radio udp [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// Which ROVs there are, and which body of the motion capture is whose, with --radio udp [default: 1, 2, … in the scenario's order]
    #[arg(long, value_name = "FILE")]
    roster: Option<PathBuf>,
    #[command(flatten)]
    poses: PoseArguments,
    /// Without a fix for this time all thrusters go to neutral, s, instead of the scenario's
    #[arg(long, value_name = "SECONDS", requires = "pose")]
    hold_after: Option<f64>,
    #[command(flatten)]
    serve: ServeArguments,
    /// Folder for logs, plans, summary.json and the pictures [default: runs/NAME, a new one each time]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print each plan as one line of JSON, and plan only
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CriterionKind {
    /// Electric energy of the mover and of the robots that balance
    Energy,
    /// Length of the paths
    Euclidean,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MannerKind {
    /// Best speed and heading for every leg, acceleration counted
    Best,
    /// Turn in place, constant speed, steady-state power
    Paper,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OrderKind {
    /// The least sum over all orders and assignments
    Exact,
    /// The least g + h moves next
    Paper,
}

/// Real ROVs.
struct Remote {
    radio: UdpRadio,
    host: HostIdentity,
    /// Which of them is which robot.
    seats: Vec<ModuleId>,
    poses: Option<LabBodies>,
}

/// A column of the results.
struct Column {
    /// Its heading, and the name of its files.
    title: &'static str,
    criterion: Criterion,
    manner: Manner,
    made: Result<Made, NotMade>,
}

impl Column {
    fn made(&self) -> Option<&Made> {
        self.made.as_ref().ok()
    }

    fn executed(&self) -> Option<&Executed> {
        self.made()?.executed.as_ref()
    }
}

/// A plan, and what its execution came to.
struct Made {
    planned: Planned,
    executed: Option<Executed>,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let opened = ReconfigureScenario::open(&arguments.scenario);
    let mut scenario = opened.map_err(bad)?;
    arguments.poses.apply(&mut scenario.pose);
    if arguments.poses.pose.is_some() && arguments.radio != RadioKind::Udp {
        return Err(Failure::Bad("--pose is for ROVs on --radio udp".to_owned()));
    }
    let together = arguments.together.checked(manner(arguments)).map_err(Failure::Bad)?;
    if let Some(seconds) = arguments.hold_after {
        if !(0.35..=60.0).contains(&seconds) {
            return Err(Failure::Bad(format!("--hold-after {seconds} s: must lie between 0.35 and 60")));
        }
        scenario.pose.hold_after_s = seconds;
    }
    if let Some(path) = &arguments.verify {
        return judge(&scenario.problem, path);
    }
    let loss = FaultParameters { loss: arguments.loss, ..FaultParameters::default() };
    loss.validate().map_err(|error| Failure::Bad(format!("--loss: {error}")))?;
    // The port comes first: an execution that no robot can join is not begun.
    let mut remote = match arguments.radio {
        RadioKind::Loopback => None,
        RadioKind::Udp if arguments.criterion.is_none() => {
            return Err(Failure::Bad("--radio udp: say which plan, by --criterion".to_owned()));
        }
        RadioKind::Udp => {
            let host = keygen::host(arguments.key.as_deref())?;
            let radio = UdpRadio::bind(arguments.listen.as_str());
            let (roster, seats) = rovs(arguments.roster.as_deref(), &scenario.problem)?;
            let poses = arguments.poses.open_rovs(&scenario, &roster, &seats)?;
            Some(Remote { radio: radio.map_err(bad)?, host, seats, poses })
        }
    };
    let mut bound = arguments.serve.bind(false)?;
    if bound.is_some() && (arguments.criterion.is_none() || arguments.plan_only || arguments.json) {
        return Err(Failure::Bad(
            "--serve shows the execution of one plan: say which, by --criterion".to_owned(),
        ));
    }
    if !(0.1..=86_400.0).contains(&arguments.time_limit) {
        let seconds = arguments.time_limit;
        return Err(Failure::Bad(format!("--time-limit {seconds} s: must lie between 0.1 and 86400")));
    }
    let limit = Duration::from_secs_f64(arguments.time_limit);
    let mut columns = Vec::new();
    let mut bar = Bar::new(&scenario.problem.name);
    if let Some(path) = &arguments.task {
        let law = arguments.power.law(scenario.problem.rules.battery_v).map_err(bad)?;
        let (criterion, manner, order) = (Criterion::Energy, Manner::Best, OrderRule::Exact);
        let request = Request { criterion, manner, order, law };
        let mut watch = GoalWatch::new(&mut bar, limit);
        let (problem, said) = task::found(&scenario.problem, path, &request, &mut watch)?;
        scenario.problem = problem;
        if std::io::stderr().is_terminal() { bar.note(&said) } else { tell(&said) }
    }
    let wanted = wanted(arguments);
    for (done, &(title, criterion, manner, order)) in wanted.iter().enumerate() {
        bar.preparing(&format!("planning: {title}"), done as u64, wanted.len() as u64);
        let law = arguments.power.law(scenario.problem.rules.battery_v).map_err(bad)?;
        let request = Request { criterion, manner, order, law };
        let mut watch = Watch::new(&mut bar, title, criterion, limit);
        let made = match planned(&scenario.problem, &request, &together, &mut watch) {
            Err(NotMade::Unfit(why)) => return Err(Failure::Bad(format!("{}: {why}", arguments.scenario))),
            made => made.map(|planned| Made { planned, executed: None }),
        };
        columns.push(Column { title, criterion, manner, made });
    }
    // A column that leads nowhere does not keep the others from being shown; it is named among them.
    let failures = columns.iter().filter_map(|column| Some((column.title, column.made.as_ref().err()?)));
    let failures: Vec<(&str, &NotMade)> = failures.collect();
    let is_defect = failures.iter().any(|(_, why)| matches!(why, NotMade::Refused(_)));
    let named: Vec<String> = failures.iter().map(|(title, why)| format!("{title}: {why}")).collect();
    let all_failed = failures.len() == columns.len();
    if arguments.json {
        drop(bar);
        print_json(&scenario.problem, &columns)?;
        return if all_failed || is_defect { Err(Failure::Could(named.join("; "))) } else { Ok(()) };
    }
    if all_failed {
        return Err(Failure::Could(named.join("; ")));
    }
    let folder = Folder::of(arguments.out.as_deref(), &scenario.problem.name)?;
    let mut logs = Vec::new();
    if !arguments.plan_only {
        signal::watch();
        let several = columns.iter().filter(|column| column.made.is_ok()).count() > 1;
        for (index, column) in columns.iter_mut().enumerate() {
            if column.made.is_err() {
                continue;
            }
            bar.note(&format!("executing: {}", column.title));
            let name = if several { format!("log-{}.mcap", column.title) } else { "log.mcap".to_owned() };
            let (console, tap) = console(bound.take());
            let (log, path) = folder.log(&name, tap)?;
            logs.push(path);
            let log = (log, index);
            let executed = execute(arguments, &scenario, column, log, (remote.take(), console), &mut bar);
            let executed = executed.inspect_err(|_| folder.discard(&logs))?;
            if let Ok(made) = &mut column.made {
                made.executed = Some(executed);
            }
        }
    }
    drop(bar);
    let mut complaints: Vec<String> = Vec::new();
    for column in &columns {
        let title = column.title;
        if let Err(why @ NotMade::Refused(_)) = &column.made {
            complaints.push(format!("{title}: {why}"));
        }
        let said = column.executed().map_or_else(Vec::new, |executed| executed.summary.complaints());
        complaints.extend(said.iter().map(|why| format!("{title}: {why}")));
    }
    // What was measured is told before anything is written, and written whether or not it could be told.
    let mut out = std::io::stdout().lock();
    let told = table::print(&mut out, &scenario.problem, &columns, arguments.power.name())
        .and_then(|()| out.flush());
    let files = save(&scenario.problem, &columns, logs, &folder);
    let listed = told.and_then(|()| list(&mut out, &files));
    complaints.extend(files.complaints);
    complaints.extend(untold(listed));
    all_said(complaints)
}

/// What stands in the place of a plan that was not made.
#[derive(serde::Serialize)]
struct FailedPlan<'a> {
    problem: &'a str,
    criterion: Criterion,
    manner: Manner,
    failure: String,
}

fn print_json(problem: &Problem, columns: &[Column]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    for column in columns {
        let line = match &column.made {
            Ok(made) => serde_json::to_string(&made.planned.plan),
            Err(why) => serde_json::to_string(&FailedPlan {
                problem: &problem.name,
                criterion: column.criterion,
                manner: column.manner,
                failure: why.to_string(),
            }),
        };
        let line = line.map_err(|error| Failure::Could(format!("plan: {error}")))?;
        written(writeln!(out, "{line}"))?;
    }
    written(out.flush())
}

/// Executes a plan on the chosen radio.
fn execute(
    arguments: &Arguments,
    scenario: &ReconfigureScenario,
    column: &Column,
    (log, index): (Log, usize),
    (remote, console): (Option<Remote>, Option<Console>),
    bar: &mut Bar,
) -> Result<Executed, Failure> {
    let Some(Made { planned: Planned { plan, .. }, .. }) = column.made() else {
        return Err(Failure::Could(format!("{}: there is no plan", column.title)));
    };
    let problem = &scenario.problem;
    let log = (log, Title { name: column.title.to_owned(), index });
    let faults = FaultParameters { loss: arguments.loss, ..FaultParameters::default() };
    let law = arguments.power.law(problem.rules.battery_v).map_err(bad)?;
    let seed = arguments.seed.unwrap_or(scenario.seed);
    let options = Options { seed, radio: faults, law };
    let Some(Remote { radio, host, seats, poses }) = remote else {
        let mut fleet = InProcess::rovs(problem, faults, seed).map_err(could)?;
        let watched = console.is_some();
        let desk = if watched { super::run::desk(&problem.name, bar) } else { Desk::signals() };
        let mut desk = Attended::new(desk, console, false)?;
        let pace = if watched { Pace::Watched } else { Pace::Simulated };
        let drive = Drive { pace, operator: &mut desk, hook: &mut |_, _, _| {} };
        return run_into(log, problem, plan, &options, &mut fleet, drive, bar).map_err(could);
    };
    let address = radio.local_address().map_err(could)?;
    let first = seats.first().map_or(1, |id| id.0);
    tell(&format!(
        "listening on {address} for {} ROVs (flotilla module --rov --id {first} --host {address}, and so on)",
        problem.robots.len()
    ));
    let mut fleet = OverUdp::rovs(problem, radio, host, seats, faults, seed);
    let mut desk = Attended::new(super::run::desk(&problem.name, bar), console, false)?;
    let drive = Drive { pace: Pace::Real, operator: &mut desk, hook: &mut |_, _, _| {} };
    let Some(poses) = poses else {
        return run_into(log, problem, plan, &options, &mut fleet, drive, bar).map_err(could);
    };
    let fixes = Some(Fixes { hold_after_s: scenario.pose.hold_after_s });
    let site = Site { water: None, poses, fixes };
    run_with(log, problem, plan, &options, &mut fleet, drive, site, bar).map_err(could)
}

/// Plans, figures and pictures.
fn save(problem: &Problem, columns: &[Column], logs: Vec<PathBuf>, folder: &Folder) -> Files {
    let mut files = folder.files();
    let made = || columns.iter().filter_map(|column| Some((column.title, column.made()?)));
    for (path, (_, made)) in logs.into_iter().zip(made()) {
        files.log(path, made.executed.as_ref().and_then(|executed| executed.log_failure.clone()));
    }
    for (title, made) in made() {
        let path = folder.path.join(format!("plan-{title}.json"));
        files.json(path, serde_json::to_string_pretty(&made.planned.plan));
    }
    let summaries: serde_json::Map<_, _> = columns
        .iter()
        .filter_map(|column| {
            let summary = match &column.made {
                Ok(made) => serde_json::to_value(&made.executed.as_ref()?.summary).ok()?,
                Err(why) => serde_json::json!({ "failure": why.to_string() }),
            };
            Some((column.title.to_owned(), summary))
        })
        .collect();
    if !summaries.is_empty() {
        files.json(folder.path.join("summary.json"), serde_json::to_string_pretty(&summaries));
    }
    let record = |(_, made): (&str, &Made)| match &made.executed {
        Some(executed) => executed.record.clone(),
        // The pictures show what was planned.
        None => Record { problem: problem.clone(), plan: made.planned.plan.clone(), samples: Vec::new() },
    };
    let records: Vec<Record> = made().map(record).collect();
    let pictures = plot::reconfigure::write_all(&records, &folder.path);
    pictures.into_iter().for_each(|picture| files.add(picture));
    files
}

fn manner(arguments: &Arguments) -> Manner {
    if arguments.manner == MannerKind::Paper { Manner::Paper } else { Manner::Best }
}

/// Which plans are asked for.
fn wanted(arguments: &Arguments) -> Vec<(&'static str, Criterion, Manner, OrderRule)> {
    let Some(criterion) = arguments.criterion else {
        return vec![
            ("energy", Criterion::Energy, Manner::Paper, OrderRule::Paper),
            ("euclidean", Criterion::Euclidean, Manner::Paper, OrderRule::Paper),
            ("best", Criterion::Energy, Manner::Best, OrderRule::Exact),
        ];
    };
    let (title, criterion) = match criterion {
        CriterionKind::Energy => ("energy", Criterion::Energy),
        CriterionKind::Euclidean => ("euclidean", Criterion::Euclidean),
    };
    let manner = manner(arguments);
    let order = match arguments.order {
        None => usual_order(manner),
        Some(OrderKind::Exact) => OrderRule::Exact,
        Some(OrderKind::Paper) => OrderRule::Paper,
    };
    vec![(title, criterion, manner, order)]
}

/// Says what is wrong with a plan from a file.
fn judge(problem: &Problem, path: &Path) -> Result<(), Failure> {
    let name = path.display();
    let text = if path == Path::new("-") {
        text_from("-", std::io::stdin().lock(), MADE_MAX).map_err(bad)?
    } else {
        let text = text_of(path, MADE_MAX).map_err(bad)?;
        text.ok_or_else(|| Failure::Bad(format!("{name}: no such file")))?
    };
    let plan: Plan = Document::json(&text).and_then(|document| document.read()).map_err(|mistake| {
        Failure::Bad(format!("{name}:{}: not a plan: {}", mistake.line, mistake.message))
    })?;
    let found = judge::verify(problem, &plan);
    let mut out = std::io::stdout().lock();
    if let Some(note) = judge::note(&plan) {
        written(writeln!(out, "note: {note}"))?;
    }
    for violation in &found {
        written(writeln!(out, "{violation}"))?;
    }
    match found.len() {
        0 => written(writeln!(out, "{name}: keeps every condition of {}", problem.name)),
        1 => Err(Failure::Could(format!("{name}: breaks a condition of {}", problem.name))),
        n => Err(Failure::Could(format!("{name}: breaks {n} conditions of {}", problem.name))),
    }
}
