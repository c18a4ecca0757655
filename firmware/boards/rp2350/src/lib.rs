//! What both boards with an RP2350 share: everything between the chip and the `firmware` crate but the pins and the network.
//!
//! | file | what |
//! |---|---|
//! | `configuration` | the configuration in flash |
//! | `random` | what is drawn at boot |
//! | `supply` | battery and current, on the analogue inputs |
//! | `status_led` | the status LED |
//! | `watchdog` | resets the chip when the control loop is stuck, or gave up |
//! | `control` | the control loop, and what runs in its place without a configuration |
//! | `priority` | where the control loop runs, above everything else |
//! | `timer` | a PWM slice for a rate of pulses |
//! | `link` | datagrams between the network and the control loop |
//! | `encoder` | the encoder that [`counter`] counts |
//! | [`counter`] | the program that counts the edges of an encoder |
//! | [`frame`] | the timer's divider and top for a rate of frames |
//! | [`hardware_address`] | the address of a board that has none |
//! | [`low_pass`] | a filter |
//!
//! ```text
//! thread mode    network ─→ Link ─→ ┐            ┌ ─→ Link ─→ network
//! interrupt                         └→ control ─→┘   every interval: supply → tick → outputs, status LED, watchdog
//! ```
//!
//! The files in the lower half of the table know no hardware and are tested on the PC (`cargo test --package rp2350`).
//!
//! Assumptions and limits: one of the two cores is used. Whatever panics or faults resets the chip, and with that every output.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod counter;
pub mod frame;
pub mod hardware_address;
pub mod low_pass;

#[cfg(target_os = "none")]
pub mod configuration;
#[cfg(target_os = "none")]
pub mod control;
#[cfg(target_os = "none")]
pub mod encoder;
#[cfg(target_os = "none")]
pub mod link;
#[cfg(target_os = "none")]
pub mod priority;
#[cfg(target_os = "none")]
pub mod random;
#[cfg(target_os = "none")]
pub mod status_led;
#[cfg(target_os = "none")]
pub mod supply;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod watchdog;
