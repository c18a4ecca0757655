//! Properties that the checker verifies in every state.
//!
//! | running | the other runs the same | the other rests where the plan takes it to be | the other rests elsewhere | the other runs another cycle |
//! |---|---|---|---|---|
//! | a direct cycle | safe | safe | unsafe | unsafe |
//! | a prepared cycle | safe | unsafe | unsafe | unsafe |

use link::delivery::Knowledge;
use protocol::{Delivery, ModuleState};
use stateright::Property;

use crate::fleet::{Config, Fleet};
use crate::heal::recovers;
use crate::said::{Held, MODULES};

/// A: no two modules run different cycles at the same time.
pub const ONE_CYCLE: &str = "A: all that run run the same cycle";
/// B: nothing from a session that is over, or from another life of the host.
pub const NO_OLD_SESSION: &str = "B: nothing from a session that is over is run";
/// B: nothing that the host gave up, of its own accord or because the module booted.
pub const NOTHING_DROPPED: &str = "B: nothing that was given up is run";
/// B: nothing that was sent before a hold, a stop or a release which the module has followed.
pub const NOTHING_VOID: &str = "B: nothing that a hold or a stop made void is run";
/// B: nothing twice, nothing but from its start on.
pub const ONCE_ON_TIME: &str = "B: a cycle is run once, from its start on";
/// C: a prepared cycle is run only if the other module holds it, or held it and lost it by a boot, a stop or a hold.
pub const NEIGHBOUR_HOLDS: &str = "C: a prepared cycle is run only if the neighbour holds it";
/// D: certainly means that it runs it or ran it, unless it was stopped or booted since it said so.
pub const CERTAINLY: &str = "D: certainly is certain";
/// D: certainly not means that it does not run it, and never will.
pub const CERTAINLY_NOT: &str = "D: certainly not is certain";
/// D: a plan sets out from where the tails will be, unless one was stopped or booted since it said so.
pub const POSES: &str = "D: plans set out from true poses";
/// G: what is stopped runs nothing, from the stop on.
pub const STOPPED_RESTS: &str = "G: a stopped module runs nothing";
/// G: nothing ends a stop but a release that was sent after it: of its host's, by number; of any other, once the host had seen a report of it.
pub const STOP_LASTS: &str = "G: a stop lasts until a release that was sent after it";
/// E: no state is stuck; see [`heal`](crate::heal).
pub const RECOVERS: &str = "E: once the network heals, both run a new cycle";
/// F: what cannot hold of prepared cycles.
pub const BOTH_OR_NONE: &str = "F: a prepared cycle is run by both or by none";
/// F: no two modules are in an unsafe combination; holds of direct cycles.
pub const COMBINATIONS: &str = "F: every combination is safe, holding included";

/// The properties that hold of the protocol.
pub const HOLD: [&str; 11] = [
    ONE_CYCLE,
    NO_OLD_SESSION,
    NOTHING_DROPPED,
    NOTHING_VOID,
    ONCE_ON_TIME,
    NEIGHBOUR_HOLDS,
    CERTAINLY,
    CERTAINLY_NOT,
    POSES,
    STOPPED_RESTS,
    STOP_LASTS,
];

/// Breaches of the properties that are seen in a step, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Breaches(u8);

impl Breaches {
    const OLD_SESSION: Self = Self(1);
    const DROPPED: Self = Self(1 << 1);
    const VOID: Self = Self(1 << 2);
    const TIMING: Self = Self(1 << 3);
    const ALONE: Self = Self(1 << 4);
    const CERTAINLY_NOT: Self = Self(1 << 5);
    const POSES: Self = Self(1 << 6);

    fn add(&mut self, other: Self, breached: bool) {
        self.0 |= if breached { other.0 } else { 0 };
    }

