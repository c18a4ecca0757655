//! Configuration images: their bytes, every way in which one can be wrong, and that none is shown.

use std::path::PathBuf;

use proptest::prelude::*;
use protocol::configuration::{
    BankConstants, BatteryLimits, EncoderConstants, EncoderMounting, EscConstants, FORMAT, Host, IMAGE_MAX,
    LeaseLimits, MAGIC, Network, Own, Passphrase, Robot, RovConstants, ServoConstants, SupplyConstants,
    TailConstants, TailLimits, ThrusterMounting,
};
use protocol::time::Duration;
use protocol::units::{Amperes, Newtons, Radians, RadiansPerSecond, Volts};
use protocol::{Configuration, ConfigurationError, FleetKey, ModuleId, ModuleKey, ModuleKind};

fn tail() -> TailConstants {
    TailConstants {
        limits: TailLimits {
            amplitude_min: Radians(0.9),
            amplitude_max: Radians(2.6),
            centerline_max: Radians(1000.0),
            rotation_max: Radians(12.5),
            speed_max: RadiansPerSecond(13.0),
            period_min: Duration(500_000),
            period_max: Duration(10_000_000),
            transition_max: Duration(10_000_000),
        },
        servo: ServoConstants {
            no_load_speed: RadiansPerSecond(18.0),
            time_constant_s: 0.02,
            position_gain_per_s: 60.0,
            rate_gain: 1.2,
            speed_max: RadiansPerSecond(15.0),
            stall_current: Amperes(1.8),
            current_max: Amperes(1.2),
            following_error_max: Radians(0.022),
            following_error_time: Duration(50_000),
            interval: Duration(1_000),
        },
        encoder: EncoderConstants {
            counts_per_turn: 4_800,
            mounting: EncoderMounting { zero_counts: 1234, reversed: true },
            homing_speed: RadiansPerSecond(0.5),
            homing_after: Duration(5_000_000),
        },
    }
}

fn rov() -> RovConstants {
    RovConstants {
        thrusters: (0..6).map(|output| ThrusterMounting { output, reversed: output % 2 == 1 }).collect(),
        limits: LeaseLimits { thrust_max: Newtons(66.0), lease_max: Duration(1_000_000) },
        bank: BankConstants {
            frame_rate_hz: 400.0,
            arming: Duration(3_000_000),
            esc: EscConstants { slew_n_s: 200.0, reversal_delay: Duration(20_000) },
        },
    }
}

fn network(ssid: &[u8], passphrase: &[u8], own: Own) -> Network {
    Network {
        ssid: heapless::Vec::from_slice(ssid).expect("short enough"),
        passphrase: Passphrase::new(passphrase).expect("short enough"),
        host: Host { address: [192, 168, 4, 1], port: 5005 },
        own,
    }
}

fn modboat() -> Configuration {
    let key = FleetKey::new([0x42; 32]);
    Configuration {
        module: ModuleId(3),
        fleet: key.fleet(),
        key: key.module(ModuleId(3)),
        network: network(b"tank", b"eight or more", Own::Dhcp),
        report_every: Duration(20_000),
        sure_within: Duration(2_000),
        supply: SupplyConstants {
            volts_per_volt: 4.0,
            amperes_per_volt: 0.5,
            battery: BatteryLimits { low: Volts(6.4), recover: Volts(6.8), hold_off: Duration(2_000_000) },
        },
        robot: Robot::Modboat(tail()),
    }
}

fn on_a_wire() -> Configuration {
    let own = Own::Static { address: [10, 0, 0, 7], prefix: 24, gateway: Some([10, 0, 0, 1]) };
    Configuration { network: network(b"", b"", own), robot: Robot::Rov(rov()), ..modboat() }
}

fn image(configuration: &Configuration) -> Vec<u8> {
    configuration.write(&mut [0; IMAGE_MAX]).expect("valid").to_vec()
}

fn with_checksum(mut guarded: Vec<u8>) -> Vec<u8> {
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&guarded);
    guarded.extend(checksum.to_le_bytes());
    guarded
}

