//! Queues of datagrams between the network, in thread mode, and the control loop above it.
//!
//! Two queues of fixed length. What finds its queue full is dropped: it is UDP, and the sender counts on that. What waits while
//! there is no network is dropped too, as it would be old by the time there is one.
//!
//! The socket takes datagrams from any sender: `firmware::link::session` decides what is let in. What the module says goes to the one host
//! of the configuration, from the port of the same number.

use embassy_futures::join::join;
use embassy_net::udp::{PacketMetadata, RecvError, UdpSocket};
use embassy_net::{Config, Ipv4Address, Ipv4Cidr, Stack, StaticConfigV4};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use heapless::Vec;
use protocol::MAX_DATAGRAM;
use protocol::configuration::{Host, Own};

/// One datagram.
pub type Datagram = Vec<u8, MAX_DATAGRAM>;

/// Sockets of a module: this one and that of DHCP.
pub const SOCKETS: usize = 2;

/// Datagrams that wait for the control loop, at most. It takes them as they come; only where it is busy do they wait.
const INCOMING: usize = 4;

/// Datagrams that wait for the network, at most: as many as an endpoint has ready at once.
const OUTGOING: usize = 8;

/// Datagrams in the socket, each way. It moves them on at once.
const IN_SOCKET: usize = 4;

/// Queues of datagrams between the network task and the control loop.
pub struct Link {
    incoming: Channel<CriticalSectionRawMutex, Datagram, INCOMING>,
    outgoing: Channel<CriticalSectionRawMutex, Datagram, OUTGOING>,
}

impl Link {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self { incoming: Channel::new(), outgoing: Channel::new() }
    }

    /// The next datagram that came.
    pub async fn receive(&self) -> Datagram {
        self.incoming.receive().await
    }

    /// Hands a datagram to the network, if there is room.
    pub fn send(&self, datagram: &[u8]) {
        if let Ok(datagram) = Vec::from_slice(datagram) {
            // Full: the newest is dropped.
            let _ = self.outgoing.try_send(datagram);
        }
    }

    /// Carries datagrams for ever, whenever there is a network.
    pub async fn serve(&self, stack: Stack<'static>, host: Host) -> ! {
        let mut metadata = ([PacketMetadata::EMPTY; IN_SOCKET], [PacketMetadata::EMPTY; IN_SOCKET]);
        let mut payload = ([0; IN_SOCKET * MAX_DATAGRAM], [0; IN_SOCKET * MAX_DATAGRAM]);
        let mut socket =
            UdpSocket::new(stack, &mut metadata.0, &mut payload.0, &mut metadata.1, &mut payload.1);
        socket.bind(host.port).expect("the socket is new, and no configuration has port 0");
        join(self.take_in(&socket), self.send_out(stack, &socket, host)).await.0
    }

    async fn take_in(&self, socket: &UdpSocket<'_>) -> ! {
        let mut buffer = [0; MAX_DATAGRAM];
        loop {
            let datagram = match socket.recv_from(&mut buffer).await {
                Ok((length, _)) => buffer.get(..length).and_then(|bytes| Vec::from_slice(bytes).ok()),
                // No datagram of this protocol has that length.
                Err(RecvError::Truncated) => None,
            };
            if let Some(datagram) = datagram {
                // Full: the newest is dropped.
                let _ = self.incoming.try_send(datagram);
            }
        }
    }

    async fn send_out(&self, stack: Stack<'static>, socket: &UdpSocket<'_>, host: Host) {
        let to = (Ipv4Address::from(host.address), host.port);
        loop {
            let datagram = self.outgoing.receive().await;
            if stack.is_link_up() && stack.is_config_up() {
                // No route to the host: lost, like any datagram may be.
                let _ = socket.send_to(&datagram, to).await;
            }
        }
    }
}

impl Default for Link {
    fn default() -> Self {
        Self::new()
    }
}

/// How the network's side of the configuration is said to the network.
#[must_use]
pub fn addresses(own: Own) -> Config {
    match own {
        Own::Dhcp => Config::dhcpv4(embassy_net::DhcpConfig::default()),
        Own::Static { address, prefix, gateway } => Config::ipv4_static(StaticConfigV4 {
            address: Ipv4Cidr::new(Ipv4Address::from(address), prefix),
            gateway: gateway.map(Ipv4Address::from),
            dns_servers: Vec::new(),
        }),
    }
}
