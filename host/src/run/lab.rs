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
use pose::feed::{Event, Feed};
use pose::frame::Label;
use pose::gate::{self, Gate};
use pose::ledger::FrameFault;
use pose::roster::Roster;
use pose::source::{Link, Source, Status};
use pose::structure::{Found, Outcome, PlanarPose, Structure};
use pose::time::HostInstant;
use protocol::time::{Duration, FleetInstant};

use super::RunError;
use super::pose_source::{PoseAccount, PoseSource};

/// Frames that are not used in a row after which it is said why. *Assumed*: a tenth of a second at 100 Hz.
pub(super) const SAID_AFTER: u32 = 10;
/// Without a frame for this time the connection is looked at. *Assumed.*
pub(super) const SILENT: Duration = Duration(500_000);
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
    feed: Feed,
    structure: Structure,
    /// The fleet's bodies, until all have been seen.
    awaited: Option<Roster>,
    fix: Fix,
    last: Option<(f64, PlanarPose)>,
    /// When the last frame came.
    came: Option<FleetInstant>,
    unused: u32,
    trouble: Option<String>,
}

impl LabPoses {
    /// Of `structure`, which has these `bodies`, by the frames of `source`, in a laboratory with these axes.
    #[must_use]
    pub fn new(
        name: String,
        source: Box<dyn Source>,
        axes: Axes,
        structure: Structure,
        bodies: Roster,
    ) -> Self {
        let feed = Feed::new(source, Gate::new(axes, gate::Limits::default()));
        let awaited = Some(bodies);
        Self {
            name,
            feed,
            structure,
            awaited,
            fix: Fix::default(),
            last: None,
            came: None,
            unused: 0,
            trouble: None,
        }
    }

    /// The first body of the fleet that has not been seen since the beginning, and what is seen instead.
    fn unseen(&mut self) -> Option<String> {
        let awaited = self.awaited.as_ref()?;
        let labels: Vec<Label> =
            self.feed.figures().bodies().keys().chain(self.feed.bodies()).cloned().collect();
        let Some(entry) = awaited.missing(&labels).next() else {
            self.awaited = None;
            return None;
        };
        let sent: Vec<String> =
            labels.iter().filter(|label| label.name.is_some()).map(Label::to_string).collect();
        let sent = if sent.is_empty() { "bodies without names".to_owned() } else { sent.join(", ") };
        Some(format!("body {} of module {} is never seen; the server sends {sent}", entry.body, entry.module))
    }

    /// The pose that a frame shows, or why it shows none.
    fn locate(&mut self, seen: &gate::Fix) -> Result<PlanarPose, String> {
        if let Some(unseen) = self.unseen() {
            return Err(unseen);
        }
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

    fn take(&mut self, event: Event) -> bool {
        let located = match event {
            Event::Fix(seen) => self.locate(&seen).map(|pose| (seen.captured_s, pose)),
            // The same frame again is no trouble.
            Event::Dropped(FrameFault::Doubled | FrameFault::OutOfOrder) => return false,
            Event::Dropped(fault) => Err(worded(fault).to_owned()),
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

/// How a motion capture stands that sends no frames.
pub(super) fn silence(name: &str, status: &Status) -> String {
    let stands = match status.link {
        Link::Connecting => "there is no answer from it",
        Link::Connected | Link::Streaming => "it is connected, and no frames come",
    };
    let trouble = status.trouble.as_ref().map_or_else(String::new, |trouble| format!(" ({trouble})"));
    format!("{name}: {stands}{trouble}")
}

/// What came of it.
pub(super) fn account(name: &str, feed: &Feed) -> PoseAccount {
    let clock = feed.gate().clock();
    PoseAccount {
        source: name.to_owned(),
        ledger: *feed.ledger(),
        connects: feed.status().connects,
        clock_jumps: clock.jumps(),
        least_delay_s: clock.least_delay_s(),
        late_p50_s: feed.figures().late_s(0.5),
        late_p99_s: feed.figures().late_s(0.99),
    }
}

impl<W> PoseSource<W> for LabPoses {
    type Pose = Fix;

    fn poll<'a>(&'a mut self, now: FleetInstant, _: Option<&'a W>) -> Result<Option<&'a Fix>, RunError> {
        let at = HostInstant(std::time::Duration::from_micros(now.0));
        let mut is_new = false;
        while let Some(event) = self.feed.poll(at).map_err(|error| RunError::Pose(error.to_string()))? {
            self.came = Some(now);
            is_new |= self.take(event);
        }
        if self.came.is_none_or(|came| now.since(came) > SILENT) {
            self.trouble = Some(silence(&self.name, self.feed.status()));
        }
        Ok(is_new.then_some(&self.fix))
    }

    fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    fn account(&self) -> Option<PoseAccount> {
        Some(account(&self.name, &self.feed))
    }
}
