//! `flotilla run`: the main job.

use std::io::Write;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use link::identity::HostIdentity;
use link::strangers::Silence;
use link::udp::UdpRadio;
use protocol::{ModuleId, ModuleKind};

use super::console::{Attended, Console, ServeArguments, console};
use super::folder::{Files, Folder};
use super::operator::socket::Desk;
use super::planner::PlannerArguments;
use super::poses::{PoseArguments, Poses};
use super::progress::Bar;
use super::{Failure, all_said, bad, could, keygen, report, signal, tell, untold};
use crate::run::RunError;
use crate::run::closed_loop::Drive;
use crate::run::experiment::{Pace, RunResult, Site, run_into, run_with};
use crate::run::fleet::{InProcess, OverUdp};
use crate::run::log::Log;
use crate::run::progress::Progress;
use crate::run::roster::Roster;
use crate::run::scenario::Scenario;

/// The scenario that runs when none is named.
pub(super) const DEFAULT: &str = "holonomic-1";

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla run\n  flotilla run holonomic-4 --seed 7 --loss 0.3\n  \
                        flotilla run --serve                         and a page that shows it, and takes orders\n  \
                        flotilla run nine --interactive --serve 127.0.0.1:8080\n  \
                        flotilla run my-boats.toml --radio udp --listen 0.0.0.0:4870\n  \
                        flotilla run my-boats.toml --radio udp --listen 0.0.0.0:4870 --pose natnet:192.168.1.10 --up y")]
pub(super) struct Arguments {
    /// A scenario file, or one that comes with the program: holonomic-1, holonomic-2, holonomic-3, holonomic-4, six, nine,
    /// twenty-five, ring, line-12, station-keeping, square-path, or identify-SHAPE (identify-3, identify-9, identify-4x2)
    #[arg(default_value = DEFAULT)]
    scenario: String,
    /// Seed of everything random, instead of the scenario's
    #[arg(long)]
    seed: Option<u64>,
    /// What carries the datagrams
    #[arg(long, value_enum, default_value_t = RadioKind::Loopback)]
    radio: RadioKind,
    /// Where to listen for modules, with --radio udp
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:4870")]
    listen: String,
    /// The fleet's key file, with --radio udp [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// Which modules there are and where each sits, with --radio udp [default: 1, 2, … in the structure's order]
    #[arg(long, value_name = "FILE")]
    roster: Option<PathBuf>,
    #[command(flatten)]
    pose: PoseArguments,
    /// Swim with so many modules at least, and leave out those that are missing: all, or a number [default: the scenario's, all]
    #[arg(long, value_name = "all|N", value_parser = required)]
    require: Option<u32>,
    /// Share of datagrams lost, instead of the scenario's
    #[arg(long, value_name = "SHARE")]
    loss: Option<f64>,
    #[command(flatten)]
    planner: PlannerArguments,
    /// Follow the wall clock (always so with --radio udp)
    #[arg(long)]
    realtime: bool,
    #[command(flatten)]
    serve: ServeArguments,
    /// Swim to no legs, but to targets that are given on the page (--serve)
    #[arg(long)]
    interactive: bool,
    /// Folder for log.mcap, summary.json and the pictures [default: runs/NAME, a new one each time]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// What carries datagrams.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum RadioKind {
    /// Modules in this process
    Loopback,
    /// Modules that are processes (`flotilla module`) or robots
    Udp,
}

