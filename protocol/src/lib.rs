//! The link protocol: wire types, framing and the [`Radio`] trait.
//!
//! One UDP datagram carries one [`Message`] in postcard, sealed, at most [`MAX_DATAGRAM`] bytes, the wire version first.
//! This crate runs on the module as well as on the PC: `no_std`, no allocation, no panic on any input.
//!
//! | file | what |
//! |---|---|
//! | [`message`] | what is said |
//! | [`frame`] | one datagram, as a stranger sees it |
//! | [`keys`] | the fleet's secret and what is derived from it |
//! | [`session`] | the one way in: sealing and opening, each number once |
//! | [`window`] | which numbers have come |
//! | [`ledger`] | where every datagram went |
//! | [`time`] | instants of a module's clock and of the fleet's, and spans |
//! | [`units`] | angles, forces, voltages |
//! | [`radio`] | what carries datagrams |
//! | [`configuration`] | what a module is provisioned with |
//!
//! ```text
//! module                                   host
//!   Announce(Nₘ){Hello}  ────────────────→          sealed with the key of this boot
//!            ←──────────────── Call(Nₕ){Called}     sealed with the key of (Nₘ, Nₕ), which the module derives
//!   ToHost{…}            ────────────────→          proves that the module is there now, not a recording of it
//!            ←──────────────── ToModule{…}
//! ```
#![no_std]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

#[cfg(test)]
extern crate std;

pub mod configuration;
pub mod frame;
pub mod keys;
pub mod ledger;
pub mod message;
pub mod radio;
pub mod session;
pub mod time;
pub mod units;
pub mod window;

pub use configuration::{Configuration, ConfigurationError};
pub use frame::{EncodeError, Frame, FrameError, Header, Kind, MAX_DATAGRAM};
pub use keys::{FleetId, FleetKey, ModuleKey, Nonce};
pub use message::{
    Acknowledge, Connectors, Cycle, Delivery, Faults, Health, Hello, Message, ModboatCycle, ModuleId,
    ModuleKind, ModuleState, Motion, Refusal, RovCycle, RovTelemetry, TailUnknown, Telemetry, TimeReply,
    TimeRequest, TransitionLaw, Verdict, WIRE_VERSION,
};
pub use radio::Radio;
pub use session::{Announcer, Session, Side};
