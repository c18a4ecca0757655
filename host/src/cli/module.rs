//! `flotilla module`: one module as a process on UDP. The firmware crate, compiled for the PC, drives a simulated
//! motor, or the simulated thrusters of an ROV; everything between host and firmware is real.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};

use link::key_file::ModuleCredentials;
use link::udp::{BrokenRadio, UdpRadio};
use protocol::ModuleState;
use protocol::time::Duration;
use sim::clock::ClockParameters;
use sim::module::{Boat, SimModule};
use sim::node::Setup;
use sim::rov::{SimRov, Thrusters};

use super::keygen::module_credentials;
use super::real_time::{Live, live};
use super::{Failure, bad, could, tell};
use crate::run::scenario::Scenario;

#[derive(clap::Args)]
#[command(after_help = "Example:\n  flotilla module --id 1 --host 127.0.0.1:4870 &\n  \
                        flotilla module --id 2 --host 127.0.0.1:4870 &\n  \
                        flotilla module --id 3 --host 127.0.0.1:4870 &\n  \
                        flotilla run holonomic-1 --radio udp --listen 127.0.0.1:4870\n\n  \
                        flotilla module --rov --id 1 --thrusters 6 --battery 16")]
pub(super) struct Arguments {
    /// Number in the fleet, from 1
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    id: u16,
    /// Where the host listens
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:4870")]
    host: String,
    /// Its key file, or on the host's machine the fleet's [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// Where this module listens; port 0 takes any free one [default: any port, on this machine alone if the host is
    /// on it]
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<String>,
    /// An ROV: thrusters instead of a tail
    #[arg(long, conflicts_with = "scenario")]
    rov: bool,
    /// How many thrusters the ROV has
    #[arg(long, value_name = "COUNT", default_value_t = 6, requires = "rov",
          value_parser = clap::value_parser!(u8).range(1..=8))]
    thrusters: u8,
    /// Thrusters whose wires are swapped, from 1, such as 2,5
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', requires = "rov")]
    reversed: Vec<u8>,
    /// Battery voltage of the ROV, 10 to 20 V
    #[arg(long, value_name = "VOLTS", default_value_t = 16.0, requires = "rov")]
    battery: f64,
    /// Take motor, geometry and start pose from this scenario [default: holonomic-1]
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// End by itself after so many seconds
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let host = resolve(&arguments.host)?;
    if let Some(seconds) = arguments.duration.filter(|seconds| !(*seconds > 0.0 && *seconds <= 1e7)) {
        return Err(Failure::Bad(format!("--duration = {seconds} s: must lie between 0 and 10000000")));
    }
    if arguments.rov { rov(arguments, host) } else { modboat(arguments, host) }
}

/// A process has a clock of its own already: real, and wrong by its own start.
const CLOCK: ClockParameters = ClockParameters { offset_s: 0.0, drift_ppm: 0.0 };

/// Pause between two reports of a Modboat.
pub(super) const MODBOAT_REPORTS: Duration = Duration(10_000);
/// And of an ROV.
pub(super) const ROV_REPORTS: Duration = Duration(20_000);

/// Module `id` of this process. Its seed tells its lives apart, and the modules of one process.
pub(super) fn setup(key: Option<&Path>, id: u16, report_every: Duration) -> Result<Setup<'static>, Failure> {
    let ModuleCredentials { id, fleet, key } = module_credentials(key, id)?;
    let life = u64::from(std::process::id()) << 32 | since_epoch_us() & 0xFFFF_FFFF;
    let seed = life.wrapping_mul(1_000_003).wrapping_add(u64::from(id.0));
    Ok(Setup { id, fleet, key, report_every, clock: &CLOCK, seed })
}

/// A module's radio on `listen`, or on any port that `host` reaches. A network that is away for a while does not end a module.
pub(super) fn radio(listen: Option<&str>, host: SocketAddr) -> Result<UdpRadio, Failure> {
    let listen = listen.map_or_else(|| any_port(host), str::to_owned);
    Ok(UdpRadio::bind(listen.as_str()).map_err(bad)?.patient())
}

