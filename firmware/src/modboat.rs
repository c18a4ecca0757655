//! A whole Modboat: the link endpoint above the tail.
//!
//! A board calls [`Modboat::tick`] at the servo rate, [`Modboat::handle_datagram`] for every datagram that came, and
//! sends what [`Modboat::poll_transmit`] gives. The simulated module of the host does exactly the same.

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use protocol::DecodeError;
use protocol::units::{Amperes, Micros, Volts};

use crate::encoder::Encoder;
use crate::endpoint::Endpoint;
use crate::motor::ErrorOf;
use crate::servo::CurrentSense;
use crate::swimmer::{Measurement, Swimmer};
use crate::tail::Tail;

/// See the module's documentation.
#[derive(Debug)]
pub struct Modboat<E, S, P, A, B> {
    endpoint: Endpoint<Swimmer>,
    tail: Tail<E, S, P, A, B>,
}

impl<E: Encoder, S: CurrentSense, P: SetDutyCycle, A: OutputPin, B: OutputPin> Modboat<E, S, P, A, B> {
    /// From its two halves.
    #[must_use]
    pub const fn new(endpoint: Endpoint<Swimmer>, tail: Tail<E, S, P, A, B>) -> Self {
        Self { endpoint, tail }
    }

    /// One turn of the servo loop at `now`, own clock; then whatever the link has to say.
    ///
    /// # Errors
    /// The output of the motor bridge that failed; the link goes on all the same.
    pub fn tick(&mut self, now: Micros, battery: Volts) -> Result<(), ErrorOf<P, A, B>> {
        let (outcome, current) = match self.endpoint.reference(now) {
            Some(reference) => match self.tail.tick(&reference) {
                Ok(status) => (Ok(()), status.current),
                Err(error) => (Err(error), None),
            },
            // Just booted: look where the tail is before moving it.
            None => {
                self.tail.locate();
                (self.tail.coast(), None)
            }
        };
        let counter = self.tail.counter();
        let measurement = Measurement {
            tail: counter.unwrapped(),
            rate: counter.rate(),
            current: current.unwrap_or(Amperes(0.0)),
            battery,
        };
        self.endpoint.handle_timer(now, &measurement);
        outcome
    }

    /// Follows one datagram that arrived at `now`, own clock.
    ///
    /// # Errors
    /// [`DecodeError`] if it is none; nothing happens then.
    pub fn handle_datagram(&mut self, now: Micros, datagram: &[u8]) -> Result<(), DecodeError> {
        self.endpoint.handle_datagram(now, datagram)
    }

    /// The next datagram to send; see [`Endpoint::poll_transmit`].
    pub fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.endpoint.poll_transmit(buffer)
    }

    /// Its side of the link.
    #[must_use]
    pub const fn endpoint(&self) -> &Endpoint<Swimmer> {
        &self.endpoint
    }

    /// Its tail.
    #[must_use]
    pub const fn tail(&self) -> &Tail<E, S, P, A, B> {
        &self.tail
    }
}
