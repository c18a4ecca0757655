//! Plausibility of what a module reports: numbers that none can have are kept out where they would come in.
//!
//! A report with one is corrupt, though its seal is right: nothing of it is noted, and what the module reported last gets older.
//!
//! | number | limits | why |
//! |---|---|---|
//! | tail angle | ±[`TAIL_MAX`] | beyond it an `f32` says no more where a tail points |
//! | tail speed | ±[`RATE_MAX`] | no encoder that is believed turns faster |
//! | current | ±[`CURRENT_MAX`] | eight thrusters at the highest voltage |
//! | battery | 0 to [`BATTERY_MAX`] | |
//! | pulse | [`PULSE_MIN`] to [`PULSE_MAX`] | |
//! | time of the report | [`OLDEST`] before now to [`AHEAD`] after, or 0 | a module that does not know the time says 0 |
//! | cycle | 0 to the greatest that was dispatched to the module | numbers grow |
//! | drift of the clock | ±[`DRIFT_MAX_PPB`] | |
//! | counts of datagrams | their sum is exact | [`Incoming::is_exact`](protocol::ledger::Incoming::is_exact) |
//!
//! NaN is within no limits. Of battery and current it is what a board says that measures none, and 0 takes its place.
//!
//! Assumptions and limits: a number within the limits may be wrong all the same. A time request is not looked at: its number goes back to the
//! module that sent it and nowhere else.

use protocol::time::{Duration, FleetInstant};
use protocol::{Health, Message, RovTelemetry, Telemetry};

/// Greatest |tail angle|, rad: from 2¹⁷ on two neighbouring `f32` are 0.016 rad apart, almost the 0.02 rad by which the schedule
/// tells one pose from another (`firmware::modboat::schedule::POSE_TOLERANCE`).
const TAIL_MAX: f32 = 1e5;
/// Greatest |tail speed|, rad/s: an encoder does not believe more than a quarter turn in its interval of 1 ms, 1571 rad/s
/// (`firmware::modboat::encoder`).
const RATE_MAX: f32 = 1_600.0;
/// Greatest |current|, A: eight thrusters of 32.2 A, the greatest in the measured table of the T200 (`host/data/t200_2019.csv`).
const CURRENT_MAX: f32 = 300.0;
/// Greatest voltage of a battery, V. *Assumed*: three times the highest in that table.
const BATTERY_MAX: f32 = 60.0;
/// Shortest pulse, µs. *Assumed*: a speed controller reads 1100 to 1900.
const PULSE_MIN: f32 = 500.0;
/// Longest pulse, µs. *Assumed*, likewise.
const PULSE_MAX: f32 = 2_500.0;
/// Oldest report. *Assumed*: more than a datagram is under way, or waits for a host that was paused for a while.
const OLDEST: Duration = Duration(60_000_000);
/// Farthest report ahead of fleet time. *Assumed*: half the longest round trip from which a module takes the time (1 s,
/// `firmware::link::clock`), and as much again.
const AHEAD: Duration = Duration(1_000_000);
/// Greatest drift, 10⁻⁹. *Assumed*: three times what `firmware::link::clock` takes for possible.
const DRIFT_MAX_PPB: u32 = 1_000_000;

/// `message` with nothing in it that no module can have, or nothing. `latest`: greatest number of a cycle that was dispatched to the module.
pub(super) fn plausible(now: FleetInstant, latest: u32, message: Message) -> Option<Message> {
    let timed = |at: FleetInstant, cycle: u32| {
        let in_time = at.after(OLDEST) >= now && at <= now.after(AHEAD);
        (at == FleetInstant(0) || in_time) && cycle <= latest
    };
    match message {
        Message::Telemetry(mut report) => {
            let Telemetry { at, cycle, tail, rate, current, battery, .. } = &mut report;
            supply(&mut battery.0, &mut current.0)?;
            let moves = within(tail.0, TAIL_MAX) && within(rate.0, RATE_MAX);
            (moves && timed(*at, *cycle)).then_some(Message::Telemetry(report))
        }
        Message::TailUnknown(mut report) => {
            supply(&mut report.battery.0, &mut 0.0)?;
            timed(report.at, report.cycle).then_some(Message::TailUnknown(report))
        }
        Message::RovTelemetry(mut report) => {
            let RovTelemetry { at, cycle, pulses, battery, current, .. } = &mut report;
            supply(&mut battery.0, &mut current.0)?;
            let driven = pulses.iter().all(|pulse| (PULSE_MIN..=PULSE_MAX).contains(&pulse.0));
            (driven && timed(*at, *cycle)).then_some(Message::RovTelemetry(report))
        }
        Message::Health(health) => {
            let Health { incoming, drift_ppb, .. } = health;
            let possible = incoming.is_exact() && drift_ppb.unsigned_abs() <= DRIFT_MAX_PPB;
            possible.then_some(message)
        }
        _ => Some(message),
    }
}

fn within(value: f32, most: f32) -> bool {
    value.abs() <= most
}

/// Battery and current: what is not measured becomes 0.
fn supply(battery_v: &mut f32, current_a: &mut f32) -> Option<()> {
    for value in [&mut *battery_v, &mut *current_a] {
        if value.is_nan() {
            *value = 0.0;
        }
    }
    ((0.0..=BATTERY_MAX).contains(battery_v) && within(*current_a, CURRENT_MAX)).then_some(())
}
