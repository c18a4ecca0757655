//! NatNet: libmotioncapture, the Python package `natnet` and the crate `natnet`.

#![expect(clippy::float_cmp, reason = "single precision holds all these numbers exactly")]

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::time::Duration;

use mocap::{frame, frames_read, judge, labels};
use natnet::{Decoder, Message, PlannedBody, ServerInfo, SyntheticServer};
use pose::frame::Frame;
use pose::natnet::client::NatNetClient;
use pose::natnet::message::Version;
use pose::natnet::server::{NatNetServer, Settings, Transport};
use pose::natnet::{frames, models};
use pose::server::Server;
use pose::source::{Link, Source};
use pose::time::{HostInstant, ServerInstant};

const VERSIONS: [Version; 4] = [Version::V3_0, Version::V3_1, Version::V4_0, Version::V4_1];
const LOCAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

fn free_port() -> u16 {
    let probe = UdpSocket::bind(LOCAL).expect("a free port");
    probe.local_addr().expect("an address").port()
}

fn server(version: Version, transport: Transport) -> NatNetServer {
    let settings = Settings { version, transport, clock_ahead_ns: 0 };
    NatNetServer::new(LOCAL, settings, &labels()).expect("a free port")
}

fn multicast(data_port: u16) -> Transport {
    let group = SocketAddrV4::new(Ipv4Addr::new(239, 255, 42, 99), data_port);
    Transport::Multicast { group, interface: Ipv4Addr::LOCALHOST }
}

/// The second body is not tracked.
fn without_one(mut frame: Frame) -> Frame {
    frame.bodies[1].tracked = false;
    frame
}

#[test]
fn libmotioncapture_reads_our_multicast() {
    for version in VERSIONS {
        let mut server = server(version, multicast(free_port()));
        let command = format!("port_command={}", server.address().port());
        let arguments = ["optitrack", "20", "hostname=127.0.0.1", "interface_ip=127.0.0.1", &command];
        let lines =
            frames_read(&mut server, "motioncapture_frames.py", &arguments.map(str::to_owned), without_one);
        judge(&lines, 20, |number| without_one(frame(number)));
    }
}

#[test]
fn the_python_natnet_reads_our_unicast_and_multicast() {
    for version in VERSIONS {
        for transport in [Transport::Unicast, multicast(free_port())] {
            let mut server = server(version, transport);
            let (data, how) = match transport {
                Transport::Unicast => (0, "unicast"),
                Transport::Multicast { group, .. } => (group.port(), "multicast"),
            };
            let arguments = ["20".into(), server.address().port().to_string(), data.to_string(), how.into()];
            let lines = frames_read(&mut server, "natnet_frames.py", &arguments, without_one);
            judge(&lines, 20, |number| without_one(frame(number)));
            assert!(lines.iter().all(|line| line.number.is_some() && line.captured_us.is_some()));
        }
    }
}

#[test]
fn the_python_natnet_is_granted_another_bitstream() {
    let mut server = server(Version::V4_1, Transport::Unicast);
    let port = server.address().port().to_string();
    let arguments = ["20".into(), port, "0".into(), "unicast".into(), "3.1".into()];
    let lines = frames_read(&mut server, "natnet_frames.py", &arguments, |frame| frame);
    judge(&lines, 20, frame);
}

/// Their version for ours.
fn theirs(version: Version) -> natnet::Version {
    natnet::Version::new(version.major, version.minor, 0, 0)
}

