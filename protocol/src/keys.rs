//! Keys: one secret a fleet, everything else derived from it.
//!
//! ```text
//! fleet key ─ HKDF-Extract ─┬─ Expand("fleet") → fleet id, 4 bytes, public
//!                           └─ Expand("module" ‖ id) → module key
//! module key ─┬─ Expand("announce" ‖ Nₘ) → key of a boot's announcements
//!             └─ Expand("session" ‖ Nₘ ‖ Nₕ) → key to the module ‖ key to the host ‖ session number
//! ```
//!
//! HKDF with SHA-256 (RFC 5869); ChaCha20-Poly1305 (RFC 8439) seals. Nₘ is drawn by the module at every boot, Nₕ by the host
//! for every session: a session's keys have a fresh part of either side in them, so whatever was recorded before the
//! reboot of one of them is sealed with keys that are not used any more. A module holds its own key and no other's: who
//! takes one apart learns nothing about the rest of the fleet.
//!
//! Keys are wiped when dropped and never shown: `Debug` prints no byte of them.

use chacha20poly1305::{ChaCha20Poly1305, KeyInit};
use hkdf::Hkdf;
use serde::{Deserialize, Serialize};
use sha2::Sha256;
use zeroize::Zeroize;

use crate::message::ModuleId;

/// Salt of the first derivation: keys of another protocol, or another wire version, have nothing in common with these.
const SALT: &[u8] = b"flotilla wire 2";

/// Which fleet a datagram belongs to: public, so that a radio that hears two fleets can tell them apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FleetId(pub [u8; 4]);

impl core::fmt::Display for FleetId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// 128 bits that are drawn once and never again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Nonce(pub [u8; 16]);

/// The secret of a fleet. The host has it; modules do not.
#[derive(Clone)]
pub struct FleetKey([u8; 32]);

/// The secret of one module.
#[derive(Clone)]
pub struct ModuleKey([u8; 32]);

impl FleetKey {
    /// From 32 random bytes.
    #[must_use]
    pub const fn new(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// Its bytes, to be kept where only its owner reads.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// The fleet's public number.
    #[must_use]
    pub fn fleet(&self) -> FleetId {
        let mut id = [0; 4];
        self.expand(&[b"fleet"], &mut id);
        FleetId(id)
    }

    /// The key of one module.
    #[must_use]
    pub fn module(&self, module: ModuleId) -> ModuleKey {
        let mut key = [0; 32];
        self.expand(&[b"module", &module.0.to_le_bytes()], &mut key);
        ModuleKey(key)
    }

    fn expand(&self, info: &[&[u8]], output: &mut [u8]) {
        let derived = Hkdf::<Sha256>::new(Some(SALT), &self.0).expand_multi_info(info, output);
        debug_assert!(derived.is_ok(), "HKDF gives up to 8160 bytes");
    }
}

impl ModuleKey {
    /// From the 32 bytes that [`FleetKey::module`] gave.
    #[must_use]
    pub const fn new(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// Its bytes, for the module's configuration.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// What seals the announcements of the boot that drew `boot`.
    pub(crate) fn announcements(&self, boot: &Nonce) -> ChaCha20Poly1305 {
        let mut key = [0; 32];
        self.expand(&[b"announce", &boot.0], &mut key);
        let cipher = ChaCha20Poly1305::new(&key.into());
        key.zeroize();
        cipher
    }

    /// What seals the session that `boot` of the module and `host` of the host make.
    pub(crate) fn session(&self, boot: &Nonce, host: &Nonce) -> SessionKeys {
        let mut derived = [0; 68];
        self.expand(&[b"session", &boot.0, &host.0], &mut derived);
        let mut halves = [[0; 32]; 2];
        let (keys, number) = derived.split_at(64);
        for (half, key) in halves.iter_mut().zip(keys.chunks_exact(32)) {
            half.copy_from_slice(key);
        }
        let [to_module, to_host] = halves.map(|key| ChaCha20Poly1305::new(&key.into()));
        halves.zeroize();
        let id = number.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        derived.zeroize();
        SessionKeys { to_module, to_host, id }
    }

    fn expand(&self, info: &[&[u8]], output: &mut [u8]) {
        // The key is already as good as random: no extraction.
        let derived = Hkdf::<Sha256>::from_prk(&self.0).map(|hkdf| hkdf.expand_multi_info(info, output));
        debug_assert!(matches!(derived, Ok(Ok(()))), "32 bytes are a whole SHA-256 block key");
    }
}

/// The keys of one session.
#[derive(Clone)]
pub(crate) struct SessionKeys {
    pub(crate) to_module: ChaCha20Poly1305,
    pub(crate) to_host: ChaCha20Poly1305,
    /// The session's number, public: tells it from others without trying its keys.
    pub(crate) id: u32,
}

impl Drop for FleetKey {
    fn drop(&mut self) {
        self.0.zeroize();
    }
}

impl Drop for ModuleKey {
    fn drop(&mut self) {
        self.0.zeroize();
    }
}

impl core::fmt::Debug for FleetKey {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "FleetKey(of fleet {})", self.fleet())
    }
}

impl core::fmt::Debug for ModuleKey {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("ModuleKey(…)")
    }
}

impl core::fmt::Debug for SessionKeys {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "SessionKeys(of session {:08x})", self.id)
    }
}
