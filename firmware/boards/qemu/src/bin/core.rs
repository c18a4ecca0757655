//! The firmware core and nothing else: one Modboat whose datagrams go over a serial line, without a network stack.
//!
//! On the line a datagram is its length in two bytes, little endian, and its bytes. What this image takes of flash and RAM is
//! what the core itself takes, and what can panic in it is all that can panic in the core.
#![no_std]
#![no_main]

use board_qemu::clock::Tick;
use board_qemu::pins::{self, Compare, Pin, Register};
use board_qemu::status_led::StatusLed;
use board_qemu::uart::Uart;
use board_qemu::{clock, configuration, semihosting};
use cortex_m_rt::entry;
use firmware::modboat::Modboat;
use firmware::modboat::servo::NoSense;
use firmware::module::{Module, Status, Supply};
use firmware::{indicator, provision};
use protocol::configuration::Robot;
use protocol::time::Duration;
use protocol::units::{Amperes, Volts};
use protocol::{Configuration, Faults, MAX_DATAGRAM, ModuleState};

/// What two lithium cells show. *Assumed*, and constant.
const SUPPLY: Supply = Supply { battery: Volts(7.4), current: Amperes(0.0) };

/// What little of this is linked in, and who calls it, `images panics` shows.
#[panic_handler]
fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
    semihosting::done(false)
}

/// Bytes of a line on their way to be a datagram.
struct Incoming {
    head: [u8; 2],
    bytes: [u8; MAX_DATAGRAM],
    taken: usize,
}

impl Incoming {
    const fn new() -> Self {
        Self { head: [0; 2], bytes: [0; MAX_DATAGRAM], taken: 0 }
    }

    /// Takes a byte; the datagram that it completes. One that is too long is read over.
    fn take(&mut self, byte: u8) -> Option<&[u8]> {
        if let Some(head) = self.head.get_mut(self.taken) {
            *head = byte;
        } else if let Some(place) = self.bytes.get_mut(self.taken.wrapping_sub(2)) {
            *place = byte;
        }
        self.taken = self.taken.wrapping_add(1);
        let length = usize::from(u16::from_le_bytes(self.head));
        if self.taken < 2 || self.taken < length.wrapping_add(2) {
            return None;
        }
        self.taken = 0;
        self.bytes.get(..length)
    }
}

/// The firmware on bare pins.
type Firmware = Modboat<Register, NoSense, Compare, Pin, Pin>;

#[entry]
fn main() -> ! {
    clock::start();
    // SAFETY: the only ones.
    let (mut uart, mut status_led) = unsafe { (Uart::first(), StatusLed::new()) };
    let (Some((firmware, interval)), Some(incoming)) = (boot(), buffer()) else {
        loop {
            status_led.set(indicator::is_lit(clock::now(), ModuleState::Unprovisioned, Faults::default()));
        }
    };
    run(firmware, interval, &mut uart, &mut status_led, incoming)
}

/// Out of line like [`boot`], so that they have their stacks one after the other.
#[inline(never)]
fn run(
    firmware: &mut Firmware,
    interval: Duration,
    uart: &mut Uart,
    status_led: &mut StatusLed,
    incoming: &mut Incoming,
) -> ! {
    let tick = Tick::start(interval);
    let mut outgoing = [0; MAX_DATAGRAM];
    loop {
        if tick.take() {
            // The pins of this board cannot fail.
            let _ = firmware.tick(clock::now(), &SUPPLY);
        }
        while let Some(byte) = uart.read() {
            if let Some(datagram) = incoming.take(byte) {
                // What is not for it is counted there.
                let _ = firmware.handle_datagram(clock::now(), datagram);
            }
        }
        while let Some(datagram) = firmware.poll_transmit(&mut outgoing) {
            let [low, high, ..] = datagram.len().to_le_bytes();
            uart.write(&[low, high]);
            uart.write(datagram);
        }
        let now = clock::now();
        let Status { state, faults, .. } = firmware.status(now);
        status_led.set(indicator::is_lit(now, state, faults));
    }
}

/// The module that the configuration makes; nothing without a valid one. Out of line, so that what it needs is given back.
#[inline(never)]
fn boot() -> Option<(&'static mut Firmware, Duration)> {
    let configuration = read()?;
    let Robot::Modboat(constants) = &configuration.robot else { return None };
    let interval = provision::servo_interval(&constants.servo).ok()?;
    let nonce = semihosting::boot_nonce()?;
    let place = cortex_m::singleton!(: Option<Firmware> = None)?;
    // Straight to its place: `?` would take the whole module over the stack once more.
    match provision::modboat(&configuration, nonce, Register, NoSense, pins::bridge()) {
        Ok(firmware) => Some((place.insert(firmware), interval)),
        Err(_) => None,
    }
}

#[inline(never)]
fn read() -> Option<Configuration> {
    Configuration::read(configuration::block()).ok()
}

/// For what comes in: in memory that is counted, as it is there for good.
#[inline(never)]
fn buffer() -> Option<&'static mut Incoming> {
    cortex_m::singleton!(: Incoming = Incoming::new())
}
