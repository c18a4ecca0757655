//! NatNet over real sockets, every version, unicast and multicast.

use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::Duration;

use pose::natnet::client::NatNetClient;
use pose::natnet::message::{ServerInfo, Version};
use pose::natnet::server::{NatNetServer, Settings, Transport};
use pose::server::Server;
use pose::source::{Link, Source, SourceError};
use pose::time::{HostInstant, ServerInstant};

use crate::rig::{ANY_PORT, Rig, frame, labels};

const VERSIONS: [Version; 5] = [Version::V3_0, Version::V3_1, Version::V4_0, Version::V4_1, Version::V4_2];

fn server(version: Version, transport: Transport) -> NatNetServer {
    let settings = Settings { version, transport, clock_ahead_ns: 7_000_000_000 };
    NatNetServer::new(ANY_PORT, settings, &labels()).expect("a free port")
}

/// A group on the loopback interface, with a port that was free a moment ago.
fn multicast() -> Transport {
    let probe = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
    let port = probe.local_addr().expect("an address").port();
    Transport::Multicast {
        group: SocketAddrV4::new(Ipv4Addr::new(239, 255, 42, 99), port),
        interface: Ipv4Addr::LOCALHOST,
    }
}

/// Three frames arrive with every number as sent, and every body with its name.
fn streams(version: Version, transport: Transport) {
    let mut rig = Rig::default();
    let mut server = server(version, transport);
    let mut client = NatNetClient::new(server.address(), None).expect("a client");
    rig.until(&mut server, &mut client, "names of the bodies", |_, client| !client.bodies().is_empty());
    assert_eq!(client.bodies(), labels());
    for number in 1..=3 {
        let arrival = rig.deliver(&mut server, &mut client, number);
        let sent = frame(number, ServerInstant(1_000_000 * i64::from(number)));
        assert_eq!(arrival.frame, sent, "{version} {transport:?}");
        assert!(arrival.arrived <= rig.now);
    }
    let status = client.status();
    assert_eq!((status.link, status.connects, status.undecodable), (Link::Streaming, 1, 0));
    let described = status.server.clone().expect("a description");
    assert_eq!(described.protocol, format!("NatNet {version}"));
    assert_eq!(described.application, "Flotilla 0.1.0");
}

#[test]
fn every_version_streams_in_unicast() {
    VERSIONS.into_iter().for_each(|version| streams(version, Transport::Unicast));
}

#[test]
fn every_version_streams_to_a_group() {
    VERSIONS.into_iter().for_each(|version| streams(version, multicast()));
}

#[test]
fn two_clients_are_served_and_the_group_too() {
    for transport in [Transport::Unicast, multicast()] {
        let mut rig = Rig::default();
        let mut server = server(Version::V4_1, transport);
        let mut first = NatNetClient::new(server.address(), None).expect("a client");
        let mut second = NatNetClient::new(server.address(), None).expect("a client");
        rig.until(&mut server, &mut first, "first", |_, client| !client.bodies().is_empty());
        rig.until(&mut server, &mut second, "second", |_, client| !client.bodies().is_empty());
        rig.deliver(&mut server, &mut first, 5);
        assert_eq!(rig.deliver(&mut server, &mut second, 6).frame.number, Some(6));
        assert_eq!(rig.deliver(&mut server, &mut first, 6).frame.number, Some(6));
    }
}

#[test]
fn a_server_that_starts_again_is_met_again() {
    let mut rig = Rig::default();
    let mut first = server(Version::V4_1, Transport::Unicast);
    let address = first.address();
    let mut client = NatNetClient::new(address, None).expect("a client");
    rig.deliver(&mut first, &mut client, 1);
    drop(first);
    for _ in 0..1000 {
        rig.now = rig.now.after(Duration::from_millis(5));
        assert_eq!(client.poll(rig.now), Ok(None));
    }
    assert_eq!(client.status().link, Link::Connecting);
    // Another version this time: what was learned of the first must not be kept.
    let settings = Settings { version: Version::V3_1, transport: Transport::Unicast, clock_ahead_ns: 0 };
    let mut second = NatNetServer::new(address, settings, &labels()).expect("the same port");
    rig.deliver(&mut second, &mut client, 2);
    assert_eq!(client.status().connects, 2);
    assert_eq!(client.status().undecodable, 0);
}