#[test]
fn the_crate_reads_what_we_encode_to_the_last_byte() {
    for version in VERSIONS {
        let decoder = Decoder::new(theirs(version)).expect("a version of theirs");
        let sent = frames::FrameOfData {
            number: 41,
            bodies: frame(41)
                .bodies
                .iter()
                .zip(1..)
                .map(|(body, number)| frames::RigidBody {
                    number,
                    position: body.position,
                    attitude: body.attitude,
                    error: 0.5,
                    tracked: number != 2,
                })
                .collect(),
            timestamp_s: 12.5,
            mid_exposure: 125_000_000,
            transmitted: 125_010_000,
            models_changed: true,
        };
        let datagram = frames::encode(&sent, version);
        let decoded = decoder.parse(&datagram).expect("a frame");
        let Message::FrameOfData(read) = decoded.message() else { panic!("{decoded:?}") };
        assert_eq!((read.frame_number, read.params, read.timing.timestamp), (41, 2, 12.5));
        assert_eq!(read.timing.camera_mid_exposure, 125_000_000);
        for (read, sent) in read.rigid_bodies.iter().zip(&sent.bodies) {
            assert_eq!(read.id, sent.number);
            assert_eq!(read.position.map(f64::from), <[f64; 3]>::from(sent.position));
            assert_eq!(read.orientation.map(f64::from), <[f64; 4]>::from(sent.attitude.coords));
            assert_eq!(read.params & 1 == 1, sent.tracked);
        }
        assert_eq!(decoded.to_datagram().expect("the same again"), datagram);
        let defined = [models::Model { number: 7, name: "Kälte".into() }];
        let datagram = models::encode(&defined, version);
        let decoded = decoder.parse(&datagram).expect("definitions");
        let Message::ModelDef(read) = decoded.message() else { panic!("{decoded:?}") };
        assert_eq!(read.rigid_bodies().collect::<Vec<_>>(), [("Kälte", 7)]);
        assert_eq!(decoded.to_datagram().expect("the same again"), datagram);
    }
}

