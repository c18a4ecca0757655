//! A Modboat for the emulator's `mps2-an386`: the drivers, and nothing of what a module does.
//!
//! | module | drives |
//! |---|---|
//! | [`clock`] | microseconds and the tick, on two CMSDK timers |
//! | [`motor`] | bridge, encoder and current sensor of a motor in software |
//! | [`disturbance`] | what goes wrong with these, for tests |
//! | [`pins`] | bare pins, with the least motor behind them that swims |
//! | [`lan9118`] | the Ethernet controller, as a device of smoltcp |
//! | [`network`] | address, UDP |
//! | [`uart`] | lines of text |
//! | [`status_led`] | the status LED |
//! | [`configuration`] | the image that `flotilla provision` wrote |
//! | [`semihosting`] | what only an emulator has: dice of the PC, a status to end with |
//! | [`control`] | the loop that calls the firmware |
//! | [`retained`] | what outlives a reset |
//! | [`steps`] | lock step with a test |
//! | [`stack`] | how deep the stack has been |
#![no_std]

pub mod clock;
pub mod configuration;
pub mod control;
pub mod disturbance;
pub mod lan9118;
pub mod motor;
pub mod network;
pub mod pins;
mod registers;
pub mod retained;
pub mod semihosting;
pub mod stack;
pub mod status_led;
pub mod steps;
pub mod uart;
mod vectors;
