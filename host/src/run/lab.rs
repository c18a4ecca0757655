//! Poses of a structure from a motion capture.
//!
//! ```text
//! Source ─ frames → Gate ─ bodies in the world, on the host's clock → Structure ─ one pose → pilot
//! ```
//!
//! While bodies contradict each other (labels are swapped, a module has broken away) there is no pose, and so the fleet holds. Why
//! there is none is told in words.

use modboat::observer::Fix;
use pose::axes::{Axes, Unit};
use pose::gate::{self, Gate};
use pose::ledger::{FrameFault, Ledger};
use pose::source::{Link, Source, Status};
use pose::structure::{Found, Outcome, PlanarPose, Structure};
use pose::time::HostInstant;
use protocol::time::FleetInstant;

use super::RunError;
use super::closed_loop::PoseSource;

/// Frames that are not used in a row after which it is said why. *Assumed*: a tenth of a second at 100 Hz.
pub(super) const SAID_AFTER: u32 = 10;
/// Without a frame for this time the connection is looked at, s. *Assumed.*
pub(super) const SILENT_S: f64 = 0.5;
/// The last pose says where the structure should be for this time, s.
const EXPECTED_S: f64 = 5.0;

/// The unit that a motion capture measures in where nothing else is said.
#[must_use]
pub fn standard_unit(address: &pose::address::Address) -> Unit {
    match address {
        pose::address::Address::Qtm(_) => Unit::Millimetre,
        _ => Unit::Metre,
    }
}

/// See the module's documentation.
pub struct LabPoses {
    name: String,
    source: Box<dyn Source>,
    gate: Gate,
    structure: Structure,
    fix: Fix,
    last: Option<(f64, PlanarPose)>,
    arrived_s: Option<f64>,
    unused: u32,
    trouble: Option<String>,
    late: Latency,
}

/// How long frames were under way beyond the least time, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Latency {
    count: f64,
    sum_s: f64,
    most_s: f64,
}

impl Latency {
    /// Another frame.
    pub(super) fn add(&mut self, late_s: f64) {
        self.count += 1.0;
        self.sum_s += late_s;
        self.most_s = self.most_s.max(late_s);
    }

    /// The account of a motion capture with these latencies.
    pub(super) fn account(&self, source: &str, gate: &Gate, connects: u32) -> PoseAccount {
        let clock = gate.clock();
        PoseAccount {
            source: source.to_owned(),
            ledger: *gate.ledger(),
            connects,
            clock_jumps: clock.jumps(),
            least_delay_s: clock.least_delay_s(),
            late_mean_s: self.sum_s / self.count.max(1.0),
            late_most_s: self.most_s,
        }
    }
}

/// How a motion capture stands that sends no frames.
pub(super) fn silence(name: &str, status: &Status) -> String {
    let stands = match status.link {
        Link::Connecting => "there is no answer from it",
        Link::Connected | Link::Streaming => "it is connected, and no frames come",
    };
    let trouble = status.trouble.as_ref().map_or_else(String::new, |trouble| format!(" ({trouble})"));
    format!("{name}: {stands}{trouble}")
}

/// What came of a motion capture, so far.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseAccount {
    /// Where poses come from.
    pub source: String,
    /// What became of frames and bodies.
    pub ledger: Ledger,
    /// Connections that were made.
    pub connects: u32,
    /// Jumps of the server's clock.
    pub clock_jumps: u64,
    /// Least time from exposure to arrival, and how far off that may be, s; `None` where the protocol does not show it.
    pub least_delay_s: Option<(f64, f64)>,
    /// Mean time that frames took beyond the least, s.
    pub late_mean_s: f64,
    /// Greatest, s.
    pub late_most_s: f64,
}

