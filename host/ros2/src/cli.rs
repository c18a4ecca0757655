//! The command line. Exit codes: 0 done, 1 could not, 2 bad usage or input.

use std::fmt::Display;
use std::net::SocketAddr;
use std::process::ExitCode;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Parser, Subcommand, ValueEnum};
use pose::ros2::Topics;
use ros2_client::ServiceMapping;

use crate::attach::Address;
use crate::bridge::{self, BridgeError};
use crate::node::{self, DOMAIN_MAX};
use crate::poses;

/// A bridge between a run of Flotilla and ROS 2. No ROS is needed: it speaks DDS by itself.
#[derive(Parser)]
#[command(name = "flotilla-ros2", version, about, long_about = None, after_help = EXAMPLE)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLE: &str = "Example:\n  flotilla run --interactive --serve          prints the page: http://127.0.0.1:4880/#token=…\n  \
                       flotilla-ros2 bridge 'http://127.0.0.1:4880/#token=…'";

#[derive(Subcommand)]
enum Command {
    /// Show a run in ROS 2, and steer it by cmd_vel, goal_pose and services
    Bridge(BridgeArguments),
    /// Serve poses that a driver publishes in ROS 2 to a run, by VRPN; flotilla run --pose ros2:/… starts this by itself
    Poses(PosesArguments),
}

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla-ros2 bridge 'http://127.0.0.1:4880/#token=…'\n  \
                        flotilla-ros2 bridge 'http://127.0.0.1:4880/#token=…' --namespace lab/boats --world map --domain 7")]
struct BridgeArguments {
    /// The address of the run's page, with the token: as flotilla run --serve prints it. Without the token the bridge only shows
    #[arg(value_name = "ADDRESS")]
    address: Address,
    /// In front of the fleet's topics and frames; / for none
    #[arg(long, value_name = "NAME", default_value = "flotilla")]
    namespace: String,
    /// What the world's frame is called in ROS
    #[arg(long, value_name = "FRAME", default_value = "world")]
    world: String,
    /// Odometry and joint states reliably too, for tools that do not take best effort
    #[arg(long)]
    reliable: bool,
    /// The middleware of those who call services [default: RMW_IMPLEMENTATION, or fastrtps]
    #[arg(long, value_enum, value_name = "NAME")]
    rmw: Option<Middleware>,
    #[command(flatten)]
    domain: DomainArguments,
}

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla-ros2 poses /module_1/pose,/module_2/pose\n  \
                        flotilla-ros2 poses /tf@mocap --listen 0.0.0.0:3883    then: flotilla run … --pose vrpn:HOST")]
struct PosesArguments {
    /// [BODY=]/TOPIC[,…][@FRAME]: PoseStamped or Odometry, a body each; or TFMessage, whose bodies are children of FRAME
    #[arg(value_name = "TOPICS")]
    topics: Topics,
    /// Where VRPN is served; the address is printed
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:3883")]
    listen: SocketAddr,
    /// End when standard input does
    #[arg(long, hide = true)]
    attached: bool,
    #[command(flatten)]
    domain: DomainArguments,
}

#[derive(clap::Args)]
struct DomainArguments {
    /// DDS domain [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(..=i64::from(DOMAIN_MAX)))]
    domain: Option<u16>,
}

/// A middleware of ROS 2.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Middleware {
    /// rmw_fastrtps_cpp, and others that follow the standard.
    Fastrtps,
    /// rmw_cyclonedds_cpp.
    Cyclonedds,
}

/// How a command ended, if not well.
enum Failure {
    /// It could not be done.
    Could(String),
    /// Usage or input is wrong.
    Bad(String),
}

/// Becomes true by Ctrl-C, or a request to terminate.
static STOP: LazyLock<AtomicBool> = LazyLock::new(AtomicBool::default);

/// Runs the program.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    watch();
    let outcome = match arguments.command {
        Command::Bridge(arguments) => bridge(arguments),
        Command::Poses(arguments) => relay(arguments),
    };
    let (code, text) = match outcome {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Could(text)) => (1, text),
        Err(Failure::Bad(text)) => (2, text),
    };
    eprintln!("error: {text}");
    ExitCode::from(code)
}

/// The first signal ends the program in good order, the second at once.
fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    // Without a handler a signal ends the program at once.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        for _ in signals.forever() {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        }
    });
}

fn bridge(arguments: BridgeArguments) -> Result<(), Failure> {
    let BridgeArguments { address, namespace, world, reliable, rmw, domain } = arguments;
    let namespace =
        node::namespace(&namespace).map_err(|error| Failure::Bad(format!("--namespace: {error}")))?;
    let domain = domain.number()?;
    let mapping = match rmw.map_or_else(middleware, Ok)? {
        Middleware::Fastrtps => ServiceMapping::Enhanced,
        Middleware::Cyclonedds => ServiceMapping::Cyclone,
    };
    let settings = bridge::Settings { address, namespace, world, domain, reliable, mapping };
    bridge::run(&settings, &STOP).map_err(|error| match error {
        BridgeError::Token(_) => Failure::Bad(error.to_string()),
        BridgeError::Attach(_) | BridgeError::Node(_) => could(error),
    })
}

fn relay(arguments: PosesArguments) -> Result<(), Failure> {
    let PosesArguments { topics, listen, attached, domain } = arguments;
    let settings = poses::Settings { topics, listen, domain: domain.number()?, attached };
    poses::run(&settings, &STOP).map_err(could)
}

fn could(error: impl Display) -> Failure {
    Failure::Could(error.to_string())
}

impl DomainArguments {
    fn number(&self) -> Result<u16, Failure> {
        let Some(said) =
            std::env::var("ROS_DOMAIN_ID").ok().filter(|said| self.domain.is_none() && !said.is_empty())
        else {
            return Ok(self.domain.unwrap_or_default());
        };
        let number = said.parse().ok().filter(|number| *number <= DOMAIN_MAX);
        number.ok_or_else(|| {
            Failure::Bad(format!("ROS_DOMAIN_ID = \"{said}\": must lie between 0 and {DOMAIN_MAX}"))
        })
    }
}

fn middleware() -> Result<Middleware, Failure> {
    match std::env::var("RMW_IMPLEMENTATION").unwrap_or_default().as_str() {
        "" | "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" | "rmw_connextdds" => Ok(Middleware::Fastrtps),
        "rmw_cyclonedds_cpp" => Ok(Middleware::Cyclonedds),
        other => Err(Failure::Bad(format!(
            "RMW_IMPLEMENTATION = \"{other}\": is not spoken here; there are rmw_fastrtps_cpp and rmw_cyclonedds_cpp"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use pose::ros2::TopicError;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory as _;
        Arguments::command().debug_assert();
    }

    #[test]
    fn topics_that_are_none_are_named() {
        let error = Arguments::try_parse_from(["flotilla-ros2", "poses", "pose"]).err().expect("no topic");
        assert!(error.to_string().contains(&TopicError::Name("pose".to_owned()).to_string()), "{error}");
    }
}
