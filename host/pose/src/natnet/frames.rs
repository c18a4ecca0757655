//! Frames of data: which bodies are where, in the order of the wire.
//!
//! | section | one entry |
//! |---|---|
//! | marker sets | name, count, positions |
//! | unlabelled markers | position |
//! | **rigid bodies** | `i32` number, `3 f32` position, `4 f32` attitude (x, y, z, w), `f32` mean error, `u16` flags (bit 0: tracked) |
//! | skeletons | number, count, rigid bodies |
//! | assets, from 4.1 | skipped by their length |
//! | labelled markers | 26 bytes |
//! | force plates, devices | number, channels with their values |
//! | end | `2 u32` timecode, `f64` time stamp, `3 u64` ticks (mid-exposure, received, transmitted), from 4.1 `2 u32` precision time, `u16` flags, `i32` 0 |
//!
//! Each section begins with its count, from 4.1 followed by its length in bytes.

use nalgebra::{Quaternion, Vector3};

use super::message::{Version, kind, message};
use crate::bytes::{Malformed, Reader};

/// Length of a position on the wire.
const POSITION: usize = 12;
/// Length of a rigid body on the wire.
const RIGID_BODY: usize = 38;
/// Length of a labelled marker on the wire.
const LABELLED_MARKER: usize = 26;
/// The flag of a body that was tracked.
const TRACKED: u16 = 1;
/// The flag of a frame after which the model definitions have changed.
const MODELS_CHANGED: u16 = 2;

/// A rigid body of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidBody {
    /// The streaming ID.
    pub number: i32,
    /// Where, in the server's unit and axes.
    pub position: Vector3<f64>,
    /// How turned.
    pub attitude: Quaternion<f64>,
    /// Mean error of its markers.
    pub error: f64,
    /// Whether it was seen.
    pub tracked: bool,
}

/// What is read of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameOfData {
    /// The server's count.
    pub number: u32,
    /// The rigid bodies.
    pub bodies: Vec<RigidBody>,
    /// The software's time stamp, s.
    pub timestamp_s: f64,
    /// Ticks of the server's clock at the middle of the exposure; zero where the frame comes from a recording.
    pub mid_exposure: u64,
    /// Ticks when the frame was sent.
    pub transmitted: u64,
    /// Whether the model definitions have changed.
    pub models_changed: bool,
}

/// From a payload.
///
/// # Errors
/// A payload that is not laid out as `version` says, to the last byte.
pub fn decode(payload: &[u8], version: Version) -> Result<FrameOfData, Malformed> {
    let mut reader = Reader::new(payload);
    let number = reader.u32_le()?;
    section(&mut reader, version, 5, |reader| {
        reader.text()?;
        skip(reader, POSITION)
    })?;
    section(&mut reader, version, POSITION, |reader| reader.take(POSITION).map(drop))?;
    let mut bodies = Vec::new();
    section(&mut reader, version, RIGID_BODY, |reader| {
        bodies.push(rigid_body(reader)?);
        Ok(())
    })?;
    section(&mut reader, version, 8, |reader| {
        reader.i32_le()?;
        skip(reader, RIGID_BODY)
    })?;
    if version.has_lengths() {
        reader.u32_le()?;
        let length = reader.count_le(1)?;
        reader.take(length)?;
    }
    section(&mut reader, version, LABELLED_MARKER, |reader| reader.take(LABELLED_MARKER).map(drop))?;
    for _force_plates_then_devices in 0..2 {
        section(&mut reader, version, 8, |reader| {
            reader.i32_le()?;
            let channels = reader.count_le(4)?;
            (0..channels).try_for_each(|_| skip(reader, 4))
        })?;
    }
    reader.take(8)?;
    let timestamp_s = reader.f64_le()?;
    let mid_exposure = reader.u64_le()?;
    reader.u64_le()?;
    let transmitted = reader.u64_le()?;
    if version.has_lengths() {
        reader.take(8)?;
    }
    let flags = reader.u16_le()?;
    reader.i32_le()?;
    if reader.left() > 0 {
        return Err(reader.malformed("bytes after the end of a frame"));
    }
    let models_changed = flags & MODELS_CHANGED != 0;
    Ok(FrameOfData { number, bodies, timestamp_s, mid_exposure, transmitted, models_changed })
}

