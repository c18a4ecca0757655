//! Errors of a configuration block.

use core::fmt;

use super::{FORMAT, IMAGE_MAX, MAGIC, MODULES_MAX};
use crate::message::ModuleId;

/// Why there is no configuration, with the value that is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigurationError {
    /// The block ends before the image does, bytes.
    Short {
        /// Length of the block.
        have: usize,
        /// Length of the image, or of its head.
        need: usize,
    },
    /// The block begins with something else: it was never written.
    Magic([u8; 4]),
    /// Another format.
    Format(u16),
    /// A length that no image has, bytes.
    Length(u16),
    /// The checksum does not match: damaged, or half written.
    Checksum {
        /// As stored.
        stored: u32,
        /// As it should be.
        computed: u32,
    },
    /// The checksum is right, but what it covers is no configuration.
    Content,
    /// So many bytes follow the configuration within the image.
    Trailing(usize),
    /// No number of a module.
    Module(ModuleId),
    /// A passphrase of so many bytes.
    Passphrase(usize),
    /// The host's port.
    Port(u16),
    /// Bits of the network's prefix.
    Prefix(u8),
    /// A constant that is not a number.
    Constant {
        /// Which.
        key: &'static str,
        /// What it is, in `unit`.
        value: f32,
        /// Its unit.
        unit: &'static str,
    },
    /// The buffer has fewer bytes than the image needs.
    BufferTooSmall {
        /// Length of the buffer, bytes.
        have: usize,
    },
}

impl fmt::Display for ConfigurationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short { have, need } => write!(f, "the block has {have} bytes and the image {need}"),
            Self::Magic(magic) => write!(f, "begins with {magic:02x?} instead of {MAGIC:02x?}"),
            Self::Format(format) => write!(f, "format {format}, this build reads {FORMAT}"),
            Self::Length(length) => {
                write!(f, "{length} bytes of content: an image has at most {IMAGE_MAX} in all")
            }
            Self::Checksum { stored, computed } => {
                write!(f, "checksum {stored:08x} where the bytes make {computed:08x}")
            }
            Self::Content => f.write_str("what the checksum covers is no configuration"),
            Self::Trailing(bytes) => write!(f, "{bytes} bytes follow the configuration"),
            Self::Module(module) => write!(f, "module {module}: numbers go from 1 to {MODULES_MAX}"),
            Self::Passphrase(bytes) => write!(f, "a passphrase of {bytes} bytes: 8 to 63, or none"),
            Self::Port(port) => write!(f, "port {port} of the host"),
            Self::Prefix(bits) => write!(f, "a prefix of {bits} bits: at most 32"),
            Self::Constant { key, value, unit } => {
                write!(f, "{key} = {value} {unit}: must be a finite number")
            }
            Self::BufferTooSmall { have } => write!(f, "{have} bytes are too few for the image"),
        }
    }
}

impl core::error::Error for ConfigurationError {}
