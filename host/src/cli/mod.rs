//! The command line. Each command is a file; contracts (JSON fields, units, exit codes) are fixed: people script
//! against them.
//!
//! Exit codes: 0 done, 1 could not, 2 bad usage or input.

use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod campaign;
mod compare;
mod console;
mod envelope;
mod export;
mod filter;
mod folder;
mod identify;
mod keygen;
mod module;
mod operator;
mod path;
mod plan;
mod planner;
mod poses;
mod probe;
mod progress;
mod provision;
mod real_time;
mod reconfigure;
mod replay;
mod report;
mod request;
mod run;
mod serve;
mod signal;
mod simulate;
mod tank;

/// Swim a fleet of docked Modboats, or reconfigure a cluster of ROVs, from one PC.
#[derive(Parser)]
#[command(name = "flotilla", version, about, long_about = None, after_help = EXAMPLE)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLE: &str =
    "Example:\n  flotilla run holonomic-1      three docked modules swim the first holonomic experiment";

#[derive(Subcommand)]
enum Command {
    /// Plan, dispatch, execute and observe in a closed loop; leaves figures and pictures in a folder
    Run(run::Arguments),
    /// Run several planners on one scenario with the same seeds, and set their figures side by side
    Compare(compare::Arguments),
    /// Run a study of many runs: scenarios, parameters, seeds and planners, one row a run; on all cores, or a cluster
    Campaign(campaign::Arguments),
    /// Filter: one JSON request a line in, one JSON plan a line out
    Plan(plan::Arguments),
    /// Filter: 6-DOF motion of an ROV under given forces or pulses, one JSON request a line in, one JSON reply out
    Simulate(simulate::Arguments),
    /// Shortest paths on 2D and 3D maps, at any angle or by A*: one query, or a scenario of them
    Path(path::Arguments),
    /// Plan how ROVs change their configuration at least energy, and execute it in simulation
    Reconfigure(reconfigure::Arguments),
    /// A page that shows a log, and a stream of its topics: play, pause, scrub
    Serve(serve::Arguments),
    /// Figures and pictures of a run again, from its log
    Replay(replay::Arguments),
    /// The topics of a log as tables
    Export(export::Arguments),
    /// Constants of the boat from logs of its runs, with intervals; or an experiment that shows them
    Identify(identify::Arguments),
    /// One module as a process of its own on UDP: the firmware on a simulated motor
    Module(module::Arguments),
    /// What a motion-capture system sends: bodies, rate, latency, lost frames, and what is likely wrong
    Probe(probe::Arguments),
    /// A laboratory in a box: the scenario's modules on UDP, the water, and a motion-capture server over it
    Tank(tank::Arguments),
    /// Emergency stop: every drive off at once, tails braked, until a release
    Stop(operator::Arguments),
    /// The fleet finishes its cycle and holds, until a release
    Hold(operator::Arguments),
    /// End a stop or a hold
    Release(operator::Arguments),
    /// What each module does, and what is wrong with it
    Status(operator::Arguments),
    /// Make the secret key of a fleet, or from it the key of one module
    Keygen(keygen::Arguments),
    /// Make what is written to a module's flash: its number, its key, its network, the constants of its hardware
    Provision(provision::Arguments),
}

/// How a command ended, if not well.
enum Failure {
    /// It could not be done.
    Could(String),
    /// The same for several reasons, a line each.
    Several(Vec<String>),
    /// Usage or input is wrong.
    Bad(String),
}

/// What is the user's to mend.
fn bad(error: impl Display) -> Failure {
    Failure::Bad(error.to_string())
}

/// What is not.
fn could(error: impl Display) -> Failure {
    Failure::Could(error.to_string())
}

/// Runs the program.
#[must_use]
pub fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Run(arguments) => run::main(arguments),
        Command::Compare(arguments) => compare::main(&arguments),
        Command::Campaign(arguments) => campaign::main(&arguments),
        Command::Plan(arguments) => plan::main(&arguments),
        Command::Simulate(arguments) => simulate::main(&arguments),
        Command::Path(arguments) => path::main(&arguments),
        Command::Reconfigure(arguments) => reconfigure::main(&arguments),
        Command::Serve(arguments) => serve::main(&arguments),
        Command::Replay(arguments) => replay::main(&arguments),
        Command::Export(arguments) => export::main(&arguments),
        Command::Identify(arguments) => identify::main(&arguments),
        Command::Module(arguments) => module::main(&arguments),
        Command::Probe(arguments) => probe::main(&arguments),
        Command::Tank(arguments) => tank::main(&arguments),
        Command::Stop(arguments) => operator::main(operator::Wish::Stop, &arguments),
        Command::Hold(arguments) => operator::main(operator::Wish::Hold, &arguments),
        Command::Release(arguments) => operator::main(operator::Wish::Release, &arguments),
        Command::Status(arguments) => operator::main(operator::Wish::Status, &arguments),
        Command::Keygen(arguments) => keygen::main(&arguments),
        Command::Provision(arguments) => provision::main(&arguments),
    };
    let (code, messages) = match outcome {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Could(message)) => (1, vec![message]),
        Err(Failure::Several(messages)) => (1, messages),
        Err(Failure::Bad(message)) => (2, vec![message]),
    };
    messages.iter().filter(|message| !message.is_empty()).for_each(|message| complain(message));
    ExitCode::from(code)
}

/// How a command ended that has this to say, if it has.
fn all_said(complaints: Vec<String>) -> Result<(), Failure> {
    if complaints.is_empty() { Ok(()) } else { Err(Failure::Several(complaints)) }
}

/// One line to standard error: whatever a name or key in `message` holds, it makes no second line and no colour.
fn complain(message: &str) {
    let message: String = message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    tell(&format!("flotilla: {message}"));
}

/// One line to standard error; a closed standard error is ignored (`eprintln` panics there).
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// What became of writing to standard output. A reader that has gone away has seen enough.
fn written(outcome: std::io::Result<()>) -> Result<(), Failure> {
    match outcome {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Could(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// The same, for one that goes on: what there is to say.
fn untold(outcome: std::io::Result<()>) -> Option<String> {
    match written(outcome) {
        Err(Failure::Could(message)) => Some(message),
        _ => None,
    }
}
