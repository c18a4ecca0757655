//! One emulated module that is stepped: its time goes on when the test says so, by as much as the test says.
//!
//! The emulator counts instructions (`-icount shift=N,sleep=off`): each takes 2^N ns of its time, and while it waits for an interrupt
//! its time jumps to the next one. At the end of each step the program stands still (`firmware/boards/qemu/src/steps.rs`). What
//! was put into its network by then is taken in before the next step begins, at that instant of its time. So nothing that a module
//! does depends on how much processor this machine gives it.

use std::net::SocketAddr;

use protocol::time::Duration;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::debugger::Debugger;
use crate::emulator::{Emulator, Setup, free_port};
use crate::report::Report;

/// How a module is stepped.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// How long one is.
    pub length: Duration,
    /// An instruction takes 2^this ns.
    pub shift: u8,
    /// Where its random bytes come from.
    pub seed: u64,
    /// Words for its program: what goes wrong there (`firmware/boards/qemu/src/disturbance.rs`).
    pub words: &'static [&'static str],
}

/// An emulated module whose time goes on by steps.
#[derive(Debug)]
pub struct Stepped {
    /// The emulator.
    pub emulator: Emulator,
    /// Where datagrams to the module go.
    pub address: SocketAddr,
    debugger: Debugger,
    /// Datagrams that were put into its network since the last step began, and before.
    fresh: u32,
    put: u32,
    sent: u32,
    received: u32,
    /// Both counts as they were when its watchdog reset the board last: its own begin again then.
    before: (u32, u32),
}

impl Stepped {
    /// Starts one with this configuration, which listens on `port`. It stands at the end of its first step.
    ///
    /// # Panics
    /// If it does not get there.
    #[must_use]
    pub fn start(configuration: &[u8], port: u16, steps: Steps) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let socket = folder.path().join("debugger");
        let outside = free_port();
        let (length, count) = (steps.length.0.to_string(), format!("shift={},sleep=off", steps.shift));
        let emulator = Emulator::start(&Setup {
            image: "qemu.elf",
            configuration,
            forward: Some((outside, port)),
            debugger: Some(&socket),
            words: &[&["step", length.as_str()][..], steps.words].concat(),
            arguments: &["-icount", &count],
            ..Setup::default()
        });
        let debugger = Debugger::attach(&socket, ChaCha8Rng::seed_from_u64(steps.seed));
        let address = SocketAddr::from(([127, 0, 0, 1], outside));
        let mut module =
            Self { emulator, address, debugger, fresh: 0, put: 0, sent: 0, received: 0, before: (0, 0) };
        module.stand();
        module
    }

    /// A datagram was sent to its address.
    pub fn put(&mut self) {
        self.fresh += 1;
    }

    /// Begins the next step.
    pub fn go(&mut self) {
        // Its network takes in one datagram a look (libslirp, `slirp_pollfds_poll`).
        for _ in 0..self.fresh {
            self.debugger.look_around();
        }
        self.put += std::mem::take(&mut self.fresh);
        self.debugger.answer_step();
    }

    /// Waits for the end of the step.
    ///
    /// # Panics
    /// If it ends otherwise.
    pub fn stand(&mut self) {
        let bytes = self.debugger.await_step();
        let words: Vec<u32> = bytes
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")))
            .collect();
        let [sent, received] = words[..] else { panic!("no step: {bytes:?}") };
        if sent < self.sent - self.before.0 {
            self.before = (self.sent, self.received);
        }
        (self.sent, self.received) = (self.before.0 + sent, self.before.1 + received);
    }

    /// Datagrams that it has sent.
    #[must_use]
    pub fn sent(&self) -> u32 {
        self.sent
    }

    /// Datagrams that were put into its network before the last step, and those of them that reached its program.
    #[must_use]
    pub fn taken(&self) -> (u32, u32) {
        (self.put, self.received)
    }

    /// Steps on until it prints its next report.
    ///
    /// # Panics
    /// If it never does.
    pub fn next_report(&mut self) -> Report {
        let before = self.emulator.reports().len();
        // It prints one a second; reading it may take this process a while, in which a little more time passes.
        for _ in 0..1_000_000 {
            self.go();
            self.stand();
            if let Some(report) = self.emulator.reports().get(before) {
                return report.clone();
            }
        }
        panic!("no report:\n{}", self.emulator.lines().join("\n"));
    }
}
