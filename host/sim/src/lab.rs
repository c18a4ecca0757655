//! A laboratory in a box: the cameras of a motion capture over simulated water, with what goes wrong in a real one.
//!
//! ```text
//! truth of every body → look → frame, as the server says it → a queue with latency, jitter and loss → what is sent
//! ```
//!
//! [`pose::server::Server`] sends what [`Cameras::poll`] gives. Noise is normal and white; latency is uniform about its mean;
//! frames stay in order, as in the one stream that a server sends. All *assumed*.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use pose::axes::{Axes, Pose};
use pose::frame::{Body, Frame, Label};
use pose::time::ServerInstant;
use quantity::{ParameterError, Range, check_ranges};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

pub use fault::{Fault, FaultError, Mishap};

mod fault;
#[cfg(test)]
mod tests;

/// Speed at which a module that has broken away drifts off, m/s. *Assumed.*
const AWAY_M_S: f64 = 0.03;
/// Latency of frames while the network is slow, s.
const SLOW_S: f64 = 0.5;

/// What the cameras and their network are like.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraParameters {
    /// Frames a second, Hz.
    pub rate_hz: f64,
    /// Standard deviation of each coordinate of a body, m.
    pub position_noise_m: f64,
    /// Standard deviation of each turn of a body, rad.
    pub attitude_noise_rad: f64,
    /// Mean time from the exposure to the sending of a frame, s.
    pub latency_s: f64,
    /// Greatest deviation from it, s.
    pub jitter_s: f64,
    /// Share of frames that are lost.
    pub loss: f64,
    /// The server's clock less the laboratory's, s.
    pub clock_ahead_s: f64,
}

impl CameraParameters {
    /// Refuses what cannot be, by the first offending key.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges(&[
            ("rate_hz", self.rate_hz, "Hz", Range::Positive),
            ("position_noise_m", self.position_noise_m, "m", Range::NonNegative),
            ("attitude_noise_rad", self.attitude_noise_rad, "rad", Range::NonNegative),
            ("latency_s", self.latency_s, "s", Range::NonNegative),
            ("jitter_s", self.jitter_s, "s", Range::NonNegative),
            ("loss", self.loss, "", Range::Share),
            ("clock_ahead_s", self.clock_ahead_s, "s", Range::Finite),
        ])
    }
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Cameras {
    parameters: CameraParameters,
    axes: Axes,
    labels: Vec<Label>,
    faults: Vec<Fault>,
    rng: ChaCha8Rng,
    number: u32,
    next_s: f64,
    /// When each is to be sent, s.
    queue: VecDeque<(f64, Frame)>,
    /// What a frozen stream goes on saying.
    frozen: Option<Vec<Body>>,
}

impl Cameras {
    /// Cameras that see bodies with these labels, in a laboratory with these axes.
    ///
    /// # Errors
    /// [`ParameterError`] for what cannot be, [`FaultError`] for the fault of a body that there is not.
    pub fn new(
        parameters: CameraParameters,
        axes: Axes,
        labels: Vec<Label>,
        faults: Vec<Fault>,
        seed: u64,
    ) -> Result<Self, LabError> {
        parameters.validate()?;
        for fault in &faults {
            fault.check(labels.len())?;
        }
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Ok(Self {
            parameters,
            axes,
            labels,
            faults,
            rng,
            number: 0,
            next_s: 0.0,
            queue: VecDeque::new(),
            frozen: None,
        })
    }

    /// Looks at `now_s` if a frame is due; `truth` is every body in the world (x east, y north, z up).
    pub fn look(&mut self, now_s: f64, truth: &[Pose]) {
        if now_s < self.next_s {
            return;
        }
        let period_s = 1.0 / self.parameters.rate_hz;
        self.next_s = (self.next_s + period_s).max(now_s);
        self.number = self.number.wrapping_add(1);
        let bodies = self.seen(now_s, truth);
        let captured_s = now_s + self.clock_ahead_s(now_s);
        let slow_s = if self.mishaps(now_s).any(|mishap| mishap == Mishap::Slow) { SLOW_S } else { 0.0 };
        let frame =
            Frame { number: Some(self.number), captured: ServerInstant::from_seconds(captured_s), bodies };
        let jitter_s = self.parameters.jitter_s * (2.0 * self.rng.random::<f64>() - 1.0);
        let late_s = (self.parameters.latency_s + jitter_s).max(0.0) + slow_s;
        if self.rng.random::<f64>() < self.parameters.loss {
            return;
        }
        let sent_s = self.queue.back().map_or(0.0, |(last_s, _)| *last_s).max(now_s + late_s);
        if self.mishaps(now_s).any(|mishap| mishap == Mishap::Doubled) {
            self.queue.push_back((sent_s, frame.clone()));
        }
        self.queue.push_back((sent_s, frame));
    }

