//! The pictures of executed reconfigurations of ROVs, as SVG: one to three plans of the same problem (least energy,
//! shortest path, Flotilla's best) beside each other or over each other.
//!
//! | file | shows |
//! |---|---|
//! | `scene.svg` | the cluster in three dimensions after each move, one row a plan |
//! | `top.svg` | all paths from above, with the order of the moves |
//! | `velocity.svg` | velocities of the movers, slot by slot |
//! | `force.svg` | forces of the movers, restoring moment of the waiting cluster |
//! | `power.svg` | electric power of mover and balancing, energy so far |
//! | `pwm.svg` | pulses of every thruster of every mover |
//!
//! Each picture is a pure function from the records to a text; only [`write_all`] touches the disk.

use std::path::{Path, PathBuf};

use record::reconfigure::Record;

use super::PlotError;

pub mod bodies;
pub mod executed_move;
pub mod floor;
pub mod panels;
pub mod power;
pub mod quantities;
#[cfg(test)]
mod sample;
pub mod scene;
pub mod solid;
pub mod stage;
pub mod step;
pub mod stroke;
pub mod top;

/// Writes every picture of these executed plans of one problem into an existing directory; what became of each, in
/// order. One that cannot be drawn or written does not keep the others from being so.
pub fn write_all(records: &[Record], directory: &Path) -> Vec<Result<PathBuf, PlotError>> {
    let pictures = [
        ("scene.svg", scene::svg(records)),
        ("top.svg", top::svg(records)),
        ("velocity.svg", quantities::velocity(records)),
        ("force.svg", quantities::force(records)),
        ("power.svg", power::svg(records)),
        ("pwm.svg", quantities::pwm(records)),
    ];
    super::write(pictures, directory)
}

#[cfg(test)]
mod tests;
