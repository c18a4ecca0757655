//! Clients of motion capture that are not ours, in Python, read what our servers send.
//!
//! The packages are installed once into a folder below `target` ([`python`]). A client prints one line of JSON a frame ([`Line`]);
//! [`frames_read`] serves while it runs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::thread;
use std::time::{Duration, Instant};

use nalgebra::{Quaternion, Vector3};
use pose::frame::{Body, Frame, Label};
use pose::server::Server;
use pose::time::{HostInstant, ServerInstant};

/// How long a client may take: it is ended then and the test fails. Many times what one takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);
/// Time between two frames that are served.
const PERIOD: Duration = Duration::from_millis(10);
/// Frames after which the first comes again; a client that reads so late that it takes one for the other has other faults.
const PERIODS: u32 = 4096;

/// A frame as a client read it.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
pub struct Line {
    /// Its number, where the protocol has one and the client shows it.
    pub number: Option<u32>,
    /// When it was captured, where the client shows it.
    pub captured_us: Option<i64>,
    /// x, y, z, then the quaternion's w, x, y, z, by name.
    pub bodies: BTreeMap<String, [f64; 7]>,
}

/// The Python interpreter of the environment with the clients.
pub fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = here.join("../../target/mocap");
        let mut made = Command::new(here.join("../environment"));
        let status = made.arg(&folder).arg(here.join("python/requirements.txt")).status().expect("bash");
        assert!(status.success(), "tests/environment failed: {status}");
        folder.join("bin/python")
    })
}

/// The bodies that are served.
pub fn labels() -> Vec<Label> {
    vec![Label::new(1, "boat 1"), Label::new(2, "boat 2"), Label::new(7, "Kälte")]
}

/// Frame `number`: numbers that single precision holds exactly, another position in each frame, attitudes that tell all axes and
/// signs apart.
pub fn frame(number: u32) -> Frame {
    let count = f64::from(number % PERIODS);
    let attitudes = [
        Quaternion::new(0.5, 0.5, 0.5, 0.5),
        Quaternion::new(0.5, -0.5, 0.5, 0.5),
        Quaternion::new(0.5, 0.5, -0.5, 0.5),
    ];
    let bodies = labels().into_iter().zip(attitudes).zip(0..).map(|((label, attitude), index)| {
        let offset = f64::from(index);
        let position = Vector3::new(0.25 + count, -1.5 - offset, 0.0625 + offset);
        Body { label, position, attitude, tracked: true, error: Some(0.0) }
    });
    let captured = ServerInstant(i64::from(number) * 10_000_000);
    Frame { number: Some(number), captured, bodies: bodies.collect() }
}

/// What the script printed, while `server` sent frame 1, 2 and so on, each as `shown` makes of it.
pub fn frames_read(
    server: &mut dyn Server,
    script: &str,
    arguments: &[String],
    shown: impl Fn(Frame) -> Frame,
) -> Vec<Line> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(script);
    let mut child = Command::new(python())
        .arg(script)
        .args(arguments)
        .stdout(Stdio::piped())
        .spawn()
        .expect("the interpreter starts");
    let began = Instant::now();
    let mut number = 0;
    while child.try_wait().expect("a child").is_none() {
        let elapsed = began.elapsed();
        if elapsed > PATIENCE {
            end(&mut child);
            panic!(
                "the client {arguments:?} read too few frames in {PATIENCE:?}; clients: {}",
                server.clients()
            );
        }
        server.poll(HostInstant(elapsed));
        if elapsed >= PERIOD * number {
            number += 1;
            server.send(HostInstant(elapsed), &shown(frame(number)));
        }
        thread::sleep(Duration::from_millis(1));
    }
    let output = child.wait_with_output().expect("its output");
    assert!(output.status.success(), "the client {arguments:?} failed: {}", output.status);
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    // libmotioncapture prints messages of its own between the lines.
    let lines = text.lines().filter(|line| line.starts_with('{'));
    lines.map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

fn end(child: &mut Child) {
    child.kill().expect("a child of this test");
    child.wait().expect("a child of this test");
}

/// Holds every line against the frame it shows, which the first coordinate tells.
///
/// # Panics
/// A pose off by more than 1e-6, a body too many or too few, a wrong number or time.
pub fn judge(lines: &[Line], count: usize, expected: impl Fn(u32) -> Frame) {
    assert_eq!(lines.len(), count);
    for line in lines {
        let first = line.bodies.get("boat 1").expect("the first body")[0];
        let number =
            (1..PERIODS).find(|&number| (expected(number).bodies[0].position.x - first).abs() < 1e-4);
        let number = number.unwrap_or_else(|| panic!("no frame has {first}"));
        let frame = expected(number);
        assert_eq!(line.number.unwrap_or(number), number);
        let captured_us = frame.captured.0 / 1000;
        assert_eq!(line.captured_us.unwrap_or(captured_us), captured_us);
        assert_eq!(line.bodies.len(), frame.bodies.iter().filter(|body| body.tracked).count());
        for body in frame.bodies.iter().filter(|body| body.tracked) {
            let found = line.bodies[body.label.name.as_deref().expect("a name")];
            let (p, q) = (body.position, body.attitude);
            let turn = if q.w * found[3] + q.i * found[4] + q.j * found[5] + q.k * found[6] < 0.0 {
                -1.0
            } else {
                1.0
            };
            let right = [p.x, p.y, p.z, turn * q.w, turn * q.i, turn * q.j, turn * q.k];
            let off = right.iter().zip(found).map(|(right, found)| (right - found).abs()).fold(0.0, f64::max);
            assert!(off <= 1e-6, "{}: {found:?} for {right:?}", body.label);
        }
    }
}
