//! What every module executes: fleet clock, schedule, waveform, transition, tail servo, motor bridge on a Modboat;
//! fleet clock, thrust lease, thrust → pulse, output stage on an ROV.
//!
//! `no_std`, no allocation, no panic on any input (NaN included), single precision. The laws of motion exist
//! here and nowhere else; the simulator calls this copy. Nothing in this crate reads a clock or owns a thread:
//! time is always an argument, hardware comes in through `embedded-hal` and the two traits
//! [`Encoder`](encoder::Encoder) and [`CurrentSense`](servo::CurrentSense).
//!
//! ```text
//! datagram → Endpoint<Swimmer> → Schedule ─ reference(now) → TailServo → Bridge → PWM and direction pins
//!               ↑ now: FleetClock                               ↑ pose, rate: TurnCounter ← Encoder
//! datagram → Endpoint<ThrustLease> ─ thrusts(now) → Bank: Esc → law → PWM pins
//! ```
//!
//! Newtypes of [`protocol::units`] stand at the boundary of the crate; inside, `f32` with unit suffixes.
#![no_std]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

#[cfg(test)]
extern crate std;

pub mod clock;
pub mod cycle;
pub mod disturbance;
pub mod encoder;
pub mod endpoint;
pub mod failsafe;
pub mod homing;
pub mod indicator;
pub mod lease;
pub mod limits;
pub mod link;
pub mod modboat;
pub mod motor;
pub mod provision;
pub mod quadrature;
pub mod reference;
pub mod rov;
pub mod schedule;
pub mod servo;
pub mod swimmer;
pub mod tail;
pub mod thruster;
pub mod transition;
pub mod waveform;

#[cfg(test)]
mod bench_host;
#[cfg(test)]
mod plant;
