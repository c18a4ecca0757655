//! A velocity lasts while it is asked for again and again, and no longer.

use std::time::{Duration, Instant};

/// A velocity that is not asked for again within this time ends. *Assumed*: three refreshes of the page, and with the time to the next
/// look of the loop well within half a second.
pub const LASTS: Duration = Duration::from_millis(300);

/// Who asks for a velocity, and since when the request is good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadman {
    held: Option<(u32, Instant)>,
}

impl Deadman {
    /// Client `client` asks for a velocity, at `now`; the newest one has it.
    pub fn refresh(&mut self, client: u32, now: Instant) {
        self.held = Some((client, now));
    }

    /// The velocity gives way to another target.
    pub fn disarm(&mut self) {
        self.held = None;
    }

    /// Client `client` lets go; whether it had the velocity.
    pub fn let_go(&mut self, client: u32) -> bool {
        let had = self.held.is_some_and(|(held, _)| held == client);
        if had {
            self.held = None;
        }
        had
    }

    /// Whether a velocity has ended at `now` because it was not asked for again; said once.
    pub fn expires(&mut self, now: Instant) -> bool {
        let over = self.held.is_some_and(|(_, since)| now.saturating_duration_since(since) > LASTS);
        if over {
            self.held = None;
        }
        over
    }

    /// Whether a velocity is in force.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.held.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_velocity_that_is_not_refreshed_ends_once() {
        let (mut deadman, began) = (Deadman::default(), Instant::now());
        let at = |ms| began + Duration::from_millis(ms);
        assert!(!deadman.expires(at(10_000)));
        for ms in [0, 100, 200, 500] {
            deadman.refresh(7, at(ms));
            assert!(!deadman.expires(at(ms + 300)));
        }
        assert!(deadman.expires(at(801)));
        assert!(!deadman.expires(at(5_000)) && !deadman.is_armed());
    }

    #[test]
    fn only_the_client_that_has_it_lets_go() {
        let (mut deadman, now) = (Deadman::default(), Instant::now());
        deadman.refresh(1, now);
        deadman.refresh(2, now);
        assert!(!deadman.let_go(1) && deadman.is_armed());
        assert!(deadman.let_go(2) && !deadman.is_armed() && !deadman.let_go(2));
        deadman.refresh(1, now);
        deadman.disarm();
        assert!(!deadman.expires(now + Duration::from_secs(1)));
    }
}
