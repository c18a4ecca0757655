//! A simulated module of any kind: power, clock and radio about the firmware, which runs on simulated [`Hardware`].
//!
//! It has a clock of its own, with an offset and a drift, so that the fleet time it learns over the link is really
//! learnt. Runs in one process and `flotilla module` use the same code.
//!
//! Times are true time, which is the fleet's: the simulated host reads a clock without error. In `flotilla module` the clock of the
//! process stands for it.

use firmware::link::session::{Identity, Link};
use firmware::module::{Module, Status, Supply};
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::{FleetId, MAX_DATAGRAM, ModuleId, ModuleKey, ModuleState, Radio};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::clock::ClockParameters;

/// A module's own clock: local = offset + (1 + drift)·true.
#[derive(Clone, Copy, Debug)]
struct LocalClock {
    offset_s: f64,
    rate: f64,
}

impl LocalClock {
    fn read(&self, now: FleetInstant) -> LocalInstant {
        LocalInstant(((self.offset_s + self.rate * now.as_secs_f64()) * 1e6) as u64)
    }
}

/// How a module of any kind is set up.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    /// Its number.
    pub id: ModuleId,
    /// Its fleet.
    pub fleet: FleetId,
    /// Its key.
    pub key: ModuleKey,
    /// Pause between two reports.
    pub report_every: Duration,
    /// How wrong its clock is.
    pub clock: &'a ClockParameters,
    /// Decides its clock, its boot time and its boot nonces.
    pub seed: u64,
}

/// What the firmware of one kind of module runs on.
pub trait Hardware {
    /// The firmware crate's module on these pins.
    type Firmware: Module;
    /// What the water feels of it.
    type Actuation: Default;
    /// Why no firmware runs on it.
    type Error;
    /// How sure of the fleet time it must be to take a cycle.
    const SURE_WITHIN: Duration;

    /// The firmware as it starts.
    ///
    /// # Errors
    /// Why it does not.
    fn boot(&self, identity: Identity) -> Result<Self::Firmware, Self::Error>;

    /// One tick at `now`: what is before the firmware's turn, that turn by `run`, what comes after it.
    fn tick<T>(&mut self, now: FleetInstant, run: impl FnOnce(&Self, &Supply) -> T) -> T;

    /// The firmware's outputs are gone.
    fn power_off(&mut self);

    /// Writes what the water feels of it now.
    fn actuate(&self, actuation: &mut Self::Actuation);
}

/// One module at one end of a radio.
pub struct Simulated<H: Hardware, R: Radio> {
    pub(super) hardware: H,
    /// Its identity at its next boot.
    identity: Identity,
    firmware: Option<H::Firmware>,
    clock: LocalClock,
    radio: R,
    host: R::Address,
    rng: ChaCha8Rng,
    boots_at: FleetInstant,
    unheard: u64,
}

impl<H: Hardware, R: Radio> Simulated<H, R> {
    /// A module that boots within the first 50 ms and talks to `host` over `radio`.
    ///
    /// # Errors
    /// Why the firmware does not run on this hardware.
    pub fn new(setup: &Setup<'_>, hardware: H, radio: R, host: R::Address) -> Result<Self, H::Error> {
        let &Setup { id: module, fleet, ref key, report_every, clock, seed } = setup;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let clock = LocalClock {
            offset_s: clock.offset_s * rng.random::<f64>(),
            rate: 1.0 + clock.drift_ppm * 1e-6 * (2.0 * rng.random::<f64>() - 1.0),
        };
        let boots_at = FleetInstant(rng.random_range(0..50_000));
        let (key, boot, sure_within) = (key.clone(), rng.random(), H::SURE_WITHIN);
        let mut identity = Identity { module, fleet, key, boot, report_every, sure_within };
        // A module that cannot be built says so now, not when it boots.
        hardware.boot(identity.clone())?;
        identity.boot = rng.random();
        Ok(Self { hardware, identity, firmware: None, clock, radio, host, rng, boots_at, unheard: 0 })
    }

