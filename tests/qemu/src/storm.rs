//! A storm of datagrams that no module may follow: noise, and genuine ones cut short.

use link::identity::HostIdentity;
use protocol::{FleetKey, MAX_DATAGRAM, Message, ModuleId, Nonce, Session, Side};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Datagrams of a storm, without end.
///
/// One in four is noise of any length up to the longest, one in four noise behind a right beginning, two are the beginnings of a datagram
/// that a host of another life has sealed for this very module.
pub struct Storm {
    session: Session,
    rng: ChaCha8Rng,
    number: u32,
}

impl Storm {
    /// At `module` of `host`'s fleet.
    #[must_use]
    pub fn new(host: &HostIdentity, module: ModuleId, seed: u64) -> Self {
        let (key, fleet) = (host.key.module(module), host.key.fleet());
        let session = Session::new(Side::Host, fleet, module, &key, &Nonce([1; 16]), Nonce([2; 16]));
        Self { session, rng: ChaCha8Rng::seed_from_u64(seed), number: 0 }
    }
}

impl Iterator for Storm {
    type Item = Vec<u8>;

    fn next(&mut self) -> Option<Vec<u8>> {
        let Self { session, rng, number } = self;
        let mut buffer = [0; MAX_DATAGRAM];
        let sealed = session.seal(&Message::EmergencyStop, &mut buffer).expect("fits");
        let mut noise = vec![0_u8; rng.random_range(0..=MAX_DATAGRAM)];
        rng.fill(&mut noise[..]);
        let kind = *number % 4;
        *number = number.wrapping_add(1);
        Some(match kind {
            0 => noise,
            1 => [&sealed[..rng.random_range(1..sealed.len())], &noise[..noise.len().min(200)]].concat(),
            _ => sealed[..rng.random_range(0..sealed.len())].to_vec(),
        })
    }
}

/// Calls of hosts that do not have the key, under right checksums, without end.
pub fn forged_calls(host: &HostIdentity, module: ModuleId, seed: u64) -> impl Iterator<Item = Vec<u8>> {
    let (key, fleet) = (FleetKey::new([0x5a; 32]).module(module), host.key.fleet());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let [boot, nonce] = [rng.random(), rng.random()].map(Nonce);
        let mut session = Session::new(Side::Host, fleet, module, &key, &boot, nonce);
        session.seal_call(&mut [0; MAX_DATAGRAM]).expect("fits").to_vec()
    })
}
