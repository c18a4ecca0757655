//! Text formats of maps and scenarios.
//!
//! | format | looks like | from |
//! |---|---|---|
//! | `.map` | `type octile`, `height 49`, `width 49`, `map`, then one character a cell | Sturtevant, *Benchmarks for Grid-Based Pathfinding*, 2012 |
//! | `.scen` | `version 1`, then a line a query: bucket, map, width, height, start x, y, goal x, y, octile length | " |
//! | `.3dmap` | `voxel X Y Z`, then `x y z` of every blocked cell | Brewer and Sturtevant, *Benchmarks for Pathfinding in 3D Voxel Space*, 2018 |
//! | `.3dscen` | `version 1`, the map's name, then start x y z, goal x y z, length, its ratio to the straight line | " |
//!
//! Of the characters of a map `.`, `G` and `S` (swamp) are free; `@`, `O`, `T` (trees) and `W` (water) are blocked.
//! Coordinates are cells; in 2D the vertex is the upper left corner of the cell, so each path of a scenario between
//! centres has a twin between corners, and the octile length is one that can be reached.

use thiserror::Error;

use super::plane::Plane;
use super::volume::Volume;
use super::{CELLS_MAX, SIDE_MAX};

/// Why a line of a map or scenario cannot be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadError {
    /// Something else was expected.
    #[error("{line}: {value:?}: {expected} expected")]
    Unexpected { line: usize, value: String, expected: &'static str },
    /// A number that it cannot be.
    #[error("{line}: {what} = {value} cells: must be {must}")]
    Number { line: usize, what: &'static str, value: u64, must: String },
    /// A row or a list that is not as long as it was said to be.
    #[error("{line}: {found} {what}, {wanted} expected")]
    Count { line: usize, what: &'static str, found: usize, wanted: usize },
    /// A place that is not on the map.
    #[error("{line}: {what} {place:?} is outside the map, whose last is {last:?}")]
    Outside { line: usize, what: &'static str, place: Vec<u32>, last: Vec<u32> },
}

/// A query for a path, from a scenario file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query<const N: usize> {
    /// Line of the file, from 1.
    pub line: usize,
    /// From which cell.
    pub start: [u32; N],
    /// To which cell.
    pub goal: [u32; N],
    /// Length of the shortest path from cell to neighbouring cell, in cells.
    pub length: f64,
}

/// Lines with their numbers, the empty ones left out.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(k, line)| (k + 1, line)).filter(|(_, line)| !line.trim().is_empty())
}

/// `value` is cut where it gets too long to read.
fn unexpected(line: usize, value: &str, expected: &'static str) -> ReadError {
    ReadError::Unexpected { line, value: value.chars().take(40).collect(), expected }
}

fn number<T: std::str::FromStr>(line: usize, word: &str, expected: &'static str) -> Result<T, ReadError> {
    word.parse().map_err(|_| unexpected(line, word, expected))
}

/// The words of a line, if there are that many.
fn words<'t, const N: usize>(
    line: usize,
    text: &'t str,
    expected: &'static str,
) -> Result<[&'t str; N], ReadError> {
    // Names of maps may have spaces where the columns are separated by tabs.
    let words: Vec<&str> = match text.contains('\t') {
        true => text.split('\t').map(str::trim).filter(|word| !word.is_empty()).collect(),
        false => text.split_whitespace().collect(),
    };
    words.try_into().map_err(|_| unexpected(line, text, expected))
}

/// Reads a 2D map.
pub fn plane(text: &str) -> Result<Plane, ReadError> {
    let mut rows = text.lines().enumerate().map(|(k, row)| (k + 1, row.trim_end()));
    let (mut width, mut height, mut is_typed) = (None, None, false);
    let mut last = 0;
    for (line, row) in rows.by_ref() {
        last = line;
        let mut words = row.split_whitespace();
        match (words.next(), words.next(), words.next()) {
            (Some("type"), Some("octile"), None) => is_typed = true,
            (Some("height"), Some(side), None) => height = Some(side_of(line, "height", side)?),
            (Some("width"), Some(side), None) => width = Some(side_of(line, "width", side)?),
            (Some("map"), None, None) => break,
            (None, ..) => {}
            _ => return Err(unexpected(line, row, "type octile, height, width or map")),
        }
    }
    let (Some(width), Some(height), true) = (width, height, is_typed) else {
        return Err(unexpected(last.max(1), "", "type octile, height and width before map"));
    };
    let mut free = Vec::new();
    let mut count = 0;
    for (line, row) in rows {
        last = line;
        if count == height as usize && row.is_empty() {
            continue;
        }
        count += 1;
        if count > height as usize {
            return Err(ReadError::Count { line, what: "rows", found: count, wanted: height as usize });
        }
        let found = row.chars().count();
        if found != width as usize {
            return Err(ReadError::Count { line, what: "cells in a row", found, wanted: width as usize });
        }
        for cell in row.chars() {
            free.push(match cell {
                '.' | 'G' | 'S' => true,
                '@' | 'O' | 'T' | 'W' => false,
                _ => return Err(unexpected(line, &cell.to_string(), "one of . G S @ O T W")),
            });
        }
    }
    if count != height as usize {
        return Err(ReadError::Count {
            line: last.max(1),
            what: "rows",
            found: count,
            wanted: height as usize,
        });
    }
    let is_free = |x: u32, y: u32| free[y as usize * width as usize + x as usize];
    Plane::new(width, height, is_free)
        .ok_or_else(|| too_large(last.max(1), u64::from(width) * u64::from(height)))
}

