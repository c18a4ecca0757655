//! `flotilla path`: shortest paths on a map, for one query or a scenario of them.
//!
//! With `--json` one line a query; `length` and `path` are null where there is no way, which is proved and not given up.

use std::fs::File;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use grid::Map;
use grid::any_angle::Shortest;
use grid::plane::Plane;
use grid::read::{self, Query, ReadError};
use grid::volume::Volume;
use reader::file::{MADE_MAX, text_of};

use super::progress::Bar;
use super::{Failure, bad, could, written};
use crate::answer::route::{Algorithm, Answer, Scratch, ask};
use crate::run::progress::Progress;

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla path arena.map --scen arena.map.scen --json\n  \
                        flotilla path arena.map --from 1,11 --to 40,3 --plot arena.svg\n  \
                        flotilla path A1.3dmap --scen A1.3dmap.3dscen --limit 10\n\n\
                        2D: vertices are the corners of cells, [x, y] the upper left one of cell x, y. 3D: the centres.\n\
                        Lengths are in cells.")]
#[command(group = clap::ArgGroup::new("what").required(true).multiple(true).args(["scen", "from"]))]
pub(super) struct Arguments {
    /// A MovingAI .map, or a voxel map (voxel X Y Z)
    map: PathBuf,
    /// Queries: a MovingAI .scen or .3dscen
    #[arg(long, value_name = "SCEN", conflicts_with_all = ["from", "to"])]
    scen: Option<PathBuf>,
    /// Start of a single query: x,y or x,y,z
    #[arg(long, value_name = "PLACE", requires = "to")]
    from: Option<String>,
    /// Goal of a single query
    #[arg(long, value_name = "PLACE", requires = "from")]
    to: Option<String>,
    /// How to search
    #[arg(long, value_enum, default_value_t = Algorithm::AnyAngle)]
    algorithm: Algorithm,
    /// No more than the first N queries of the scenario
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// One JSON line a query
    #[arg(long)]
    json: bool,
    /// Draw a 2D map with the paths
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let text = text(&arguments.map)?;
    let of_map = |error: ReadError| in_file(&arguments.map, &error);
    if text.split_whitespace().next() == Some("voxel") {
        if arguments.plot.is_some() {
            return Err(Failure::Bad(format!("--plot: {} is 3D; 2D maps only", arguments.map.display())));
        }
        let volume = read::volume(&text).map_err(of_map)?;
        let queries = queries(arguments, &volume, |text| read::volume_scenario(text, volume.last()))?;
        return answer(arguments, &volume, &queries, &size_3d(&volume), |_| Ok(()));
    }
    let plane = read::plane(&text).map_err(of_map)?;
    let queries = queries(arguments, &plane, |text| read::plane_scenario(text, &plane))?;
    // Found out before the work, not after it.
    let mut picture = match &arguments.plot {
        Some(file) => Some((file, File::create(file).map_err(|error| unwritable(file, &error))?)),
        None => None,
    };
    let size = format!("{} × {} cells", plane.width(), plane.height());
    answer(arguments, &plane, &queries, &size, |answers| match &mut picture {
        Some((file, to)) => draw(arguments, &plane, answers, to).map_err(|error| unwritable(file, &error)),
        None => Ok(()),
    })
}

fn size_3d(volume: &Volume) -> String {
    let [x, y, z] = volume.last().map(|last| last + 1);
    format!("{x} × {y} × {z} cells")
}

/// The whole of a text file.
fn text(file: &Path) -> Result<String, Failure> {
    let text = text_of(file, MADE_MAX).map_err(bad)?;
    text.ok_or_else(|| Failure::Bad(format!("{}: no such file", file.display())))
}

fn in_file(file: &Path, error: &ReadError) -> Failure {
    Failure::Bad(format!("{}:{error}", file.display()))
}

fn unwritable(file: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Bad(format!("cannot write to {}: {error}", file.display()))
}

/// What is asked, and how long the scenario says the shortest path from cell to cell is.
struct Question<const N: usize> {
    start: [u32; N],
    goal: [u32; N],
    known: Option<f64>,
}

fn queries<const N: usize>(
    arguments: &Arguments,
    map: &impl Map<N>,
    read: impl Fn(&str) -> Result<Vec<Query<N>>, ReadError>,
) -> Result<Vec<Question<N>>, Failure> {
    let limit = arguments.limit.unwrap_or(usize::MAX);
    let mut questions = Vec::new();
    if let Some(file) = &arguments.scen {
        let queries = read(&text(file)?).map_err(|error| in_file(file, &error))?;
        let asked = |q: Query<N>| Question { start: q.start, goal: q.goal, known: Some(q.length) };
        questions.extend(queries.into_iter().take(limit).map(asked));
    }
    if let (Some(from), Some(to)) = (&arguments.from, &arguments.to) {
        let (start, goal) = (place("--from", from, map)?, place("--to", to, map)?);
        questions.push(Question { start, goal, known: None });
    }
    Ok(questions)
}

