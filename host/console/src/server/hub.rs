//! What a server does at one look: takes in what its source says and what clients ask for, and answers.

use std::collections::HashMap;
use std::net::TcpListener;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::Message;

use super::super::access::Access;
use super::super::client::{Came, Client};
use super::super::command::{self, Command, Playing};
use super::super::desk::{Ask, Wanted};
use super::super::http::{self, Speaks};
use super::super::stream::{self, Asked};
use super::super::tap::Channel;
use super::super::view::{Can, Stage};
use super::Source;
use super::audience::Audience;
use super::session::Session;

/// Time between two snapshots: 20 a second.
const SNAPSHOT_EVERY: Duration = Duration::from_millis(50);
/// Connections at a time.
const CLIENTS: usize = 64;
/// Connections that are taken in at one look.
const ACCEPT_AT_ONCE: usize = 16;
/// Sending ends a look after this time, and goes on at the next one: what the scheduler lets the server run through is time that the loop
/// may wait for its core. *Assumed.*
const SEND_AT_ONCE: Duration = Duration::from_micros(200);
/// What one is told that has not shown the token.
const LOOKS: &str = "this page only looks: open the address that the program printed";
/// The same, of the stream.
const STREAM_LOOKS: &str = "without the token in the address (?token=…) this connection only looks";

/// See the module's documentation.
pub(super) struct Hub {
    access: Access,
    source: Source,
    audience: Audience,
    /// By number.
    channels: HashMap<u16, Channel>,
    next_id: u32,
    due: Instant,
    number: u64,
    staged: bool,
    /// The client that is sent to next.
    next: usize,
    /// Tells this run from others.
    session: String,
    came: Vec<Came>,
}

impl Hub {
    pub(super) fn new(access: Access, source: Source, stage: Box<Stage>, now: Instant) -> Self {
        let mut hub = Self {
            session: format!("{}-{}", std::process::id(), access.address),
            access,
            source,
            audience: Audience::new(stage),
            channels: HashMap::new(),
            next_id: 1,
            due: now,
            number: 0,
            staged: false,
            next: 0,
            came: Vec::new(),
        };
        if let Source::Log(player) = &hub.source {
            let all = player.channels().iter().map(|channel| (channel.id, channel.clone()));
            hub.channels.extend(all);
        }
        hub
    }

    /// Its clients.
    pub(super) fn clients(&self) -> impl Iterator<Item = &Client> {
        self.audience.sessions.iter().map(|session| &session.client)
    }

    /// Whether something waits for a client to take it.
    pub(super) fn has_left(&self) -> bool {
        self.clients().any(Client::wants_to_write)
    }

    fn can(&self) -> Can {
        match self.source {
            Source::Run { steer, .. } => Can { order: true, steer, play: false },
            Source::Log(_) => Can { play: true, ..Can::default() },
        }
    }

    /// Takes in new connections. Where there is no room, the oldest one that only looks gives way.
    pub(super) fn accept(&mut self, listener: &TcpListener, now: Instant) {
        for _ in 0..ACCEPT_AT_ONCE {
            let Ok((stream, peer)) = listener.accept() else { return };
            if stream.set_nonblocking(true).is_err() {
                continue;
            }
            // Snapshots are for now.
            let _ = stream.set_nodelay(true);
            if self.audience.sessions.len() >= CLIENTS {
                match self.audience.sessions.iter_mut().find(|session| !session.client.trusted) {
                    Some(oldest) => oldest.client.close(),
                    None => {
                        let _ = std::io::Write::write(&mut &stream, &http::full());
                        continue;
                    }
                }
                self.sweep();
            }
            self.audience.sessions.push(Session::new(Client::new(self.next_id, peer, stream, now)));
            self.next_id = self.next_id.wrapping_add(1).max(1);
        }
    }

    /// Takes in what clients say.
    pub(super) fn read(&mut self, now: Instant) {
        for index in 0..self.audience.sessions.len() {
            let mut came = std::mem::take(&mut self.came);
            if let Some(session) = self.audience.sessions.get_mut(index) {
                session.client.read(&self.access, now, &mut came);
            }
            came.drain(..).for_each(|came| self.handle(index, came, now));
            self.came = came;
        }
    }

