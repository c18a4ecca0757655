//! Fuzz input: bytes as a block of flash.

use protocol::Configuration;
use protocol::configuration::{FORMAT, IMAGE_MAX, MAGIC};

/// The bytes, and the bytes within a right head and checksum. What is read is written to what is read to the same.
pub fn run(bytes: &[u8]) {
    round_trip(bytes);
    let content = &bytes[..bytes.len().min(IMAGE_MAX - 12)];
    let mut image =
        [&MAGIC[..], &FORMAT.to_le_bytes(), &(content.len() as u16).to_le_bytes(), content].concat();
    image.extend(crc32(&image).to_le_bytes());
    round_trip(&image);
}

fn round_trip(block: &[u8]) {
    let Ok(configuration) = Configuration::read(block) else { return };
    let (mut first, mut second) = ([0; IMAGE_MAX], [0; IMAGE_MAX]);
    let image = configuration.write(&mut first).expect("what was read is valid");
    let again = Configuration::read(image).expect("written just now");
    assert_eq!(again.write(&mut second).expect("valid"), image);
    assert_eq!(format!("{again:?}"), format!("{configuration:?}"));
}

/// CRC-32, ISO-HDLC, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}
