//! What a run says of itself while it goes on, for a person.

use link::dispatcher::Dispatcher;
use link::strangers::Silence;
use protocol::ModuleState;
use protocol::ledger::Outgoing;
use protocol::time::FleetInstant;

use super::host::{Controller, Host};
use super::progress::Progress;

/// Pause between two reports of time and link, µs.
const EVERY_US: u64 = 100_000;

/// Notes what has changed since the last step.
#[derive(Debug, Default)]
pub(super) struct Reporter {
    known: usize,
    under_way: bool,
    missed: bool,
    /// Boots seen, by module.
    boots: Vec<u32>,
}

impl Reporter {
    /// After the step at `now`, when the fleet has not been under way for `idle_s`.
    pub(super) fn report<C: Controller, A: Copy>(
        &mut self,
        now: FleetInstant,
        idle_s: f64,
        host: &Host<C, A>,
        progress: &mut dyn Progress,
    ) {
        let (controller, links) = (&host.controller, host.dispatcher());
        let modules = links.modules();
        let known = modules.iter().filter(|link| link.is_known()).count();
        if std::mem::replace(&mut self.known, known) != known {
            progress.note(&format!("{known} of {} {}s have joined", modules.len(), C::MODULE));
        }
        self.boots.resize(modules.len(), 0);
        for (index, (boots, link)) in self.boots.iter_mut().zip(modules).enumerate() {
            if link.boots() > std::mem::replace(boots, link.boots()).max(1) {
                let id = controller.id(index, links);
                progress.note(&format!("{} {id} has lost its power and is back", C::MODULE));
            }
        }
        let under_way = controller.is_under_way();
        if std::mem::replace(&mut self.under_way, under_way) != under_way {
            progress.note(&controller.status(links));
        }
        if idle_s <= controller.patience().missing_after_s {
            self.missed = false;
        } else if !std::mem::replace(&mut self.missed, true) {
            progress.note(&format!("still missing: {}", missing(now, host)));
        }
        if now.0.is_multiple_of(EVERY_US) {
            let t_s = controller.origin().map_or(0.0, |origin| now.as_secs_f64() - origin.as_secs_f64());
            progress.at(t_s.max(0.0), controller.duration_s());
            progress.link(&link_line(links));
        }
    }
}

/// The modules that are waited for, and why if that is known.
fn missing<C: Controller, A: Copy>(now: FleetInstant, host: &Host<C, A>) -> String {
    let (controller, links) = (&host.controller, host.dispatcher());
    let one = |index: usize| {
        let link = &links.modules()[index];
        let why = match (links.silence(now, link.id()), link.state(), link.health()) {
            (_, Some(ModuleState::Ready | ModuleState::Holding), Some(health)) => {
                format!(" (knows the fleet time to {:.1} ms)", f64::from(health.uncertainty.0) * 1e-3)
            }
            (Some(Silence::Known) | None, Some(state), _) => format!(" ({state:?})"),
            (Some(Silence::NeverHeard | Silence::Known) | None, None, _) => String::new(),
            (Some(reason), ..) => format!(" ({reason})"),
        };
        format!("{}{why}", controller.id(index, links))
    };
    controller.missing(links).into_iter().map(one).collect::<Vec<_>>().join(", ")
}

/// The first module that has stopped, with its faults by its own word.
pub(super) fn stopped<C: Controller, A: Copy>(host: &Host<C, A>) -> Option<String> {
    let links = host.dispatcher();
    let index = links.modules().iter().position(|link| link.state() == Some(ModuleState::Stopped))?;
    let names: Vec<_> = links.modules()[index].faults().names().collect();
    let id = host.controller.id(index, links);
    Some(format!("{} {id} has stopped: {}", C::MODULE, names.join(", ")))
}

/// The ledger in a line, as it is now.
fn link_line<A: Copy>(dispatcher: &Dispatcher<A>) -> String {
    let modules = dispatcher.modules();
    let there = modules.iter().filter(|link| link.is_known()).count();
    let sent = modules.iter().fold(Outgoing::default(), |sum, link| sum.plus(&link.outgoing()));
    let incoming = || modules.iter().map(|link| link.incoming()).chain([dispatcher.strays()]);
    let bad: u64 = incoming().map(|i| u64::from(i.duplicate + i.stale + i.corrupt + i.foreign)).sum();
    let forged: u64 = incoming().map(|i| u64::from(i.forged)).sum();
    let unsure = modules.iter().filter_map(|link| link.health()).map(|health| health.uncertainty.0).max();
    let clock = unsure.map_or(String::new(), |us| format!(", clocks ±{:.1} ms", f64::from(us) * 1e-3));
    let faults = modules.iter().filter(|link| link.faults().0 != 0).count();
    let faults = if faults == 0 { String::new() } else { format!(", {faults} with faults") };
    format!(
        "{there}/{} modules, {} sent, {} lost, {} late, {bad} not followed, {forged} forged{clock}{faults}",
        modules.len(),
        sent.sent,
        sent.lost,
        sent.late
    )
}
