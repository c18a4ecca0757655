//! How a run stands, told of both fleets: 5 times a second, and at once when a module or the fleet changes what it does.

use protocol::time::{Duration, FleetInstant};
use runlog::flotilla;

use super::super::closed_loop::Run;
use super::super::fleet::Fleet;
use super::super::host::Controller;
use super::super::orders::{ModuleStatus, Ordered};
use super::stamp;

/// Pause between two looks.
const LOOK_EVERY: Duration = Duration(50_000);
/// Pause between two that say the same.
const TELL_EVERY: Duration = Duration(200_000);

/// See the module's documentation.
#[derive(Default)]
pub struct Standing {
    looked: Option<FleetInstant>,
    told: Option<FleetInstant>,
    status: flotilla::Status,
}

/// What was ordered, as it is told.
pub fn order(Ordered { at, by, what, steers, outcome }: &Ordered) -> flotilla::Order {
    let (followed, text) = match outcome {
        Ok(text) => (true, text),
        Err(text) => (false, text),
    };
    let (by, what, text) = (by.clone(), what.clone(), text.clone());
    flotilla::Order { stamp: stamp(*at), by, what, steers: *steers, followed, text }
}

impl Standing {
    /// How `run` stands at `now`, if that is to be told. `words` and `measured` fill in what only one fleet has: the first what is told at
    /// once, the second what can wait.
    pub fn status<C: Controller, F: Fleet, W, P>(
        &mut self,
        now: FleetInstant,
        run: &Run<'_, C, F, W, P>,
        ids: &[u16],
        words: impl FnOnce(&mut flotilla::Status),
        measured: impl FnOnce(&mut flotilla::Status),
    ) -> Option<&flotilla::Status> {
        if self.looked.is_some_and(|looked| now.since(looked) < LOOK_EVERY) {
            return None;
        }
        self.looked = Some(now);
        let (controller, links) = (&run.host.controller, run.host.dispatcher());
        let modules = links.modules().iter().zip(ids).map(|(link, &id)| {
            let ModuleStatus { id, state, faults, battery_v, silent_s } = ModuleStatus::of(now, id, link);
            let state = state.unwrap_or_default();
            flotilla::ModuleStatus { module: id, state, faults, battery_v, silent_s, ..Default::default() }
        });
        let mut status = flotilla::Status {
            stamp: stamp(now),
            fleet: controller.status(links),
            order: run.order().unwrap_or_default().to_owned(),
            deadman: controller.lacks_target().unwrap_or_default().to_owned(),
            modules: modules.collect(),
            ..flotilla::Status::default()
        };
        words(&mut status);
        let waited = self.told.is_none_or(|told| now.since(told) >= TELL_EVERY);
        if !waited && !differs(&self.status, &status) {
            return None;
        }
        measured(&mut status);
        self.told = Some(now);
        self.status = status;
        Some(&self.status)
    }
}

/// Whether more than measurements is another.
fn differs(one: &flotilla::Status, other: &flotilla::Status) -> bool {
    let is_another = |(one, other): (&flotilla::ModuleStatus, &flotilla::ModuleStatus)| {
        (&one.state, &one.faults) != (&other.state, &other.faults)
    };
    words(one) != words(other)
        || one.modules.len() != other.modules.len()
        || one.modules.iter().zip(&other.modules).any(is_another)
}

fn words(flotilla::Status { fleet, order, deadman, poses, .. }: &flotilla::Status) -> [&str; 4] {
    [fleet, order, deadman, poses]
}
