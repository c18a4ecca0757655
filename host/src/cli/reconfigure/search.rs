//! What the search for an order needs of this computer: a clock, and a place to tell how far it has come.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use reconfiguration::plan::Criterion;
use rov::morphology::{GoalProgress, Search, TRIED};
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

/// The same of the search for a goal. Half of the time at most is for growing configurations.
pub(super) struct GoalWatch<'a> {
    bar: &'a mut Bar,
    began: Instant,
    limit: Duration,
    looked: Instant,
    told: Instant,
    terminal: bool,
}

impl<'a> GoalWatch<'a> {
    pub(super) fn new(bar: &'a mut Bar, limit: Duration) -> Self {
        let now = Instant::now();
        Self { bar, began: now, limit, looked: now, told: now, terminal: std::io::stderr().is_terminal() }
    }
}

impl GoalProgress for GoalWatch<'_> {
    fn report(&mut self, search: &Search) -> ControlFlow<()> {
        let now = Instant::now();
        let Search { placed, robots, configurations, tried, best_j, bound_j } = *search;
        let text = || match best_j {
            _ if !search.plans() => {
                format!("planning: goal: {configurations} configurations of {placed} of {robots} robots")
            }
            None => format!(
                "planning: goal: {tried} of {configurations} configurations planned for, at least {bound_j:.1} J"
            ),
            Some(best_j) => format!(
                "planning: goal: best {best_j:.1} J, at least {bound_j:.1} J, {tried} of {configurations} configurations planned for"
            ),
        };
        if self.terminal && now - self.looked >= LOOK {
            self.looked = now;
            let (done, all) = if search.plans() { (tried, TRIED) } else { (placed, robots) };
            self.bar.preparing(&text(), done as u64, all as u64);
        } else if !self.terminal && now - self.told >= LINE {
            self.told = now;
            tell(&text());
        }
        let limit = if search.plans() { self.limit } else { self.limit / 2 };
        if now - self.began >= limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
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
