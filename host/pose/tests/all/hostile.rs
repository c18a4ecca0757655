//! Bytes that no honest server sends: codecs and sessions give errors, never a panic, and never set memory aside for a count that the
//! message cannot hold.

use pose::natnet::frames::{self, FrameOfData, RigidBody};
use pose::natnet::message::{ServerInfo, Version};
use pose::natnet::models::{self, Model};
use pose::natnet::session::Session;
use pose::time::HostInstant;
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