/// A place on the map from its words.
fn place<const N: usize>(option: &str, words: &str, map: &impl Map<N>) -> Result<[u32; N], Failure> {
    let numbers: Option<Vec<u32>> = words.split(',').map(|word| word.trim().parse().ok()).collect();
    let place: Option<[u32; N]> = numbers.and_then(|numbers| numbers.try_into().ok());
    let shown = if N == 2 { "x,y" } else { "x,y,z" };
    let place =
        place.ok_or_else(|| Failure::Bad(format!("{option} {words:?}: {shown} in whole cells expected")))?;
    match map.vertex(place) {
        Some(_) => Ok(place),
        None => Err(Failure::Bad(format!(
            "{option} {place:?}: is outside the map, whose last is {:?}",
            map.last()
        ))),
    }
}

/// Answers all queries; `done` gets what was found.
fn answer<const N: usize>(
    arguments: &Arguments,
    map: &impl Shortest<N>,
    questions: &[Question<N>],
    size: &str,
    done: impl FnOnce(&[Answer]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut scratch = Scratch::new();
    let mut answers = Vec::with_capacity(questions.len());
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    // A bar between the lines of its own answers would be in their way.
    let mut bar = (!arguments.json || !std::io::stdout().is_terminal()).then(|| Bar::new("path"));
    for (index, question) in questions.iter().enumerate() {
        if let Some(bar) = bar.as_mut().filter(|_| index % 16 == 0) {
            bar.preparing(
                &format!("{index} of {} queries", questions.len()),
                index as u64,
                questions.len() as u64,
            );
        }
        let answer = ask(arguments.algorithm, &mut scratch, map, question.start, question.goal);
        if arguments.json {
            let line = serde_json::to_string(&answer).map_err(could)?;
            let outcome = writeln!(out, "{line}");
            let is_gone = outcome.is_err();
            written(outcome)?;
            if is_gone {
                return Ok(());
            }
        }
        answers.push(answer);
    }
    drop(bar);
    if !arguments.json {
        written(table(&mut out, arguments, size, questions, &answers))?;
    }
    written(out.flush())?;
    done(&answers)
}

/// The answers and their totals, for a person.
fn table<const N: usize>(
    out: &mut impl Write,
    arguments: &Arguments,
    size: &str,
    questions: &[Question<N>],
    answers: &[Answer],
) -> std::io::Result<()> {
    let name = arguments.algorithm.to_possible_value().map(|value| value.get_name().to_owned());
    writeln!(out, "{}: {size}, {}", arguments.map.display(), name.unwrap_or_default())?;
    writeln!(out)?;
    let grid = if N == 2 { "octile" } else { "given" };
    writeln!(
        out,
        "  {:>17}  {:>17}  {:>10}  {grid:>10}  {:>6}  {:>4}  {:>9}  {:>9}",
        "start", "goal", "length", "ratio", "legs", "expanded", "µs"
    )?;
    let (mut sum, mut known_sum, mut unreachable) = (0.0, 0.0, 0);
    for (question, answer) in questions.iter().zip(answers) {
        let words = |place: &[u32]| place.iter().map(u32::to_string).collect::<Vec<_>>().join(",");
        write!(out, "  {:>17}  {:>17}", words(&answer.start), words(&answer.goal))?;
        let known = question.known;
        let given = known.map_or_else(String::new, |known| format!("{known:.3}"));
        match answer.length {
            Some(length) => {
                let known = known.filter(|&known| known > 0.0);
                let ratio = known.map_or_else(String::new, |known| format!("{:.4}", length / known));
                sum += known.map_or(0.0, |_| length);
                known_sum += known.unwrap_or(0.0);
                write!(out, "  {length:>10.3}  {given:>10}  {ratio:>6}")?;
            }
            None => {
                unreachable += 1;
                write!(out, "  {:>10}  {given:>10}  {:>6}", "no path", "")?;
            }
        }
        let legs = answer.path.as_ref().map_or(0, |path| path.len().saturating_sub(1));
        writeln!(out, "  {legs:>4}  {:>9}  {:>9}", answer.expanded, answer.time_us)?;
    }
    let expanded: usize = answers.iter().map(|answer| answer.expanded).sum();
    let time_us: u64 = answers.iter().map(|answer| answer.time_us).sum();
    writeln!(out)?;
    writeln!(out, "  queries    {}, {unreachable} without a path", answers.len())?;
    if known_sum > 0.0 {
        writeln!(out, "  length     {sum:.3} cells against {known_sum:.3}: {:.4}", sum / known_sum)?;
    }
    let rate = expanded as f64 / (time_us.max(1) as f64 * 1e-6);
    writeln!(out, "  search     {expanded} expanded in {:.3} s: {rate:.3e} a second", time_us as f64 * 1e-6)
}

fn draw(
    arguments: &Arguments,
    plane: &Plane,
    answers: &[Answer],
    to: &mut File,
) -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<Vec<[u32; 2]>> = answers
        .iter()
        .filter_map(|answer| answer.path.as_ref())
        .map(|path| path.iter().filter_map(|place| place.as_slice().try_into().ok()).collect())
        .collect();
    let name = arguments.map.file_name().map(|name| name.to_string_lossy().into_owned());
    let line = format!(
        "{} × {} cells, {} of {} queries with a path",
        plane.width(),
        plane.height(),
        paths.len(),
        answers.len()
    );
    let svg = plot::path::svg(&name.unwrap_or_default(), line, plane, &paths)?;
    to.write_all(svg.as_bytes())?;
    Ok(())
}
