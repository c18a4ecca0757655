//! Electric power of a T200 thruster against its thrust, by three laws.
//!
//! ```text
//! P = η u²                                                                         (10), Quadratic
//! P between the measured points, at a battery voltage                              Table, the program's default
//! P = c₊ uᵖ⁺ forward, c₋ |u|ᵖ⁻ reverse, fitted to the measured points              Fitted
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | u | thrust, positive forward | N |
//! | P | electric power | W |
//! | η | conversion factor | W/N² |
//! | c, p | coefficient and exponent of a direction | W/Nᵖ, 1 |
//!
//! (10) as printed, η|u|u, is negative in reverse; both directions cost. (11), P proportional to the pulse width, is
//! wrong at mid range and is not built: at 16 V the T200 draws 73 W at 1700 µs and 381 W at 1900 µs, not half.
//!
//! **Which law.** The table is what was measured, and the only evidence there is at small thrust. Its current was read
//! to 0.05–0.1 A, 0.8–1.6 W at 16 V: below some 4 N its power is a staircase, 0.8 W for 0.4 N and for 1.0 N alike, and
//! balancing lives there. A propeller at rest in the water takes P ∝ n³, and the table's speed n was read finely:
//! carried down from 4–12 N by n³, the power is nearer to
//! the fitted law than to the table's own steps (a test shows it). Fit: least squares of ln P over ln |u| at each of the
//! table's voltages, all points of at least 4 N. Root mean square of the relative residual at most 3 % up to 16 V, 4 % at
//! 18 V, 7 % at 20 V; at 16 V 0.745·u^1.580 and 0.945·|u|^1.623. Between voltages ln c and p are interpolated linearly.
//!
//! Limits: bollard pull. A thruster that moves through the water gives less; no open-water data are published.

mod t200;

use reconfiguration::vehicle::Vehicle;

/// Least thrust whose power is trusted in the fit, N: five least counts of the current.
const FIT_FROM_N: f64 = 4.0;

/// Why a power law cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PowerError {
    /// No sheet of the table.
    #[error("a battery voltage of {voltage_v} V is outside the thruster's table, 10 to 20 V")]
    Voltage { voltage_v: f64 },
    /// Not positive.
    #[error("the quadratic law needs a positive coefficient, not {coefficient_w_n2} W/N²")]
    Coefficient { coefficient_w_n2: f64 },
}

/// Electric power of a thruster against its thrust.
#[derive(Clone, Debug, PartialEq)]
pub enum PowerLaw {
    /// The paper's law (10), positive both ways.
    Quadratic {
        /// η, W/N².
        coefficient_w_n2: f64,
    },
    /// The measured table at one voltage.
    Table(PowerTable),
    /// Smooth law fitted to the table.
    Fitted {
        /// Forward.
        forward: PowerCurve,
        /// Reverse, of |u|.
        reverse: PowerCurve,
    },
}

/// Power of one direction of thrust, P = c |u|ᵖ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerCurve {
    /// c, W/Nᵖ.
    pub coefficient: f64,
    /// p, above 1, so that the law is convex.
    pub exponent: f64,
}

/// Power over thrust at one voltage, thrust ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerTable {
    points: Vec<t200::Point>,
    /// Corners of the lower convex envelope, the origin among them.
    envelope: Vec<t200::Point>,
}

/// A piece of a convex law: from 0 outwards, so many newtons at so many W/N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Whether it is on the forward side.
    pub forward: bool,
    /// Length, N.
    pub width_n: f64,
    /// Marginal power, W/N of |u|.
    pub slope_w_n: f64,
}

impl PowerLaw {
    /// The paper's law (10), P = η u², with η in W/N².
    ///
    /// # Errors
    /// [`PowerError::Coefficient`] unless it is positive and finite.
    pub fn quadratic(coefficient_w_n2: f64) -> Result<Self, PowerError> {
        if coefficient_w_n2 > 0.0 && coefficient_w_n2.is_finite() {
            Ok(Self::Quadratic { coefficient_w_n2 })
        } else {
            Err(PowerError::Coefficient { coefficient_w_n2 })
        }
    }

