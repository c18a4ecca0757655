//! Who may look, and who may order.
//!
//! | asked for | needs |
//! |---|---|
//! | anything | a `Host` that is this server: a page of another name that leads here (DNS rebinding) has another |
//! | the page's socket | no `Origin`, or that of this server's own page |
//! | Foxglove's protocol | the same, or the token in the address: its clients are pages of their own |
//! | orders | the token |
//!
//! Each run makes a token of its own. It has 128 bits, and is compared in a time that does not depend on it.

use std::fmt::Write as _;
use std::net::{IpAddr, SocketAddr};

/// A secret that is printed once.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// A new one, from the system's randomness.
    ///
    /// # Errors
    /// That there is none.
    pub fn random() -> Result<Self, String> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(|error| format!("no randomness for a token: {error}"))?;
        let mut text = String::new();
        bytes.iter().for_each(|byte| {
            let _ = write!(text, "{byte:02x}");
        });
        Ok(Self(text))
    }

    /// As it stands in an address.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Whether `text` is it.
    #[must_use]
    pub fn is(&self, text: &str) -> bool {
        let (ours, theirs) = (self.0.as_bytes(), text.as_bytes());
        let differs = ours.iter().zip(theirs).fold(0, |differs, (a, b)| differs | (a ^ b));
        ours.len() == theirs.len() && differs == 0
    }
}

/// What a server lets in.
#[derive(Clone)]
pub struct Access {
    /// Where it listens.
    pub address: SocketAddr,
    /// Of orders.
    pub token: Token,
}

impl Access {
    /// Whether `host` is this server, as a browser names it.
    #[must_use]
    pub fn is_here(&self, host: &str) -> bool {
        let port = self.address.port();
        let name = match host.strip_suffix(&format!(":{port}")) {
            Some(name) => name,
            // A browser leaves out the port of HTTP.
            None if port == 80 => host,
            None => return false,
        };
        let number = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        match number.parse::<IpAddr>() {
            // A name could lead anywhere, an address only to whom it belongs.
            Ok(ip) => ip.is_loopback() || ip == self.address.ip() || !self.address.ip().is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        }
    }

    /// Whether a page of `origin` is this server's own, which the browser reached as `host`.
    #[must_use]
    pub fn is_own(&self, origin: Option<&str>, host: &str) -> bool {
        origin.is_none_or(|origin| {
            origin.strip_prefix("http://").is_some_and(|origin| origin.eq_ignore_ascii_case(host))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access(address: &str) -> Access {
        Access { address: address.parse().expect("an address"), token: Token("0123abcd".to_owned()) }
    }

    #[test]
    fn only_the_names_of_this_server_are_let_in() {
        for (address, host, here) in [
            ("127.0.0.1:4880", "127.0.0.1:4880", true),
            ("127.0.0.1:4880", "localhost:4880", true),
            ("127.0.0.1:4880", "LocalHost:4880", true),
            ("[::1]:4880", "[::1]:4880", true),
            ("127.0.0.1:4880", "127.0.0.1:4881", false),
            ("127.0.0.1:4880", "127.0.0.1", false),
            ("127.0.0.1:4880", "evil.example:4880", false),
            ("127.0.0.1:4880", "127.0.0.1.evil.example:4880", false),
            ("127.0.0.1:4880", "192.168.1.5:4880", false),
            ("127.0.0.1:4880", "", false),
            ("0.0.0.0:4880", "192.168.1.5:4880", true),
            ("0.0.0.0:4880", "evil.example:4880", false),
            ("127.0.0.1:80", "localhost", true),
        ] {
            assert_eq!(access(address).is_here(host), here, "{host} at {address}");
        }
    }

    #[test]
    fn a_page_of_another_origin_is_not_ours() {
        let access = access("127.0.0.1:4880");
        for (origin, own) in [
            (None, true),
            (Some("http://127.0.0.1:4880"), true),
            (Some("https://127.0.0.1:4880"), false),
            (Some("http://127.0.0.1:4881"), false),
            (Some("http://127.0.0.1:4880.evil.example"), false),
            (Some("http://localhost:4880"), false),
            (Some("null"), false),
            (Some(""), false),
        ] {
            assert_eq!(access.is_own(origin, "127.0.0.1:4880"), own, "{origin:?}");
        }
    }

    #[test]
    fn a_token_is_all_of_it() {
        let token = access("127.0.0.1:1").token;
        assert!(token.is("0123abcd"));
        for wrong in ["", "0123abc", "0123abcd0", "0123abce", "0123ABCD"] {
            assert!(!token.is(wrong), "{wrong}");
        }
        let (one, two) = (Token::random().expect("randomness"), Token::random().expect("randomness"));
        assert!(one.text().len() == 32 && one.text() != two.text());
    }
}
