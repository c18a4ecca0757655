//! The image of a configuration, bare or as UF2.

use images::uf2::{self, Family, PAYLOAD, Uf2Error};
use protocol::configuration::IMAGE_MAX;
use protocol::{Configuration, ConfigurationError};
use thiserror::Error;
use zeroize::Zeroizing;

use super::memory::CONFIGURATION;

/// How an image is kept in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// As UF2, for the board's drive.
    Uf2,
    /// As it is in flash, for a probe or the emulator.
    Bin,
}

impl Format {
    /// The end of such a file's name.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Uf2 => "uf2",
            Self::Bin => "bin",
        }
    }
}

/// Why a file holds no configuration.
#[derive(Debug, Error)]
pub enum ImageError {
    /// It begins as UF2, and is none.
    #[error("is no UF2 file: {0}")]
    Uf2(#[from] Uf2Error),
    /// A program, or for another chip.
    #[error("is for {0}: a configuration is for {absolute}", absolute = Family::ABSOLUTE)]
    Family(Family),
    /// It would be written where no board looks.
    #[error("block {block} is for {address:#010x}: a configuration is in one piece from {origin:#010x} on", origin = CONFIGURATION.origin)]
    Address {
        /// Which block, from 1.
        block: usize,
        /// Where it would go.
        address: u32,
    },
    /// What is there is not valid.
    #[error("{called}: {0}", called = name(.0))]
    Configuration(#[from] ConfigurationError),
}

/// What an error is called.
const fn name(error: &ConfigurationError) -> &'static str {
    match error {
        ConfigurationError::Short { .. } => "cut short",
        ConfigurationError::Magic(_) => "no configuration",
        ConfigurationError::Format(_) => "wrong version",
        ConfigurationError::Length(_) => "wrong length",
        ConfigurationError::Checksum { .. } => "wrong checksum",
        ConfigurationError::Content => "wrong content",
        ConfigurationError::Trailing(_) => "too long",
        ConfigurationError::Module(_) => "id out of range",
        ConfigurationError::Passphrase(_) => "wrong passphrase",
        ConfigurationError::Port(_) => "wrong port",
        ConfigurationError::Prefix(_) => "wrong prefix",
        ConfigurationError::Constant { .. } => "wrong constant",
        ConfigurationError::BufferTooSmall { .. } => "too large",
    }
}

/// The bytes of a file.
///
/// # Errors
/// [`ImageError::Configuration`] where [`Configuration::write`] refuses it.
pub fn encode(configuration: &Configuration, format: Format) -> Result<Zeroizing<Vec<u8>>, ImageError> {
    let mut buffer = Zeroizing::new([0; IMAGE_MAX]);
    let image = configuration.write(&mut *buffer)?;
    let file = match format {
        Format::Bin => image.to_vec(),
        Format::Uf2 => {
            let at = |page: usize| CONFIGURATION.origin + (page * PAYLOAD) as u32;
            uf2::write(
                Family::ABSOLUTE,
                image.chunks(PAYLOAD).enumerate().map(|(page, bytes)| (at(page), bytes)),
            )?
        }
    };
    Ok(Zeroizing::new(file))
}

/// What a file holds, in either format.
///
/// # Errors
/// [`ImageError`].
pub fn decode(file: &[u8]) -> Result<(Configuration, Format), ImageError> {
    if !uf2::is_uf2(file) {
        return Ok((Configuration::read(file)?, Format::Bin));
    }
    let (family, blocks) = uf2::read(file)?;
    if family != Family::ABSOLUTE {
        return Err(ImageError::Family(family));
    }
    let mut image = Zeroizing::new(Vec::with_capacity(blocks.len() * PAYLOAD));
    let addresses = (CONFIGURATION.origin..).step_by(PAYLOAD);
    for ((number, block), expected) in (1..).zip(&blocks).zip(addresses) {
        if block.address != expected {
            return Err(ImageError::Address { block: number, address: block.address });
        }
        image.extend_from_slice(block.payload);
    }
    Ok((Configuration::read(&image)?, Format::Uf2))
}
