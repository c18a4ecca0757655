//! `host/docs/planner.svg`: time and error of both planners against the size of structures.

use std::fs;
use std::path::Path;

use modboat::parameters::Parameters;
use modboat::planner_kind::PlannerKind;
use plot::scaling::{Line, svg};
use tests::stream::{Course, Kind, Row, Rows, Sequence, settings};

use crate::{NEAR, SHARE, alone, structure};

/// Structures, and plans of the exact planner and of the potential field.
const SIZES: [(&str, [usize; 2]); 6] = [
    ("3x1", [1000, 500]),
    ("3x3", [1000, 300]),
    ("5x5", [1000, 200]),
    ("10x10", [300, 60]),
    ("20x20", [100, 10]),
    ("32x32", [100, 5]),
];

/// Times are those of the machine that draws it; everything else comes out the same.
#[test]
#[ignore = "writes the picture of the documentation: cargo test -p tests --test planner figure -- --ignored"]
fn figure_time_and_error_against_size() {
    let _alone = alone();
    let kind = Kind::new(Parameters::default());
    let rows = |planner: PlannerKind, index: usize, sequence: Sequence| -> Vec<(usize, Rows)> {
        let sizes = SIZES.iter().map(|&(name, plans)| {
            let (structure, kind, config) = (structure(name), kind.clone(), settings(planner));
            let (modules, walks) = (structure.len(), 5);
            let course = Course {
                structure,
                kind,
                config,
                share: SHARE,
                sequence,
                walks,
                each: plans[index] / walks,
                times: 3,
            };
            (modules, course.run())
        });
        sizes.collect()
    };
    let mut figures = Vec::new();
    for (sequence, titles) in [
        (NEAR, ["Time for a plan, ms: steps of 0.03", "Relative weighted error: steps of 0.03"]),
        (
            Sequence::Apart,
            ["Time for a plan, ms: unrelated demands", "Relative weighted error: unrelated demands"],
        ),
    ] {
        let planners = [PlannerKind::Exact, PlannerKind::PotentialField];
        let rows: Vec<_> =
            planners.iter().enumerate().map(|(k, &planner)| rows(planner, k, sequence)).collect();
        let lines = |of: fn(&Row) -> f64| -> Vec<Line<'_>> {
            let both = |rows: &Rows| {
                let quantiles = rows.quantiles(of);
                [quantiles.median, quantiles.p99]
            };
            let line = |(planner, rows): (&PlannerKind, &Vec<(usize, Rows)>)| {
                let sizes = rows.iter().map(|(modules, rows)| (*modules, both(rows))).collect();
                Line { name: planner.name(), sizes }
            };
            planners.iter().zip(&rows).map(line).collect()
        };
        figures.push((titles[0], lines(|row| 1e-3 * row.plan_us)));
        figures.push((titles[1], lines(|row| row.error)));
    }
    let line =
        "Demands uniform inside 60 % of the envelope; squares (at the left three in a row); one thread";
    let picture = svg(line, &figures).expect("drawn");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/docs/planner.svg");
    fs::write(&file, picture).expect("written");
    println!("{}: {figures:?}", file.display());
}
