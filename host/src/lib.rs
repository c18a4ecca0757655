//! The host of a fleet: plans for everybody, sends each module its cycle, simulates the tank, shows what happened.

pub mod link;
pub mod modboat;
pub mod plot;
pub mod quantity;
pub mod run;
pub mod sim;
