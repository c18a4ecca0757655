//! The firmware in the emulator: what it costs, that it swims as in the simulator, and what it does about faults and liars.

mod budgets;
mod closed_loop;
mod core;
mod faults;
mod provisioned;
mod refusals;
mod supervision;
mod swim;
