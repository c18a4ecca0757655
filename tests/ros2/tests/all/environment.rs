//! An environment with the peers in it, below `target`; programs and scripts, ended with the test.

use std::io::{BufRead as _, BufReader, Read};
use std::net::{TcpListener, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU16, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::JoinHandle;

/// `flotilla`.
pub const FLOTILLA: &str = env!("CARGO_BIN_EXE_flotilla-to-bridge");
/// `flotilla-ros2`.
pub const BRIDGE: &str = env!("CARGO_BIN_EXE_bridge-to-flotilla");
/// Domains up to this have ports below those that Linux gives to any socket.
const DOMAINS: u16 = 100;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// An empty folder for a test.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ros2").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder below target");
    folder
}

/// A DDS domain that no other test of this process has.
pub fn domain() -> String {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let begin = (std::process::id() % u32::from(DOMAINS)) as u16;
    (1 + (begin + NEXT.fetch_add(1, Ordering::Relaxed)) % DOMAINS).to_string()
}

/// A port of 127.0.0.1 that is free for datagrams and connections.
pub fn port() -> u16 {
    loop {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("bound").port();
        if UdpSocket::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}

/// The Python of an environment with the peers in it; made when they are not there yet.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let folder = here().join("../../target/ros2");
        let status = Command::new(here().join("set-up")).arg(&folder).status().expect("bash");
        assert!(status.success(), "tests/ros2/set-up failed: {status}");
        folder.join("bin/python")
    })
}

/// A program, and what it says.
pub struct Program {
    name: String,
    child: Child,
    said: Arc<Mutex<Vec<String>>>,
    readers: Vec<JoinHandle<()>>,
}

impl Program {
    /// Starts a program of ours.
    pub fn start(program: &str, arguments: &[&str], folder: &Path, domain: &str) -> Self {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(folder);
        Self::spawn(command, arguments.first().copied().unwrap_or(program), domain)
    }

    /// Starts a script over Fast DDS.
    pub fn script(script: &str, arguments: &[&str], domain: &str) -> Self {
        let mut command = Command::new(python());
        command.arg(here().join("python").join(script)).args(arguments);
        command.env("PYTHONDONTWRITEBYTECODE", "1").env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp");
        Self::spawn(command, script, domain)
    }

    fn spawn(mut command: Command, name: &str, domain: &str) -> Self {
        command.env("ROS_DOMAIN_ID", domain).env("FLOTILLA_ROS2", BRIDGE);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let said = Arc::new(Mutex::new(Vec::new()));
        let pipes: [Box<dyn Read + Send>; 2] =
            [Box::new(child.stdout.take().expect("a pipe")), Box::new(child.stderr.take().expect("a pipe"))];
        let readers = pipes.map(|pipe| {
            let (said, name) = (Arc::clone(&said), name.to_owned());
            std::thread::spawn(move || {
                for line in BufReader::new(pipe).lines().map_while(Result::ok) {
                    println!("{name}: {line}");
                    said.lock().expect("no reader panics").push(line);
                }
            })
        });
        Self { name: name.to_owned(), child, said, readers: readers.into() }
    }

    /// Waits for a line with `part` in it; the program must not end before.
    pub fn line(&mut self, part: &str) -> String {
        loop {
            let over = self.child.try_wait().expect("a child");
            if let Some(line) =
                self.said.lock().expect("no reader panics").iter().find(|line| line.contains(part))
            {
                return line.clone();
            }
            assert!(over.is_none(), "{} ended without saying {part:?}: {over:?}", self.name);
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    }

    /// Waits for the end; how it ended, and all that was said.
    pub fn finish(mut self) -> (ExitStatus, String) {
        let status = self.child.wait().expect("a child");
        self.readers.drain(..).for_each(|reader| reader.join().expect("no reader panics"));
        let said = self.said.lock().expect("no reader panics").join("\n");
        (status, said)
    }

    /// Ends it in good order, as Ctrl-C does.
    pub fn interrupt(&self) {
        let sent = Command::new("kill").args(["-INT", &self.child.id().to_string()]).status();
        assert!(sent.is_ok_and(|status| status.success()), "kill -INT {}", self.name);
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A run that serves its console, and a bridge to it.
pub struct Bridged {
    /// The run.
    pub run: Program,
    /// The bridge.
    pub bridge: Program,
    /// DDS domain.
    pub domain: String,
    /// Where the run writes.
    pub folder: PathBuf,
}

impl Bridged {
    /// Three modules, run as `wanted` has it.
    pub fn start(name: &str, wanted: &str) -> Self {
        // It takes minutes where it is not there yet, in which a run would go on by itself.
        python();
        let (folder, domain) = (folder(name), domain());
        let arguments = ["run", wanted, "--realtime", "--serve", "127.0.0.1:0", "--seed", "5", "--out", "."];
        let mut run = Program::start(FLOTILLA, &arguments, &folder, &domain);
        let line = run.line("http://");
        let address = line.split_whitespace().find(|word| word.starts_with("http://")).expect("an address");
        let bridge = Program::start(BRIDGE, &["bridge", address], &folder, &domain);
        Self { run, bridge, domain, folder }
    }

    /// Ends the run in good order, which ends the bridge.
    pub fn end(self) {
        self.run.interrupt();
        let (status, said) = self.run.finish();
        // A run that was steered may have shortfalls; it was not to fail.
        assert!(status.code().is_some_and(|code| code <= 1), "the run ended with {status}: {said}");
        let (status, said) = self.bridge.finish();
        assert!(status.success(), "the bridge ended with {status}: {said}");
    }
}

/// What a script found: its last line, JSON. It must have ended well, and no line may be a warning.
pub fn found(script: Program) -> serde_json::Value {
    let (status, said) = script.finish();
    assert!(status.success(), "{status}\n{said}");
    for line in said.lines() {
        let small = line.to_lowercase();
        let is_warning = ["warn", "error", "bare", "traceback"].iter().any(|word| small.contains(word));
        assert!(!is_warning, "{line}");
    }
    serde_json::from_str(said.lines().last().expect("a line")).expect("JSON")
}
