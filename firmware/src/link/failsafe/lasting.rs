//! A condition that counts once it has lasted for long enough without a break.

use protocol::time::{Duration, LocalInstant};

/// Time without a believable reading of the encoder after which the module stops, *assumed*. Until then the tail coasts
/// and goes on when it sees again.
pub const BLIND_FOR: Duration = Duration(100_000);

/// Time after which an output that fails is taken for broken. *Assumed.*
pub const OUTPUT_FAILS_FOR: Duration = Duration(100_000);

/// Since when something is the case. Time is the module's own, which never steps back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Lasting {
    since: Option<LocalInstant>,
}

impl Lasting {
    /// Nothing has been the case yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { since: None }
    }

    /// Whether it is the case now and has been since `hold_off` ago.
    pub fn update(&mut self, now: LocalInstant, is: bool, hold_off: Duration) -> bool {
        if !is {
            self.since = None;
            return false;
        }
        now.since(*self.since.get_or_insert(now)) >= hold_off
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_break_restarts_it() {
        let mut lasting = Lasting::new();
        let mut update = |now, is| lasting.update(LocalInstant(now), is, Duration(100));
        assert!(!update(0, false) && !update(1000, true) && !update(1099, true));
        assert!(update(1100, true) && update(5000, true));
        assert!(!update(5001, false) && !update(5002, true) && !update(5101, true) && update(5102, true));
    }

    #[test]
    fn without_a_hold_off_it_is_at_once() {
        assert!(Lasting::new().update(LocalInstant(0), true, Duration(0)));
        assert!(!Lasting::new().update(LocalInstant(0), false, Duration(0)));
    }

    #[test]
    fn the_longest_hold_off_ends() {
        let mut lasting = Lasting::new();
        assert!(!lasting.update(LocalInstant(0), true, Duration(u32::MAX)));
        assert!(lasting.update(LocalInstant(u64::MAX), true, Duration(u32::MAX)));
    }
}
