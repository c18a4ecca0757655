//! The request that begins a connection, and the reply to it. Each connection takes one request; what follows a reply is not read.

use sha1::{Digest as _, Sha1};

use super::access::Access;
use super::page::{Asset, asset};

/// The longest head of a request, bytes.
pub const HEAD_MAX: usize = 8192;
/// Header fields at most.
const FIELDS: usize = 64;

/// The page's own protocol.
pub const CONSOLE: &str = "flotilla.console.v1";
/// Foxglove's, by its newer and its older name; the frames are the same.
pub const STREAM: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// Scripts and styles are files of this server alone, and no other page shows this one in a frame.
const POLICY: &str =
    "default-src 'self'; connect-src 'self' ws:; img-src 'self' data:; frame-ancestors 'none'";

/// What a socket speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speaks {
    /// The page's protocol.
    Console,
    /// Foxglove's.
    Stream,
}

/// What is done with a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// These bytes are sent, and it is closed.
    Reply(Vec<u8>),
    /// These bytes are sent, and it is a WebSocket.
    Upgrade {
        /// The reply.
        reply: Vec<u8>,
        /// What it speaks.
        speaks: Speaks,
        /// Whether the token stood in the address.
        trusted: bool,
        /// How long the head was; what is behind it belongs to the socket.
        length: usize,
    },
    /// More of the head is to come.
    More,
}

#[derive(Default)]
struct Fields<'a> {
    host: Option<&'a str>,
    origin: Option<&'a str>,
    key: Option<&'a str>,
    version: Option<&'a str>,
    protocols: Vec<&'a str>,
    upgrades: bool,
}

/// What is done with a connection that began with `head`.
#[must_use]
pub fn judge(head: &[u8], access: &Access) -> Verdict {
    let mut fields = [httparse::EMPTY_HEADER; FIELDS];
    let mut request = httparse::Request::new(&mut fields);
    let length = match request.parse(head) {
        Ok(httparse::Status::Complete(length)) if length <= HEAD_MAX => length,
        Ok(httparse::Status::Partial) if head.len() < HEAD_MAX => return Verdict::More,
        Ok(_) | Err(httparse::Error::TooManyHeaders) => return refuse(431, "the head is too long"),
        Err(_) => return refuse(400, "no HTTP request"),
    };
    let (Some(method), Some(target)) = (request.method, request.path) else {
        return refuse(400, "no HTTP request");
    };
    let Some(fields) = of_interest(request.headers) else {
        return refuse(400, "a field is doubled or no text");
    };
    let Some(host) = fields.host.filter(|host| access.is_here(host)) else {
        return refuse(403, "this server has another name: see its address");
    };
    if method != "GET" && method != "HEAD" {
        return refuse(405, "GET alone");
    }
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    if fields.upgrades {
        return upgrade(&fields, host, query, access, length);
    }
    match asset(path) {
        Some(asset) => Verdict::Reply(file(asset, method == "HEAD")),
        None => refuse(404, "no such page"),
    }
}

/// The fields that matter; `None` where one that may come once comes twice.
fn of_interest<'a>(all: &[httparse::Header<'a>]) -> Option<Fields<'a>> {
    let mut fields = Fields::default();
    for field in all {
        let name = field.name.to_ascii_lowercase();
        let place = match name.as_str() {
            "host" => &mut fields.host,
            "origin" => &mut fields.origin,
            "sec-websocket-key" => &mut fields.key,
            "sec-websocket-version" => &mut fields.version,
            "sec-websocket-protocol" => {
                fields.protocols.extend(str::from_utf8(field.value).ok()?.split(',').map(str::trim));
                continue;
            }
            "upgrade" => {
                fields.upgrades |= field.value.eq_ignore_ascii_case(b"websocket");
                continue;
            }
            _ => continue,
        };
        if place.replace(str::from_utf8(field.value).ok()?).is_some() {
            return None;
        }
    }
    Some(fields)
}

