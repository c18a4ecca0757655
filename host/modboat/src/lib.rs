//! Docked Modboats: from a demanded wrench to a collision-free swim cycle and transition for every module.
//!
//! Implements `Z. Qiao, G. Knizhnik, M. Yim, "Holonomic Control of Arbitrary Configurations of Docked
//! Modboats"`; equation numbers are the paper's. Pure: no clock, socket, thread or print.

pub mod attraction;
pub mod bounds;
pub mod buffers;
pub mod control;
pub mod distance;
pub mod distance_table;
pub mod envelope;
pub mod exact;
pub mod motion;
pub mod observer;
pub mod pairs;
pub mod parameters;
pub mod plan;
pub mod planner;
pub mod planner_config;
pub mod planner_kind;
pub mod potential_field;
pub mod reason;
pub mod region;
pub mod repulsion;
pub mod setting;
pub mod shares;
pub mod structure;
pub mod tail;
pub mod transition;
pub mod tube;
pub mod way;
