//! Counts the instructions of the firmware core: a host on the same processor serves one Modboat that swims for half a minute.
//!
//! Run with `-icount shift=10`, in which each instruction takes 1024 ns of the emulator's time, so that the timer counts
//! instructions exactly. The time that the firmware is told is made up: a tick is a millisecond, whatever it takes.
#![no_std]
#![no_main]

use core::fmt::Write;

use board_qemu::control::Firmware;
use board_qemu::uart::Uart;
use board_qemu::{clock, configuration, motor, semihosting};
use cortex_m_rt::entry;
use firmware::module::{Module, Status, Supply};
use firmware::provision;
use heapless::Vec;
use protocol::configuration::Robot;
use protocol::ledger::Class;
use protocol::session::open_announcement;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::{Radians, Volts};
use protocol::{
    Configuration, Cycle, Delivery, Frame, Kind, MAX_DATAGRAM, Message, ModboatCycle, ModuleState, Motion,
    Nonce, Session, Side, TimeReply, TransitionLaw,
};

/// Counts of the timer while one instruction runs: 1024 ns at 25 MHz, in tenths.
const PER_INSTRUCTION_TENTHS: u64 = 256;
/// Fleet time less the module's own.
const AHEAD: u64 = 1_000_000;
const PERIOD: Duration = Duration(1_500_000);
const TICKS: u64 = 30_000;

/// Instructions that something took, each time it was done.
#[derive(Default)]
struct Cost {
    times: u64,
    total: u64,
    least: u64,
    most: u64,
}

impl Cost {
    fn add(&mut self, instructions: u64) {
        self.least = if self.times == 0 { instructions } else { self.least.min(instructions) };
        self.most = self.most.max(instructions);
        self.total += instructions;
        self.times += 1;
    }
}

/// What is counted, by its name in the table.
#[derive(Default)]
struct Costs {
    tick: Cost,
    cycle: Cost,
    duplicate: Cost,
    time_reply: Cost,
    call: Cost,
    damaged: Cost,
    forged: Cost,
    forged_call: Cost,
    foreign_call: Cost,
    sent: Cost,
}

impl Costs {
    fn tell(&self, uart: &mut Uart) {
        let Self {
            tick,
            cycle,
            duplicate,
            time_reply,
            call,
            damaged,
            forged,
            forged_call,
            foreign_call,
            sent,
        } = self;
        for (what, cost) in [
            ("tick", tick),
            ("cycle", cycle),
            ("duplicate", duplicate),
            ("time-reply", time_reply),
            ("call", call),
            ("damaged", damaged),
            ("forged", forged),
            ("forged-call", forged_call),
            ("foreign-call", foreign_call),
            ("sent", sent),
        ] {
            let &Cost { times, total, least, most } = cost;
            let mean = total.checked_div(times).unwrap_or(0);
            let _ = writeln!(uart, "cost {what} times {times} least {least} mean {mean} most {most}");
        }
    }
}

/// Does it, and adds what it took but for `overhead`, the counting itself.
fn count<T>(cost: &mut Cost, overhead: u64, does: impl FnOnce() -> T) -> T {
    let began = clock::counts();
    let result = does();
    let counts = clock::counts() - began;
    cost.add((counts * 10 / PER_INSTRUCTION_TENTHS).saturating_sub(overhead));
    result
}

/// Both ends of the link on one processor.
struct Bench {
    firmware: Firmware,
    session: Option<Session>,
    costs: Costs,
    overhead: u64,
}

impl Bench {
    fn new(firmware: Firmware) -> Self {
        let mut nothing = Cost::default();
        for _ in 0..100 {
            count(&mut nothing, 0, || ());
        }
        Self { firmware, session: None, costs: Costs::default(), overhead: nothing.least }
    }

    fn tick(&mut self, now: LocalInstant) {
        let supply = Supply { battery: Volts(7.4), ..Supply::default() };
        let outcome = count(&mut self.costs.tick, self.overhead, || self.firmware.tick(now, &supply));
        assert!(outcome.is_ok());
    }

    /// Hears all that the module says, and answers as a host does.
    fn serve(&mut self, now: LocalInstant) {
        let (mut buffer, mut answer) = ([0; MAX_DATAGRAM], [0; MAX_DATAGRAM]);
        loop {
            // Whether anything waits is asked outside of the count.
            let began = clock::counts();
            let Some(said) = self.firmware.poll_transmit(&mut buffer) else { return };
            let counts = clock::counts() - began;
            self.costs.sent.add((counts * 10 / PER_INSTRUCTION_TENTHS).saturating_sub(self.overhead));
            let frame = Frame::parse(said).unwrap_or_else(|error| panic!("{error}"));
            if frame.header.kind == Kind::Announce {
                self.call(now, &frame, &mut answer);
                continue;
            }
            let Some(session) = &mut self.session else { continue };
            let Ok(opened) = session.open(&frame) else { panic!("not sealed by the module") };
            if let Message::TimeRequest(request) = opened.message {
                let fleet = FleetInstant(now.0 + AHEAD);
                let reply = TimeReply { request_sent: request.sent, received: fleet, sent: fleet };
                let reply = seal(session, &Message::TimeReply(reply), &mut answer);
                let cost = &mut self.costs.time_reply;
                let taken = count(cost, self.overhead, || self.firmware.handle_datagram(now, reply));
                assert_eq!(taken, Ok(()));
            }
        }
    }

