//! Fault parameters of the medium: the table `[radio]` of a scenario.

use quantity::{ParameterError, Range, check_ranges};
use serde::{Deserialize, Serialize};

/// How bad the medium is. The default is a perfect one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultParameters {
    /// Share of datagrams that vanish, 0–1.
    pub loss: f64,
    /// Share of time in the bad state, in which everything sent vanishes, 0–1; beside `loss`.
    pub burst: f64,
    /// Mean length of a bad state, s.
    pub burst_s: f64,
    /// Share of datagrams that arrive twice, 0–1.
    pub duplication: f64,
    /// Share of datagrams that arrive with one bit flipped, 0–1.
    pub corruption: f64,
    /// Share of datagrams that arrive cut to a shorter length, uniformly drawn from zero bytes on, 0–1.
    pub truncation: f64,
    /// Least time under way, s.
    pub delay_s: f64,
    /// Up to this much more, uniformly drawn for each datagram, s. Longer than the gap between two datagrams, it
    /// reorders them.
    pub jitter_s: f64,
    /// Share of datagrams held back by `reorder_s`, 0–1.
    pub reordering: f64,
    /// For how long they are held back, s.
    pub reorder_s: f64,
    /// Share of datagrams in a spike of delay, 0–1.
    pub late: f64,
    /// The greatest spike, s; each is uniformly drawn up to it.
    pub late_s: f64,
    /// Replays per datagram, 0–1: an earlier one to the same address is sent again as it was.
    pub replay: f64,
    /// Up to this long after the datagram that sets it off a replay is sent, uniformly drawn, s.
    pub replay_s: f64,
    /// Forgeries per datagram, 0–1: what a stranger without keys adds.
    pub forgery: f64,
}

impl FaultParameters {
    /// Refuses shares outside 0–1, times that are negative or not numbers, and shares whose time is missing.
    ///
    /// # Errors
    /// [`ParameterError`] names the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let needed_for = |share: f64| if share > 0.0 { Range::Positive } else { Range::NonNegative };
        check_ranges(&[
            ("loss", self.loss, "(share)", Range::Share),
            ("burst", self.burst, "(share)", Range::Share),
            ("burst_s", self.burst_s, "s", needed_for(self.burst)),
            ("duplication", self.duplication, "(share)", Range::Share),
            ("corruption", self.corruption, "(share)", Range::Share),
            ("truncation", self.truncation, "(share)", Range::Share),
            ("delay_s", self.delay_s, "s", Range::NonNegative),
            ("jitter_s", self.jitter_s, "s", Range::NonNegative),
            ("reordering", self.reordering, "(share)", Range::Share),
            ("reorder_s", self.reorder_s, "s", needed_for(self.reordering)),
            ("late", self.late, "(share)", Range::Share),
            ("late_s", self.late_s, "s", needed_for(self.late)),
            ("replay", self.replay, "(share)", Range::Share),
            ("replay_s", self.replay_s, "s", Range::NonNegative),
            ("forgery", self.forgery, "(share)", Range::Share),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused_by_name() {
        let error = FaultParameters { loss: f64::NAN, ..Default::default() }.validate().unwrap_err();
        assert_eq!(error.key, "loss");
        let error = FaultParameters { delay_s: -1.0, ..Default::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "delay_s = -1 s: must be a finite number, zero or greater");
        let error = FaultParameters { burst: 0.1, ..Default::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "burst_s = 0 s: must be a finite number greater than zero");
    }

    /// Every key, one after the other, through the table itself: none is forgotten.
    #[test]
    fn every_key_is_checked() {
        let table = toml::Table::try_from(FaultParameters::default()).unwrap();
        assert_eq!(table.len(), 15);
        for key in table.keys() {
            for nonsense in [-0.1, f64::NAN, f64::INFINITY, 1e7] {
                let mut table = table.clone();
                table.insert(key.clone(), nonsense.into());
                let error = table.try_into::<FaultParameters>().unwrap().validate().unwrap_err();
                assert_eq!(error.key, key);
                assert_eq!(error.unit, if key.ends_with("_s") { "s" } else { "(share)" });
            }
        }
    }
}
