//! The network interface of the module: an address, given or fixed, and one UDP socket. The stack is smoltcp.

use protocol::configuration::{Network as Settings, Own};
use protocol::time::LocalInstant;
use protocol::{FleetId, MAX_DATAGRAM, ModuleId};
use smoltcp::iface::{
    Config, Interface, PollIngressSingleResult, PollResult, SocketHandle, SocketSet, SocketStorage,
};
use smoltcp::socket::{dhcpv4, udp};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpCidr, IpEndpoint, Ipv4Address, Ipv4Cidr};

use crate::lan9118::Lan9118;
use crate::steps;

/// Datagrams that wait for the stack or for the firmware, each way.
const WAITING: usize = 8;

/// What the stack needs besides; lives as long as it.
pub struct Memory {
    sockets: [SocketStorage<'static>; 2],
    received: [udp::PacketMetadata; WAITING],
    received_bytes: [u8; WAITING * MAX_DATAGRAM],
    sent: [udp::PacketMetadata; WAITING],
    sent_bytes: [u8; WAITING * MAX_DATAGRAM],
}

impl Memory {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            sockets: [SocketStorage::EMPTY; 2],
            received: [udp::PacketMetadata::EMPTY; WAITING],
            received_bytes: [0; WAITING * MAX_DATAGRAM],
            sent: [udp::PacketMetadata::EMPTY; WAITING],
            sent_bytes: [0; WAITING * MAX_DATAGRAM],
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

/// An address of the module's own making: locally administered, from fleet and number.
#[must_use]
pub fn ethernet_address(fleet: FleetId, module: ModuleId) -> EthernetAddress {
    let ([a, b, c, _], [low, high]) = (fleet.0, module.0.to_le_bytes());
    EthernetAddress([0x02, a, b, c, high, low])
}

/// The module's network interface: one address and one UDP socket.
pub struct Network {
    device: Lan9118,
    interface: Interface,
    sockets: SocketSet<'static>,
    udp: SocketHandle,
    dhcp: Option<SocketHandle>,
    host: IpEndpoint,
    /// Datagrams that the stack took to send.
    sent: u32,
    /// Datagrams that came.
    received: u32,
}

impl Network {
    /// Of the module with this Ethernet address, as its configuration wants it; it listens on the number of its host's port.
    /// `seed` makes port numbers and transaction numbers differ from boot to boot.
    pub fn new(
        mut device: Lan9118,
        address: EthernetAddress,
        settings: &Settings,
        seed: u64,
        memory: &'static mut Memory,
    ) -> Self {
        let mut config = Config::new(address.into());
        config.random_seed = seed;
        let interface = Interface::new(config, &mut device, Instant::from_micros(0));
        let mut sockets = SocketSet::new(&mut memory.sockets[..]);
        let mut socket = udp::Socket::new(
            udp::PacketBuffer::new(&mut memory.received[..], &mut memory.received_bytes[..]),
            udp::PacketBuffer::new(&mut memory.sent[..], &mut memory.sent_bytes[..]),
        );
        let port = settings.host.port;
        // Refuses port 0 alone, and so does the configuration.
        let _ = socket.bind(port);
        let udp = sockets.add(socket);
        let dhcp = matches!(settings.own, Own::Dhcp).then(|| sockets.add(dhcpv4::Socket::new()));
        let host = IpEndpoint::new(Ipv4Address::from(settings.host.address).into(), port);
        let mut network = Self { device, interface, sockets, udp, dhcp, host, sent: 0, received: 0 };
        if let Own::Static { address, prefix, gateway } = settings.own {
            network.settle(Ipv4Cidr::new(address.into(), prefix), gateway.map(Into::into));
        }
        network
    }

    fn settle(&mut self, own: Ipv4Cidr, gateway: Option<Ipv4Address>) {
        self.interface.update_ip_addrs(|addresses| {
            addresses.clear();
            // There is room for one.
            let _ = addresses.push(IpCidr::Ipv4(own));
        });
        self.interface.routes_mut().remove_default_ipv4_route();
        if let Some(gateway) = gateway {
            // There is room for one.
            let _ = self.interface.routes_mut().add_default_ipv4_route(gateway);
        }
    }

    /// Moves frames both ways, and hands every datagram that came to `handle_datagram`: one frame after the other, as the controller has room for
    /// more of them than the stack.
    pub fn poll(&mut self, now: LocalInstant, mut handle_datagram: impl FnMut(&[u8])) {
        #[expect(clippy::cast_possible_wrap, reason = "292 000 years of microseconds")]
        let at = Instant::from_micros(now.0 as i64);
        self.interface.poll_maintenance(at);
        loop {
            let taken = self.interface.poll_ingress_single(at, &mut self.device, &mut self.sockets);
            let socket = self.sockets.get_mut::<udp::Socket<'_>>(self.udp);
            while let Ok((datagram, _)) = socket.recv() {
                self.received = self.received.wrapping_add(1);
                handle_datagram(datagram);
            }
            if matches!(taken, PollIngressSingleResult::None) {
                break;
            }
        }
        while self.interface.poll_egress(at, &mut self.device, &mut self.sockets) != PollResult::None {}
        if let Some(handle) = self.dhcp {
            let event = self.sockets.get_mut::<dhcpv4::Socket<'_>>(handle).poll();
            let leased = event.map(|event| match event {
                dhcpv4::Event::Configured(lease) => Some((lease.address, lease.router)),
                dhcpv4::Event::Deconfigured => None,
            });
            match leased {
                Some(Some((own, gateway))) => self.settle(own, gateway),
                Some(None) => {
                    self.interface.update_ip_addrs(|addresses| addresses.clear());
                    self.interface.routes_mut().remove_default_ipv4_route();
                }
                None => {}
            }
        }
        // What waits for the way to the host has not left.
        if self.sockets.get_mut::<udp::Socket<'_>>(self.udp).send_queue() == 0 {
            steps::count(self.sent, self.received);
        }
    }

    /// Sends a datagram to the host. It is lost where the module has no address yet, or the stack is full.
    pub fn send(&mut self, datagram: &[u8]) {
        if self.interface.ipv4_addr().is_none() {
            return;
        }
        let host = self.host;
        let sent = self.sockets.get_mut::<udp::Socket<'_>>(self.udp).send_slice(datagram, host);
        self.sent = self.sent.wrapping_add(u32::from(sent.is_ok()));
    }

    /// Lets the controller wake the main loop.
    pub fn listen(&mut self) {
        self.device.listen();
    }
}
