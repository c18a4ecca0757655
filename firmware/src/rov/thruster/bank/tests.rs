use embedded_hal_mock::eh1::pwm::{Mock, Transaction};
use proptest::prelude::*;
use std::vec::Vec as List;

use super::*;
use protocol::configuration::EscConstants;
use protocol::time::Duration;

/// One count a microsecond.
const MAX_DUTY: u16 = 2_500;
const BATTERY: Volts = Volts(16.0);

fn settings() -> BankConstants {
    BankConstants {
        frame_rate_hz: 400.0,
        arming: Duration(2_000),
        esc: EscConstants { slew_n_s: 1e9, reversal_delay: Duration(2_000) },
    }
}

fn straight(count: u8) -> List<ThrusterMounting> {
    (0..count).map(|output| ThrusterMounting { output, reversed: false }).collect()
}

/// A pin that expects these duties, with every reading of its range the bank makes.
fn pin(duties: &[u16]) -> Mock {
    let mut expected = std::vec![Transaction::max_duty_cycle(MAX_DUTY)];
    for &duty in duties {
        expected.extend([Transaction::max_duty_cycle(MAX_DUTY), Transaction::set_duty_cycle(duty)]);
    }
    Mock::new(&expected)
}

fn done(bank: Bank<Mock>) {
    for mut pin in bank.release() {
        pin.done();
    }
}

fn pins(duties: &[&[u16]]) -> Vec<Mock, MAX_THRUSTERS> {
    duties.iter().map(|duties| pin(duties)).collect()
}

#[test]
fn arms_at_neutral_then_drives_order_and_direction() {
    let ahead = libm::roundf(law::pulse(Newtons(10.0), BATTERY).0) as u16;
    let mirrored = 3000 - ahead;
    assert!(ahead > 1528);
    // Thruster 0 on pin 1 as it is, thruster 1 on pin 0 turned round.
    let mountings =
        [ThrusterMounting { output: 1, reversed: false }, ThrusterMounting { output: 0, reversed: true }];
    let pins = pins(&[&[1500, 1500, mirrored, mirrored, 1500], &[1500, 1500, ahead, 1500, 1500]]);
    let mut bank = Bank::new(pins, &mountings, settings()).unwrap();
    let both = [Newtons(10.0), Newtons(10.0)];
    bank.tick(LocalInstant(7_000), &both, BATTERY).unwrap();
    bank.tick(LocalInstant(8_999), &both, BATTERY).unwrap();
    bank.tick(LocalInstant(9_000), &both, BATTERY).unwrap();
    assert_eq!(bank.pulses()[..], [ahead, mirrored].map(|us| PulseMicros(f32::from(us))));
    bank.tick(LocalInstant(10_000), &[Newtons(f32::NAN), Newtons(10.0)], BATTERY).unwrap();
    bank.tick(LocalInstant(11_000), &[], BATTERY).unwrap();
    assert_eq!(bank.pulses()[..], [NEUTRAL; 2]);
    done(bank);
}

#[test]
fn a_timer_step_is_what_is_reported() {
    // 50 Hz with 10 000 counts: 2 µs each.
    let pins = [Mock::new(&[
        Transaction::max_duty_cycle(10_000),
        Transaction::max_duty_cycle(10_000),
        Transaction::set_duty_cycle(750),
        Transaction::max_duty_cycle(10_000),
        Transaction::set_duty_cycle(850),
    ])];
    let settings = BankConstants { frame_rate_hz: 50.0, arming: Duration(0), ..settings() };
    let mut bank = Bank::new(pins, &straight(1), settings).unwrap();
    bank.tick(LocalInstant(0), &[], BATTERY).unwrap();
    let wanted = law::thrust(PulseMicros(1700.7), BATTERY);
    bank.tick(LocalInstant(1_000), &[wanted], BATTERY).unwrap();
    assert_eq!(bank.pulses()[..], [PulseMicros(1700.0)]);
    done(bank);
}

/// A pin that fails on demand.
struct Loose(bool);

impl embedded_hal::pwm::ErrorType for Loose {
    type Error = embedded_hal::pwm::ErrorKind;
}

impl SetDutyCycle for Loose {
    fn max_duty_cycle(&self) -> u16 {
        MAX_DUTY
    }

    fn set_duty_cycle(&mut self, _duty: u16) -> Result<(), Self::Error> {
        if self.0 { Err(embedded_hal::pwm::ErrorKind::Other) } else { Ok(()) }
    }
}

#[test]
fn one_failing_output_leaves_the_others_running() {
    let pins = [Loose(true), Loose(false)];
    let settings = BankConstants { arming: Duration(0), ..settings() };
    let mut bank = Bank::new(pins, &straight(2), settings).unwrap();
    assert!(bank.tick(LocalInstant(0), &[], BATTERY).is_err());
    assert!(bank.tick(LocalInstant(1_000), &[Newtons(9.0), Newtons(9.0)], BATTERY).is_err());
    assert_eq!(bank.pulses()[0], NEUTRAL, "nothing else was ever put out there");
    assert!(bank.pulses()[1].0 > 1528.0);
}

#[test]
fn what_cannot_be_driven_is_refused_by_name() {
    let refused = |count: usize, mountings: &[ThrusterMounting], settings: BankConstants| {
        let pins = (0..count).map(|_| Loose(false));
        Bank::new(pins, mountings, settings).map(|_| ()).unwrap_err()
    };
    let good = settings();
    assert_eq!(refused(0, &[], good), BankError::Count { thrusters: 0, pins: 0 });
    assert_eq!(refused(2, &straight(3), good), BankError::Count { thrusters: 3, pins: 2 });
    let shared = [ThrusterMounting { output: 1, reversed: false }; 2];
    assert_eq!(refused(2, &shared, good), BankError::Output(1));
    assert_eq!(refused(1, &[ThrusterMounting { output: 1, reversed: false }], good), BankError::Output(1));
    for hz in [49.0, 401.0] {
        let settings = BankConstants { frame_rate_hz: hz, ..good };
        assert_eq!(refused(1, &straight(1), settings), BankError::FrameRate(hz));
    }
    assert!(matches!(
        refused(1, &straight(1), BankConstants { frame_rate_hz: f32::NAN, ..good }),
        BankError::FrameRate(_)
    ));
    let esc = EscConstants { slew_n_s: 0.0, ..good.esc };
    assert_eq!(refused(1, &straight(1), BankConstants { esc, ..good }), BankError::Slew(0.0));
    // 2500 counts in 20 ms.
    assert_eq!(refused(1, &straight(1), BankConstants { frame_rate_hz: 50.0, ..good }), BankError::Step(8.0));
}

proptest! {
    #[test]
    fn no_demand_leaves_the_range_of_the_pins(
        ticks in proptest::collection::vec((0_u64..5_000, any::<[u32; 3]>(), any::<u32>()), 1..40),
    ) {
        let pins = (0..3).map(|_| Loose(false));
        let mountings = [(2, true), (0, false), (1, false)].map(|(output, reversed)| ThrusterMounting { output, reversed });
        let mut bank = Bank::new(pins, &mountings, settings()).unwrap();
        let mut now = LocalInstant(0);
        for (pause, demand_bits, volt_bits) in ticks {
            let thrusts = demand_bits.map(|bits| Newtons(f32::from_bits(bits)));
            bank.tick(now, &thrusts, Volts(f32::from_bits(volt_bits))).unwrap();
            for pulse in bank.pulses() {
                prop_assert!((1100.0..=1900.0).contains(&pulse.0), "{pulse:?}");
            }
            now = LocalInstant(now.0 + pause);
        }
    }
}
