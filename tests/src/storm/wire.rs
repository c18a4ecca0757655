//! Sockets of one machine, whose sends fail when a storm says so: below the radio that runs use on UDP.

use std::cell::{Cell, RefCell};
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr};
use std::rc::Rc;

use link::loopback::{Ether, LoopbackRadio, Node};
use link::udp::Socket;
use protocol::Radio;
use protocol::time::FleetInstant;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Port of the first node.
const PORT: u16 = 4870;

/// What a send fails with, by Linux's numbers: EPERM, ENOMEM, EINVAL, EADDRNOTAVAIL, ENETUNREACH, ENOBUFS, EHOSTUNREACH.
const ERRORS: [i32; 7] = [1, 12, 22, 99, 101, 105, 113];

/// Where a node listens.
#[must_use]
pub fn address(node: Node) -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, PORT + node.0))
}

/// Which node listens there.
#[must_use]
pub fn node(address: SocketAddr) -> Node {
    Node(address.port() - PORT)
}

/// How bad the machine of a node is.
#[derive(Debug, Default)]
pub struct Trouble {
    /// Share of sends that fail.
    pub share: Cell<f64>,
    /// Sends that failed.
    pub failed: Cell<u64>,
}

/// A node's socket.
#[derive(Debug)]
pub struct Wire {
    radio: RefCell<LoopbackRadio>,
    trouble: Rc<Trouble>,
    rng: RefCell<ChaCha8Rng>,
}

impl Wire {
    /// That of `node`; `seed` decides which sends fail.
    #[must_use]
    pub fn new(ether: &Ether, node: Node, trouble: Rc<Trouble>, seed: u64) -> Self {
        let rng = RefCell::new(ChaCha8Rng::seed_from_u64(seed));
        Self { radio: RefCell::new(ether.radio(node)), trouble, rng }
    }
}

impl Socket for Wire {
    fn send_to(&self, datagram: &[u8], to: SocketAddr) -> io::Result<usize> {
        let share = self.trouble.share.get();
        let mut rng = self.rng.borrow_mut();
        if share > 0.0 && rng.random_bool(share) {
            self.trouble.failed.set(self.trouble.failed.get() + 1);
            return Err(io::Error::from_raw_os_error(ERRORS[rng.random_range(0..ERRORS.len())]));
        }
        let Ok(()) = self.radio.borrow_mut().send(FleetInstant(0), node(to), datagram);
        Ok(datagram.len())
    }

    fn recv_from(&self, buffer: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
        let Ok(received) = self.radio.borrow_mut().receive(FleetInstant(0), buffer);
        let (length, from) = received.ok_or_else(|| io::Error::from(ErrorKind::WouldBlock))?;
        Ok((length, address(from)))
    }
}
