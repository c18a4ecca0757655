//! The image without a network stack, over a serial line: it swims, is lied to, stops in mid-cycle and is released, and with the deepest
//! stack of all that it takes no more RAM than it may.
//!
//! It runs in this machine's time, which may stand still for a while: a tail that was left behind by that is stopped, and released here.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use link::dispatcher::Dispatcher;
use link::identity::HostIdentity;
use protocol::session::seal_stop;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;
use protocol::{
    Delivery, Faults, Frame, Kind, MAX_DATAGRAM, ModboatCycle, ModuleId, ModuleState, Motion, Nonce, Radio,
    TransitionLaw,
};
use qemu::emulator::{Emulator, PATIENCE, Setup, free_tcp_port, image};
use qemu::storm::{Storm, forged_calls};
use qemu::{kept, provisioned};

const SEED: u64 = 1;

/// Between two lies: less than the line and the processor can take.
const LIE_EVERY: Duration = Duration(20_000);

/// RAM of the core at most, bytes. Half a KiB more than while the stack was measured of a core whose tail stood still.
const RAM_MAX: u64 = 8 * 1024 + 512;

/// Where the emulator's RAM is, and its size in `firmware/boards/qemu/memory.x`.
const RAM: (u64, u64) = (0x2000_0000, 128 * 1024);

/// What the stack is painted with.
const PAINT: [u8; 4] = [0xcc; 4];

/// A serial line as a radio: a datagram is its length in two bytes, little endian, and its bytes.
struct Line {
    stream: TcpStream,
    came: VecDeque<u8>,
}

impl Radio for Line {
    type Address = ();
    type Error = std::io::Error;

    fn send(&mut self, _now: FleetInstant, (): (), datagram: &[u8]) -> std::io::Result<()> {
        let length = u16::try_from(datagram.len()).expect("short").to_le_bytes();
        self.stream.write_all(&[&length[..], datagram].concat())
    }