    /// The measured table at a battery voltage.
    ///
    /// # Errors
    /// [`PowerError::Voltage`] outside 10–20 V.
    pub fn table(voltage_v: f64) -> Result<Self, PowerError> {
        let mut points = t200::at(voltage_v).ok_or(PowerError::Voltage { voltage_v })?;
        points.sort_by(|a, b| a.thrust_n.total_cmp(&b.thrust_n));
        // One power for one thrust: the zero band, and forces equal to the least count of 0.01 kgf.
        points = points
            .chunk_by(|a, b| b.thrust_n - a.thrust_n < 1e-9)
            .map(|equal| t200::Point {
                thrust_n: equal[0].thrust_n,
                power_w: equal.iter().map(|point| point.power_w).sum::<f64>() / equal.len() as f64,
            })
            .collect();
        Ok(Self::Table(PowerTable { envelope: lower_envelope(&points), points }))
    }

    /// The smooth law at a battery voltage.
    ///
    /// # Errors
    /// [`PowerError::Voltage`] outside 10–20 V.
    pub fn fitted(voltage_v: f64) -> Result<Self, PowerError> {
        let (low, high, share) = t200::around(voltage_v).ok_or(PowerError::Voltage { voltage_v })?;
        let curve = |sign: f64| {
            let [a, b] = [low, high].map(|sheet| fit(&t200::sheets()[sheet].points, sign));
            let mix = |a: f64, b: f64| a + share * (b - a);
            PowerCurve {
                coefficient: mix(a.coefficient.ln(), b.coefficient.ln()).exp(),
                exponent: mix(a.exponent, b.exponent),
            }
        };
        Ok(Self::Fitted { forward: curve(1.0), reverse: curve(-1.0) })
    }

    /// Electric power at a thrust, W. Beyond the thruster's limits the law goes on as it ended.
    #[must_use]
    pub fn power_w(&self, thrust_n: f64) -> f64 {
        match self {
            Self::Quadratic { coefficient_w_n2 } => coefficient_w_n2 * thrust_n * thrust_n,
            Self::Table(table) => table.power_w(thrust_n),
            Self::Fitted { forward, reverse } => {
                let curve = if thrust_n < 0.0 { reverse } else { forward };
                curve.coefficient * thrust_n.abs().powf(curve.exponent)
            }
        }
    }

    /// dP/du of the smooth laws, W/N; `None` for the table.
    pub(super) fn marginal_w_n(&self, thrust_n: f64) -> Option<f64> {
        match self {
            Self::Quadratic { coefficient_w_n2 } => Some(2.0 * coefficient_w_n2 * thrust_n),
            Self::Table(_) => None,
            Self::Fitted { forward, reverse } => {
                let PowerCurve { coefficient: c, exponent: p } =
                    if thrust_n < 0.0 { reverse } else { forward };
                Some(thrust_n.signum() * c * p * thrust_n.abs().powf(p - 1.0))
            }
        }
    }

    /// The thrust whose marginal power is `y` W/N, and how fast it grows with y; `None` for the table.
    pub(super) fn thrust_of_marginal(&self, y: f64) -> Option<(f64, f64)> {
        match self {
            Self::Quadratic { coefficient_w_n2 } => {
                let grows = 0.5 / coefficient_w_n2;
                Some((grows * y, grows))
            }
            Self::Table(_) => None,
            Self::Fitted { forward, reverse } => {
                if y == 0.0 {
                    return Some((0.0, 0.0));
                }
                let PowerCurve { coefficient: c, exponent: p } = if y < 0.0 { reverse } else { forward };
                // c p |u|ᵖ⁻¹ = |y|
                let u = y.signum() * (y.abs() / (c * p)).powf(1.0 / (p - 1.0));
                Some((u, u / (y * (p - 1.0))))
            }
        }
    }

    /// The thrust within limits that is worth most above its power where a newton is worth `marginal` W/N, and that power by the lower convex envelope, W.
    pub(super) fn response(&self, marginal: f64, (low_n, high_n): (f64, f64)) -> (f64, f64) {
        if let Self::Table(table) = self {
            let within = table.envelope.iter().filter(|point| (low_n..=high_n).contains(&point.thrust_n));
            let worth = |point: &t200::Point| marginal * point.thrust_n - point.power_w;
            let best = within.max_by(|a, b| worth(a).total_cmp(&worth(b)));
            return best.map_or((0.0, 0.0), |point| (point.thrust_n, point.power_w));
        }
        let thrust_n =
            self.thrust_of_marginal(marginal).map_or(0.0, |(free_n, _)| free_n.clamp(low_n, high_n));
        (thrust_n, self.power_w(thrust_n))
    }