    /// One tick at `now`, true time: what came over the radio, the firmware, what it says, and the hardware. A Modboat's
    /// come once every [`TICK`](super::module::TICK), an ROV's at any pace.
    ///
    /// # Errors
    /// The radio's own.
    pub fn tick(&mut self, now: FleetInstant) -> Result<(), R::Error> {
        let Self { hardware, identity, firmware, clock, radio, host, rng, boots_at, unheard } = self;
        let local = clock.read(now);
        hardware.tick(now, |hardware, supply| {
            if firmware.is_none() && now >= *boots_at {
                *firmware = hardware.boot(identity.clone()).ok();
                identity.boot = rng.random();
            }
            let mut buffer = [0; MAX_DATAGRAM];
            while let Some((length, _)) = radio.receive(now, &mut buffer)? {
                // Without power a datagram falls on deaf ears.
                match firmware {
                    Some(firmware) => {
                        // What it does not follow it counts itself.
                        let _ = firmware.handle_datagram(local, &buffer[..length]);
                    }
                    None => *unheard += 1,
                }
            }
            if let Some(firmware) = firmware {
                // The simulated pins cannot fail.
                let _ = firmware.tick(local, supply);
                while let Some(datagram) = firmware.poll_transmit(&mut buffer) {
                    radio.send(now, *host, datagram)?;
                }
            }
            Ok(())
        })
    }

    /// Takes its power at `now` and gives it back `off` later. What the firmware knew is gone; a tail coasts, speed controllers
    /// hear nothing and stop.
    pub fn reboot(&mut self, now: FleetInstant, off: Duration) {
        self.firmware = None;
        self.boots_at = now.after(off);
        self.hardware.power_off();
    }

    /// Writes what the water feels of it now.
    pub fn actuate(&self, actuation: &mut H::Actuation) {
        self.hardware.actuate(actuation);
    }

    /// Whether it has power, and its firmware runs.
    pub fn has_power(&self) -> bool {
        self.firmware.is_some()
    }

    /// Lets its own clock jump ahead by so much, as if ticks had been lost, or back.
    pub fn step_clock(&mut self, by_s: f64) {
        self.clock.offset_s += by_s;
    }

    /// The firmware and its own time at `now`; `None` without power.
    pub(super) fn firmware(&self, now: FleetInstant) -> Option<(&H::Firmware, LocalInstant)> {
        Some((self.firmware.as_ref()?, self.clock.read(now)))
    }

    fn status(&self, now: FleetInstant) -> Option<Status> {
        Some(self.firmware.as_ref()?.status(self.clock.read(now)))
    }

    /// What the firmware is doing at `now`, true time; `None` without power.
    pub fn state(&self, now: FleetInstant) -> Option<ModuleState> {
        Some(self.status(now)?.state)
    }

    /// Number of the cycle that it runs at `now`, true time, if any.
    pub fn running(&self, now: FleetInstant) -> Option<u32> {
        self.status(now)?.running
    }

    /// Its way in and out, while it has power.
    pub fn link(&self) -> Option<&Link> {
        self.firmware.as_ref()?.endpoint().link()
    }

    /// Fleet time by the module's own reckoning less the true one, µs; `None` before it is synchronised.
    pub fn clock_error_us(&self, now: FleetInstant) -> Option<i64> {
        let clock = self.firmware.as_ref()?.endpoint().clock();
        let fleet = clock.fleet(self.clock.read(now)).filter(|_| clock.is_synchronised())?;
        Some(fleet.0 as i64 - now.0 as i64)
    }

    /// Its end of the radio.
    pub fn radio(&self) -> &R {
        &self.radio
    }

    /// Its end of the radio, to change the weather there.
    pub fn radio_mut(&mut self) -> &mut R {
        &mut self.radio
    }

    /// Datagrams that came while it had no power.
    pub fn unheard(&self) -> u64 {
        self.unheard
    }
}
