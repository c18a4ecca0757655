//! `flotilla plan --envelope`: the same requests, and for each where its demand lies in the envelope of its structure.
//!
//! A line out: `{"gauge":…,"inside":…,"boundary":{"fx_n":…,"fy_n":…,"tau_nm":…},"extremes":{"fx_n":…,"fy_n":…,"tau_nm":…}}`.
//! `gauge` is 0 for no demand, 1 on the border, and null where nothing in the demand's direction can be given at all (a
//! torque from one module); `boundary` is the farthest wrench in that direction, null where there is none; `extremes` are
//! the greatest force and torque along each axis, alike both ways.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use modboat::envelope::Envelope;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;

use super::request::Request;
use super::{Failure, filter};
use crate::answer::envelope::{self, Reply};

/// No more demands are drawn.
const DRAWN_MAX: usize = 500;

/// What is to be drawn: the first structure, and the demands on it.
struct Shown {
    cells: Vec<[i32; 2]>,
    envelope: Envelope,
    demands: Vec<Wrench>,
}

pub(super) fn main(parameters: &Parameters, plot: Option<&Path>) -> Result<(), Failure> {
    let unwritable = |file: &Path, error: &dyn std::fmt::Display| {
        Failure::Could(format!("{}: cannot write: {error}", file.display()))
    };
    // Found out before the work, not after it.
    let picture = match plot {
        Some(file) => Some((file, File::create(file).map_err(|error| unwritable(file, &error))?)),
        None => None,
    };
    let mut shown = None;
    let outcome = filter::run(|_, line| answer(line, parameters, &mut shown));
    match (picture, shown) {
        (Some((file, mut to)), Some(shown)) => {
            let count = shown.cells.len();
            let name = format!("{count} module{}", if count == 1 { "" } else { "s" });
            let svg = plot::envelope::svg(&name, &shown.envelope, &shown.demands)
                .map_err(|error| unwritable(file, &error))?;
            to.write_all(svg.as_bytes()).map_err(|error| unwritable(file, &error))?;
        }
        (Some((file, _)), None) => {
            // An empty file is no picture.
            let _ = std::fs::remove_file(file);
            outcome?;
            return Err(Failure::Bad(format!("{}: no request, nothing to draw", file.display())));
        }
        (None, _) => {}
    }
    outcome
}

fn answer(line: &str, parameters: &Parameters, shown: &mut Option<Shown>) -> Result<String, String> {
    let Request { cells, demand, .. } = Request::read(line)?;
    let envelope = envelope::envelope(&cells, parameters)?;
    let reply = Reply::new(&envelope, demand);
    let shown = shown.get_or_insert_with(|| Shown { cells: cells.clone(), envelope, demands: Vec::new() });
    if shown.cells == cells && shown.demands.len() < DRAWN_MAX {
        shown.demands.push(demand);
    }
    serde_json::to_string(&reply).map_err(|error| error.to_string())
}
