use super::t200::{NEWTONS_PER_KGF, T200_CSV};
use super::*;

/// Rows of one voltage: pulse (µs), speed (rpm), power (W), thrust (N).
fn rows(voltage_v: f64) -> Vec<[f64; 4]> {
    let fields = |line: &str| line.split(',').map(|field| field.parse().unwrap()).collect::<Vec<f64>>();
    let all = T200_CSV.lines().skip(1).map(fields);
    all.filter(|f| (f[0] - voltage_v).abs() < 1e-9)
        .map(|f| [f[1], f[2], f[4], f[5] * NEWTONS_PER_KGF])
        .collect()
}

#[test]
fn every_line_of_the_table_is_read() {
    let sheets = t200::sheets();
    let voltages: Vec<f64> = sheets.iter().map(|sheet| sheet.voltage_v).collect();
    assert_eq!(voltages, [10.0, 12.0, 14.0, 16.0, 18.0, 20.0]);
    assert!(sheets.iter().all(|sheet| sheet.points.len() == 201));
    assert_eq!(T200_CSV.lines().count(), 1 + 6 * 201);
}

#[test]
fn the_table_law_is_the_table_in_every_row() {
    for voltage_v in [10.0, 12.0, 14.0, 16.0, 18.0, 20.0] {
        let law = PowerLaw::table(voltage_v).unwrap();
        let rows = rows(voltage_v);
        for [_, _, power_w, thrust_n] in &rows {
            // Several rows may have one thrust: then it is their mean.
            let equal: Vec<f64> =
                rows.iter().filter(|row| (row[3] - thrust_n).abs() < 1e-9).map(|row| row[2]).collect();
            let mean = equal.iter().sum::<f64>() / equal.len() as f64;
            assert!((law.power_w(*thrust_n) - mean).abs() < 1e-9, "{thrust_n} N: {power_w} W");
        }
    }
}

#[test]
fn between_voltages_the_table_is_interpolated_at_equal_pulse() {
    // 15 V, 1900 µs: half way between the rows of 14 V and 16 V.
    let last = |voltage_v: f64| *rows(voltage_v).last().unwrap();
    let (a, b) = (last(14.0), last(16.0));
    let law = PowerLaw::table(15.0).unwrap();
    let (thrust_n, power_w) = (0.5 * (a[3] + b[3]), 0.5 * (a[2] + b[2]));
    assert!((law.power_w(thrust_n) - power_w).abs() < 1e-9);
    assert!((limits_n(15.0).unwrap().1 - thrust_n).abs() < 1e-9);
}

#[test]
fn greatest_thrusts_at_sixteen_volts_are_the_published_ones() {
    let (reverse_n, forward_n) = limits_n(16.0).unwrap();
    assert!((reverse_n + 39.9).abs() < 0.05 && (forward_n - 51.4).abs() < 0.05, "{reverse_n} {forward_n}");
    // More voltage, more thrust.
    let mut before = (0.0, 0.0);
    for tenth in 100..=200 {
        let now = limits_n(f64::from(tenth) / 10.0).unwrap();
        assert!(now.0 < before.0 && now.1 > before.1);
        before = now;
    }
}

#[test]
fn a_power_proportional_to_the_pulse_is_wrong_at_mid_range() {
    // (11) says that half the pulse, 1700 µs, draws half the power.
    let rows = rows(16.0);
    let row = |pulse_us: f64| rows.iter().find(|row| (row[0] - pulse_us).abs() < 0.5).unwrap();
    let (half, full) = (row(1700.0), row(1900.0));
    assert!((half[2] - 73.0).abs() < 1.0 && (full[2] - 381.0).abs() < 1.0, "{} {}", half[2], full[2]);
    for law in [PowerLaw::table(16.0).unwrap(), PowerLaw::fitted(16.0).unwrap()] {
        let (half_w, full_w) = (law.power_w(half[3]), law.power_w(full[3]));
        assert!((half_w / half[2] - 1.0).abs() < 0.04, "{half_w} W for {} W", half[2]);
        assert!((full_w / full[2] - 1.0).abs() < 0.05, "{full_w} W for {} W", full[2]);
        assert!(half_w < 0.22 * full_w);
    }
}

#[test]
fn the_fitted_law_comes_near_its_table_and_the_known_law() {
    for (voltage_v, root_mean_square) in
        [(10.0, 0.03), (12.0, 0.03), (14.0, 0.03), (16.0, 0.03), (18.0, 0.04), (20.0, 0.07)]
    {
        let law = PowerLaw::fitted(voltage_v).unwrap();
        for sign in [1.0, -1.0] {
            let squares: Vec<f64> = rows(voltage_v)
                .iter()
                .filter(|row| sign * row[3] >= FIT_FROM_N)
                .map(|row| (law.power_w(row[3]) / row[2] - 1.0).powi(2))
                .collect();
            let residual = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            println!("{voltage_v} V, {sign:+}: residual {:.1} %, {law:?}", residual * 100.0);
            assert!(residual < root_mean_square, "{voltage_v} V, {sign:+}: {residual}");
        }
    }
    // DESIGN §4: 0.80·u^1.56 forward, 1.03·|u|^1.60 in reverse at 16 V.
    let law = PowerLaw::fitted(16.0).unwrap();
    for tenth in 40..=390 {
        let u = f64::from(tenth) / 10.0;
        assert!((law.power_w(u) / (0.80 * u.powf(1.56)) - 1.0).abs() < 0.05, "{u} N");
        assert!((law.power_w(-u) / (1.03 * u.powf(1.60)) - 1.0).abs() < 0.06, "-{u} N");
    }
    // In between it lies in between.
    let powers = [14.0, 15.3, 16.0].map(|v| PowerLaw::fitted(v).unwrap().power_w(2.0));
    assert!((powers[0].min(powers[2])..=powers[0].max(powers[2])).contains(&powers[1]), "{powers:?}");
}

