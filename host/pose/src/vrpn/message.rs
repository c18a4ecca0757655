//! The cookie, messages and poses of trackers.

use nalgebra::{Quaternion, Vector3};

use crate::bytes::{Malformed, Reader, put_text};
use crate::time::ServerInstant;

/// The port of servers, TCP and UDP.
pub const PORT: u16 = 3883;
/// Length of the cookie, bytes.
pub const COOKIE_LENGTH: usize = 24;
/// Length of a message's header, bytes.
const HEADER: usize = 24;
/// What payloads are filled up to, bytes.
const ALIGNMENT: usize = 8;
/// The largest message that is taken, bytes: `vrpn_CONNECTION_TCP_BUFLEN`.
const LARGEST: usize = 64_000;
/// The versions that are read: all with this major number.
const MAGIC: &[u8] = b"vrpn: ver. 07.";

/// The kind of a sender's description.
pub const SENDER_DESCRIPTION: i32 = -1;
/// The kind of a kind's description.
pub const KIND_DESCRIPTION: i32 = -2;
/// The name of the kind of poses.
pub const POSE: &str = "vrpn_Tracker Pos_Quat";
/// The name of the kind that asks for a sign of life.
pub const PING: &str = "vrpn_Base ping_message";
/// The name of the kind that answers it.
pub const PONG: &str = "vrpn_Base pong_message";
/// The sender that every connection has for itself.
pub const CONTROL: &str = "VRPN Control";

/// The cookie of this end: a version whose minor number no peer minds, and no logging asked for.
pub fn cookie() -> [u8; COOKIE_LENGTH] {
    *b"vrpn: ver. 07.38  0\0\0\0\0\0"
}

/// Whether the other end's cookie names a version that is read.
pub fn is_read(cookie: &[u8]) -> bool {
    cookie.starts_with(MAGIC)
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// When it was made, on the sender's clock.
    pub time: ServerInstant,
    /// Who, by the number of the end that sent it.
    pub sender: i32,
    /// What, likewise; negative for what every end knows.
    pub kind: i32,
    /// The content.
    pub payload: Vec<u8>,
}

impl Message {
    /// A description: `sender` is the number that is described.
    pub fn description(kind: i32, number: i32, name: &str) -> Self {
        let mut payload = vec![0; 4];
        put_text(&mut payload, name);
        let length = u32::try_from(payload.len() - 4).unwrap_or_default();
        payload.splice(..4, length.to_be_bytes());
        Self { time: ServerInstant::default(), sender: number, kind, payload }
    }

    /// The name of a description.
    ///
    /// # Errors
    /// A payload that is too short.
    pub fn described(&self) -> Result<String, Malformed> {
        let mut reader = Reader::new(&self.payload);
        reader.u32_be()?;
        reader.text()
    }

    /// As bytes.
    pub fn encode(&self) -> Vec<u8> {
        let length = u32::try_from(HEADER + self.payload.len()).unwrap_or(u32::MAX);
        let micros = self.time.0.div_euclid(1000);
        // Seconds wrap in 2106, as VRPN's own do.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "as on the wire")]
        let [seconds, micros] = [micros.div_euclid(1_000_000) as u32, micros.rem_euclid(1_000_000) as u32];
        let mut out = Vec::with_capacity(HEADER + self.payload.len() + ALIGNMENT);
        [length, seconds, micros].iter().for_each(|number| out.extend(number.to_be_bytes()));
        [self.sender, self.kind, 0].iter().for_each(|number| out.extend(number.to_be_bytes()));
        out.extend(&self.payload);
        out.resize(out.len().next_multiple_of(ALIGNMENT), 0);
        out
    }
}

