//! A radio over a UDP socket that never blocks.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};

use protocol::Radio;
use protocol::time::{Duration, FleetInstant};
use thiserror::Error;

/// Why there is no socket.
#[derive(Debug, Error)]
#[error("cannot listen on UDP {address}: {source}")]
pub struct BindError {
    /// The address asked for.
    pub address: String,
    /// What the operating system said.
    pub source: io::Error,
}

/// The host's or a module's radio is broken after its own machine has let no datagram through for this time. *Assumed*: longer than a
/// reload of firewall rules, shorter than an operator's patience.
pub const BROKEN_AFTER: Duration = Duration(3_000_000);

/// Two refusals that are further apart do not belong together. *Assumed*: a host sends many datagrams a second, and one that was paused none.
const TRIED_WITHIN: Duration = Duration(1_000_000);

/// Why a radio is broken: for [`BROKEN_AFTER`] this machine has let no datagram through.
#[derive(Debug, Error)]
#[error(
    "the radio is broken: no datagram got through for {silent_s:.1} s, {failures} failed in all; the last: {source}"
)]
pub struct BrokenRadio {
    /// For how long, s.
    pub silent_s: f32,
    /// Datagrams that the operating system has refused since the socket was opened.
    pub failures: u64,
    /// What the operating system said last.
    pub source: io::Error,
}

/// What a radio needs of a socket.
pub trait Socket {
    /// Hands over a datagram: how much of it was taken.
    ///
    /// # Errors
    /// The operating system's.
    fn send_to(&self, datagram: &[u8], to: SocketAddr) -> io::Result<usize>;

    /// Takes the next datagram: its length, and where it came from.
    ///
    /// # Errors
    /// The operating system's; [`ErrorKind::WouldBlock`] where there is none.
    fn recv_from(&self, buffer: &mut [u8]) -> io::Result<(usize, SocketAddr)>;
}

impl Socket for UdpSocket {
    fn send_to(&self, datagram: &[u8], to: SocketAddr) -> io::Result<usize> {
        Self::send_to(self, datagram, to)
    }

    fn recv_from(&self, buffer: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
        Self::recv_from(self, buffer)
    }
}

/// One UDP socket as a [`Radio`].
///
/// An error of one datagram is a lost datagram, and counted: a firewall that is reloaded (EPERM), a full queue (ENOBUFS), an address
/// that goes and comes back (EADDRNOTAVAIL, ENETUNREACH), a peer without a route (EHOSTUNREACH) or with a port that is none
/// (EINVAL). Only a machine that lets nothing through for [`BROKEN_AFTER`] breaks the radio.
#[derive(Debug)]
pub struct UdpRadio<S = UdpSocket> {
    socket: S,
    failures: u64,
    /// Since when this machine has refused whatever was sent, and whatever was to be received, and when it did so last.
    refuses: [Option<(FleetInstant, FleetInstant)>; 2],
    /// How long it may do so; for ever, if there is no limit.
    patience: Option<Duration>,
}

impl UdpRadio {
    /// Listens on `address`, such as `127.0.0.1:4870`; port 0 takes any free one.
    ///
    /// # Errors
    /// [`BindError`] when the address is not one of this machine or the port is taken.
    pub fn bind(address: impl ToSocketAddrs + std::fmt::Display) -> Result<Self, BindError> {
        let name = address.to_string();
        let bound = UdpSocket::bind(address).and_then(|socket| {
            socket.set_nonblocking(true)?;
            Ok(Self::over(socket))
        });
        bound.map_err(|source| BindError { address: name, source })
    }

    /// Where it listens.
    ///
    /// # Errors
    /// The operating system's.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }
}

impl<S: Socket> UdpRadio<S> {
    /// Over a socket that does not block.
    pub fn over(socket: S) -> Self {
        Self { socket, failures: 0, refuses: [None; 2], patience: Some(BROKEN_AFTER) }
    }

    /// The same radio, never broken: a module waits for its network as long as it takes.
    #[must_use]
    pub fn patient(self) -> Self {
        Self { patience: None, ..self }
    }

