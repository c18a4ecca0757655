//! The configuration of an emulated module: what `flotilla provision` writes for it.

use firmware::limits::Limits;
use firmware::servo::ServoParameters;
use host::link::identity::HostIdentity;
use protocol::configuration::{
    EncoderConstants, Host, IMAGE_MAX, Mounting, Network, Own, Passphrase, Robot, ServoConstants,
    SupplyConstants, TailConstants,
};
use protocol::units::{MicrosSpan, RadiansPerSecond, Volts};
use protocol::{Configuration, ModuleId};

use crate::emulator::HOST;

/// Of module `id` of `host`'s fleet, whose host listens on `port` of this machine.
///
/// # Panics
/// Never for a valid id.
#[must_use]
pub fn modboat(host: &HostIdentity, id: ModuleId, port: u16) -> Configuration {
    // Both ways are gone, by turns: what the emulator's network would give, taken without asking.
    let fixed = Own::Static { address: [10, 0, 2, 15], prefix: 24, gateway: None };
    let own = if id.0.is_multiple_of(2) { fixed } else { Own::Dhcp };
    let (limits, servo) = (Limits::default(), ServoParameters::default());
    Configuration {
        module: id,
        fleet: host.key.fleet(),
        key: host.key.module(id),
        network: Network {
            ssid: heapless::Vec::new(),
            passphrase: Passphrase::new(b"").expect("short"),
            host: Host { address: HOST, port },
            own,
        },
        report_every: MicrosSpan(2_000),
        sure_within: MicrosSpan(2_000),
        supply: SupplyConstants {
            volts_per_volt: 4.0,
            amperes_per_volt: 1.0,
            low: Volts(6.4),
            recover: Volts(6.8),
            hold_off: MicrosSpan(2_000_000),
        },
        robot: Robot::Modboat(TailConstants {
            amplitude_min: limits.amplitude_min,
            amplitude_max: limits.amplitude_max,
            centerline_max: limits.centerline_max,
            rotation_max: limits.rotation_max,
            speed_max: limits.speed_max,
            period_min: limits.period_min,
            period_max: limits.period_max,
            transition_max: limits.transition_max,
            servo: ServoConstants {
                no_load_speed: servo.no_load_speed,
                time_constant_s: servo.time_constant_s,
                position_gain_per_s: servo.position_gain_per_s,
                rate_gain: servo.rate_gain,
                speed_max: servo.speed_max,
                stall_current: servo.stall_current,
                current_max: servo.current_max,
                following_error_max: servo.following_error_max,
                interval: servo.interval,
            },
            encoder: EncoderConstants {
                counts_per_turn: 0,
                mounting: Mounting::default(),
                homing_speed: RadiansPerSecond(0.0),
                homing_after: MicrosSpan(0),
            },
        }),
    }
}

/// Its image.
///
/// # Panics
/// If it is none.
#[must_use]
pub fn image(configuration: &Configuration) -> Vec<u8> {
    configuration.write(&mut [0; IMAGE_MAX]).expect("a valid configuration").to_vec()
}
