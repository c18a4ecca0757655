//! What was identified, and how well.

use serde::Serialize;

use super::filter::Errors;
use super::prediction::{Foretold, Prediction};

/// What the scale of all forces, masses and drags rests on. Poses show ratios of them only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// The rotor's moment of inertia J is as known: the structure yaws against it with every swing.
    #[default]
    Rotor,
    /// The mean slope of law (2) is as known.
    Thrust,
}

/// One constant with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Constant {
    /// Its name, with its unit at the end as everywhere.
    pub name: String,
    /// Best value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// What was believed before, where anything was.
    pub belief: Option<f64>,
    /// Whether the data show it: the interval is narrower than ±50 %, or than a tenth of what it is measured against.
    pub shown: bool,
}

/// One module.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Module {
    /// Its number.
    pub id: u16,
    /// Slope of its law (2), N/rad.
    pub force_slope_n_rad: Constant,
    /// Its thrust over the mean of all.
    pub gain: Constant,
    /// How late its tail follows its plan, s, and the half width of the interval.
    pub lag_s: Option<[f64; 2]>,
}

/// What these data cannot tell apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Indistinct {
    /// Standard deviation along the direction, in logarithms (0.1 is 10 %) or units of θ.
    pub deviation: f64,
    /// Elements of the direction of length one, the greatest first.
    pub terms: Vec<(String, f64)>,
    /// In words.
    pub text: String,
}

/// How much is left of the poses once they are predicted a bin ahead.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Residuals {
    /// Root mean square of each coordinate: east, north (m) and heading (rad); of ROVs north, east, down, yaw.
    pub rms: Vec<f64>,
    /// Mean square over what the filter expects: 1 where the noise is as it is taken to be.
    pub normalized: Vec<f64>,
    /// Correlation of one with the next: 0 where nothing is left to explain.
    pub correlation: Vec<f64>,
}

impl Residuals {
    /// Of all logs, whose bins have so many coordinates.
    pub(crate) fn of(logs: &[Errors], coordinates: usize) -> Self {
        let mut residuals = Self::default();
        for axis in 0..coordinates {
            let of =
                |values: &[f64]| values.iter().skip(axis).step_by(coordinates).copied().collect::<Vec<f64>>();
            let (mut square, mut normal, mut next, mut count) = (0.0, 0.0, 0.0, 0.0);
            for log in logs {
                let (e, s) = (of(&log.e), of(&log.s));
                let scaled: Vec<f64> = e.iter().zip(&s).map(|(e, s)| e / s.sqrt()).collect();
                square += e.iter().map(|e| e * e).sum::<f64>();
                normal += scaled.iter().map(|e| e * e).sum::<f64>();
                next += scaled.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
                count += e.len() as f64;
            }
            let count = f64::max(count, 1.0);
            residuals.rms.push((square / count).sqrt());
            residuals.normalized.push(normal / count);
            residuals.correlation.push(next / normal.max(1e-12));
        }
        residuals
    }
}

/// Everything.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Length of all, s.
    pub duration_s: f64,
    /// Poses that were used.
    pub fixes: usize,
    /// Mean battery voltage, V: what the thrust was measured at.
    pub battery_v: Option<f64>,
    /// What the scale rests on.
    pub scale: Scale,
    /// In a sentence.
    pub scale_text: String,
    /// Constants of boat and water.
    pub constants: Vec<Constant>,
    /// What needs no scale.
    pub ratios: Vec<Constant>,
    /// Modules by place.
    pub modules: Vec<Module>,
    /// What is not told apart.
    pub indistinct: Vec<Indistinct>,
    /// Names of rows and columns of `correlations`.
    pub correlated: Vec<String>,
    /// Correlations of estimates.
    pub correlations: Vec<Vec<f64>>,
    /// What constants that were fitted to the first part of the logs foretell of the rest.
    pub prediction: Prediction,
    /// One bin ahead.
    pub residuals: Residuals,
    /// Steps of the search.
    pub steps: usize,
    /// Whether it ended by itself.
    pub converged: bool,
    /// What is worth a person's attention.
    pub notes: Vec<String>,
    /// For pictures: predictions over the held-back data, of each log.
    #[serde(skip)]
    pub foretold: Vec<Vec<Foretold>>,
    /// For pictures: time, s, and prediction errors one bin ahead of east, north (m), heading (rad), of each log.
    #[serde(skip)]
    pub errors: Vec<Vec<(f64, [f64; 3])>>,
}

impl Outcome {
    /// The constant of that name.
    #[must_use]
    pub fn constant(&self, name: &str) -> Option<&Constant> {
        self.constants.iter().chain(&self.ratios).find(|constant| constant.name == name)
    }
}
