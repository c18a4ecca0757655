//! Which frames, and which bodies of them, are fixes: everything else is dropped and counted.
//!
//! A frame is held in this order against: the one before (doubled), the clock (off the clock), the newest (out of order), the time
//! since a body last moved (frozen), its bodies, and whether one is left (without a body).
//!
//! A body teleports when it is further from its last place than [`Limits::fastest_m_s`] and [`Limits::slack_m`] allow. It is believed
//! at the new place after [`Limits::believed_after`] frames in a row that fit each other: it was carried there, or its label has
//! changed its body.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};

use crate::axes::{Axes, Pose};
use crate::clock::Clock;
use crate::frame::{Arrival, Body, Frame, Label};
use crate::ledger::{BodyFault, FrameFault, Ledger};
use crate::time::ServerInstant;

/// An attitude whose length is further from one is no turn. Single precision leaves 1e-6.
const LENGTH_WITHIN: f64 = 0.01;
/// Bodies that are remembered: `MAX_RIGIDBODIES` of NatNet.
const MOST_BODIES: usize = 1000;

/// What the gate holds frames against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Positions of all bodies unchanged to the last digit for this time mean a frozen stream, s; `None` where bodies may lie
    /// perfectly still, as in a simulation without noise.
    pub frozen_after_s: Option<f64>,
    /// The fastest a body moves, m/s.
    pub fastest_m_s: f64,
    /// How far positions may be off beside that, m.
    pub slack_m: f64,
    /// Frames in a row after which a body is believed at a new place.
    pub believed_after: u32,
}

impl Default for Limits {
    /// *Assumed*: noise leaves no two frames of any camera alike, so half a second without change is a frozen stream; 3 m/s is more than boat and
    /// ROV do; 5 cm is more than noise.
    fn default() -> Self {
        Self { frozen_after_s: Some(0.5), fastest_m_s: 3.0, slack_m: 0.05, believed_after: 5 }
    }
}

/// A frame that was accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// The server's count.
    pub number: Option<u32>,
    /// When it was captured, on the host's clock, s from the program's start.
    pub captured_s: f64,
    /// When it came, s.
    pub arrived_s: f64,
    /// How much longer than the least delay it took, s.
    pub late_s: f64,
    /// The bodies that were accepted, in the world's axes.
    pub bodies: Vec<(Label, Pose)>,
}

/// Where a body was last, and where it may be now.
#[derive(Clone, Copy, Debug)]
struct Place {
    at_s: f64,
    position: Vector3<f64>,
    /// A new place that is not believed yet, when, and for how many frames in a row.
    doubted: Option<(f64, Vector3<f64>, u32)>,
}

/// Holds frames against what is known.
#[derive(Clone, Debug)]
pub struct Gate {
    axes: Axes,
    limits: Limits,
    clock: Clock,
    ledger: Ledger,
    newest_s: Option<f64>,
    /// The stamp of the newest frame, and the bodies that came with it.
    last: Option<(ServerInstant, Vec<Label>)>,
    /// What each body's position was in the server's own digits.
    digits: BTreeMap<Label, [u64; 3]>,
    /// When a body last moved, by arrival.
    moved_s: f64,
    places: BTreeMap<Label, Place>,
}

impl Gate {
    /// A gate for the frames of one source.
    pub fn new(axes: Axes, limits: Limits) -> Self {
        Self {
            axes,
            limits,
            clock: Clock::default(),
            ledger: Ledger::default(),
            newest_s: None,
            last: None,
            digits: BTreeMap::new(),
            moved_s: 0.0,
            places: BTreeMap::new(),
        }
    }

    /// The account so far.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The server's clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The server's clock, to add exchanges of stamps to it.
    pub fn clock_mut(&mut self) -> &mut Clock {
        &mut self.clock
    }

    /// Takes a frame: a fix, or why it is none.
    ///
    /// # Errors
    /// The fault, which is in the ledger too.
    pub fn take(&mut self, arrival: &Arrival) -> Result<Fix, FrameFault> {
        let became = self.judge(arrival);
        self.ledger.enter_frame(became.as_ref().map(drop).map_err(|fault| *fault));
        became
    }

