//! From the closed loop to the server: every message of the log, copied into a queue that never makes the loop wait.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

/// Messages that may wait for the server: 25 modules make about 200 a second. *Assumed.*
const QUEUE: usize = 4096;

/// A topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its number.
    pub id: u16,
    /// Its name.
    pub topic: String,
    /// Name of its type.
    pub schema: String,
    /// Definition of its type, as `ros2msg`.
    pub definition: String,
}

/// A message of a topic.
#[derive(Clone, Debug)]
pub struct Message {
    /// Number of its topic.
    pub channel: u16,
    /// Fleet time, ns.
    pub at_ns: u64,
    /// CDR.
    pub data: Box<[u8]>,
}

#[derive(Default)]
struct Shared {
    channels: Mutex<Vec<Channel>>,
    lost: AtomicU64,
}

/// The loop's end.
pub struct Tap {
    sender: SyncSender<Message>,
    shared: Arc<Shared>,
}

/// The server's end.
pub struct Live {
    receiver: Receiver<Message>,
    shared: Arc<Shared>,
    known: usize,
}

/// Both ends.
#[must_use]
pub fn tap() -> (Tap, Live) {
    let (sender, receiver) = sync_channel(QUEUE);
    let shared = Arc::new(Shared::default());
    (Tap { sender, shared: Arc::clone(&shared) }, Live { receiver, shared, known: 0 })
}

impl runlog::writer::Tap for Tap {
    fn topic(&mut self, id: u16, name: &str, schema: &'static str, definition: String) {
        let channel = Channel { id, topic: name.to_owned(), schema: schema.to_owned(), definition };
        self.shared.channels.lock().unwrap_or_else(PoisonError::into_inner).push(channel);
    }

    fn message(&mut self, channel: u16, at_ns: u64, data: &[u8]) {
        if self.sender.try_send(Message { channel, at_ns, data: data.into() }).is_err() {
            self.shared.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Live {
    /// The next message, if one has come.
    pub fn message(&mut self) -> Option<Message> {
        self.receiver.try_recv().ok()
    }

    /// Topics that are new since the last call. A topic is known before its first message comes.
    pub fn new_channels(&mut self) -> Vec<Channel> {
        let channels = self.shared.channels.lock().unwrap_or_else(PoisonError::into_inner);
        let new = channels.get(self.known..).unwrap_or_default().to_vec();
        self.known = channels.len();
        new
    }

    /// Messages that found no room.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use runlog::writer::Tap as _;

    use super::*;

    #[test]
    fn what_finds_no_room_is_counted_and_the_loop_goes_on() {
        let (mut tap, mut live) = tap();
        tap.topic(1, "/event", "flotilla_msgs/msg/Event", String::new());
        for at_ns in 0..QUEUE as u64 + 7 {
            tap.message(1, at_ns, &[0, 1, 0, 0]);
        }
        assert_eq!((live.new_channels().len(), live.new_channels().len(), live.lost()), (1, 0, 7));
        let came: Vec<u64> = std::iter::from_fn(|| live.message()).map(|message| message.at_ns).collect();
        assert_eq!(came.len(), QUEUE);
        assert!(came.is_sorted());
        drop(live);
        tap.message(1, 0, &[]);
    }
}
