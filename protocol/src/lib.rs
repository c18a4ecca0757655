//! What host and modules say to each other: wire types, framing and the [`Radio`] trait.
//!
//! One UDP datagram carries one [`Message`] in postcard, at most [`MAX_DATAGRAM`] bytes, the wire version first
//! ([`frame`] has the layout). This crate runs on the module as well as on the PC: `no_std`, no allocation, no
//! panic on any input.
#![no_std]
#![deny(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used
)]

pub mod frame;
pub mod message;
pub mod radio;
pub mod units;

pub use frame::{DecodeError, EncodeError, Header, MAX_DATAGRAM, Seal, decode, encode};
pub use message::{
    Acknowledge, Cycle, Hello, Message, ModboatCycle, ModuleId, ModuleKind, ModuleState, Motion, Refusal,
    RovCycle, RovTelemetry, Telemetry, TimeReply, TimeRequest, Verdict, WIRE_VERSION,
};
pub use radio::Radio;
