//! A stranger on the network of a storm, without keys: plays recorded announcements of old boots round to the host, and calls modules.

use link::loopback::{Ether, LoopbackRadio, Node};
use protocol::time::FleetInstant;
use protocol::{
    Announcer, FleetKey, Hello, MAX_DATAGRAM, Message, ModuleId, ModuleKind, Nonce, Radio, WIRE_VERSION,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::count::crc32;
use super::tap::HOST;

const CALL: u8 = 2;

/// See the module's documentation.
pub struct Player {
    radio: LoopbackRadio,
    fleet: [u8; 4],
    modules: u16,
    /// Datagrams, each with the session that it names.
    pub recorded: Vec<(Vec<u8>, u32)>,
    next: usize,
    /// Calls that it heard: bytes of genuine ones.
    calls: Vec<Vec<u8>>,
    /// Announcements played.
    pub played: u64,
    /// Calls made.
    pub called: u64,
    /// Datagrams that came to it from a host, and from modules.
    pub came: [u64; 2],
    rng: ChaCha8Rng,
}

impl Player {
    /// At `node`, with announcements of `boots` old boots of the modules 1 to `modules`, recorded before the storm.
    #[must_use]
    pub fn new(ether: &Ether, node: Node, key: &FleetKey, modules: u16, boots: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // All of one module, or some of several.
        let victims = if rng.random_bool(0.5) { 1 } else { modules };
        let first = rng.random_range(0..modules);
        let recorded = (0..boots).map(|k| {
            let id = ModuleId((first + k as u16 % victims) % modules + 1);
            let boot: [u8; 16] = rng.random();
            let session = if rng.random_bool(0.5) { 0 } else { rng.random() };
            let hello = Hello { kind: ModuleKind::Modboat, firmware: (0, 2, 0), session };
            let mut buffer = [0; MAX_DATAGRAM];
            let mut announcer = Announcer::new(key.fleet(), id, &key.module(id), Nonce(boot));
            let datagram = announcer.seal(&Message::Hello(hello), &mut buffer).expect("room");
            (datagram.to_vec(), session)
        });
        let recorded = recorded.collect();
        let (fleet, radio) = (key.fleet().0, ether.radio(node));
        Self {
            radio,
            fleet,
            modules,
            recorded,
            next: 0,
            calls: Vec::new(),
            played: 0,
            called: 0,
            came: [0; 2],
            rng,
        }
    }

    /// Hears what a host sends.
    pub fn hear(&mut self, datagram: &[u8]) {
        if datagram.get(1) == Some(&CALL) && self.calls.len() < 256 {
            self.calls.push(datagram.to_vec());
        }
    }

    /// Plays the next announcement.
    pub fn play(&mut self) {
        let Some((datagram, _)) = self.recorded.get(self.next) else { return };
        let Ok(()) = self.radio.send(FleetInstant(0), HOST, datagram);
        self.next = (self.next + 1) % self.recorded.len();
        self.played += 1;
    }

    /// Calls a module: with a nonce and a session of its own, or with a genuine call whose seal it has broken.
    pub fn call(&mut self) {
        let module = self.rng.random_range(0..self.modules) + 1;
        let known = self.calls.len();
        let datagram = if known > 0 && self.rng.random_bool(0.3) {
            let mut datagram = self.calls[self.rng.random_range(0..known)].clone();
            let tag = datagram.len() - 20 + self.rng.random_range(0..16);
            datagram[tag] ^= self.rng.random_range(1..=u8::MAX);
            datagram.truncate(datagram.len() - 4);
            datagram
        } else {
            let mut datagram = vec![WIRE_VERSION, CALL];
            datagram.extend(self.fleet);
            datagram.extend(module.to_le_bytes());
            // Session, number, nonce, sealed message and tag.
            datagram.extend((0..4 + 4 + 16 + 8 + 16).map(|_| self.rng.random::<u8>()));
            datagram
        };
        let to = Node(u16::from_le_bytes([datagram[6], datagram[7]]));
        let sum = crc32(&datagram).to_le_bytes();
        let Ok(()) = self.radio.send(FleetInstant(0), to, &[datagram.as_slice(), &sum].concat());
        self.called += 1;
    }

    /// Takes in what was sent to it.
    pub fn listen(&mut self) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Ok(Some((_, from))) = self.radio.receive(FleetInstant(0), &mut buffer) {
            self.came[usize::from(from != HOST)] += 1;
        }
    }
}
