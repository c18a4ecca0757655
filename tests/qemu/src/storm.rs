//! A storm of datagrams that nobody should follow: noise, and genuine ones cut short, from somebody who never stops.

use std::net::{SocketAddr, UdpSocket};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use host::link::identity::HostIdentity;
use protocol::{MAX_DATAGRAM, Message, ModuleId, Nonce, Session, Side};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Starts to send `count` datagrams to `module` at `to`, `rate_hz` of them a second; sent is what the thread returns.
///
/// One in four is noise of any length up to the longest, one in four noise behind a right beginning, two are the beginnings of a datagram
/// that a host of another life has sealed for this very module.
#[must_use]
pub fn start(
    host: &HostIdentity,
    module: ModuleId,
    to: SocketAddr,
    count: u32,
    rate_hz: f64,
    seed: u64,
) -> JoinHandle<u32> {
    let (key, fleet) = (host.key.module(module), host.key.fleet());
    let mut session = Session::new(Side::Host, fleet, module, &key, &Nonce([1; 16]), Nonce([2; 16]));
    std::thread::spawn(move || {
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a free port");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (began, mut sent) = (Instant::now(), 0);
        for number in 0..count {
            let due = began + Duration::from_secs_f64(f64::from(number) / rate_hz);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            let mut buffer = [0; MAX_DATAGRAM];
            let sealed = session.seal(&Message::EmergencyStop, &mut buffer).expect("fits").to_vec();
            let mut noise = vec![0_u8; rng.random_range(0..=MAX_DATAGRAM)];
            rng.fill(&mut noise[..]);
            let datagram = match number % 4 {
                0 => noise,
                1 => [&sealed[..rng.random_range(1..sealed.len())], &noise[..noise.len().min(200)]].concat(),
                _ => sealed[..rng.random_range(0..sealed.len())].to_vec(),
            };
            // An empty one is a datagram as well.
            sent += u32::from(socket.send_to(&datagram, to).is_ok());
        }
        sent
    })
}
