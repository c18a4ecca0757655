//! The constants of a module's hardware, checked as the firmware would check them.
//!
//! Defaults are the firmware's. Bounds that the firmware does not know, on times above all, are *assumed*: wide, and there to catch a
//! slip of units.

use firmware::modboat::quadrature::{COUNTS_MAX, READINGS};
use firmware::rov::thruster::bank::FRAME_RATE_HZ;
use firmware::{link::session, rov::lease};
use protocol::configuration::{
    BankConstants, BatteryLimits, EncoderConstants, EncoderMounting, EscConstants, LeaseLimits, Robot,
    RovConstants, ServoConstants, SupplyConstants, TailConstants, TailLimits, ThrusterMounting,
};
use protocol::message::MAX_THRUSTERS;
use protocol::time::Duration;
use protocol::units::{Amperes, Newtons, Radians, RadiansPerSecond, Volts};
use quantity::Range::{NonNegative, Positive};

use super::file::{ModuleFile, ProvisionError};
use super::tables::{EncoderTable, ModboatTable, RovTable, ServoTable};

/// Pause between two reports where the file says none. *Assumed*: fifty a second of each module are little for any network.
const REPORT_EVERY: Duration = Duration(20_000);
/// One second, µs.
const S: u32 = 1_000_000;
/// One millisecond, µs.
const MS: u32 = 1_000;
/// The longest time that a module can be told, in whole seconds, µs.
const LONGEST: u32 = 4_294 * S;

/// `[report] every_ms`.
pub(super) fn report_every(file: &ModuleFile) -> Result<Duration, ProvisionError> {
    file.span(&["report"], "every_ms", file.tables.report.every_ms, REPORT_EVERY, MS..=60 * S)
}

/// `[report] sure_within_ms`.
pub(super) fn sure_within(file: &ModuleFile, robot: &Robot) -> Result<Duration, ProvisionError> {
    let default = match robot {
        Robot::Modboat(_) => session::SURE_WITHIN,
        Robot::Rov(_) => lease::SURE_WITHIN,
    };
    file.span(&["report"], "sure_within_ms", file.tables.report.sure_within_ms, default, MS / 10..=S)
}

/// `[supply]`.
pub(super) fn supply(file: &ModuleFile, robot: &Robot) -> Result<SupplyConstants, ProvisionError> {
    let (table, at) = (&file.tables.supply, &["supply"]);
    let usual = match robot {
        Robot::Modboat(_) => BatteryLimits::MODBOAT,
        Robot::Rov(_) => BatteryLimits::ROV,
    };
    let ratio = |key, unit, given| file.number(at, (key, unit), given, 0.0, NonNegative);
    let volts =
        |key, given, default: Volts| file.number(at, (key, "V"), given, default.0, Positive).map(Volts);
    let supply = SupplyConstants {
        volts_per_volt: ratio("volts_per_volt", "V/V", table.volts_per_volt)?,
        amperes_per_volt: ratio("amperes_per_volt", "A/V", table.amperes_per_volt)?,
        battery: BatteryLimits {
            low: volts("low_v", table.low_v, usual.low)?,
            recover: volts("recover_v", table.recover_v, usual.recover)?,
            hold_off: file.span(at, "hold_off_s", table.hold_off_s, usual.hold_off, 0..=3_600 * S)?,
        },
    };
    let (low, recover) = (supply.battery.low.0, supply.battery.recover.0);
    ordered(file, at, ("low_v", low), ("recover_v", recover), "V")?;
    Ok(supply)
}

