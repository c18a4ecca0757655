//! One connection: a request, then a reply or a WebSocket. Nothing here waits.
//!
//! What is kept for one that does not take it: one snapshot, the newest, and [`QUEUE_BYTES`] of everything else. What finds no room is
//! dropped and counted. One that takes nothing for [`DEAD_AFTER`] is closed.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, Utf8Bytes, WebSocket};

use super::access::Access;
use super::http::{self, Speaks, Verdict};

/// The longest frame and message from a client, bytes.
pub const FRAME_MAX: usize = 64 << 10;
/// What may wait for a client, bytes, besides a snapshot.
pub const QUEUE_BYTES: usize = 1 << 20;
/// A request has this time to come, and a reply to be taken.
const REQUEST_WITHIN: Duration = Duration::from_secs(5);
/// A socket that takes nothing for this time is closed. *Assumed.*
pub const DEAD_AFTER: Duration = Duration::from_secs(10);
/// Messages that are read at one look: others have their turn between.
const READ_AT_ONCE: usize = 32;

enum State {
    /// The head so far.
    Request(TcpStream, Vec<u8>),
    /// What is left to be sent from where on, and what the socket becomes then.
    Reply(TcpStream, Vec<u8>, usize, Option<(Speaks, Vec<u8>)>),
    /// A socket.
    Socket(Box<WebSocket<TcpStream>>, Speaks),
    /// It is gone.
    Over,
}

/// What came from a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Came {
    /// It is a socket now.
    Opened(Speaks),
    /// A text.
    Text(Utf8Bytes),
    /// Bytes.
    Binary(Bytes),
}

/// See the module's documentation.
pub struct Client {
    /// Its number; no two of a server have the same.
    pub id: u32,
    /// Where it is.
    pub peer: SocketAddr,
    /// It has shown the token.
    pub trusted: bool,
    state: State,
    /// Since when it is what it is.
    since: Instant,
    /// Since when it has not taken what waits for it.
    stalled: Option<Instant>,
    snapshot: Option<Utf8Bytes>,
    queue: VecDeque<Message>,
    queued_bytes: usize,
    /// Messages and snapshots that it was too slow for.
    pub dropped: u64,
}

impl Client {
    /// Of a new connection.
    #[must_use]
    pub fn new(id: u32, peer: SocketAddr, stream: TcpStream, now: Instant) -> Self {
        Self {
            id,
            peer,
            trusted: false,
            state: State::Request(stream, Vec::new()),
            since: now,
            stalled: None,
            snapshot: None,
            queue: VecDeque::new(),
            queued_bytes: 0,
            dropped: 0,
        }
    }

    /// Its connection, while it has one.
    #[must_use]
    pub fn stream(&self) -> Option<&TcpStream> {
        match &self.state {
            State::Request(stream, _) | State::Reply(stream, ..) => Some(stream),
            State::Socket(socket, _) => Some(socket.get_ref()),
            State::Over => None,
        }
    }

    /// What it speaks, once it is a socket.
    #[must_use]
    pub fn speaks(&self) -> Option<Speaks> {
        match &self.state {
            State::Socket(_, speaks) => Some(*speaks),
            _ => None,
        }
    }

    /// Whether it is gone.
    #[must_use]
    pub fn is_over(&self) -> bool {
        matches!(self.state, State::Over)
    }

    /// Whether something waits for it to take it.
    #[must_use]
    pub fn wants_to_write(&self) -> bool {
        let queued = self.snapshot.is_some() || !self.queue.is_empty() || self.stalled.is_some();
        matches!(self.state, State::Reply(..)) || self.speaks().is_some() && queued
    }

    /// Ends it.
    pub fn close(&mut self) {
        self.state = State::Over;
        (self.snapshot, self.queued_bytes) = (None, 0);
        self.queue.clear();
    }

    /// Queues a snapshot; the one that still waits is dropped.
    pub fn push_snapshot(&mut self, text: impl FnOnce(u64) -> Utf8Bytes) {
        if self.speaks().is_some() {
            self.dropped += u64::from(self.snapshot.is_some());
            self.snapshot = Some(text(self.dropped));
        }
    }

    /// The snapshot that waits goes before what is queued next.
    pub fn flush_snapshot(&mut self) {
        if let Some(text) = self.snapshot.take() {
            self.push(Message::Text(text));
        }
    }

