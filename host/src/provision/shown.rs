//! What a configuration holds, written as the file that it could have been made from: all but its secrets.

use std::net::{Ipv4Addr, SocketAddrV4};

use firmware::provision::NotProvisioned;
use protocol::configuration::{
    BatteryLimits, EncoderConstants, Network, Own, Robot, RovConstants, ServoConstants, SupplyConstants,
    TailConstants,
};
use protocol::time::Duration;
use protocol::{Configuration, ModuleKind};

use super::tables::{
    EncoderTable, LimitsTable, ModboatTable, NetworkTable, ReportTable, RovTable, ServoTable, SupplyTable,
    Tables, ThrusterTable,
};
use super::trial;

/// The configuration as TOML. What is secret is a comment that says whether it is there.
///
/// # Errors
/// [`NotProvisioned`] where the firmware would not run it.
pub fn shown(configuration: &Configuration) -> Result<String, NotProvisioned> {
    trial::run(configuration)?;
    let Configuration { module, fleet, network, .. } = configuration;
    let secret = match (network.ssid.is_empty(), network.passphrase.bytes().is_empty()) {
        (true, _) => "none: it is on a wire",
        (false, true) => "none: the network is open",
        (false, false) => "there, not shown",
    };
    let kind = kind(configuration);
    // Tables of numbers and texts can always be written.
    let tables = toml::to_string(&tables(configuration)).unwrap_or_default();
    Ok(format!(
        "# module {module} of fleet {fleet}, {kind}\n# key: there, not shown\n# passphrase: {secret}\n\n{tables}"
    ))
}

/// What kind of robot it is for.
#[must_use]
pub const fn kind(configuration: &Configuration) -> &'static str {
    match configuration.kind() {
        ModuleKind::Modboat => "a Modboat",
        ModuleKind::Rov => "an ROV",
    }
}

/// The host's address and the module's own.
#[must_use]
pub fn addresses(configuration: &Configuration) -> (SocketAddrV4, Option<String>) {
    let Network { host, own, .. } = &configuration.network;
    let own = match own {
        Own::Dhcp => None,
        Own::Static { address, prefix, .. } => Some(format!("{}/{prefix}", Ipv4Addr::from(*address))),
    };
    (SocketAddrV4::new(host.address.into(), host.port), own)
}

fn tables(configuration: &Configuration) -> Tables {
    let Network { ssid, own, .. } = &configuration.network;
    let (host, address) = addresses(configuration);
    let gateway = match own {
        Own::Static { gateway: Some(gateway), .. } => Some(Ipv4Addr::from(*gateway).to_string()),
        _ => None,
    };
    let network = NetworkTable {
        ssid: (!ssid.is_empty()).then(|| String::from_utf8_lossy(ssid).into_owned()),
        passphrase: None,
        passphrase_file: None,
        host: Some(host.to_string()),
        address,
        gateway,
    };
    let report = ReportTable {
        every_ms: ms(configuration.report_every),
        sure_within_ms: ms(configuration.sure_within),
    };
    let (modboat, rov) = match &configuration.robot {
        Robot::Modboat(tail) => (Some(modboat(tail)), None),
        Robot::Rov(constants) => (None, Some(rov(constants))),
    };
    Tables { network, report, supply: supply(&configuration.supply), modboat, rov }
}

fn supply(constants: &SupplyConstants) -> SupplyTable {
    let &SupplyConstants {
        volts_per_volt,
        amperes_per_volt,
        battery: BatteryLimits { low, recover, hold_off },
    } = constants;
    SupplyTable {
        volts_per_volt: number(volts_per_volt),
        amperes_per_volt: number(amperes_per_volt),
        low_v: number(low.0),
        recover_v: number(recover.0),
        hold_off_s: s(hold_off),
    }
}

fn modboat(tail: &TailConstants) -> ModboatTable {
    let limits = &tail.limits;
    let ServoConstants {
        no_load_speed,
        time_constant_s,
        position_gain_per_s,
        rate_gain,
        speed_max,
        stall_current,
        current_max,
        following_error_max,
        following_error_time,
        interval,
    } = tail.servo;
    let EncoderConstants { counts_per_turn, mounting, homing_speed, homing_after } = tail.encoder;
    ModboatTable {
        limits: LimitsTable {
            amplitude_min_rad: number(limits.amplitude_min.0),
            amplitude_max_rad: number(limits.amplitude_max.0),
            centerline_max_rad: number(limits.centerline_max.0),
            rotation_max_rad: number(limits.rotation_max.0),
            speed_max_rad_s: number(limits.speed_max.0),
            period_min_s: s(limits.period_min),
            period_max_s: s(limits.period_max),
            transition_max_s: s(limits.transition_max),
        },
        servo: ServoTable {
            no_load_speed_rad_s: number(no_load_speed.0),
            time_constant_s: number(time_constant_s),
            position_gain_per_s: number(position_gain_per_s),
            rate_gain: number(rate_gain),
            speed_max_rad_s: number(speed_max.0),
            stall_current_a: number(stall_current.0),
            current_max_a: number(current_max.0),
            following_error_max_rad: number(following_error_max.0),
            following_error_time_ms: ms(following_error_time),
            interval_ms: ms(interval),
        },
        encoder: EncoderTable {
            counts_per_turn: Some(counts_per_turn.into()),
            zero_counts: Some(mounting.zero_counts.into()),
            reversed: mounting.reversed,
            homing_speed_rad_s: number(homing_speed.0),
            homing_after_s: s(homing_after),
        },
    }
}

fn rov(constants: &RovConstants) -> RovTable {
    let thrusters = constants.thrusters.iter();
    RovTable {
        thrust_max_n: number(constants.limits.thrust_max.0),
        lease_max_s: s(constants.limits.lease_max),
        frame_rate_hz: number(constants.bank.frame_rate_hz),
        arming_s: s(constants.bank.arming),
        slew_n_s: number(constants.bank.esc.slew_n_s),
        reversal_delay_ms: ms(constants.bank.esc.reversal_delay),
        thrusters: thrusters
            .map(|thruster| ThrusterTable { output: thruster.output.into(), reversed: thruster.reversed })
            .collect(),
    }
}

/// The shortest number that is the same `f32`: 0.1, not 0.10000000149.
fn number(value: f32) -> Option<f64> {
    Some(value.to_string().parse().unwrap_or_else(|_| value.into()))
}

fn s(span: Duration) -> Option<f64> {
    Some(f64::from(span.0) / 1e6)
}

fn ms(span: Duration) -> Option<f64> {
    Some(f64::from(span.0) / 1e3)
}
