//! `host/docs/planner.svg`: time and error of both planners against the size of structures.
//!
//! Errors are of this code, and every test run asks whether the picture shows them. Times are those of the machine that drew it, kept in
//! `tests/data/planner_times.json`; `cargo test -p tests --test all figure:: -- --ignored` measures them again and draws.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use modboat::parameters::Parameters;
use modboat::planner_kind::PlannerKind;
use plot::scaling::{Line, svg};
use tests::stream::{DemandStream, Kind, Row, Rows, Sequence, on_both_cores, settings};

use super::{NEAR, SHARE, alone, structure};

/// Structures, and plans of the exact planner and of the potential field.
const SIZES: [(&str, [usize; 2]); 6] = [
    ("3x1", [1000, 500]),
    ("3x3", [1000, 300]),
    ("5x5", [1000, 200]),
    ("10x10", [300, 60]),
    ("20x20", [100, 10]),
    ("32x32", [100, 5]),
];
const PLANNERS: [PlannerKind; 2] = [PlannerKind::Exact, PlannerKind::PotentialField];
const SEQUENCES: [(&str, Sequence); 2] = [("steps of 0.03", NEAR), ("unrelated demands", Sequence::Apart)];

/// By sequence and planner: modules, with median and 99th percentile.
type Figures = BTreeMap<String, Vec<(usize, [f64; 2])>>;

fn key(sequence: &str, planner: PlannerKind) -> String {
    format!("{}, {sequence}", planner.name())
}

/// Every stream of the figure, each plan made `times` times, and what `of` says of them.
fn figures<const N: usize>(times: usize, threads: bool, of: [fn(&Row) -> f64; N]) -> [Figures; N] {
    let kind = Kind::new(Parameters::default());
    let mut jobs = Vec::new();
    for (name, sequence) in SEQUENCES {
        for (index, planner) in PLANNERS.into_iter().enumerate() {
            jobs.extend(SIZES.map(|(size, plans)| (name, sequence, planner, size, plans[index])));
        }
    }
    let run =
        |&(_, sequence, planner, size, plans): &(&str, Sequence, PlannerKind, &str, usize)| -> (usize, Rows) {
            let (structure, kind, config, walks) = (structure(size), kind.clone(), settings(planner), 5);
            let modules = structure.len();
            let stream = DemandStream {
                structure,
                kind,
                config,
                share: SHARE,
                sequence,
                walks,
                each: plans / walks,
                times,
            };
            (modules, stream.run())
        };
    let rows: Vec<(usize, Rows)> =
        if threads { on_both_cores(&jobs, run) } else { jobs.iter().map(run).collect() };
    of.map(|of| {
        let mut figures = Figures::new();
        for ((name, _, planner, ..), (modules, rows)) in jobs.iter().zip(&rows) {
            let quantiles = rows.quantiles(of);
            let line = figures.entry(key(name, *planner)).or_default();
            line.push((*modules, [quantiles.median, quantiles.p99]));
        }
        figures
    })
}

fn picture(times: &Figures, errors: &Figures) -> String {
    let mut panels = Vec::new();
    for (name, _) in SEQUENCES {
        for (title, figures) in [("Time for a plan, ms", times), ("Relative weighted error", errors)] {
            let line = |planner: PlannerKind| {
                let sizes = figures.get(&key(name, planner)).cloned().unwrap_or_default();
                Line { name: planner.name(), sizes }
            };
            panels.push((format!("{title}: {name}"), PLANNERS.map(line).to_vec()));
        }
    }
    let panels: Vec<(&str, Vec<Line<'_>>)> =
        panels.iter().map(|(title, lines)| (title.as_str(), lines.clone())).collect();
    let line =
        "Demands uniform inside 60 % of the envelope; squares (at the left three in a row); one thread";
    svg(line, &panels).expect("drawn")
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

const TIMES: &str = "tests/data/planner_times.json";
const PICTURE: &str = "host/docs/planner.svg";

/// Rounding of another machine's sines may move a point of an error that is rounding itself: coordinates may be that far
/// off, in the picture's units of a quarter of a pixel.
const OFF: f64 = 40.0;

/// The first place where two pictures differ.
fn difference<'a>(stored: &'a str, drawn: &'a str) -> Option<(&'a str, &'a str)> {
    let words = |text: &'a str| -> Vec<&'a str> {
        text.split([' ', '"', ',', '\n', '<', '>', '=']).filter(|word| !word.is_empty()).collect()
    };
    let (stored, drawn) = (words(stored), words(drawn));
    if stored.len() != drawn.len() {
        return Some(("another number of words", "than stored"));
    }
    let same = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= OFF,
        _ => a == b,
    };
    stored.into_iter().zip(drawn).find(|(stored, drawn)| !same(stored, drawn))
}

#[test]
fn figure_shows_the_errors_of_this_code() {
    let _alone = alone();
    let [errors] = figures(1, true, [|row| row.error]);
    let times = fs::read_to_string(file(TIMES)).expect(TIMES);
    let times: Figures = serde_json::from_str(&times).expect(TIMES);
    let stored = fs::read_to_string(file(PICTURE)).expect(PICTURE);
    let drawn = picture(&times, &errors);
    let different = difference(&stored, &drawn);
    assert!(
        different.is_none(),
        "{PICTURE} is out of date ({different:?}): cargo test -p tests --test all figure:: -- --ignored\n{errors:?}"
    );
    let moved = picture(&times, &times);
    assert!(difference(&stored, &moved).is_some(), "a picture of something else is taken for this one");
}

#[test]
#[ignore = "writes the picture of the documentation: cargo test -p tests --test all figure:: -- --ignored"]
fn figure_time_and_error_against_size() {
    let _alone = alone();
    let [times, errors] = figures(3, false, [|row| (1e3 * row.plan_us).round() * 1e-6, |row| row.error]);
    let json = serde_json::to_string_pretty(&times).expect("JSON");
    fs::write(file(TIMES), json + "\n").expect("written");
    fs::write(file(PICTURE), picture(&times, &errors)).expect("written");
    println!("{PICTURE}: {times:?}\n{errors:?}");
}
