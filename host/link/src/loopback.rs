//! A radio inside one process: what one node sends, the other receives at once and in order.
//!
//! Faults are not its business: wrap it in [`Faulty`](super::faults::Faulty).

use std::cell::RefCell;
use std::collections::{HashMap, VecDeque};
use std::convert::Infallible;
use std::rc::Rc;

use protocol::Radio;
use protocol::time::FleetInstant;

use super::spare::Spare;

/// A node's address on the loopback: 0 is the host, module ids follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Node(pub u16);

type Inbox = VecDeque<(Node, Vec<u8>)>;

/// What is on its way, by the node that it is for.
#[derive(Debug, Default)]
struct Shared {
    inboxes: HashMap<Node, Inbox>,
    spare: Spare,
}

/// The medium that all loopback radios of one fleet share.
#[derive(Clone, Debug, Default)]
pub struct Ether {
    shared: Rc<RefCell<Shared>>,
}

impl Ether {
    /// A radio at `address`; two at one address share its inbox.
    #[must_use]
    pub fn radio(&self, address: Node) -> LoopbackRadio {
        self.shared.borrow_mut().inboxes.entry(address).or_default();
        LoopbackRadio { address, ether: self.clone() }
    }
}

/// One node's end of the [`Ether`].
#[derive(Clone, Debug)]
pub struct LoopbackRadio {
    address: Node,
    ether: Ether,
}

impl Radio for LoopbackRadio {
    type Address = Node;
    type Error = Infallible;

    fn send(&mut self, _now: FleetInstant, to: Node, datagram: &[u8]) -> Result<(), Infallible> {
        // A datagram to an address without a receiver is lost, as on any radio.
        let Shared { inboxes, spare } = &mut *self.ether.shared.borrow_mut();
        if let Some(inbox) = inboxes.get_mut(&to) {
            inbox.push_back((self.address, spare.copied(datagram)));
        }
        Ok(())
    }

    fn receive(
        &mut self,
        _now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, Node)>, Infallible> {
        let Shared { inboxes, spare } = &mut *self.ether.shared.borrow_mut();
        Ok(inboxes.get_mut(&self.address).and_then(VecDeque::pop_front).map(|(from, datagram)| {
            let length = datagram.len().min(buffer.len());
            buffer[..length].copy_from_slice(&datagram[..length]);
            spare.take_back(datagram);
            (length, from)
        }))
    }
}