/// An image whose head and checksum are right.
fn around(content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u16).to_le_bytes();
    with_checksum([&MAGIC[..], &FORMAT.to_le_bytes(), &length, content].concat())
}

fn error(block: &[u8]) -> ConfigurationError {
    Configuration::read(block).expect_err("it is wrong")
}

fn refused(change: impl FnOnce(&mut Configuration)) -> ConfigurationError {
    let mut configuration = modboat();
    change(&mut configuration);
    let error = configuration.write(&mut [0; IMAGE_MAX]).expect_err("it is wrong");
    // It is written all the same.
    let mut buffer = [0; IMAGE_MAX];
    let content = postcard::to_slice(&configuration, &mut buffer).expect("fits");
    let read = self::error(&around(content));
    assert_eq!(format!("{read:?}"), format!("{error:?}"));
    assert!(!error.to_string().is_empty());
    error
}

#[test]
fn images_have_their_bytes() {
    for (name, configuration, kind) in
        [("modboat", modboat(), ModuleKind::Modboat), ("rov", on_a_wire(), ModuleKind::Rov)]
    {
        let bytes: String = image(&configuration).iter().map(|byte| format!("{byte:02x}")).collect();
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/wire/configuration");
        let path = folder.join(format!("{name}.hex"));
        if std::env::var_os("FLOTILLA_WRITE_GOLDEN").is_some() {
            std::fs::create_dir_all(&folder).expect("writable");
            std::fs::write(&path, bytes.clone() + "\n").expect("writable");
        }
        let stored = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert_eq!(bytes, stored.trim(), "{name}: modules in the field have this in their flash");
        // In a block of flash, the rest of it erased.
        let block = [image(&configuration), vec![0xFF; 3000]].concat();
        let read = Configuration::read(&block).expect("valid");
        assert_eq!((read.kind(), image(&read)), (kind, image(&configuration)));
        assert_eq!(read.robot, configuration.robot);
        assert_eq!((read.network, read.module), (configuration.network, configuration.module));
        assert_eq!(read.key.bytes(), configuration.key.bytes());
    }
}

#[test]
fn each_error_has_its_name_and_its_value() {
    let good = image(&modboat());
    let with = |at: usize, bytes: &[u8]| {
        let mut block = good.clone();
        block[at..at + bytes.len()].copy_from_slice(bytes);
        block
    };
    for have in [0, 3, 4, 5, 6, 7] {
        assert_eq!(error(&good[..have]), ConfigurationError::Short { have, need: 8 });
    }
    for have in 8..good.len() {
        assert_eq!(error(&good[..have]), ConfigurationError::Short { have, need: good.len() });
    }
    assert_eq!(error(&[0xFF; 1024]), ConfigurationError::Magic([0xFF; 4]), "erased flash");
    assert_eq!(error(&with(0, b"flot")), ConfigurationError::Magic(*b"flot"));
    assert_eq!(error(&with(4, &[2, 1])), ConfigurationError::Format(0x0102));
    assert_eq!(error(&with(6, &[0xF5, 0x03])), ConfigurationError::Length(1013));
    let last = with(6, &[0xF4, 0x03]);
    assert_eq!(error(&last), ConfigurationError::Short { have: good.len(), need: 1024 });
    let stored = u32::from_le_bytes(good[good.len() - 4..].try_into().expect("four bytes"));
    assert!(
        matches!(error(&with(20, &[!good[20]])), ConfigurationError::Checksum { stored: s, .. } if s == stored)
    );
    assert_eq!(error(&around(&good[8..60])), ConfigurationError::Content);
    assert_eq!(
        error(&around(&[&good[8..good.len() - 4], &[0; 7]].concat())),
        ConfigurationError::Trailing(7)
    );
    for number in [0, 1025, u16::MAX] {
        assert_eq!(refused(|c| c.module = ModuleId(number)), ConfigurationError::Module(ModuleId(number)));
    }
    for bytes in [1, 7] {
        let passphrase = Passphrase::new(&vec![b'x'; bytes]).expect("short enough");
        assert_eq!(refused(|c| c.network.passphrase = passphrase), ConfigurationError::Passphrase(bytes));
    }
    assert_eq!(refused(|c| c.network.host.port = 0), ConfigurationError::Port(0));
    let own = Own::Static { address: [10, 0, 0, 7], prefix: 33, gateway: None };
    assert_eq!(refused(|c| c.network.own = own), ConfigurationError::Prefix(33));
    for have in 0..good.len() {
        let error = modboat().write(&mut vec![0; have]).map(<[u8]>::len);
        assert_eq!(error, Err(ConfigurationError::BufferTooSmall { have }));
    }
    assert_eq!(Passphrase::new(&[b'x'; 64]), None);
}