pub(super) fn main(arguments: Arguments) -> Result<(), Failure> {
    let mut scenario = Scenario::open(&arguments.scenario).map_err(bad)?;
    arguments.planner.apply(&mut scenario.planner);
    if let Some(loss) = arguments.loss {
        scenario.radio.loss = loss;
        scenario.radio.validate().map_err(|error| Failure::Bad(format!("--loss: {error}")))?;
    }
    if let Some(require) = arguments.require {
        scenario.timing.require = require;
    }
    let modules = scenario.structure.len();
    if scenario.timing.require as usize > modules {
        let require = scenario.timing.require;
        return Err(Failure::Bad(format!(
            "--require {require}: there are only {modules} modules in {}",
            scenario.name
        )));
    }
    arguments.pose.apply(&mut scenario.pose);
    if arguments.interactive {
        scenario = scenario.without_legs();
    }
    let seed = arguments.seed.unwrap_or(scenario.seed);
    // Port and folder come first: a run that no module can join, or whose results have nowhere to go, is not begun.
    let radio = match arguments.radio {
        RadioKind::Loopback if arguments.pose.pose.is_some() => {
            return Err(Failure::Bad(
                "--pose needs --radio udp: modules in this process swim in simulated water".to_owned(),
            ));
        }
        RadioKind::Loopback => None,
        RadioKind::Udp => Some(remote(&arguments, &scenario)?),
    };
    let bound = arguments.serve.bind(arguments.interactive)?;
    let folder = Folder::of(arguments.out.as_deref(), &scenario.name)?;
    signal::watch();
    let (console, tap) = console(bound);
    let (log, path) = folder.log("log.mcap", tap)?;
    let result = swim(&arguments, &scenario, seed, radio, log, console);
    let result = result.inspect_err(|_| folder.discard(std::slice::from_ref(&path)))?;
    let mut complaints = result.summary.complaints();
    // What was measured is told before anything is written, and written whether or not it could be told.
    let json = || serde_json::to_string_pretty(&result.summary);
    let mut out = std::io::stdout().lock();
    let told = if arguments.json {
        json().map_err(std::io::Error::other).and_then(|json| writeln!(out, "{json}"))
    } else {
        report::print(&mut out, &result.summary)
    };
    let told = told.and_then(|()| out.flush());
    let mut files = folder.files();
    files.log(path, result.log_failure);
    files.json(folder.path.join("summary.json"), json());
    plot::write_all(&result.record, &folder.path).into_iter().for_each(|picture| files.add(picture));
    let listed = told.and_then(|()| if arguments.json { Ok(()) } else { list(&mut out, &files) });
    complaints.extend(files.complaints);
    complaints.extend(untold(listed));
    all_said(complaints)
}

/// The files that were written.
pub(super) fn list(out: &mut impl Write, files: &Files) -> std::io::Result<()> {
    files.paths.iter().try_for_each(|path| writeln!(out, "  {}", path.display())).and_then(|()| out.flush())
}

/// `all` is zero.
fn required(text: &str) -> Result<u32, String> {
    match text.parse() {
        _ if text == "all" => Ok(0),
        Ok(count @ 1..=1024) => Ok(count),
        _ => Err("must be `all` or a number of modules from 1 to 1024".to_owned()),
    }
}

/// Modules that are not in this process.
struct Remote {
    radio: UdpRadio,
    host: HostIdentity,
    roster: Vec<ModuleId>,
    /// A motion capture; without one the water is simulated here.
    poses: Option<Poses>,
}

fn remote(arguments: &Arguments, scenario: &Scenario) -> Result<Remote, Failure> {
    let host = keygen::host(arguments.key.as_deref())?;
    let all = fleet(arguments.roster.as_deref(), scenario)?;
    let roster = all.seats(&scenario.structure).map_err(bad)?;
    let poses = arguments.pose.open(scenario, &all, &roster)?;
    let radio = UdpRadio::bind(arguments.listen.as_str()).map_err(bad)?;
    Ok(Remote { radio, host, roster, poses })
}

/// The roster in a file, or modules 1, 2, … where there is none.
pub(super) fn fleet(path: Option<&Path>, scenario: &Scenario) -> Result<Roster, Failure> {
    match path {
        Some(path) => Roster::read(path).map_err(bad),
        None => Ok(Roster::numbered(scenario.structure.len(), ModuleKind::Modboat)),
    }
}

