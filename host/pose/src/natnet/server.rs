//! The server's end of NatNet: what Motive would send.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::time::Duration;

use super::frames::{self, FrameOfData, RigidBody};
use super::message::{self, ServerInfo, Version, kind};
use super::models::{self, Model};
use crate::bytes::{Reader, put_text};
use crate::frame::{Frame, Label};
use crate::server::{ServeError, Server};
use crate::time::{HostInstant, ServerInstant};

/// Ticks a second of the simulated server's clock: Motive on Windows 10 and later counts 10 MHz.
const CLOCK_HZ: u64 = 10_000_000;
/// A unicast client that is silent for this time is forgotten. *Assumed.*
const FORGET_AFTER: Duration = Duration::from_secs(10);
/// Unicast clients at once. *Assumed.*
const MOST_CLIENTS: usize = 64;
/// Requests that are answered in one poll. *Assumed.*
const MOST_A_POLL: usize = 256;

/// How frames are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// To each client that has asked.
    Unicast,
    /// To a group, out of the interface with this address.
    Multicast {
        /// The group and the data port.
        group: SocketAddrV4,
        /// This machine's address in the network of the clients.
        interface: Ipv4Addr,
    },
}

/// How a server is set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The bitstream.
    pub version: Version,
    /// How frames are sent.
    pub transport: Transport,
    /// The server's clock less the host's, ns: what answers to questions for the clock say.
    pub clock_ahead_ns: i64,
}

#[derive(Debug)]
struct Listener {
    address: SocketAddr,
    version: Version,
    heard: HostInstant,
}

/// A server of NatNet.
#[derive(Debug)]
pub struct NatNetServer {
    command: UdpSocket,
    address: SocketAddr,
    /// Where multicast frames are sent, and from which socket.
    group: Option<(UdpSocket, SocketAddrV4)>,
    settings: Settings,
    models: Vec<Model>,
    listeners: Vec<Listener>,
    latest: Option<FrameOfData>,
    buffer: Vec<u8>,
}

impl NatNetServer {
    /// A server with its command port at `address`, where port 0 takes a free one, that streams `bodies`. Bodies without a number
    /// are counted from one.
    ///
    /// # Errors
    /// A port that is taken, an interface that is not there.
    pub fn new(address: SocketAddr, settings: Settings, bodies: &[Label]) -> Result<Self, ServeError> {
        let failed = |source| ServeError { protocol: "NatNet", address, source };
        let command = UdpSocket::bind(address).map_err(failed)?;
        command.set_nonblocking(true).map_err(failed)?;
        let group = match settings.transport {
            Transport::Unicast => None,
            Transport::Multicast { group, interface } => {
                Some((open_group(interface).map_err(failed)?, group))
            }
        };
        let models = (1..).zip(bodies).map(|(count, label)| Model {
            number: label.number.unwrap_or(count),
            name: label.name.as_deref().unwrap_or_default().to_owned(),
        });
        let address = command.local_addr().map_err(failed)?;
        let models = models.collect();
        let (listeners, latest, buffer) = (Vec::new(), None, vec![0; message::LARGEST + 4]);
        Ok(Self { command, address, group, settings, models, listeners, latest, buffer })
    }

    fn ticks(&self, now: HostInstant) -> u64 {
        let host = i64::try_from(now.0.as_nanos()).unwrap_or(i64::MAX);
        ServerInstant(host.saturating_add(self.settings.clock_ahead_ns)).ticks(CLOCK_HZ)
    }

    fn info(&self) -> Vec<u8> {
        let group = self.group.as_ref().map(|(_, group)| *group);
        let info = ServerInfo {
            application: "Flotilla".into(),
            application_version: [0, 1, 0, 0],
            version: self.settings.version,
            clock_hz: CLOCK_HZ,
            data_port: group.map_or(message::DATA_PORT, |group| group.port()),
            group: group.map(|group| *group.ip()),
        };
        info.encode()
    }

    /// Notes a sign of life; a client that says hello becomes a listener.
    fn hear(&mut self, now: HostInstant, from: SocketAddr, hello: bool) {
        if let Some(listener) = self.listeners.iter_mut().find(|listener| listener.address == from) {
            listener.heard = now;
        } else if hello && self.group.is_none() && self.listeners.len() < MOST_CLIENTS {
            self.listeners.push(Listener { address: from, version: self.settings.version, heard: now });
        }
    }

    fn version_for(&self, address: SocketAddr) -> Version {
        let known = self.listeners.iter().find(|listener| listener.address == address);
        known.map_or(self.settings.version, |listener| listener.version)
    }

    /// Agrees on a bitstream with a unicast client; whether it does.
    fn agree(&mut self, from: SocketAddr, wanted: Version) -> bool {
        let listener = self.listeners.iter_mut().find(|listener| listener.address == from);
        let granted = wanted.is_read() && wanted <= self.settings.version;
        listener.filter(|_| granted).map(|listener| listener.version = wanted).is_some()
    }

