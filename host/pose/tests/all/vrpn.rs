//! VRPN over real sockets.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::time::Duration;

use pose::frame::{Frame, Label};
use pose::server::Server;
use pose::source::{Link, Source};
use pose::time::{HostInstant, ServerInstant};
use pose::vrpn::client::VrpnClient;
use pose::vrpn::message::{self, Message, Pose};
use pose::vrpn::server::VrpnServer;

use crate::rig::{ANY_PORT, Rig, frame, labels};

/// Frame `number` as VRPN carries it: names alone, no number, no error; times in microseconds.
fn sent(number: u32) -> Frame {
    let mut frame = frame(number, ServerInstant(1_000_000 * i64::from(number)));
    frame.number = None;
    for body in &mut frame.bodies {
        (body.label.number, body.error) = (None, None);
    }
    frame
}

fn server() -> VrpnServer {
    VrpnServer::new(ANY_PORT, &names()).expect("a free port")
}

fn names() -> Vec<Label> {
    labels().into_iter().map(|label| Label { number: None, ..label }).collect()
}

fn connected(rig: &mut Rig, server: &mut VrpnServer, client: &mut VrpnClient) {
    rig.until(server, client, "a connection", |_, client| client.status().link == Link::Connected);
    // The server has met the client one round after the client has met the server.
    for _ in 0..20 {
        rig.round(server, client).expect("a source that goes on");
    }
}

/// Everything the client has of the next rounds.
fn frames(rig: &mut Rig, server: &mut VrpnServer, client: &mut VrpnClient) -> Vec<Frame> {
    let mut found = Vec::new();
    for _ in 0..50 {
        found.extend(rig.round(server, client).expect("a source that goes on").map(|arrival| arrival.frame));
    }
    found
}

#[test]
fn trackers_of_one_moment_make_one_frame() {
    let mut rig = Rig::default();
    let mut server = server();
    let mut client = VrpnClient::new(server.address(), &[]);
    connected(&mut rig, &mut server, &mut client);
    for number in 1..=5 {
        server.send(rig.now, &sent(number));
        let found = frames(&mut rig, &mut server, &mut client);
        if number > 1 {
            assert_eq!(found, [sent(number)]);
        }
    }
    assert_eq!(client.bodies(), names());
    let status = client.status();
    assert_eq!((status.link, status.connects, status.undecodable), (Link::Streaming, 1, 0));
    assert_eq!(status.server.as_ref().map(|server| server.protocol.as_str()), Some("VRPN 07.38"));
}

#[test]
fn a_tracker_that_sees_nothing_is_missed_and_comes_back() {
    let mut rig = Rig::default();
    let mut server = server();
    let mut client = VrpnClient::new(server.address(), &[]);
    connected(&mut rig, &mut server, &mut client);
    let mut counts = Vec::new();
    for number in 1..=60 {
        let mut frame = sent(number);
        frame.bodies[1].tracked = !(20..40).contains(&number);
        server.send(rig.now, &frame);
        let found = frames(&mut rig, &mut server, &mut client);
        counts.push(found.iter().map(|frame| frame.bodies.len()).collect::<Vec<_>>());
    }
    assert!(counts[5..19].iter().all(|found| *found == [3]), "{counts:?}");
    assert!(counts[19..39].iter().all(|found| *found == [2]), "{counts:?}");
    // The first time after its return the tracker was not waited for.
    assert!(counts[40..].iter().all(|found| *found == [3]), "{counts:?}");
}

#[test]
fn trackers_that_are_added_come_to_clients_that_are_there_and_to_later_ones() {
    let mut rig = Rig::default();
    let mut server = VrpnServer::new(ANY_PORT, &[]).expect("a free port");
    let mut early = VrpnClient::new(server.address(), &[]);
    connected(&mut rig, &mut server, &mut early);
    for label in names() {
        server.add(rig.now, &label);
        // Once more is not another one.
        server.add(rig.now, &label);
    }
    for number in 1..=3 {
        server.send(rig.now, &sent(number));
        let found = frames(&mut rig, &mut server, &mut early);
        assert!(number == 1 || found == [sent(number)], "{found:?}");
    }
    assert_eq!(early.bodies(), names());
    let mut late = VrpnClient::new(server.address(), &[]);
    connected(&mut rig, &mut server, &mut late);
    server.send(rig.now, &sent(9));
    frames(&mut rig, &mut server, &mut late);
    assert_eq!(late.bodies(), names());
}

#[test]
fn only_the_trackers_that_are_wanted_are_taken() {
    let mut rig = Rig::default();
    let mut server = server();
    let mut client = VrpnClient::new(server.address(), &["boat 2"]);
    connected(&mut rig, &mut server, &mut client);
    server.send(rig.now, &sent(1));
    let found = frames(&mut rig, &mut server, &mut client);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].bodies, sent(1).bodies[1..2]);
}

