//! `flotilla path` through the binary: answers, totals, pictures, and one clear line for every mistake.

use std::path::Path;

use crate::common::{Finished, Process};
use serde_json::Value;
use tempfile::{TempDir, tempdir};

const MAP: &str = "type octile\nheight 3\nwidth 4\nmap\n....\n.@@.\n....\n";
const SCEN: &str = "version 1\n0\tm.map\t4\t3\t0\t0\t3\t2\t5.0\n0\tm.map\t4\t3\t0\t0\t0\t0\t0\n";
const VOXELS: &str = "voxel 4 3 2\n1 1 0\n1 1 1\n2 1 0\n2 1 1\n";
const SCEN_3D: &str = "version 1\nm.3dmap\n0 1 0 3 1 0 5.0 1.6\n0 0 0 1 1 1 1.0 1.0\n";

/// A folder with a 2D and a 3D map, and a scenario for each.
fn folder() -> TempDir {
    let folder = tempdir().expect("a folder");
    for (name, text) in [("m.map", MAP), ("m.scen", SCEN), ("m.3dmap", VOXELS), ("m.3dscen", SCEN_3D)] {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

fn flotilla(folder: &Path, arguments: &[&str]) -> Finished {
    let arguments: Vec<_> = ["path"].iter().chain(arguments).copied().collect();
    Process::start(folder, &arguments).finish()
}

/// The answers, without the time that they took.
#[track_caller]
fn answers(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let arguments: Vec<_> = arguments.iter().chain(&["--json"]).copied().collect();
    let finished = flotilla(folder, &arguments);
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
    let parsed = finished.out.iter().map(|line| serde_json::from_str(line).expect("JSON"));
    parsed
        .map(|mut answer: Value| {
            let time = answer.as_object_mut().expect("an object").remove("time_us");
            assert!(time.is_some_and(|time| time.is_u64()));
            answer
        })
        .collect()
}

fn length(answer: &Value) -> f64 {
    answer["length"].as_f64().expect("a length")
}

#[test]
fn each_query_has_a_line() {
    let folder = folder();
    let found = answers(folder.path(), &["m.map", "--scen", "m.scen"]);
    assert_eq!(found.len(), 2);
    // Over the corner (3, 1) of the block: √10 + 1. Over (1, 2) it would be √5 + 2.
    assert!((length(&found[0]) - (10f64.sqrt() + 1.0)).abs() < 1e-12, "{found:?}");
    assert_eq!((&found[0]["start"], &found[0]["goal"]), (&Value::from([0, 0]), &Value::from([3, 2])));
    assert_eq!(found[0]["path"].as_array().map(Vec::len), Some(3));
    assert!(found[0]["expanded"].as_u64().is_some_and(|expanded| expanded > 0));
    assert_eq!((&found[1]["length"], &found[1]["path"]), (&Value::from(0.0), &serde_json::json!([[0, 0]])));
    assert_eq!(answers(folder.path(), &["m.map", "--scen", "m.scen", "--limit", "1"]), found[..1]);
    let single = answers(folder.path(), &["m.map", "--from", "0,0", "--to", "3,2"]);
    assert_eq!(single, found[..1]);
    // Along the moves 3 + √2, the same or less after smoothing.
    let along =
        answers(folder.path(), &["m.map", "--scen", "m.scen", "--algorithm", "a-star", "--limit", "1"]);
    assert!((length(&along[0]) - (3.0 + 2f64.sqrt())).abs() < 1e-12, "{along:?}");
    let smoothed =
        answers(folder.path(), &["m.map", "--from", "0,0", "--to", "3,2", "--algorithm", "a-star-smoothed"]);
    assert!(length(&smoothed[0]) <= length(&along[0]) && length(&smoothed[0]) >= length(&found[0]));
}

#[test]
fn three_dimensions_and_no_path() {
    let folder = folder();
    let found = answers(folder.path(), &["m.3dmap", "--scen", "m.3dscen"]);
    // Around the wall through the row beside it, without cutting its corners: 1 + 3 + 1.
    assert_eq!((length(&found[0]), found[0]["path"].as_array().map(Vec::len)), (5.0, Some(4)));
    // A goal in a block: null, and not an error.
    assert_eq!(
        (&found[1]["length"], &found[1]["path"], &found[1]["expanded"]),
        (&Value::Null, &Value::Null, &0.into())
    );
    std::fs::write(folder.path().join("w.map"), MAP.replace(".@@.", "@@@@")).expect("a file");
    let cut_off = answers(folder.path(), &["w.map", "--from", "0,0", "--to", "0,3"]);
    assert_eq!((&cut_off[0]["length"], &cut_off[0]["path"]), (&Value::Null, &Value::Null));
    assert!(cut_off[0]["expanded"].as_u64().is_some_and(|expanded| expanded > 0), "proved: {cut_off:?}");
}

#[test]
fn a_table_and_a_picture_for_people() {
    let folder = folder();
    let finished = flotilla(folder.path(), &["m.map", "--scen", "m.scen", "--plot", "m.svg"]);
    assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{finished:?}");
    let text = finished.out.join("\n");
    for expected in
        ["m.map: 4 × 3 cells, theta", "0,0", "3,2", "4.162", "5.000", "0.8325", "2, 0 without a path"]
    {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let picture = std::fs::read_to_string(folder.path().join("m.svg")).expect("a picture");
    assert!(picture.starts_with("<svg ") && picture.contains("m.map · paths"));
}

#[test]
fn mistakes_are_one_line_with_file_line_and_value() {
    let folder = folder();
    let bad = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).expect("a file");
    bad("row.map", MAP.replace(".@@.", ".@@").as_bytes());
    bad("cell.map", MAP.replace(".@@.", ".@x.").as_bytes());
    bad("bytes.map", b"type octile\nheight \xff\n");
    bad("size.scen", SCEN.replace("\t4\t3", "\t5\t3").as_bytes());
    bad("far.scen", SCEN.replace("\t3\t2\t5.0", "\t4\t2\t5.0").as_bytes());
    bad("far.3dmap", format!("{VOXELS}0 0 2\n").as_bytes());
    bad("huge.3dmap", b"voxel 60000 60000 60000\n");
    let cases: [(&[&str], &[&str]); 14] = [
        (&["none.map", "--scen", "m.scen"], &["none.map: no such file"]),
        (&["m.map", "--scen", "none.scen"], &["none.scen: no such file"]),
        (&["row.map", "--scen", "m.scen"], &["row.map:6: 3 cells in a row, 4 expected"]),
        (&["cell.map", "--scen", "m.scen"], &["cell.map:6: \"x\"", ". G S @ O T W"]),
        (&["bytes.map", "--scen", "m.scen"], &["bytes.map:2: is not a text in UTF-8"]),
        (&["m.map", "--scen", "size.scen"], &["size.scen:2: width = 5 cells: must be 4"]),
        (&["m.map", "--scen", "far.scen"], &["far.scen:2: goal [4, 2] is outside the map", "[3, 2]"]),
        (&["far.3dmap", "--scen", "m.3dscen"], &["far.3dmap:6: blocked cell [0, 0, 2] is outside"]),
        (
            &["huge.3dmap", "--scen", "m.3dscen"],
            &["huge.3dmap:1: map = 216000000000000 cells: must be at most"],
        ),
        (&["m.map", "--from", "0,0", "--to", "5,0"], &["--to [5, 0]: is outside the map", "[4, 3]"]),
        (&["m.map", "--from", "0,0,0", "--to", "1,0"], &["--from \"0,0,0\": x,y in whole cells expected"]),
        (&["m.map", "--from", "0,nan", "--to", "1,0"], &["--from \"0,nan\""]),
        (&["m.3dmap", "--scen", "m.3dscen", "--plot", "m.svg"], &["--plot: m.3dmap is 3D"]),
        (&["m.map", "--scen", "m.scen", "--plot", "no/m.svg"], &["cannot write to no/m.svg"]),
    ];
    for (arguments, expected) in cases {
        let finished = flotilla(folder.path(), arguments);
        assert_eq!((finished.code, finished.err.len()), (Some(2), 1), "{arguments:?}: {finished:?}");
        assert!(finished.out.is_empty() && finished.err[0].starts_with("flotilla: "), "{finished:?}");
        for part in expected {
            assert!(finished.err[0].contains(part), "{arguments:?}: {part}: {finished:?}");
        }
    }
    // Nothing to do is a mistake of usage.
    assert_eq!(flotilla(folder.path(), &["m.map"]).code, Some(2));
    assert_eq!(flotilla(folder.path(), &["m.map", "--from", "0,0"]).code, Some(2));
    assert!(!folder.path().join("m.svg").exists());
}
