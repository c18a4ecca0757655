//! Where a demand lies in the envelope of a structure: `flotilla plan --envelope`.

use modboat::envelope::{Envelope, ON_BORDER};
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use serde::Serialize;

/// A demand in an envelope.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reply {
    /// 0 for no demand, 1 on the border; `None` where nothing in the demand's direction can be given at all (a torque from one module).
    pub gauge: Option<f64>,
    /// Whether it can be given.
    pub inside: bool,
    /// The farthest wrench in that direction, where there is one.
    pub boundary: Option<Wrench>,
    /// The greatest force and torque along each axis, alike both ways.
    pub extremes: Wrench,
}

impl Reply {
    /// Of one demand.
    #[must_use]
    pub fn new(envelope: &Envelope, demand: Wrench) -> Self {
        let gauge = envelope.gauge(demand);
        Self {
            // JSON has no infinity.
            gauge: gauge.is_finite().then_some(gauge),
            inside: gauge <= ON_BORDER,
            boundary: (gauge > 0.0 && gauge.is_finite()).then(|| envelope.boundary(demand)),
            extremes: extremes(envelope),
        }
    }
}

/// The greatest force and torque along each axis, alike both ways.
#[must_use]
pub fn extremes(envelope: &Envelope) -> Wrench {
    Wrench::from_array(
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|normal| envelope.support(normal)),
    )
}

/// The envelope of modules in these cells.
///
/// # Errors
/// Cells that are no structure.
pub fn envelope(cells: &[[i32; 2]], parameters: &Parameters) -> Result<Envelope, String> {
    let structure = Structure::from_cells(cells).map_err(|error| format!("cells: {error}"))?;
    Ok(Envelope::new(&structure.positions_m(parameters.pitch_m), parameters))
}
