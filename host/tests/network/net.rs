//! Two network namespaces of this process's own, joined by a pair of virtual Ethernet devices. Nothing outside of them is touched, and
//! they go when the [`Net`] goes.
//!
//! ```text
//! namespace flotilla-PID-N-host        namespace flotilla-PID-N-modules
//!   10.77.0.1/30 veth ──────────────────── veth 10.77.0.2/30
//! ```

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::Process;

/// The host's end.
pub const HOST: &str = "10.77.0.1";
/// The modules' end.
pub const MODULES: &str = "10.77.0.2";

/// What the kernel's own fault injector is to do on either end.
const NETEM: &str = "netem loss 10% delay 20ms 15ms duplicate 5% reorder 10% 50%";

/// Which side of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Host,
    Modules,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Net {
    names: [String; 2],
    /// Whether the kernel itself makes it a bad network.
    pub netem: bool,
}

impl Net {
    /// A network, made bad by the kernel where that can.
    pub fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        sweep();
        let (process, count) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let names = ["host", "modules"].map(|side| format!("flotilla-{process}-{count}-{side}"));
        // From here on it is taken away again, whatever fails.
        let mut net = Self { names, netem: false };
        for name in &net.names {
            ip(&["netns", "add", name]);
        }
        let [host, modules] = &net.names;
        ip(&["-n", host, "link", "add", "veth", "type", "veth", "peer", "name", "veth", "netns", modules]);
        for (name, address) in net.names.iter().zip([HOST, MODULES]) {
            ip(&["-n", name, "address", "add", &format!("{address}/30"), "dev", "veth"]);
            ip(&["-n", name, "link", "set", "veth", "up"]);
            ip(&["-n", name, "link", "set", "lo", "up"]);
        }
        net.netem = net.names.iter().all(|name| {
            let words =
                ["-n", name, "qdisc", "add", "dev", "veth", "root"].into_iter().chain(NETEM.split(' '));
            let output = Command::new("tc").args(words).output().expect("tc runs: install iproute2");
            let why = String::from_utf8_lossy(&output.stderr);
            // Anything but a kernel without it is a mistake of this test.
            assert!(output.status.success() || why.contains("qdisc kind is unknown"), "tc: {why}");
            output.status.success()
        });
        net
    }

    /// Starts `program` in `folder` on one side.
    pub fn start(&self, side: Side, folder: &Path, program: &str, arguments: &[&str]) -> Process {
        self.start_with(side, folder, program, arguments, &[])
    }

    /// The same, with variables in its environment.
    pub fn start_with(
        &self,
        side: Side,
        folder: &Path,
        program: &str,
        arguments: &[&str],
        variables: &[(&str, &str)],
    ) -> Process {
        let mut command = Command::new("ip");
        // It turns into the program: to kill the one is to kill the other.
        command.args(["netns", "exec", &self.names[side as usize], program]).args(arguments);
        command.current_dir(folder).envs(variables.iter().copied());
        Process::spawn(command)
    }

    /// What the kernel's fault injector did, for the log.
    pub fn netem_count(&self) -> String {
        let show =
            |name| Command::new("tc").args(["-n", name, "-s", "qdisc", "show", "dev", "veth"]).output();
        let text = |name| show(name).map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
        self.names.iter().filter_map(|name| text(name).ok()).collect()
    }
}

impl Drop for Net {
    fn drop(&mut self) {
        for name in &self.names {
            let _ = Command::new("ip").args(["netns", "delete", name]).output();
        }
    }
}

/// Takes away what a run of this test that was killed has left.
fn sweep() {
    let Ok(output) = Command::new("ip").args(["netns", "list"]).output() else { return };
    let list = String::from_utf8_lossy(&output.stdout).into_owned();
    for name in list.lines().filter_map(|line| line.split(' ').next()) {
        let process = name.strip_prefix("flotilla-").and_then(|rest| rest.split('-').next());
        if process.is_some_and(|process| !Path::new("/proc").join(process).exists()) {
            let _ = Command::new("ip").args(["netns", "delete", name]).output();
        }
    }
}

fn ip(arguments: &[&str]) {
    let output = Command::new("ip").args(arguments).output().expect("ip runs: install iproute2");
    let why = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "ip {}: {why} (namespaces want root)", arguments.join(" "));
}