/// `[modboat]`.
pub(super) fn modboat(file: &ModuleFile, table: &ModboatTable) -> Result<TailConstants, ProvisionError> {
    let (limits, at, usual) = (&table.limits, &["modboat", "limits"], TailLimits::default());
    let angle =
        |key, given, default: Radians| file.number(at, (key, "rad"), given, default.0, Positive).map(Radians);
    let time = |key, given, default| file.span(at, key, given, default, MS..=LONGEST);
    let speed = ("speed_max_rad_s", "rad/s");
    let limits = TailLimits {
        amplitude_min: angle("amplitude_min_rad", limits.amplitude_min_rad, usual.amplitude_min)?,
        amplitude_max: angle("amplitude_max_rad", limits.amplitude_max_rad, usual.amplitude_max)?,
        centerline_max: angle("centerline_max_rad", limits.centerline_max_rad, usual.centerline_max)?,
        rotation_max: angle("rotation_max_rad", limits.rotation_max_rad, usual.rotation_max)?,
        speed_max: file
            .number(at, speed, limits.speed_max_rad_s, usual.speed_max.0, Positive)
            .map(RadiansPerSecond)?,
        period_min: time("period_min_s", limits.period_min_s, usual.period_min)?,
        period_max: time("period_max_s", limits.period_max_s, usual.period_max)?,
        transition_max: time("transition_max_s", limits.transition_max_s, usual.transition_max)?,
    };
    let (servo, encoder) = (servo(file, &table.servo)?, encoder(file, &table.encoder)?);
    let (least, most) = (limits.amplitude_min.0, limits.amplitude_max.0);
    ordered(file, at, ("amplitude_min_rad", least), ("amplitude_max_rad", most), "rad")?;
    let (least, most) = (limits.period_min.as_secs_f32(), limits.period_max.as_secs_f32());
    ordered(file, at, ("period_min_s", least), ("period_max_s", most), "s")?;
    Ok(TailConstants { limits, servo, encoder })
}

fn servo(file: &ModuleFile, table: &ServoTable) -> Result<ServoConstants, ProvisionError> {
    let (at, usual) = (&["modboat", "servo"], ServoConstants::default());
    let positive = |key, unit, given, default| file.number(at, (key, unit), given, default, Positive);
    let speed = |key, given, default: RadiansPerSecond| {
        positive(key, "rad/s", given, default.0).map(RadiansPerSecond)
    };
    let current = |key, given, default: Amperes| positive(key, "A", given, default.0).map(Amperes);
    let error = ("following_error_max_rad", table.following_error_max_rad, usual.following_error_max.0);
    Ok(ServoConstants {
        no_load_speed: speed("no_load_speed_rad_s", table.no_load_speed_rad_s, usual.no_load_speed)?,
        time_constant_s: positive("time_constant_s", "s", table.time_constant_s, usual.time_constant_s)?,
        position_gain_per_s: positive(
            "position_gain_per_s",
            "1/s",
            table.position_gain_per_s,
            usual.position_gain_per_s,
        )?,
        rate_gain: positive("rate_gain", "1", table.rate_gain, usual.rate_gain)?,
        speed_max: speed("speed_max_rad_s", table.speed_max_rad_s, usual.speed_max)?,
        stall_current: current("stall_current_a", table.stall_current_a, usual.stall_current)?,
        current_max: current("current_max_a", table.current_max_a, usual.current_max)?,
        following_error_max: positive(error.0, "rad", error.1, error.2).map(Radians)?,
        following_error_time: file.span(
            at,
            "following_error_time_ms",
            table.following_error_time_ms,
            usual.following_error_time,
            MS..=10_000 * MS,
        )?,
        interval: file.span(at, "interval_ms", table.interval_ms, usual.interval, MS / 10..=100 * MS)?,
    })
}

