//! Keys and datagrams against values that another implementation computed: Python's `hmac`, `hashlib` and `zlib`, and
//! `ChaCha20Poly1305` of its `cryptography` package. What it takes to speak to a module, whole:
//!
//! ```python
//! H = lambda key, data: hmac.new(key, data, hashlib.sha256).digest()
//! def expand(prk, info, length):                                   # RFC 5869, §2.3
//!     out, t, i = b"", b"", 1
//!     while len(out) < length:
//!         t = H(prk, t + info + bytes([i])); out += t; i += 1
//!     return out[:length]
//!
//! prk = H(b"flotilla wire 2", bytes(range(32)))                    # salt, fleet key
//! fleet = expand(prk, b"fleet", 4)
//! module_key = expand(prk, b"module" + struct.pack("<H", 3), 32)   # module 3
//! boot, host = bytes(range(0xa0, 0xb0)), bytes(range(0xc0, 0xd0))  # nonces
//! announce = expand(module_key, b"announce" + boot, 32)
//! session = expand(module_key, b"session" + boot + host, 68)
//! to_module, to_host = session[:32], session[32:64]
//! number, = struct.unpack("<I", session[64:])
//!
//! def datagram(key, kind, session, sequence, plain, nonce=b""):
//!     head = bytes([2, kind]) + fleet + struct.pack("<HII", 3, session, sequence) + nonce
//!     body = head + ChaCha20Poly1305(key).encrypt(struct.pack("<III", session, kind, sequence), plain, head)
//!     return body + struct.pack("<I", zlib.crc32(body))
//!
//! # plain: postcard of the receipt (seen, accepted, late), then of the message: its variant, then its fields
//! datagram(announce, 1, 0, 0, bytes([0, 0, 0,  0, 0, 0, 2, 0, 0]), boot)
//! datagram(to_module, 2, number, 0, bytes([0, 0, 0,  9]), host)
//! datagram(to_module, 3, number, 1, bytes([0, 0, 0,  6]))
//! datagram(to_host, 4, number, 0, bytes([1, 1, 0,  1, 0xc1, 0x84, 0x3d]))
//! ```

use crate::common::{BOOT, HOST, MODULE, fleet_key, messages, open, pair, remade, seal};
use chacha20poly1305::aead::{AeadInOut, KeyInit};
use hkdf::Hkdf;
use protocol::*;
use sha2::Sha256;

const FLEET: [u8; 4] = [0xd4, 0x0f, 0x4d, 0x38];
const MODULE_KEY: &str = "e0e10faa2e7b5b47855459229cb14e510be68fcac26b2bd2ce979a1f154eb462";
const SESSION: u32 = 0xcfbe_39d1;
const ANNOUNCE: &str = "0201d40f4d3803000000000000000000a0a1a2a3a4a5a6a7a8a9aaabacadaeafd2872f09630f361b7d899467603e6a\
    e3af5403697b75c6e537813c87cd";
const CALL: &str = "0202d40f4d380300d139becf00000000c0c1c2c3c4c5c6c7c8c9cacbcccdcecf58a2d9398f7d2ed1887e74f05839d404d6\
    2c20d857fa5c78";
const HOLD: &str = "0203d40f4d380300d139becf010000002038aa720df55d4d08017c2e58a4806ec893cd38e2bb4475";
const TIME_REQUEST: &str =
    "0204d40f4d380300d139becf00000000a3753384b645d72dea0d365be2bb1b64e82aed2458750926789bf3";

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn keys_are_derived_as_elsewhere() {
    let key = fleet_key();
    assert_eq!(key.fleet(), FleetId(FLEET));
    assert_eq!(key.fleet().to_string(), "d40f4d38");
    assert_eq!(hex(key.module(MODULE).bytes()), MODULE_KEY);
    let (host, module) = pair();
    assert_eq!([host.id(), module.id()], [SESSION; 2]);
}

#[test]
fn datagrams_are_sealed_as_elsewhere() {
    let (key, mut buffer) = (fleet_key(), [0; MAX_DATAGRAM]);
    let hello = Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: (0, 2, 0), session: 0 });
    let mut announcer = Announcer::new(key.fleet(), MODULE, &key.module(MODULE), BOOT);
    assert_eq!(hex(announcer.seal(&hello, &mut buffer).expect("fits")), ANNOUNCE);
    let (mut host, mut module) = pair();
    let call = host.seal_call(&mut buffer).expect("fits").to_vec();
    assert_eq!(hex(&call), CALL);
    assert_eq!(open(&mut module, &call).map(|opened| opened.message), Ok(Message::Called));
    assert_eq!(hex(&seal(&mut host, &Message::Hold)), HOLD);
    let request = Message::TimeRequest(TimeRequest { sent: time::LocalInstant(1_000_001) });
    assert_eq!(hex(&seal(&mut module, &request)), TIME_REQUEST);
}

