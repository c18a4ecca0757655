//! `flotilla stop`, `hold`, `release`, `status`: to the run that is going on, or, where none is, straight to the modules.

mod client;
mod direct;
pub(super) mod socket;

use std::io::Write;
use std::path::PathBuf;

use protocol::ModuleId;
use serde::{Deserialize, Serialize};

use super::{Failure, written};
use crate::run::orders::{ModuleStatus, Order};

#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  flotilla stop                      the run that is going on, or all modules that answer\n  \
                        flotilla release --module 3\n  flotilla status --json\n  \
                        flotilla stop --key tank/fleet.key --listen 0.0.0.0:4870     with no run going on"
)]
pub(super) struct Arguments {
    /// This module alone; where a run is going on, to release it or to know
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u16).range(1..=1024))]
    module: Option<u16>,
    /// The run of this process, where several are going on
    #[arg(long, value_name = "PID")]
    run: Option<u32>,
    /// Where modules look for their host, where no run is going on
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:4870")]
    listen: String,
    /// The fleet's key file, where no run is going on [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// How long to wait for modules, s
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0)]
    wait: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What an operator wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Wish {
    /// Emergency stop.
    Stop,
    /// Hold.
    Hold,
    /// End of both.
    Release,
    /// Nothing but to know.
    Status,
}

impl Wish {
    fn order(self, module: Option<ModuleId>) -> Option<Order> {
        match self {
            Self::Stop => Some(Order::Stop),
            Self::Hold => Some(Order::Hold),
            Self::Release => Some(Order::Release(module)),
            Self::Status => None,
        }
    }

    /// Whether a module has followed it, by what it says; `None` where there is nothing to follow.
    fn is_followed(self, module: &ModuleStatus) -> Option<bool> {
        let state = module.state.as_deref();
        match self {
            Self::Stop => Some(state == Some("Stopped")),
            Self::Release => Some(state.is_some_and(|state| state != "Stopped")),
            Self::Hold => Some(state.is_some_and(|state| state != "Executing")),
            Self::Status => None,
        }
    }
}

pub(super) fn main(wish: Wish, arguments: &Arguments) -> Result<(), Failure> {
    if !(arguments.wait > 0.0 && arguments.wait <= 3_600.0) {
        return Err(Failure::Bad(format!("--wait = {} s: must lie above 0, up to 3600", arguments.wait)));
    }
    let (who, modules) = match client::running(arguments.run)? {
        Some(run) => {
            if arguments.module.is_some() && matches!(wish, Wish::Stop | Wish::Hold) {
                let run = run.name();
                return Err(Failure::Bad(format!(
                    "--module: {run} is going on: it stops and holds as a whole"
                )));
            }
            let mut modules = client::ask(&run, wish, arguments.module, arguments.wait)?;
            modules.retain(|module| arguments.module.is_none_or(|id| module.id == id));
            (run.name(), modules)
        }
        None => {
            let only = arguments.module.map(ModuleId);
            ("no run is going on: straight to the modules".to_owned(), direct::ask(wish, only, arguments)?)
        }
    };
    tell(arguments.json, &who, &modules)?;
    judge(wish, arguments, &modules)
}

/// What came of it is printed first.
fn tell(json: bool, who: &str, modules: &[ModuleStatus]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if json {
        let line = serde_json::to_string(&serde_json::json!({ "run": who, "modules": modules }));
        let line = line.map_err(|error| Failure::Could(format!("status: {error}")))?;
        return written(writeln!(out, "{line}"));
    }
    let row = |module: &ModuleStatus| {
        let state = module.state.as_deref().unwrap_or("not heard");
        let battery = module.battery_v.map_or_else(|| "–".to_owned(), |volts| format!("{volts:.2} V"));
        let silent = module.silent_s.map_or_else(|| "–".to_owned(), |s| format!("{s:.1} s ago"));
        let faults = module.faults.join(", ");
        format!("{:>6}  {state:<14} {battery:>8}  {silent:>10}  {faults}", module.id)
    };
    let mut lines = vec![who.to_owned()];
    if !modules.is_empty() {
        lines.push(format!("{:>6}  {:<14} {:>8}  {:>10}  faults", "module", "state", "battery", "heard"));
    }
    lines.extend(modules.iter().map(row));
    written(lines.iter().try_for_each(|line| writeln!(out, "{line}")))
}

fn judge(wish: Wish, arguments: &Arguments, modules: &[ModuleStatus]) -> Result<(), Failure> {
    if modules.is_empty() {
        return Err(Failure::Could(format!("no module was heard within {} s", arguments.wait)));
    }
    let against: Vec<String> = modules
        .iter()
        .filter(|module| wish.is_followed(module) == Some(false))
        .map(|module| match module.state.as_deref() {
            Some(state) => format!("{} ({state})", module.id),
            None => format!("{} (not heard)", module.id),
        })
        .collect();
    if against.is_empty() {
        return Ok(());
    }
    Err(Failure::Could(format!("not followed within {} s by {}", arguments.wait, against.join(", "))))
}
