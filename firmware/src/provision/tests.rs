use super::*;
use protocol::configuration::{BatteryLimits, EncoderMounting};
use protocol::units::RadiansPerSecond;

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