/// A second host, written from the documentation alone, and every message of a session.
#[test]
fn what_is_opened_by_hand_is_what_was_sealed() {
    let key = fleet_key();
    let (mut host, mut module) = pair();
    let mut derived = [0; 68];
    let hkdf = Hkdf::<Sha256>::from_prk(key.module(MODULE).bytes()).expect("32 bytes");
    hkdf.expand_multi_info(&[b"session", &BOOT.0, &HOST.0], &mut derived).expect("short enough");
    for (name, side, message) in messages() {
        let (sealed, direction, kind) = match side {
            Side::Host => (seal(&mut host, &message), &derived[..32], 3),
            Side::Module => (seal(&mut module, &message), &derived[32..64], 4),
        };
        assert_eq!(sealed, remade(&sealed), "{name}");
        let (head, rest) = sealed.split_at(16);
        let mut plain = rest[..rest.len() - 20].to_vec();
        let tag: [u8; 16] = rest[rest.len() - 20..rest.len() - 4].try_into().expect("sixteen bytes");
        let nonce: [u8; 12] =
            [&head[8..12], &[kind, 0, 0, 0], &head[12..16]].concat().try_into().expect("twelve bytes");
        let direction: [u8; 32] = direction.try_into().expect("32 bytes");
        let cipher = chacha20poly1305::ChaCha20Poly1305::new(&direction.into());
        let opened =
            cipher.decrypt_inout_detached(&nonce.into(), head, plain.as_mut_slice().into(), &tag.into());
        assert!(opened.is_ok(), "{name}");
        // A law of time other than constant speed is written behind the message.
        let (mut bare, mut law) = (message, Vec::new());
        if let Message::Cycle(Cycle { motion: Motion::Modboat(cycle), .. }) = &mut bare
            && let TransitionLaw::RestToRest { ramp } = std::mem::take(&mut cycle.law)
        {
            let low = |k: u32| (ramp.0 >> (7 * k) & 0x7F) as u8;
            // The law's number, and the ramp in groups of seven bits.
            law = vec![1, low(0) | 0x80, low(1) | 0x80, low(2)];
        }
        // So are connectors that are open.
        if let Message::Cycle(Cycle { motion: Motion::Rov(cycle), .. }) = &mut bare
            && std::mem::take(&mut cycle.connectors) == Connectors::Open
        {
            law = vec![2];
        }
        assert_eq!(postcard::take_from_bytes(&plain[3..]), Ok((bare, law.as_slice())), "{name}");
    }
}

#[test]
fn hkdf_is_that_of_rfc_5869_a_1() {
    let mut derived = [0; 42];
    let salt: Vec<u8> = (0..13).collect();
    let info: Vec<u8> = (0xF0..0xFA).collect();
    Hkdf::<Sha256>::new(Some(&salt), &[0x0B; 22]).expand(&info, &mut derived).expect("short enough");
    let expected = "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf34007208d5b887185865";
    assert_eq!(hex(&derived), expected);
}

#[test]
fn the_seal_is_that_of_rfc_8439_2_8_2() {
    let mut text = *b"Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the \
        future, sunscreen would be it.";
    let mut key = [0; 32];
    key.iter_mut().zip(0x80..).for_each(|(byte, k)| *byte = k);
    let nonce = [7, 0, 0, 0, 0x40, 0x41, 0x42, 0x43, 0x44, 0x45, 0x46, 0x47];
    let clear = [0x50, 0x51, 0x52, 0x53, 0xC0, 0xC1, 0xC2, 0xC3, 0xC4, 0xC5, 0xC6, 0xC7];
    let cipher = chacha20poly1305::ChaCha20Poly1305::new(&key.into());
    let tag =
        cipher.encrypt_inout_detached(&nonce.into(), &clear, text.as_mut_slice().into()).expect("short");
    assert_eq!(hex(&text[..16]), "d31a8d34648e60db7b86afbc53ef7ec2");
    assert_eq!(hex(&tag), "1ae10b594f09e26a7e902ecbd0600691");
}
