//! Power, clock and radio of a simulated module of any kind.

use firmware::link::session::Link;
use firmware::module::{Module, Status, Supply};
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::{MAX_DATAGRAM, Radio};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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

/// Power, clock and radio of one simulated module. Times are true time, which is the fleet's: the simulated host reads a clock without error.
/// In `flotilla module` the clock of the process stands for it.
pub(super) struct Node<M, R: Radio> {
    firmware: Option<M>,
    clock: LocalClock,
    radio: R,
    host: R::Address,
    rng: ChaCha8Rng,
    boots_at: FleetInstant,
    unheard: u64,
}

impl<M: Module, R: Radio> Node<M, R> {
    /// Without power; it is given within the first 50 ms. `seed` decides its clock, its boot time and its boot nonces.
    pub(super) fn new(seed: u64, clock: &ClockParameters, radio: R, host: R::Address) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let clock = LocalClock {
            offset_s: clock.offset_s * rng.random::<f64>(),
            rate: 1.0 + clock.drift_ppm * 1e-6 * (2.0 * rng.random::<f64>() - 1.0),
        };
        let boots_at = FleetInstant(rng.random_range(0..50_000));
        Self { firmware: None, clock, radio, host, rng, boots_at, unheard: 0 }
    }

    /// Random bytes for its next boot.
    pub(super) fn boot_nonce(&mut self) -> [u8; 12] {
        self.rng.random()
    }

    /// Whether power has come back by `now` and nothing runs yet.
    pub(super) fn boots(&self, now: FleetInstant) -> bool {
        self.firmware.is_none() && now >= self.boots_at
    }

    /// Gives it its firmware.
    pub(super) fn power_on(&mut self, firmware: Option<M>) {
        self.firmware = firmware;
    }

    /// Takes its power at `now` and gives it back `off` later.
    pub(super) fn power_off(&mut self, now: FleetInstant, off: Duration) {
        self.firmware = None;
        self.boots_at = now.after(off);
    }

    /// What came over the radio by `now`, one tick of the firmware, what it says.
    pub(super) fn tick(&mut self, now: FleetInstant, supply: &Supply) -> Result<(), R::Error> {
        let mut buffer = [0; MAX_DATAGRAM];
        let local = self.clock.read(now);
        while let Some((length, _)) = self.radio.receive(now, &mut buffer)? {
            // Without power a datagram falls on deaf ears.
            match &mut self.firmware {
                Some(firmware) => {
                    // What it does not follow it counts itself.
                    let _ = firmware.handle_datagram(local, &buffer[..length]);
                }
                None => self.unheard += 1,
            }
        }
        if let Some(firmware) = &mut self.firmware {
            // The simulated pins cannot fail.
            let _ = firmware.tick(local, supply);
            while let Some(datagram) = firmware.poll_transmit(&mut buffer) {
                self.radio.send(now, self.host, datagram)?;
            }
        }
        Ok(())
    }

    /// Whether it has power, and its firmware runs.
    pub(super) fn has_power(&self) -> bool {
        self.firmware.is_some()
    }

    /// Lets its own clock jump ahead by so much, as if ticks had been lost, or back.
    pub(super) fn step_clock(&mut self, by_s: f64) {
        self.clock.offset_s += by_s;
    }

    /// What the firmware is doing at `now`; nothing without power.
    pub(super) fn status(&self, now: FleetInstant) -> Option<Status> {
        Some(self.firmware.as_ref()?.status(self.clock.read(now)))
    }

    /// Its way in and out, while it has power.
    pub(super) fn link(&self) -> Option<&Link> {
        self.firmware.as_ref()?.endpoint().link()
    }

    /// Fleet time by the module's own reckoning less the true one, µs; nothing before it is synchronised.
    pub(super) fn clock_error_us(&self, now: FleetInstant) -> Option<i64> {
        let clock = self.firmware.as_ref()?.endpoint().clock();
        let fleet = clock.fleet(self.clock.read(now)).filter(|_| clock.is_synchronised())?;
        Some(fleet.0 as i64 - now.0 as i64)
    }

    /// Its end of the radio.
    pub(super) fn radio(&self) -> &R {
        &self.radio
    }

    /// Its end of the radio, to change the weather there.
    pub(super) fn radio_mut(&mut self) -> &mut R {
        &mut self.radio
    }

    /// Datagrams that came while it had no power.
    pub(super) fn unheard(&self) -> u64 {
        self.unheard
    }
}
