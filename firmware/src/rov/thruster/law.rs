//! Thrust ↔ pulse of one T200, by battery voltage.
//!
//! F(p, V) is linear in p between the rows of the [`t200`](super::t200) table and linear in V between its columns:
//!
//! F(p, V) = (1 − w)·F_low(p) + w·F_high(p),   w = (V − V_low)/2 V
//!
//! Its inverse p(F, V) is the pulse nearest to neutral at which F(·, V) reaches F. Where the table rises from row to
//! row that is the only one, so F(p(F, V), V) = F. Decided here for the rest of it:
//!
//! - In a few rows near full speed thrust falls by up to 0.14 N where the pulse goes on outward (scatter of the
//!   measurement: 10 V 1700 µs, 12 V 1100 and 1896 µs, 14 V 1900 µs, 18 V 1128 µs). The inverse never goes there: a force that was
//!   reached before the fall is given by the earlier pulse, which draws less. Such rows are not inverted to themselves,
//!   but to a pulse nearer to neutral with the same force.
//! - Dead band: rows of zero thrust about 1500 µs (1472–1528 µs at 16 V). Zero is 1500 µs exactly; anything else lands
//!   outside the band, at least [`EDGE_US`] beyond its last row.
//! - A force beyond the table's greatest is answered with the pulse of the greatest.
//!
//! | input | taken as |
//! |---|---|
//! | thrust not a number | zero: neutral |
//! | battery below 10 V, above 20 V | 10 V, 20 V |
//! | battery not a number | 20 V, at which the pulse is nearest to neutral |
//! | pulse beyond 1100–1900 µs | 1100 µs, 1900 µs |
//! | pulse not a number | neutral: no thrust, no current |
//!
//! Clamping the voltage is right on the module, which must do something; planning refuses such a voltage.

use protocol::units::{Amperes, Newtons, PulseMicros, Volts};

use super::t200::{
    COLUMNS, CURRENT_A, FORCE_N, NEUTRAL_ROW, PULSE_MAX_US, PULSE_MIN_US, PULSE_STEP_US, ROWS, VOLTAGE_MAX_V,
    VOLTAGE_MIN_V, VOLTAGE_STEP_V,
};

/// The pulse that stops a thruster.
pub const NEUTRAL: PulseMicros = PulseMicros(1500.0);

/// How far outside the dead band the least thrust lands, µs. Some 0.01 N.
pub const EDGE_US: f32 = 0.0625;

/// The pulse that gives `thrust` (forward positive) at `battery`.
#[must_use]
pub fn pulse(thrust: Newtons, battery: Volts) -> PulseMicros {
    let force_n = libm::fabsf(thrust.0);
    if force_n.is_nan() || force_n <= 0.0 {
        return NEUTRAL;
    }
    let outward = if thrust.0 > 0.0 { 1.0 } else { -1.0 };
    let column = Column::new(&FORCE_N, battery);
    // From neutral outward to the first row that reaches the force.
    let (mut before_n, mut greatest_n, mut greatest_at_us) = (0.0, 0.0, 0.0);
    let mut inner_us = 0.0;
    for step in 1..=NEUTRAL_ROW {
        let row =
            if outward > 0.0 { NEUTRAL_ROW.saturating_add(step) } else { NEUTRAL_ROW.saturating_sub(step) };
        let here_n = outward * column.at(row);
        if here_n >= force_n {
            // p = p_inner + 4 µs·(F − F_inner)/(F_outer − F_inner)
            let along_us = PULSE_STEP_US * (force_n - before_n) / (here_n - before_n);
            let along_us = if before_n > 0.0 { along_us } else { along_us.max(EDGE_US) };
            return PulseMicros(NEUTRAL.0 + outward * (inner_us + along_us));
        }
        inner_us += PULSE_STEP_US;
        before_n = here_n;
        if here_n > greatest_n {
            (greatest_n, greatest_at_us) = (here_n, inner_us);
        }
    }
    PulseMicros(NEUTRAL.0 + outward * greatest_at_us)
}

/// What a propeller gives (forward positive) when its controller has read `pulse` long enough.
#[must_use]
pub fn thrust(pulse: PulseMicros, battery: Volts) -> Newtons {
    Newtons(Column::new(&FORCE_N, battery).between(pulse))
}

/// What its controller draws from the battery then.
#[must_use]
pub fn current(pulse: PulseMicros, battery: Volts) -> Amperes {
    Amperes(Column::new(&CURRENT_A, battery).between(pulse))
}

/// The pulse for a motor whose wires are swapped, or whose propeller is the mirror image: as far to the other side of
/// neutral. Its own inverse.
#[must_use]
pub fn mirrored(pulse: PulseMicros) -> PulseMicros {
    PulseMicros(2.0 * NEUTRAL.0 - pulse.0)
}

/// One column of the table, at any voltage.
struct Column {
    low: &'static [f32; ROWS],
    high: &'static [f32; ROWS],
    share: f32,
}

impl Column {
    fn new(table: &'static [[f32; ROWS]; COLUMNS], battery: Volts) -> Self {
        let volts = if battery.0.is_nan() { VOLTAGE_MAX_V } else { battery.0 };
        let volts = volts.clamp(VOLTAGE_MIN_V, VOLTAGE_MAX_V);
        let [mut low, .., high] = table.each_ref();
        let (mut high, mut low_v) = (high, VOLTAGE_MIN_V);
        for (column, next) in table.iter().zip(table.iter().skip(1)) {
            (low, high) = (column, next);
            if volts <= low_v + VOLTAGE_STEP_V {
                break;
            }
            low_v += VOLTAGE_STEP_V;
        }
        Self { low, high, share: (volts - low_v) / VOLTAGE_STEP_V }
    }

    fn at(&self, row: usize) -> f32 {
        let (Some(low), Some(high)) = (self.low.get(row), self.high.get(row)) else { return 0.0 };
        low + self.share * (high - low)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a clamped pulse is 0 to 200 rows up"
    )]
    fn between(&self, pulse: PulseMicros) -> f32 {
        if pulse.0.is_nan() {
            return 0.0;
        }
        let rows = (pulse.0.clamp(PULSE_MIN_US, PULSE_MAX_US) - PULSE_MIN_US) / PULSE_STEP_US;
        let row = rows as usize;
        let below = self.at(row);
        let share = rows - row as f32;
        // At the last row there is none above, and no share of it.
        if share > 0.0 { below + share * (self.at(row.saturating_add(1)) - below) } else { below }
    }
}

#[cfg(test)]
mod tests;
