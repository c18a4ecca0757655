//! The server's end of QTM RT: what Qualisys Track Manager would send.

use std::io;
use std::net::{SocketAddr, TcpListener, UdpSocket};

use super::data::{self, Component, Data, SixD};
use super::packet::{self, Packet, event};
use super::parameters;
use super::streaming::Streaming;
use crate::frame::{Body, Frame, Label};
use crate::server::{ServeError, Server};
use crate::stream::Peer;
use crate::time::HostInstant;

/// Clients at once: QTM's own limit.
const MOST_CLIENTS: usize = 10;
/// 1.1 is the version in force until a client names another.
const FIRST_MINOR: u32 = 1;

#[derive(Debug)]
struct Client {
    peer: Peer,
    received: Vec<u8>,
    /// Of the version 1.x in force.
    minor: u32,
    streaming: Option<Streaming>,
}

/// A server of QTM RT.
#[derive(Debug)]
pub struct QtmServer {
    listener: TcpListener,
    udp: UdpSocket,
    address: SocketAddr,
    bodies: Vec<Label>,
    clients: Vec<Client>,
    latest: Option<Frame>,
}

impl QtmServer {
    /// A server on `address`, where port 0 takes a free one, that streams `bodies`.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn new(address: SocketAddr, bodies: &[Label]) -> Result<Self, ServeError> {
        let failed = |source| ServeError { protocol: "QTM", address, source };
        let listener = TcpListener::bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let udp = UdpSocket::bind((address.ip(), 0)).map_err(failed)?;
        udp.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        Ok(Self { listener, udp, address, bodies: bodies.to_vec(), clients: Vec::new(), latest: None })
    }

    fn accept(&mut self) {
        while let Ok((stream, _)) = self.listener.accept() {
            let Ok(mut peer) = Peer::new(stream) else { continue };
            if self.clients.len() >= MOST_CLIENTS {
                // It is told why if it can be told.
                let _ = peer.send(
                    &Packet::Error("Connection refused. Max number of clients reached.".into()).encode(),
                );
                continue;
            }
            let greeting = Packet::Command("QTM RT Interface connected".into());
            if peer.send(&greeting.encode()).is_ok() {
                self.clients.push(Client { peer, received: Vec::new(), minor: FIRST_MINOR, streaming: None });
            }
        }
    }

    fn names(&self) -> Vec<String> {
        self.bodies.iter().map(|label| label.name.as_deref().unwrap_or_default().to_owned()).collect()
    }

    /// A frame as bodies in the order of the parameters; one that the frame does not have was not seen.
    fn wire_data(&self, frame: &Frame) -> Data {
        let bodies = self.bodies.iter().map(|label| {
            let body = frame.bodies.iter().find(|body| body.label == *label);
            body.map_or_else(unseen, |body| SixD {
                position: body.position,
                attitude: body.attitude,
                residual: body.error,
                tracked: body.tracked && is_finite(body),
            })
        });
        Data {
            timestamp_us: u64::try_from(frame.captured.0 / 1000).unwrap_or_default(),
            number: frame.number.unwrap_or_default(),
            bodies: Some(bodies.collect()),
        }
    }

    /// Answers a command; `Err` ends the connection.
    fn answer(&self, client: &mut Client, text: &str) -> io::Result<()> {
        let mut words = text.split_whitespace();
        let command = words.next().unwrap_or_default().to_ascii_lowercase();
        let said = |text: &str| Packet::Command(text.to_owned());
        let answer = match command.as_str() {
            "version" => match words.next().map(served_minor) {
                Some(Some(minor)) => {
                    client.minor = minor;
                    said(&format!("Version set to 1.{minor}"))
                }
                Some(None) => said("Version NOT supported"),
                None => said(&format!("Version is 1.{}", client.minor)),
            },
            "qtmversion" => said("QTM Version is 0.1 (Flotilla)"),
            "byteorder" => said("Byte order is little endian"),
            "getstate" => Packet::Event(event::CAPTURE_STARTED),
            "getparameters" => Packet::Xml(parameters::write(client.minor, &self.names())),
            "getcurrentframe" => {
                let components: Vec<Component> = words.filter_map(Component::named).collect();
                let latest =
                    self.latest.as_ref().map(|frame| data::encode(&self.wire_data(frame), &components));
                latest.map_or(Packet::NoMoreData, Packet::Data)
            }
            "streamframes" if words.clone().next().is_some_and(|word| word.eq_ignore_ascii_case("stop")) => {
                client.streaming = None;
                return Ok(());
            }
            "streamframes" => {
                client.streaming = Streaming::parse(words, client.peer.address()?.ip());
                match client.streaming {
                    Some(_) => return Ok(()),
                    None => Packet::Error("Parse error".into()),
                }
            }
            "takecontrol" => said("You are now master"),
            "releasecontrol" => said("You are now a regular client"),
            _ => Packet::Error("Parse error".into()),
        };
        client.peer.send(&answer.encode())
    }

    /// Takes what a client has sent; `Err` ends the connection.
    fn attend(&self, client: &mut Client) -> io::Result<()> {
        client.peer.flush()?;
        client.peer.receive(&mut client.received)?;
        while let Some(packet) = packet::take(&mut client.received).map_err(io::Error::other)? {
            match packet {
                Packet::Command(text) => self.answer(client, &text)?,
                // Settings cannot be changed here.
                Packet::Xml(_) => {
                    client.peer.send(&Packet::Error("Setting parameters failed".into()).encode())?;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Server for QtmServer {
    fn poll(&mut self, _now: HostInstant) {
        self.accept();
        let mut clients = std::mem::take(&mut self.clients);
        clients.retain_mut(|client| self.attend(client).is_ok());
        self.clients = clients;
    }

    fn send(&mut self, _now: HostInstant, frame: &Frame) {
        let data = self.wire_data(frame);
        let udp = &self.udp;
        self.clients.retain_mut(|client| {
            let Some(streaming) = client.streaming.as_mut() else { return true };
            if !streaming.wants(frame.captured) {
                return true;
            }
            let packet = Packet::Data(data::encode(&data, &streaming.components)).encode();
            match streaming.udp {
                // A datagram that is not sent is a frame lost, as on any network.
                Some(place) => udp.send_to(&packet, place).map(drop).or(Ok(())),
                None => client.peer.send(&packet),
            }
            .is_ok()
        });
        self.latest = Some(frame.clone());
    }

    fn clients(&self) -> usize {
        self.clients.len()
    }

    fn address(&self) -> SocketAddr {
        self.address
    }
}

/// The second number of a version whose bodies are laid out as in [`data`].
fn served_minor(version: &str) -> Option<u32> {
    let minor = version.strip_prefix("1.")?.parse().ok()?;
    (8..=25).contains(&minor).then_some(minor)
}

fn unseen() -> SixD {
    SixD { position: Default::default(), attitude: Default::default(), residual: None, tracked: false }
}

fn is_finite(body: &Body) -> bool {
    body.position.iter().chain(body.attitude.coords.iter()).all(|number| number.is_finite())
}
