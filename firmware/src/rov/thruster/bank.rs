//! All thrusters of a module on their pins.
//!
//! duty = p·f·D/10⁶ with the pulse p in µs, the frame rate f in Hz and the timer's greatest duty D
//!
//! - **Arming.** From the first tick on every controller sees neutral for [`BankConstants::arming`] before any thrust.
//!   Blue Robotics asks for a stop signal of a few seconds before a Basic ESC obeys; the three of the default are *assumed*.
//! - **Order and direction.** Thruster k drives pin [`ThrusterMounting::output`]; a pin that no thruster has is never touched. The pulse of a reversed one is mirrored at
//!   neutral, after the law: it turns the other way, and its propeller, weaker astern than ahead, pushes as before.
//! - The pulse reported is the one the timer's steps allow, of the last write that succeeded.
//!
//! Assumptions and limits: at most [`MAX_THRUSTERS`]; a timer whose step is coarser than the table's 4 µs is refused.

use core::fmt;

use embedded_hal::pwm::SetDutyCycle;
use heapless::Vec;
use protocol::configuration::{BankConstants, ThrusterMounting};
use protocol::message::MAX_THRUSTERS;
use protocol::time::LocalInstant;
use protocol::units::{Newtons, PulseMicros, Volts};

use super::esc::Esc;
use super::law::{self, NEUTRAL};
use super::t200::PULSE_STEP_US;

/// Least and greatest rate of frames, Hz: what a Basic ESC reads.
pub const FRAME_RATE_HZ: (f32, f32) = (50.0, 400.0);

/// Why there is no bank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BankError {
    /// No thruster, more than fit, or fewer pins than thrusters.
    Count {
        /// Thrusters given.
        thrusters: usize,
        /// Pins given.
        pins: usize,
    },
    /// A pin that does not exist or that two thrusters share.
    Output(u8),
    /// Frame rate, Hz, out of [`FRAME_RATE_HZ`].
    FrameRate(f32),
    /// A slew limit, N/s, that is not positive.
    Slew(f32),
    /// The timer's step, µs, is coarser than the table's.
    Step(f32),
}

impl fmt::Display for BankError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { thrusters, pins } => {
                write!(
                    f,
                    "{thrusters} thrusters on {pins} pins: 1 to {MAX_THRUSTERS}, each with a pin of its own"
                )
            }
            Self::Output(output) => write!(f, "output {output} does not exist or is taken twice"),
            Self::FrameRate(hz) => {
                write!(f, "frame rate of {hz} Hz must lie in {}–{} Hz", FRAME_RATE_HZ.0, FRAME_RATE_HZ.1)
            }
            Self::Slew(slew) => write!(f, "slew limit of {slew} N/s must be positive"),
            Self::Step(us) => write!(f, "the timer's step of {us} µs is coarser than {PULSE_STEP_US} µs"),
        }
    }
}

impl core::error::Error for BankError {}

/// One thruster's wiring and present.
#[derive(Clone, Copy, Debug)]
struct Channel {
    mounting: ThrusterMounting,
    esc: Esc,
}

/// All thrusters of a module on their pins.
#[derive(Debug)]
pub struct Bank<P> {
    pins: Vec<P, MAX_THRUSTERS>,
    channels: Vec<Channel, MAX_THRUSTERS>,
    pulses: Vec<PulseMicros, MAX_THRUSTERS>,
    constants: BankConstants,
    /// First tick and last tick.
    ticked: Option<(LocalInstant, LocalInstant)>,
}

