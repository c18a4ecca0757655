//! The pictures of a run, as SVG.
//!
//! | file | shows |
//! |---|---|
//! | `trajectory.svg` | path and poses in the world, velocity and heading against their demands |
//! | `wrench.svg` | the wrench of every cycle: demanded, planned, achieved |
//! | `tails.svg` | tail angles over time |
//! | `phase-space.svg` | the run's swim cycles around the collision regions |
//!
//! Those of a comparison of planners, `trajectories.svg` and `heading.svg`, are in [`compare`], figures of a campaign in [`campaign`].
//! Beside a run's there are the picture of a map with paths, [`path`], that of the wrenches a structure can give,
//! [`envelope`], that of planners against the size of structures, [`scaling`], those of identified constants, [`identified`], and those of
//! a reconfiguration of ROVs, [`reconfigure`].
//!
//! Each picture is a pure function from the record to a text; only [`write_all`] touches the disk.

use std::path::{Path, PathBuf};

use thiserror::Error;

use self::compare::Compared;
use modboat::region::CollisionRegion;
use modboat::tail::Tail;
use phase_space::NeighbourKind;
use record::RunRecord;

pub mod axis;
pub mod campaign;
pub mod compare;
pub mod envelope;
pub mod identified;
pub mod lines;
pub mod path;
pub mod phase_space;
pub mod picture;
pub mod reconfigure;
#[cfg(test)]
mod sample;
pub mod scaling;
pub mod style;
pub mod tails;
pub mod trajectory;
pub mod wrench;

/// Why a picture could not be made.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PlotError {
    /// The picture could not be drawn.
    #[error("{}: cannot draw: {reason}", file.display())]
    Draw { file: PathBuf, reason: String },
    /// The file could not be written.
    #[error("{}: cannot write: {source}", file.display())]
    Write { file: PathBuf, source: std::io::Error },
}

/// Writes every picture of a run into an existing directory; what became of each, in order. One that cannot be drawn or written does
/// not keep the others from being so.
pub fn write_all(record: &RunRecord, directory: &Path) -> Vec<Result<PathBuf, PlotError>> {
    let kinds = neighbour_kinds(record);
    let pictures = [
        ("trajectory.svg", trajectory::svg(record)),
        ("wrench.svg", wrench::svg(record)),
        ("tails.svg", tails::svg(record)),
        ("phase-space.svg", phase_space::svg(record, &kinds)),
    ];
    write(pictures, directory)
}

/// Writes the pictures of a comparison into an existing directory; what became of each, in order.
pub fn write_comparison(compared: &Compared<'_>, directory: &Path) -> Vec<Result<PathBuf, PlotError>> {
    let pictures =
        [("trajectories.svg", compare::trajectories(compared)), ("heading.svg", compare::headings(compared))];
    write(pictures, directory)
}

/// Writes pictures by their names into an existing directory; what became of each, in order.
fn write(
    pictures: impl IntoIterator<Item = (&'static str, Result<String, picture::DrawError>)>,
    directory: &Path,
) -> Vec<Result<PathBuf, PlotError>> {
    pictures.into_iter().map(|(name, picture)| write_named(name, picture, directory)).collect()
}

fn write_named(
    name: &str,
    picture: Result<String, picture::DrawError>,
    directory: &Path,
) -> Result<PathBuf, PlotError> {
    let file = directory.join(name);
    let svg = picture.map_err(|e| PlotError::Draw { file: file.clone(), reason: e.to_string() })?;
    std::fs::write(&file, svg).map_err(|source| PlotError::Write { file: file.clone(), source })?;
    Ok(file)
}

/// The kinds of neighbours with tails that can touch, with their collision regions.
fn neighbour_kinds(record: &RunRecord) -> Vec<NeighbourKind> {
    let tail = Tail::new(&record.parameters);
    let region = |offset| CollisionRegion::new(&tail, offset).polygons().to_vec();
    tail.reachable_offsets()
        .into_iter()
        .map(|offset| NeighbourKind { offset, region: region(offset) })
        .collect()
}

#[cfg(test)]
mod tests;
