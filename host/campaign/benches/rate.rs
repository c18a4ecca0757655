//! How many runs a second: on one core and on two, turn about, so that a busy machine is busy for both; and a whole thousand.
//!
//! `cargo bench -p campaign` for the ratio, `cargo bench -p campaign -- thousand` for the thousand as well.
//!
//! Beside the time by the clock there is that of the cores, which a busy machine changes little: where a run takes no more of it beside
//! another than alone, two cores have twice the rate.

use std::path::Path;
use std::time::Instant;

use campaign::execute::{Watch, execute};
use campaign::folder::{Folder, Shard};
use campaign::study::Study;
use campaign::table::Format;

/// Turns of each number of cores, and runs of each turn.
const TURNS: usize = 3;
const RUNS: usize = 20;
/// Of the times that Linux tells a process, 1/s.
const TICKS: f64 = 100.0;

struct Quiet;

impl Watch for Quiet {
    fn waits(&self) {}
    fn rows(&self, _: usize, _: usize) {}
}

/// Seconds that all cores together have worked for this process; none where the system does not tell.
fn worked_s() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in brackets: user and system time are fields 14 and 15 of all.
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / TICKS
}

/// Seconds by the clock, and of all cores together, that the runs of `shard` take on `jobs` threads, files and all.
fn took_s(study: &Study, shard: Shard, jobs: usize) -> [f64; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = Folder::of(study, folder.path(), shard.count, Format::Parquet).expect("a folder");
    let (began, worked) = (Instant::now(), worked_s());
    execute(study, &folder, shard, jobs, &Quiet).expect("runs");
    [began.elapsed().as_secs_f64(), worked_s() - worked]
}

fn main() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/campaigns/thousand.toml");
    let study = Study::open(&file).expect("a campaign");
    let count = study.runs() / RUNS;
    // The least of several is what the machine takes when nothing else wants it.
    let mut least_s = [[f64::INFINITY; 2]; 2];
    for turn in 0..TURNS {
        let shard = Shard { index: 1 + turn, count };
        for jobs in [1, 2] {
            let took_s = took_s(&study, shard, jobs);
            least_s[jobs - 1] = [0, 1].map(|which| least_s[jobs - 1][which].min(took_s[which]));
        }
    }
    let [one, two] = least_s.map(|[clock_s, _]| RUNS as f64 / clock_s);
    println!("rate: {one:.2} runs a second on one core, {two:.2} on two, {:.2} times", two / one);
    let [one, two] = least_s.map(|[_, cores_s]| cores_s / RUNS as f64);
    println!(
        "a run takes {one:.3} s of a core alone, {two:.3} s beside another: two cores have {:.2} times the rate",
        2.0 * one / two
    );
    if std::env::args().any(|argument| argument == "thousand") {
        let [clock_s, cores_s] = took_s(&study, Shard::WHOLE, 2);
        println!(
            "{} runs of 90 s with three modules on two cores: {clock_s:.1} s, {cores_s:.1} s of the cores",
            study.runs()
        );
    }
}
