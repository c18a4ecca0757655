//! All clients of a server, and what is shown to them.

use std::collections::HashMap;
use std::time::Instant;

use serde_json::Value;
use tungstenite::Message;

use super::super::http::Speaks;
use super::super::player::Player;
use super::super::stream;
use super::super::tap::Channel;
use super::super::view::{Stage, View};
use super::session::Session;

/// On the way to another place in a log all messages of this time before it are looked at, ns.
const SETTLES_NS: u64 = 2_000_000_000;

/// See the module's documentation.
pub(super) struct Audience {
    pub(super) sessions: Vec<Session>,
    pub(super) view: View,
    stage: Box<Stage>,
    /// By number of its topic, the newest message: a new subscriber begins with it.
    retained: HashMap<u16, (u64, Vec<u8>)>,
}

impl Audience {
    pub(super) fn new(stage: Box<Stage>) -> Self {
        let (sessions, view, retained) = (Vec::new(), View::default(), HashMap::new());
        Self { sessions, view, stage, retained }
    }

    /// Takes in a message, and passes it on to those that follow its topic.
    pub(super) fn take(&mut self, channel: &Channel, at_ns: u64, data: &[u8]) {
        self.view.take(&channel.topic, at_ns, data, self.stage.as_ref());
        let (retained_ns, retained) = self.retained.entry(channel.id).or_default();
        *retained_ns = at_ns;
        retained.clear();
        retained.extend_from_slice(data);
        let mut encoded = Encoded::default();
        for session in self.of(Speaks::Stream) {
            pass_on(session, channel.id, at_ns, data, &mut encoded);
        }
        if channel.topic == "/goal" {
            let values = stream::parameters(self.view.goal(), None);
            let following = |session: &&mut Session| session.subscriber.follows_parameters;
            self.of(Speaks::Stream).filter(following).for_each(|session| session.push(values.clone()));
        }
    }

    /// Everything is told again, up to where `player` is at `now`.
    pub(super) fn begin_again(&mut self, player: &mut Player, now: Instant) {
        let (mut view, stage) = (View::default(), self.stage.as_ref());
        let at_ns = player.at_ns(now);
        player.until_now(now, |told| {
            let topic = &told.channel.topic;
            if View::is_lasting(topic) || told.at_ns.saturating_add(SETTLES_NS) >= at_ns {
                view.take(topic, told.at_ns, told.data, stage);
            }
        });
        self.view = view;
        let history = Message::text(self.view.history().to_string());
        self.of(Speaks::Console).for_each(|session| session.push(history.clone()));
    }

    /// Those that speak so.
    pub(super) fn of(&mut self, speaks: Speaks) -> impl Iterator<Item = &mut Session> {
        self.sessions.iter_mut().filter(move |session| session.client.speaks() == Some(speaks))
    }

    /// Tells all pages.
    pub(super) fn tell_pages(&mut self, value: &Value) {
        let message = Message::text(value.to_string());
        self.of(Speaks::Console).for_each(|session| session.push(message.clone()));
    }

    /// Tells clients of the stream that topics are new.
    pub(super) fn announce(&mut self, new: &[Channel]) {
        if !new.is_empty() {
            let message = stream::advertise(new);
            self.of(Speaks::Stream).for_each(|session| session.push(message.clone()));
        }
    }

    /// Tells one client.
    pub(super) fn tell(&mut self, index: usize, messages: impl IntoIterator<Item = Message>) {
        if let Some(session) = self.sessions.get_mut(index) {
            messages.into_iter().for_each(|message| session.push(message));
        }
    }

    /// The newest of those topics goes to a client to which they are new: some are told once.
    pub(super) fn catch_up(&mut self, index: usize, channels: &[u16]) {
        let Some(session) = self.sessions.get_mut(index) else { return };
        for channel in channels {
            if let Some((at_ns, data)) = self.retained.get(channel) {
                pass_on(session, *channel, *at_ns, data, &mut Encoded::default());
            }
        }
    }
}

/// A message as it was sent last, with the number of the subscription: clients number alike, and the bytes are shared.
type Encoded = Option<(u32, Message)>;

fn pass_on(session: &mut Session, channel: u16, at_ns: u64, data: &[u8], encoded: &mut Encoded) {
    let Session { client, subscriber, .. } = session;
    for subscription in subscriber.to(channel) {
        if encoded.as_ref().is_none_or(|(known, _)| *known != subscription) {
            *encoded = Some((subscription, stream::data(subscription, at_ns, data)));
        }
        encoded.iter().for_each(|(_, message)| {
            client.push(message.clone());
        });
    }
}
