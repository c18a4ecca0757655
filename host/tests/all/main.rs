//! The program as its users meet it. One test program, so that it is linked once; `cargo test -p host --test all run::` runs the module
//! `run`.
//!
//! `network` is a program of its own: it wants root, for namespaces of the network, and runs itself as the relay in one of them.

mod bad_input;
mod blind;
mod bounds;
mod common;
mod compare;
mod console;
mod cores;
mod distance_table;
mod documentation;
mod envelope;
mod identify;
mod interrupt;
mod keygen;
mod keys;
mod logs;
mod operator;
mod path;
mod pilot_phases;
mod plan;
mod ports;
mod provision;
mod reconfigure;
mod reconfigure_parallel;
mod rov_udp;
mod run;
mod said;
mod scenario_readme;
mod shortfalls;
mod simulate;
mod stalls;
mod starts;
mod tank;
mod tank_rovs;
mod terminal;
mod trials;
mod truth;
mod udp;
mod weak_module;
