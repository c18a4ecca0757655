//! QTM RT over real sockets.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use nalgebra::Quaternion;
use pose::frame::{Frame, Label};
use pose::qtm::client::QtmClient;
use pose::qtm::data::{self, Component, Data, SixD};
use pose::qtm::packet::{self, Packet};
use pose::qtm::server::QtmServer;
use pose::qtm::session::Session;
use pose::server::Server;
use pose::source::{Link, Source, Status};
use pose::time::{HostInstant, ServerInstant};

use crate::rig::{ANY_PORT, Rig, frame, labels};

/// QTM has names alone.
fn names() -> Vec<Label> {
    labels().into_iter().map(|label| Label { number: None, ..label }).collect()
}

/// What QTM makes of a frame: names alone.
fn by_name(mut frame: Frame) -> Frame {
    frame.bodies.iter_mut().for_each(|body| body.label.number = None);
    frame
}

/// A server of names alone takes frames whose bodies have numbers too.
struct ByName(QtmServer);

impl Server for ByName {
    fn poll(&mut self, now: HostInstant) {
        self.0.poll(now);
    }

    fn send(&mut self, now: HostInstant, frame: &Frame) {
        self.0.send(now, &by_name(frame.clone()));
    }

    fn clients(&self) -> usize {
        self.0.clients()
    }

    fn address(&self) -> std::net::SocketAddr {
        self.0.address()
    }
}

fn server() -> ByName {
    ByName(QtmServer::new(ANY_PORT, &names()).expect("a free port"))
}

fn assert_same(found: &Frame, sent: &Frame) {
    assert_eq!((found.number, found.captured), (sent.number, sent.captured));
    assert_eq!(found.bodies.len(), sent.bodies.len());
    for (found, sent) in found.bodies.iter().zip(&sent.bodies) {
        assert_eq!((&found.label, found.position, found.tracked), (&sent.label, sent.position, true));
        let same = found.attitude.dot(&sent.attitude).abs();
        assert!((same - 1.0).abs() < 1e-7, "{} for {}", found.attitude, sent.attitude);
        assert_eq!(found.error, Some(0.125));
    }
}

#[test]
fn frames_come_over_tcp_and_udp() {
    for over_udp in [false, true] {
        let mut rig = Rig::default();
        let mut server = server();
        let mut client = QtmClient::new(server.address(), over_udp).expect("a client");
        rig.until(&mut server, &mut client, "a connection", |_, client| {
            client.status().link == Link::Connected
        });
        assert_eq!(client.bodies(), names());
        for number in 1..=3 {
            let arrival = rig.deliver(&mut server, &mut client, number);
            assert_same(
                &arrival.frame,
                &by_name(frame(number, ServerInstant(1_000_000 * i64::from(number)))),
            );
        }
        let status = client.status();
        assert_eq!((status.link, status.connects, status.undecodable), (Link::Streaming, 1, 0));
        let described = status.server.clone().expect("a description");
        assert_eq!(described.protocol, "QTM RT 1.25");
        assert_eq!(described.application, "QTM 0.1 (Flotilla)");
        assert_eq!(described.transport.starts_with("UDP"), over_udp);
    }
}

#[test]
fn a_body_that_is_not_tracked_or_not_finite_is_said_to_be_unseen() {
    let mut rig = Rig::default();
    let mut server = server();
    let mut client = QtmClient::new(server.address(), false).expect("a client");
    rig.deliver(&mut server, &mut client, 1);
    let mut spoiled = frame(2, ServerInstant(0));
    spoiled.bodies[0].tracked = false;
    spoiled.bodies[1].attitude = Quaternion::new(f64::NAN, 0.0, 0.0, 0.0);
    spoiled.bodies.remove(2);
    server.send(rig.now, &spoiled);
    let arrival = std::iter::from_fn(|| rig.round(&mut server, &mut client).ok())
        .find_map(|arrival| arrival.filter(|arrival| arrival.frame.number == Some(2)))
        .expect("the frame");
    assert_eq!(arrival.frame.bodies.len(), 3, "QTM sends every body of its settings");
    assert!(arrival.frame.bodies.iter().all(|body| !body.tracked));
}

#[test]
fn a_server_that_starts_again_is_met_again() {
    let mut rig = Rig::default();
    let mut first = server();
    let address = first.address();
    let mut client = QtmClient::new(address, false).expect("a client");
    rig.deliver(&mut first, &mut client, 1);
    drop(first);
    for _ in 0..200 {
        rig.now = rig.now.after(Duration::from_millis(5));
        client.poll(rig.now).expect("a source that goes on");
    }
    assert_eq!(client.status().link, Link::Connecting);
    let mut second = ByName(QtmServer::new(address, &names()).expect("the same port"));
    rig.deliver(&mut second, &mut client, 2);
    assert_eq!(client.status().connects, 2);
}

