//! Fuzz input: bytes as events of a Modboat: noise, genuine messages of any content, replays, ticks, faults, other hosts, reboots.
//!
//! | byte | then | what happens |
//! |---|---|---|
//! | 0 | length, bytes | the bytes come as a datagram |
//! | 1 | length, bytes | the host seals the message of which they are the postcard; it comes |
//! | 2 | index | a datagram that was sealed earlier comes again, or for the first time |
//! | 3 | 1 | the host seals a command, and it is lost, or comes later |
//! | 4 | ms | so many ticks |
//! | 5 | 4 | a cycle that fits: when it starts, its amplitude, what it needs |
//! | 6 | 1 | a command: hold, stop, release, commit of the last cycle |
//! | 7 | 1 | a fault, another host, a reboot, silence, missed ticks |
//!
//! Held against everything that may never be: see `World::tick` and `World::bring`.

mod board;
mod world;

use protocol::units::Volts;
use protocol::{Message, ModuleState};
use world::World;

/// What a run met, so that a test can see that the runs go somewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Met {
    /// Ticks in which a cycle ran.
    pub executing: u32,
    /// Ticks in which it was stopped.
    pub stopped: u32,
    /// Datagrams that were let in.
    pub accepted: u32,
    /// Datagrams that were not.
    pub rejected: u32,
}

/// Most bytes that are followed, and most ticks: an input is to be quick.
const BYTES_MAX: usize = 1 << 12;
const TICKS_MAX: u32 = 12_000;

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = usize::from(self.byte()?).min(self.0.len());
        let (bytes, rest) = self.0.split_at(length);
        self.0 = rest;
        Some(bytes)
    }
}

/// Plays it all.
pub fn run(bytes: &[u8]) -> Met {
    let mut input = Reader(&bytes[..bytes.len().min(BYTES_MAX)]);
    let mut world = World::new();
    // The first byte says whether it begins in a session.
    if input.byte().is_some_and(|byte| byte % 4 != 0) {
        world.ticks(1_000);
        assert_eq!(world.state(), ModuleState::Ready);
    }
    while world.ticked < TICKS_MAX && step(&mut world, &mut input).is_some() {}
    world.met
}

fn step(world: &mut World, input: &mut Reader<'_>) -> Option<()> {
    match input.byte()? % 8 {
        0 => {
            let noise = input.bytes()?;
            assert!(world.bring(noise).is_err(), "a valid tag by chance");
        }
        1 => {
            let bytes = input.bytes()?;
            if let Ok((message, _)) = postcard::take_from_bytes::<Message>(bytes)
                && let Some(datagram) = world.seal(&message)
            {
                let _ = world.bring(&datagram);
            }
        }
        2 => {
            let index = usize::from(input.byte()?);
            if !world.recorded.is_empty() {
                let datagram = world.recorded[index % world.recorded.len()].clone();
                let _ = world.bring(&datagram);
            }
        }
        3 => {
            let message = world.command(input.byte()?);
            let _ = world.seal(&message);
        }
        4 => world.ticks(u32::from(input.byte()?)),
        5 => {
            let [start, amplitude, rotation, delivery] =
                [input.byte()?, input.byte()?, input.byte()?, input.byte()?];
            let message = world.cycle(start, amplitude, rotation, delivery);
            if let Some(datagram) = world.seal(&message) {
                let _ = world.bring(&datagram);
            }
        }
        6 => {
            let message = world.command(input.byte()?);
            if let Some(datagram) = world.seal(&message) {
                let _ = world.bring(&datagram);
            }
        }
        _ => happen(world, input.byte()?),
    }
    Some(())
}

fn happen(world: &mut World, what: u8) {
    match what % 10 {
        0 => world.board.fail_encoder(true),
        1 => world.board.fail_encoder(false),
        2 => world.board.block(true),
        3 => world.board.block(false),
        4 => world.battery = Volts(f32::from(what) / 32.0),
        5 => world.answers = !world.answers,
        6 => world.other_host(),
        7 => world.reboot(),
        8 => world.miss(u64::from(what) * 10_000),
        _ => world.board.turn(f64::from(what) * 0.01),
    }
}