fn upgrade(fields: &Fields<'_>, host: &str, query: &str, access: &Access, length: usize) -> Verdict {
    // Sixteen random bytes in base64: RFC 6455, 4.1.
    let (Some(key), Some("13")) = (fields.key.filter(|key| key.len() == 24), fields.version) else {
        return refuse(400, "no WebSocket of version 13");
    };
    let spoken = fields.protocols.iter().find_map(|&protocol| {
        let stream = STREAM.into_iter().find(|known| *known == protocol);
        stream
            .map(|name| (Speaks::Stream, name))
            .or((protocol == CONSOLE).then_some((Speaks::Console, CONSOLE)))
    });
    let Some((speaks, protocol)) = spoken else {
        return refuse(400, "speaks flotilla.console.v1, foxglove.sdk.v1 and foxglove.websocket.v1");
    };
    let mut given = query.split('&').filter_map(|pair| pair.strip_prefix("token="));
    let trusted = speaks == Speaks::Stream && given.any(|text| access.token.is(text));
    if !trusted && !access.is_own(fields.origin, host) {
        return refuse(403, "a page from elsewhere");
    }
    let accept = accept(key);
    let reply = format!(
        "HTTP/1.1 101 Switching Protocols\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Accept: {accept}\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n"
    );
    Verdict::Upgrade { reply: reply.into_bytes(), speaks, trusted, length }
}

/// The answer to a key, that shows that this is a server of WebSockets: RFC 6455, 4.2.2.
fn accept(key: &str) -> String {
    base64(&Sha1::digest(format!("{key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11")))
}

/// RFC 4648, 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let word =
            three.iter().zip([16, 8, 0]).fold(0, |word, (byte, shift)| word | u32::from(*byte) << shift);
        for (place, shift) in [18, 12, 6, 0].into_iter().enumerate() {
            let digit = DIGITS.get((word >> shift & 63) as usize).filter(|_| place <= three.len());
            text.push(char::from(*digit.unwrap_or(&b'=')));
        }
    }
    text
}

fn head(code: u16, reason: &str, kind: &str, length: usize) -> String {
    format!(
        "HTTP/1.1 {code} {reason}\r\nConnection: close\r\nContent-Length: {length}\r\nContent-Type: {kind}\r\n\
         Cache-Control: no-store\r\nContent-Security-Policy: {POLICY}\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\r\n"
    )
}

fn file(asset: &Asset, head_only: bool) -> Vec<u8> {
    let mut reply = head(200, "OK", asset.kind, asset.bytes.len()).into_bytes();
    if !head_only {
        reply.extend_from_slice(asset.bytes);
    }
    reply
}

fn refuse(code: u16, why: &str) -> Verdict {
    let reason = match code {
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        431 => "Request Header Fields Too Large",
        _ => "Bad Request",
    };
    let text = format!("{why}\n");
    Verdict::Reply((head(code, reason, "text/plain; charset=utf-8", text.len()) + &text).into_bytes())
}

/// What a client that finds no place is told.
#[must_use]
pub fn full() -> Vec<u8> {
    (head(503, "Service Unavailable", "text/plain; charset=utf-8", 0)).into_bytes()
}

#[cfg(test)]
mod tests {
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use super::super::access::Token;
    use super::*;

    fn access() -> Access {
        let address = "127.0.0.1:4880".parse().expect("an address");
        Access { address, token: Token::random().expect("randomness") }
    }

    fn get(path: &str, fields: &str) -> String {
        format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:4880\r\n{fields}\r\n")
    }

    const SOCKET: &str = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
                          Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

    fn code(verdict: &Verdict) -> u16 {
        let (Verdict::Reply(reply) | Verdict::Upgrade { reply, .. }) = verdict else { return 0 };
        let text = String::from_utf8_lossy(reply);
        text.split(' ').nth(1).and_then(|code| code.parse().ok()).expect("a status line")
    }

