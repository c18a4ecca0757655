//! The whole system. One program, so that it is linked once; `cargo test -p tests --test all planner::` runs the module `planner`.
//!
//! `allocations` is a program of its own: it counts every allocation in it.

mod any_angle;
mod boats;
mod closed_loop;
mod docking;
mod execution;
mod experiments;
mod frames;
mod hardware_in_loop;
mod house;
mod identify;
mod one_cluster;
mod orders;
mod parallel;
mod planner;
mod plans;
mod reach;
mod reconfigurations;
mod reconfigure_executed;
mod shortest;
mod stops;
mod storms;
mod transitions;
mod turned;