    /// Datagrams that the operating system has refused.
    #[must_use]
    pub fn failures(&self) -> u64 {
        self.failures
    }

    /// Counts an error of one datagram; broken if this machine has made such errors alone for too long.
    fn count(&mut self, now: FleetInstant, way: usize, source: io::Error) -> Result<(), BrokenRadio> {
        self.failures += 1;
        if is_of_the_peer(&source) {
            return Ok(());
        }
        // Of a time in which nothing was tried, because the host was paused, nothing is known.
        let since = self.refuses[way]
            .filter(|(_, last)| now.since(*last) < TRIED_WITHIN)
            .map_or(now, |(since, _)| since);
        self.refuses[way] = Some((since, now));
        let silent = now.since(since);
        match self.patience {
            Some(patience) if silent >= patience => {
                Err(BrokenRadio { silent_s: silent.as_secs_f32(), failures: self.failures, source })
            }
            _ => Ok(()),
        }
    }
}

impl<S: Socket> Radio for UdpRadio<S> {
    type Address = SocketAddr;
    type Error = BrokenRadio;

    fn send(&mut self, now: FleetInstant, to: SocketAddr, datagram: &[u8]) -> Result<(), BrokenRadio> {
        match self.socket.send_to(datagram, to) {
            Ok(_) => {
                self.refuses[0] = None;
                Ok(())
            }
            Err(error) => self.count(now, 0, error),
        }
    }

    fn receive(
        &mut self,
        now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, SocketAddr)>, BrokenRadio> {
        for _ in 0..ECHOES {
            match self.socket.recv_from(buffer) {
                Ok(received) => {
                    self.refuses[1] = None;
                    return Ok(Some(received));
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    self.refuses[1] = None;
                    return Ok(None);
                }
                // The echo of an earlier send to a closed port; something real may stand behind it in the queue.
                Err(error) if is_of_the_peer(&error) => {}
                Err(error) => return self.count(now, 1, error).map(|()| None),
            }
        }
        Ok(None)
    }
}

/// So many echoes of failed sends are passed over in one call.
const ECHOES: usize = 64;