    #[test]
    fn requests_get_what_they_ask_for() {
        let access = access();
        for (request, expected) in [
            (get("/", ""), 200),
            (get("/?a=b", ""), 200),
            (get("/main.js", ""), 200),
            (get("/../Cargo.toml", ""), 404),
            (get("/token", ""), 404),
            (get("/", "").replace("GET", "POST"), 405),
            (get("/", "").replace("127.0.0.1:4880", "evil.example"), 403),
            (get("/", "Host: 127.0.0.1:4880\r\n"), 400),
            ("GET / HTTP/1.1\r\n\r\n".to_owned(), 403),
            ("\u{1}\u{2}\r\n\r\n".to_owned(), 400),
            ("GET / HTTP/1.1\r\nHost: 1".to_owned(), 0),
            (get("/", &"A: b\r\n".repeat(100)), 431),
            (format!("GET /{} HTTP/1.1\r\n", "a".repeat(HEAD_MAX)), 431),
            (get("/socket", SOCKET), 400),
            (get("/socket", &format!("{SOCKET}Sec-WebSocket-Protocol: x, {CONSOLE}\r\n")), 101),
            (
                get("/socket", &format!("{SOCKET}Sec-WebSocket-Protocol: {CONSOLE}\r\n").replace("13", "8")),
                400,
            ),
        ] {
            assert_eq!(code(&judge(request.as_bytes(), &access)), expected, "{request}");
        }
    }

    /// The pair of key and answer stands in RFC 6455, 1.3.
    #[test]
    fn a_socket_is_answered_as_the_standard_has_it() {
        let request = get("/", &format!("{SOCKET}Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"));
        let verdict = judge(format!("{request}rest").as_bytes(), &access());
        let Verdict::Upgrade { reply, speaks, trusted, length } = verdict else { panic!("{verdict:?}") };
        let reply = String::from_utf8(reply).expect("UTF-8");
        assert!(reply.contains("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), "{reply}");
        assert!(reply.contains("Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"), "{reply}");
        assert_eq!((speaks, trusted, length), (Speaks::Stream, false, request.len()));
    }

    #[test]
    fn a_page_from_elsewhere_gets_no_socket_but_a_stream_by_token() {
        let access = access();
        let token = access.token.text();
        let elsewhere = "Origin: http://127.0.0.1:8080\r\n";
        for (path, protocol, origin, expected) in [
            ("/", CONSOLE, "", 101),
            ("/", CONSOLE, "Origin: http://127.0.0.1:4880\r\n", 101),
            ("/", CONSOLE, elsewhere, 403),
            (&*format!("/?token={token}"), CONSOLE, elsewhere, 403),
            ("/", STREAM[0], elsewhere, 403),
            ("/?token=0", STREAM[0], elsewhere, 403),
            (&*format!("/?token={token}"), STREAM[0], elsewhere, 101),
            (&*format!("/?a=b&token={token}"), STREAM[1], elsewhere, 101),
        ] {
            let request = get(path, &format!("{SOCKET}{origin}Sec-WebSocket-Protocol: {protocol}\r\n"));
            assert_eq!(code(&judge(request.as_bytes(), &access)), expected, "{request}");
        }
    }

    #[test]
    fn random_heads_are_judged_without_a_panic() {
        let access = access();
        let good = get("/", &format!("{SOCKET}Sec-WebSocket-Protocol: {CONSOLE}\r\n")).into_bytes();
        for seed in 0..20_000 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut head = if seed % 2 == 0 { good.clone() } else { vec![0; random.random_range(0..300)] };
            let changes = if seed % 2 == 0 { random.random_range(0..6) } else { head.len() };
            for _ in 0..changes.min(head.len()) {
                let at = random.random_range(0..head.len());
                head[at] = random.random();
            }
            head.truncate(random.random_range(0..=head.len()));
            // Whatever it is, it is one of the three.
            let _ = judge(&head, &access);
        }
    }

    /// The examples of RFC 4648, 10.
    #[test]
    fn base64_is_as_the_standard_has_it() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