#[test]
fn a_server_without_frames_or_without_bodies_is_named() {
    for (transport, part) in
        [(Transport::Unicast, "firewall hold UDP back"), (multicast(), "127.0.0.1): is streaming")]
    {
        let mut rig = Rig::default();
        let mut quiet = server(Version::V4_1, transport);
        let mut client = NatNetClient::new(quiet.address(), None).expect("a client");
        let named =
            |client: &dyn Source| client.status().trouble.as_ref().is_some_and(|text| text.contains(part));
        rig.until(&mut quiet, &mut client, part, |_, client| named(client));
        assert_eq!(client.status().link, Link::Connected);
    }
    let mut rig = Rig::default();
    let settings = Settings { version: Version::V4_1, transport: Transport::Unicast, clock_ahead_ns: 0 };
    let mut empty = NatNetServer::new(ANY_PORT, settings, &[]).expect("a free port");
    let mut client = NatNetClient::new(empty.address(), None).expect("a client");
    for number in 1..200 {
        let mut frame = frame(number, ServerInstant(1_000_000 * i64::from(number)));
        frame.bodies.clear();
        empty.send(rig.now, &frame);
        rig.round(&mut empty, &mut client).expect("a source that goes on");
    }
    assert_eq!(client.status().link, Link::Streaming);
    let trouble = client.status().trouble.clone().expect("trouble");
    assert!(trouble.contains("no rigid bodies"), "{trouble}");
}

#[test]
fn the_server_s_clock_is_asked_for() {
    let mut rig = Rig::default();
    let mut server = server(Version::V4_1, Transport::Unicast);
    let mut client = NatNetClient::new(server.address(), None).expect("a client");
    let mut found = None;
    for _ in 0..2000 {
        rig.round(&mut server, &mut client).expect("a source that goes on");
        found = found.or(client.exchange());
    }
    let exchange = found.expect("an exchange of stamps");
    let server_ns = exchange.server.0 - 7_000_000_000;
    let host = |instant: HostInstant| i64::try_from(instant.0.as_nanos()).expect("soon after the start");
    assert!(host(exchange.sent) <= server_ns && server_ns <= host(exchange.received), "{exchange:?}");
}

/// A server that says it speaks `major.minor` and grants or refuses the bitstream 4.1.
fn stranger(version: Version, grants: bool) -> (Result<(), SourceError>, Option<String>) {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
    socket.set_read_timeout(Some(Duration::from_millis(1))).expect("a timeout");
    let mut client = NatNetClient::new(socket.local_addr().expect("an address"), None).expect("a client");
    let info = ServerInfo {
        application: "Motive".into(),
        application_version: [9, 9, 0, 0],
        version,
        clock_hz: 10_000_000,
        data_port: 1511,
        group: None,
    };
    let mut now = HostInstant::default();
    for _ in 0..400 {
        now = now.after(Duration::from_millis(5));
        if let Err(error) = client.poll(now) {
            return (Err(error), None);
        }
        let mut buffer = [0; 1000];
        if let Ok((length, from)) = socket.recv_from(&mut buffer) {
            let answer = match buffer[0] {
                0 => info.encode(),
                2 => {
                    assert_eq!(&buffer[4..length], b"Bitstream,4.1\0");
                    vec![3, 0, 4, 0, u8::from(!grants), 0, 0, 0]
                }
                _ => continue,
            };
            socket.send_to(&answer, from).expect("loopback");
        }
    }
    (Ok(()), client.status().server.clone().map(|server| server.protocol))
}

#[test]
fn a_newer_server_is_asked_for_a_version_that_is_read() {
    assert_eq!(stranger(Version { major: 4, minor: 4 }, true), (Ok(()), Some("NatNet 4.1".into())));
    assert_eq!(stranger(Version::V4_0, false), (Ok(()), Some("NatNet 4.0".into())));
    for (version, grants) in [((4, 4), false), ((5, 0), true), ((2, 9), true)] {
        let version = Version { major: version.0, minor: version.1 };
        let (refused, _) = stranger(version, grants);
        let text = refused.expect_err("a version that is not read").to_string();
        assert!(text.contains(&format!("speaks NatNet {version}")), "{text}");
        assert!(text.contains("reads NatNet 3.0 to 4.2"), "{text}");
    }
}