#[test]
fn a_tracker_that_is_not_there_is_named_with_those_that_are() {
    let mut rig = Rig::default();
    let mut server = server();
    let mut client = VrpnClient::new(server.address(), &["boat 9"]);
    connected(&mut rig, &mut server, &mut client);
    for _ in 0..300 {
        server.send(rig.now, &sent(1));
        rig.round(&mut server, &mut client).expect("a source that goes on");
    }
    let trouble = client.status().trouble.clone().expect("trouble");
    assert!(
        trouble.contains("no poses of \"boat 9\"; it has \"boat 1\", \"boat 2\", \"Kälte\""),
        "{trouble}"
    );
    // Its pings were answered all along.
    frames(&mut rig, &mut server, &mut client);
    for _ in 0..20 {
        frames(&mut rig, &mut server, &mut client);
    }
    assert_eq!((client.status().link, client.status().connects), (Link::Connected, 1));
}

#[test]
fn a_server_that_starts_again_is_met_again() {
    let mut rig = Rig::default();
    let mut first = server();
    let address = first.address();
    let mut client = VrpnClient::new(address, &[]);
    connected(&mut rig, &mut first, &mut client);
    drop(first);
    for _ in 0..200 {
        rig.now = rig.now.after(Duration::from_millis(5));
        client.poll(rig.now).expect("a source that goes on");
    }
    assert_eq!(client.status().link, Link::Connecting);
    let mut second = VrpnServer::new(address, &names()).expect("the same port");
    connected(&mut rig, &mut second, &mut client);
    second.send(rig.now, &sent(2));
    assert!(!frames(&mut rig, &mut second, &mut client).is_empty());
    assert_eq!(client.status().connects, 2);
}

#[test]
fn a_client_is_called_back() {
    let mut server = server();
    let listener = TcpListener::bind(ANY_PORT).expect("a free port");
    let port = listener.local_addr().expect("an address").port();
    let request = UdpSocket::bind(ANY_PORT).expect("a free port");
    request.send_to(format!("127.0.0.1 {port}\0").as_bytes(), server.address()).expect("loopback");
    listener.set_nonblocking(true).expect("a socket");
    let mut now = HostInstant::default();
    let mut round = |server: &mut VrpnServer| {
        now = now.after(Duration::from_millis(5));
        server.poll(now);
        std::thread::sleep(Duration::from_millis(1));
    };
    let (mut stream, _) = (0..1000)
        .find_map(|_| {
            round(&mut server);
            listener.accept().ok()
        })
        .expect("a call");
    stream.set_nonblocking(true).expect("a socket");
    stream.write_all(&message::cookie()).expect("loopback");
    (0..20).for_each(|_| round(&mut server));
    server.send(now, &sent(4));
    let mut received = Vec::new();
    let mut poses = Vec::new();
    for _ in 0..1000 {
        server.poll(now);
        let mut buffer = [0; 4096];
        if let Ok(length) = stream.read(&mut buffer) {
            received.extend(&buffer[..length]);
        }
        if received.len() >= 24 + 3 * 88 {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let cookie: Vec<u8> = received.drain(..24).collect();
    assert_eq!(cookie, message::cookie());
    while let Ok(Some(message)) = message::take(&mut received) {
        if message.kind == 0 {
            poses.push(Pose::decode(&message.payload).expect("a pose").position);
        }
    }
    assert_eq!(poses, sent(4).bodies.iter().map(|body| body.position).collect::<Vec<_>>());
}

/// What the client says of a server that sends `bytes` at once.
fn met_with(bytes: &[u8]) -> (VrpnClient, Option<String>) {
    let listener = TcpListener::bind(ANY_PORT).expect("a free port");
    let address: SocketAddr = listener.local_addr().expect("an address");
    let mut client = VrpnClient::new(address, &[]);
    client.poll(HostInstant::default()).expect("a source that goes on");
    let (mut stream, _) = listener.accept().expect("a connection");
    stream.write_all(bytes).expect("loopback");
    for step in 1..200 {
        if let Err(error) = client.poll(HostInstant(Duration::from_millis(step))) {
            return (client, Some(error.to_string()));
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    (client, None)
}

#[test]
fn another_version_and_another_protocol_are_refused() {
    let (_, refused) = met_with(b"vrpn: ver. 06.05  0\0\0\0\0\0");
    assert_eq!(
        refused.as_deref(),
        Some("the server speaks \"vrpn: ver. 06.05\"; this program reads VRPN 07")
    );
    let mut bytes = message::cookie().to_vec();
    bytes.extend([0; 24]);
    let (client, refused) = met_with(&bytes);
    assert_eq!((refused, client.status().undecodable), (None, 1));
    assert_eq!(client.status().link, Link::Connecting);
}

#[test]
fn a_description_cut_short_is_counted_and_passed_over() {
    let mut broken = Message::description(message::SENDER_DESCRIPTION, 1, "boat 1");
    broken.payload.truncate(6);
    let mut bytes = message::cookie().to_vec();
    bytes.extend(broken.encode());
    let (client, refused) = met_with(&bytes);
    assert_eq!((refused, client.status().undecodable), (None, 1));
    assert_eq!(client.status().link, Link::Connected);
}