/// A server that answers as `answer` says, until the client gives up or has waited long.
fn stranger(answer: impl Fn(&str) -> Option<Packet>) -> (QtmClient, Option<String>) {
    let listener = TcpListener::bind(ANY_PORT).expect("a free port");
    listener.set_nonblocking(true).expect("a socket");
    let mut client = QtmClient::new(listener.local_addr().expect("an address"), false).expect("a client");
    let mut peer: Option<TcpStream> = None;
    let mut received = Vec::new();
    let mut now = HostInstant::default();
    for _ in 0..400 {
        now = now.after(Duration::from_millis(5));
        if let Err(error) = client.poll(now) {
            return (client, Some(error.to_string()));
        }
        if let Ok((mut stream, _)) = listener.accept() {
            stream.set_nonblocking(true).expect("a socket");
            let greeting = Packet::Command("QTM RT Interface connected".into()).encode();
            stream.write_all(&greeting).expect("loopback");
            peer = Some(stream);
        }
        let mut buffer = [0; 1000];
        if let Some(stream) = &mut peer
            && let Ok(length) = stream.read(&mut buffer)
        {
            received.extend(&buffer[..length]);
            while let Ok(Some(packet)) = packet::take(&mut received) {
                let Packet::Command(text) = packet else { continue };
                if let Some(answer) = answer(&text) {
                    let _ = stream.write_all(&answer.encode());
                }
            }
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    (client, None)
}

#[test]
fn an_older_server_is_asked_for_less() {
    let (client, refused) = stranger(|text| match text {
        "Version 1.13" => Some(Packet::Command("Version set to 1.13".into())),
        "GetParameters 6D" => Some(Packet::Xml("<Q><The_6D><Body><Name>a</Name></Body></The_6D></Q>".into())),
        _ if text.starts_with("Version") => Some(Packet::Command("Version NOT supported".into())),
        _ => None,
    });
    assert_eq!(refused, None);
    assert_eq!(client.status().server.as_ref().map(|server| server.protocol.as_str()), Some("QTM RT 1.13"));
    assert_eq!(client.status().link, Link::Connected);
}

#[test]
fn a_server_that_speaks_no_version_is_refused() {
    let (_, refused) = stranger(|_| Some(Packet::Error("Version NOT supported".into())));
    let text = refused.expect("a refusal");
    assert!(text.contains("reads QTM RT 1.8 to 1.25"), "{text}");
}

#[test]
fn names_go_by_place_with_and_without_bodies_that_are_switched_off() {
    let settings = "<Q><The_6D><Body><Name>a</Name><Enabled>false</Enabled></Body><Body><Name>b</Name></Body>\
                    <Body><Name>c</Name></Body></The_6D></Q>";
    let names = |count: usize| {
        let mut status = Status::default();
        let now = HostInstant::default();
        let mut session = Session::new(now, None);
        let bodies = frame(1, ServerInstant(0)).bodies.into_iter().cycle().take(count).map(|body| SixD {
            position: body.position,
            attitude: body.attitude,
            residual: None,
            tracked: true,
        });
        let data = Data { timestamp_us: 1, number: 1, bodies: Some(bodies.collect()) };
        let packets = [
            Packet::Command("QTM RT Interface connected".into()),
            Packet::Command("Version set to 1.25".into()),
            Packet::Xml(settings.into()),
            Packet::Data(data::encode(&data, &[Component::Matrix])),
        ];
        let found = packets.into_iter().filter_map(|packet| {
            session.handle_packet(now, packet, &mut status).expect("a session that goes on")
        });
        let frame = found.last().expect("a frame");
        let labels: Vec<String> = frame.bodies.iter().map(|body| body.label.to_string()).collect();
        labels.join(", ")
    };
    assert_eq!(names(2), "\"b\", \"c\"");
    assert_eq!(names(3), "\"a\", \"b\", \"c\"");
    assert_eq!(names(1), "without a name");
}

#[test]
fn a_server_without_bodies_is_named() {
    let (client, refused) = stranger(|text| match text {
        "GetParameters 6D" => Some(Packet::Xml("<Q><The_6D></The_6D></Q>".into())),
        _ if text.starts_with("Version") => Some(Packet::Command("Version set to 1.25".into())),
        _ => None,
    });
    assert_eq!(refused, None);
    let trouble = client.status().trouble.clone().expect("trouble");
    assert!(trouble.contains("no 6DOF bodies"), "{trouble}");
}

#[test]
fn what_speaks_another_protocol_is_no_server() {
    let listener = TcpListener::bind(ANY_PORT).expect("a free port");
    let mut client = QtmClient::new(listener.local_addr().expect("an address"), false).expect("a client");
    client.poll(HostInstant::default()).expect("a source that goes on");
    let (mut stream, _) = listener.accept().expect("a connection");
    stream.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n").expect("loopback");
    for step in 1..200 {
        client.poll(HostInstant(Duration::from_millis(step))).expect("a source that goes on");
        std::thread::sleep(Duration::from_micros(200));
    }
    assert_eq!(client.status().undecodable, 1);
    let trouble = client.status().trouble.clone().expect("trouble");
    assert!(trouble.contains("does not speak QTM RT"), "{trouble}");
}
