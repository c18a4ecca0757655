//! Thrusters: from a thrust in newtons to the pulse at the pin, and back for the simulator.
//!
//! ```text
//! thrust ─→ Esc: slew, reversal ─→ law: pulse(thrust, battery) ─→ Bank: direction, order, duty ─→ pins
//!                                  law: thrust(pulse, battery) ←─ simulator
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`t200`] | the measured T200, as data |
//! | [`law`] | thrust ↔ pulse by battery voltage |
//! | [`esc`] | what one speed controller may be asked, from instant to instant |
//! | [`bank`] | all thrusters of a module on their pins: arming, order, direction |
//!
//! Assumptions and limits: every thruster is a T200 behind a Basic ESC, at rest in the water it moves: the inflow of a
//! moving vehicle is not counted.

pub mod bank;
pub mod esc;
pub mod law;
pub mod t200;
