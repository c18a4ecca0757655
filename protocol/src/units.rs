//! Units at crate boundaries and on the wire.
//!
//! Each newtype is one `f32` in the unit of its name (SI, and microseconds of a pulse), so that an angle cannot be sent
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
