//! Frames of a motion capture as they come, and in words why they show nothing.
//!
//! A frame that comes again, or late, is no trouble. One frame that cannot be used is none either: only several in a row are told.

use pose::axes::Axes;
use pose::feed::{Event, Feed};
use pose::gate::{Fix, Gate, Limits};
use pose::ledger::FrameFault;
use pose::source::{Link, Source, Status};
use pose::time::HostInstant;
use protocol::time::{Duration, FleetInstant};

use super::RunError;
use super::pose_source::PoseAccount;

/// Frames that are not used in a row after which it is said why. *Assumed*: a tenth of a second at 100 Hz.
const SAID_AFTER: u32 = 10;
/// Without a frame for this time the connection is looked at. *Assumed.*
const SILENT: Duration = Duration(500_000);

/// Why frames show nothing, if several in a row do not.
#[derive(Debug, Default)]
pub(super) struct Doubt {
    unused: u32,
    trouble: Option<String>,
}

impl Doubt {
    /// Takes a frame; whether `show` could use it, which says why if not.
    pub(super) fn judge(&mut self, event: Event, show: impl FnOnce(&Fix) -> Result<(), String>) -> bool {
        let shown = match event {
            Event::Fix(fix) => show(&fix),
            Event::Dropped(FrameFault::Doubled | FrameFault::OutOfOrder) => return false,
            Event::Dropped(fault) => Err(worded(fault).to_owned()),
        };
        let Err(trouble) = shown else {
            *self = Self::default();
            return true;
        };
        self.unused += 1;
        if self.unused >= SAID_AFTER {
            self.trouble = Some(trouble);
        }
        false
    }

    /// In words.
    pub(super) fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }
}

/// See the module's documentation.
pub(super) struct Stream {
    name: String,
    feed: Feed,
    /// When the last frame came.
    came: Option<FleetInstant>,
    doubt: Doubt,
}

impl Stream {
    /// The frames of `source`, in a laboratory with these axes.
    pub(super) fn new(name: String, source: Box<dyn Source>, axes: Axes) -> Self {
        let feed = Feed::new(source, Gate::new(axes, Limits::default()));
        Self { name, feed, came: None, doubt: Doubt::default() }
    }

    /// Hands every frame that has come by `now` to `show`, which says why it cannot be used; whether one could.
    ///
    /// # Errors
    /// [`RunError::Pose`], for what waiting does not mend.
    pub(super) fn poll(
        &mut self,
        now: FleetInstant,
        mut show: impl FnMut(&Feed, &Fix) -> Result<(), String>,
    ) -> Result<bool, RunError> {
        let Self { name, feed, came, doubt } = self;
        let at = HostInstant(std::time::Duration::from_micros(now.0));
        let mut is_new = false;
        while let Some(event) = feed.poll(at).map_err(|error| RunError::Pose(error.to_string()))? {
            *came = Some(now);
            is_new |= doubt.judge(event, |fix| show(feed, fix));
        }
        if came.is_none_or(|came| now.since(came) > SILENT) {
            doubt.trouble = Some(silence(name, feed.status()));
        }
        Ok(is_new)
    }

    /// Why there are no poses, in words.
    pub(super) fn trouble(&self) -> Option<&str> {
        self.doubt.trouble()
    }

    /// What came of it.
    pub(super) fn account(&self) -> PoseAccount {
        let (feed, clock) = (&self.feed, self.feed.gate().clock());
        PoseAccount {
            source: self.name.clone(),
            ledger: *feed.ledger(),
            connects: feed.status().connects,
            clock_jumps: clock.jumps(),
            least_delay_s: clock.least_delay_s(),
            late_p50_s: feed.figures().late_s(0.5),
            late_p99_s: feed.figures().late_s(0.99),
        }
    }
}

const fn worded(fault: FrameFault) -> &'static str {
    match fault {
        FrameFault::Doubled => "frames come twice",
        FrameFault::OffTheClock => "the server's clock has jumped",
        FrameFault::OutOfOrder => "frames are older than the newest",
        FrameFault::Frozen => "the stream is frozen: no body moves in the last digit",
        FrameFault::WithoutBody => "no body is tracked",
    }
}

/// How a motion capture stands that sends no frames.
fn silence(name: &str, status: &Status) -> String {
    let stands = match status.link {
        Link::Connecting => "there is no answer from it",
        Link::Connected | Link::Streaming => "it is connected, and no frames come",
    };
    let trouble = status.trouble.as_ref().map_or_else(String::new, |trouble| format!(" ({trouble})"));
    format!("{name}: {stands}{trouble}")
}