impl LabPoses {
    /// Of `structure` by the frames of `source`, in a laboratory with these axes.
    #[must_use]
    pub fn new(name: String, source: Box<dyn Source>, axes: Axes, structure: Structure) -> Self {
        let gate = Gate::new(axes, gate::Limits::default());
        let (fix, late) = (Fix::default(), Latency::default());
        Self {
            name,
            source,
            gate,
            structure,
            fix,
            last: None,
            arrived_s: None,
            unused: 0,
            trouble: None,
            late,
        }
    }

    /// The pose that a frame shows, or why it shows none.
    fn locate(&mut self, seen: &gate::Fix) -> Result<PlanarPose, String> {
        let expected =
            self.last.filter(|(at_s, _)| seen.captured_s - at_s < EXPECTED_S).map(|(_, pose)| pose);
        match self.structure.locate(&seen.bodies, expected.as_ref()) {
            Outcome::Unseen => Err("no body of the roster is tracked".to_owned()),
            Outcome::Contradiction(modules) => {
                let modules: Vec<String> = modules.iter().map(u16::to_string).collect();
                Err(format!("the bodies of modules {} contradict each other", modules.join(", ")))
            }
            Outcome::Found(found) => misfit(&found).map_or(Ok(found.pose), Err),
        }
    }

    fn take(&mut self, arrival: &pose::frame::Arrival) -> bool {
        self.arrived_s = Some(arrival.arrived.seconds());
        let located = match self.gate.take(arrival) {
            Ok(seen) => {
                self.late.add(seen.late_s);
                self.locate(&seen).map(|pose| (seen.captured_s, pose))
            }
            // The same frame again is no trouble.
            Err(FrameFault::Doubled | FrameFault::OutOfOrder) => return false,
            Err(fault) => Err(worded(fault).to_owned()),
        };
        match located {
            Ok((captured_s, pose)) => {
                (self.unused, self.trouble) = (0, None);
                self.last = Some((captured_s, pose));
                let [x, y] = pose.position_m.into();
                self.fix = Fix { t_s: captured_s, position_m: [x, y], heading_rad: pose.heading_rad };
                true
            }
            Err(trouble) => {
                self.unused += 1;
                if self.unused >= SAID_AFTER {
                    self.trouble = Some(trouble);
                }
                false
            }
        }
    }
}

/// What does not fit a pose, if anything.
fn misfit(found: &Found) -> Option<String> {
    if let Some((first, second)) = found.swapped.first() {
        return Some(format!("the bodies of modules {first} and {second} have each other's label"));
    }
    let astray = found.astray.first()?;
    Some(format!(
        "module {} is not in its place: it has broken away, or its body {} was moved on it",
        astray.module, astray.label
    ))
}

pub(super) const fn worded(fault: FrameFault) -> &'static str {
    match fault {
        FrameFault::Doubled => "frames come twice",
        FrameFault::OffTheClock => "the server's clock has jumped",
        FrameFault::OutOfOrder => "frames are older than the newest",
        FrameFault::Frozen => "the stream is frozen: no body moves in the last digit",
        FrameFault::WithoutBody => "no body is tracked",
    }
}

impl<W> PoseSource<W> for LabPoses {
    type Pose = Fix;

    fn poll<'a>(&'a mut self, now: FleetInstant, _: Option<&'a W>) -> Result<Option<&'a Fix>, RunError> {
        let at = HostInstant(std::time::Duration::from_micros(now.0));
        let mut is_new = false;
        while let Some(arrival) = self.source.poll(at).map_err(|error| RunError::Pose(error.to_string()))? {
            is_new |= self.take(&arrival);
        }
        if let Some(exchange) = self.source.exchange() {
            self.gate.clock_mut().exchanged(&exchange);
        }
        if self.arrived_s.is_none_or(|arrived_s| at.seconds() - arrived_s > SILENT_S) {
            self.trouble = Some(silence(&self.name, self.source.status()));
        }
        Ok(is_new.then_some(&self.fix))
    }

    fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    fn account(&self) -> Option<PoseAccount> {
        Some(self.late.account(&self.name, &self.gate, self.source.status().connects))
    }
}
