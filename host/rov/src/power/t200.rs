//! The measured T200 thruster: thrust and electric power against pulse width and voltage.
//!
//! Blue Robotics, T200 public performance data, September 2019: bollard pull at 10, 12 … 20 V, 1100–1900 µs in steps of
//! 4 µs. Between two voltages thrust and power are interpolated linearly at equal pulse width, as the thruster itself
//! is commanded; the curve of power over thrust follows.

use std::sync::OnceLock;

/// The table as published, forces in kgf.
pub(super) const T200_CSV: &str = include_str!("../../../data/t200_2019.csv");

/// Standard gravity, N/kgf.
pub(super) const NEWTONS_PER_KGF: f64 = 9.80665;

/// What a thruster does at one pulse width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Thrust, N.
    pub thrust_n: f64,
    /// Electric power, W.
    pub power_w: f64,
}

/// The rows of one voltage, by pulse width.
#[derive(Debug)]
pub(super) struct Sheet {
    /// Voltage, V.
    pub voltage_v: f64,
    /// Points at 1100, 1104 … 1900 µs.
    pub points: Vec<Point>,
}

/// All sheets, by voltage. Read once; the tests see to it that every line of the table is one.
pub(super) fn sheets() -> &'static [Sheet] {
    static SHEETS: OnceLock<Vec<Sheet>> = OnceLock::new();
    SHEETS.get_or_init(|| {
        let mut sheets: Vec<Sheet> = Vec::new();
        for line in T200_CSV.lines() {
            let fields: Vec<f64> = line.split(',').filter_map(|field| field.parse().ok()).collect();
            let [voltage_v, _pulse_us, _speed_rpm, _current_a, power_w, force_kgf] = fields[..] else {
                continue;
            };
            let point = Point { thrust_n: force_kgf * NEWTONS_PER_KGF, power_w };
            match sheets.last_mut().filter(|sheet| (sheet.voltage_v - voltage_v).abs() < 1e-9) {
                Some(sheet) => sheet.points.push(point),
                None => sheets.push(Sheet { voltage_v, points: vec![point] }),
            }
        }
        sheets
    })
}

/// The sheets below and above a voltage and the share of the upper one; nothing outside the table.
pub(super) fn around(voltage_v: f64) -> Option<(usize, usize, f64)> {
    let sheets = sheets();
    let above = sheets.iter().position(|sheet| sheet.voltage_v >= voltage_v)?;
    if above == 0 {
        return (voltage_v >= sheets[0].voltage_v).then_some((0, 0, 0.0));
    }
    let (low, high) = (sheets[above - 1].voltage_v, sheets[above].voltage_v);
    Some((above - 1, above, (voltage_v - low) / (high - low)))
}

/// The points at a voltage, by pulse width; nothing outside the table.
pub(super) fn at(voltage_v: f64) -> Option<Vec<Point>> {
    let (low, high, share) = around(voltage_v)?;
    let mix = |a: f64, b: f64| a + share * (b - a);
    let (low, high) = (&sheets()[low].points, &sheets()[high].points);
    Some(
        low.iter()
            .zip(high)
            .map(|(a, b)| Point { thrust_n: mix(a.thrust_n, b.thrust_n), power_w: mix(a.power_w, b.power_w) })
            .collect(),
    )
}
