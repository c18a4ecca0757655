#![expect(clippy::float_cmp, reason = "neutral and whole timer counts are exact")]

use std::string::String;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

/// (V, µs, kgf, A) of every line of the file.
fn file() -> Vec<(f64, f64, f64, f64)> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/data/t200_2019.csv");
    let text: String = std::fs::read_to_string(path).expect("the table is in the tree");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("voltage_V,pwm_us,rpm,current_A,power_W,force_kgf"));
    lines
        .map(|line| {
            let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            (fields[0], fields[1], fields[5], fields[3])
        })
        .collect()
}

#[test]
fn the_table_is_the_file() {
    let lines = file();
    assert_eq!(lines.len(), COLUMNS * ROWS);
    for (line, (volts, pulse_us, force_kgf, current_a)) in lines.into_iter().enumerate() {
        let (column, row) = (line / ROWS, line % ROWS);
        assert_eq!(volts, f64::from(VOLTAGE_MIN_V + VOLTAGE_STEP_V * column as f32));
        assert_eq!(pulse_us, f64::from(PULSE_MIN_US + PULSE_STEP_US * row as f32));
        let (force_n, drawn_a) = (f64::from(FORCE_N[column][row]), f64::from(CURRENT_A[column][row]));
        assert!((force_n - force_kgf * 9.80665).abs() < 6e-5, "{volts} V, {pulse_us} µs: {force_n} N");
        assert!((drawn_a - current_a).abs() < 6e-5, "{volts} V, {pulse_us} µs: {drawn_a} A");
    }
}

#[test]
fn every_row_at_every_voltage_comes_back() {
    let (mut same, mut nearer) = (0, Vec::new());
    for (volts, pulse_us, force_kgf, current_a) in file() {
        let (battery, row) = (Volts(volts as f32), PulseMicros(pulse_us as f32));
        let force_n = force_kgf * 9.80665;
        let at = std::format!("{volts} V, {pulse_us} µs");
        assert!((f64::from(thrust(row, battery).0) - force_n).abs() < 1e-4, "{at}");
        assert!((f64::from(current(row, battery).0) - current_a).abs() < 1e-4, "{at}");
        // Ask for the table's own force: 0.1 mN of rounding would decide which side of a plateau is meant.
        let demand = thrust(row, battery);
        let back = pulse(demand, battery);
        assert!((thrust(back, battery).0 - demand.0).abs() < 2e-4, "{at}: {back:?}");
        if force_n == 0.0 {
            assert_eq!(back, NEUTRAL, "{at}");
        } else if (back.0 - row.0).abs() < 0.01 {
            same += 1;
        } else {
            // Only nearer to neutral, with the same force.
            assert!((back.0 - 1500.0).abs() < (row.0 - 1500.0).abs(), "{at}: {back:?}");
            nearer.push((volts as u32, pulse_us as u32));
        }
    }
    let fallen = [(10, 1700), (12, 1100), (12, 1896), (14, 1900), (18, 1128)];
    assert_eq!(nearer, fallen);
    assert_eq!(same + nearer.len() + 101, COLUMNS * ROWS, "101 rows of the six dead bands");
}

#[test]
fn between_rows_and_voltages_it_is_linear() {
    let force_kgf = |volts: f64, pulse_us: f64| {
        file().iter().find(|line| line.0 == volts && line.1 == pulse_us).expect("a row").2
    };
    let corners = [(16.0, 1700.0), (16.0, 1704.0), (18.0, 1700.0), (18.0, 1704.0)]
        .map(|(volts, pulse_us)| force_kgf(volts, pulse_us) * 9.80665);
    // A quarter of the way in voltage, half of it in pulse.
    let by_hand = 0.75 * (corners[0] + corners[1]) / 2.0 + 0.25 * (corners[2] + corners[3]) / 2.0;
    let there = thrust(PulseMicros(1702.0), Volts(16.5));
    assert!((f64::from(there.0) - by_hand).abs() < 1e-4, "{there:?} N, by hand {by_hand} N");
    let back = pulse(there, Volts(16.5));
    assert!((back.0 - 1702.0).abs() < 0.01, "{back:?}");
}

