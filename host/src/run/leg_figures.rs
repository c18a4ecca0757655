//! Figures of one leg of a run.

use serde::Serialize;

/// One leg's figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LegFigures {
    /// Demanded velocity in the world, m/s.
    pub demand_m_s: [f64; 2],
    /// Mean velocity over the last 60 s of the leg, m/s.
    pub mean_m_s: [f64; 2],
    /// ‖mean − demand‖ / ‖demand‖; in m/s where the demand is zero.
    pub velocity_error: f64,
    /// The greatest steady speed that the structure can give along the demand, m/s; null where no speed is asked for.
    pub attainable_m_s: Option<f64>,
    /// For how long the fleet held, s.
    pub held_s: f64,
    /// Demanded heading, rad.
    pub heading_rad: f64,
    /// RMS of the heading error from 20 s after the start of the leg on, rad.
    pub heading_rms_rad: f64,
    /// How the station was kept, where one was to be.
    pub station: Option<StationFigures>,
}

/// How a station was kept, from 20 s after the start of the leg on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StationFigures {
    /// The station, m.
    pub position_m: [f64; 2],
    /// RMS of the distance from it, m.
    pub rms_m: f64,
    /// Greatest distance from it, m.
    pub max_m: f64,
}