    fn receive(&mut self, _now: FleetInstant, buffer: &mut [u8]) -> std::io::Result<Option<(usize, ())>> {
        let mut bytes = [0; 4096];
        match self.stream.read(&mut bytes) {
            Ok(count) => self.came.extend(&bytes[..count]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => return Err(error),
        }
        let Some((&low, &high)) = self.came.front().zip(self.came.get(1)) else { return Ok(None) };
        let length = usize::from(u16::from_le_bytes([low, high]));
        if self.came.len() < length + 2 {
            return Ok(None);
        }
        let datagram: Vec<u8> = self.came.drain(..length + 2).skip(2).collect();
        buffer[..length].copy_from_slice(&datagram);
        Ok(Some((length, ())))
    }
}

/// Whether the module knows the fleet time well enough to begin.
fn link_is_sure(dispatcher: &Dispatcher<()>) -> bool {
    let health = dispatcher.modules()[0].health();
    health.is_some_and(|health| health.uncertainty <= Duration(1_500))
}

/// Connects to what the emulator opens when it starts.
fn connect(port: u16) -> TcpStream {
    let deadline = Instant::now() + PATIENCE;
    loop {
        match TcpStream::connect(("127.0.0.1", port)) {
            Ok(stream) => {
                stream.set_nodelay(true).expect("a socket");
                return stream;
            }
            Err(error) => assert!(Instant::now() < deadline, "no line to the emulator: {error}"),
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

/// The emulator's RAM, by its monitor.
fn memory(monitor: &mut TcpStream) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ram");
    let (address, length) = RAM;
    writeln!(monitor, "pmemsave {address:#x} {length} \"{}\"", path.display()).expect("a monitor");
    let deadline = Instant::now() + PATIENCE;
    loop {
        let bytes = std::fs::read(&path).unwrap_or_default();
        if bytes.len() as u64 == length {
            return bytes;
        }
        assert!(Instant::now() < deadline, "{} of {length} bytes of memory", bytes.len());
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

#[test]
fn the_core_swims_stops_and_is_lied_to_within_its_memory() {
    let host = HostIdentity::simulated(SEED, 0);
    let id = ModuleId(1);
    let configuration = provisioned::image(&provisioned::modboat(&host, id, 4870));
    let (serial, monitor) = (free_tcp_port(), free_tcp_port());
    let [serial_at, monitor_at] =
        [serial, monitor].map(|port| format!("tcp:127.0.0.1:{port},server=on,wait=off"));
    let _emulator = Emulator::start(&Setup {
        image: "core.elf",
        configuration: &configuration,
        serial: Some(&serial_at),
        monitor: Some(&monitor_at),
        ..Setup::default()
    });
    let stream = connect(serial);
    stream.set_nonblocking(true).expect("a socket");
    let mut line = Line { stream, came: VecDeque::new() };
    let mut monitor = connect(monitor);

    let mut dispatcher: Dispatcher<()> = Dispatcher::new(&[id], &host.key, host.boot);
    // One in four of each: noise of a kind, and calls of a host without the key.
    let mut lies = Storm::new(&host, id, SEED).zip(forged_calls(&host, id, SEED)).flat_map(|(a, b)| [a, b]);
    let began = Instant::now();
    let now = || FleetInstant(began.elapsed().as_micros() as u64);
    let (mut number, mut next, mut swam) = (0, FleetInstant(0), Vec::new());
    let (mut announced, mut stops, mut released) = (None, Vec::new(), FleetInstant(0));
    // A lie goes out once the module has answered since the one before: on a machine that is busy the line would fill up without end.
    let (mut next_lie, mut answered) = (FleetInstant(0), false);
    while swam.len() < 5 || stops.len() < 2 {
        assert!(began.elapsed() < PATIENCE, "it ran {swam:?} only, and was stopped {stops:?}");
        std::thread::sleep(std::time::Duration::from_millis(1));
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((length, ())) = line.receive(now(), &mut buffer).expect("a line") {
            let announcement = Frame::parse(&buffer[..length]).ok().map(|frame| frame.header);
            let boot =
                announcement.filter(|header| header.kind == Kind::Announce).and_then(|header| header.nonce);
            announced = boot.or(announced);
            answered = true;
            // What is not to be followed is counted there.
            let _ = dispatcher.handle_datagram(now(), (), &buffer[..length]);
        }
        dispatcher.handle_timer(now());
        let link = &dispatcher.modules()[0];
        let (state, faults) = (link.state(), link.faults());
        let executing = link.telemetry().filter(|report| report.state == ModuleState::Executing);
        let mid_cycle = executing.is_some_and(|report| report.rate.0.abs() > 2.0);
        if let Some(report) = executing.filter(|report| swam.last() != Some(&report.cycle)) {
            swam.push(report.cycle);
        }
        // The second and the fourth cycle are ended by a stop: by its own host, and by another one.
        let ends = mid_cycle && swam.len() >= 2 * (stops.len() + 1);
        if ends && stops.is_empty() {
            dispatcher.emergency_stop(now());
        } else if ends {
            let boot: Nonce = announced.expect("it announces itself");
            let module = host.key.module(id);
            let stop = seal_stop(host.key.fleet(), id, &module, boot, &mut buffer).expect("fits").to_vec();
            line.send(now(), (), &stop).expect("a line");
        }
        if state == Some(ModuleState::Stopped) && now() > released {
            if faults.has(Faults::EMERGENCY) {
                stops.push(number);
            }
            released = now().after(Duration(1_000_000));
            dispatcher.release(now());
        }
        let sure = link_is_sure(&dispatcher);
        let ready = matches!(state, Some(ModuleState::Ready | ModuleState::Executing | ModuleState::Holding));
        if ready && sure && now() > next {
            number += 1;
            let rest = dispatcher.modules()[0].telemetry().map_or(0.0, |report| report.tail.0);
            let motion = Motion::Modboat(ModboatCycle {
                rotation: Radians(0.5),
                centerline: Radians(rest + 0.5 - 1.2),
                amplitude: Radians(1.2),
                transition: Duration(300_000),
                period: Duration(1_500_000),
                law: TransitionLaw::RestToRest { ramp: Duration(50_000) },
            });
            // In this machine's time, which may be short: one that comes too late is followed by another.
            let start = now().after(Duration(500_000));
            next = start.after(Duration(2_300_000));
            dispatcher.dispatch(now(), number, start, &[Some(motion)], Delivery::Direct);
        }
        while let Some(((), datagram)) = dispatcher.poll_transmit(now(), &mut buffer) {
            let datagram = datagram.to_vec();
            line.send(now(), (), &datagram).expect("a line");
        }
        if now() > next_lie && answered {
            answered = false;
            next_lie = now().after(LIE_EVERY);
            let lie = lies.next().expect("without end");
            line.send(now(), (), &lie).expect("a line");
        }
    }

    let ram = memory(&mut monitor);
    let elf = std::fs::read(image("core.elf")).expect("an image");
    let program = images::elf::Program::read(&elf).expect("a program");
    let sections = program.sections().expect("sections");
    let fixed: u64 = sections.iter().filter(|section| section.in_ram).map(|section| section.bytes).sum();
    // From the end of what is fixed up, the first word that is not the paint.
    let first = (fixed as usize).next_multiple_of(4);
    let painted = ram[first..].chunks_exact(4).take_while(|word| *word == PAINT).count();
    let stack = ram.len() - first - 4 * painted;
    println!(
        "cycles {swam:?} over a serial line, {} of them ended by a stop; {fixed} bytes of RAM and {stack} of stack, {} in all",
        stops.len(),
        fixed + stack as u64
    );
    assert!(painted > 100, "nothing is painted: {painted}");
    assert!(
        fixed + stack as u64 <= RAM_MAX,
        "{} bytes of RAM, at most {RAM_MAX} are meant",
        fixed + stack as u64
    );
    kept::compare("RAM that is fixed", &[fixed], 0.1);
    kept::compare("stack at its deepest, by its paint", &[stack as u64], 0.1);
}