#[test]
fn below_four_newtons_the_smooth_law_is_nearer_to_the_cube_of_the_speed_than_the_table_is() {
    let (table, fitted) = (PowerLaw::table(16.0).unwrap(), PowerLaw::fitted(16.0).unwrap());
    // One step of the current for twice the thrust.
    assert!((table.power_w(0.4003) - 0.8).abs() < 0.01 && (table.power_w(0.9786) - 0.8).abs() < 0.01);
    for sign in [1.0, -1.0] {
        // P = k n³ from 4 to 12 N, where the steps of the current are small.
        let rows: Vec<_> = rows(16.0).into_iter().filter(|row| sign * row[3] > 0.0).collect();
        let logs: Vec<f64> = rows
            .iter()
            .filter(|row| (4.0..12.0).contains(&row[3].abs()))
            .map(|row| (row[2] / row[1].powi(3)).ln())
            .collect();
        let k = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
        let error = |law: &PowerLaw| {
            let small: Vec<f64> = rows
                .iter()
                .filter(|row| row[3].abs() < 4.0)
                .map(|row| (law.power_w(row[3]) / (k * row[1].powi(3))).ln().powi(2))
                .collect();
            (small.iter().sum::<f64>() / small.len() as f64).sqrt()
        };
        let (smooth, steps) = (error(&fitted), error(&table));
        println!(
            "direction {sign:+}: from k n³ the fitted law is {smooth:.3} off, the table {steps:.3} (ln)"
        );
        assert!(smooth < 0.7 * steps, "direction {sign:+}: {smooth} {steps}");
    }
}

#[test]
fn marginal_powers_and_thrusts_are_inverse_and_are_the_slope() {
    for law in [PowerLaw::quadratic(0.14).unwrap(), PowerLaw::fitted(15.0).unwrap()] {
        for tenth in (-300..=300).filter(|tenth| *tenth != 0) {
            let u = f64::from(tenth) / 10.0;
            let y = law.marginal_w_n(u).unwrap();
            let slope = (law.power_w(u + 1e-5) - law.power_w(u - 1e-5)) / 2e-5;
            assert!((y - slope).abs() < 1e-6 * y.abs(), "{u} N: {y} {slope}");
            let (back, grows) = law.thrust_of_marginal(y).unwrap();
            assert!((back - u).abs() < 1e-9);
            let h = 1e-6 * y.abs();
            let up = law.thrust_of_marginal(y + h).unwrap().0 - law.thrust_of_marginal(y - h).unwrap().0;
            assert!((up / (2.0 * h) / grows - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn the_envelope_is_convex_below_the_table_and_touches_it() {
    for voltage_v in [10.0, 13.7, 16.0, 20.0] {
        let law = PowerLaw::table(voltage_v).unwrap();
        let PowerLaw::Table(PowerTable { points, envelope }) = &law else { panic!("no table") };
        let slopes: Vec<f64> = envelope
            .windows(2)
            .map(|pair| (pair[1].power_w - pair[0].power_w) / (pair[1].thrust_n - pair[0].thrust_n))
            .collect();
        assert!(slopes.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(envelope.iter().any(|corner| corner.thrust_n == 0.0 && corner.power_w == 0.0));
        for point in points {
            let below = envelope.partition_point(|corner| corner.thrust_n < point.thrust_n).max(1);
            let (a, slope) = (envelope[below - 1], slopes[below - 1]);
            assert!(a.power_w + slope * (point.thrust_n - a.thrust_n) <= point.power_w + 1e-9);
        }
        let widths: f64 = law.pieces().iter().map(|piece| piece.width_n).sum();
        let (reverse_n, forward_n) = limits_n(voltage_v).unwrap();
        assert!((widths - (forward_n - reverse_n)).abs() < 1e-9);
    }
}

#[test]
fn both_directions_cost_and_bad_input_is_refused_by_name() {
    let laws =
        [PowerLaw::quadratic(0.1).unwrap(), PowerLaw::table(16.0).unwrap(), PowerLaw::fitted(16.0).unwrap()];
    for law in laws {
        assert!(law.power_w(0.0) == 0.0 && law.power_w(5.0) > 0.0 && law.power_w(-5.0) > 0.0);
    }
    for voltage_v in [9.99, 20.01, f64::NAN, -1.0, f64::INFINITY] {
        let message =
            format!("a battery voltage of {voltage_v} V is outside the thruster's table, 10 to 20 V");
        assert_eq!(PowerLaw::table(voltage_v).unwrap_err().to_string(), message);
        assert_eq!(PowerLaw::fitted(voltage_v).unwrap_err().to_string(), message);
        assert_eq!(limits_n(voltage_v).unwrap_err().to_string(), message);
    }
    for coefficient in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(PowerLaw::quadratic(coefficient).is_err());
    }
}
