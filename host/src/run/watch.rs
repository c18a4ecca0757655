//! For how long each module took no part in a run, for how long the fleet held, and why: what [`shortfall`](super::shortfall) judges.

use std::fmt::{self, Display, Formatter};

use link::dispatcher::ModuleLink;
use protocol::time::{Duration, FleetInstant};
use protocol::{Faults, ModuleState, Refusal};

use super::RunError;
use super::closed_loop::{Observer, Run};
use super::fleet::Fleet;
use super::hold::Hold;
use super::host::{Controller, Host};

/// A module that has not been heard for this time does not answer: fifty of its reports. *Assumed.*
const SILENCE: Duration = Duration(1_000_000);

/// Why a module takes no part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It is not heard.
    Silent,
    /// Two modules with its number answer.
    Doubled,
    /// What it reports are numbers that no module can have.
    Implausible,
    /// It serves another host.
    Elsewhere,
    /// It has stopped, with these faults.
    Stopped(Faults),
    /// It rests, with these faults.
    Faulty(Faults),
    /// It does not know the fleet time.
    Unsynchronised,
    /// It refused the last cycle that it answered.
    Refuses(Refusal),
}

impl Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => write!(f, "it does not answer"),
            Self::Doubled => write!(f, "two modules have its number, and neither is used"),
            Self::Implausible => write!(f, "it reports numbers that no module can have"),
            Self::Elsewhere => write!(f, "it serves another host"),
            Self::Stopped(faults) if faults.0 == 0 => write!(f, "it has stopped"),
            Self::Stopped(faults) => write!(f, "it has stopped: {}", named(*faults)),
            Self::Faulty(faults) => write!(f, "{}", named(*faults)),
            Self::Unsynchronised => write!(f, "it does not know the fleet time"),
            Self::Refuses(refusal) => write!(f, "it refuses its cycles: {}", worded(*refusal)),
        }
    }
}

impl Reason {
    /// As two numbers, for a log.
    #[must_use]
    pub const fn numbers(self) -> (u8, u8) {
        match self {
            Self::Silent => (0, 0),
            Self::Doubled => (1, 0),
            Self::Elsewhere => (2, 0),
            Self::Stopped(faults) => (3, faults.0),
            Self::Faulty(faults) => (4, faults.0),
            Self::Unsynchronised => (5, 0),
            Self::Refuses(refusal) => (6, refusal as u8),
            Self::Implausible => (7, 0),
        }
    }

    /// The same, back.
    #[must_use]
    pub fn from_numbers(reason: u8, detail: u8) -> Option<Self> {
        Some(match reason {
            0 => Self::Silent,
            1 => Self::Doubled,
            2 => Self::Elsewhere,
            3 => Self::Stopped(Faults(detail)),
            4 => Self::Faulty(Faults(detail)),
            5 => Self::Unsynchronised,
            7 => Self::Implausible,
            6 => Self::Refuses(REFUSALS.into_iter().find(|refusal| *refusal as u8 == detail)?),
            _ => return None,
        })
    }
}

/// All of them.
const REFUSALS: [Refusal; 12] = [
    Refusal::Late,
    Refusal::TooFarAhead,
    Refusal::AlreadyRun,
    Refusal::Conflict,
    Refusal::PoseMismatch,
    Refusal::BeyondLimits,
    Refusal::NotSynchronised,
    Refusal::WrongKind,
    Refusal::Stopped,
    Refusal::Unsure,
    Refusal::LowBattery,
    Refusal::NotPrepared,
];

fn named(faults: Faults) -> String {
    faults.names().collect::<Vec<_>>().join(", ")
}

pub(super) const fn worded(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Late => "they come after their start",
        Refusal::TooFarAhead => "they lie too far ahead",
        Refusal::AlreadyRun => "their numbers have been run",
        Refusal::Conflict => "they overlap others",
        Refusal::PoseMismatch => "its tail is not where they begin",
        Refusal::BeyondLimits => "they are beyond its limits",
        Refusal::NotSynchronised => "it does not know the fleet time",
        Refusal::WrongKind => "they are for another kind of robot",
        Refusal::Stopped => "it has stopped",
        Refusal::Unsure => "it does not know the fleet time well enough",
        Refusal::LowBattery => "low battery",
        Refusal::NotPrepared => "they were not prepared",
    }
}

/// Why the module takes no part at `now`, if it does not; `refusal` is why it refused the last cycle that it answered.
fn reason<A: Copy>(now: FleetInstant, link: &ModuleLink<A>, refusal: Option<Refusal>) -> Option<Reason> {
    let faults = link.faults();
    match link.state() {
        _ if link.is_doubled() => Some(Reason::Doubled),
        _ if link.is_elsewhere() => Some(Reason::Elsewhere),
        _ if now.since(link.heard()) > SILENCE => Some(Reason::Silent),
        _ if link.is_implausible(now) => Some(Reason::Implausible),
        None => Some(Reason::Silent),
        Some(ModuleState::Executing) => None,
        Some(ModuleState::Stopped) => Some(Reason::Stopped(faults)),
        Some(ModuleState::Unsynchronised) => Some(Reason::Unsynchronised),
        Some(_) if faults.0 != 0 => Some(Reason::Faulty(faults)),
        Some(_) => refusal.map(Reason::Refuses),
    }
}

