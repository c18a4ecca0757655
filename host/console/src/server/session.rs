//! One client of a server: its connection, what it follows, and what it waits for.

use std::time::{Duration, Instant};

use tungstenite::protocol::CloseFrame;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::{Message, Utf8Bytes};

use super::super::client::Client;
use super::super::desk::{Answer, Ask, Ticket, Wanted};
use super::super::http::Speaks;
use super::super::stream::{self, Call, Subscriber};

/// A wrong token is answered after this time.
const WRONG_AFTER: Duration = Duration::from_secs(1);
/// Calls that may wait for an answer.
const CALLS: usize = 64;

/// See the module's documentation.
pub(super) struct Session {
    pub(super) client: Client,
    pub(super) subscriber: Subscriber,
    /// Asks that wait for an answer, with the call that it goes to; none where parameters were set.
    awaited: Vec<(u32, Option<Call>)>,
    next_ticket: u32,
    /// Of a wrong token: when it is answered, and the number of the ask.
    wrong: Option<(Instant, u32)>,
    /// Drops that a client of the stream was told of.
    told_dropped: u64,
    /// It has asked for a velocity.
    pub(super) steers: bool,
}

impl Session {
    pub(super) fn new(client: Client) -> Self {
        Self {
            client,
            subscriber: Subscriber::default(),
            awaited: Vec::new(),
            next_ticket: 1,
            wrong: None,
            told_dropped: 0,
            steers: false,
        }
    }

    /// Who it is, for the log.
    pub(super) fn name(&self) -> String {
        let what = if self.client.speaks() == Some(Speaks::Stream) { "stream" } else { "page" };
        format!("{what} at {}", self.client.peer)
    }

    /// An ask of it.
    pub(super) fn ask(&mut self, id: u32, wanted: Wanted) -> Ask {
        self.steers |= matches!(wanted, Wanted::Velocity(..));
        Ask { ticket: Ticket { client: self.client.id, id }, by: self.name(), wanted }
    }

    /// An ask that is answered by a call's response; `None` where too many wait.
    pub(super) fn ask_by_call(&mut self, wanted: Wanted, call: Option<Call>) -> Option<Ask> {
        if self.awaited.len() >= CALLS {
            return None;
        }
        let ticket = self.next_ticket;
        self.next_ticket = self.next_ticket.wrapping_add(1);
        self.awaited.push((ticket, call));
        Some(self.ask(ticket, wanted))
    }

    /// What came of an ask, said as its protocol has it.
    pub(super) fn answer(&mut self, Answer { ticket, outcome }: &Answer) {
        if self.client.speaks() != Some(Speaks::Stream) {
            return self.say(ticket.id, outcome);
        }
        let Some(place) = self.awaited.iter().position(|(id, _)| *id == ticket.id) else { return };
        match (self.awaited.swap_remove(place).1, outcome) {
            (Some(call), outcome) => self.push(stream::response(&call, outcome)),
            (None, Err(why)) => self.push(stream::status(1, why)),
            (None, Ok(_)) => {}
        }
    }

    /// An answer to a page.
    pub(super) fn say(&mut self, id: u32, outcome: &Result<String, String>) {
        let (ok, text) = match outcome {
            Ok(text) => (true, text),
            Err(text) => (false, text),
        };
        self.push(Message::text(
            serde_json::json!({ "kind": "answer", "id": id, "ok": ok, "text": text }).to_string(),
        ));
    }

    /// A wrong token has come at `now`.
    pub(super) fn suspect(&mut self, id: u32, now: Instant) {
        self.wrong.get_or_insert((now + WRONG_AFTER, id));
    }

    /// Whether its last token was wrong, and it does not know yet.
    pub(super) fn is_suspect(&self) -> bool {
        self.wrong.is_some()
    }

    /// What is due at `now`.
    pub(super) fn look(&mut self, now: Instant) {
        if let Some((_, id)) = self.wrong.take_if(|(due, _)| *due <= now) {
            self.say(id, &Err("this is not the token: open the address that the program printed".to_owned()));
        }
        if self.client.speaks() == Some(Speaks::Stream)
            && self.client.dropped > self.told_dropped
            && !self.client.wants_to_write()
        {
            let dropped = self.client.dropped;
            self.told_dropped = dropped;
            self.push(stream::status(
                1,
                &format!("{dropped} messages were dropped so far: this client is too slow"),
            ));
        }
        self.client.expire(now);
    }

    /// The last message: that the server goes.
    pub(super) fn bid_farewell(&mut self) {
        self.client.flush_snapshot();
        let (code, reason) = (CloseCode::Away, Utf8Bytes::from_static("the run is over"));
        self.push(Message::Close(Some(CloseFrame { code, reason })));
    }

    pub(super) fn push(&mut self, message: Message) {
        self.client.push(message);
    }

    /// A snapshot with what it alone is told. `text` is a JSON object.
    pub(super) fn push_snapshot(&mut self, text: &str) {
        let body = text.strip_suffix('}').unwrap_or(text);
        self.client.push_snapshot(|dropped| Utf8Bytes::from(format!("{body},\"dropped\":{dropped}}}")));
    }
}
