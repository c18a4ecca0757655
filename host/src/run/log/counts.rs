//! What is counted in a run, as messages of its log, and back.

use link::dispatcher::Dispatcher;
use link::faults::{FaultCount, ForgeryCount};
use link::ledger::{Ledger, Quantiles};
use protocol::Faults;
use protocol::ledger::{Incoming, Outgoing};
use runlog::flotilla;
use runlog::ros::Time;
use sim::module::TICK;

use super::super::hold::Hold;
use super::super::host::Controller;
use super::super::pose_source::PoseAccount;
use super::super::summary::LinkFigures;
use super::super::watch::{Absence, LegWatch, Reason};

/// Numbers that persons know the modules by, in order.
pub fn ids<A: Copy>(controller: &impl Controller, links: &Dispatcher<A>) -> Vec<u16> {
    (0..links.modules().len()).map(|index| controller.id(index, links)).collect()
}

/// Of all links, as they are now.
pub fn links<A: Copy>(stamp: Time, ids: &[u16], links: &Dispatcher<A>) -> flotilla::Links {
    let all = links.modules().iter().zip(ids).map(|(link, &module)| {
        let (ledger, outgoing, health) = (link.ledger(), link.outgoing(), link.health());
        let Quantiles { count, p50_ms, p90_ms, p99_ms, max_ms } = link.answers().quantiles();
        flotilla::Link {
            module,
            cycles: ledger.cycles,
            resent: ledger.resent,
            acknowledged: ledger.acknowledged,
            late: ledger.late,
            refused: ledger.refused,
            unanswered: ledger.unanswered,
            datagrams_sent: outgoing.sent,
            datagrams_acknowledged: outgoing.acknowledged,
            datagrams_late: outgoing.late,
            datagrams_lost: outgoing.lost,
            from_module: incoming(link.incoming()),
            module_received: health.map(|health| incoming(&health.incoming)),
            answer: flotilla::Answers { count, p50_ms, p90_ms, p99_ms, max_ms },
            clock_uncertainty_us: health.map(|health| health.uncertainty.0),
            clock_drift_ppb: health.map(|health| health.drift_ppb),
            boots: link.boots(),
            sessions: link.sessions(),
            faults: link.faults().0,
        }
    });
    flotilla::Links { stamp, links: all.collect() }
}

/// Figures of all links.
#[must_use]
pub fn link_figures(links: &flotilla::Links) -> Vec<LinkFigures> {
    let one = |link: &flotilla::Link| {
        let flotilla::Answers { count, p50_ms, p90_ms, p99_ms, max_ms } = link.answer;
        LinkFigures {
            module: link.module,
            ledger: Ledger {
                cycles: link.cycles,
                resent: link.resent,
                acknowledged: link.acknowledged,
                late: link.late,
                refused: link.refused,
                unanswered: link.unanswered,
            },
            to_module: Outgoing {
                sent: link.datagrams_sent,
                acknowledged: link.datagrams_acknowledged,
                late: link.datagrams_late,
                lost: link.datagrams_lost,
            },
            from_module: received(&link.from_module),
            module_received: link.module_received.as_ref().map(received),
            answer: Quantiles { count, p50_ms, p90_ms, p99_ms, max_ms },
            clock_uncertainty_us: link.clock_uncertainty_us,
            clock_drift_ppb: link.clock_drift_ppb,
            boots: link.boots,
            sessions: link.sessions,
            faults: Faults(link.faults).names().collect(),
        }
    };
    links.links.iter().map(one).collect()
}

/// Counts of what was received.
#[must_use]
pub fn incoming(counts: &Incoming) -> flotilla::Incoming {
    let &Incoming { received, accepted, duplicate, stale, corrupt, forged, foreign } = counts;
    flotilla::Incoming { received, accepted, duplicate, stale, corrupt, forged, foreign }
}

/// The same, back.
#[must_use]
pub fn received(counts: &flotilla::Incoming) -> Incoming {
    let &flotilla::Incoming { received, accepted, duplicate, stale, corrupt, forged, foreign } = counts;
    Incoming { received, accepted, duplicate, stale, corrupt, forged, foreign }
}

/// What the medium did.
#[must_use]
pub fn medium(count: &FaultCount) -> flotilla::Medium {
    flotilla::Medium {
        sent: count.sent,
        lost: count.lost,
        burst_lost: count.burst_lost,
        dropped: count.dropped,
        duplicated: count.duplicated,
        corrupted: count.corrupted,
        truncated: count.truncated,
        reordered: count.reordered,
        late: count.late,
        replayed: count.replayed,
        forged_noise: count.forged.noise,
        forged_remade: count.forged.remade,
        forged_misdirected: count.forged.misdirected,
        forged_reflected: count.forged.reflected,
        delivered: count.delivered,
        under_way: count.under_way,
    }
}

