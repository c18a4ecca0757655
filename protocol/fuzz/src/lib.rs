//! Checks on every input, shared by the fuzz targets and the plain tests of `protocol/tests/all/fuzzing.rs`.
//!
//! Seals by itself, after the documentation, so that bytes which are no message at all can stand under a right tag.

use chacha20poly1305::ChaCha20Poly1305;
use chacha20poly1305::aead::{AeadInOut, KeyInit};
use hkdf::Hkdf;
use protocol::frame::{CHECKSUM, HEADER, NONCE, OVERHEAD, TAG};
use protocol::ledger::Class;
use protocol::session::{Opened, open_announcement, seal_stop};
use protocol::{
    Announcer, FleetKey, Frame, Header, Kind, MAX_DATAGRAM, Message, ModuleId, ModuleKey, Nonce, Session,
    Side, WIRE_VERSION,
};
use sha2::Sha256;

const MODULE: ModuleId = ModuleId(3);
const BOOT: Nonce = Nonce([0xA5; NONCE]);
const HOST: Nonce = Nonce([0x5A; NONCE]);

/// Every way in, for any bytes: as a datagram, under a right checksum, as the rest of a right header, and as what a right
/// tag covers. Nothing panics; no way but the last leads anywhere; and what leads somewhere says the same again.
pub fn decode(bytes: &[u8]) {
    let key = FleetKey::new([0x42; 32]);
    let ends = Ends { key: key.module(MODULE), fleet: key };
    // Only the corpus knows the key.
    ends.round_trip(bytes);
    let body = &bytes[..bytes.len().min(MAX_DATAGRAM - CHECKSUM)];
    ends.round_trip(&guarded(body.to_vec()));
    for kind in [Kind::Announce, Kind::Call, Kind::ToModule, Kind::ToHost, Kind::Stop] {
        let header = ends.header(kind, 0);
        let room = MAX_DATAGRAM - CHECKSUM - header.len();
        let unsealed = guarded([&header, &bytes[..bytes.len().min(room)]].concat());
        assert!(
            matches!(ends.open(&unsealed), Err(Class::Forged | Class::Corrupt)),
            "accepted without a tag"
        );
        ends.sealed(kind, bytes);
    }
}

struct Ends {
    fleet: FleetKey,
    key: ModuleKey,
}

impl Ends {
    fn session(&self, side: Side) -> Session {
        Session::new(side, self.fleet.fleet(), MODULE, &self.key, &BOOT, HOST)
    }

    fn announcer(&self, boot: Nonce) -> Announcer {
        Announcer::new(self.fleet.fleet(), MODULE, &self.key, boot)
    }

    /// Opened by its receiver.
    fn open(&self, datagram: &[u8]) -> Result<Opened, Class> {
        let frame = Frame::parse(datagram).map_err(|_| Class::Corrupt)?;
        match frame.header.kind {
            Kind::Announce => {
                let sequence = frame.header.sequence;
                open_announcement(&self.key, &frame).map(|message| Opened {
                    message,
                    overtaken: false,
                    sequence,
                    seen: 0,
                })
            }
            Kind::Stop => self.announcer(BOOT).open_stop(&frame).map(|()| Opened {
                message: Message::EmergencyStop,
                overtaken: false,
                sequence: 0,
                seen: 0,
            }),
            Kind::ToHost => self.session(Side::Host).open(&frame),
            Kind::Call | Kind::ToModule => self.session(Side::Module).open(&frame),
        }
    }

    /// What was opened must seal again to something that opens to the same.
    fn round_trip(&self, datagram: &[u8]) {
        let Ok(opened) = self.open(datagram) else { return };
        let mut buffer = [0; MAX_DATAGRAM];
        let header = Frame::parse(datagram).expect("it was opened").header;
        let again = self.seal_again(&header, &opened.message, &mut buffer);
        let message = self.open(again).expect("sealed just now").message;
        // NaN is not equal to itself: compare the text.
        assert_eq!(format!("{message:?}"), format!("{:?}", opened.message));
    }

    fn seal_again<'a>(&self, header: &Header, message: &Message, buffer: &'a mut [u8]) -> &'a [u8] {
        let sealed = match header.kind {
            Kind::Announce => {
                let boot = header.nonce.expect("announcements have one");
                self.announcer(boot).seal(message, buffer)
            }
            Kind::Stop => seal_stop(self.fleet.fleet(), MODULE, &self.key, BOOT, buffer),
            Kind::Call | Kind::ToModule => self.session(Side::Host).seal(message, buffer),
            Kind::ToHost => self.session(Side::Module).seal(message, buffer),
        };
        sealed.expect("what was read fits")
    }

    fn header(&self, kind: Kind, sequence: u32) -> Vec<u8> {
        let (session, nonce): (u32, &[u8]) = match kind {
            Kind::Announce | Kind::Stop => (0, &BOOT.0),
            Kind::Call => (self.session(Side::Host).id(), &HOST.0),
            Kind::ToModule | Kind::ToHost => (self.session(Side::Host).id(), &[]),
        };
        let mut header = vec![WIRE_VERSION, kind as u8];
        header.extend(self.fleet.fleet().0);
        header.extend(MODULE.0.to_le_bytes());
        header.extend(session.to_le_bytes());
        header.extend(sequence.to_le_bytes());
        assert_eq!(header.len(), HEADER);
        header.extend(nonce);
        header
    }

    /// The bytes under a right tag: a message or corrupt, never forged.
    fn sealed(&self, kind: Kind, bytes: &[u8]) {
        let header = self.header(kind, 0);
        let room = MAX_DATAGRAM - OVERHEAD - (header.len() - HEADER);
        let mut plain = bytes[..bytes.len().min(room)].to_vec();
        let mut derived = [0; 68];
        let expand = |info: &[&[u8]], output: &mut [u8]| {
            let hkdf = Hkdf::<Sha256>::from_prk(self.key.bytes()).expect("32 bytes");
            hkdf.expand_multi_info(info, output).expect("short enough");
        };
        match kind {
            Kind::Announce | Kind::Stop => expand(&[b"announce", &BOOT.0], &mut derived[..32]),
            _ => expand(&[b"session", &BOOT.0, &HOST.0], &mut derived),
        }
        let half = if kind == Kind::ToHost { &derived[32..64] } else { &derived[..32] };
        let key: [u8; 32] = half.try_into().expect("32 bytes");
        let mut nonce = [0; 12];
        nonce[..4].copy_from_slice(&header[8..12]);
        nonce[4] = kind as u8;
        let tag = ChaCha20Poly1305::new(&key.into())
            .encrypt_inout_detached(&nonce.into(), &header, plain.as_mut_slice().into())
            .expect("short enough");
        assert_eq!(tag.len(), TAG);
        let datagram = guarded([header.as_slice(), &plain, &tag].concat());
        match self.open(&datagram) {
            Ok(_) => self.round_trip(&datagram),
            Err(class) => assert_eq!(class, Class::Corrupt, "sealed with the right key"),
        }
    }
}

/// With the checksum behind it.
fn guarded(mut body: Vec<u8>) -> Vec<u8> {
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&body);
    body.extend(checksum.to_le_bytes());
    body
}