    /// Queues a message; false if there is no room for it.
    pub fn push(&mut self, message: Message) -> bool {
        let length = message.len();
        // One alone may be longer than all that usually waits.
        if self.speaks().is_none() || !self.queue.is_empty() && self.queued_bytes + length > QUEUE_BYTES {
            self.dropped += 1;
            return false;
        }
        self.queued_bytes += length;
        self.queue.push_back(message);
        true
    }

    /// Reads what has come, into `came`.
    pub fn read(&mut self, access: &Access, now: Instant, came: &mut Vec<Came>) {
        if let State::Request(..) = self.state {
            self.read_request(access, now);
        }
        for _ in 0..READ_AT_ONCE {
            let State::Socket(socket, _) = &mut self.state else { return };
            match socket.read() {
                Ok(Message::Text(text)) => came.push(Came::Text(text)),
                Ok(Message::Binary(bytes)) => came.push(Came::Binary(bytes)),
                Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_) | Message::Close(_)) => {}
                Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => return,
                Err(_) => return self.close(),
            }
        }
    }

    fn read_request(&mut self, access: &Access, now: Instant) {
        let State::Request(stream, head) = &mut self.state else { return };
        let mut bytes = [0; 2048];
        match stream.read(&mut bytes) {
            Ok(0) => return self.close(),
            Ok(read) => head.extend_from_slice(bytes.get(..read).unwrap_or_default()),
            Err(error) if error.kind() == ErrorKind::WouldBlock => return,
            Err(_) => return self.close(),
        }
        let (reply, socket) = match http::judge(head, access) {
            Verdict::More => return,
            Verdict::Reply(reply) => (reply, None),
            Verdict::Upgrade { reply, speaks, trusted, length } => {
                self.trusted = trusted;
                (reply, Some((speaks, head.split_off(length))))
            }
        };
        self.since = now;
        if let State::Request(stream, _) = std::mem::replace(&mut self.state, State::Over) {
            self.state = State::Reply(stream, reply, 0, socket);
        }
    }

    /// Sends what it takes. That it has become a socket goes into `came`.
    pub fn write(&mut self, now: Instant, came: &mut Vec<Came>) {
        if let State::Reply(..) = self.state {
            self.write_reply(now, came);
        }
        // One that did not take the last of it gets no more to buffer before it has.
        if self.stalled.is_some() && !self.flush(now) {
            return;
        }
        while let Some(message) = self.next_message() {
            let State::Socket(socket, _) = &mut self.state else { return };
            let result = socket.write(message);
            if !self.took(result, now) {
                return;
            }
        }
        self.flush(now);
    }

    /// What came first goes first, but for snapshots: they are about now.
    fn next_message(&mut self) -> Option<Message> {
        let next = self.queue.pop_front();
        self.queued_bytes -= next.as_ref().map_or(0, Message::len);
        next.or_else(|| self.snapshot.take().map(Message::Text))
    }

    /// Sends what the socket has buffered; false if something of it is left.
    fn flush(&mut self, now: Instant) -> bool {
        let State::Socket(socket, _) = &mut self.state else { return false };
        let result = socket.flush();
        let took = self.took(result, now);
        if took {
            self.stalled = None;
        }
        took
    }

    /// Whether a socket took all of it; if not, it waits from `now` on, or is over.
    fn took(&mut self, result: Result<(), Error>, now: Instant) -> bool {
        match result {
            Ok(()) => return true,
            Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => {
                self.stalled.get_or_insert(now);
            }
            Err(_) => self.close(),
        }
        false
    }

    fn write_reply(&mut self, now: Instant, came: &mut Vec<Came>) {
        let State::Reply(stream, reply, sent, _) = &mut self.state else { return };
        while let Some(rest) = reply.get(*sent..).filter(|rest| !rest.is_empty()) {
            match stream.write(rest) {
                Ok(0) => return self.close(),
                Ok(wrote) => *sent += wrote,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(_) => return self.close(),
            }
        }
        let State::Reply(stream, .., Some((speaks, rest))) = std::mem::replace(&mut self.state, State::Over)
        else {
            return;
        };
        let config = WebSocketConfig::default()
            .read_buffer_size(4 << 10)
            .write_buffer_size(16 << 10)
            .max_write_buffer_size(2 << 20)
            .max_message_size(Some(FRAME_MAX))
            .max_frame_size(Some(FRAME_MAX));
        let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
        self.state = State::Socket(Box::new(socket), speaks);
        self.since = now;
        came.push(Came::Opened(speaks));
    }

    /// Ends it at `now` if it has been given enough time.
    pub fn expire(&mut self, now: Instant) {
        let over = match &self.state {
            State::Request(..) | State::Reply(..) => {
                now.saturating_duration_since(self.since) > REQUEST_WITHIN
            }
            State::Socket(..) => {
                self.stalled.is_some_and(|stalled| now.saturating_duration_since(stalled) > DEAD_AFTER)
            }
            State::Over => false,
        };
        if over {
            self.close();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::super::access::Token;
    use super::*;

    /// A client of the stream at `now`, and its end of the connection. The system keeps little of what is between them.
    fn connected(now: Instant) -> (Client, WebSocket<TcpStream>) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let mut end = TcpStream::connect(address).expect("a connection");
        let (stream, peer) = listener.accept().expect("a connection");
        for stream in [&end, &stream] {
            let socket = socket2::SockRef::from(stream);
            socket
                .set_send_buffer_size(8192)
                .and_then(|()| socket.set_recv_buffer_size(8192))
                .expect("a size");
        }
        stream.set_nonblocking(true).expect("a socket");
        let request = format!(
            "GET /socket HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        );
        end.write_all(request.as_bytes()).expect("room");
        let access = Access { address, token: Token::random().expect("a token") };
        let (mut client, mut came) = (Client::new(1, peer, stream, now), Vec::new());
        while client.speaks().is_none() && !client.is_over() {
            client.read(&access, now, &mut came);
            client.write(now, &mut came);
        }
        assert_eq!(came, [Came::Opened(Speaks::Stream)]);
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            end.read_exact(&mut byte).expect("a reply");
            head.extend(byte);
        }
        (client, WebSocket::from_raw_socket(end, Role::Client, None))
    }

    /// Of `count` messages the numbers of those for which there was room.
    fn push(client: &mut Client, count: u32, now: Instant) -> Vec<u32> {
        let mut taken = Vec::new();
        for number in 0..count {
            let content = [&number.to_le_bytes()[..], &[7; 996]].concat();
            if client.push(Message::binary(content)) {
                taken.push(number);
            }
            client.write(now, &mut Vec::new());
        }
        taken
    }

    #[test]
    fn one_that_takes_nothing_keeps_so_much_and_is_closed_in_time() {
        let now = Instant::now();
        let (mut client, _end) = connected(now);
        let taken = push(&mut client, 5000, now);
        assert_eq!(taken.len() as u64 + client.dropped, 5000);
        assert!(client.dropped > 2000, "{} dropped", client.dropped);
        assert!(client.queued_bytes <= QUEUE_BYTES, "{} bytes", client.queued_bytes);
        let dropped = client.dropped;
        for _ in 0..3 {
            client.push_snapshot(|_| Utf8Bytes::from_static("{}"));
            client.write(now, &mut Vec::new());
        }
        assert_eq!(client.dropped, dropped + 2, "all but the newest snapshot");
        client.expire(now + DEAD_AFTER);
        assert!(!client.is_over());
        client.expire(now + DEAD_AFTER + Duration::from_millis(1));
        assert!(client.is_over() && client.queued_bytes == 0);
    }

    #[test]
    fn one_that_was_slow_gets_what_there_was_room_for_and_stays() {
        let now = Instant::now();
        let (mut client, mut end) = connected(now);
        let mut taken = push(&mut client, 3000, now);
        let reader = std::thread::spawn(move || {
            let numbers = std::iter::from_fn(|| match end.read() {
                Ok(Message::Binary(bytes)) => {
                    Some(u32::from_le_bytes(*bytes.first_chunk().expect("a number")))
                }
                _ => None,
            });
            numbers.collect::<Vec<u32>>()
        });
        while client.wants_to_write() {
            client.write(now, &mut Vec::new());
        }
        client.expire(now + 2 * DEAD_AFTER);
        assert!(!client.is_over(), "nothing waits for it");
        taken.extend(push(&mut client, 10, now));
        while client.wants_to_write() {
            client.write(now, &mut Vec::new());
        }
        client.close();
        assert_eq!(reader.join().expect("it reads"), taken);
    }
}
