//! Programs of other makers, in Python: a reader of Parquet, Snakemake, submitit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::program::{PROGRAM, folder, judge, program, said, scheduler, study, whole};

/// The programs of an environment with the packages in it, below `target`; made when they are not there yet.
pub fn programs() -> &'static Path {
    static PROGRAMS: OnceLock<PathBuf> = OnceLock::new();
    PROGRAMS.get_or_init(|| {
        let asked = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("python/requirements.txt"))
            .expect("part of this package");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("campaigns-python");
        let (programs, done) = (folder.join("bin"), folder.join("installed.txt"));
        if fs::read(&done).is_ok_and(|installed| installed == asked) {
            return programs;
        }
        let make = || Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder).output();
        if !make().is_ok_and(|output| output.status.success()) {
            said(Command::new("apt-get").args(["update", "-qq"]));
            said(
                Command::new("apt-get")
                    .args(["install", "-y", "-qq", "python3-venv"])
                    .env("DEBIAN_FRONTEND", "noninteractive"),
            );
            assert!(make().is_ok_and(|output| output.status.success()), "python3 -m venv");
        }
        let wanted = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/requirements.txt");
        let install = ["install", "--quiet", "--disable-pip-version-check", "--requirement"];
        said(Command::new(programs.join("pip")).args(install).arg(wanted));
        fs::write(&done, asked).expect("writes");
        programs
    })
}

/// Rows by pyarrow, as JSON, less what is nothing.
const READ: &str = "
import json, sys
import pyarrow.parquet as parquet
table = parquet.read_table(sys.argv[1])
print(json.dumps([{name: value for name, value in row.items() if value is not None} for row in table.to_pylist()]))
";

#[test]
fn rows_are_the_summaries_of_their_runs_as_pyarrow_reads_them() {
    whole();
    let rows = folder("read").join("rows.parquet");
    fs::write(&rows, whole()).expect("writes");
    let read = said(Command::new(programs().join("python")).args(["-c", READ]).arg(&rows));
    let rows: Vec<Value> = serde_json::from_str(&read).expect("JSON");
    assert_eq!(rows.len(), 200);
    for (number, row) in rows.iter().enumerate() {
        assert_eq!((&row["run"], &row["seed"]), (&json!(number), &json!(1 + number % 50)));
    }
    // One of them by the way of `flotilla run`: a figure of each kind.
    let mut scenario =
        host::run::scenario::Scenario::open(study("short.toml").to_str().expect("UTF-8")).expect("sound");
    scenario.radio.loss = 0.2;
    let summary = host::run::experiment::simulate(&scenario, 8).expect("runs").summary;
    let summary = serde_json::to_value(&summary).expect("JSON");
    let row = &rows[2 * 50 + 7];
    for (column, path) in [
        ("scenario", "/scenario"),
        ("complete", "/complete"),
        ("duration_s", "/duration_s"),
        ("legs.0.mean_m_s.1", "/legs/0/mean_m_s/1"),
        ("cycles.total", "/cycles/total"),
        ("cycles.mean_travel_rad", "/cycles/mean_travel_rad"),
        ("link.1.cycles", "/link/1/cycles"),
        ("faults.lost", "/faults/lost"),
    ] {
        let figure = summary.pointer(path).unwrap_or_else(|| panic!("{path} in {summary}"));
        assert_eq!(&row[column], figure, "{column}");
    }
    assert_eq!((&row["radio.loss"], &row["contacts.count"]), (&json!(0.2), &json!(0)));
    assert!(row.get("wall_s").is_none() && row.get("error").is_none());
}

#[test]
fn shards_run_under_snakemake() {
    let folder = folder("snakemake");
    let config = [
        format!("campaign={PROGRAM}"),
        format!("file={}", study("two-hundred.toml").display()),
        format!("folder={}", folder.display()),
        "shards=4".to_owned(),
    ];
    let mut command = Command::new(programs().join("snakemake"));
    command
        .arg("--snakefile")
        .arg(scheduler("Snakefile"))
        .args(["--cores", "2", "--quiet", "all", "--config"])
        .args(config);
    let output = crate::program::output(command.current_dir(&folder));
    assert!(output.status.success(), "{}", crate::program::both(&output));
    judge(&folder);
}

#[test]
fn a_report_has_every_group_and_its_pictures() {
    let folder = folder("report");
    let file = study("two-hundred.toml");
    // The rows that are there already, with the folder's own account of them.
    said(&mut program(&[&file, &"--out", &folder, &"--jobs", &"2"]));
    judge(&folder);
    let report = said(&mut program(&[&"report", &folder]));
    println!("{report}");
    let json = said(&mut program(&[&"report", &folder, &"--json", &"--figures", &"passed,faults.lost"]));
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["factors"], json!(["radio.loss"]));
    let lost: Vec<(f64, u64)> = json["figures"][1]["groups"]
        .as_array()
        .expect("groups")
        .iter()
        .map(|group| (group["mean"].as_f64().expect("a mean"), group["count"].as_u64().expect("a count")))
        .collect();
    assert_eq!(lost.len(), 4);
    assert!(lost.iter().all(|(_, count)| *count == 50));
    assert!(lost[0].0 == 0.0 && lost.windows(2).all(|two| two[0].0 < two[1].0), "{lost:?}");
    for picture in ["report-passed.svg", "report-legs-0-velocity_error.svg"] {
        let svg = fs::read_to_string(folder.join(picture)).expect(picture);
        assert!(svg.contains("radio.loss") && svg.contains("<circle"), "{picture}");
    }
}
