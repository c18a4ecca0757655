//! What a run of the host decides, whom it names, and how it is judged.
//!
//! | fault | within | then |
//! |---|---|---|
//! | two modules have one number and power, the host runs | [`NOTICED_S`] | both addresses are named, no decision counts on either |
//! | a module tells lies alone, the host runs | [`NOTICED_S`] | it is named for that, no decision counts on it |
//! | either was named while the fleet swam | | the run is judged as one that was not what was asked |
//! | no module is doubled, or the second has been off, and the first has not booted, for [`OVER_S`] | | none is named as doubled |

use std::collections::HashMap;

use host::run::host::Controller as _;
use host::run::shortfall;
use host::run::watch::{Reason, Watch};
use link::strangers::Silence;
use protocol::ModuleId;
use protocol::time::{Duration, FleetInstant};

use super::World;
use super::wire::node;

/// In the worst weather. What is delayed comes 1.6 s later, a liar is named after 1 s, a module may have to be called again.
const NOTICED_S: f64 = 6.0;
/// 3 s without a sign of life, by the time at which it was sent as the host has it; what is played of it later is none.
const OVER_S: f64 = 3.1;

/// One run of the host, from start to crash.
pub(super) struct HostRun {
    pub(super) boot: [u8; 12],
    /// Its time zero, true time.
    pub(super) epoch_us: u64,
    /// Start and end of each decision's cycles, µs of its own time, by number; whether any module may lose its power in it.
    pub(super) cycles: HashMap<u32, (u64, u64, bool)>,
    pub(super) seen: usize,
    verdict: Watch,
    /// Who was named after the first cycle began: module (from 0), and why.
    named: Vec<(usize, Reason)>,
}

impl HostRun {
    pub(super) fn new(boot: [u8; 12], epoch_us: u64) -> Self {
        let (verdict, named) = (Watch::new(vec![1e4]), Vec::new());
        Self { boot, epoch_us, cycles: HashMap::new(), seen: 0, verdict, named }
    }
}

/// Since when something has not been noticed, µs.
#[derive(Debug, Default)]
pub(super) struct Named {
    doubled: Option<u64>,
    liar: Option<u64>,
}

/// When two cannot be named any more of whom the second lost its power at `until_us`, µs. A module that boots meanwhile is two for as long.
fn over_us(until_us: u64, reboots: &[(u64, usize, Duration)], module: usize) -> u64 {
    let mut own: Vec<u64> =
        reboots.iter().filter(|(_, of, _)| *of == module).map(|(at_us, ..)| *at_us).collect();
    own.sort_unstable();
    let after = |us: u64| us + (OVER_S * 1e6) as u64;
    own.into_iter()
        .fold(after(until_us), |end_us, at_us| if at_us < end_us { end_us.max(after(at_us)) } else { end_us })
}

/// Whether `waits` has lasted too long; it is told once.
fn too_long(since: &mut Option<u64>, now_us: u64, waits: bool) -> bool {
    if !waits {
        *since = None;
        return false;
    }
    let late = now_us.saturating_sub(*since.get_or_insert(now_us)) > (NOTICED_S * 1e6) as u64;
    if late {
        *since = Some(u64::MAX / 2);
    }
    late
}

