//! Motion of the tails from their present angles to the start of a cycle.

use crate::motion::{StepTime, Turn};
use crate::transition::STILL_RAD;

/// How the tails get from where they are to the start of a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Approach {
    /// Each module's rotation.
    pub turns: Vec<Turn>,
    /// Where the tails are between its two steps, if it has two.
    pub via_rad: Option<Vec<f64>>,
    /// How long each step takes, and each of its ramps; the second counts only if there are two.
    pub times: [StepTime; 2],
    /// It turns slowly, out of a place too narrow for the usual tube.
    pub slow: bool,
}

impl Approach {
    /// True if no tail moves in it.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.via_rad.is_none() && self.turns.iter().all(|turn| turn.rotation_rad().abs() < STILL_RAD)
    }

    /// How long it takes, s: both steps of it where it has two, zero where nothing moves.
    #[must_use]
    pub fn transition_s(&self) -> f64 {
        let [first, second] = self.times;
        match &self.via_rad {
            Some(_) => first.duration_s + second.duration_s,
            None if self.is_still() => 0.0,
            None => first.duration_s,
        }
    }

    /// Σ |rotation|, over both steps where there are two, rad.
    #[must_use]
    pub fn travel_rad(&self) -> f64 {
        let via = |module: usize, turn: &Turn| self.via_rad.as_ref().map_or(turn.from_rad, |via| via[module]);
        self.turns
            .iter()
            .enumerate()
            .map(|(module, turn)| {
                let via_rad = via(module, turn);
                (via_rad - turn.from_rad).abs() + (turn.to_rad - via_rad).abs()
            })
            .sum()
    }

    /// Its steps.
    pub(crate) fn steps(&self) -> Steps<'_> {
        Steps { turns: &self.turns, via_rad: self.via_rad.as_deref() }
    }
}

/// The steps of a transition; none by default.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steps<'a> {
    pub(crate) turns: &'a [Turn],
    /// Where the tails are between its two steps, if it has two.
    pub(crate) via_rad: Option<&'a [f64]>,
}

impl<'a> Steps<'a> {
    /// One after another.
    pub(crate) fn iter(self) -> impl DoubleEndedIterator<Item = Step<'a>> {
        let first = (!self.turns.is_empty()).then_some(Step { steps: self, second: false });
        let second = self.via_rad.map(|_| Step { steps: self, second: true });
        first.into_iter().chain(second)
    }
}

/// One step as segments: each module's pose before and after.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step<'a> {
    steps: Steps<'a>,
    second: bool,
}

impl Step<'_> {
    /// That of one module.
    pub(crate) fn turn(self, module: usize) -> Turn {
        let Turn { from_rad, to_rad } = self.steps.turns[module];
        match self.steps.via_rad.map(|via_rad| via_rad[module]) {
            None => Turn { from_rad, to_rad },
            Some(via_rad) if self.second => Turn { from_rad: via_rad, to_rad },
            Some(via_rad) => Turn { from_rad, to_rad: via_rad },
        }
    }
}
