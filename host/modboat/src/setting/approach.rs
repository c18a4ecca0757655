//! The way from where the tails are to where a cycle starts.

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
    /// True if nothing moves.
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

    /// Its steps as segments: each module's pose before and after.
    pub(super) fn steps(&self) -> Vec<Vec<Turn>> {
        let Some(via) = &self.via_rad else { return vec![self.turns.clone()] };
        let first =
            self.turns.iter().zip(via).map(|(turn, &via)| Turn { from_rad: turn.from_rad, to_rad: via });
        let second =
            self.turns.iter().zip(via).map(|(turn, &via)| Turn { from_rad: via, to_rad: turn.to_rad });
        vec![first.collect(), second.collect()]
    }
}
