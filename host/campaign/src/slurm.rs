//! Shards as an array of jobs of Slurm: the script, its submission, and how the array stands.
//!
//! A task of the array is one shard. One that is killed and requeued, by Slurm or by an administrator, goes on where its journal ends.
//! What has become of the campaign is read from its folder, not from Slurm's accounts, which many clusters do not keep.
//!
//! The folder has to be on a file system that all nodes share.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use thiserror::Error;

use crate::folder::Folder;
use crate::journal::replace;

/// Why there is no array of jobs.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SlurmError {
    /// A program of Slurm's does not start.
    #[error("{program}: {source}: is Slurm installed here?")]
    Missing { program: &'static str, source: io::Error },
    /// It starts, and refuses.
    #[error("{program}: {said}")]
    Refused { program: &'static str, said: String },
    /// The script cannot be written.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    /// A path that a script cannot hold.
    #[error("{}: a script for Slurm takes no such path: letters, digits and / . _ - + , @ % = : alone", path.display())]
    Path { path: PathBuf },
}

/// What the script runs.
#[derive(Clone, Debug)]
pub struct Script<'a> {
    /// This program.
    pub program: &'a Path,
    /// The campaign's file.
    pub file: &'a Path,
    /// Cores of each task.
    pub jobs: usize,
    /// More options of `sbatch`, such as `--partition=short`.
    pub options: &'a [String],
}

impl Script<'_> {
    /// The script for the shards of `folder`, without which of them.
    ///
    /// # Errors
    /// [`SlurmError::Path`].
    pub fn text(&self, folder: &Folder) -> Result<String, SlurmError> {
        let [program, file, path] = [self.program, self.file, folder.path.as_path()].map(plain);
        let (program, file, path) = (program?, file?, path?);
        let (name, shards, jobs) = (&folder.manifest.campaign, folder.manifest.shards, self.jobs);
        let format = &folder.manifest.format;
        let log = path.replace('%', "%%");
        let options: String = self.options.iter().map(|option| format!("#SBATCH {option}\n")).collect();
        Ok(format!(
            "#!/bin/bash\n\
             # Written by flotilla campaign --slurm. By hand: sbatch --array=1-{shards} slurm.sh\n\
             #SBATCH --job-name={name}\n\
             #SBATCH --ntasks=1\n\
             #SBATCH --cpus-per-task={jobs}\n\
             #SBATCH --requeue\n\
             #SBATCH --open-mode=append\n\
             #SBATCH --output={log}/slurm-%A_%a.log\n\
             {options}\
             exec {program} {file} --shard \"$SLURM_ARRAY_TASK_ID/{shards}\" --out {path} --format {format} \
             --jobs \"${{SLURM_CPUS_PER_TASK:-1}}\"\n"
        ))
    }

    /// Writes the script into `folder` and submits it for the shards `missing`; the number of the job.
    ///
    /// # Errors
    /// [`SlurmError`].
    pub fn submit(&self, folder: &Folder, missing: &[usize]) -> Result<u64, SlurmError> {
        let path = folder.path.join("slurm.sh");
        let text = self.text(folder)?;
        let failed = |path: PathBuf| |source| SlurmError::File { path, source };
        std::fs::write(&path, text).map_err(failed(path.clone()))?;
        let array = format!("--array={}", ranges(missing));
        let arguments = [OsStr::new("--parsable"), OsStr::new(&array), path.as_os_str()];
        let said = run("sbatch", &arguments)?;
        // On a cluster of several the number is followed by the cluster's name.
        let number = said.trim().split(';').next().unwrap_or_default();
        let job: u64 =
            number.parse().map_err(|_| SlurmError::Refused { program: "sbatch", said: said.clone() })?;
        let kept = job_file(folder);
        replace(&kept, |file| io::Write::write_all(file, format!("{job}\n").as_bytes()))
            .map_err(failed(kept.clone()))?;
        Ok(job)
    }
}

/// The job that was submitted last for `folder`.
#[must_use]
pub fn submitted(folder: &Folder) -> Option<u64> {
    std::fs::read_to_string(job_file(folder)).ok()?.trim().parse().ok()
}