impl World<'_> {
    pub(super) fn note_decisions(&mut self, host_now: FleetInstant) {
        let (Some(host), Some(host_run)) = (&self.host, self.host_runs.last_mut()) else { return };
        let pilot = &host.controller;
        for decision in &pilot.decisions()[host_run.seen..] {
            let links = host.dispatcher().modules().iter().zip(&decision.missing).enumerate();
            for (module, (link, &missing)) in links {
                if !missing && (link.is_doubled() || link.is_implausible(host_now)) {
                    let what = format!("decision {} counts on module {}", decision.number, module + 1);
                    self.outcome.violations.push(what);
                }
            }
            self.outcome.decisions += 1;
            let (outcome, tolerant) = (decision.plan.outcome.name(), decision.plan.loss_tolerant);
            self.last = format!(
                "{} {outcome}, loss tolerant: {tolerant}, clearance {}, {:?}",
                decision.number, decision.plan.clearance_m, decision.plan.cycle
            );
            let span = (decision.start.0, decision.end().0, decision.plan.power_tolerant);
            // Of a transition in two steps each is a cycle of its own.
            host_run.cycles.insert(decision.number, span);
            host_run.cycles.insert(decision.number + u32::from(decision.via.is_some()), span);
        }
        host_run.seen = pilot.decisions().len();
    }

    /// Whether every module runs the same cycle of the running host.
    pub(super) fn all_swim(&self) -> bool {
        let host_run = self.host_runs.len().wrapping_sub(1);
        let first = self.watch.running[0];
        let decisions = self.host.as_ref().map_or(&[][..], |host| host.controller.decisions());
        // A module with a cycle of no amplitude does not swim.
        let swims = decisions.iter().rev().take(2).any(|decision| {
            let moves = decision.plan.cycle.iter().any(|swing| swing.amplitude_rad != 0.0);
            moves && first.is_some_and(|(_, number)| number == decision.last_number())
        });
        swims
            && first.is_some_and(|(of, _)| of == host_run)
            && self.watch.running.iter().all(|running| *running == first)
    }

    /// Who is named at this tick. `runs`: the host is not paused; `gap`: it was until now.
    pub(super) fn watch_names(&mut self, now_us: u64, host_now: FleetInstant, runs: bool, gap: bool) {
        let kinds = &self.storm.kinds;
        let Some(host) = self.host.as_ref().filter(|_| runs) else {
            self.named = Named::default();
            return;
        };
        let (Some(host_run), links) = (self.host_runs.last_mut(), host.dispatcher()) else { return };
        host_run.verdict.note(host_now, host, gap, false);
        let begun = host.controller.origin().is_some_and(|origin| origin < host_now);
        let mut wrong = Vec::new();
        for (module, link) in links.modules().iter().enumerate() {
            let silence = links.silence(host_now, ModuleId(module as u16 + 1));
            let mut note = |reason| {
                if begun && !host_run.named.contains(&(module, reason)) {
                    host_run.named.push((module, reason));
                }
            };
            // Of three boots two are told apart, and the host cannot know which.
            let rebooted = self.storm.reboots.iter().any(|(_, of, _)| *of == module);
            if link.is_doubled() {
                note(Reason::Doubled);
                let mut places = link.doubled().map_or(Vec::new(), |both| both.map(|at| node(at).0).to_vec());
                places.sort_unstable();
                let is = kinds.double.is_some_and(|(of, from_us, until_us)| {
                    of == module
                        && now_us >= from_us
                        && now_us < over_us(until_us, &self.storm.reboots, module)
                });
                let both = [module as u16 + 1, self.storm.modules as u16 + 1];
                if !is || !(rebooted || places == both) || silence != Some(Silence::Doubled) {
                    wrong.push(format!(
                        "module {} is named as doubled, at {places:?}: {silence:?}",
                        module + 1
                    ));
                }
            } else if link.is_implausible(host_now) {
                note(Reason::Implausible);
                if kinds.liar.is_none_or(|(liar, ..)| liar != module) {
                    wrong.push(format!("module {} is named as a liar", module + 1));
                }
            }
        }
        let has_power = |module: usize| self.fleet.modules[module].has_power();
        let unnoticed = kinds.double.is_some_and(|(module, ..)| {
            // Forged calls keep a module out that looks for a host.
            let joins = kinds.calls_per_s <= 0.0;
            joins
                && has_power(module)
                && has_power(self.storm.modules)
                && !links.modules()[module].is_doubled()
        });
        if too_long(&mut self.named.doubled, now_us, unnoticed) {
            wrong.push("a doubled module is not noticed".to_owned());
        }
        let unnoticed = kinds.liar.is_some_and(|(module, from_us, until_us)| {
            let link = &links.modules()[module];
            let told = !link.is_implausible(host_now) && !link.is_doubled();
            let speaks = host_now.since(link.heard()).0 < 1_000_000;
            (from_us..until_us).contains(&now_us) && speaks && told
        });
        if too_long(&mut self.named.liar, now_us, unnoticed) {
            wrong.push("a liar is not noticed".to_owned());
        }
        wrong.into_iter().for_each(|what| self.violation(now_us, &what));
    }

    /// What judges a run, of the last one.
    pub(super) fn judge(&mut self) {
        let Some(host_run) = self.host_runs.last() else { return };
        let found =
            shortfall::of_watch(None, &host_run.verdict.legs()[0], 4.0, "module", |module| module as u16 + 1);
        let mut missing = Vec::new();
        for (module, reason) in &host_run.named {
            let by_name = |shortfall: &&shortfall::Shortfall| matches!(shortfall, shortfall::Shortfall::Absent { module: of, .. } if usize::from(*of) == module + 1);
            if found.iter().find(by_name).is_none() {
                missing.push(format!("module {}, {reason}: the run is judged to be {found:?}", module + 1));
            }
            match reason {
                Reason::Doubled => self.outcome.kinds.doubled += 1,
                _ => self.outcome.kinds.liars += 1,
            }
        }
        missing.into_iter().for_each(|what| self.violation(0, &what));
    }
}