/// Every section that a frame can have, so that our reader must get past all of them.
fn full_frame(server: &SyntheticServer, number: i32) -> Vec<u8> {
    use natnet::{Asset, Device, ForcePlate, LabeledMarker, MarkerSet, PlannedSections, RigidBody, Skeleton};
    let bone = RigidBody {
        id: 9,
        position: [9.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        mean_marker_error: 0.0,
        params: 1,
    };
    let marker = |id| LabeledMarker { id, position: [1.0; 3], size: 0.01, params: 2, residual: 0.001 };
    let newest = server.version == natnet::Version::V4_1;
    let sections = PlannedSections {
        skeletons: vec![Skeleton { id: 1, rigid_bodies: vec![bone, bone] }],
        assets: if newest {
            vec![Asset { id: 3, rigid_bodies: vec![bone], markers: vec![marker(4)] }]
        } else {
            Vec::new()
        },
        force_plates: vec![ForcePlate { id: 1, channels: vec![vec![1.0, 2.0], vec![3.0]] }],
        devices: vec![Device { id: 2, channels: vec![vec![4.0], Vec::new()] }],
    };
    let bodies = [
        PlannedBody::tracked(1, [0.25, -1.5, 8.0], [0.5, -0.5, 0.5, 0.5]),
        PlannedBody::dropout(2),
        PlannedBody::tracked(7, [-0.5, 0.0, 2.0], [0.0, 0.0, 0.0, 1.0]),
    ];
    let mut frame = server
        .frame_with_sections(number, f64::from(number) / 100.0, &bodies, &sections)
        .expect("a frame of theirs");
    frame.marker_sets = vec![MarkerSet { name: "all".into(), markers: vec![[1.0; 3], [2.0; 3]] }];
    frame.other_markers = vec![[3.0; 3]];
    frame.labeled_markers = vec![marker(1), marker(2)];
    frame.to_datagram(server.version).expect("a datagram of theirs")
}

/// Definitions of every kind around the two rigid bodies.
fn full_definitions(server: &SyntheticServer) -> Vec<u8> {
    use natnet::modeldef::{
        CameraDef, DataSet, DeviceDef, ForcePlateDef, MarkerSetDef, RigidBodyDef, SkeletonDef,
    };
    let tail = if server.version.major >= 4 {
        [&1_i32.to_le_bytes()[..], &[0; 16], b"m\0"].concat()
    } else {
        [&1_i32.to_le_bytes()[..], &[0; 16]].concat()
    };
    let body = |id, name: &str| RigidBodyDef {
        name: name.into(),
        id,
        parent_id: -1,
        offset: [0.0; 3],
        tail: tail.clone(),
    };
    let datasets = vec![
        DataSet::MarkerSet(MarkerSetDef { name: "all".into(), marker_names: vec!["a".into(), "b".into()] }),
        DataSet::RigidBody(body(1, "boat 1")),
        DataSet::Skeleton(SkeletonDef { name: "s".into(), id: 1, rigid_bodies: vec![body(9, "bone")] }),
        DataSet::ForcePlate(Box::new(ForcePlateDef {
            id: 1,
            serial_number: "fp".into(),
            width: 0.5,
            length: 0.5,
            origin: [0.0; 3],
            calibration_matrix: [[0.0; 12]; 12],
            corners: [[0.0; 3]; 4],
            plate_type: 0,
            channel_data_type: 0,
            channel_names: vec!["Fx".into()],
        })),
        DataSet::Device(DeviceDef {
            id: 2,
            name: "d".into(),
            serial_number: "n".into(),
            device_type: 0,
            channel_data_type: 0,
            channel_names: vec!["c".into()],
        }),
        DataSet::Camera(CameraDef {
            name: "cam".into(),
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }),
        DataSet::RigidBody(body(7, "Kälte")),
    ];
    server.model_def_datagram(&natnet::ModelDef { datasets }).expect("definitions of theirs")
}

#[test]
fn our_client_reads_the_crate_s_synthetic_server() {
    for version in VERSIONS {
        let synthetic = SyntheticServer::new(theirs(version), 1_000_000);
        let info = ServerInfo {
            application_name: "Synthetic".into(),
            server_version: natnet::Version::new(3, 1, 2, 1),
            protocol_version: theirs(version),
            high_res_clock_frequency: 1_000_000,
            connection: natnet::ConnectionInfo {
                data_port: 1511,
                multicast: false,
                multicast_group: [239, 255, 42, 99],
            },
        };
        let socket = UdpSocket::bind(LOCAL).expect("a free port");
        socket.set_read_timeout(Some(Duration::from_millis(2))).expect("a timeout");
        let mut client = NatNetClient::new(socket.local_addr().expect("an address"), None).expect("a client");
        let mut now = HostInstant::default();
        let mut number = 0;
        let mut read = Vec::new();
        let mut peer = None;
        for _ in 0..1000 {
            now = now.after(Duration::from_millis(5));
            while let Some(arrival) = client.poll(now).expect("a version that is read") {
                read.push(arrival.frame);
            }
            let mut buffer = [0; 1000];
            if let Ok((_, from)) = socket.recv_from(&mut buffer) {
                peer = Some(from);
                let answer = match buffer[0] {
                    0 => info.to_datagram().expect("information of theirs"),
                    4 => full_definitions(&synthetic),
                    _ => continue,
                };
                socket.send_to(&answer, from).expect("loopback");
            }
            if let Some(peer) = peer {
                number += 1;
                socket.send_to(&full_frame(&synthetic, number), peer).expect("loopback");
            }
            if read.len() >= 20 && !client.bodies().is_empty() {
                break;
            }
        }
        let status = client.status();
        assert_eq!((status.link, status.undecodable), (Link::Streaming, 0), "{version}: {status:?}");
        let names: Vec<String> = client.bodies().iter().map(ToString::to_string).collect();
        assert_eq!(names, ["\"boat 1\" (number 1)", "\"Kälte\" (number 7)"]);
        let last = read.last().expect("frames");
        let number = i64::from(last.number.expect("a number"));
        assert_eq!(last.captured, ServerInstant(number * 10_000_000));
        assert_eq!(last.bodies.len(), 3);
        assert_eq!(<[f64; 3]>::from(last.bodies[0].position), [0.25, -1.5, 8.0]);
        assert_eq!(<[f64; 4]>::from(last.bodies[0].attitude.coords), [0.5, -0.5, 0.5, 0.5]);
        let tracked: Vec<bool> = last.bodies.iter().map(|body| body.tracked).collect();
        assert_eq!(tracked, [true, false, true]);
    }
}
