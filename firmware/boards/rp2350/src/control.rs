//! The control loop: the module's firmware, its supply, its lamp and its watchdog, at a fixed interval.
//!
//! ```text
//! every interval:      supply → tick → lamp → watchdog ┐
//! for every datagram:  handle_datagram                 ┴→ poll_transmit until there is nothing
//! ```
//!
//! Datagrams are taken in as they come, not at the next tick: the fleet time is worked out from when an answer came. A tick that is
//! due goes before a datagram that waits, so somebody who floods the module delays a tick by one datagram at most.
//!
//! Assumptions and limits: it runs where nothing but short interrupts delays it ([`priority`](crate::priority)), and no tick
//! takes as long as an interval.

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use firmware::modboat::Modboat;
use firmware::modboat::encoder::Encoder;
use firmware::modboat::servo::CurrentSense;
use firmware::rov::{Rov, Supply};
use protocol::units::{Micros, MicrosSpan};
use protocol::{Faults, MAX_DATAGRAM, ModuleState};

use crate::lamp::Lamp;
use crate::link::Link;
use crate::supply::PowerSensor;
use crate::watchdog::Watchdog;

/// How often the lamp of a board is looked after that does nothing else: its shortest flash is twice as long.
const BLINK_EVERY: Duration = Duration::from_millis(50);

/// A module of either kind.
pub trait Module {
    /// One turn of the loop at `now`, own clock.
    fn tick(&mut self, now: Micros, supply: &Supply);

    /// Follows a datagram that arrived at `now`, own clock.
    fn handle_datagram(&mut self, now: Micros, datagram: &[u8]);

    /// The next datagram to send.
    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]>;

    /// What it is doing at `now`, own clock, and what is wrong with it.
    fn state(&self, now: Micros) -> (ModuleState, Faults);
}

// Outputs of this chip do not fail, and a module watches its own; what is not let in is counted by the link.
impl<E: Encoder, S: CurrentSense, P: SetDutyCycle, A: OutputPin, B: OutputPin> Module
    for Modboat<E, S, P, A, B>
{
    fn tick(&mut self, now: Micros, supply: &Supply) {
        let _ = self.tick(now, supply.battery);
    }

    fn handle_datagram(&mut self, now: Micros, datagram: &[u8]) {
        let _ = self.handle_datagram(now, datagram);
    }

    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.poll_transmit(buffer)
    }

    fn state(&self, now: Micros) -> (ModuleState, Faults) {
        (self.endpoint().state(now), self.endpoint().failsafe().faults())
    }
}

impl<P: SetDutyCycle> Module for Rov<P> {
    fn tick(&mut self, now: Micros, supply: &Supply) {
        let _ = self.tick(now, supply);
    }

    fn handle_datagram(&mut self, now: Micros, datagram: &[u8]) {
        let _ = self.handle_datagram(now, datagram);
    }

    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.poll_transmit(buffer)
    }

    fn state(&self, now: Micros) -> (ModuleState, Faults) {
        (self.endpoint().state(now), self.endpoint().failsafe().faults())
    }
}

/// The module's own clock: since boot.
#[must_use]
pub fn now() -> Micros {
    Micros(Instant::now().as_micros())
}

/// Runs a module for ever.
pub async fn run<M: Module>(
    mut module: M,
    mut power: PowerSensor,
    mut lamp: Lamp,
    mut watchdog: Watchdog,
    link: &Link,
    interval: MicrosSpan,
) -> ! {
    let mut ticks = Ticker::every(Duration::from_micros(interval.0.into()));
    let mut buffer = [0; MAX_DATAGRAM];
    loop {
        match select(ticks.next(), link.receive()).await {
            Either::First(()) => {
                let now = now();
                module.tick(now, &power.measure());
                let (state, faults) = module.state(now);
                lamp.show(now, state, faults);
                watchdog.feed();
            }
            Either::Second(datagram) => module.handle_datagram(now(), &datagram),
        }
        while let Some(datagram) = module.poll_transmit(&mut buffer) {
            link.send(datagram);
        }
    }
}

/// What a board does without a valid configuration, for ever: it blinks. Its outputs stay as they are, and there is no network.
pub async fn blink(mut lamp: Lamp, mut watchdog: Watchdog) -> ! {
    let mut ticks = Ticker::every(BLINK_EVERY);
    loop {
        ticks.next().await;
        lamp.show(now(), ModuleState::Unprovisioned, Faults::default());
        watchdog.feed();
    }
}