    fn answer(&mut self, now: HostInstant, from: SocketAddr, datagram: &[u8]) -> Option<Vec<u8>> {
        let (kind, payload) = message::split(datagram).ok()?;
        self.hear(now, from, kind == kind::CONNECT);
        match kind {
            kind::CONNECT => {
                if let Some(wanted) = message::wanted_bitstream(payload) {
                    self.agree(from, wanted);
                }
                Some(self.info())
            }
            kind::REQUEST_MODEL_DEF => Some(models::encode(&self.models, self.version_for(from))),
            kind::REQUEST_FRAME_OF_DATA => {
                self.latest.as_ref().map(|frame| frames::encode(frame, self.version_for(from)))
            }
            kind::REQUEST => Some(self.request(from, &Reader::new(payload).text().ok()?)),
            kind::ECHO_REQUEST => {
                let stamp = Reader::new(payload).u64_le().ok()?;
                let ticks = self.ticks(now);
                Some(message::message(kind::ECHO_RESPONSE, |out| {
                    out.extend(stamp.to_le_bytes());
                    out.extend(ticks.to_le_bytes());
                }))
            }
            kind::DISCONNECT => {
                self.listeners.retain(|listener| listener.address != from);
                None
            }
            kind::KEEP_ALIVE => None,
            _ => Some(message::message(kind::UNRECOGNIZED_REQUEST, |_| ())),
        }
    }

    fn request(&mut self, from: SocketAddr, text: &str) -> Vec<u8> {
        match text.split_once(',') {
            None if text == "Bitstream" => {
                let version = self.version_for(from);
                message::message(kind::RESPONSE, |out| put_text(out, &format!("Bitstream,{version}")))
            }
            Some(("Bitstream", wanted)) => {
                let mut numbers = wanted.split('.').map_while(|number| number.trim().parse().ok());
                let wanted = numbers.next().zip(numbers.next());
                let granted = wanted.is_some_and(|(major, minor)| self.agree(from, Version { major, minor }));
                message::message(kind::RESPONSE, |out| out.extend(i32::from(!granted).to_le_bytes()))
            }
            _ => message::message(kind::UNRECOGNIZED_REQUEST, |_| ()),
        }
    }

    fn wire_frame(&self, now: HostInstant, frame: &Frame) -> FrameOfData {
        let number_of = |label: &Label| {
            let named = self.models.iter().find(|model| Some(model.name.as_str()) == label.name.as_deref());
            label.number.or(named.map(|model| model.number))
        };
        let bodies = frame.bodies.iter().filter_map(|body| {
            Some(RigidBody {
                number: number_of(&body.label)?,
                position: body.position,
                attitude: body.attitude,
                error: body.error.unwrap_or_default(),
                tracked: body.tracked,
            })
        });
        FrameOfData {
            number: frame.number.unwrap_or_default(),
            bodies: bodies.collect(),
            timestamp_s: frame.captured.seconds(),
            mid_exposure: frame.captured.ticks(CLOCK_HZ),
            transmitted: self.ticks(now),
            models_changed: false,
        }
    }
}

impl Server for NatNetServer {
    fn poll(&mut self, now: HostInstant) {
        for _ in 0..MOST_A_POLL {
            // An error other than "nothing there" is the echo of a client that has gone.
            let Ok((length, from)) = self.command.recv_from(&mut self.buffer) else { break };
            let datagram = self.buffer.get(..length).unwrap_or_default().to_vec();
            if let Some(answer) = self.answer(now, from, &datagram) {
                // A client that cannot be reached asks again or is forgotten.
                let _ = self.command.send_to(&answer, from);
            }
        }
        self.listeners.retain(|listener| now.since(listener.heard) < FORGET_AFTER);
    }

    fn send(&mut self, now: HostInstant, frame: &Frame) {
        let frame = self.wire_frame(now, frame);
        if let Some((socket, group)) = &self.group {
            // A datagram that is not sent is a frame lost, as on any network.
            let _ = socket.send_to(&frames::encode(&frame, self.settings.version), group);
        }
        for listener in &self.listeners {
            let _ = self.command.send_to(&frames::encode(&frame, listener.version), listener.address);
        }
        self.latest = Some(frame);
    }

    fn set_clock_ahead_ns(&mut self, clock_ahead_ns: i64) {
        self.settings.clock_ahead_ns = clock_ahead_ns;
    }

    fn clients(&self) -> usize {
        self.listeners.len()
    }

    fn address(&self) -> SocketAddr {
        self.address
    }
}

fn open_group(interface: Ipv4Addr) -> io::Result<UdpSocket> {
    let socket = UdpSocket::bind((interface, 0))?;
    socket.set_nonblocking(true)?;
    socket.set_multicast_loop_v4(true)?;
    socket2::SockRef::from(&socket).set_multicast_if_v4(&interface)?;
    Ok(socket)
}
