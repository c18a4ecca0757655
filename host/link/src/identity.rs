//! Identity of a host: the fleet's key, and random bytes that tell this start of it from its other ones.

use protocol::FleetKey;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::entropy::{self, EntropyError};

/// Identity of a host: the fleet's key and the random bytes of this start.
#[derive(Clone, Debug)]
pub struct HostIdentity {
    /// The fleet's key.
    pub key: FleetKey,
    /// Drawn when the host starts.
    pub boot: [u8; 12],
}

impl HostIdentity {
    /// That of a host on a radio.
    ///
    /// # Errors
    /// [`EntropyError`] where the operating system gives no random bytes.
    pub fn new(key: FleetKey) -> Result<Self, EntropyError> {
        let mut boot = [0; 12];
        entropy::fill(&mut boot)?;
        Ok(Self { key, boot })
    }

    /// That of the `start`-th host of a simulation: the fleet's key and the host's bytes are decided by its seed. Never for a radio.
    #[must_use]
    pub fn simulated(seed: u64, start: u64) -> Self {
        let key = FleetKey::new(ChaCha8Rng::seed_from_u64(seed ^ 0x006B_6579).random());
        let boot = ChaCha8Rng::seed_from_u64(seed.wrapping_add(start << 32) ^ 0x626F_6F74).random();
        Self { key, boot }
    }
}
