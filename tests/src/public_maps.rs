//! Maps of the public benchmarks of movingai.com: those that the crate `movingai` has among its tests, and any others in the
//! folder that `FLOTILLA_MAPS` names, `x.map` with `x.map.scen`, `x.3dmap` with `x.3dmap.3dscen`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A map and its scenario, as text.
#[derive(Clone, Debug)]
pub struct Benchmark {
    /// Its file's name.
    pub name: String,
    /// The map.
    pub map: String,
    /// The scenario.
    pub scenario: String,
}

/// The folder of the tests of the crate `movingai`, where Cargo has put it.
///
/// # Panics
/// If Cargo does not know where.
#[must_use]
pub fn of_the_crate() -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--offline", "--manifest-path"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"))
        .output()
        .expect("cargo metadata");
    let text = String::from_utf8_lossy(&output.stdout);
    let key = "\"manifest_path\":\"";
    let manifests = text.match_indices(key).filter_map(|(at, _)| text[at + key.len()..].split('"').next());
    let folders = manifests.filter_map(|manifest| Path::new(manifest).parent());
    let is_it =
        |folder: &&Path| folder.file_name().is_some_and(|n| n.to_string_lossy().starts_with("movingai-"));
    folders.into_iter().find(is_it).expect("the crate movingai").join("tests")
}

/// One map of a folder.
///
/// # Panics
/// If it cannot be read.
#[must_use]
pub fn benchmark(folder: &Path, name: &str) -> Benchmark {
    let read = |name: &str| {
        let file = folder.join(name);
        std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
    };
    let ending = if name.ends_with(".3dmap") { ".3dscen" } else { ".scen" };
    Benchmark { name: name.to_owned(), map: read(name), scenario: read(&format!("{name}{ending}")) }
}

/// All maps with that ending in the folder that `FLOTILLA_MAPS` names, in the order of their names; none without it.
///
/// # Panics
/// If the folder cannot be read.
#[must_use]
pub fn of_the_environment(ending: &str) -> Vec<Benchmark> {
    let Some(folder) = std::env::var_os("FLOTILLA_MAPS").map(PathBuf::from) else { return Vec::new() };
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(ending)).collect();
    names.sort();
    names.iter().map(|name| benchmark(&folder, name)).collect()
}

/// A layer of a voxel map (`voxel X Y Z`, then one blocked cell a line) as a 2D map.
///
/// # Panics
/// If the text is no voxel map.
#[must_use]
pub fn layer(voxels: &str, z: usize) -> String {
    let mut lines = voxels.lines().map(|line| {
        let numbers = line.split_whitespace().filter_map(|word| word.parse::<usize>().ok());
        <[usize; 3]>::try_from(numbers.collect::<Vec<_>>()).expect("three numbers")
    });
    let [width, height, _] = lines.next().expect("a header");
    let mut cells = vec![vec![b'.'; width]; height];
    for [x, y, _] in lines.filter(|cell| cell[2] == z) {
        cells[y][x] = b'@';
    }
    let rows: Vec<_> = cells.iter().map(|row| String::from_utf8_lossy(row)).collect();
    format!("type octile\nheight {height}\nwidth {width}\nmap\n{}\n", rows.join("\n"))
}