/// The first message of `stream`, which it is taken from; `None` until it is whole.
///
/// # Errors
/// A length that no message has: the stream cannot be followed any more.
pub fn take(stream: &mut Vec<u8>) -> Result<Option<Message>, Malformed> {
    let mut reader = Reader::new(stream);
    let Ok(length) = reader.u32_be() else { return Ok(None) };
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    if !(HEADER..=LARGEST).contains(&length) {
        return Err(Malformed { what: "a length that no message has", at: 0 });
    }
    let filled = length.next_multiple_of(ALIGNMENT);
    let Some(bytes) = stream.get(..filled) else { return Ok(None) };
    let mut reader = Reader::new(bytes);
    reader.take(4)?;
    let seconds = i64::from(reader.u32_be()?);
    let micros = i64::from(reader.u32_be()?);
    let time = ServerInstant(seconds * 1_000_000_000 + micros * 1000);
    let (sender, kind) = (reader.i32_be()?, reader.i32_be()?);
    reader.take(4)?;
    let payload = reader.take(length - HEADER)?.to_vec();
    stream.drain(..filled);
    Ok(Some(Message { time, sender, kind, payload }))
}

/// A pose of a tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Which of the tracker's sensors; the only one is 0.
    pub sensor: i32,
    /// Where, in the server's unit and axes.
    pub position: Vector3<f64>,
    /// How turned.
    pub attitude: Quaternion<f64>,
}

impl Pose {
    /// From a payload: `i32` sensor, 4 bytes to fill up, `3 f64` position, `4 f64` attitude (x, y, z, w).
    ///
    /// # Errors
    /// A payload that is too short.
    pub fn decode(payload: &[u8]) -> Result<Self, Malformed> {
        let mut reader = Reader::new(payload);
        let sensor = reader.i32_be()?;
        reader.take(4)?;
        let position = Vector3::new(reader.f64_be()?, reader.f64_be()?, reader.f64_be()?);
        let [i, j, k, w] = [reader.f64_be()?, reader.f64_be()?, reader.f64_be()?, reader.f64_be()?];
        Ok(Self { sensor, position, attitude: Quaternion::new(w, i, j, k) })
    }

    /// As a payload.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(64);
        // VRPN fills up with the sensor again.
        [self.sensor, self.sensor].iter().for_each(|number| out.extend(number.to_be_bytes()));
        // nalgebra keeps a quaternion as x, y, z, w too.
        let numbers = self.position.iter().chain(self.attitude.coords.iter());
        numbers.for_each(|number| out.extend(number.to_be_bytes()));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_a_message_of_88_bytes() {
        let pose = Pose {
            sensor: 3,
            position: Vector3::new(1.0, -2.0, 0.5),
            attitude: Quaternion::new(0.5, -0.5, 0.5, 0.5),
        };
        let time = ServerInstant(1_700_000_000_123_456_000);
        let message = Message { time, sender: 1, kind: 4, payload: pose.encode() };
        let mut bytes = message.encode();
        assert_eq!(bytes.len(), 88);
        assert_eq!(bytes[..4], 88_u32.to_be_bytes());
        assert_eq!(bytes[32..40], 1.0_f64.to_be_bytes());
        assert_eq!(bytes[80..88], 0.5_f64.to_be_bytes(), "w comes last");
        assert_eq!(take(&mut bytes), Ok(Some(message)));
        assert_eq!(Pose::decode(&pose.encode()), Ok(pose));
    }

    #[test]
    fn a_description_is_filled_up_and_its_length_is_not() {
        let message = Message::description(SENDER_DESCRIPTION, 2, "boat 1");
        let mut bytes = message.encode();
        assert_eq!(bytes[..4], 35_u32.to_be_bytes());
        assert_eq!(bytes.len(), 40);
        assert_eq!(bytes[24..36], *b"\0\0\0\x07boat 1\0\0");
        bytes.truncate(39);
        assert_eq!(take(&mut bytes), Ok(None));
        bytes.push(0);
        assert_eq!(take(&mut bytes).expect("whole").expect("whole").described().as_deref(), Ok("boat 1"));
    }

    #[test]
    fn cookies() {
        assert!(is_read(&cookie()));
        assert!(is_read(b"vrpn: ver. 07.30  0\0\0\0\0\0"));
        assert!(!is_read(b"vrpn: ver. 06.05  0\0\0\0\0\0"));
        assert!(!is_read(b"HTTP/1.1 400 Bad Request"));
    }
}