    fn call(&mut self, now: LocalInstant, frame: &Frame<'_>, answer: &mut [u8]) {
        let Some(link) = self.firmware.endpoint().link() else { return };
        let identity = link.identity();
        let Ok(Message::Hello(hello)) = open_announcement(&identity.key, frame) else { panic!("no hello") };
        let Some(boot) = frame.header.nonce.filter(|_| hello.session == 0) else { return };
        let (fleet, module, nonce) = (identity.fleet, identity.module, Nonce([7; 16]));
        let mut session = Session::new(Side::Host, fleet, module, &identity.key, &boot, nonce);
        let call = session.seal_call(answer).unwrap_or_else(|error| panic!("{error}"));
        let mut forged = Vec::<u8, MAX_DATAGRAM>::from_slice(call).expect("it fits");
        damage(&mut forged, TAG_FROM_END);
        let cost = &mut self.costs.forged_call;
        let taken = count(cost, self.overhead, || self.firmware.handle_datagram(now, &forged));
        assert_eq!(taken, Err(Class::Forged));
        let taken = count(&mut self.costs.call, self.overhead, || self.firmware.handle_datagram(now, call));
        assert_eq!(taken, Ok(()));
        self.session = Some(session);
        // Of another host, whatever it says.
        let of_session = forged.len() - SESSION;
        damage(&mut forged, of_session);
        let cost = &mut self.costs.foreign_call;
        let taken = count(cost, self.overhead, || self.firmware.handle_datagram(now, &forged));
        assert_eq!(taken, Err(Class::Foreign));
    }

    /// Sends a cycle, once more, once damaged, and once damaged under a right checksum.
    fn send(&mut self, now: LocalInstant, number: u32) {
        let Some(session) = &mut self.session else { return };
        let mut buffer = [0; MAX_DATAGRAM];
        let length = seal(session, &cycle(number, FleetInstant(now.0 + AHEAD + 500_000)), &mut buffer).len();
        let (costs, overhead) = (&mut self.costs, self.overhead);
        let sealed = &mut buffer[..length];
        let mut deliver =
            |cost, bytes: &[u8]| count(cost, overhead, || self.firmware.handle_datagram(now, bytes));
        assert_eq!(deliver(&mut costs.cycle, sealed), Ok(()));
        assert_eq!(deliver(&mut costs.duplicate, sealed), Err(Class::Duplicate));
        // A number that has not come yet, and a byte that is changed.
        let next = seal(session, &Message::Hold, &mut buffer).len();
        let guarded = next - 4;
        buffer[guarded - 1] ^= 1;
        assert_eq!(deliver(&mut costs.damaged, &buffer[..next]), Err(Class::Corrupt));
        let checksum = crc32(&buffer[..guarded]);
        buffer[guarded..next].copy_from_slice(&checksum.to_le_bytes());
        assert_eq!(deliver(&mut costs.forged, &buffer[..next]), Err(Class::Forged));
    }
}

/// The last byte of the tag, and the first of the session's number, from the end and from the beginning of a datagram.
const TAG_FROM_END: usize = 5;
const SESSION: usize = 8;

/// Changes the byte that stands so far from the end, under a right checksum.
fn damage(datagram: &mut [u8], from_end: usize) {
    let (changed, guarded) = (datagram.len() - from_end, datagram.len() - 4);
    datagram[changed] ^= 1;
    let checksum = crc32(&datagram[..guarded]);
    datagram[guarded..].copy_from_slice(&checksum.to_le_bytes());
}

fn seal<'a>(session: &mut Session, message: &Message, buffer: &'a mut [u8]) -> &'a [u8] {
    session.seal(message, buffer).unwrap_or_else(|error| panic!("{error}"))
}

/// CRC-32, ISO-HDLC, as a forger works it out.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}

/// A turn all the way round, and one period of swimming, from rest to rest at φ = 0.
fn cycle(number: u32, start: FleetInstant) -> Message {
    let amplitude = if number.is_multiple_of(2) { 2.6 } else { -1.3 };
    let motion = Motion::Modboat(ModboatCycle {
        rotation: Radians(core::f32::consts::TAU),
        centerline: Radians(-amplitude),
        amplitude: Radians(amplitude),
        transition: Duration(660_000),
        period: PERIOD,
        law: TransitionLaw::RestToRest { ramp: Duration(52_000) },
    });
    Message::Cycle(Cycle { number, start, motion, delivery: Delivery::Direct })
}

board_qemu::ends_with_its_faults!();

#[entry]
fn main() -> ! {
    clock::start();
    motor::connect();
    // SAFETY: the only one.
    let mut uart = unsafe { Uart::first() };
    let configuration = Configuration::read(configuration::block()).unwrap_or_else(|error| panic!("{error}"));
    let boot = semihosting::boot_nonce().expect("random bytes from the PC");
    let Robot::Modboat(constants) = &configuration.robot else { panic!("no Modboat") };
    let wheel = motor::Wheel::new(&constants.encoder).unwrap_or_else(|error| panic!("{error}"));
    let firmware = provision::modboat(&configuration, boot, wheel, motor::Sensors, motor::bridge());
    let firmware = firmware.unwrap_or_else(|error| panic!("{error}"));
    // Not on the stack, with everything else that lasts.
    let bench = cortex_m::singleton!(: Bench = Bench::new(firmware)).expect("taken once");

    let (mut number, mut swam) = (0, 0);
    for tick in 0..TICKS {
        let now = LocalInstant(tick * 1_000);
        motor::step(1e-3);
        bench.tick(now);
        bench.serve(now);
        let Status { state, running, .. } = bench.firmware.status(now);
        swam += u64::from(running.is_some());
        let takes = matches!(state, ModuleState::Ready | ModuleState::Executing | ModuleState::Holding);
        if takes && tick.is_multiple_of(2_500) {
            number += 1;
            bench.send(now, number);
        }
    }
    assert!(swam > TICKS / 2, "it swam for {swam} ms only");
    bench.costs.tell(&mut uart);
    semihosting::done(true)
}