/// Runs `scenario` on the chosen radio.
fn swim(
    arguments: &Arguments,
    scenario: &Scenario,
    seed: u64,
    remote: Option<Remote>,
    log: Log,
    console: Option<Console>,
) -> Result<RunResult, Failure> {
    let mut bar = Bar::new(&scenario.name);
    let Some(Remote { radio, host, roster, poses }) = remote else {
        let watched = arguments.realtime || console.is_some();
        let pace = if watched { Pace::Watched } else { Pace::Simulated };
        let mut fleet = InProcess::boats(scenario, seed).map_err(|error| failure(error, ""))?;
        let desk = if watched { desk(&scenario.name, &mut bar) } else { Desk::signals() };
        let mut desk = Attended::new(desk, console, true)?;
        let drive = Drive { pace, operator: &mut desk, hook: &mut |_, _, _| {} };
        let result = run_into(log, scenario, seed, &mut fleet, drive, &mut bar);
        return result.map_err(|error| failure(error, ""));
    };
    let address = radio.local_address().map_err(could)?;
    let listening = format!("listening on {address} for {} modules", scenario.structure.len());
    // A port that the system chose must be told to scripts too.
    if arguments.listen.ends_with(":0") {
        tell(&listening);
    } else {
        bar.note(&listening);
    }
    let mut fleet = OverUdp::boats(scenario, radio, host, roster, seed);
    let mut desk = Attended::new(desk(&scenario.name, &mut bar), console, true)?;
    let drive = Drive { pace: Pace::Real, operator: &mut desk, hook: &mut |_, _, _| {} };
    let result = match poses {
        Some(Poses::Lab(poses)) => {
            let site = Site { water: None, poses: *poses };
            run_with(log, scenario, seed, &mut fleet, drive, site, &mut bar)
        }
        Some(Poses::Logged(poses)) => {
            let site = Site { water: None, poses };
            run_with(log, scenario, seed, &mut fleet, drive, site, &mut bar)
        }
        None => run_into(log, scenario, seed, &mut fleet, drive, &mut bar),
    };
    result.map_err(|error| failure(error, &invitation(arguments, address)))
}

/// Where an operator reaches the run. A run that cannot be reached is begun all the same: Ctrl-C stops it.
pub(super) fn desk(scenario: &str, bar: &mut Bar) -> Desk {
    Desk::open(scenario).unwrap_or_else(|error| {
        bar.note(&format!("flotilla stop, hold, release and status do not reach this run: {error}"));
        Desk::signals()
    })
}

/// What a module that does not answer may be started with, less its number.
fn invitation(arguments: &Arguments, mut address: SocketAddr) -> String {
    if address.ip().is_unspecified() {
        let local: IpAddr =
            if address.is_ipv4() { Ipv4Addr::LOCALHOST.into() } else { Ipv6Addr::LOCALHOST.into() };
        address.set_ip(local);
    }
    let scenario = match arguments.scenario.as_str() {
        DEFAULT => String::new(),
        scenario => format!(" --scenario {scenario}"),
    };
    let key = arguments.key.as_ref().map_or_else(String::new, |key| format!(" --key {}", key.display()));
    format!("--host {address}{scenario}{key}")
}

/// `invitation` is empty where modules are not processes.
pub(super) fn failure(error: RunError, invitation: &str) -> Failure {
    match error {
        RunError::Silent { kind, modules, known, waited_s, .. } => {
            if modules.is_empty() && known.is_empty() {
                return Failure::Could(format!(
                    "no cycle was found for {waited_s} s in which no tails meet; every module held"
                ));
            }
            let hint = match (invitation, modules.first()) {
                ("", _) | (_, None) => String::new(),
                (_, Some(first)) => format!(" (start it with: flotilla module --id {first} {invitation})"),
            };
            // One that is there and cannot be used is no mistake in what the host or the module was given.
            let is_there = |reason| {
                use Silence::{Doubled, Implausible, ServesAnotherHost, Stopped};
                matches!(reason, Doubled | Implausible | Stopped | ServesAnotherHost)
            };
            let all_there = modules.is_empty() && known.iter().all(|(_, reason, _)| is_there(*reason));
            let failure = if all_there { Failure::Could } else { Failure::Bad };
            failure(RunError::Silent { kind, modules, known, waited_s, hint }.to_string())
        }
        RunError::Parameter(_) | RunError::Module { .. } => Failure::Bad(error.to_string()),
        RunError::Pose(_)
        | RunError::Radio(_)
        | RunError::Rov { .. }
        | RunError::Execution(_)
        | RunError::Log(_) => Failure::Could(error.to_string()),
    }
}
