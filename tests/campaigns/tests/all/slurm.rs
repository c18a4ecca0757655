//! A real Slurm on this machine: 200 runs in 8 shards, of which one is killed and requeued in its midst.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::program::{PROGRAM, folder, judge, program, rows, said, scheduler, study};
use crate::python::programs;

/// How long the whole of a job may take: the test fails then, and nothing is left behind. Many times what it takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(900);
/// The shard that is killed.
const KILLED: usize = 3;

/// One at a time: ports and the munge daemon are the machine's.
static ONE: Mutex<()> = Mutex::new(());

/// A cluster of one node, while this is there.
struct Cluster {
    folder: PathBuf,
    _one: MutexGuard<'static, ()>,
}

impl Cluster {
    fn start(name: &str) -> Self {
        let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        // Paths of sockets are short.
        let folder = std::env::temp_dir().join(format!("flotilla-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("writable");
        let cluster = Self { folder, _one: one };
        cluster.call("start");
        cluster
    }

    fn call(&self, wish: &str) {
        // What goes on in the background keeps no pipe open.
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("cluster");
        let status =
            Command::new(script).arg(wish).arg(&self.folder).stdout(Stdio::null()).status().expect("bash");
        assert!(status.success(), "tests/campaigns/cluster {wish}: {status}");
    }

    fn conf(&self) -> PathBuf {
        self.folder.join("slurm.conf")
    }

    /// What a program of Slurm's says.
    fn said(&self, words: &[&str]) -> String {
        said(Command::new(words[0]).args(&words[1..]).env("SLURM_CONF", self.conf()))
    }

    /// Waits until a shard in `out` is in its midst, kills it and has it queued again.
    fn requeue(&self, out: &Path, job: impl Fn(&Self) -> String, child: &mut Child) {
        let journal = out.join(format!("shard-{KILLED}-of-8.journal"));
        let began = Instant::now();
        while rows(&journal) < 2 {
            assert!(began.elapsed() < PATIENCE, "shard {KILLED} does not begin");
            assert!(child.try_wait().expect("a child").is_none(), "it ended before shard {KILLED} began");
            thread::sleep(Duration::from_millis(10));
        }
        self.said(&["scontrol", "requeue", &job(self)]);
        println!("requeued with {} of 25 rows", rows(&journal));
    }

    /// Waits for the end of what follows the job.
    fn end(&self, child: &mut Child) {
        let began = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child") {
                break status;
            }
            if began.elapsed() > PATIENCE {
                child.kill().expect("a child of this test");
                panic!("the job does not end: {}", self.said(&["squeue", "--array"]));
            }
            thread::sleep(Duration::from_millis(50));
        };
        assert!(status.success(), "{status}; {}", self.said(&["squeue", "--array"]));
    }

    /// That the task was there twice, and the second time went on from the rows of the first.
    fn judge(&self, task: &str, log: &str) {
        assert!(
            self.said(&["scontrol", "show", "job", task]).contains("Restarts=1"),
            "{task} was not requeued"
        );
        let resumed = log
            .lines()
            .find_map(|line| line.trim().strip_prefix("resumed")?.trim().split(' ').next()?.parse().ok());
        let resumed: usize = resumed.unwrap_or_else(|| panic!("it did not resume:\n{log}"));
        assert!((2..25).contains(&resumed), "{resumed} rows were there");
        println!("shard {KILLED} went on from {resumed} of 25 rows");
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("cluster");
        let _ = Command::new(script).arg("stop").arg(&self.folder).stdout(Stdio::null()).status();
        if !thread::panicking() {
            let _ = fs::remove_dir_all(&self.folder);
        }
    }
}

#[test]
fn two_hundred_runs_in_eight_shards_of_which_one_is_killed() {
    let out = folder("slurm");
    let cluster = Cluster::start("slurm");
    let mut command = program(&[&study("two-hundred.toml"), &"--slurm", &"--shards", &"8", &"--out", &out]);
    let mut child = command.env("SLURM_CONF", cluster.conf()).spawn().expect("it starts");
    let job = || fs::read_to_string(out.join("slurm.job")).expect("submitted").trim().to_owned();
    cluster.requeue(&out, |_| format!("{}_{KILLED}", job()), &mut child);
    cluster.end(&mut child);
    judge(&out);
    let log = fs::read_to_string(out.join(format!("slurm-{}_{KILLED}.log", job()))).expect("a log");
    cluster.judge(&format!("{}_{KILLED}", job()), &log);

    // Called again it has nothing to do; without one shard it submits that one.
    let mut again = program(&[&study("two-hundred.toml"), &"--slurm", &"--shards", &"8", &"--out", &out]);
    let first = job();
    said(again.env("SLURM_CONF", cluster.conf()));
    assert_eq!(job(), first);
    fs::remove_file(out.join("shard-5-of-8.parquet")).expect("there");
    said(again.env("SLURM_CONF", cluster.conf()));
    assert_ne!(job(), first);
    judge(&out);
}

#[test]
fn the_same_through_submitit() {
    let out = folder("submitit");
    programs();
    let cluster = Cluster::start("submitit");
    let mut command = Command::new(programs().join("python"));
    command.arg(scheduler("with_submitit.py")).arg(study("two-hundred.toml")).arg(&out).arg("8");
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", programs().display());
    let command = command.env("CAMPAIGN", PROGRAM).env("SLURM_CONF", cluster.conf()).env("PATH", path);
    let mut child = command.spawn().expect("it starts");
    // Its tasks count from 0.
    let task = |cluster: &Cluster| {
        let queue = cluster.said(&["squeue", "--noheader", "--array", "--format=%i"]);
        let end = format!("_{}", KILLED - 1);
        let task = queue.split_whitespace().find(|task| task.ends_with(&end));
        task.unwrap_or_else(|| panic!("no task {end} in {queue}")).to_owned()
    };
    let mut found = String::new();
    {
        let found = std::cell::RefCell::new(&mut found);
        cluster.requeue(
            &out,
            |cluster| {
                let task = task(cluster);
                found.borrow_mut().clone_from(&task);
                task
            },
            &mut child,
        );
    }
    cluster.end(&mut child);
    judge(&out);
    let logs = fs::read_dir(out.join("submitit")).expect("logs").map(|entry| entry.expect("one").path());
    let logs = logs.filter(|path| path.display().to_string().contains(&format!("{found}_")));
    let log: String = logs.filter_map(|path| fs::read_to_string(path).ok()).collect();
    cluster.judge(&found, &log);
}
