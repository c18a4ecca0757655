//! The configuration of a module: who it is, where its host is, and the constants of its hardware; one block of flash.
//!
//! ```text
//! "FLOT" 4 │ format 2 │ length 2 │ postcard of a Configuration … length │ CRC-32 4 │ anything
//! ```
//!
//! Integers are little endian; the checksum (CRC-32, ISO-HDLC) covers all before it. The order of the fields *is* the format:
//! append only, and bump [`FORMAT`] for anything else. `protocol/tests/wire/configuration/` holds the bytes.
//!
//! | what is wrong | what the module does |
//! |---|---|
//! | anything at all | it is unprovisioned: it moves nothing and says nothing |
//!
//! Assumptions and limits: only the module reads the block. A reader of it has the key of this module and the
//! passphrase of the network, and no other module's key. Both are wiped when dropped and never shown. Whether a constant makes
//! sense is checked by what it is for; here only that each is a number.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use zeroize::Zeroize;

use crate::frame::{self, CHECKSUM};
use crate::keys::{FleetId, ModuleKey};
use crate::message::{ModuleId, ModuleKind};
use crate::time::Duration;

mod constants;
mod error;
mod network;

pub use constants::{
    BankConstants, BatteryLimits, EncoderConstants, EncoderMounting, EscConstants, LeaseLimits, Robot,
    RovConstants, ServoConstants, SupplyConstants, TailConstants, TailLimits, ThrusterMounting,
};
pub use error::ConfigurationError;
pub use network::{Host, Network, Own, PASSPHRASE_MAX, Passphrase, SSID_MAX};

/// First bytes of the block.
pub const MAGIC: [u8; 4] = *b"FLOT";
/// The format that this build writes, and the only one it reads.
pub const FORMAT: u16 = 3;
/// Longest image, bytes.
pub const IMAGE_MAX: usize = 1024;
/// Modules of one fleet have numbers from 1 to this.
pub const MODULES_MAX: u16 = 1024;

/// Bytes before the postcard.
const HEAD: usize = 8;

/// The configuration of one module: identity, network and hardware constants.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Configuration {
    /// Its number in the fleet.
    pub module: ModuleId,
    /// Its fleet.
    pub fleet: FleetId,
    /// Its key.
    #[serde(serialize_with = "write_key", deserialize_with = "read_key")]
    pub key: ModuleKey,
    /// How it reaches its host.
    pub network: Network,
    /// Pause between two reports.
    pub report_every: Duration,
    /// No cycle starts while fleet time may be off by more.
    pub sure_within: Duration,
    /// What it measures of its supply.
    pub supply: SupplyConstants,
    /// What it is, and the constants of that.
    pub robot: Robot,
}

impl Configuration {
    /// What kind of robot it is for.
    #[must_use]
    pub const fn kind(&self) -> ModuleKind {
        match self.robot {
            Robot::Modboat(_) => ModuleKind::Modboat,
            Robot::Rov(_) => ModuleKind::Rov,
        }
    }

    /// Reads the image at the start of `block`; what follows it does not matter.
    ///
    /// # Errors
    /// The first [`ConfigurationError`]; no input panics.
    pub fn read(block: &[u8]) -> Result<Self, ConfigurationError> {
        let short = |need| ConfigurationError::Short { have: block.len(), need };
        let (&magic, rest) = block.split_first_chunk().ok_or_else(|| short(HEAD))?;
        if magic != MAGIC {
            return Err(ConfigurationError::Magic(magic));
        }
        let (&format, rest) = rest.split_first_chunk().ok_or_else(|| short(HEAD))?;
        let format = u16::from_le_bytes(format);
        if format != FORMAT {
            return Err(ConfigurationError::Format(format));
        }
        let (&length, rest) = rest.split_first_chunk().ok_or_else(|| short(HEAD))?;
        let length = u16::from_le_bytes(length);
        let end = HEAD.saturating_add(usize::from(length));
        let total = end.saturating_add(CHECKSUM);
        if total > IMAGE_MAX {
            return Err(ConfigurationError::Length(length));
        }
        let (guarded, after) = block.split_at_checked(end).ok_or_else(|| short(total))?;
        let stored = u32::from_le_bytes(*after.first_chunk().ok_or_else(|| short(total))?);
        let computed = frame::checksum(guarded);
        if stored != computed {
            return Err(ConfigurationError::Checksum { stored, computed });
        }
        let content = rest.get(..usize::from(length)).ok_or_else(|| short(total))?;
        let (configuration, left): (Self, _) =
            postcard::take_from_bytes(content).map_err(|_| ConfigurationError::Content)?;
        if !left.is_empty() {
            return Err(ConfigurationError::Trailing(left.len()));
        }
        configuration.check()?;
        Ok(configuration)
    }

    /// Writes the image to the start of `buffer` and returns that part.
    ///
    /// # Errors
    /// Where [`read`](Self::read) would refuse it, and [`ConfigurationError::BufferTooSmall`]: never with [`IMAGE_MAX`] bytes.
    pub fn write<'a>(&self, buffer: &'a mut [u8]) -> Result<&'a [u8], ConfigurationError> {
        self.check()?;
        let too_small = ConfigurationError::BufferTooSmall { have: buffer.len() };
        let (head, rest) = buffer.split_first_chunk_mut::<HEAD>().ok_or(too_small)?;
        let length = postcard::to_slice(self, rest).map_err(|_| too_small)?.len();
        let short_length = u16::try_from(length).map_err(|_| too_small)?;
        let fields = [&MAGIC[..], &FORMAT.to_le_bytes(), &short_length.to_le_bytes()];
        head.iter_mut().zip(fields.into_iter().flatten()).for_each(|(to, from)| *to = *from);
        let end = HEAD.saturating_add(length);
        let total = end.saturating_add(CHECKSUM);
        let checksum = frame::checksum(buffer.get(..end).ok_or(too_small)?);
        buffer.get_mut(end..total).ok_or(too_small)?.copy_from_slice(&checksum.to_le_bytes());
        buffer.get(..total).ok_or(too_small)
    }

    /// What the postcard does not see to.
    fn check(&self) -> Result<(), ConfigurationError> {
        if !(1..=MODULES_MAX).contains(&self.module.0) {
            return Err(ConfigurationError::Module(self.module));
        }
        self.network.check()?;
        self.supply.check()?;
        self.robot.check()
    }
}

fn write_key<S: Serializer>(key: &ModuleKey, serializer: S) -> Result<S::Ok, S::Error> {
    key.bytes().serialize(serializer)
}

fn read_key<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ModuleKey, D::Error> {
    let mut bytes = <[u8; 32]>::deserialize(deserializer)?;
    let key = ModuleKey::new(bytes);
    bytes.zeroize();
    Ok(key)
}
