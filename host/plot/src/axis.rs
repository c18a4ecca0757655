//! Axes: which interval is shown, where its ticks stand and how they read.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// How tick values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// With that many decimals.
    Decimals(usize),
    /// As multiples of π/2.
    QuarterTurns,
    /// As the number whose logarithm it is.
    Logarithm,
}

/// One axis of a panel.
#[derive(Clone, Debug)]
pub struct Axis {
    range: Range<f64>,
    ticks: Vec<f64>,
    format: Format,
}

impl Axis {
    /// An axis over exactly `[low, high]` with about `wanted` ticks at round values (1, 2, 5 × 10ⁿ).
    #[must_use]
    pub fn exact(low: f64, high: f64, wanted: usize) -> Self {
        let range = widened(low, high, 0.0);
        let step = decimal_step((range.end - range.start) / wanted.max(1) as f64);
        Self::with_step(range, step)
    }

    /// An axis over exactly `[low, high]` with ticks at the least round step that is not below `least`.
    #[must_use]
    pub fn spaced(low: f64, high: f64, least: f64) -> Self {
        // Places: far from the origin a metre is still a metre.
        let range = if low.is_finite() && high - low > low.abs() * 1e-9 && high.abs() <= 1e9 {
            low..high
        } else {
            widened(low, high, 0.0)
        };
        let least = least.max((range.end - range.start) / 100.0);
        Self::with_step(range, decimal_step(least))
    }

    /// An axis that holds `[low, high]` with some air above and below it.
    #[must_use]
    pub fn padded(low: f64, high: f64, wanted: usize) -> Self {
        let range = widened(low, high, 0.08);
        Self::exact(range.start, range.end, wanted)
    }

    /// A time axis in seconds over exactly `[low, high]`: ticks that suit a clock.
    #[must_use]
    pub fn time(low: f64, high: f64, wanted: usize) -> Self {
        const STEPS_S: [f64; 13] =
            [0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0];
        Self::with_one_of(&STEPS_S, widened(low, high, 0.0), wanted)
    }

    /// An axis in degrees with some air and ticks at divisors of a right angle.
    #[must_use]
    pub fn degrees(low: f64, high: f64, wanted: usize) -> Self {
        const STEPS: [f64; 10] = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0];
        Self::with_one_of(&STEPS, widened(low, high, 0.08), wanted)
    }

    /// An axis in radians over exactly `[low, high]` with ticks every `quarters`·π/2, written with π.
    #[must_use]
    pub fn radians(low: f64, high: f64, quarters: u32) -> Self {
        let range = widened(low, high, 0.0);
        let mut axis = Self::with_step(range, f64::from(quarters.max(1)) * FRAC_PI_2);
        axis.format = Format::QuarterTurns;
        axis
    }

    /// An axis for logarithms to base ten, with ticks at those of `values` (positive, ascending) and some air beyond the
    /// first and the last.
    #[must_use]
    pub fn logarithmic(values: &[f64]) -> Self {
        let ticks: Vec<f64> = values.iter().map(|v| v.log10()).collect();
        let (low, high) = extent(ticks.iter().copied()).unwrap_or((0.0, 1.0));
        Self { range: widened(low, high, 0.04), ticks, format: Format::Logarithm }
    }

    /// With the least of `steps`, or a round step where the ticks would stand closer than half of the first or all are too short.
    fn with_one_of(steps: &[f64], range: Range<f64>, wanted: usize) -> Self {
        let least = (range.end - range.start) / wanted.max(1) as f64;
        let step = steps.iter().copied().find(|&step| step >= least && least >= 0.5 * steps[0]);
        Self::with_step(range, step.unwrap_or_else(|| decimal_step(least)))
    }

    fn with_step(range: Range<f64>, step: f64) -> Self {
        // A tick on the very end of an axis must not be lost to rounding.
        let slack = step * 1e-6;
        let first = ((range.start - slack) / step).ceil() as i64;
        let last = ((range.end + slack) / step).floor() as i64;
        let ticks = (first..=last).take(1000).map(|n| n as f64 * step).collect();
        let decimals = (0..9).find(|&d| is_whole(step * 10f64.powi(d))).unwrap_or(9);
        Self { range, ticks, format: Format::Decimals(decimals as usize) }
    }

    /// Values at which ticks stand.
    #[must_use]
    pub fn ticks(&self) -> &[f64] {
        &self.ticks
    }

    /// How a tick reads, with a true minus sign.
    #[must_use]
    pub fn label(&self, value: f64) -> String {
        match self.format {
            Format::Decimals(decimals) => number(value, decimals),
            Format::QuarterTurns => quarter_turns(value),
            Format::Logarithm => power_of_ten(value),
        }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        // Far outside stays far outside, without running out of pixels.
        let share = ((value - self.range.start) / (self.range.end - self.range.start)).clamp(-9.0, 9.0);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(value: &f64) -> String {
        number(*value, 2)
    }

    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

/// A number with that many decimals, a true minus sign, and no negative zero.
#[must_use]
pub fn number(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let is_zero = digits.chars().all(|c| c == '0' || c == '.');
    if value < 0.0 && !is_zero { format!("−{digits}") } else { digits }
}

/// The smallest interval that holds all finite values; `None` if there are none.
#[must_use]
pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|v| v.is_finite()).fold(None, |seen, v| match seen {
        None => Some((v, v)),
        Some((low, high)) => Some((f64::min(low, v), f64::max(high, v))),
    })
}

