//! Model definitions: which number has which name.
//!
//! A count, then entries: `i32` kind, from 4.1 `i32` length, content. Before 4.1 entries have no length, so every kind must be read
//! to get past it.

use super::message::{Version, kind, message};
use crate::bytes::{Malformed, Reader, put_text};

/// A rigid body's definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Model {
    /// The streaming ID.
    pub number: i32,
    /// The name.
    pub name: String,
}

/// Kinds of entries: `DataDescriptors`.
mod descriptor {
    pub const MARKER_SET: u32 = 0;
    pub const RIGID_BODY: u32 = 1;
    pub const SKELETON: u32 = 2;
    pub const FORCE_PLATE: u32 = 3;
    pub const DEVICE: u32 = 4;
    pub const CAMERA: u32 = 5;
}

/// The rigid bodies of a payload.
///
/// # Errors
/// A payload that is not laid out as `version` says; before 4.1 also an entry of a kind that is not known.
pub fn decode(payload: &[u8], version: Version) -> Result<Vec<Model>, Malformed> {
    let mut reader = Reader::new(payload);
    let entries = reader.count_le(4)?;
    let mut models = Vec::new();
    for _ in 0..entries {
        let kind = reader.u32_le()?;
        if version.has_lengths() {
            let length = reader.count_le(1)?;
            let mut content = reader.section(length)?;
            if kind == descriptor::RIGID_BODY {
                models.push(rigid_body(&mut content, version)?);
            }
        } else {
            match kind {
                descriptor::RIGID_BODY => models.push(rigid_body(&mut reader, version)?),
                other => pass(&mut reader, other, version)?,
            }
        }
    }
    Ok(models)
}

fn rigid_body(reader: &mut Reader<'_>, version: Version) -> Result<Model, Malformed> {
    let name = reader.text()?;
    let number = reader.i32_le()?;
    // The parent, and the offset from it: a rigid body of its own has none.
    reader.take(4 + 12)?;
    if version >= Version::V4_2 {
        reader.take(16)?;
    }
    let markers = reader.count_le(16)?;
    reader.take(markers * 16)?;
    if version >= Version::V4_0 {
        (0..markers).try_for_each(|_| reader.text().map(drop))?;
    }
    Ok(Model { number, name })
}

/// Gets past an entry without a length.
fn pass(reader: &mut Reader<'_>, kind: u32, version: Version) -> Result<(), Malformed> {
    match kind {
        descriptor::MARKER_SET => {
            reader.text()?;
            texts(reader)
        }
        descriptor::SKELETON => {
            reader.text()?;
            reader.i32_le()?;
            let bones = reader.count_le(25)?;
            (0..bones).try_for_each(|_| rigid_body(reader, version).map(drop))
        }
        descriptor::FORCE_PLATE => {
            reader.i32_le()?;
            reader.text()?;
            // Width, length, origin, 12 × 12 calibration, 4 corners, kind, kind of channels.
            reader.take(4 * (2 + 3 + 144 + 12 + 2))?;
            texts(reader)
        }
        descriptor::DEVICE => {
            reader.i32_le()?;
            reader.text()?;
            reader.text()?;
            reader.take(8)?;
            texts(reader)
        }
        descriptor::CAMERA => {
            reader.text()?;
            reader.take(4 * 7).map(drop)
        }
        _ => Err(reader.malformed("a definition of a kind that is not known")),
    }
}

/// Skips a count and that many texts.
fn texts(reader: &mut Reader<'_>) -> Result<(), Malformed> {
    let count = reader.count_le(1)?;
    (0..count).try_for_each(|_| reader.text().map(drop))
}

/// As a message: rigid bodies without markers and without a parent.
pub fn encode(models: &[Model], version: Version) -> Vec<u8> {
    message(kind::MODEL_DEF, |out| {
        out.extend(u32::try_from(models.len()).unwrap_or_default().to_le_bytes());
        for model in models {
            let mut content = Vec::new();
            put_text(&mut content, &model.name);
            content.extend(model.number.to_le_bytes());
            content.extend((-1_i32).to_le_bytes());
            content.extend([0; 12]);
            if version >= Version::V4_2 {
                [0.0_f32, 0.0, 0.0, 1.0].iter().for_each(|number| content.extend(number.to_le_bytes()));
            }
            content.extend([0; 4]);
            out.extend(descriptor::RIGID_BODY.to_le_bytes());
            if version.has_lengths() {
                out.extend(u32::try_from(content.len()).unwrap_or_default().to_le_bytes());
            }
            out.extend(content);
        }
    })
}
