//! One Modboat in the emulator, on its network.
//!
//! It says once a second over its serial line how it does:
//!
//! ```text
//! tick 12000 missed 0 stalled 0 late 1 tick_us 9 turn_us 31 state Executing running 5 faults 0 braked 0 drive 310 stack 3320 received 431 accepted 431 …
//! ```
#![no_std]
#![no_main]

use core::fmt::Write;

use board_qemu::control::{self, Control, Mail};
use board_qemu::lan9118::{self, Lan9118};
use board_qemu::network::{self, Memory, Network};
use board_qemu::stack::Stack;
use board_qemu::status_led::StatusLed;
use board_qemu::uart::Uart;
use board_qemu::{clock, configuration, motor, semihosting, steps};
use cortex_m_rt::{entry, exception};
use firmware::{indicator, provision};
use heapless::Vec;
use protocol::configuration::Robot;
use protocol::time::{Duration, LocalInstant};
use protocol::{Configuration, Faults, ModuleState};

/// Between two lines.
const REPORT_EVERY: Duration = Duration(1_000_000);

board_qemu::ends_with_its_faults!();

#[entry]
fn main() -> ! {
    let boot = semihosting::boot_nonce().expect("random bytes from the PC");
    steps::start(cortex_m::Peripherals::take().expect("taken once").SYST);
    clock::start();
    motor::connect();
    // SAFETY: the only ones.
    let (mut uart, mut status_led) = unsafe { (Uart::first(), StatusLed::new()) };
    match run(boot, &mut uart, &mut status_led) {
        Ok(never) => match never {},
        Err(why) => {
            let _ = writeln!(uart, "not provisioned: {why}");
            loop {
                let lit = indicator::is_lit(clock::now(), ModuleState::Unprovisioned, Faults::default());
                if status_led.set(lit) {
                    let _ = writeln!(uart, "status LED {}", if lit { "on" } else { "off" });
                }
            }
        }
    }
}

fn run(
    boot: [u8; 12],
    uart: &mut Uart,
    status_led: &mut StatusLed,
) -> Result<core::convert::Infallible, provision::NotProvisioned> {
    let configuration = Configuration::read(configuration::block())?;
    let Robot::Modboat(constants) = &configuration.robot else {
        return Err(provision::NotProvisioned::Kind(configuration.kind()));
    };
    let wheel = motor::Wheel::new(&constants.encoder)?;
    let firmware = provision::modboat(&configuration, boot, wheel, motor::Sensors, motor::bridge())?;
    let interval = provision::servo_interval(&constants.servo)?;

    let address = network::ethernet_address(configuration.fleet, configuration.module);
    // SAFETY: the only one.
    let Some(device) = (unsafe { Lan9118::start(address) }) else { panic!("no Ethernet controller") };
    let memory = cortex_m::singleton!(: Memory = Memory::new()).expect("taken once");
    let [a, b, c, d, ..] = boot;
    let seed = u64::from(u32::from_le_bytes([a, b, c, d]));
    let mut network = Network::new(device, address, &configuration.network, seed, memory);

    let (mut to_control, inbox) = cortex_m::singleton!(: Mail = Mail::new()).expect("taken once").split();
    let (outbox, mut from_control) = cortex_m::singleton!(: Mail = Mail::new()).expect("taken once").split();
    Control::start(firmware, configuration.supply, interval, inbox, outbox);

    let _ = writeln!(uart, "module {} of fleet {}", configuration.module, configuration.fleet);
    let (mut unheard, mut stack) = (0_u64, Stack::new());
    let mut next_report = LocalInstant(0);
    loop {
        while let Some(datagram) = from_control.dequeue() {
            network.send(&datagram);
        }
        network.poll(clock::now(), |datagram| {
            // Longer than any, or the control loop is busy with others.
            let sent = Vec::from_slice(datagram).ok().and_then(|datagram| to_control.enqueue(datagram).ok());
            match sent {
                Some(()) => clock::call_control(),
                None => unheard += 1,
            }
        });
        network.listen();
        stack.look();
        let now = clock::now();
        if now >= next_report {
            let s = control::statistics();
            next_report = now.after(REPORT_EVERY);
            let i = s.incoming;
            let _ = writeln!(
                uart,
                "tick {} missed {} stalled {} late {} tick_us {} turn_us {} state {:?} running {} faults {} braked {} drive {} stack {} received {} \
                 accepted {} duplicate {} stale {} corrupt {} forged {} foreign {} unheard {unheard} unsent {}",
                s.ticks,
                s.missed,
                s.stalled,
                s.latest.0,
                s.longest_tick.0,
                s.longest_turn.0,
                s.state.unwrap_or(ModuleState::Boot),
                s.running,
                s.faults.0,
                u8::from(s.drive.0),
                s.drive.1,
                stack.high_water(),
                i.received,
                i.accepted,
                i.duplicate,
                i.stale,
                i.corrupt,
                i.forged,
                i.foreign,
                s.unsent,
            );
        }
        let (state, faults) = control::state();
        status_led.set(indicator::is_lit(now, state, faults));
        // Asleep until a tick or a frame, unless something came meanwhile: an interrupt that waits wakes it as well.
        cortex_m::interrupt::free(|_| {
            if !from_control.ready() {
                cortex_m::asm::wfi();
            }
        });
    }
}

// SAFETY: both handlers are made to be interrupts; neither touches what the interrupted code holds but in critical sections.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    const TICK: i16 = clock::Interrupt::Tick as i16;
    const ETHERNET: i16 = clock::Interrupt::Ethernet as i16;
    // Exception 15, SysTick, counted from the first interrupt.
    const STEP: i16 = -1;
    match number {
        TICK => control::interrupted(),
        ETHERNET => lan9118::interrupted(),
        STEP => steps::interrupted(),
        other => panic!("interrupt {other} has no handler"),
    }
}