fn modboat(arguments: &Arguments, host: SocketAddr) -> Result<(), Failure> {
    let name = arguments.scenario.as_deref().unwrap_or(super::run::DEFAULT);
    let scenario = Scenario::open(name).map_err(bad)?;
    let modules = scenario.structure.len();
    if arguments.scenario.is_some() && usize::from(arguments.id) > modules {
        let id = arguments.id;
        return Err(Failure::Bad(format!("--id {id}: there are only {modules} modules in {name}")));
    }
    let setup = setup(arguments.key.as_deref(), arguments.id, MODBOAT_REPORTS)?;
    let (radio, address) = listen(arguments, host)?;
    let tail_rad = scenario.start.tail_rad;
    let boat = Boat::new(&scenario.modboat, &scenario.motor, tail_rad, setup.seed).map_err(bad)?;
    let mut module = SimModule::new(&setup, boat, radio, host).map_err(bad)?;
    tell(&format!("module {} on {address}, host at {host}", arguments.id));
    follow(arguments, |&Live { tick, hears }| module.live(tick.now, hears).map(|()| module.state(tick.now)))
}

fn rov(arguments: &Arguments, host: SocketAddr) -> Result<(), Failure> {
    let thrusters = arguments.thrusters;
    if let Some(number) = arguments.reversed.iter().find(|number| !(1..=thrusters).contains(number)) {
        return Err(Failure::Bad(format!("--reversed {number}: there are only {thrusters} thrusters")));
    }
    let reversed: Vec<bool> = (1..=thrusters).map(|number| arguments.reversed.contains(&number)).collect();
    let setup = setup(arguments.key.as_deref(), arguments.id, ROV_REPORTS)?;
    let (radio, address) = listen(arguments, host)?;
    let thrusters = Thrusters::new(&reversed, arguments.battery).map_err(bad)?;
    let mut rov = SimRov::new(&setup, thrusters, radio, host).map_err(bad)?;
    tell(&format!("ROV {} on {address}, host at {host}", arguments.id));
    follow(arguments, |&Live { tick, hears }| rov.live(tick.now, hears).map(|()| rov.state(tick.now)))
}

/// The radio, and where it listens.
fn listen(arguments: &Arguments, host: SocketAddr) -> Result<(UdpRadio, SocketAddr), Failure> {
    let radio = radio(arguments.listen.as_deref(), host)?;
    let address = radio.local_address().map_err(could)?;
    Ok((radio, address))
}

/// Ticks in real time until told to end, and tells every change of state.
fn follow(
    arguments: &Arguments,
    mut tick: impl FnMut(&Live) -> Result<Option<ModuleState>, BrokenRadio>,
) -> Result<(), Failure> {
    let mut state = None;
    live(arguments.duration, |now| {
        let present = tick(&now).map_err(could)?;
        if present != state {
            state = present;
            if let Some(present) = present {
                let t_s = now.tick.now.as_secs_f64();
                tell(&format!("module {} at {t_s:.3} s: {present:?}", arguments.id));
            }
        }
        Ok(())
    })
}

pub(super) fn resolve(address: &str) -> Result<SocketAddr, Failure> {
    let mut found = address
        .to_socket_addrs()
        .map_err(|error| Failure::Bad(format!("--host {address}: {error} (it takes ADDRESS:PORT)")))?;
    match found.next() {
        Some(found) if found.port() != 0 => Ok(found),
        Some(_) => Err(Failure::Bad(format!("--host {address}: port 0 cannot be sent to"))),
        None => Err(Failure::Bad(format!("--host {address}: no such address"))),
    }
}

/// Any free port where `host` can be reached from: a socket on the loopback reaches no other machine.
fn any_port(host: SocketAddr) -> String {
    let ip: IpAddr = match (host, host.ip().is_loopback()) {
        (SocketAddr::V4(_), true) => Ipv4Addr::LOCALHOST.into(),
        (SocketAddr::V4(_), false) => Ipv4Addr::UNSPECIFIED.into(),
        (SocketAddr::V6(_), true) => Ipv6Addr::LOCALHOST.into(),
        (SocketAddr::V6(_), false) => Ipv6Addr::UNSPECIFIED.into(),
    };
    SocketAddr::new(ip, 0).to_string()
}

fn since_epoch_us() -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(0, |since| since.as_micros() as u64)
}
