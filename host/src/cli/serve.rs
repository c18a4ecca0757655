//! `flotilla serve`: the page of a log, and a stream of its topics.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use runconsole::player::Player;
use runconsole::server::{ADDRESS, Source, bind};

use super::console::{invite, stage};
use super::{Failure, bad, could, signal};

/// Pause between two looks at whether it is to end.
const LOOK_EVERY: Duration = Duration::from_millis(50);

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla serve runs/holonomic-1/log.mcap\n  \
                        flotilla serve runs/i-to-l/log-best.mcap --at 127.0.0.1:8080\n  \
                        flotilla serve log.mcap --at 0.0.0.0:4880 --allow-remote")]
pub(super) struct Arguments {
    /// The log of a run or of a reconfiguration
    log: PathBuf,
    /// Where to serve it
    #[arg(long, value_name = "ADDRESS", default_value = ADDRESS)]
    at: String,
    /// Let others than this machine reach the page
    #[arg(long)]
    allow_remote: bool,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let player = Player::open(&arguments.log, Instant::now()).map_err(bad)?;
    let bound = bind(&arguments.at, arguments.allow_remote).map_err(bad)?;
    signal::watch();
    invite(&bound);
    let server = bound.start(Source::Log(Box::new(player)), Box::new(stage::stage)).map_err(could)?;
    while !signal::STOP.load(Ordering::Relaxed) {
        std::thread::sleep(LOOK_EVERY);
    }
    drop(server);
    Ok(())
}
