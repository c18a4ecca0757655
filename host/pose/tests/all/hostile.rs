//! Bytes that no honest server sends: codecs and sessions give errors, never a panic, and never set memory aside for a count that the
//! message cannot hold.

use pose::natnet::frames::{self, FrameOfData, RigidBody};
use pose::natnet::message::{ServerInfo, Version};
use pose::natnet::models::{self, Model};
use pose::natnet::session::Session;
use pose::qtm::data::{self, Component, Data, SixD};
use pose::qtm::packet::{self, Packet};
use pose::qtm::{self, parameters};
use pose::source::Status;
use pose::time::{HostInstant, ServerInstant};
use pose::vrpn::message::{self, Message, Pose};
use pose::vrpn::session::Session as VrpnSession;
use proptest::prelude::*;

/// A datagram with some of its bytes changed and its end cut.
pub fn spoiled(genuine: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let length = genuine.len();
    (prop::collection::vec((0..length, any::<u8>()), 1..6), 0..=length).prop_map(move |(changes, end)| {
        let mut bytes = genuine.clone();
        changes.iter().for_each(|&(at, byte)| bytes[at] = byte);
        bytes.truncate(end);
        bytes
    })
}

fn natnet_version() -> impl Strategy<Value = Version> {
    prop::sample::select(vec![Version::V3_0, Version::V3_1, Version::V4_0, Version::V4_1, Version::V4_2])
}

fn body() -> impl Strategy<Value = RigidBody> {
    (any::<i32>(), prop::array::uniform8(any::<f32>()), any::<bool>()).prop_map(|(number, n, tracked)| {
        let n = n.map(f64::from);
        RigidBody {
            number,
            position: [n[0], n[1], n[2]].into(),
            attitude: [n[3], n[4], n[5], n[6]].into(),
            error: n[7],
            tracked,
        }
    })
}

fn frame() -> impl Strategy<Value = FrameOfData> {
    (any::<u32>(), prop::collection::vec(body(), 0..5), any::<f64>(), any::<u64>(), any::<bool>()).prop_map(
        |(number, bodies, timestamp_s, ticks, models_changed)| FrameOfData {
            number,
            bodies,
            timestamp_s,
            mid_exposure: ticks,
            transmitted: ticks,
            models_changed,
        },
    )
}

fn model() -> impl Strategy<Value = Model> {
    (any::<i32>(), "[^\0]{0,12}").prop_map(|(number, name)| Model { number, name })
}

/// Everything that takes a payload or a datagram of NatNet takes these bytes.
fn natnet_takes(bytes: &[u8], version: Version) {
    let _ = frames::decode(bytes, version);
    let _ = models::decode(bytes, version);
    let _ = ServerInfo::decode(bytes);
    let info = ServerInfo {
        application: String::new(),
        application_version: [0; 4],
        version,
        clock_hz: 1,
        data_port: 0,
        group: None,
    };
    let mut session = Session::default();
    let now = HostInstant::default();
    session.handle_datagram(now, &info.encode()).expect("a version that is read");
    let _ = session.handle_datagram(now, bytes);
    session.handle_timer(now);
}

fn six_d() -> impl Strategy<Value = SixD> {
    (prop::array::uniform3(-1e5_f32..1e5), prop::array::uniform4(-1.0..1.0_f64), any::<bool>())
        .prop_filter("a turn", |(_, q, _)| q.iter().map(|q| q * q).sum::<f64>() > 0.01)
        .prop_map(|(position, q, tracked)| SixD {
            position: position.map(f64::from).into(),
            attitude: nalgebra::UnitQuaternion::from_quaternion(q.into()).into_inner(),
            residual: Some(0.5),
            tracked,
        })
}

fn data() -> impl Strategy<Value = Data> {
    (any::<u64>(), any::<u32>(), prop::collection::vec(six_d(), 0..5))
        .prop_map(|(timestamp_us, number, bodies)| Data { timestamp_us, number, bodies: Some(bodies) })
}

/// A session takes every packet of a stream, at every stage.
fn qtm_takes(bytes: &[u8]) {
    let _ = data::decode(bytes);
    let text = String::from_utf8_lossy(bytes).into_owned();
    let _ = parameters::bodies(&text);
    let now = HostInstant::default();
    let mut status = Status::default();
    let mut session = qtm::session::Session::new(now, None);
    let mut stream = bytes.to_vec();
    let greeting =
        ["QTM RT Interface connected", "Version set to 1.25"].map(|text| Packet::Command(text.into()));
    let known = greeting.into_iter().chain([Packet::Xml(text), Packet::Data(bytes.to_vec())]);
    for packet in known {
        let _ = session.handle_packet(now, packet, &mut status);
        session.handle_timer(now, &mut status);
    }
    while let Ok(Some(packet)) = packet::take(&mut stream) {
        let _ = session.handle_packet(now, packet, &mut status);
    }
}