impl<P: SetDutyCycle> Bank<P> {
    /// From pins in the board's order and thrusters in the order of the cycle's thrusts. Nothing is driven yet.
    ///
    /// # Errors
    /// [`BankError`].
    pub fn new(
        pins: impl IntoIterator<Item = P>,
        mountings: &[ThrusterMounting],
        constants: BankConstants,
    ) -> Result<Self, BankError> {
        let mut fitted = Vec::new();
        for pin in pins {
            let pins = fitted.len().saturating_add(1);
            fitted.push(pin).map_err(|_| BankError::Count { thrusters: mountings.len(), pins })?;
        }
        let pins = fitted;
        let count = BankError::Count { thrusters: mountings.len(), pins: pins.len() };
        if mountings.is_empty() || mountings.len() > pins.len() {
            return Err(count);
        }
        let (least_hz, greatest_hz) = FRAME_RATE_HZ;
        if !(constants.frame_rate_hz >= least_hz && constants.frame_rate_hz <= greatest_hz) {
            return Err(BankError::FrameRate(constants.frame_rate_hz));
        }
        if constants.esc.slew_n_s.is_nan() || constants.esc.slew_n_s <= 0.0 {
            return Err(BankError::Slew(constants.esc.slew_n_s));
        }
        let mut channels = Vec::new();
        for (index, &mounting) in mountings.iter().enumerate() {
            let twice = mountings.iter().skip(index.saturating_add(1)).any(|m| m.output == mounting.output);
            let pin = pins.get(usize::from(mounting.output)).filter(|_| !twice);
            let pin = pin.ok_or(BankError::Output(mounting.output))?;
            let step_us = step_us(pin.max_duty_cycle(), constants.frame_rate_hz);
            // Infinite for a timer that does not count.
            if step_us > PULSE_STEP_US {
                return Err(BankError::Step(step_us));
            }
            channels.push(Channel { mounting, esc: Esc::default() }).map_err(|_| count)?;
        }
        let pulses = channels.iter().map(|_| NEUTRAL).collect();
        Ok(Self { pins, channels, pulses, constants, ticked: None })
    }

    /// Drives every pin at `now`, own clock: `thrusts` along each thruster's axis, neutral where there is none.
    ///
    /// # Errors
    /// The first output that failed; the others are driven all the same.
    pub fn tick(&mut self, now: LocalInstant, thrusts: &[Newtons], battery: Volts) -> Result<(), P::Error> {
        let (first, last) = self.ticked.unwrap_or((now, now));
        self.ticked = Some((first, now));
        let (elapsed, armed) = (now.since(last), self.is_armed());
        let BankConstants { frame_rate_hz, esc, .. } = self.constants;
        let mut outcome = Ok(());
        let demanded = thrusts.iter().copied().chain(core::iter::repeat(Newtons(0.0)));
        for ((channel, reported), demand) in self.channels.iter_mut().zip(&mut self.pulses).zip(demanded) {
            let ThrusterMounting { output, reversed } = channel.mounting;
            let demand = if armed { demand } else { Newtons(0.0) };
            let ahead = law::pulse(channel.esc.tick(now, elapsed, demand, &esc), battery);
            let pulse = if reversed { law::mirrored(ahead) } else { ahead };
            let Some(pin) = self.pins.get_mut(usize::from(output)) else { continue };
            let step_us = step_us(pin.max_duty_cycle(), frame_rate_hz);
            let duty = duty_of(pulse, step_us);
            match pin.set_duty_cycle(duty) {
                Ok(()) => *reported = PulseMicros(f32::from(duty) * step_us),
                Err(error) => outcome = outcome.and(Err(error)),
            }
        }
        outcome
    }

    /// What is put out, in the order of the thrusters.
    #[must_use]
    pub const fn pulses(&self) -> &Vec<PulseMicros, MAX_THRUSTERS> {
        &self.pulses
    }

    /// True once every controller has seen neutral for long enough to obey.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.ticked.is_some_and(|(first, last)| last.since(first) >= self.constants.arming)
    }

    /// Gives the pins back.
    pub fn release(self) -> Vec<P, MAX_THRUSTERS> {
        self.pins
    }
}

/// Width of one count of the timer, µs: 10⁶/(f·D).
fn step_us(max_duty: u16, frame_rate_hz: f32) -> f32 {
    1e6 / (frame_rate_hz * f32::from(max_duty))
}

/// The duty whose pulse is nearest.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a pulse is shorter than the frame, so its counts fit the timer"
)]
fn duty_of(pulse: PulseMicros, step_us: f32) -> u16 {
    libm::roundf(pulse.0 / step_us) as u16
}

#[cfg(test)]
mod tests;
