//! Units at crate boundaries and on the wire.
//!
//! Each newtype is one `f32` or one integer in the unit of its name (SI, and microseconds), so that an angle cannot be sent
//! where a force is meant. Inside matrix maths the host uses bare `f64` with unit suffixes instead.

use serde::{Deserialize, Serialize};

macro_rules! scalar {
    ($(#[$doc:meta] $name:ident),+ $(,)?) => {$(
        #[$doc]
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub f32);

        impl $name {
            /// True for everything but NaN and the infinities.
            #[must_use]
            pub fn is_finite(self) -> bool {
                self.0.is_finite()
            }
        }
    )+};
}

scalar! {
    /// An angle in radians, counter-clockwise positive.
    Radians,
    /// An angular velocity in rad/s, counter-clockwise positive.
    RadiansPerSecond,
    /// A force in newtons.
    Newtons,
    /// An electric current in amperes.
    Amperes,
    /// An electric potential in volts.
    Volts,
    /// Width of a servo pulse in microseconds, as an electronic speed controller reads it: 1500 is neutral.
    PulseMicros,
}

/// A point in time in microseconds: since boot on a module's own clock, since the fleet's epoch on the
/// fleet clock. Which of the two is said where it is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Micros(pub u64);

impl Micros {
    /// The time `span` later; the end of time if that overflows.
    #[must_use]
    pub const fn after(self, span: MicrosSpan) -> Self {
        Self(self.0.saturating_add(span.0 as u64))
    }

    /// How long after `earlier` this is; zero if it is not after it, the longest span if it does not fit.
    #[must_use]
    pub fn since(self, earlier: Self) -> MicrosSpan {
        MicrosSpan(u32::try_from(self.0.saturating_sub(earlier.0)).unwrap_or(u32::MAX))
    }

    /// Seconds as `f64`, for plots and logs.
    #[must_use]
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-6
    }
}

/// A duration in microseconds, up to 71 minutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MicrosSpan(pub u32);

impl MicrosSpan {
    /// Seconds as `f32`, for the laws of motion on the module.
    #[must_use]
    pub fn as_secs_f32(self) -> f32 {
        self.0 as f32 * 1e-6
    }
}
