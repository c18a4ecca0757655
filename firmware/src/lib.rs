//! What every module executes: fleet clock, schedule, waveform, transition, tail servo, motor bridge on a Modboat;
//! fleet clock, thrust lease, thrust → pulse, output stage on an ROV.
//!
//! `no_std`, no allocation, no panic on any input (NaN included), single precision. The laws of motion exist
//! here and nowhere else; the simulator calls this copy. Nothing in this crate reads a clock or owns a thread:
//! time is always an argument, hardware comes in through `embedded-hal` and the two traits
//! [`Encoder`](modboat::encoder::Encoder) and [`CurrentSense`](modboat::servo::CurrentSense).
//!
//! ```text
//! datagram → Endpoint<ModboatRobot> → Schedule ─ reference(now) → TailServo → Bridge → PWM and direction pins
//!               ↑ now: FleetClock                               ↑ pose, rate: TurnCounter ← Encoder
//! datagram → Endpoint<ThrustLease> ─ thrusts(now) → Bank: Esc → law → PWM pins
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`module`] | what a board, the simulator and a process call: [`Module`](module::Module) |
//! | [`link`] | session, endpoint, fleet clock and failsafe, the same for every kind |
//! | [`modboat`] | one motor, one tail |
//! | [`rov`] | thrusters |
//! | [`provision`] | from the configuration to a module |
//! | [`indicator`] | what the status LED shows |
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

pub mod indicator;
pub mod link;
pub mod modboat;
pub mod module;
pub mod provision;
pub mod rov;

#[cfg(test)]
mod bench_host;
#[cfg(test)]
mod plant;
