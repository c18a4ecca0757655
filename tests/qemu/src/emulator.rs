//! Process of one emulated module: start, output, end.

use std::io::{BufRead, BufReader};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::report::Report;

/// How long anything may take that must come: it only ends what hangs, on whatever machine.
pub const PATIENCE: Duration = Duration::from_secs(600);

/// The image with this name, where `firmware/boards/build` puts it.
///
/// # Panics
/// If it is not there.
#[must_use]
pub fn image(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/images");
    let path = folder.join(name);
    assert!(path.is_file(), "{} is missing: run firmware/boards/build first", path.display());
    path
}

/// A UDP port that is free.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn free_port() -> u16 {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
    socket.local_addr().expect("bound").port()
}

/// The same for TCP.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn free_tcp_port() -> u16 {
    let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
    socket.local_addr().expect("bound").port()
}

/// How an emulator is started.
#[derive(Clone, Debug, Default)]
pub struct Setup<'a> {
    /// The image, by its name.
    pub image: &'a str,
    /// What lies where the configuration belongs.
    pub configuration: &'a [u8],
    /// Port of this machine that leads to the module, and the module's.
    pub forward: Option<(u16, u16)>,
    /// Where its serial line ends; here if nothing is said.
    pub serial: Option<&'a str>,
    /// Where its monitor listens.
    pub monitor: Option<&'a str>,
    /// Where its debugger finds it. It waits there for one, which serves the program's files then.
    pub debugger: Option<&'a Path>,
    /// Words for the program.
    pub words: &'a [&'a str],
    /// More arguments.
    pub arguments: &'a [&'a str],
}

/// A running emulator of one module. Killed when dropped.
#[derive(Debug)]
pub struct Emulator {
    process: Child,
    lines: Receiver<String>,
    seen: Vec<String>,
    _folder: tempfile::TempDir,
    /// Where datagrams to the module go.
    pub address: Option<SocketAddr>,
}

impl Emulator {
    /// Starts one.
    ///
    /// # Panics
    /// If there is no emulator.
    #[must_use]
    pub fn start(setup: &Setup<'_>) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let configuration = folder.path().join("configuration.bin");
        std::fs::write(&configuration, setup.configuration).expect("a file");
        let target = if setup.debugger.is_some() { "gdb" } else { "native" };
        let words: String = setup.words.iter().map(|word| format!(",arg={word}")).collect();
        let mut command = Command::new("qemu-system-arm");
        command
            .args(["-machine", "mps2-an386", "-nographic"])
            .args(["-serial", setup.serial.unwrap_or("stdio"), "-monitor", setup.monitor.unwrap_or("none")])
            .arg("-semihosting-config")
            .arg(format!("enable=on,target={target}{words}"))
            .arg("-kernel")
            .arg(image(setup.image));
        if !setup.configuration.is_empty() {
            let file = configuration.display();
            command.arg("-device").arg(format!("loader,file={file},addr=0x3ff000,force-raw=on"));
        }
        if let Some(socket) = setup.debugger {
            command.arg("-S").arg("-gdb").arg(format!("unix:{},server=on,wait=off", socket.display()));
        }
        command.arg("-nic");
        match setup.forward {
            Some((outside, inside)) => {
                command.arg(format!("user,model=lan9118,hostfwd=udp:127.0.0.1:{outside}-:{inside}"));
            }
            None => {
                command.arg("user,model=lan9118");
            }
        }
        command.args(setup.arguments);
        let mut process = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("qemu-system-arm: {error}: run firmware/boards/build first"));
        let (sender, lines) = channel();
        let out = process.stdout.take().expect("piped");
        let err = process.stderr.take().expect("piped");
        let from_err = sender.clone();
        std::thread::spawn(move || {
            BufReader::new(out).lines().map_while(Result::ok).try_for_each(|l| sender.send(l))
        });
        std::thread::spawn(move || {
            BufReader::new(err).lines().map_while(Result::ok).try_for_each(|l| from_err.send(l))
        });
        let address = setup.forward.map(|(outside, _)| SocketAddr::from((Ipv4Addr::LOCALHOST, outside)));
        Self { process, lines, seen: Vec::new(), _folder: folder, address }
    }

    /// The next line that `wanted` takes, in time.
    ///
    /// # Panics
    /// If none comes.
    pub fn await_line<T>(&mut self, what: &str, mut wanted: impl FnMut(&str) -> Option<T>) -> T {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            match self.lines.recv_timeout(left) {
                Ok(line) => {
                    let found = wanted(&line);
                    self.seen.push(line);
                    if let Some(found) = found {
                        return found;
                    }
                }
                Err(error) => panic!("no {what} ({error}) after:\n{}", self.seen.join("\n")),
            }
        }
    }

    /// Everything printed by now.
    pub fn lines(&mut self) -> &[String] {
        self.seen.extend(self.lines.try_iter());
        &self.seen
    }

    /// The reports by now.
    pub fn reports(&mut self) -> Vec<Report> {
        self.lines().iter().filter_map(|line| Report::read(line)).collect()
    }

    /// Whether it still runs.
    pub fn is_alive(&mut self) -> bool {
        matches!(self.process.try_wait(), Ok(None))
    }

    /// Waits until it ends by itself: its status, and what it said.
    ///
    /// # Panics
    /// If it does not in time.
    pub fn wait(mut self) -> (ExitStatus, Vec<String>) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) => self.seen.push(line),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => panic!("it goes on:\n{}", self.seen.join("\n")),
            }
        }
        let status = self.process.wait().expect("its status");
        (status, std::mem::take(&mut self.seen))
    }

    /// Kills the emulator.
    pub fn kill(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.kill();
    }
}
