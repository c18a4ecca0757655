//! What the search for an order needs of this computer: a clock, and a place to tell how far it has come.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use reconfiguration::plan::Criterion;
use rov::order::{Known, Progress};

use super::super::progress::Bar;
use super::super::tell;
use crate::run::progress::Progress as _;

/// Pause between two lines in a pipe, and two looks of a terminal's bar.
const LINE: Duration = Duration::from_secs(2);
const LOOK: Duration = Duration::from_millis(100);

/// Ends a search when its time is up, and shows the best order known and its bound: on a terminal as the bar, in a pipe as lines.
pub(super) struct Watch<'a> {
    bar: &'a mut Bar,
    title: &'a str,
    unit: &'static str,
    until: Instant,
    looked: Instant,
    /// Lines are for people who wait: none before the first pause is over.
    told: Instant,
    terminal: bool,
}

impl<'a> Watch<'a> {
    pub(super) fn new(bar: &'a mut Bar, title: &'a str, criterion: Criterion, limit: Duration) -> Self {
        let now = Instant::now();
        let unit = match criterion {
            Criterion::Energy => "J",
            Criterion::Euclidean => "m",
        };
        let terminal = std::io::stderr().is_terminal();
        Self { bar, title, unit, until: now + limit, looked: now, told: now, terminal }
    }
}

impl Progress for Watch<'_> {
    fn report(&mut self, known: &Known) -> ControlFlow<()> {
        let now = Instant::now();
        let Self { title, unit, .. } = *self;
        let text = || {
            let Known { bound, priced, .. } = *known;
            match (known.best, known.gap()) {
                (Some(best), Some(gap)) => format!(
                    "planning: {title}: best {best:.1} {unit}, at least {bound:.1} {unit} (within {:.1} %), {priced} \
                     moves priced",
                    100.0 * gap
                ),
                _ => format!(
                    "planning: {title}: no order yet, at least {bound:.1} {unit}, {priced} moves priced"
                ),
            }
        };
        if self.terminal && now - self.looked >= LOOK {
            self.looked = now;
            let share = known.gap().map_or(0, |gap| (1000.0 / (1.0 + gap)) as u64);
            self.bar.preparing(&text(), share, 1000);
        } else if !self.terminal && now - self.told >= LINE {
            self.told = now;
            tell(&text());
        }
        if now >= self.until { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
