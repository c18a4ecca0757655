//! Time on two clocks: a module's own, and the fleet's.
//!
//! | type | clock | zero |
//! |---|---|---|
//! | [`LocalInstant`] | a module's own: its quartz, as wrong as that is | its boot |
//! | [`FleetInstant`] | the fleet's: the host's clock, which modules estimate | the host's epoch |
//! | [`Duration`] | either; the clocks differ by at most some 10⁻⁴ in rate | |
//!
//! No conversion leads from one clock to the other: which instant of one an instant of the other is, says only the estimate
//! of the module that asks (`firmware::link::clock`). What mixes them does not compile:
//!
//! ```compile_fail,E0308
//! use protocol::time::{FleetInstant, LocalInstant};
//!
//! let (start, now) = (FleetInstant(1_500_000), LocalInstant(1_000_000));
//! let pause = start.since(now);
//! ```
//!
//! ```compile_fail,E0277
//! use protocol::time::{FleetInstant, LocalInstant};
//!
//! let fleet: FleetInstant = LocalInstant(1_000_000).into();
//! ```
//!
//! On one clock it does:
//!
//! ```
//! use protocol::time::{Duration, FleetInstant};
//!
//! let (start, now) = (FleetInstant(1_500_000), FleetInstant(1_000_000));
//! assert_eq!(start.since(now), Duration(500_000));
//! assert_eq!(now.after(Duration(500_000)), start);
//! ```
//!
//! On the wire each is its number of microseconds.

use serde::{Deserialize, Serialize};

macro_rules! instant {
    ($(#[$doc:meta] $name:ident),+ $(,)?) => {$(
        #[$doc]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub u64);

        impl $name {
            /// The time `span` later; the end of time if that overflows.
            #[must_use]
            pub const fn after(self, span: Duration) -> Self {
                Self(self.0.saturating_add(span.0 as u64))
            }

            /// How long after `earlier` this is; zero if it is not after it, the longest span if it does not fit.
            #[must_use]
            pub fn since(self, earlier: Self) -> Duration {
                Duration(u32::try_from(self.0.saturating_sub(earlier.0)).unwrap_or(u32::MAX))
            }

            /// Seconds as `f64`, for plots and logs.
            #[must_use]
            pub fn as_secs_f64(self) -> f64 {
                self.0 as f64 * 1e-6
            }
        }
    )+};
}

instant! {
    /// An instant of a module's own clock, µs since its boot.
    LocalInstant,
    /// An instant of the fleet's clock, µs since the fleet's epoch.
    FleetInstant,
}

/// A span of time in microseconds, up to 71 minutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Duration(pub u32);

impl Duration {
    /// Seconds as `f32`, for the laws of motion on the module.
    #[must_use]
    pub fn as_secs_f32(self) -> f32 {
        self.0 as f32 * 1e-6
    }
}