#[test]
fn every_flipped_bit_is_noticed() {
    for good in [image(&modboat()), image(&on_a_wire())] {
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(Configuration::read(&bad).is_err(), "bit {bit}");
        }
    }
}

#[test]
fn constants_are_numbers() {
    type Change<T> = fn(&mut T, f32);
    let of_tail: [(&str, Change<TailConstants>); 14] = [
        ("amplitude_min", |c, v| c.limits.amplitude_min.0 = v),
        ("amplitude_max", |c, v| c.limits.amplitude_max.0 = v),
        ("centerline_max", |c, v| c.limits.centerline_max.0 = v),
        ("rotation_max", |c, v| c.limits.rotation_max.0 = v),
        ("speed_max", |c, v| c.limits.speed_max.0 = v),
        ("servo.no_load_speed", |c, v| c.servo.no_load_speed.0 = v),
        ("servo.time_constant_s", |c, v| c.servo.time_constant_s = v),
        ("servo.position_gain_per_s", |c, v| c.servo.position_gain_per_s = v),
        ("servo.rate_gain", |c, v| c.servo.rate_gain = v),
        ("servo.speed_max", |c, v| c.servo.speed_max.0 = v),
        ("servo.stall_current", |c, v| c.servo.stall_current.0 = v),
        ("servo.current_max", |c, v| c.servo.current_max.0 = v),
        ("servo.following_error_max", |c, v| c.servo.following_error_max.0 = v),
        ("encoder.homing_speed", |c, v| c.encoder.homing_speed.0 = v),
    ];
    let of_rov: [(&str, Change<RovConstants>); 3] = [
        ("thrust_max", |c, v| c.limits.thrust_max.0 = v),
        ("frame_rate_hz", |c, v| c.bank.frame_rate_hz = v),
        ("slew_n_s", |c, v| c.bank.esc.slew_n_s = v),
    ];
    let of_supply: [(&str, Change<SupplyConstants>); 4] = [
        ("supply.volts_per_volt", |c, v| c.volts_per_volt = v),
        ("supply.amperes_per_volt", |c, v| c.amperes_per_volt = v),
        ("supply.low", |c, v| c.battery.low.0 = v),
        ("supply.recover", |c, v| c.battery.recover.0 = v),
    ];
    let is = |error, wanted: &str, bad: f32| {
        let right = matches!(error, ConfigurationError::Constant { key, value, .. }
            if key == wanted && value.to_bits() == bad.to_bits());
        assert!(right, "{wanted} = {bad}: {error:?}");
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for (key, change) in of_tail {
            let mut tail = tail();
            change(&mut tail, bad);
            is(refused(|c| c.robot = Robot::Modboat(tail)), key, bad);
        }
        for (key, change) in of_rov {
            let mut rov = rov();
            change(&mut rov, bad);
            is(refused(|c| c.robot = Robot::Rov(rov)), key, bad);
        }
        for (key, change) in of_supply {
            is(refused(|c| change(&mut c.supply, bad)), key, bad);
        }
    }
}

#[test]
fn neither_key_nor_passphrase_is_shown() {
    let configuration = Configuration { key: ModuleKey::new([0xAB; 32]), ..modboat() };
    for text in [format!("{configuration:?}"), format!("{configuration:#x?}"), format!("{configuration:X?}")]
    {
        let flat: String = text.to_lowercase().split_whitespace().collect();
        assert!(!flat.contains("171,171") && !flat.contains("ab,0xab") && !flat.contains("ab,ab"), "{text}");
        assert!(!flat.contains("abab") && !flat.contains("eightormore"), "{text}");
        // "eigh" as numbers.
        assert!(
            !flat.contains("101,105") && !flat.contains("0x65,0x69") && !flat.contains("65,69"),
            "{text}"
        );
    }
}

