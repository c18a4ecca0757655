//! `cargo +nightly fuzz run decode`, from `protocol/`: bytes as a datagram, and as the body of a well-dressed one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use protocol::{DecodeError, MAX_DATAGRAM, Seal, WIRE_VERSION, decode, encode};

fn round_trip(datagram: &[u8]) {
    if let Ok((header, message)) = decode(datagram) {
        let mut buffer = [0; MAX_DATAGRAM];
        let again = encode(&header, &message, &mut buffer).expect("what was read fits");
        assert_eq!(format!("{:?}", decode(again)), format!("{:?}", Ok::<_, DecodeError>((header, message))));
    }
}

fuzz_target!(|body: &[u8]| {
    round_trip(body);
    let mut datagram = vec![WIRE_VERSION, Seal::Checksum as u8];
    datagram.extend_from_slice(body);
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&datagram);
    datagram.extend_from_slice(&checksum.to_le_bytes());
    round_trip(&datagram);
});
