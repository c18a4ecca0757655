//! What thrust costs, as the command line names it.

use clap::ValueEnum;
use rov::power::PowerLaw;

use super::super::{Failure, bad};

/// A law of power.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in super::super) enum PowerKind {
    /// The T200's measured table
    Table,
    /// A smooth law through its upper part
    Fitted,
    /// Proportional to the square of thrust, through the table's greatest forward thrust
    Quadratic,
}

impl PowerKind {
    /// As the table of results says it.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Table => "the T200's table",
            Self::Fitted => "the smooth law",
            Self::Quadratic => "the square law",
        }
    }
}

/// The law of that name at a battery's voltage.
///
/// # Errors
/// Nothing is known of the thrusters at this voltage.
pub(in super::super) fn law(kind: PowerKind, battery_v: f64) -> Result<PowerLaw, Failure> {
    let law = match kind {
        PowerKind::Fitted => PowerLaw::fitted(battery_v),
        PowerKind::Table => PowerLaw::table(battery_v),
        PowerKind::Quadratic => PowerLaw::table(battery_v).and_then(|table| {
            let (_, forward_n) = rov::power::limits_n(battery_v)?;
            // P = η u² (10), through the end of the table
            PowerLaw::quadratic(table.power_w(forward_n) / (forward_n * forward_n))
        }),
    };
    law.map_err(bad)
}