#[test]
fn the_longest_fits() {
    let own = Own::Static { address: [255; 4], prefix: 32, gateway: Some([255; 4]) };
    let mounting = ThrusterMounting { output: 255, reversed: true };
    let span = Duration(u32::MAX);
    let thrusters = std::iter::repeat_n(mounting, 8).collect();
    let mut rov = RovConstants { thrusters, ..rov() };
    (rov.limits.lease_max, rov.bank.arming, rov.bank.esc.reversal_delay) = (span, span, span);
    let mut tail = tail();
    (tail.limits.period_min, tail.limits.period_max, tail.limits.transition_max) = (span, span, span);
    (tail.servo.interval, tail.encoder.mounting.zero_counts) = (span, u32::MAX);
    (tail.encoder.counts_per_turn, tail.encoder.homing_after) = (u32::MAX, span);
    for robot in [Robot::Modboat(tail), Robot::Rov(rov)] {
        let network = network(&[0xFF; 32], &[0xFF; 63], own);
        let module = ModuleId(1024);
        let mut longest =
            Configuration { module, network, report_every: span, sure_within: span, robot, ..modboat() };
        longest.supply.battery.hold_off = span;
        println!("{} bytes", image(&longest).len());
        assert!(image(&longest).len() <= 320);
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read(
        (module, key) in (1_u16..=1024, any::<[u8; 32]>()),
        ssid in prop::collection::vec(any::<u8>(), 0..=32),
        passphrase in prop_oneof![Just(Vec::new()), prop::collection::vec(any::<u8>(), 8..=63)],
        (address, port) in (any::<[u8; 4]>(), 1_u16..),
        own in prop_oneof![
            Just(Own::Dhcp),
            (any::<[u8; 4]>(), 0_u8..=32, any::<Option<[u8; 4]>>())
                .prop_map(|(address, prefix, gateway)| Own::Static { address, prefix, gateway }),
        ],
        numbers in prop::collection::vec(-1e30_f32..1e30, 13),
        spans in any::<[u32; 6]>(),
        thrusters in prop::option::of(prop::collection::vec(any::<(u8, bool)>(), 0..=8)),
    ) {
        let [period_min, period_max, transition_max, interval, report_every, sure_within] = spans.map(Duration);
        let robot = match thrusters {
            Some(thrusters) => Robot::Rov(RovConstants {
                thrusters: thrusters.iter().map(|&(output, reversed)| ThrusterMounting { output, reversed }).collect(),
                limits: LeaseLimits { thrust_max: Newtons(numbers[0]), lease_max: period_min },
                bank: BankConstants {
                    frame_rate_hz: numbers[1],
                    arming: period_max,
                    esc: EscConstants { slew_n_s: numbers[2], reversal_delay: interval },
                },
            }),
            None => {
                let limits = TailLimits { period_min, period_max, transition_max, ..tail().limits };
                let mut tail = TailConstants { limits, ..tail() };
                (tail.limits.amplitude_min.0, tail.limits.speed_max.0, tail.servo.rate_gain) = (numbers[3], numbers[4], numbers[5]);
                (tail.servo.interval, tail.encoder.mounting.zero_counts) = (interval, spans[0]);
                Robot::Modboat(tail)
            }
        };
        let mut network = network(&ssid, &passphrase, own);
        network.host = Host { address, port };
        let configuration = Configuration {
            module: ModuleId(module), key: ModuleKey::new(key), network, report_every, sure_within, robot, ..modboat()
        };
        let read = Configuration::read(&image(&configuration)).expect("valid");
        prop_assert_eq!(read.key.bytes(), &key);
        prop_assert_eq!(image(&read), image(&configuration));
        prop_assert_eq!((read.robot, read.network), (configuration.robot, configuration.network));
        prop_assert_eq!((read.module, read.report_every), (ModuleId(module), report_every));
    }
}