#[test]
fn the_dead_band_is_jumped() {
    for newtons in [f32::MIN_POSITIVE, 1e-9, 1e-3, 0.01, 0.2] {
        let (ahead, astern) = (pulse(Newtons(newtons), Volts(16.0)), pulse(Newtons(-newtons), Volts(16.0)));
        assert!(ahead.0 > 1528.0 && ahead.0 < 1532.0, "{newtons} N: {ahead:?}");
        assert!(astern.0 < 1472.0 && astern.0 > 1468.0, "{newtons} N: {astern:?}");
    }
    for pulse_us in 1472..=1528_u16 {
        assert_eq!(thrust(PulseMicros(f32::from(pulse_us)), Volts(16.0)), Newtons(0.0));
    }
}

#[test]
fn nonsense_and_too_much_have_an_answer() {
    let at = |thrust, battery| pulse(Newtons(thrust), Volts(battery)).0;
    assert_eq!([at(f32::NAN, 16.0), at(0.0, 16.0), at(-0.0, 16.0)], [1500.0; 3]);
    assert_eq!([at(60.0, 16.0), at(f32::INFINITY, 16.0)], [1900.0; 2]);
    assert_eq!([at(-40.0, 16.0), at(f32::NEG_INFINITY, 16.0)], [1100.0; 2]);
    // The greatest force of these columns is not in the last row.
    assert_eq!([at(-99.0, 12.0), at(99.0, 14.0)], [1104.0, 1896.0]);
    assert_eq!(at(10.0, 9.0), at(10.0, 10.0));
    assert_eq!([at(10.0, 30.0), at(10.0, f32::NAN)], [at(10.0, 20.0); 2]);
    assert_eq!(thrust(PulseMicros(5000.0), Volts(16.0)), thrust(PulseMicros(1900.0), Volts(16.0)));
    assert_eq!(thrust(PulseMicros(0.0), Volts(16.0)), thrust(PulseMicros(1100.0), Volts(16.0)));
    assert_eq!(thrust(PulseMicros(f32::NAN), Volts(16.0)), Newtons(0.0));
    assert_eq!(current(PulseMicros(f32::NAN), Volts(16.0)), Amperes(0.0));
}

proptest! {
    #[test]
    fn what_is_asked_within_the_table_is_given(newtons in -22.0_f32..28.0, volts in 10.0_f32..20.0) {
        let out = pulse(Newtons(newtons), Volts(volts));
        let given = thrust(out, Volts(volts));
        // Below the edge of the dead band the least thrust that can be given.
        prop_assert!((given.0 - newtons).abs() < 0.012, "{} N asked, {:?} gives {:?}", newtons, out, given);
        if newtons.abs() > 0.012 {
            prop_assert!((given.0 - newtons).abs() < 5e-4, "{} N asked, {:?} gives {:?}", newtons, out, given);
        }
    }

    #[test]
    fn more_thrust_is_never_a_pulse_nearer_to_neutral(
        a in 0.0_f32..80.0, b in 0.0_f32..80.0, volts in 8.0_f32..22.0, ahead in any::<bool>(),
    ) {
        let sign = if ahead { 1.0 } else { -1.0 };
        let out = |newtons: f32| (pulse(Newtons(sign * newtons), Volts(volts)).0 - 1500.0).abs();
        prop_assert!(out(a.min(b)) <= out(a.max(b)));
    }

    #[test]
    fn any_bits_stay_within_the_range(thrust_bits: u32, volt_bits: u32, pulse_bits: u32) {
        let (newtons, volts) = (f32::from_bits(thrust_bits), Volts(f32::from_bits(volt_bits)));
        let out = pulse(Newtons(newtons), volts).0;
        prop_assert!((1100.0..=1900.0).contains(&out));
        let given = thrust(PulseMicros(f32::from_bits(pulse_bits)), volts).0;
        prop_assert!((-50.0..=66.0).contains(&given));
        let drawn = current(PulseMicros(f32::from_bits(pulse_bits)), volts).0;
        prop_assert!((0.0..=33.0).contains(&drawn));
    }
}
