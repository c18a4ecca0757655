//! The console of a run: its page and stream, and the orders that come by it.

use std::time::Instant;

use clap::Args;
use protocol::ModuleId;
use runconsole::desk::{Ask, Desk as ConsoleDesk, Wanted, desk};
use runconsole::server::{ADDRESS, Bound, Server, Source, bind};
use runconsole::tap::{Live, tap};
use runlog::writer::Tap;

use super::operator::socket::Desk;
use super::{Failure, could, tell};
use crate::run::orders::{Operator, Order, RunStatus};
use crate::run::steering::Steering;

pub(super) mod stage;

#[derive(Args)]
pub(super) struct ServeArguments {
    /// Serve a page that shows the run, and takes orders; follows the wall clock [default ADDRESS: 127.0.0.1:4880]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = ADDRESS)]
    pub(super) serve: Option<String>,
    /// Let others than this machine reach the page: a person with its address may order
    #[arg(long)]
    pub(super) allow_remote: bool,
}

impl ServeArguments {
    /// Takes the port, where a page is asked for, or `needed`.
    pub(super) fn bind(&self, needed: bool) -> Result<Option<Bound>, Failure> {
        let Some(address) = self.serve.as_deref().or(needed.then_some(ADDRESS)) else {
            return match self.allow_remote {
                true => Err(Failure::Bad("--allow-remote needs --serve".to_owned())),
                false => Ok(None),
            };
        };
        if !address.contains(':') {
            return Err(Failure::Bad(format!(
                "--serve {address}: wants ADDRESS:PORT; a scenario's name stands before --serve"
            )));
        }
        bind(address, self.allow_remote).map(Some).map_err(Failure::Bad)
    }
}

/// The console of a run that has not begun.
pub(super) struct Console {
    bound: Bound,
    live: Live,
}

/// The console of what `bound` serves, and what the log's messages go to.
pub(super) fn console(bound: Option<Bound>) -> (Option<Console>, Option<Box<dyn Tap>>) {
    let Some(bound) = bound else { return (None, None) };
    let (tap, live) = tap();
    (Some(Console { bound, live }), Some(Box::new(tap)))
}

/// Says where the page is.
pub(super) fn invite(bound: &Bound) {
    tell(&format!("the page: {}", bound.url()));
}

/// Signals, the socket of `flotilla stop`, and the console where there is one. It serves as long as this is there.
pub(super) struct Attended {
    desk: Desk,
    console: Option<ConsoleDesk>,
    /// The ask that is being followed.
    ask: Option<Ask>,
    _server: Option<Server>,
}

impl Attended {
    /// Begins to serve `console`; `steer`: the fleet takes targets.
    pub(super) fn new(desk: Desk, console: Option<Console>, steer: bool) -> Result<Self, Failure> {
        let Some(Console { bound, live }) = console else {
            return Ok(Self { desk, console: None, ask: None, _server: None });
        };
        invite(&bound);
        let (counter, console) = self::desk();
        let source = Source::Run { live, counter, steer };
        let server = bound.start(source, Box::new(stage::stage)).map_err(could)?;
        Ok(Self { desk, console: Some(console), ask: None, _server: Some(server) })
    }
}

impl Operator for Attended {
    fn poll(&mut self, status: &dyn Fn() -> RunStatus) -> Option<Order> {
        self.ask = None;
        if let Some(order) = self.desk.poll(status) {
            if let (Some(console), Order::Stop | Order::Hold) = (&mut self.console, &order) {
                console.interrupt();
            }
            return Some(order);
        }
        let console = self.console.as_mut()?;
        let now = Instant::now();
        while let Some(ask) = console.ask(now) {
            match order(&ask.wanted, status) {
                Ok(order) => {
                    self.ask = Some(ask);
                    return Some(order);
                }
                Err(why) => console.tell(&ask, Err(why), now),
            }
        }
        None
    }

    fn by(&self) -> String {
        self.ask.as_ref().map_or_else(|| self.desk.by(), |ask| ask.by.clone())
    }

    fn answer(&mut self, outcome: &Result<String, String>) {
        if let (Some(console), Some(ask)) = (&mut self.console, &self.ask) {
            console.tell(ask, outcome.clone(), Instant::now());
        }
    }
}

/// The order of an ask.
fn order(wanted: &Wanted, status: &dyn Fn() -> RunStatus) -> Result<Order, String> {
    Ok(match wanted {
        Wanted::Stop => Order::Stop,
        Wanted::Hold => Order::Hold,
        Wanted::Resume => match status().order.as_deref() {
            Some("hold") => Order::Release(None),
            Some(_) => return Err("the fleet is stopped: that ends with a release".to_owned()),
            None => return Err("the fleet is not held".to_owned()),
        },
        Wanted::Release(module) => Order::Release(module.map(ModuleId)),
        Wanted::End => Order::End,
        Wanted::Velocity(velocity_m_s, heading_rad) => {
            Order::Steer(Steering::Velocity(*velocity_m_s, *heading_rad))
        }
        Wanted::LetGo(why) => Order::Steer(Steering::LetGo(why)),
        Wanted::Station(position_m, heading_rad) => {
            Order::Steer(Steering::Station(*position_m, *heading_rad))
        }
        Wanted::Heading(heading_rad) => Order::Steer(Steering::Heading(*heading_rad)),
        Wanted::Waypoints(all, heading_rad) => Order::Steer(Steering::Waypoints(all.clone(), *heading_rad)),
        Wanted::Legs => Order::Steer(Steering::Legs),
    })
}