proptest! {
    #[test]
    fn qtm_takes_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        qtm_takes(&bytes);
        for kind in 0..9 {
            let size = u32::try_from(bytes.len() + 8).expect("short").to_le_bytes();
            qtm_takes(&[&size[..], &[kind, 0, 0, 0], bytes.as_slice()].concat());
        }
    }

    #[test]
    fn qtm_takes_spoiled_packets(
        bytes in data().prop_flat_map(|data| {
            spoiled(Packet::Data(data::encode(&data, &[Component::Matrix, Component::MatrixResidual])).encode())
        }),
    ) {
        qtm_takes(&bytes);
        qtm_takes(bytes.get(8..).unwrap_or_default());
    }

    #[test]
    fn qtm_takes_spoiled_settings(
        bytes in prop::collection::vec("[^\0]{0,12}", 0..4)
            .prop_flat_map(|names| spoiled(parameters::write(25, &names).into_bytes())),
    ) {
        qtm_takes(&bytes);
    }

    #[test]
    fn qtm_frames_survive_the_wire(data in data()) {
        let read = data::decode(&data::encode(&data, &[Component::MatrixResidual])).expect("its own packet");
        prop_assert_eq!((read.timestamp_us, read.number), (data.timestamp_us, data.number));
        for (read, sent) in read.bodies.unwrap_or_default().iter().zip(data.bodies.unwrap_or_default()) {
            prop_assert_eq!(read.tracked, sent.tracked);
            if sent.tracked {
                prop_assert_eq!(read.position, sent.position);
                let same = read.attitude.dot(&sent.attitude).abs();
                prop_assert!((same - 1.0).abs() < 1e-6, "{} for {}", read.attitude, sent.attitude);
            }
        }
    }
}

proptest! {
    #[test]
    fn natnet_takes_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..600), version in natnet_version()) {
        natnet_takes(&bytes, version);
        for kind in 0..15 {
            natnet_takes(&[&[kind, 0, 0, 0], bytes.as_slice()].concat(), version);
        }
    }

    #[test]
    fn natnet_takes_spoiled_frames(
        (version, bytes) in (natnet_version(), frame())
            .prop_flat_map(|(version, frame)| (Just(version), spoiled(frames::encode(&frame, version)))),
    ) {
        natnet_takes(&bytes, version);
        natnet_takes(bytes.get(4..).unwrap_or_default(), version);
    }

    #[test]
    fn natnet_takes_spoiled_definitions(
        (version, bytes) in (natnet_version(), prop::collection::vec(model(), 0..5))
            .prop_flat_map(|(version, models)| (Just(version), spoiled(models::encode(&models, version)))),
    ) {
        natnet_takes(&bytes, version);
        natnet_takes(bytes.get(4..).unwrap_or_default(), version);
    }

    #[test]
    fn natnet_frames_survive_the_wire(frame in frame(), version in natnet_version()) {
        let decoded = frames::decode(&frames::encode(&frame, version)[4..], version).expect("its own frame");
        // NaN is not equal to itself; its text is.
        prop_assert_eq!(format!("{decoded:?}"), format!("{frame:?}"));
    }

    #[test]
    fn natnet_definitions_survive_the_wire(
        defined in prop::collection::vec(model(), 0..5),
        version in natnet_version(),
    ) {
        let decoded = models::decode(&models::encode(&defined, version)[4..], version);
        prop_assert_eq!(decoded, Ok(defined));
    }
}

/// A session takes a stream in pieces, after a genuine start.
fn vrpn_takes(bytes: &[u8]) {
    let _ = Pose::decode(bytes);
    let now = HostInstant::default();
    let mut status = Status::default();
    let mut session = VrpnSession::new(now, &[]);
    let start = [
        Message::description(message::SENDER_DESCRIPTION, 1, "boat 1"),
        Message::description(message::KIND_DESCRIPTION, 0, message::POSE),
    ];
    let genuine = message::cookie()
        .into_iter()
        .chain(start.iter().flat_map(Message::encode))
        .chain(bytes.iter().copied());
    let mut stream = Vec::new();
    for byte in genuine {
        stream.push(byte);
        if !session.handle_bytes(now, &mut stream, &mut status).is_ok_and(|followed| followed.is_ok()) {
            break;
        }
    }
    session.handle_timer(now.after(std::time::Duration::from_secs(1)), &mut status);
    while session.take_frame().is_some() {}
    let mut fresh = VrpnSession::new(now, &[]);
    let _ = fresh.handle_bytes(now, &mut bytes.to_vec(), &mut status);
}

fn vrpn_message() -> impl Strategy<Value = Message> {
    let pose = (any::<i32>(), prop::array::uniform7(any::<f64>())).prop_map(|(sensor, n)| {
        let [x, y, z, i, j, k, w] = n;
        Pose { sensor, position: [x, y, z].into(), attitude: [i, j, k, w].into() }.encode()
    });
    let payload = prop_oneof![pose, prop::collection::vec(any::<u8>(), 0..80)];
    (any::<u32>(), 0..1_000_000_i64, -3..3, -6..4, payload).prop_map(
        |(seconds, micros, sender, kind, payload)| {
            let time = ServerInstant(i64::from(seconds) * 1_000_000_000 + micros * 1000);
            Message { time, sender, kind, payload }
        },
    )
}

proptest! {
    #[test]
    fn vrpn_takes_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        vrpn_takes(&bytes);
    }

    #[test]
    fn vrpn_takes_spoiled_messages(
        bytes in prop::collection::vec(vrpn_message(), 1..6)
            .prop_flat_map(|messages| spoiled(messages.iter().flat_map(Message::encode).collect())),
    ) {
        vrpn_takes(&bytes);
    }

    #[test]
    fn vrpn_messages_survive_the_wire(messages in prop::collection::vec(vrpn_message(), 0..6)) {
        let mut stream: Vec<u8> = messages.iter().flat_map(Message::encode).collect();
        for sent in messages {
            prop_assert_eq!(message::take(&mut stream), Ok(Some(sent)));
        }
        prop_assert_eq!(message::take(&mut stream), Ok(None));
    }
}
