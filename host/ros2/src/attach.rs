//! The run's console, seen from here: its stream of the log's messages, and its commands.
//!
//! Two sockets to one server. The stream speaks `foxglove.sdk.v1`; commands go by the page's own protocol, `flotilla.console.v1`, which has
//! velocities with a heading and answers each command. Neither ever blocks. Sources: `host/console/docs/protocol.md`, and
//! <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>.

use std::collections::{BTreeMap, VecDeque};
use std::io::ErrorKind;
use std::net::TcpStream;
use std::str::FromStr;

use serde_json::{Value, json};
use thiserror::Error;
use tungstenite::http::Uri;
use tungstenite::{Bytes, ClientRequestBuilder, Message, WebSocket};

const STREAM: &str = "foxglove.sdk.v1";
const CONSOLE: &str = "flotilla.console.v1";
/// Of a message: operation, subscription and time stand in front of the CDR.
const DATA: u8 = 1;

/// Where a run serves its console: the address that it printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// Host and port.
    pub host: String,
    /// The token, without which the run takes no commands.
    pub token: Option<String>,
}

/// Why text is no such address.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "\"{0}\" is no page of a run, such as http://127.0.0.1:4880/#token=…, which flotilla run --serve prints"
)]
pub struct AddressError(String);

/// What became of a connection.
#[derive(Debug, Error)]
pub enum AttachError {
    /// There is no server.
    #[error(
        "no run at {host}: {reason}; start one by flotilla run --serve, and give the address that it prints"
    )]
    Absent {
        /// Where.
        host: String,
        /// What the operating system or the server said.
        reason: String,
    },
    /// The connection broke.
    #[error("the connection to the run is lost: {0}")]
    Lost(String),
    /// The server went, in good order.
    #[error("the run is over")]
    Over,
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(given: &str) -> Result<Self, AddressError> {
        let wrong = || AddressError(given.to_owned());
        let rest = given.strip_prefix("http://").or(given.strip_prefix("ws://")).ok_or_else(wrong)?;
        let (host, rest) = rest.split_once('/').unwrap_or((rest, ""));
        let token = rest.split(['#', '?', '&']).find_map(|part| part.strip_prefix("token="));
        let is_host =
            host.rsplit_once(':').is_some_and(|(name, port)| !name.is_empty() && port.parse::<u16>().is_ok());
        if !is_host || token == Some("") {
            return Err(wrong());
        }
        Ok(Self { host: host.to_owned(), token: token.map(str::to_owned) })
    }
}

/// A socket that never blocks.
struct Socket(WebSocket<TcpStream>);

impl Socket {
    fn open(address: &Address, protocol: &str) -> Result<Self, AttachError> {
        let host = &address.host;
        let absent = |reason: String| AttachError::Absent { host: host.clone(), reason };
        let uri: Uri =
            format!("ws://{host}/socket").parse().map_err(|_| absent("no such address".to_owned()))?;
        let stream = TcpStream::connect(host).map_err(|error| absent(error.to_string()))?;
        let _ = stream.set_nodelay(true);
        let request = ClientRequestBuilder::new(uri).with_sub_protocol(protocol);
        let (socket, _) = tungstenite::client(request, stream).map_err(|error| absent(error.to_string()))?;
        socket.get_ref().set_nonblocking(true).map_err(|error| absent(error.to_string()))?;
        Ok(Self(socket))
    }

    /// The next message; `None` where none has come.
    fn poll(&mut self) -> Result<Option<Message>, AttachError> {
        let read = self.0.flush().and_then(|()| self.0.read());
        Self::judged(read.map(Some))
    }

    fn send(&mut self, message: Message) -> Result<(), AttachError> {
        Self::judged(self.0.send(message).map(|()| None)).map(drop)
    }

