//! Faults of a motion capture, in words: `KIND[:BODIES]@START[+LENGTH]`, such as `blind@20+10`, `swap:1,2@30` or `clock:3600@15`.

use std::str::FromStr;

use thiserror::Error;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mishap {
    /// No frames come.
    Blind,
    /// The server answers nothing at all.
    Dead,
    /// Frames come, and all say the same.
    Frozen,
    /// Two bodies have each other's label.
    Swapped(usize, usize),
    /// A body is not tracked.
    Lost(usize),
    /// A body drifts off.
    Away(usize),
    /// A body is where no number says.
    NotANumber(usize),
    /// The server's clock is ahead by so much more, s.
    Clock(f64),
    /// Frames take half a second longer.
    Slow,
    /// Every frame comes twice.
    Doubled,
}

/// A mishap, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What.
    pub mishap: Mishap,
    /// From when, s from the start of the cameras.
    pub at_s: f64,
    /// For how long, s; for ever if it is infinite.
    pub length_s: f64,
}

impl Fault {
    /// Whether it lasts at `now_s`.
    #[must_use]
    pub fn lasts(&self, now_s: f64) -> bool {
        (0.0..self.length_s).contains(&(now_s - self.at_s))
    }

    /// Refuses a body beyond the last of `bodies`.
    pub(super) fn check(&self, bodies: usize) -> Result<(), FaultError> {
        let named = match self.mishap {
            Mishap::Swapped(first, second) => [first, second],
            Mishap::Lost(body) | Mishap::Away(body) | Mishap::NotANumber(body) => [body; 2],
            _ => return Ok(()),
        };
        match named.iter().find(|body| **body >= bodies) {
            Some(&body) => Err(FaultError::UnknownBody { body: body + 1, bodies }),
            None => Ok(()),
        }
    }
}

/// Why it is none.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FaultError {
    /// It does not read.
    #[error("\"{0}\": a fault reads KIND[:BODIES]@START[+LENGTH], such as {EXAMPLES}")]
    Shape(String),
    /// No such kind.
    #[error("\"{given}\": no fault \"{kind}\"; there are {KINDS}")]
    Kind {
        /// The whole text.
        given: String,
        /// The word.
        kind: String,
    },
    /// A number that is none, or out of range.
    #[error("\"{given}\": \"{number}\" must be {must}")]
    Number {
        /// The whole text.
        given: String,
        /// What stands there.
        number: String,
        /// What is asked of it.
        must: &'static str,
    },
    /// A body beyond the last.
    #[error("body {body}: there are only {bodies}")]
    UnknownBody {
        /// From 1.
        body: usize,
        /// How many there are.
        bodies: usize,
    },
}

const EXAMPLES: &str = "blind@20+10, swap:1,2@30, clock:3600@15";
const KINDS: &str = "blind, dead, frozen, swap:A,B, lost:A, away:A, nan:A, clock:SECONDS, slow and doubled";

impl FromStr for Fault {
    type Err = FaultError;

    fn from_str(given: &str) -> Result<Self, FaultError> {
        let shape = || FaultError::Shape(given.to_owned());
        let (what, when) = given.split_once('@').ok_or_else(shape)?;
        let (kind, of) = what.split_once(':').map_or((what, None), |(kind, of)| (kind, Some(of)));
        let (start, length) =
            when.split_once('+').map_or((when, None), |(start, length)| (start, Some(length)));
        let wrong = |number: &str, must| FaultError::Number {
            given: given.to_owned(),
            number: number.to_owned(),
            must,
        };
        let seconds = |text: &str| {
            let value: Option<f64> = text.parse().ok();
            value
                .filter(|value| (0.0..=1e6).contains(value))
                .ok_or_else(|| wrong(text, "seconds, 0 to 1000000"))
        };
        let body = |text: &str| {
            let value: Option<usize> = text.parse().ok();
            value
                .filter(|value| *value >= 1)
                .map(|value| value - 1)
                .ok_or_else(|| wrong(text, "the number of a body, from 1"))
        };
        let mishap = match (kind, of) {
            ("blind", None) => Mishap::Blind,
            ("dead", None) => Mishap::Dead,
            ("frozen", None) => Mishap::Frozen,
            ("slow", None) => Mishap::Slow,
            ("doubled", None) => Mishap::Doubled,
            ("swap", Some(of)) => {
                let (first, second) = of.split_once(',').ok_or_else(shape)?;
                Mishap::Swapped(body(first)?, body(second)?)
            }
            ("lost", Some(of)) => Mishap::Lost(body(of)?),
            ("away", Some(of)) => Mishap::Away(body(of)?),
            ("nan", Some(of)) => Mishap::NotANumber(body(of)?),
            ("clock", Some(of)) => {
                let by_s: Option<f64> = of.parse().ok();
                let by_s = by_s.filter(|by_s| (-1e9..=1e9).contains(by_s));
                Mishap::Clock(by_s.ok_or_else(|| wrong(of, "seconds, within ±1000000000"))?)
            }
            (
                "blind" | "dead" | "frozen" | "slow" | "doubled" | "swap" | "lost" | "away" | "nan" | "clock",
                _,
            ) => {
                return Err(shape());
            }
            _ => return Err(FaultError::Kind { given: given.to_owned(), kind: kind.to_owned() }),
        };
        let length_s = length.map_or(Ok(f64::INFINITY), seconds)?;
        Ok(Self { mishap, at_s: seconds(start)?, length_s })
    }
}
