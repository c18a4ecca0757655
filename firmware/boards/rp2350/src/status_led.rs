//! The status LED of the board; `firmware::indicator` decides when it is lit.
//!
//! A board has two: one of its own on a pin, which is seen through a hull, and the one that is soldered to it. On the Pico 2 W that
//! one hangs on the radio, so it is only told to it when it changes, and is dark without a network.

use embassy_rp::gpio::Output;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use firmware::indicator;
use protocol::time::LocalInstant;
use protocol::{Faults, ModuleState};

/// Signal for a status LED that another task switches: true is lit.
pub type Switch = Signal<CriticalSectionRawMutex, bool>;

/// One status LED.
pub enum Light {
    /// Lit while the pin is high.
    Pin(Output<'static>),
    /// Lit when the switch is seen to.
    Switch(&'static Switch),
}

/// The status LEDs of a board.
pub struct StatusLed {
    lights: [Light; 2],
    lit: Option<bool>,
}

impl StatusLed {
    /// Of both status LEDs, which are as they are until the first state is shown.
    #[must_use]
    pub const fn new(lights: [Light; 2]) -> Self {
        Self { lights, lit: None }
    }

    /// Shows a state and faults at `now`, own clock.
    pub fn show(&mut self, now: LocalInstant, state: ModuleState, faults: Faults) {
        let lit = indicator::is_lit(now, state, faults);
        if self.lit.replace(lit) == Some(lit) {
            return;
        }
        for light in &mut self.lights {
            match light {
                Light::Pin(pin) => pin.set_level(lit.into()),
                Light::Switch(switch) => switch.signal(lit),
            }
        }
    }
}
