//! A server, a client and a clock that is advanced by hand.

use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use nalgebra::{Quaternion, Vector3};
use pose::frame::{Arrival, Body, Frame, Label};
use pose::server::Server;
use pose::source::{Source, SourceError};
use pose::time::{HostInstant, ServerInstant};

/// A port of this machine that the operating system chooses.
pub const ANY_PORT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// Simulated time that passes between two rounds.
pub const STEP: Duration = Duration::from_millis(5);
/// Rounds before a test gives up; each gives the operating system a moment to carry datagrams.
const MOST_ROUNDS: usize = 4000;

/// Labels of three bodies.
pub fn labels() -> Vec<Label> {
    vec![Label::new(1, "boat 1"), Label::new(2, "boat 2"), Label::new(7, "Kälte")]
}

/// A frame whose numbers single precision holds exactly, so that every protocol can carry them unchanged.
pub fn frame(number: u32, captured: ServerInstant) -> Frame {
    let count = f64::from(number % 1000);
    let bodies = labels().into_iter().zip(0..).map(|(label, index)| {
        let offset = f64::from(index);
        // (0.5, ±0.5, ±0.5, ±0.5) is a third of a turn about a diagonal: exact, and no two of its axes alike.
        let attitude = match index {
            0 => Quaternion::new(0.5, 0.5, 0.5, 0.5),
            1 => Quaternion::new(0.5, -0.5, 0.5, 0.5),
            _ => Quaternion::new(1.0, 0.0, 0.0, 0.0),
        };
        Body {
            label,
            position: Vector3::new(0.25 + count, -1.5 * offset, 0.0625 + offset),
            attitude,
            tracked: true,
            error: Some(0.125),
        }
    });
    Frame { number: Some(number), captured, bodies: bodies.collect() }
}

/// A clock that is advanced by hand.
#[derive(Default)]
pub struct Rig {
    /// The host's time.
    pub now: HostInstant,
}

impl Rig {
    /// One step of time, in which the server answers; what the client gets.
    pub fn round(
        &mut self,
        server: &mut dyn Server,
        client: &mut dyn Source,
    ) -> Result<Option<Arrival>, SourceError> {
        self.now = self.now.after(STEP);
        server.poll(self.now);
        let arrival = client.poll(self.now)?;
        if arrival.is_none() {
            // Loopback carries a datagram at once, TCP after its acknowledgements.
            std::thread::sleep(Duration::from_micros(200));
        }
        Ok(arrival)
    }

    /// Rounds until `done` says so.
    pub fn until(
        &mut self,
        server: &mut dyn Server,
        client: &mut dyn Source,
        what: &str,
        mut done: impl FnMut(&dyn Server, &dyn Source) -> bool,
    ) {
        for _ in 0..MOST_ROUNDS {
            if done(server, client) {
                return;
            }
            self.round(server, client).expect("a source that goes on");
        }
        panic!("not within {MOST_ROUNDS} rounds: {what}; the client: {:?}", client.status());
    }

    /// Sends frame `number` until the client has it. Datagrams may be lost on the way, so a frame is sent again after some rounds.
    pub fn deliver(&mut self, server: &mut dyn Server, client: &mut dyn Source, number: u32) -> Arrival {
        for round in 0..MOST_ROUNDS {
            if round % 50 == 0 {
                server.send(self.now, &frame(number, ServerInstant(1_000_000 * i64::from(number))));
            }
            if let Some(arrival) = self.round(server, client).expect("a source that goes on")
                && arrival.frame.number.is_none_or(|found| found == number)
            {
                return arrival;
            }
        }
        panic!("frame {number} did not come; the client: {:?}", client.status());
    }
}
