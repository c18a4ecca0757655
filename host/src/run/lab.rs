//! Poses of a structure from a motion capture.
//!
//! ```text
//! Source ─ frames → Gate ─ bodies in the world, on the host's clock → Structure ─ one pose → pilot
//! ```
//!
//! While bodies contradict each other (labels are swapped, a module has broken away) there is no pose, and so the fleet holds. Why
//! there is none is told in words.

use modboat::observer::Fix;
use nalgebra::Vector3;
use pose::axes::{Axes, Pose, Unit};
use pose::feed::Feed;
use pose::frame::Label;
use pose::gate;
use pose::roster::Roster;
use pose::source::Source;
use pose::structure::{Found, Outcome, PlanarPose, Structure};
use protocol::time::FleetInstant;
use runlog::flotilla::Body;

use super::RunError;
use super::pose_source::{PoseAccount, PoseSource};
use super::stream::Stream;

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
    stream: Stream,
    view: View,
}

/// What is made of frames.
struct View {
    structure: Structure,
    /// The fleet's bodies, until all have been seen.
    awaited: Option<Roster>,
    fix: Fix,
    last: Option<(f64, PlanarPose)>,
    /// Which body sits on which module.
    fleet: Roster,
    /// The bodies of the newest frame, and the modules that the pose was made of.
    seen: Vec<(Label, Pose)>,
    used: Vec<u16>,
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
        let view = View {
            structure,
            awaited: Some(bodies.clone()),
            fix: Fix::default(),
            last: None,
            fleet: bodies,
            seen: Vec::new(),
            used: Vec::new(),
        };
        Self { stream: Stream::new(name, source, axes), view }
    }
}

impl View {
    /// The first body of the fleet that has not been seen since the beginning, and what is seen instead.
    fn unseen(&mut self, feed: &Feed) -> Option<String> {
        let awaited = self.awaited.as_ref()?;
        let labels: Vec<Label> = feed.figures().bodies().keys().chain(feed.bodies()).cloned().collect();
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
    fn locate(&mut self, feed: &Feed, seen: &gate::Fix) -> Result<PlanarPose, String> {
        if let Some(unseen) = self.unseen(feed) {
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
            Outcome::Found(found) => {
                self.used.clone_from(&found.used);
                misfit(&found).map_or(Ok(found.pose), Err)
            }
        }
    }

    /// Takes in a frame.
    fn take(&mut self, feed: &Feed, seen: &gate::Fix) -> Result<(), String> {
        self.seen.clone_from(&seen.bodies);
        self.used.clear();
        let pose = self.locate(feed, seen)?;
        self.last = Some((seen.captured_s, pose));
        self.fix =
            Fix { t_s: seen.captured_s, position_m: pose.position_m.into(), heading_rad: pose.heading_rad };
        Ok(())
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

impl<W> PoseSource<W> for LabPoses {
    type Pose = Fix;

    fn poll<'a>(&'a mut self, now: FleetInstant, _: Option<&'a W>) -> Result<Option<&'a Fix>, RunError> {
        let Self { stream, view } = self;
        let is_new = stream.poll(now, |feed, seen| view.take(feed, seen))?;
        Ok(is_new.then_some(&view.fix))
    }

    fn trouble(&self) -> Option<&str> {
        self.stream.trouble()
    }

    fn bodies(&self) -> Option<Vec<Body>> {
        let View { fleet, seen, used, .. } = &self.view;
        let one = |(label, pose): &(Label, Pose)| {
            let module = fleet.of(label).map_or(0, |entry| entry.module);
            let axis = pose.attitude * Vector3::x();
            Body {
                name: label.to_string(),
                module,
                position_m: [pose.position.x, pose.position.y],
                heading_rad: axis.y.atan2(axis.x),
                used: used.contains(&module),
            }
        };
        Some(seen.iter().map(one).collect())
    }

    fn account(&self) -> Option<PoseAccount> {
        Some(self.stream.account())
    }
}
