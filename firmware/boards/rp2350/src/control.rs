//! The control loop: the module's firmware, its supply, its status LED and its watchdog, at a fixed interval.
//!
//! ```text
//! every interval:      supply → tick → status LED → watchdog ┐
//! for every datagram:  handle_datagram                       ┴→ poll_transmit until there is nothing
//! ```
//!
//! Datagrams are taken in as they come, not at the next tick: the fleet time is worked out from when an answer came. A tick that is
//! due goes before a datagram that waits, so a sender that floods the module delays a tick by one datagram at most.
//!
//! Assumptions and limits: it runs where nothing but short interrupts delays it ([`priority`](crate::priority)), and no tick
//! takes as long as an interval.

use embassy_futures::select::{Either, select};
use embassy_time::{Instant, Ticker};
use firmware::module::{Module, Status};
use protocol::time::{Duration, LocalInstant};
use protocol::{Faults, MAX_DATAGRAM, ModuleState};

use crate::link::Link;
use crate::status_led::StatusLed;
use crate::supply::PowerSensor;
use crate::watchdog::Watchdog;

/// How often the status LED of a board is looked after that does nothing else: its shortest flash is twice as long.
const BLINK_EVERY: embassy_time::Duration = embassy_time::Duration::from_millis(50);

/// The module's own clock: since boot.
#[must_use]
pub fn now() -> LocalInstant {
    LocalInstant(Instant::now().as_micros())
}

/// Runs a module for ever.
pub async fn run<M: Module>(
    mut module: M,
    mut power: PowerSensor,
    mut status_led: StatusLed,
    mut watchdog: Watchdog,
    link: &Link,
    interval: Duration,
) -> ! {
    let interval = embassy_time::Duration::from_micros(interval.0.into());
    let mut ticks = Ticker::every(interval);
    let mut buffer = [0; MAX_DATAGRAM];
    loop {
        match select(ticks.next(), link.receive()).await {
            Either::First(()) => {
                let now = now();
                // Outputs of this chip do not fail, and a module watches its own.
                let _ = module.tick(now, &power.measure());
                let Status { state, faults, .. } = module.status(now);
                status_led.show(now, state, faults);
                watchdog.feed(interval);
            }
            Either::Second(datagram) => {
                // What is not let in is counted by the link.
                let _ = module.handle_datagram(now(), &datagram);
            }
        }
        while let Some(datagram) = module.poll_transmit(&mut buffer) {
            link.send(datagram);
        }
    }
}

/// What a board does without a valid configuration, for ever: it blinks. Its outputs stay as they are, and there is no network.
pub async fn blink(mut status_led: StatusLed, mut watchdog: Watchdog) -> ! {
    let mut ticks = Ticker::every(BLINK_EVERY);
    loop {
        ticks.next().await;
        status_led.show(now(), ModuleState::Unprovisioned, Faults::default());
        watchdog.feed(BLINK_EVERY);
    }
}
