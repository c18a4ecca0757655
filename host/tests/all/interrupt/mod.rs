//! Ctrl-C and other signals to a child process.

use std::process::Command;
use std::time::{Duration, Instant};

use crate::common::{PATIENCE, Process};

/// Sends a signal that ends a run, once the program takes those; Ctrl-C sends `INT`.
pub fn end(process: &Process, signal: &str) {
    let status = format!("/proc/{}/status", process.child.id());
    let is_taken = || {
        let text = std::fs::read_to_string(&status).expect("it runs");
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:")).expect("a mask");
        // One bit a signal, from 1; SIGINT is 2.
        u64::from_str_radix(caught.trim(), 16).expect("a mask") & 1 << 1 != 0
    };
    let began = Instant::now();
    while !is_taken() {
        assert!(began.elapsed() < PATIENCE, "it never takes the signal");
        std::thread::sleep(Duration::from_millis(5));
    }
    send(process, signal);
}

/// Sends any signal.
pub fn send(process: &Process, signal: &str) {
    // Every shell has `kill` built in; not every machine has it as a program.
    let command = format!("kill -{signal} {}", process.child.id());
    let status = Command::new("sh").args(["-c", &command]).status().expect("a shell");
    assert!(status.success());
}