    /// Sends what they take, to one after the other for [`SEND_AT_ONCE`]; forgets those that are gone.
    fn write(&mut self, now: Instant) {
        let (began, clients) = (Instant::now(), self.audience.sessions.len());
        for _ in 0..clients {
            let index = self.next % clients;
            self.next = index + 1;
            let mut came = std::mem::take(&mut self.came);
            if let Some(session) = self.audience.sessions.get_mut(index) {
                session.client.write(now, &mut came);
                session.look(now);
            }
            let opened = !came.is_empty();
            came.drain(..).for_each(|came| self.handle(index, came, now));
            self.came = came;
            if let Some(session) = self.audience.sessions.get_mut(index).filter(|_| opened) {
                session.client.write(now, &mut Vec::new());
            }
            if began.elapsed() >= SEND_AT_ONCE {
                break;
            }
        }
        self.sweep();
    }

    /// A page that is gone lets go of its velocity.
    fn sweep(&mut self) {
        let Self { audience, source, .. } = self;
        audience.sessions.retain_mut(|session| {
            let over = session.client.is_over();
            if over
                && session.steers
                && let Source::Run { counter, .. } = source
            {
                // Where there is no room for it, the deadman ends it as soon.
                let _ = counter.ask(session.ask(0, Wanted::LetGo("the page is gone")));
            }
            !over
        });
    }

    /// What is due at `now`: what the source says goes to those that follow it.
    pub(super) fn look(&mut self, now: Instant) {
        self.feed(now);
        self.answer();
        self.tell_fresh();
        if self.due <= now {
            // One that was missed is not made up for.
            self.due += SNAPSHOT_EVERY;
            if self.due <= now {
                self.due = now + SNAPSHOT_EVERY;
            }
            self.snapshot(now);
        }
        self.write(now);
    }

    /// The source has ended: clients are told all of it, and that it was the last.
    pub(super) fn finish(&mut self, now: Instant) {
        self.due = now;
        self.look(now);
        for session in &mut self.audience.sessions {
            session.bid_farewell();
        }
        self.write(now);
    }

    fn feed(&mut self, now: Instant) {
        let Self { source, audience, channels, .. } = self;
        match source {
            Source::Run { live, .. } => {
                while let Some(message) = live.message() {
                    if !channels.contains_key(&message.channel) {
                        let new = live.new_channels();
                        audience.announce(&new);
                        channels.extend(new.into_iter().map(|channel| (channel.id, channel)));
                    }
                    if let Some(channel) = channels.get(&message.channel) {
                        audience.take(channel, message.at_ns, &message.data);
                    }
                }
            }
            Source::Log(player) => {
                player.advance(now, |told| audience.take(told.channel, told.at_ns, told.data));
            }
        }
        if !self.staged && self.audience.view.is_set() {
            self.staged = true;
            let scene = self.audience.view.scene(self.can());
            self.audience.tell_pages(&scene);
        }
    }

    fn answer(&mut self) {
        let Self { source: Source::Run { counter, .. }, audience, .. } = self else { return };
        while let Some(answer) = counter.answer() {
            let asker =
                audience.sessions.iter_mut().find(|session| session.client.id == answer.ticket.client);
            asker.into_iter().for_each(|session| session.answer(&answer));
        }
    }

    fn tell_fresh(&mut self) {
        for value in self.audience.view.fresh() {
            self.audience.tell_pages(&value);
        }
    }

    fn snapshot(&mut self, now: Instant) {
        self.number += 1;
        let pages = self.clients().filter(|client| client.speaks() == Some(Speaks::Console)).count();
        if pages == 0 {
            return;
        }
        let mut snapshot = self.audience.view.snapshot(self.number);
        let (play, lost) = match &self.source {
            Source::Run { live, .. } => (Value::Null, live.lost()),
            Source::Log(player) => (player.show(now), 0),
        };
        if let Value::Object(object) = &mut snapshot {
            object.insert("play".to_owned(), play);
            object.insert("lost".to_owned(), json!(lost));
            object.insert("clients".to_owned(), json!(self.audience.sessions.len()));
        }
        let text = snapshot.to_string();
        self.audience.of(Speaks::Console).for_each(|session| session.push_snapshot(&text));
    }

