//! A browser's side of the console: a request, a socket, and what comes by it.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use serde_json::Value;
use tungstenite::protocol::Role;
use tungstenite::{Message, WebSocket};

use crate::common::PATIENCE;

/// After tens of thousands of connections the system uses a port again whose last connection is not over at the other end.
const RETRIES: usize = 20;

/// The address and port of a page's address.
pub fn host_of(url: &str) -> String {
    let rest = url.strip_prefix("http://").expect("HTTP");
    rest.split('/').next().expect("a host").to_owned()
}

/// The token of a page's address.
pub fn token_of(url: &str) -> &str {
    url.split_once("#token=").expect("a token").1
}

/// The reply to a request with these fields besides, or instead of `Host`.
pub fn fetch(url: &str, path: &str, fields: &[&str]) -> String {
    let host = host_of(url);
    let own = format!("Host: {host}");
    let fields = if fields.is_empty() { vec![own.as_str()] } else { fields.to_vec() };
    let mut stream = TcpStream::connect(&host).expect("a server");
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    write!(stream, "GET {path} HTTP/1.1\r\n{}\r\n\r\n", fields.join("\r\n")).expect("room");
    let mut reply = String::new();
    stream.read_to_string(&mut reply).expect("a reply");
    reply
}

/// A socket that speaks `protocol`, opened by a page of `origin`, with `query` in its address; or the code of the refusal, 0 where there is
/// no server.
pub fn open_as(
    url: &str,
    protocol: &str,
    origin: Option<&str>,
    query: &str,
) -> Result<WebSocket<TcpStream>, u16> {
    let host = host_of(url);
    let origin = origin.map_or_else(String::new, |origin| format!("Origin: {origin}\r\n"));
    let request = format!(
        "GET /socket{query} HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
         Sec-WebSocket-Protocol: {protocol}\r\n{origin}\r\n"
    );
    for _ in 0..RETRIES {
        let Ok(mut stream) = TcpStream::connect(&host) else { return Err(0) };
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let head = match stream.write_all(request.as_bytes()).and_then(|()| head(&mut stream)) {
            Ok(head) => head,
            Err(error) if error.kind() == ErrorKind::ConnectionReset => continue,
            Err(error) => panic!("{error}"),
        };
        let code = head.split(' ').nth(1).and_then(|code| code.parse().ok()).expect("a code");
        if code != 101 {
            return Err(code);
        }
        // RFC 6455, 1.3, has this key and its answer as an example.
        let fields = [
            "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=",
            &format!("Sec-WebSocket-Protocol: {protocol}"),
        ];
        assert!(fields.iter().all(|field| head.lines().any(|line| line == *field)), "{head}");
        return Ok(WebSocket::from_raw_socket(stream, Role::Client, None));
    }
    panic!("the server resets every connection");
}

/// The head of a reply, up to its empty line and no further.
fn head(stream: &mut TcpStream) -> std::io::Result<String> {
    let (mut head, mut byte) = (Vec::new(), [0]);
    while !head.ends_with(b"\r\n\r\n") {
        stream.read_exact(&mut byte)?;
        head.extend(byte);
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

/// The code of a refusal.
pub fn refusal(opened: Result<WebSocket<TcpStream>, u16>) -> u16 {
    match opened {
        Ok(_) => 101,
        Err(code) => code,
    }
}

/// A page's socket.
pub struct Page {
    pub socket: WebSocket<TcpStream>,
    /// What came while something else was waited for: answers.
    answers: Vec<Value>,
    /// Numbers of the snapshots that came.
    numbers: Vec<u64>,
    /// Events that came.
    pub events: Vec<Value>,
    /// What was told last of all that happened, and of what is run.
    pub history: Value,
    scene: Value,
    next_id: u64,
}

impl Page {
    /// Opened as a browser does.
    pub fn open(url: &str) -> Self {
        let origin = format!("http://{}", host_of(url));
        Self::over(open_as(url, "flotilla.console.v1", Some(&origin), "").expect("a socket"))
    }

    pub fn over(socket: WebSocket<TcpStream>) -> Self {
        Self {
            socket,
            answers: Vec::new(),
            numbers: Vec::new(),
            events: Vec::new(),
            history: Value::Null,
            scene: Value::Null,
            next_id: 1000,
        }
    }

    /// Opened, with the token shown.
    pub fn trusted(url: &str) -> Self {
        let mut page = Self::open(url);
        let answer = page.ask(&format!(r#"{{"id":1,"do":"hello","token":"{}"}}"#, token_of(url)));
        assert_eq!(answer["ok"], Value::from(true), "{answer}");
        page
    }

    pub fn say(&mut self, text: &str) {
        self.socket.send(Message::text(text)).expect("room");
    }

    /// The next message.
    pub fn next(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().expect("a message") {
                let value: Value = serde_json::from_str(&text).expect("JSON");
                match value["kind"].as_str().expect("a kind") {
                    "answer" => self.answers.push(value.clone()),
                    "snapshot" => self.numbers.push(value["n"].as_u64().expect("a number")),
                    kind @ ("events" | "history") => {
                        if kind == "history" {
                            self.history = value.clone();
                        }
                        self.events.extend(value["events"].as_array().expect("events").iter().cloned());
                    }
                    "scene" => self.scene = value.clone(),
                    _ => {}
                }
                return value;
            }
        }
    }

    /// What is told of the scene, once it is known.
    pub fn scene(&mut self) -> Value {
        while !self.scene["name"].is_string() {
            self.next();
        }
        self.scene.clone()
    }

    /// The first message that is `wanted`.
    pub fn first(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let value = self.next();
            if wanted(&value) {
                return value;
            }
            assert!(began.elapsed() < PATIENCE, "it never comes; the last was {value}");
        }
    }

    /// The first snapshot that is `wanted`.
    pub fn until(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        self.first(|value| value["kind"] == "snapshot" && wanted(value))
    }

    /// How many snapshots have come after `first`.
    pub fn snapshots_since(&self, first: &Value) -> u64 {
        self.numbers.iter().filter(|number| Some(**number) > first["n"].as_u64()).count() as u64
    }

    /// The answer to a command with a number.
    pub fn ask(&mut self, text: &str) -> Value {
        let id = serde_json::from_str::<Value>(text).expect("JSON")["id"].clone();
        self.say(text);
        let began = Instant::now();
        loop {
            if let Some(place) = self.answers.iter().position(|answer| answer["id"] == id) {
                return self.answers.swap_remove(place);
            }
            self.next();
            assert!(began.elapsed() < PATIENCE, "no answer to {text}");
        }
    }

    /// The same of a command without one: it must be followed.
    pub fn order(&mut self, what: &str) -> Value {
        self.next_id += 1;
        let answer = self.ask(&format!(r#"{{"id":{},{what}}}"#, self.next_id));
        assert_eq!(answer["ok"], Value::from(true), "{what}: {answer}");
        answer
    }
}
