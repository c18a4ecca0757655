//! Learning environments of docked Modboats: batches of simulations in which an action is one cycle of every module.
//!
//! ```text
//! seeds, actions → Batch → workers → Environment → Modules or Mean → observations, rewards, ends
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`settings`] | what an environment is made of |
//! | [`layout`] | observation and action: order, units, frames, bounds |
//! | [`command`] | what all modules do in one step |
//! | [`modules`] | fidelity `module`: the firmware crate on simulated motors in the tank of `flotilla run` |
//! | [`mean`] | fidelity `cycle`: the mean wrench of each cycle, which is what the planner believes |
//! | [`goal`] | what is asked for, drawn by the seed, and what missing it costs |
//! | [`environment`] | one environment: reset, step |
//! | [`baseline`] | the paper's controller with the exact planner or the potential field |
//! | [`batch`] | many environments on all cores |
//! | [`worker`] | a thread that keeps what may not change threads |
//!
//! A step is one decision of the fleet: a transition, as long as its longest turn takes, and one period. It is decided `lead_s` before the
//! cycle before it ends, as the pilot of a run decides, so that what an observation shows is that much older than the cycle that
//! follows from it.

pub mod baseline;
pub mod batch;
pub mod command;
pub mod environment;
pub mod goal;
pub mod layout;
pub mod mean;
pub mod modules;
pub mod settings;
pub mod worker;
