//! Points that fill a unit cube evenly: Sobol's sequence and Latin hypercubes, both from a seed.
//!
//! | method | what it promises |
//! |---|---|
//! | [`Method::Sobol`] | of the first 2ᵏ points exactly one lies in each of the 2ᵏ equal slices of every dimension, and more in boxes of several |
//! | [`Method::LatinHypercube`] | of n points exactly one lies in each of the n equal slices of every dimension |

use serde::Deserialize;

mod latin;
mod sobol;

/// How points are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Sobol's sequence with a random digital shift.
    #[default]
    Sobol,
    /// A Latin hypercube.
    LatinHypercube,
}

impl Method {
    /// The most dimensions that it can fill.
    #[must_use]
    pub const fn dimensions_max(self) -> usize {
        match self {
            Self::Sobol => sobol::DIMENSIONS,
            Self::LatinHypercube => 1024,
        }
    }

    /// `count` points in [0, 1)ᵈ from `seed`, d being `dimensions`, at most [`dimensions_max`](Self::dimensions_max).
    #[must_use]
    pub fn points(self, count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
        match self {
            Self::Sobol => sobol::points(count, dimensions, seed),
            Self::LatinHypercube => latin::points(count, dimensions, seed),
        }
    }
}
