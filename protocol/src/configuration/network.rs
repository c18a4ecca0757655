//! Network settings of a module: how it reaches its host.

use heapless::Vec;
use serde::{Deserialize, Serialize};
use zeroize::Zeroize;

use super::ConfigurationError;

/// Longest name of a wireless network, bytes.
pub const SSID_MAX: usize = 32;
/// Longest passphrase, bytes.
pub const PASSPHRASE_MAX: usize = 63;
/// Shortest passphrase, bytes.
const PASSPHRASE_MIN: usize = 8;

/// The network and the host in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Network {
    /// Name of the wireless network; empty for a module on a wire.
    pub ssid: Vec<u8, SSID_MAX>,
    /// Its passphrase; empty for an open one.
    pub passphrase: Passphrase,
    /// Where the host listens.
    pub host: Host,
    /// The module's own address.
    pub own: Own,
}

/// An address of IPv4 and a UDP port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    /// Its address.
    pub address: [u8; 4],
    /// Its port.
    pub port: u16,
}

/// How the module comes to its address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Own {
    /// The network gives it one.
    Dhcp,
    /// It has one.
    Static {
        /// The address.
        address: [u8; 4],
        /// Bits of it that are the network's.
        prefix: u8,
        /// What leads out of the network, if the host is outside.
        gateway: Option<[u8; 4]>,
    },
}

/// A secret of the network's.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Passphrase(Vec<u8, PASSPHRASE_MAX>);

impl Passphrase {
    /// From its bytes; nothing if there are too many.
    #[must_use]
    pub fn new(bytes: &[u8]) -> Option<Self> {
        Vec::from_slice(bytes).ok().map(Self)
    }

    /// Its bytes, for the radio.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }
}

impl Drop for Passphrase {
    fn drop(&mut self) {
        self.0.as_mut_slice().zeroize();
    }
}

impl core::fmt::Debug for Passphrase {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Passphrase(…)")
    }
}

impl Network {
    pub(super) fn check(&self) -> Result<(), ConfigurationError> {
        let bytes = self.passphrase.bytes().len();
        if (1..PASSPHRASE_MIN).contains(&bytes) {
            return Err(ConfigurationError::Passphrase(bytes));
        }
        if self.host.port == 0 {
            return Err(ConfigurationError::Port(self.host.port));
        }
        match self.own {
            Own::Static { prefix, .. } if prefix > 32 => Err(ConfigurationError::Prefix(prefix)),
            _ => Ok(()),
        }
    }
}
