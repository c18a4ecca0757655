use super::*;
use protocol::configuration::{BatteryLimits, EncoderMounting};
use protocol::units::{Radians, RadiansPerSecond};

fn encoder(counts_per_turn: u32) -> EncoderConstants {
    EncoderConstants {
        counts_per_turn,
        mounting: EncoderMounting::default(),
        homing_speed: RadiansPerSecond(0.0),
        homing_after: Duration(0),
    }
}

#[test]
fn a_board_that_counts_wants_counts() {
    for counts in [0, COUNTS_MAX + 1, u32::MAX] {
        assert_eq!(quadrature(&encoder(counts)).unwrap_err(), NotProvisioned::Counts(counts));
    }
    let mut quadrature = quadrature(&encoder(4)).unwrap();
    // Onto the index, and a quarter of a turn beyond it.
    [(0, false), (1, true), (2, true)].into_iter().for_each(|(count, index)| quadrature.update(count, index));
    assert_eq!(quadrature.reading(), Some(1 << 14));
}

#[test]
fn the_servo_is_called_as_often_as_it_says() {
    let constants = |micros| ServoConstants { interval: Duration(micros), ..ServoConstants::default() };
    for micros in [500, 1_000, 10_000] {
        assert_eq!(servo_interval(&constants(micros)), Ok(Duration(micros)));
    }
    for micros in [0, 499, 10_001, u32::MAX] {
        let refused = NotProvisioned::Interval(Duration(micros));
        assert_eq!(servo_interval(&constants(micros)), Err(refused));
    }
}

#[test]
fn an_input_with_nothing_wired_to_it_says_nothing() {
    let supply = |volts_per_volt, amperes_per_volt| SupplyConstants {
        volts_per_volt,
        amperes_per_volt,
        battery: BatteryLimits::MODBOAT,
    };
    assert_eq!(battery(&supply(3.0, 0.0), Volts(2.5)), Volts(7.5));
    assert!(battery(&supply(0.0, 0.0), Volts(2.5)).0.is_nan());
    assert_eq!(current(&supply(0.0, 2.0), Volts(0.25)), Some(Amperes(0.5)));
    assert_eq!(current(&supply(0.0, 0.0), Volts(0.25)), None);
}

#[test]
fn a_tail_that_is_not_watched_is_refused() {
    let servo = |error_rad, time| ServoConstants {
        following_error_max: Radians(error_rad),
        following_error_time: Duration(time),
        ..ServoConstants::default()
    };
    assert_eq!(check_following(&ServoConstants::default()), Ok(()));
    assert_eq!(check_following(&servo(0.15, 350_000)), Ok(()));
    for (error_rad, time) in [(0.151, 50_000), (f32::INFINITY, 50_000), (0.02, 0), (0.02, 350_001)] {
        let refused = NotProvisioned::Following(error_rad, Duration(time));
        assert_eq!(check_following(&servo(error_rad, time)), Err(refused));
    }
    assert!(check_following(&servo(f32::NAN, 50_000)).is_err());
}

#[test]
fn limits_that_no_cycle_keeps_are_refused() {
    let usual = TailLimits::default();
    assert_eq!(check_limits(&usual), Ok(()));
    for (key, limits) in [
        ("amplitude", TailLimits { amplitude_min: Radians(2.7), ..usual }),
        ("amplitude", TailLimits { amplitude_min: Radians(-0.1), ..usual }),
        ("amplitude", TailLimits { amplitude_max: Radians(f32::NAN), ..usual }),
        ("centerline_max", TailLimits { centerline_max: Radians(0.0), ..usual }),
        ("rotation_max", TailLimits { rotation_max: Radians(-1.0), ..usual }),
        ("speed_max", TailLimits { speed_max: RadiansPerSecond(f32::NAN), ..usual }),
        ("period", TailLimits { period_min: Duration(11_000_000), ..usual }),
        ("period", TailLimits { period_min: Duration(0), ..usual }),
        ("transition_max", TailLimits { transition_max: Duration(0), ..usual }),
    ] {
        assert_eq!(check_limits(&limits), Err(NotProvisioned::Limits(key)), "{limits:?}");
    }
}
