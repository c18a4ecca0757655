//! Cycles that go to all modules or to none: when they are sent, committed and given up.

use super::super::delivery::{CycleDelivery, DeliveryState, PhaseOutcome};
use super::super::lead::Lead;
use super::{Dispatcher, ModuleLink, QueuedDatagram};
use protocol::time::FleetInstant;

impl<A: Copy> Dispatcher<A> {
    /// The deliveries of cycle `number`.
    fn deliveries(&self, number: u32) -> impl Iterator<Item = (usize, &CycleDelivery)> {
        let all = self
            .modules
            .iter()
            .enumerate()
            .filter_map(|(index, link)| Some((index, link.delivery.as_ref()?)));
        all.filter(move |(_, delivery)| delivery.number == number)
    }

    /// Commits a prepared cycle that every module holds, or gives it up.
    pub(super) fn decide(&mut self, now: FleetInstant) {
        let prepared = |link: &ModuleLink<A>| {
            link.delivery.as_ref().filter(|delivery| delivery.needs_all() && delivery.is_open()).cloned()
        };
        let Some(delivery) = self.modules.iter().find_map(prepared) else { return };
        let (number, in_time) = (delivery.number, delivery.is_in_time(now));
        let states = self.deliveries(number).map(|(_, delivery)| delivery.state);
        let outcome = DeliveryState::decide(states, in_time);
        let all: Vec<usize> = self.deliveries(number).map(|(index, _)| index).collect();
        match outcome {
            PhaseOutcome::Wait => {}
            PhaseOutcome::Commit => {
                for index in all {
                    if let Some(delivery) = &mut self.modules[index].delivery {
                        self.outbox.push_back(QueuedDatagram::Message(index, delivery.commit(now)));
                    }
                }
            }
            PhaseOutcome::Drop => {
                all.into_iter().for_each(|index| self.abandon(index, DeliveryState::Dropped));
            }
        }
    }

    /// Whether cycle `number` was given up before its start: no module runs it.
    pub fn is_dropped(&self, number: u32) -> bool {
        let states = || {
            self.deliveries(number)
                .filter(|(_, delivery)| delivery.needs_all())
                .map(|(_, delivery)| delivery.state)
        };
        states().any(|state| matches!(state, DeliveryState::Dropped | DeliveryState::Refused))
            && !states().any(|state| matches!(state, DeliveryState::Committing | DeliveryState::Taken))
    }

    /// How long before its start a cycle for all modules or none is to be dispatched, with the losses and round trips that are measured.
    pub fn lead(&self) -> Lead {
        let reachable = self.modules.iter().filter(|link| link.is_reachable());
        Lead::new(reachable.map(ModuleLink::losses), &self.round_trip)
    }
}
