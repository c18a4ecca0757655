//! One experiment swum in one process and by two processes over UDP and NatNet: the logs show the same constants.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

use super::number;
use crate::said::done;

/// A boat that is not what the host believes.
const BOAT: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[bounds]\nedge_m = [[-2, -2], [2, -2], [2, 2], [-2, 2]]\n\
                    [[leg]]\nduration_s = 5\nvelocity_m_s = [0.0, 0.0]\nheading_rad = 0.0\n\
                    [tank]\ndrag_sway_n_s2_m2 = 7.0\nmodule_mass_kg = 1.3\ntail_drag_n_m_s2 = 0.00002\ncurrent_m_s = [0.006, -0.004]\n\
                    [tank.thrust]\nmodule_share = [1.1, 0.9, 0.8]\n";

/// Constants of the boat and of the water. What is left out is the noise of the one or the other run: gusts and latency.
const CONSTANTS: [&str; 10] = [
    "drag_sway_n_s2_m2",
    "drag_surge_n_s2_m2",
    "structure_yaw_drag_n_m_s2",
    "mass_sway_kg",
    "mass_surge_kg",
    "structure_inertia_kg_m2",
    "force_slope_n_rad",
    "tail_drag_n_m_s2",
    "current_east_m_s",
    "current_north_m_s",
];

/// Seeds of the runs in one process. All constants of a run share the error of its scale: the mean of some runs has less of it.
const SEEDS: [u32; 4] = [1, 2, 3, 4];

/// The experiment, with what the runs in one process showed.
pub struct Experiment {
    folder: TempDir,
    in_process: Vec<Value>,
}

impl Experiment {
    pub fn new(folder: TempDir) -> Self {
        std::fs::write(folder.path().join("boat.toml"), BOAT).expect("written");
        let experiment =
            done(&flotilla(folder.path(), &["identify", "--experiment", "boat.toml", "--duration", "90"]));
        std::fs::write(folder.path().join("experiment.toml"), experiment).expect("written");
        let in_process = SEEDS.map(|seed| {
            let (seed, out) = (seed.to_string(), format!("in-process-{seed}"));
            done(&flotilla(folder.path(), &["run", "experiment.toml", "--seed", &seed, "--out", &out]));
            constants(folder.path(), &Path::new(&out).join("log.mcap"))
        });
        let in_process = in_process.to_vec();
        // What the body feels of the water's torque on tails is found as it is.
        let (found, half) = mean(&in_process, "tail_drag_n_m_s2");
        assert!((found - 2e-5).abs() < 2.0 * half && half < 1e-6, "{found} ± {half}");
        Self { folder, in_process }
    }

    /// Its scenario.
    pub fn file(&self) -> String {
        self.folder.path().join("experiment.toml").display().to_string()
    }

    /// Whether the log at `path` shows the same: differences within the 95 % interval of differences, of which all share the error of the scale, so
    /// that one run in twenty is beyond; three standard deviations are too much.
    pub fn compare(&self, path: &Path) -> Result<String, String> {
        let natnet = constants(self.folder.path(), path);
        let mut apart = Vec::new();
        for name in CONSTANTS {
            let ((one, own), (other, its)) = (mean(&self.in_process, name), value(&natnet, name));
            let within = own.hypot(its);
            println!(
                "{name:>28}  {one:.6} ± {own:.6} in one process, {other:.6} ± {its:.6} over NatNet: {:.2} of the interval",
                (other - one).abs() / within
            );
            apart.push((other - one).abs() / within);
        }
        let most = apart.into_iter().fold(0.0, f64::max);
        let said = format!("constants apart by at most {most:.2} of their interval");
        if most <= 1.5 { Ok(said) } else { Err(said) }
    }
}

fn flotilla(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_flotilla"));
    command.args(arguments).current_dir(folder).output().expect("it runs")
}

fn constants(folder: &Path, log: &Path) -> Value {
    let told = done(&flotilla(folder, &["identify", &log.display().to_string(), "--json"]));
    serde_json::from_str(&told).expect("JSON")
}

/// The mean of a constant over runs, and half the width of the mean's interval.
fn mean(runs: &[Value], name: &str) -> (f64, f64) {
    let values: Vec<(f64, f64)> = runs.iter().map(|told| value(told, name)).collect();
    let count = values.len() as f64;
    let sum: f64 = values.iter().map(|(value, _)| value).sum();
    let squares: f64 = values.iter().map(|(_, half)| half * half).sum();
    (sum / count, squares.sqrt() / count)
}

/// A constant, and half the width of its interval.
fn value(told: &Value, name: &str) -> (f64, f64) {
    let mut constants = told["constants"].as_array().expect("a list").iter();
    let constant = constants.find(|constant| constant["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    let [low, high] = ["low", "high"].map(|end| number(&constant[end]));
    (number(&constant["value"]), 0.5 * (high - low))
}
