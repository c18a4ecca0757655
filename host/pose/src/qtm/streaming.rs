//! What one client of the server has asked for.

use std::net::{IpAddr, SocketAddr};

use super::data::Component;
use crate::time::ServerInstant;

/// How often frames are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rate {
    All,
    /// Every n-th.
    Divisor(u32),
    /// At most so many a second.
    Frequency(f64),
}

/// A stream that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Streaming {
    rate: Rate,
    /// Where frames go, if not over the connection.
    pub udp: Option<SocketAddr>,
    /// What frames have in them.
    pub components: Vec<Component>,
    seen: u32,
    last: Option<ServerInstant>,
}

impl Streaming {
    /// From the words behind `StreamFrames`, of a client at `client`; `None` for what is no request.
    pub fn parse<'a>(mut words: impl Iterator<Item = &'a str>, client: IpAddr) -> Option<Self> {
        let rate = rate(words.next()?)?;
        let mut udp = None;
        let mut components = Vec::new();
        for word in words {
            match word.split_once(':').filter(|(name, _)| name.eq_ignore_ascii_case("udp")) {
                Some((_, place)) => udp = Some(address(place, client)?),
                // Components without bodies are left out, as QTM leaves out what is not measured.
                None => components.extend(Component::named(word)),
            }
        }
        Some(Self { rate, udp, components, seen: 0, last: None })
    }

    /// Whether a frame captured at `captured` is wanted.
    pub fn wants(&mut self, captured: ServerInstant) -> bool {
        self.seen = self.seen.wrapping_add(1);
        let wanted = match self.rate {
            Rate::All => true,
            Rate::Divisor(divisor) => self.seen.wrapping_sub(1).is_multiple_of(divisor),
            Rate::Frequency(hz) => self.last.is_none_or(|last| captured.seconds_since(last) >= 0.999 / hz),
        };
        if wanted {
            self.last = Some(captured);
        }
        wanted
    }
}

fn rate(word: &str) -> Option<Rate> {
    if word.eq_ignore_ascii_case("AllFrames") {
        return Some(Rate::All);
    }
    let (name, number) = word.split_once(':')?;
    match name.to_ascii_lowercase().as_str() {
        "frequencydivisor" => number.parse().ok().filter(|&n| n > 0).map(Rate::Divisor),
        "frequency" => {
            number.parse().ok().filter(|&hz: &f64| hz > 0.0 && hz.is_finite()).map(Rate::Frequency)
        }
        _ => None,
    }
}

/// `port` or `address:port`.
fn address(place: &str, client: IpAddr) -> Option<SocketAddr> {
    match place.rsplit_once(':') {
        Some((address, port)) => Some(SocketAddr::new(address.parse().ok()?, port.parse().ok()?)),
        None => Some(SocketAddr::new(client, place.parse().ok()?)),
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    const CLIENT: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

    fn parsed(text: &str) -> Option<Streaming> {
        Streaming::parse(text.split_whitespace(), CLIENT)
    }

    #[test]
    fn the_documentation_s_example() {
        let streaming = parsed("Frequency:30 UDP:2234 3D Analog 6d").expect("a request");
        assert_eq!(streaming.udp, Some(SocketAddr::new(CLIENT, 2234)));
        assert_eq!(streaming.components, [Component::Matrix]);
        assert_eq!(
            parsed("allframes udp:10.0.0.2:99 6DRes").expect("a request").udp,
            "10.0.0.2:99".parse().ok()
        );
        for wrong in ["", "Sometimes 6D", "FrequencyDivisor:0 6D", "Frequency:-1 6D", "AllFrames UDP:x 6D"] {
            assert_eq!(parsed(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn rates() {
        let wanted = |text: &str| {
            let mut streaming = parsed(text).expect("a request");
            (0..100).filter(|&frame| streaming.wants(ServerInstant(frame * 10_000_000))).count()
        };
        assert_eq!(wanted("AllFrames 6D"), 100);
        assert_eq!(wanted("FrequencyDivisor:4 6D"), 25);
        assert_eq!(wanted("Frequency:50 6D"), 50);
        assert_eq!(wanted("Frequency:500 6D"), 100);
    }
}
