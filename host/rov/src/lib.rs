//! The planner of thruster-driven ROVs: pure functions from a start and a goal configuration to moves, their order, times
//! and paths, at least energy.
//!
//! L. Furno, M. Blanke, R. Galeazzi, D. J. Christensen, *Self-reconfiguration of modular underwater robots using an
//! energy heuristic*, IROS 2017, DOI 10.1109/IROS.2017.8206530. Equation numbers are that paper's.
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | η = (x, y, z, φ, θ, ψ) | pose | world, north-east-down; m, rad (ZYX Euler angles) |
//! | ν = (u, v, w, p, q, r) | velocity | body: x forward, y right, z down; m/s, rad/s |
//! | τ = (X, Y, Z, K, M, N) | wrench at the body origin | body; N, N·m |
//! | (x, y, z, ψ) | pose of a planned robot, level | world; m, rad |

pub mod allocation;
pub mod balance;
pub mod clearance;
pub mod cluster;
pub mod conditions;
pub mod configuration;
pub mod configuration_matrix;
pub mod cost_per_metre;
pub mod docking;
pub mod dynamics;
pub mod frame;
pub mod guidance;
pub mod hydrostatics;
pub mod morphology;
pub mod order;
pub mod parallel;
pub mod planner;
pub mod power;
pub mod pricing;
pub mod propulsion;
pub mod response;
pub mod route;
pub mod search_graph;
mod vector;
pub mod water;