/// Whether an error says something of one peer or one moment, and nothing of this machine.
fn is_of_the_peer(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock
            | ErrorKind::Interrupted
            | ErrorKind::ConnectionRefused
            | ErrorKind::ConnectionReset
            | ErrorKind::HostUnreachable
            | ErrorKind::InvalidInput
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn datagrams_cross_a_real_socket() {
        let mut here = UdpRadio::bind("127.0.0.1:0").unwrap();
        let mut there = UdpRadio::bind("127.0.0.1:0").unwrap();
        let mut buffer = [0; 512];
        assert_eq!(there.receive(FleetInstant(0), &mut buffer).unwrap(), None);
        here.send(FleetInstant(0), there.local_address().unwrap(), b"swim").unwrap();
        let received = std::iter::repeat_with(|| {
            std::thread::sleep(std::time::Duration::from_millis(1));
            there.receive(FleetInstant(0), &mut buffer).unwrap()
        })
        .take(2_000)
        .find_map(|received| received);
        assert_eq!(received, Some((4, here.local_address().unwrap())));
        assert_eq!(&buffer[..4], b"swim");
    }

    #[test]
    fn a_busy_port_is_named() {
        let first = UdpRadio::bind("127.0.0.1:0").unwrap();
        let address = first.local_address().unwrap().to_string();
        let error = UdpRadio::bind(address.as_str()).unwrap_err();
        assert!(error.to_string().contains(&address), "{error}");
    }

    #[test]
    fn a_peer_that_is_not_there_is_no_error() {
        let mut here = UdpRadio::bind("127.0.0.1:0").unwrap();
        let gone = UdpRadio::bind("127.0.0.1:0").unwrap().local_address().unwrap();
        let mut buffer = [0; 512];
        for _ in 0..3 {
            here.send(FleetInstant(0), gone, b"hello?").unwrap();
            assert_eq!(here.receive(FleetInstant(0), &mut buffer).unwrap(), None);
        }
    }

    /// A socket whose sends fail as the script says, one entry a datagram; `None` lets one through. Nothing arrives.
    struct Scripted(std::cell::RefCell<std::vec::IntoIter<Option<i32>>>);

    impl Socket for Scripted {
        fn send_to(&self, datagram: &[u8], _: SocketAddr) -> io::Result<usize> {
            match self.0.borrow_mut().next().expect("no more datagrams than the script has") {
                Some(errno) => Err(io::Error::from_raw_os_error(errno)),
                None => Ok(datagram.len()),
            }
        }

        fn recv_from(&self, _: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
            Err(io::Error::from_raw_os_error(9))
        }
    }

    fn scripted(script: Vec<Option<i32>>) -> UdpRadio<Scripted> {
        UdpRadio::over(Scripted(std::cell::RefCell::new(script.into_iter())))
    }

    fn peer() -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], 4870))
    }

    /// Linux's numbers: EPERM, EAGAIN, ENOMEM, EACCES, EINVAL, EMSGSIZE, EADDRNOTAVAIL, ENETDOWN, ENETUNREACH, ENOBUFS,
    /// ECONNREFUSED, EHOSTUNREACH.
    const ERRORS: [i32; 12] = [1, 11, 12, 13, 22, 90, 99, 100, 101, 105, 111, 113];

    #[test]
    fn an_error_of_one_datagram_is_a_lost_datagram() {
        for errno in ERRORS {
            let mut radio = scripted(vec![None, Some(errno), None, Some(errno)]);
            // A minute between them: each stands alone.
            for minute in 0..4 {
                let sent = radio.send(FleetInstant(minute * 60_000_000), peer(), b"swim");
                assert!(sent.is_ok(), "errno {errno}: {sent:?}");
            }
            assert_eq!(radio.failures(), 2, "errno {errno}");
        }
    }

    #[test]
    fn a_machine_that_lets_nothing_through_breaks_the_radio_and_a_peer_does_not() {
        for errno in ERRORS {
            let of_the_peer = [11, 22, 111, 113].contains(&errno);
            let mut radio = scripted(vec![Some(errno); 41]);
            // Ten datagrams a second.
            let broken_at = (0..41).find(|n| radio.send(FleetInstant(n * 100_000), peer(), b"swim").is_err());
            let expected = (!of_the_peer).then_some(u64::from(BROKEN_AFTER.0) / 100_000);
            assert_eq!(broken_at, expected, "errno {errno}");
            let mut patient = scripted(vec![Some(errno); 41]).patient();
            assert!((0..41).all(|n| patient.send(FleetInstant(n * 100_000), peer(), b"swim").is_ok()));
        }
    }

    /// A host that is paused for a minute sends nothing meanwhile: what failed before it says nothing of that time.
    #[test]
    fn failures_before_and_after_a_pause_do_not_make_a_broken_radio() {
        let mut radio = scripted(vec![Some(1); 40]);
        let fails =
            |at_us: u64, radio: &mut UdpRadio<Scripted>| radio.send(FleetInstant(at_us), peer(), b"swim");
        (0..20).for_each(|n| assert!(fails(n * 100_000, &mut radio).is_ok()));
        (600..620).for_each(|n| assert!(fails(n * 100_000, &mut radio).is_ok(), "{n}"));
        assert_eq!(radio.failures(), 40);
    }

    #[test]
    fn a_socket_that_cannot_be_read_breaks_the_radio_in_its_time() {
        let mut radio = scripted(Vec::new());
        let mut buffer = [0; 512];
        let broken_at = (0..).find(|n| radio.receive(FleetInstant(n * 100_000), &mut buffer).is_err());
        assert_eq!(broken_at, Some(u64::from(BROKEN_AFTER.0) / 100_000));
    }

    #[test]
    fn a_peer_with_port_zero_costs_its_own_datagram() {
        let mut here = UdpRadio::bind("127.0.0.1:0").unwrap();
        let none = SocketAddr::from(([127, 0, 0, 1], 0));
        for second in 0..10 {
            here.send(FleetInstant(second * 1_000_000), none, b"hello?").unwrap();
        }
        assert_eq!(here.failures(), 10);
    }
}