    /// The lower convex envelope of the table in pieces from zero outwards; none for the smooth laws.
    pub(super) fn pieces(&self) -> Vec<Piece> {
        let Self::Table(table) = self else { return Vec::new() };
        let pieces = table.envelope.windows(2).map(|pair| {
            let width_n = pair[1].thrust_n - pair[0].thrust_n;
            let rise = (pair[1].power_w - pair[0].power_w) / width_n;
            let forward = pair[0].thrust_n >= 0.0;
            Piece { forward, width_n, slope_w_n: if forward { rise } else { -rise } }
        });
        pieces.collect()
    }
}

impl PowerTable {
    fn power_w(&self, thrust_n: f64) -> f64 {
        let above = self.points.partition_point(|point| point.thrust_n < thrust_n);
        let above = above.clamp(1, self.points.len().saturating_sub(1).max(1));
        let (Some(a), Some(b)) = (self.points.get(above - 1), self.points.get(above)) else { return 0.0 };
        let share = (thrust_n - a.thrust_n) / (b.thrust_n - a.thrust_n);
        a.power_w * (1.0 - share) + b.power_w * share
    }
}

/// Greatest thrust both ways at a battery voltage, N: reverse (negative) and forward.
///
/// # Errors
/// [`PowerError::Voltage`] outside 10–20 V.
pub fn limits_n(voltage_v: f64) -> Result<(f64, f64), PowerError> {
    let points = t200::at(voltage_v).ok_or(PowerError::Voltage { voltage_v })?;
    let over = |pick: fn(f64, f64) -> f64| points.iter().map(|point| point.thrust_n).fold(0.0, pick);
    Ok((over(f64::min), over(f64::max)))
}

/// Limits of each of a vehicle's thrusters, N: `limits_n`, or nothing where one is out of order.
pub fn limits_of(vehicle: &Vehicle, limits_n: (f64, f64)) -> impl Iterator<Item = (f64, f64)> + '_ {
    vehicle.thrusters.iter().map(move |thruster| if thruster.failed { (0.0, 0.0) } else { limits_n })
}

/// Least squares of ln P = ln c + p ln |u| over the points of one direction.
fn fit(points: &[t200::Point], sign: f64) -> PowerCurve {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| sign * point.thrust_n >= FIT_FROM_N)
        .map(|point| (point.thrust_n.abs().ln(), point.power_w.ln()))
        .collect();
    let n = logs.len() as f64;
    let (mean_x, mean_y) = logs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = logs.iter().fold((0.0, 0.0), |(xy, xx), (x, y)| {
        (xy + (x - mean_x) * (y - mean_y), xx + (x - mean_x) * (x - mean_x))
    });
    let exponent = xy / xx;
    PowerCurve { coefficient: (mean_y - exponent * mean_x).exp(), exponent }
}

/// Lower convex envelope of points in ascending order and the origin, which stays a corner: nothing costs less than zero.
fn lower_envelope(points: &[t200::Point]) -> Vec<t200::Point> {
    let zero = t200::Point { thrust_n: 0.0, power_w: 0.0 };
    let mut envelope: Vec<t200::Point> = Vec::new();
    let outer = points.iter().filter(|point| point.thrust_n.abs() > 1e-9);
    let (reverse, forward): (Vec<_>, Vec<_>) = outer.copied().partition(|point| point.thrust_n < 0.0);
    for point in reverse.into_iter().chain([zero]).chain(forward) {
        // Andrew's monotone chain: drop corners above the line to the new point.
        while let [.., a, b] = envelope[..]
            && (b.power_w - a.power_w) * (point.thrust_n - a.thrust_n)
                >= (point.power_w - a.power_w) * (b.thrust_n - a.thrust_n)
        {
            envelope.pop();
        }
        envelope.push(point);
    }
    envelope
}

#[cfg(test)]
mod tests;
