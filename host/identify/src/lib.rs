//! Constants of a Modboat or an ROV from logs of its own runs, and experiments that show them.
//!
//! ```text
//! fixes, tail angles, plans ─→ Prepared ─→ filter(θ) ─→ likelihood ─→ search ─→ θ, intervals, correlations, predictions
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`data`] | what is read of a log |
//! | `binning` | fixes in bins |
//! | [`strokes`] | tail angles → sweeps and directions of strokes, (i1) |
//! | `log` | impulses of all tails, (i2) |
//! | [`constants`] | θ |
//! | `model`, `filter` | motion, (i3)–(i7); extended Kalman filter |
//! | `fit`, `inference`, `estimate` | maximum likelihood, (i8)–(i11); intervals, what is not told apart, (i13), (i14) |
//! | `lag`, [`prediction`] | motor lag, (i12); motion foretold over held-back data |
//! | [`search`](identify), [`outcome`] | all of it |
//! | [`experiment`] | legs that show the constants, (i15) |
//! | [`rov`] | the same of ROVs, (i16)–(i19) |
//!
//! Nothing here knows a clock, a socket, a thread or a console; the same data give the same outcome to the bit.
//!
//! *Grey-box*: the equations are those of the boat, constants and noise come from the data. Sources: L. Ljung, *System Identification*,
//! 2nd ed., chapters 7 (prediction errors, maximum likelihood) and 9 (covariances); F. Ljungberg and M. Enqvist, *Consistent Estimators
//! for Nonlinear Vessel Models*, 2022, on the bias of least squares for v|v| under disturbances.

mod binning;
pub mod constants;
pub mod data;
mod estimate;
pub mod experiment;
mod filter;
mod fit;
mod inference;
mod lag;
mod log;
mod model;
pub mod outcome;
pub mod prediction;
pub mod rov;
mod search;
pub mod strokes;

pub use search::{HELD_BACK, IdentifyError, LEAST_S, identify};