    /// The next frame that is to be sent by `now_s`. A server that is dead sends none, and they are gone.
    pub fn poll(&mut self, now_s: f64) -> Option<Frame> {
        while self.queue.front().is_some_and(|(sent_s, _)| *sent_s <= now_s) {
            let (_, frame) = self.queue.pop_front()?;
            if !self.is_dead(now_s) && !self.mishaps(now_s).any(|mishap| mishap == Mishap::Blind) {
                return Some(frame);
            }
        }
        None
    }

    /// Whether the server is dead at `now_s`: it answers nothing either.
    #[must_use]
    pub fn is_dead(&self, now_s: f64) -> bool {
        self.mishaps(now_s).any(|mishap| mishap == Mishap::Dead)
    }

    /// The server's clock less the laboratory's at `now_s`, s.
    #[must_use]
    pub fn clock_ahead_s(&self, now_s: f64) -> f64 {
        let jumps =
            self.mishaps(now_s).map(|mishap| if let Mishap::Clock(by_s) = mishap { by_s } else { 0.0 });
        self.parameters.clock_ahead_s + jumps.sum::<f64>()
    }

    fn mishaps(&self, now_s: f64) -> impl Iterator<Item = Mishap> + '_ {
        self.faults.iter().filter(move |fault| fault.lasts(now_s)).map(|fault| fault.mishap)
    }

    /// What the server says of every body.
    fn seen(&mut self, now_s: f64, truth: &[Pose]) -> Vec<Body> {
        if self.mishaps(now_s).any(|mishap| mishap == Mishap::Frozen) {
            if let Some(frozen) = &self.frozen {
                return frozen.clone();
            }
        } else {
            self.frozen = None;
        }
        let Self { rng, parameters, axes, labels, faults, .. } = self;
        let mut said: Vec<Pose> = truth.to_vec();
        for fault in faults.iter().filter(|fault| fault.lasts(now_s)) {
            if let Mishap::Away(body) = fault.mishap {
                let direction = TAU * 0.381_966 * body as f64;
                let by = AWAY_M_S * (now_s - fault.at_s);
                said[body].position += Vector3::new(direction.cos(), direction.sin(), 0.0) * by;
            }
        }
        for pose in &mut said {
            let mut normal = || -> f64 { StandardNormal.sample(rng) };
            pose.position += Vector3::from_fn(|_, _| parameters.position_noise_m * normal());
            let turn = Vector3::from_fn(|_, _| parameters.attitude_noise_rad * normal());
            pose.attitude *= UnitQuaternion::from_scaled_axis(turn);
        }
        let mut bodies: Vec<Body> =
            said.iter().zip(labels.iter()).map(|(pose, label)| body(axes, pose, label)).collect();
        for fault in faults.iter().filter(|fault| fault.lasts(now_s)) {
            match fault.mishap {
                Mishap::Swapped(first, second) => {
                    let label = bodies[first].label.clone();
                    bodies[first].label = std::mem::replace(&mut bodies[second].label, label);
                }
                Mishap::Lost(body) => bodies[body].tracked = false,
                Mishap::NotANumber(body) => bodies[body].position = Vector3::repeat(f64::NAN),
                _ => {}
            }
        }
        // Servers name bodies in their own order, whatever they took for which.
        bodies.sort_by(|a, b| a.label.cmp(&b.label));
        if self.mishaps(now_s).any(|mishap| mishap == Mishap::Frozen) {
            self.frozen = Some(bodies.clone());
        }
        bodies
    }
}

fn body(axes: &Axes, pose: &Pose, label: &Label) -> Body {
    let said = axes.from_world(pose);
    Body {
        label: label.clone(),
        position: said.position,
        attitude: said.attitude.into_inner(),
        tracked: true,
        error: None,
    }
}

/// Why there is no laboratory.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum LabError {
    /// A number.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A fault.
    #[error(transparent)]
    Fault(#[from] FaultError),
}
