//! Recovery of a fleet when the network heals: nothing is lost from then on, no module boots, none doubts its clock, and
//! what comes comes in the order in which it was sent. A stopped module is released by the host.
//!
//! This is one schedule of events, and a fair one: in every slot announcements, calls, orders, answers and reports come until
//! nothing is new; the host plans when it may; time goes on. The goal, both running the same cycle, has to
//! be reached within the slots that [`Config::recovery`] names with prepared cycles, which need most, both if what was under way before the
//! network healed all comes and if it is all lost.

use protocol::{Delivery, ModuleState};

use crate::fleet::{Action, Budget, Config, Fleet};
use crate::said::{MODULES, SessionId, Up};

/// What is enough: the module notices that its host is dead, is taken in by the next one, and reports; a cycle is planned, and
/// begins.
pub const SLOTS: u8 = 3;
/// Rounds of messages within a slot: handshake and release, plan, cycle, commit.
const ROUNDS: usize = 4;

/// Whether the fleet reaches the goal from this state on, whatever became of what was under way.
#[must_use]
pub fn recovers(config: &Config, fleet: &Fleet) -> bool {
    [true, false].iter().all(|&comes| heals(config, fleet, comes))
}

fn heals(config: &Config, fleet: &Fleet, comes: bool) -> bool {
    let mut fleet = fleet.clone();
    fleet.left = Budget { cycles: SLOTS, orders: SLOTS, ..Budget::default() };
    if !comes {
        for index in 0..MODULES {
            fleet.modules[index].down.clear();
            fleet.modules[index].up = Up::default();
            fleet.host.links[index].up = Up::default();
            fleet.calls[index].clear();
        }
    }
    (0..config.recovery).any(|_| {
        slot(config, &mut fleet);
        fleet.both_run()
    })
}

/// Everything that happens in one slot, and the beginning of the next.
fn slot(config: &Config, fleet: &mut Fleet) {
    fleet.repeat(config);
    for _ in 0..ROUNDS {
        for index in 0..MODULES {
            messages(config, fleet, index);
        }
        let stopped = fleet.modules.iter().any(|module| module.failsafe.state() == ModuleState::Stopped);
        if stopped && fleet.left.orders > 0 {
            fleet.step(config, Action::Order { stop: false });
        } else if fleet.left.cycles > 0 && fleet.host.may_decide(fleet.now) {
            fleet.step(config, Action::Decide(Delivery::Prepare));
        }
    }
    if fleet.host.is_undecided() {
        fleet.step(config, Action::LeadPasses);
    }
    fleet.step(config, Action::SlotBegins { doubts: None });
}

/// What is under way to and from one module comes, each once.
fn messages(config: &Config, fleet: &mut Fleet, index: usize) {
    let now = fleet.now;
    fleet.step(config, Action::Announced(index));
    let follows = |call: &&SessionId| fleet.modules[index].may_be_called(now, **call);
    let call = fleet.calls[index].iter().find(follows).copied();
    if let Some(call) = call {
        fleet.step(config, Action::Called(index, call));
    }
    let session = fleet.modules[index].session;
    if session.is_some_and(|session| fleet.host.links[index].calling.contains(&session)) {
        fleet.step(config, Action::Joins(index));
    }
    if session.is_none() || fleet.host.links[index].live != session {
        return;
    }
    if fleet.modules[index].wants_time() {
        fleet.step(config, Action::TimeKnown(index));
    }
    for order in fleet.modules[index].down.clone() {
        fleet.step(config, Action::Hears { module: index, order, doubt: false });
    }
    for ack in fleet.host.links[index].up.acks.clone() {
        fleet.step(config, Action::Answered(index, ack));
    }
    fleet.step(config, Action::Reported(index, None));
}