/// `[low, high]` with `air` times its length on both sides; never empty, never beyond what a picture can show.
fn widened(low: f64, high: f64, air: f64) -> Range<f64> {
    let sane = |v: f64| if v.is_finite() { v.clamp(-1e9, 1e9) } else { 0.0 };
    let (low, high) = (sane(low.min(high)), sane(high.max(low)));
    let length = high - low;
    let centre = 0.5 * (low + high);
    // A constant series gets an interval in proportion to its value.
    let least = (centre.abs() * 1e-3).max(1e-6);
    if length < least {
        let half = (centre.abs() * 0.1).max(0.5 * least);
        return centre - half..centre + half;
    }
    low - air * length..high + air * length
}

/// The least of 1, 2, 5 × 10ⁿ that is at least `least`.
fn decimal_step(least: f64) -> f64 {
    let power = least.max(1e-9).log10().floor();
    let unit = 10f64.powf(power);
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * unit)
        .find(|&s| s >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * unit)
}

fn is_whole(value: f64) -> bool {
    value > 0.5 && (value - value.round()).abs() < 1e-6 * value
}

fn quarter_turns(value: f64) -> String {
    let quarters = (value / FRAC_PI_2).round() as i64;
    let sign = if quarters < 0 { "−" } else { "" };
    let (count, over) = if quarters % 2 == 0 { (quarters.abs() / 2, "") } else { (quarters.abs(), "/2") };
    match count {
        0 => "0".to_owned(),
        1 => format!("{sign}π{over}"),
        n => format!("{sign}{n}π{over}"),
    }
}

/// 10^exponent: written out from a hundredth to ten thousand, as 10ⁿ beyond.
fn power_of_ten(exponent: f64) -> String {
    let whole = exponent.round();
    if (exponent - whole).abs() > 1e-9 || (-2.0..=4.0).contains(&whole) {
        let decimals = if exponent < -1e-9 { (-exponent).ceil() as usize } else { 0 };
        return number(10f64.powf(exponent), decimals);
    }
    let raised = |c: char| match c {
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or('⁻'),
    };
    format!("10{}", number(whole, 0).chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_read_as_their_numbers() {
        let axis = Axis::logarithmic(&[1e-12, 0.01, 0.1, 1.0, 3.0, 25.0, 1024.0, 1e6]);
        let labels: Vec<_> = axis.ticks().iter().map(|&t| axis.label(t)).collect();
        assert_eq!(labels, ["10⁻¹²", "0.01", "0.1", "1", "3", "25", "1024", "10⁶"]);
        assert!(axis.range.start < -12.0 && axis.range.end > 6.0);
    }

    #[test]
    fn ticks_stand_at_round_values_inside_the_interval() {
        let axis = Axis::exact(-0.013, 0.042, 5);
        let labels: Vec<_> = axis.ticks().iter().map(|&t| axis.label(t)).collect();
        assert_eq!(labels, ["0.00", "0.02", "0.04"]);
        let axis = Axis::time(0.0, 120.0, 7);
        assert_eq!(axis.ticks(), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0]);
        let axis = Axis::degrees(80.0, 101.0, 5);
        assert_eq!(axis.ticks(), [80.0, 85.0, 90.0, 95.0, 100.0]);
    }

    #[test]
    fn angles_read_as_parts_of_pi() {
        use std::f64::consts::PI;
        let axis = Axis::radians(-2.0 * PI, 2.0 * PI, 1);
        let labels: Vec<_> = axis.ticks().iter().map(|&t| axis.label(t)).collect();
        assert_eq!(labels, ["−2π", "−3π/2", "−π", "−π/2", "0", "π/2", "π", "3π/2", "2π"]);
    }

    #[test]
    fn minus_signs_are_true_and_zero_has_none() {
        assert_eq!(number(-0.04, 2), "−0.04");
        assert_eq!(number(-0.0001, 2), "0.00");
        assert_eq!(number(12.0, 0), "12");
    }

    #[test]
    fn a_map_far_from_the_origin_shows_what_it_is_asked_to() {
        let axis = Axis::spaced(1e6 - 0.6, 1e6 + 0.6, 0.2);
        assert!((axis.range.end - axis.range.start - 1.2).abs() < 1e-6, "{:?}", axis.range);
        assert_eq!(axis.label(axis.ticks()[0]), "999999.4");
        // A value that never changes gets an interval all the same.
        let still = Axis::spaced(5.0, 5.0, 0.2).range;
        assert!(still.start < 5.0 && still.end > 5.0);
    }

    #[test]
    fn every_interval_can_be_drawn() {
        for (low, high) in
            [(0.0, 0.0), (5.0, 5.0), (-1e300, 1e300), (f64::NAN, 1.0), (3.0, -3.0), (1e-12, 2e-12)]
        {
            for axis in [Axis::exact(low, high, 5), Axis::padded(low, high, 5), Axis::time(low, high, 5)] {
                let range = axis.range();
                assert!(range.start < range.end, "{low}..{high} gave {range:?}");
                assert!(range.start.is_finite() && range.end.is_finite());
                assert!(axis.ticks().len() <= 12, "{low}..{high} gave {} ticks", axis.ticks().len());
            }
        }
        assert_eq!(extent([f64::NAN, 2.0, -1.0, f64::INFINITY]), Some((-1.0, 2.0)));
        assert_eq!(extent([f64::NAN]), None);
    }
}
