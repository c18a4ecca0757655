//! What a motion-capture system says: frames of bodies, in its own unit and axes.

use std::fmt;
use std::sync::Arc;

use nalgebra::{Quaternion, Vector3};

use crate::time::{HostInstant, ServerInstant};

/// All bodies of one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The server's count of frames; VRPN has none.
    pub number: Option<u32>,
    /// When the cameras saw it, on the server's clock.
    pub captured: ServerInstant,
    /// The bodies, in the server's order.
    pub bodies: Vec<Body>,
}

/// One body of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Which body.
    pub label: Label,
    /// Where its origin is, in the server's unit and axes; not finite where the server says so.
    pub position: Vector3<f64>,
    /// How it is turned, in the server's axes; of unit length where the server keeps to its protocol.
    pub attitude: Quaternion<f64>,
    /// Whether the server saw it in this frame.
    pub tracked: bool,
    /// The server's figure for the fit of the markers, in the server's unit; `None` where the protocol has none.
    pub error: Option<f64>,
}

/// What a server calls a body: a number (NatNet), a name (QTM, VRPN), or both.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Label {
    /// The streaming ID of NatNet, the sensor of VRPN.
    pub number: Option<i32>,
    /// The name; with NatNet it comes from the model definitions, so later than the first frames.
    pub name: Option<Arc<str>>,
}

impl Label {
    /// A label with a name alone.
    pub fn named(name: &str) -> Self {
        Self { number: None, name: Some(name.into()) }
    }

    /// A label with both.
    pub fn new(number: i32, name: &str) -> Self {
        Self { number: Some(number), name: Some(name.into()) }
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.name, self.number) {
            (Some(name), Some(number)) => write!(f, "\"{name}\" (number {number})"),
            (Some(name), None) => write!(f, "\"{name}\""),
            (None, Some(number)) => write!(f, "number {number}"),
            (None, None) => write!(f, "without a name"),
        }
    }
}

/// A frame that has come, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrival {
    /// The frame.
    pub frame: Frame,
    /// When the host took it from its socket.
    pub arrived: HostInstant,
}
