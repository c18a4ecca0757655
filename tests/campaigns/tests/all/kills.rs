//! A campaign that is killed at random moments and called again, until it is done.

use std::fs;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::program::{folder, program, rows, said, study};

const KILLS: usize = 20;

#[test]
fn a_campaign_that_is_killed_twenty_times_has_the_same_rows() {
    let seed: u64 = std::env::var("FLOTILLA_SEED").map_or(1, |text| text.parse().expect("a number"));
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let file = study("forty.toml");
    for format in ["parquet", "csv"] {
        let (whole, killed) = (folder(&format!("not-killed-{format}")), folder(&format!("killed-{format}")));
        said(&mut program(&[&file, &"--out", &whole, &"--format", &format]));
        let journal = killed.join("rows.journal");
        let mut pieces = 0;
        for _ in 0..KILLS {
            let before = rows(&journal);
            let mut command = program(&[&file, &"--out", &killed, &"--format", &format]);
            let mut child = command.stdout(Stdio::null()).spawn().expect("it starts");
            // After some rows, of which there may be none, and somewhere in the next.
            let more: usize = random.random_range(0..=3);
            while rows(&journal) < before + more && child.try_wait().expect("a child").is_none() {
                thread::sleep(Duration::from_millis(1));
            }
            thread::sleep(Duration::from_secs_f64(random.random_range(0.0..0.1)));
            child.kill().expect("a child of this test");
            child.wait().expect("a child of this test");
            pieces += usize::from(rows(&journal) > before);
        }
        let told = said(&mut program(&[&file, &"--out", &killed, &"--format", &format]));
        println!("seed {seed}, {format}: {KILLS} kills, rows came in {pieces} of the pieces\n{told}");
        assert!(pieces >= 3, "seed {seed}: the kills met nothing: {told}");
        let read = |folder: &std::path::Path| fs::read(folder.join(format!("rows.{format}"))).expect("rows");
        assert!(read(&killed) == read(&whole), "seed {seed}, {format}: other rows than without kills");
        let left: Vec<_> =
            fs::read_dir(&killed).expect("a folder").map(|entry| entry.expect("one").file_name()).collect();
        let journals = left.iter().filter(|name| name.to_string_lossy().ends_with(".journal"));
        assert_eq!(journals.count(), 0, "{left:?}");
    }
}