/// The same, back.
#[must_use]
pub fn fault_count(medium: &flotilla::Medium) -> FaultCount {
    FaultCount {
        sent: medium.sent,
        lost: medium.lost,
        burst_lost: medium.burst_lost,
        dropped: medium.dropped,
        duplicated: medium.duplicated,
        corrupted: medium.corrupted,
        truncated: medium.truncated,
        reordered: medium.reordered,
        late: medium.late,
        replayed: medium.replayed,
        forged: ForgeryCount {
            noise: medium.forged_noise,
            remade: medium.forged_remade,
            misdirected: medium.forged_misdirected,
            reflected: medium.forged_reflected,
        },
        delivered: medium.delivered,
        under_way: medium.under_way,
    }
}

/// What became of what a motion capture sent.
#[must_use]
pub fn poses(stamp: Time, account: &PoseAccount, troubles: &[flotilla::Trouble]) -> flotilla::Poses {
    let (frames, bodies) = (&account.ledger.frames, &account.ledger.bodies);
    flotilla::Poses {
        stamp,
        source: account.source.clone(),
        frames: frames.received,
        frames_accepted: frames.accepted,
        frames_doubled: frames.doubled,
        frames_off_the_clock: frames.off_the_clock,
        frames_out_of_order: frames.out_of_order,
        frames_frozen: frames.frozen,
        frames_without_body: frames.without_body,
        bodies: bodies.received,
        bodies_accepted: bodies.accepted,
        bodies_untracked: bodies.untracked,
        bodies_not_finite: bodies.not_finite,
        bodies_teleported: bodies.teleported,
        connects: account.connects,
        clock_jumps: account.clock_jumps,
        least_delay_s: account.least_delay_s.map(|(delay_s, _)| delay_s),
        least_delay_error_s: account.least_delay_s.map(|(_, error_s)| error_s),
        late_p50_s: account.late_p50_s,
        late_p99_s: account.late_p99_s,
        troubles: troubles.to_vec(),
    }
}

/// A tick more of a trouble with poses.
pub fn suffer(troubles: &mut Vec<flotilla::Trouble>, text: &str) {
    let time_s = f64::from(TICK.as_secs_f32());
    match troubles.iter_mut().find(|known| known.text == text) {
        Some(known) => known.time_s += time_s,
        None => troubles.push(flotilla::Trouble { text: text.to_owned(), time_s }),
    }
}

/// What was seen in each leg.
#[must_use]
pub fn legs(stamp: Time, legs: &[LegWatch]) -> (flotilla::Legs, flotilla::Absences, Option<flotilla::Holds>) {
    let absences = legs.iter().enumerate().flat_map(|(leg, seen)| {
        seen.absences.iter().map(move |absence| {
            let (reason, detail) = absence.reason.numbers();
            flotilla::Absence {
                leg: leg as u32,
                place: absence.module as u32,
                reason,
                detail,
                text: absence.reason.to_string(),
                time_s: absence.time_s,
            }
        })
    });
    let absences = flotilla::Absences { stamp: stamp.clone(), absences: absences.collect() };
    let (time_s, held_s) = legs.iter().map(|leg| (leg.time_s, leg.held_s)).unzip();
    let mut holds = flotilla::Holds { stamp: stamp.clone(), ..flotilla::Holds::default() };
    for (leg, seen) in legs.iter().enumerate() {
        for (hold, time_s) in &seen.holds {
            holds.leg.push(leg as u32);
            holds.reason.push(hold.number());
            holds.time_s.push(*time_s);
        }
    }
    (flotilla::Legs { stamp, time_s, held_s }, absences, (!holds.leg.is_empty()).then_some(holds))
}

/// The same, back, of `count` legs. What no leg or no reason is left out.
#[must_use]
pub fn watched(
    count: usize,
    legs: &flotilla::Legs,
    absences: &flotilla::Absences,
    holds: &flotilla::Holds,
) -> Vec<LegWatch> {
    let mut watched = vec![LegWatch::default(); count];
    for ((leg, &time_s), &held_s) in watched.iter_mut().zip(&legs.time_s).zip(&legs.held_s) {
        (leg.time_s, leg.held_s) = (time_s, held_s);
    }
    for ((&leg, &reason), &time_s) in holds.leg.iter().zip(&holds.reason).zip(&holds.time_s) {
        if let (Some(leg), Some(hold)) = (watched.get_mut(leg as usize), Hold::from_number(reason)) {
            leg.holds.push((hold, time_s));
        }
    }
    for absence in &absences.absences {
        let reason = Reason::from_numbers(absence.reason, absence.detail);
        if let (Some(leg), Some(reason)) = (watched.get_mut(absence.leg as usize), reason) {
            leg.absences.push(Absence { module: absence.place as usize, reason, time_s: absence.time_s });
        }
    }
    watched
}
