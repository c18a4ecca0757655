//! Ranges of numbers that come from outside, the error that refuses one, the wrapping of angles, products of vectors and the edge of
//! the water.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use thiserror::Error;

pub mod bounds;
pub mod vector;

/// The numbers that modules of a fleet can have.
pub const MODULE_IDS: RangeInclusive<u16> = 1..=1024;

/// A number out of the range of its key.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} = {value} {unit}: {reason}")]
pub struct ParameterError {
    /// The field's name, as in the TOML file.
    pub key: &'static str,
    /// What it was set to, in `unit`.
    pub value: f64,
    /// The unit of `value`.
    pub unit: &'static str,
    /// What is asked of it.
    pub reason: &'static str,
}

/// The range of a number in a parameter table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Finite and greater than zero, at most 10⁶.
    Positive,
    /// Finite and zero or greater, at most 10⁶.
    NonNegative,
    /// Finite, of either sign, at most 10⁶ in size.
    Finite,
    /// From zero to one.
    Share,
}

/// Refuses the first `(key, value, unit)` outside its range.
pub fn check_ranges(entries: &[(&'static str, f64, &'static str, Range)]) -> Result<(), ParameterError> {
    for &(key, value, unit, range) in entries {
        let (in_range, reason) = match range {
            Range::Positive => (value > 0.0, "must be a finite number greater than zero"),
            Range::NonNegative => (value >= 0.0, "must be a finite number, zero or greater"),
            Range::Share => ((0.0..=1.0).contains(&value), "must lie between 0 and 1"),
            Range::Finite => (true, "must be a finite number"),
        };
        if !value.is_finite() || !in_range {
            return Err(ParameterError { key, value, unit, reason });
        }
        if value.abs() > 1e6 {
            return Err(ParameterError { key, value, unit, reason: "must be at most 1000000 in size" });
        }
    }
    Ok(())
}

/// Refuses the first `(key, value, unit)` outside its bounds, both included, for the reason given with it.
pub fn check_within(
    entries: &[(&'static str, f64, &'static str, RangeInclusive<f64>, &'static str)],
) -> Result<(), ParameterError> {
    // NaN is within no bounds.
    match entries.iter().find(|(_, value, _, bounds, _)| !bounds.contains(value)) {
        Some(&(key, value, unit, _, reason)) => Err(ParameterError { key, value, unit, reason }),
        None => Ok(()),
    }
}

/// The same direction within (−π, π], rad.
#[must_use]
pub fn wrap_rad(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_into_the_half_open_turn() {
        for (angle, expected) in [(0.0, 0.0), (PI, PI), (-PI, PI), (3.5 * PI, -0.5 * PI), (-7.0, TAU - 7.0)] {
            assert!((wrap_rad(angle) - expected).abs() < 1e-12, "{angle}");
        }
    }
}