    fn judge(&mut self, arrival: &Arrival) -> Result<Fix, FrameFault> {
        let (frame, arrived_s) = (&arrival.frame, arrival.arrived.seconds());
        if self.is_doubled(frame) {
            return Err(FrameFault::Doubled);
        }
        let reading = self.clock.read(frame.captured, arrival.arrived).ok_or(FrameFault::OffTheClock)?;
        if self.newest_s.is_some_and(|newest_s| reading.captured_s < newest_s) {
            return Err(FrameFault::OutOfOrder);
        }
        self.newest_s = Some(reading.captured_s);
        self.remember(frame);
        if self.is_frozen(frame, arrived_s) {
            return Err(FrameFault::Frozen);
        }
        let mut bodies = Vec::with_capacity(frame.bodies.len());
        for body in &frame.bodies {
            let became = self.judge_body(body, reading.captured_s);
            self.ledger.enter_body(became.as_ref().map(drop).map_err(|fault| *fault));
            bodies.extend(became.ok().map(|pose| (body.label.clone(), pose)));
        }
        if bodies.is_empty() {
            return Err(FrameFault::WithoutBody);
        }
        let (captured_s, late_s) = (reading.captured_s, reading.late_s);
        Ok(Fix { number: frame.number, captured_s, arrived_s, late_s, bodies })
    }

    /// Whether the frame has come before, or another of the same moment: of frames without a number one with a body that has come.
    fn is_doubled(&self, frame: &Frame) -> bool {
        self.last.as_ref().is_some_and(|(captured, labels)| {
            let again = || frame.bodies.iter().any(|body| labels.contains(&body.label));
            frame.captured == *captured && (frame.number.is_some() || again())
        })
    }

    fn remember(&mut self, frame: &Frame) {
        let labels = frame.bodies.iter().map(|body| body.label.clone());
        match &mut self.last {
            Some((captured, known)) if *captured == frame.captured => known.extend(labels),
            last => *last = Some((frame.captured, labels.collect())),
        }
    }

    fn is_frozen(&mut self, frame: &Frame, arrived_s: f64) -> bool {
        let mut any = false;
        let mut moved = false;
        for body in frame.bodies.iter().filter(|body| body.tracked) {
            any = true;
            let digits = <[f64; 3]>::from(body.position).map(f64::to_bits);
            let full = self.digits.len() >= MOST_BODIES;
            moved |= match self.digits.get_mut(&body.label) {
                Some(known) => std::mem::replace(known, digits) != digits,
                None if full => true,
                None => self.digits.insert(body.label.clone(), digits).is_none(),
            };
        }
        if moved || !any {
            self.moved_s = arrived_s;
        }
        self.limits.frozen_after_s.is_some_and(|allowed_s| arrived_s - self.moved_s > allowed_s)
    }

    fn judge_body(&mut self, body: &Body, captured_s: f64) -> Result<Pose, BodyFault> {
        if !body.tracked {
            return Err(BodyFault::Untracked);
        }
        let finite = body.position.iter().chain(body.attitude.coords.iter()).all(|number| number.is_finite());
        if !finite || (body.attitude.norm() - 1.0).abs() > LENGTH_WITHIN {
            return Err(BodyFault::NotFinite);
        }
        let attitude = UnitQuaternion::from_quaternion(body.attitude);
        let pose = self.axes.to_world(&Pose { position: body.position, attitude });
        self.follow(&body.label, captured_s, pose.position)?;
        Ok(pose)
    }

    /// Holds a position against the last one.
    fn follow(&mut self, label: &Label, at_s: f64, position: Vector3<f64>) -> Result<(), BodyFault> {
        let limits = self.limits;
        let reaches = |from_s: f64, from: Vector3<f64>| {
            (position - from).norm() <= limits.slack_m + limits.fastest_m_s * (at_s - from_s).max(0.0)
        };
        let here = Place { at_s, position, doubted: None };
        let Some(place) = self.places.get_mut(label) else {
            if self.places.len() < MOST_BODIES {
                self.places.insert(label.clone(), here);
            }
            return Ok(());
        };
        if reaches(place.at_s, place.position) {
            *place = here;
            return Ok(());
        }
        let in_a_row = match place.doubted {
            Some((from_s, from, in_a_row)) if reaches(from_s, from) => in_a_row + 1,
            _ => 1,
        };
        if in_a_row >= limits.believed_after {
            *place = here;
            return Ok(());
        }
        place.doubted = Some((at_s, position, in_a_row));
        Err(BodyFault::Teleported)
    }
}