fn too_large(line: usize, value: u64) -> ReadError {
    let must = format!("at most {CELLS_MAX} with a rim of one cell");
    ReadError::Number { line, what: "map", value, must }
}

fn side_of(line: usize, what: &'static str, word: &str) -> Result<u32, ReadError> {
    let value = number::<u64>(line, word, "a whole number")?;
    let fits = u32::try_from(value).ok().filter(|side| (1..=SIDE_MAX).contains(side));
    let must = || format!("between 1 and {SIDE_MAX}");
    fits.ok_or_else(|| ReadError::Number { line, what, value, must: must() })
}

/// Reads a 3D map.
pub fn volume(text: &str) -> Result<Volume, ReadError> {
    const HEADER: &str = "voxel X Y Z";
    let mut lines = lines(text);
    let (line, header) = lines.next().ok_or_else(|| unexpected(1, "", HEADER))?;
    let ["voxel", x, y, z] = words(line, header, HEADER)? else {
        return Err(unexpected(line, header, HEADER));
    };
    let mut size = [0; 3];
    for (side, word) in size.iter_mut().zip([x, y, z]) {
        *side = side_of(line, "side", word)?;
    }
    let cells = size.iter().map(|&side| u64::from(side)).product();
    let mut volume = Volume::new(size).ok_or_else(|| too_large(line, cells))?;
    for (line, text) in lines {
        let place = cell(line, words(line, text, "x y z of a blocked cell")?)?;
        if !volume.block(place) {
            let last = size.map(|side| side - 1).to_vec();
            return Err(ReadError::Outside { line, what: "blocked cell", place: place.to_vec(), last });
        }
    }
    Ok(volume)
}

fn cell<const N: usize>(line: usize, words: [&str; N]) -> Result<[u32; N], ReadError> {
    let mut place = [0; N];
    for (at, word) in place.iter_mut().zip(words) {
        *at = number(line, word, "a whole number")?;
    }
    Ok(place)
}

/// Reads the queries on a 2D map.
///
/// # Errors
/// [`ReadError`] for the first line that is not as it should be, or speaks of a map of another size.
pub fn plane_scenario(text: &str, plane: &Plane) -> Result<Vec<Query<2>>, ReadError> {
    const LINE: &str = "bucket, map, width, height, start x, y, goal x, y, octile length";
    let mut lines = lines(text);
    version(lines.next())?;
    lines
        .map(|(line, text)| {
            let [_, _, width, height, x, y, goal_x, goal_y, length] = words(line, text, LINE)?;
            let of_map = [("width", width, plane.width()), ("height", height, plane.height())];
            for (what, word, side) in of_map {
                let value = number::<u64>(line, word, "a whole number")?;
                if value != u64::from(side) {
                    let must = format!("{side} as in the map");
                    return Err(ReadError::Number { line, what, value, must });
                }
            }
            let last = [plane.width() - 1, plane.height() - 1];
            query(line, [x, y], [goal_x, goal_y], length, last)
        })
        .collect()
}

/// Reads the queries on a 3D map whose last cell is `last`.
pub fn volume_scenario(text: &str, last: [u32; 3]) -> Result<Vec<Query<3>>, ReadError> {
    const LINE: &str = "start x y z, goal x y z, length, ratio";
    let mut lines = lines(text);
    version(lines.next())?;
    // The name of the map.
    lines.next();
    lines
        .map(|(line, text)| {
            let [x, y, z, goal_x, goal_y, goal_z, length, _] = words(line, text, LINE)?;
            query(line, [x, y, z], [goal_x, goal_y, goal_z], length, last)
        })
        .collect()
}

fn version(first: Option<(usize, &str)>) -> Result<(), ReadError> {
    let (line, text) = first.unwrap_or((1, ""));
    let mut words = text.split_whitespace();
    match (words.next(), words.next(), words.next()) {
        (Some("version"), Some("1" | "1.0"), None) => Ok(()),
        _ => Err(unexpected(line, text, "version 1")),
    }
}

fn query<const N: usize>(
    line: usize,
    start: [&str; N],
    goal: [&str; N],
    length: &str,
    last: [u32; N],
) -> Result<Query<N>, ReadError> {
    let (start, goal) = (cell(line, start)?, cell(line, goal)?);
    for (what, place) in [("start", start), ("goal", goal)] {
        if place.iter().zip(&last).any(|(at, last)| at > last) {
            let (place, last) = (place.to_vec(), last.to_vec());
            return Err(ReadError::Outside { line, what, place, last });
        }
    }
    let value: f64 = number(line, length, "a length")?;
    if !value.is_finite() || value < 0.0 {
        return Err(unexpected(line, length, "a length"));
    }
    Ok(Query { line, start, goal, length: value })
}

#[cfg(test)]
mod tests;