/// A section's entries, each of at least `least` bytes. Where the section has a length, its entries must fill it.
fn section<'a>(
    reader: &mut Reader<'a>,
    version: Version,
    least: usize,
    mut entry: impl FnMut(&mut Reader<'a>) -> Result<(), Malformed>,
) -> Result<(), Malformed> {
    let count = reader.count_le(least)?;
    if !version.has_lengths() {
        return (0..count).try_for_each(|_| entry(reader));
    }
    let length = reader.count_le(1)?;
    let mut inside = reader.section(length)?;
    (0..count).try_for_each(|_| entry(&mut inside))?;
    if inside.left() > 0 {
        return Err(reader.malformed("a section shorter than its length"));
    }
    Ok(())
}

/// Skips a count and that many entries of `length` bytes.
fn skip(reader: &mut Reader<'_>, length: usize) -> Result<(), Malformed> {
    let count = reader.count_le(length)?;
    reader.take(count * length).map(drop)
}

fn rigid_body(reader: &mut Reader<'_>) -> Result<RigidBody, Malformed> {
    let number = reader.i32_le()?;
    let mut next = || reader.f32_le().map(f64::from);
    let position = Vector3::new(next()?, next()?, next()?);
    let (i, j, k, w) = (next()?, next()?, next()?, next()?);
    let error = next()?;
    let tracked = reader.u16_le()? & TRACKED != 0;
    Ok(RigidBody { number, position, attitude: Quaternion::new(w, i, j, k), error, tracked })
}

/// As a message, with rigid bodies alone; positions and attitudes are rounded to single precision.
#[expect(clippy::cast_possible_truncation, reason = "the wire is single precision")]
pub fn encode(frame: &FrameOfData, version: Version) -> Vec<u8> {
    let put_section = |out: &mut Vec<u8>, count: usize, content: &[u8]| {
        out.extend(u32::try_from(count).unwrap_or_default().to_le_bytes());
        if version.has_lengths() {
            out.extend(u32::try_from(content.len()).unwrap_or_default().to_le_bytes());
        }
        out.extend(content);
    };
    let mut bodies = Vec::with_capacity(frame.bodies.len() * RIGID_BODY);
    for body in &frame.bodies {
        bodies.extend(body.number.to_le_bytes());
        // nalgebra keeps a quaternion as x, y, z, w too.
        let numbers = body.position.iter().chain(body.attitude.coords.iter()).chain([&body.error]);
        numbers.for_each(|&number| bodies.extend((number as f32).to_le_bytes()));
        bodies.extend((u16::from(body.tracked) * TRACKED).to_le_bytes());
    }
    message(kind::FRAME_OF_DATA, |out| {
        out.extend(frame.number.to_le_bytes());
        put_section(out, 0, &[]);
        put_section(out, 0, &[]);
        put_section(out, frame.bodies.len(), &bodies);
        let rest = if version.has_lengths() { 5 } else { 4 };
        (0..rest).for_each(|_| put_section(out, 0, &[]));
        out.extend([0; 8]);
        out.extend(frame.timestamp_s.to_le_bytes());
        out.extend(frame.mid_exposure.to_le_bytes());
        // The simulated cameras hand over what they saw at once.
        out.extend(frame.mid_exposure.to_le_bytes());
        out.extend(frame.transmitted.to_le_bytes());
        if version.has_lengths() {
            out.extend([0; 8]);
        }
        out.extend((u16::from(frame.models_changed) * MODELS_CHANGED).to_le_bytes());
        out.extend([0; 4]);
    })
}
