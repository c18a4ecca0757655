//! Why a fleet holds, in words and as a number in a log.

use std::fmt::{self, Display, Formatter};

/// Why the fleet holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// The host did not run, or did not know yet what modules had done meanwhile.
    HostAway,
    /// No pose is new enough.
    PosesLost,
    /// An operator has ordered it.
    Operator,
    /// A module does not do what it was told, or what it does is not known.
    Module,
    /// No cycle was found, or the one that was found did not reach every module.
    NoCycle,
    /// A robot has drifted towards the edge of the water.
    Bounds,
    /// A robot is not where it should be.
    Astray,
}

/// All of them, by their numbers in a log.
const HOLDS: [Hold; 7] = [
    Hold::HostAway,
    Hold::PosesLost,
    Hold::Operator,
    Hold::Module,
    Hold::NoCycle,
    Hold::Bounds,
    Hold::Astray,
];

impl Display for Hold {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::HostAway => "the host did not run",
            Self::PosesLost => "no pose was new enough",
            Self::Operator => "an operator ordered it",
            Self::Module => "a module did not do what it was told",
            Self::NoCycle => "no cycle was found that all modules had in time",
            Self::Bounds => "a robot had drifted towards the edge of the water",
            Self::Astray => "a robot was not where it should be",
        })
    }
}

impl Hold {
    /// As a number, for a log.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The same, back.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        HOLDS.get(usize::from(number)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_comes_back_from_its_number() {
        for hold in HOLDS {
            assert_eq!(Hold::from_number(hold.number()), Some(hold));
        }
        assert_eq!(Hold::from_number(7), None);
    }
}