/// A module took no part.
#[derive(Clone, Debug, PartialEq)]
pub struct Absence {
    /// Its index.
    pub module: usize,
    /// Why.
    pub reason: Reason,
    /// For how long, s.
    pub time_s: f64,
}

/// What was seen in one leg.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LegWatch {
    /// How long it was swum, or held in, s.
    pub time_s: f64,
    /// For how long of that the fleet held, s.
    pub held_s: f64,
    /// The same by reason, in the order in which they were met.
    pub holds: Vec<(Hold, f64)>,
    /// By module and reason, in the order in which they were met.
    pub absences: Vec<Absence>,
}

/// See the module's documentation. Time counts from the start of the first cycle.
#[derive(Debug)]
pub struct Watch {
    /// When each leg ends, s.
    ends_s: Vec<f64>,
    legs: Vec<LegWatch>,
    last: Option<FleetInstant>,
}

impl Watch {
    /// For legs that end at these times, s.
    #[must_use]
    pub fn new(ends_s: Vec<f64>) -> Self {
        let legs = vec![LegWatch::default(); ends_s.len()];
        Self { ends_s, legs, last: None }
    }

    /// What was seen in each leg.
    #[must_use]
    pub fn legs(&self) -> &[LegWatch] {
        &self.legs
    }

    /// Calls `add` with each leg that has a part of the time from `from_s` to `to_s`, and with the length of that part, s.
    fn share_out(&mut self, from_s: f64, to_s: f64, mut add: impl FnMut(&mut LegWatch, f64)) {
        let mut start_s = from_s;
        for (leg, &end_s) in self.legs.iter_mut().zip(&self.ends_s) {
            let part_s = end_s.min(to_s) - start_s;
            if part_s > 0.0 {
                add(leg, part_s);
                start_s = end_s;
            }
        }
    }
}

impl<C: Controller, F: Fleet, W, P> Observer<Run<'_, C, F, W, P>> for Watch {
    fn observe(&mut self, now: FleetInstant, run: &Run<'_, C, F, W, P>) -> Result<(), RunError> {
        // Modules hold in a gap of the host, whatever is decided right after it.
        let gap = run.gaps.last().is_some_and(|gap| self.last.is_some_and(|last| gap.start >= last));
        self.note(now, &run.host, gap, run.is_blind());
        Ok(())
    }
}

impl Watch {
    /// Takes in what `host` knows at `now`; `gap`: it did not run since the last time; `blind`: what modules do is not known since then.
    pub fn note<C: Controller, A: Copy>(
        &mut self,
        now: FleetInstant,
        host: &Host<C, A>,
        gap: bool,
        blind: bool,
    ) {
        let (controller, links) = (&host.controller, host.dispatcher());
        let Some(origin) = controller.origin().filter(|&origin| origin < now) else { return };
        let since = |at: FleetInstant| at.0.saturating_sub(origin.0) as f64 * 1e-6;
        let (from_s, to_s) = (self.last.map_or(0.0, since), since(now));
        self.last = Some(now);
        let hold = match gap || blind {
            true => Some(Hold::HostAway),
            false => (!controller.gets_on()).then(|| controller.hold()),
        };
        self.share_out(from_s, to_s, |leg, part_s| {
            leg.time_s += part_s;
            let Some(hold) = hold else { return };
            leg.held_s += part_s;
            match leg.holds.iter_mut().find(|(known, _)| *known == hold) {
                Some((_, time_s)) => *time_s += part_s,
                None => leg.holds.push((hold, part_s)),
            }
        });
        // What modules do in a gap of the host is not known.
        if blind {
            return;
        }
        for (module, (link, &refusal)) in links.modules().iter().zip(host.refusals()).enumerate() {
            let Some(reason) = reason(now, link, refusal) else { continue };
            self.share_out(from_s, to_s, |leg, part_s| {
                let known =
                    leg.absences.iter_mut().find(|known| (known.module, known.reason) == (module, reason));
                match known {
                    Some(known) => known.time_s += part_s,
                    None => leg.absences.push(Absence { module, reason, time_s: part_s }),
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_comes_back_from_its_numbers() {
        let plain =
            [Reason::Silent, Reason::Doubled, Reason::Elsewhere, Reason::Unsynchronised, Reason::Implausible];
        let faults = [Reason::Stopped(Faults(5)), Reason::Faulty(Faults(128))];
        for reason in plain.into_iter().chain(faults).chain(REFUSALS.map(Reason::Refuses)) {
            let (number, detail) = reason.numbers();
            assert_eq!(Reason::from_numbers(number, detail), Some(reason));
        }
        assert_eq!((Reason::from_numbers(8, 0), Reason::from_numbers(6, 12)), (None, None));
    }
}