fn encoder(file: &ModuleFile, table: &EncoderTable) -> Result<EncoderConstants, ProvisionError> {
    let at = &["modboat", "encoder"];
    let Some(counts) = table.counts_per_turn else {
        let message = "counts_per_turn is missing: write the counts in one turn of the tail, each edge of both lines, gears \
                       included; 0 if the encoder is absolute";
        return Err(file.wrong(at, "counts_per_turn", message));
    };
    let counts_per_turn = file.count(at, "counts_per_turn", counts, 0..=COUNTS_MAX)?;
    // An absolute encoder has readings of its own.
    let readings = if counts_per_turn > 0 { READINGS - 1 } else { u32::MAX };
    let mounting = EncoderMounting {
        zero_counts: file.count(at, "zero_counts", table.zero_counts.unwrap_or(0), 0..=readings)?,
        reversed: table.reversed,
    };
    let homing = ("homing_speed_rad_s", "rad/s");
    Ok(EncoderConstants {
        counts_per_turn,
        mounting,
        homing_speed: file
            .number(at, homing, table.homing_speed_rad_s, 0.0, NonNegative)
            .map(RadiansPerSecond)?,
        homing_after: file.span(at, "homing_after_s", table.homing_after_s, Duration(0), 0..=3_600 * S)?,
    })
}

/// `[rov]`.
pub(super) fn rov(file: &ModuleFile, table: &RovTable) -> Result<RovConstants, ProvisionError> {
    let at = &["rov"];
    let count = table.thrusters.len();
    if !(1..=MAX_THRUSTERS).contains(&count) {
        let message = format!("has {count} thrusters: write 1 to {MAX_THRUSTERS} tables [[rov.thruster]]");
        return Err(file.wrong(at, "thruster", &message));
    }
    let mut thrusters = Vec::new();
    for (index, thruster) in table.thrusters.iter().enumerate() {
        let index = index.to_string();
        let at = &["rov", "thruster", &index];
        let output = file.count(at, "output", thruster.output, 0..=MAX_THRUSTERS as u32 - 1)? as u8;
        let earlier = thrusters.iter().position(|other: &ThrusterMounting| other.output == output);
        if let Some(earlier) = earlier {
            let message = format!("output = {output}: [[rov.thruster]] {} has it already", earlier + 1);
            return Err(file.wrong(at, "output", &message));
        }
        thrusters.push(ThrusterMounting { output, reversed: thruster.reversed });
    }
    let (bank, limits) = (BankConstants::default(), LeaseLimits::default());
    let positive = |key, unit, given, default| file.number(at, (key, unit), given, default, Positive);
    let rate = positive("frame_rate_hz", "Hz", table.frame_rate_hz, bank.frame_rate_hz)?;
    let (least, most) = FRAME_RATE_HZ;
    if !(least..=most).contains(&rate) {
        let message = format!("frame_rate_hz = {rate} Hz: must lie between {least} and {most} Hz");
        return Err(file.wrong(at, "frame_rate_hz", &message));
    }
    let delay = bank.esc.reversal_delay;
    Ok(RovConstants {
        thrusters: thrusters.into_iter().collect(),
        limits: LeaseLimits {
            thrust_max: positive("thrust_max_n", "N", table.thrust_max_n, limits.thrust_max.0)
                .map(Newtons)?,
            lease_max: file.span(at, "lease_max_s", table.lease_max_s, limits.lease_max, MS..=60 * S)?,
        },
        bank: BankConstants {
            frame_rate_hz: rate,
            arming: file.span(at, "arming_s", table.arming_s, bank.arming, 0..=60 * S)?,
            esc: EscConstants {
                slew_n_s: positive("slew_n_s", "N/s", table.slew_n_s, bank.esc.slew_n_s)?,
                reversal_delay: file.span(
                    at,
                    "reversal_delay_ms",
                    table.reversal_delay_ms,
                    delay,
                    0..=10 * S,
                )?,
            },
        },
    })
}

/// Refuses bounds between which nothing lies.
fn ordered(
    file: &ModuleFile,
    table: &[&str],
    (low_key, low): (&'static str, f32),
    (high_key, high): (&'static str, f32),
    unit: &str,
) -> Result<(), ProvisionError> {
    if low <= high {
        return Ok(());
    }
    let message = format!(
        "{low_key} = {low} {unit}: must not exceed {high_key} = {high} {unit}: the range is reversed"
    );
    Err(file.wrong(table, low_key, &message))
}