    /// What is left to be sent is kept, and sent by the next poll.
    fn judged(outcome: tungstenite::Result<Option<Message>>) -> Result<Option<Message>, AttachError> {
        match outcome {
            Ok(Some(Message::Close(_)))
            | Err(tungstenite::Error::ConnectionClosed | tungstenite::Error::AlreadyClosed) => {
                Err(AttachError::Over)
            }
            Ok(message) => Ok(message),
            Err(tungstenite::Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(AttachError::Lost(error.to_string())),
        }
    }
}

/// What comes by the stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Came {
    /// A topic that the run has: its number, its name, the name of its message.
    Topic(u32, String, String),
    /// A message of a topic that was subscribed to, in CDR with its encapsulation header.
    Message(u32, Vec<u8>),
    /// Something that a person should know.
    Warning(String),
}

/// The stream.
pub struct Stream {
    socket: Socket,
    came: VecDeque<Came>,
}

impl Stream {
    /// Opens it.
    ///
    /// # Errors
    /// [`AttachError::Absent`].
    pub fn open(address: &Address) -> Result<Self, AttachError> {
        Ok(Self { socket: Socket::open(address, STREAM)?, came: VecDeque::new() })
    }

    /// Subscribes to a topic. Of topics that are told seldom the newest message comes at once.
    ///
    /// # Errors
    /// A connection that is lost.
    pub fn subscribe(&mut self, topic: u32) -> Result<(), AttachError> {
        let one = json!({ "id": topic, "channelId": topic });
        self.socket.send(Message::text(json!({ "op": "subscribe", "subscriptions": [one] }).to_string()))
    }

    /// Ends a subscription; what is under way still comes.
    ///
    /// # Errors
    /// A connection that is lost.
    pub fn unsubscribe(&mut self, topic: u32) -> Result<(), AttachError> {
        self.socket
            .send(Message::text(json!({ "op": "unsubscribe", "subscriptionIds": [topic] }).to_string()))
    }

    /// What came next; `None` where nothing has come.
    ///
    /// # Errors
    /// A connection that is lost, or a run that is over.
    pub fn poll(&mut self) -> Result<Option<Came>, AttachError> {
        while self.came.is_empty() {
            match self.socket.poll()? {
                None => return Ok(None),
                Some(Message::Binary(bytes)) => self.came.extend(data(&bytes)),
                Some(Message::Text(text)) => self.came.extend(said(&text)),
                Some(_) => {}
            }
        }
        Ok(self.came.pop_front())
    }
}

fn data(bytes: &Bytes) -> Option<Came> {
    let rest = bytes.strip_prefix(&[DATA])?;
    let (number, rest) = rest.split_first_chunk()?;
    let (_, cdr) = rest.split_first_chunk::<8>()?;
    Some(Came::Message(u32::from_le_bytes(*number), cdr.to_vec()))
}

fn said(text: &str) -> Vec<Came> {
    let Ok(said) = serde_json::from_str::<Value>(text) else { return Vec::new() };
    let word = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
    match said.get("op").and_then(Value::as_str) {
        Some("advertise") => {
            let all = said.get("channels").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            let topic = |one: &Value| {
                let id = one.get("id").and_then(Value::as_u64).and_then(|id| id.try_into().ok())?;
                Some(Came::Topic(id, word(one, "topic")?, word(one, "schemaName")?))
            };
            all.iter().filter_map(topic).collect()
        }
        Some("status") if said.get("level").and_then(Value::as_u64) > Some(0) => {
            word(&said, "message").map(Came::Warning).into_iter().collect()
        }
        _ => Vec::new(),
    }
}

/// What the run said to a command.
pub struct Answered<T> {
    /// What the command was for.
    pub purpose: T,
    /// What was done, or why not.
    pub outcome: Result<String, String>,
}

/// Commands, each with what its answer is for.
pub struct Commands<T> {
    socket: Socket,
    next: u32,
    waiting: BTreeMap<u32, T>,
}

