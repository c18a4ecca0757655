//! How many runs a second: on one core and on two, turn about, so that a busy machine is busy for both; and the whole of a thousand.
//!
//! `cargo bench -p campaign` for the ratio, `cargo bench -p campaign -- thousand` for the thousand as well.

use std::path::Path;
use std::time::Instant;

use campaign::execute::{Watch, execute};
use campaign::folder::{Folder, Shard};
use campaign::study::Study;
use campaign::table::Format;

/// Turns of each number of cores, and runs of each turn.
const TURNS: usize = 4;
const RUNS: usize = 40;

struct Quiet;

impl Watch for Quiet {
    fn waits(&self) {}
    fn rows(&self, _: usize, _: usize) {}
}

/// Seconds that the runs of `shard` take on `jobs` threads, files and all.
fn took_s(study: &Study, shard: Shard, jobs: usize) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = Folder::of(study, folder.path(), shard.count, Format::Parquet).expect("a folder");
    let began = Instant::now();
    execute(study, &folder, shard, jobs, &Quiet).expect("runs");
    began.elapsed().as_secs_f64()
}

fn main() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/campaigns/thousand.toml");
    let study = Study::open(&file).expect("a campaign");
    let count = study.runs() / RUNS;
    // The least of several is what the machine takes when nothing else wants it.
    let mut least_s = [f64::INFINITY; 2];
    for turn in 0..TURNS {
        let shard = Shard { index: 1 + turn, count };
        for jobs in [1, 2] {
            least_s[jobs - 1] = least_s[jobs - 1].min(took_s(&study, shard, jobs));
        }
    }
    let [one, two] = least_s.map(|took_s| RUNS as f64 / took_s);
    println!("rate: {one:.2} runs a second on one core, {two:.2} on two, {:.2} times", two / one);
    if std::env::args().any(|argument| argument == "thousand") {
        let whole_s = took_s(&study, Shard::WHOLE, 2);
        println!("{} runs of 90 s with three modules on two cores: {whole_s:.1} s", study.runs());
    }
}