fn job_file(folder: &Folder) -> PathBuf {
    folder.path.join("slurm.job")
}

/// How the tasks of `job` that are not over stand: how many in each state.
///
/// # Errors
/// [`SlurmError`]: Slurm does not answer.
pub fn standing(job: u64) -> Result<BTreeMap<String, usize>, SlurmError> {
    let job = job.to_string();
    let arguments = ["--noheader", "--array", "--format=%T", "--jobs", &job].map(OsStr::new);
    let said = match run("squeue", &arguments) {
        // What has been over for a while is forgotten.
        Err(SlurmError::Refused { said, .. }) if said.contains("Invalid job id") => {
            return Ok(BTreeMap::new());
        }
        said => said?,
    };
    Ok(states(&said))
}

fn states(said: &str) -> BTreeMap<String, usize> {
    let mut states = BTreeMap::new();
    for state in said.split_whitespace() {
        *states.entry(state.to_lowercase()).or_insert(0) += 1;
    }
    states
}

fn run(program: &'static str, arguments: &[&OsStr]) -> Result<String, SlurmError> {
    let output = Command::new(program).args(arguments).output();
    let output = output.map_err(|source| SlurmError::Missing { program, source })?;
    let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().replace('\n', "; ");
    if !output.status.success() {
        return Err(SlurmError::Refused { program, said: said(&output.stderr) });
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// A path that neither the shell nor Slurm takes for something else.
fn plain(path: &Path) -> Result<String, SlurmError> {
    let text = path.to_str().unwrap_or_default();
    let fits = |c: char| c.is_ascii_alphanumeric() || "/._-+,@%=:".contains(c);
    if text.is_empty() || !text.chars().all(fits) {
        return Err(SlurmError::Path { path: path.to_owned() });
    }
    Ok(text.to_owned())
}

/// Ascending numbers as Slurm has them: `1,3-5`.
fn ranges(numbers: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for &number in numbers {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => parts.push((number, number)),
        }
    }
    let part = |(first, last): (usize, usize)| {
        if first == last { first.to_string() } else { format!("{first}-{last}") }
    };
    parts.into_iter().map(part).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Manifest;

    #[test]
    fn arrays_and_states_are_as_slurm_has_them() {
        for (numbers, told) in
            [(vec![1, 2, 3, 4], "1-4"), (vec![3], "3"), (vec![1, 3, 4, 5, 9], "1,3-5,9"), (vec![], "")]
        {
            assert_eq!(ranges(&numbers), told);
        }
        let told: Vec<(String, usize)> = states("PENDING\nRUNNING\nPENDING\n").into_iter().collect();
        assert_eq!(told, [("pending".to_owned(), 2), ("running".to_owned(), 1)]);
    }

    #[test]
    fn a_script_holds_plain_paths_alone() {
        let manifest = Manifest {
            campaign: "c".to_owned(),
            fingerprint: String::new(),
            runs: 200,
            shards: 8,
            format: "parquet".to_owned(),
            grid: Vec::new(),
            sampled: Vec::new(),
        };
        let folder = |path: &str| Folder { path: path.into(), manifest: manifest.clone() };
        let options = ["--partition=short".to_owned()];
        let script =
            Script { program: Path::new("/bin/f"), file: Path::new("/c.toml"), jobs: 4, options: &options };
        let text = script.text(&folder("/data/100%")).expect("plain");
        for line in [
            "#SBATCH --output=/data/100%%/slurm-%A_%a.log",
            "#SBATCH --partition=short",
            "#SBATCH --cpus-per-task=4",
            "exec /bin/f /c.toml --shard \"$SLURM_ARRAY_TASK_ID/8\" --out /data/100% --format parquet --jobs \"${SLURM_CPUS_PER_TASK:-1}\"",
        ] {
            assert!(text.lines().any(|found| found == line), "no {line} in\n{text}");
        }
        for path in ["/my data", "/$HOME", "/a'b", "/a;b", ""] {
            assert!(script.text(&folder(path)).is_err(), "{path:?}");
        }
    }
}