impl<T> Commands<T> {
    /// Opens the socket; whether commands are taken is what the answer to `hello` says.
    ///
    /// # Errors
    /// [`AttachError::Absent`].
    pub fn open(address: &Address) -> Result<Self, AttachError> {
        Ok(Self { socket: Socket::open(address, CONSOLE)?, next: 1, waiting: BTreeMap::new() })
    }

    /// Gives a command.
    ///
    /// # Errors
    /// A connection that is lost.
    pub fn give(&mut self, mut command: Value, purpose: T) -> Result<(), AttachError> {
        let id = self.next;
        self.next = self.next.wrapping_add(1);
        if let Some(object) = command.as_object_mut() {
            object.insert("id".to_owned(), json!(id));
        }
        self.waiting.insert(id, purpose);
        self.socket.send(Message::text(command.to_string()))
    }

    /// The next answer.
    ///
    /// # Errors
    /// A connection that is lost, or a run that is over.
    pub fn poll(&mut self) -> Result<Option<Answered<T>>, AttachError> {
        while let Some(message) = self.socket.poll()? {
            if let Message::Text(text) = message
                && let Some((id, outcome)) = answer(&text)
                && let Some(purpose) = self.waiting.remove(&id)
            {
                return Ok(Some(Answered { purpose, outcome }));
            }
        }
        Ok(None)
    }
}

/// The answer in a frame; most frames are snapshots for pages.
fn answer(text: &str) -> Option<(u32, Result<String, String>)> {
    #[derive(serde::Deserialize)]
    struct Answer {
        kind: String,
        #[serde(default)]
        id: u32,
        #[serde(default)]
        ok: bool,
        #[serde(default)]
        text: String,
    }
    let answer: Answer = serde_json::from_str(text).ok().filter(|answer: &Answer| answer.kind == "answer")?;
    Some((answer.id, if answer.ok { Ok(answer.text) } else { Err(answer.text) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_those_that_a_run_prints() {
        let address: Address = "http://127.0.0.1:4880/#token=0123ab".parse().expect("an address");
        assert_eq!((address.host.as_str(), address.token.as_deref()), ("127.0.0.1:4880", Some("0123ab")));
        let address: Address = "ws://[::1]:80/?token=7".parse().expect("an address");
        assert_eq!((address.host.as_str(), address.token.as_deref()), ("[::1]:80", Some("7")));
        assert_eq!("http://host:1".parse::<Address>().map(|address| address.token), Ok(None));
        for wrong in ["", "127.0.0.1:4880", "http://", "http://host/", "http://:1/", "http://h:1/#token="] {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
    }

    /// Bytes and texts as the specification draws them.
    #[test]
    fn messages_topics_and_answers_are_read() {
        let bytes = Bytes::from_static(&[1, 7, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 9]);
        assert_eq!(data(&bytes), Some(Came::Message(7, vec![0, 1, 0, 0, 9])));
        for length in 0..13 {
            assert_eq!(data(&bytes.slice(..length)), None, "of {length} bytes");
        }
        let topics = r#"{"op":"advertise","channels":[{"id":3,"topic":"/tf","schemaName":"tf2_msgs/msg/TFMessage"},{"id":-1}]}"#;
        assert_eq!(said(topics), [Came::Topic(3, "/tf".to_owned(), "tf2_msgs/msg/TFMessage".to_owned())]);
        assert_eq!(said(r#"{"op":"status","level":1,"message":"slow"}"#), [Came::Warning("slow".to_owned())]);
        assert_eq!(said(r#"{"op":"status","level":0,"message":"well"}"#), []);
        assert_eq!(said("nonsense"), []);
        assert_eq!(
            answer(r#"{"kind":"answer","id":5,"ok":false,"text":"no"}"#),
            Some((5, Err("no".to_owned())))
        );
        assert_eq!(answer(r#"{"kind":"snapshot","n":1,"ok":null}"#), None);
    }
}