    const fn has(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl Fleet {
    /// Notes what the last step, from `before`, means for the properties.
    pub(crate) fn note(&mut self, config: &Config, before: &Self) {
        let mut breaches = self.breaches;
        let began = self.now > before.now;
        for index in 0..MODULES {
            let (module, was) = (&self.modules[index], &before.modules[index]);
            if let Some(held) = module.slots.running(self.now) {
                let bit = held.bit();
                if began {
                    let session = module.session;
                    let old = held.boot != module.boots
                        || session.is_none_or(|session| session.life != held.life());
                    breaches.add(Breaches::OLD_SESSION, old);
                    breaches.add(Breaches::DROPPED, module.past.dropped & bit != 0);
                    breaches.add(Breaches::VOID, module.past.void & bit != 0);
                    breaches.add(Breaches::TIMING, module.past.begun & bit != 0);
                    breaches.add(Breaches::CERTAINLY_NOT, module.past.never & bit != 0);
                    let other = 1 - index;
                    let held_there = before.modules[other].slots.has(held.id)
                        || before.modules[other].past.lost & bit != 0;
                    let prepare = held.delivery == Delivery::Prepare;
                    breaches.add(Breaches::ALONE, prepare && !held_there);
                    self.modules[index].past.begun |= bit;
                } else {
                    breaches.add(Breaches::TIMING, was.slots.running(self.now) != Some(held));
                }
            }
        }
        if self.host.cycle != before.host.cycle
            && let Some(cycle) = self.host.cycle
        {
            for (index, module) in self.modules.iter().enumerate() {
                let known =
                    self.host.links[index].report.is_some_and(|report| report.stops == module.past.stops);
                breaches.add(Breaches::POSES, known && cycle.from[index] != module.slots.end());
            }
        }
        for index in 0..MODULES {
            let Some(cycle) = self.host.cycle else { continue };
            let bit = 1 << cycle.id;
            let not = self.knowledge(config, index) == Knowledge::CertainlyNot;
            let dropped = self.host.has_dropped(index);
            let past = &mut self.modules[index].past;
            past.never |= if not { bit } else { 0 };
            past.dropped |= if dropped { bit } else { 0 };
            breaches.add(Breaches::CERTAINLY_NOT, not && past.begun & !past.lost & bit != 0);
        }
        self.breaches = breaches;
    }
}

/// All of the properties; those of F are for tests of their own.
#[must_use]
pub fn properties(recovery: bool) -> Vec<Property<Config>> {
    fn none(which: Breaches) -> impl Fn(&Fleet) -> bool {
        move |fleet| !fleet.breaches.has(which)
    }
    let mut all = vec![
        Property::always(ONE_CYCLE, |_, fleet: &Fleet| fleet.runs_one_cycle()),
        Property::always(NO_OLD_SESSION, |_, fleet| none(Breaches::OLD_SESSION)(fleet)),
        Property::always(NOTHING_DROPPED, |_, fleet| none(Breaches::DROPPED)(fleet)),
        Property::always(NOTHING_VOID, |_, fleet| none(Breaches::VOID)(fleet)),
        Property::always(ONCE_ON_TIME, |_, fleet| none(Breaches::TIMING)(fleet)),
        Property::always(NEIGHBOUR_HOLDS, |_, fleet| none(Breaches::ALONE)(fleet)),
        Property::always(CERTAINLY, |config, fleet: &Fleet| fleet.certainly_is_certain(config)),
        Property::always(CERTAINLY_NOT, |_, fleet| none(Breaches::CERTAINLY_NOT)(fleet)),
        Property::always(POSES, |_, fleet| none(Breaches::POSES)(fleet)),
        Property::always(STOPPED_RESTS, |_, fleet: &Fleet| fleet.stopped_rests()),
        Property::always(STOP_LASTS, |_, fleet: &Fleet| {
            !fleet.modules.iter().any(|module| module.past.slipped)
        }),
        Property::always(BOTH_OR_NONE, |_, fleet: &Fleet| fleet.runs_on_both_or_none()),
        Property::always(COMBINATIONS, |_, fleet: &Fleet| fleet.is_safe()),
    ];
    if recovery {
        all.push(Property::always(RECOVERS, |config, fleet: &Fleet| recovers(config, fleet)));
    }
    all
}

impl Fleet {
    /// For each module what it runs, and the other's index.
    fn running(&self) -> impl Iterator<Item = (&Held, usize)> {
        let all = self.modules.iter().enumerate();
        all.filter_map(|(index, module)| Some((module.slots.running(self.now)?, MODULES - 1 - index)))
    }

    fn runs(&self, index: usize) -> Option<u8> {
        self.modules[index].slots.running(self.now).map(|held| held.id)
    }

    pub(crate) fn both_run(&self) -> bool {
        self.runs(0).is_some() && self.runs(0) == self.runs(1)
    }

    fn runs_one_cycle(&self) -> bool {
        self.running().all(|(held, other)| self.runs(other).is_none_or(|id| id == held.id))
    }

    fn runs_on_both_or_none(&self) -> bool {
        let mut prepared = self.running().filter(|(held, _)| held.delivery == Delivery::Prepare);
        prepared.all(|(held, other)| self.runs(other) == Some(held.id))
    }

    fn stopped_rests(&self) -> bool {
        let stopped = self.modules.iter().filter(|module| module.failsafe.state() == ModuleState::Stopped);
        stopped.into_iter().all(|module| module.slots.running(self.now).is_none())
    }

    /// The table.
    fn is_safe(&self) -> bool {
        self.running().all(|(held, other)| match self.runs(other) {
            Some(id) => id == held.id,
            None => held.delivery == Delivery::Direct && self.modules[other].slots.end() == held.beside,
        })
    }

    fn certainly_is_certain(&self, config: &Config) -> bool {
        (0..MODULES).all(|index| {
            let (link, module) = (&self.host.links[index], &self.modules[index]);
            let stopped_since = link.report.is_some_and(|report| report.stops != module.past.stops);
            let has = self.host.cycle.is_some_and(|cycle| module.slots.has(cycle.id));
            self.knowledge(config, index) != Knowledge::Certainly || has || stopped_since
        })
    }
}