    fn handle(&mut self, index: usize, came: Came, now: Instant) {
        match came {
            Came::Opened(Speaks::Console) => {
                let (can, view) = (self.can(), &mut self.audience.view);
                let messages = [view.scene(can), view.history()];
                let messages = messages.map(|value| Message::text(value.to_string()));
                self.audience.tell(index, messages);
            }
            Came::Opened(Speaks::Stream) => {
                let mut messages = stream::hello("flotilla", &self.session, self.can().order);
                messages.push(stream::advertise(self.channels.values()));
                self.audience.tell(index, messages);
            }
            Came::Text(text) => match self.speaks(index) {
                Some(Speaks::Console) => self.command(index, &text, now),
                Some(Speaks::Stream) => {
                    let asked =
                        self.audience.sessions.get_mut(index).map(|session| session.subscriber.text(&text));
                    asked.into_iter().for_each(|asked| self.asked(index, asked));
                }
                None => {}
            },
            Came::Binary(bytes) => {
                let Some(session) = self.audience.sessions.get_mut(index) else { return };
                if session.client.speaks() == Some(Speaks::Stream) {
                    let asked = session.subscriber.binary(&bytes);
                    self.asked(index, asked);
                } else {
                    session.client.close();
                }
            }
        }
    }

    fn speaks(&self, index: usize) -> Option<Speaks> {
        self.audience.sessions.get(index).and_then(|session| session.client.speaks())
    }

    /// What a page asks for.
    fn command(&mut self, index: usize, text: &str, now: Instant) {
        let Some(session) = self.audience.sessions.get_mut(index) else { return };
        let (id, command) = command::read(text);
        let id = id.unwrap_or(0);
        let outcome = match command {
            Err(why) => Err(why),
            Ok(Command::Hello(_)) if session.is_suspect() => return,
            Ok(Command::Hello(token)) if self.access.token.is(&token) => {
                session.client.trusted = true;
                Ok("orders of this page are followed".to_owned())
            }
            Ok(Command::Hello(_)) => return session.suspect(id, now),
            Ok(_) if !session.client.trusted => Err(LOOKS.to_owned()),
            Ok(Command::Play(playing)) => self.play(playing, now),
            Ok(Command::Run(wanted)) => {
                let ask = session.ask(id, wanted);
                match self.put(ask) {
                    Ok(()) => return,
                    Err(why) => Err(why),
                }
            }
        };
        if let Some(session) = self.audience.sessions.get_mut(index) {
            session.say(id, &outcome);
        }
    }

    /// Hands an ask to the loop.
    fn put(&self, ask: Ask) -> Result<(), String> {
        match &self.source {
            Source::Log(_) => Err("a log takes no orders".to_owned()),
            Source::Run { counter, .. } if counter.ask(ask) => Ok(()),
            Source::Run { .. } => Err("the run takes no more orders at the moment, or is over".to_owned()),
        }
    }

    fn play(&mut self, playing: Playing, now: Instant) -> Result<String, String> {
        let Source::Log(player) = &mut self.source else {
            return Err("a run that is going on cannot be played".to_owned());
        };
        if player.ask(playing, now)? {
            self.audience.begin_again(player, now);
        }
        Ok("done".to_owned())
    }

    /// What a client of the stream asks for.
    fn asked(&mut self, index: usize, asked: Asked) {
        let trusted = self.audience.sessions.get(index).is_some_and(|session| session.client.trusted);
        let parameters = |hub: &Self, id: Option<&str>| stream::parameters(hub.audience.view.goal(), id);
        match asked {
            Asked::Nothing => {}
            Asked::Refused(why) => self.audience.tell(index, [stream::status(2, &why)]),
            Asked::Subscribed(channels) => self.audience.catch_up(index, &channels),
            Asked::Parameters(id) => {
                let values = parameters(self, id.as_deref());
                self.audience.tell(index, [values]);
            }
            Asked::Set(..) if !trusted => self.audience.tell(index, [stream::status(2, STREAM_LOOKS)]),
            Asked::Call(_, call) if !trusted => {
                self.audience.tell(index, [stream::failure(&call, STREAM_LOOKS)]);
            }
            Asked::Set(wanted, id) => {
                for wanted in wanted {
                    if let Err(why) = self.put_by_call(index, wanted, None) {
                        self.audience.tell(index, [stream::status(2, &why)]);
                    }
                }
                let values = id.map(|id| parameters(self, Some(&id)));
                self.audience.tell(index, values);
            }
            Asked::Call(wanted, call) => {
                if let Err(why) = self.put_by_call(index, wanted, Some(call.clone())) {
                    self.audience.tell(index, [stream::failure(&call, &why)]);
                }
            }
        }
    }

    fn put_by_call(
        &mut self,
        index: usize,
        wanted: Wanted,
        call: Option<stream::Call>,
    ) -> Result<(), String> {
        let session = self.audience.sessions.get_mut(index);
        let ask = session.and_then(|session| session.ask_by_call(wanted, call));
        ask.map_or_else(|| Err("too many at once".to_owned()), |ask| self.put(ask))
    }
}
