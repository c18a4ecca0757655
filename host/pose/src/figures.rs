//! Figures of a stream: rate, latency, frames that are missing, and how often each body was seen.
//!
//! A server may send every n-th frame: then numbers go up by n, and none is missing. The step is the commonest one so far.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, Vector3};

use crate::frame::{Arrival, Label};
use crate::gate::Fix;

/// Steps of numbers that are told apart; a longer one is a gap.
const LONGEST_STEP: u32 = 64;
/// Bodies that are told apart.
const MOST_BODIES: usize = 1000;
/// Width of a class of latencies, s.
const CLASS_S: f64 = 0.001;
/// Classes; the last one has all that is later.
const CLASSES: usize = 1000;

/// How often a body was seen, and where it was last, as the server said.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyFigures {
    /// Frames it was in.
    pub frames: u64,
    /// Frames in which it was tracked.
    pub tracked: u64,
    /// The last position that was tracked, in the server's unit and axes.
    pub position: Option<Vector3<f64>>,
    /// The last attitude that was tracked.
    pub attitude: Option<Quaternion<f64>>,
}

/// Figures of a stream.
#[derive(Clone, Debug)]
pub struct Figures {
    frames: u64,
    first_s: Option<f64>,
    last_s: f64,
    fixes: u64,
    number: Option<u32>,
    /// How often numbers went up by 1, 2, …
    steps: BTreeMap<u32, u64>,
    /// What numbers went up by in all.
    spanned: u64,
    /// Fixes by how much later than the least delay they were.
    late: Vec<u64>,
    bodies: BTreeMap<Label, BodyFigures>,
}

impl Default for Figures {
    fn default() -> Self {
        Self {
            frames: 0,
            first_s: None,
            last_s: 0.0,
            fixes: 0,
            number: None,
            steps: BTreeMap::new(),
            spanned: 0,
            late: vec![0; CLASSES],
            bodies: BTreeMap::new(),
        }
    }
}

impl Figures {
    /// Counts a frame, whatever becomes of it.
    pub fn count(&mut self, arrival: &Arrival) {
        self.frames += 1;
        let arrived_s = arrival.arrived.seconds();
        self.first_s.get_or_insert(arrived_s);
        self.last_s = arrived_s;
        if let Some(number) = arrival.frame.number {
            if let Some(step) = self.number.map(|last| number.wrapping_sub(last))
                && (1..u32::MAX / 2).contains(&step)
            {
                if step <= LONGEST_STEP {
                    *self.steps.entry(step).or_default() += 1;
                }
                self.spanned += u64::from(step);
            }
            self.number = Some(number);
        }
        for body in &arrival.frame.bodies {
            if self.bodies.len() >= MOST_BODIES && !self.bodies.contains_key(&body.label) {
                continue;
            }
            let fresh = BodyFigures { frames: 0, tracked: 0, position: None, attitude: None };
            let figures = self.bodies.entry(body.label.clone()).or_insert(fresh);
            figures.frames += 1;
            if body.tracked {
                figures.tracked += 1;
                figures.position = Some(body.position);
                figures.attitude = Some(body.attitude);
            }
        }
    }

    /// Counts a frame that was accepted.
    pub fn count_fix(&mut self, fix: &Fix) {
        self.fixes += 1;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let class = ((fix.late_s / CLASS_S) as usize).min(CLASSES - 1);
        if let Some(count) = self.late.get_mut(class) {
            *count += 1;
        }
    }

    /// Frames that came.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Frames a second, by their arrival; zero before the second frame.
    #[expect(clippy::cast_precision_loss, reason = "counts are small")]
    pub fn rate_hz(&self) -> f64 {
        let spanned_s = self.last_s - self.first_s.unwrap_or_default();
        if spanned_s > 0.0 { self.frames.saturating_sub(1) as f64 / spanned_s } else { 0.0 }
    }

    /// What numbers commonly go up by.
    pub fn step(&self) -> u32 {
        let commonest = self.steps.iter().max_by_key(|&(step, count)| (*count, std::cmp::Reverse(*step)));
        commonest.map_or(1, |(step, _)| *step)
    }

    /// The share of frames whose numbers never came, by the numbers; `None` where there are none.
    #[expect(clippy::cast_precision_loss, reason = "counts are small")]
    pub fn missing_share(&self) -> Option<f64> {
        self.number?;
        let due = self.spanned as f64 / f64::from(self.step());
        let came = self.frames.saturating_sub(1) as f64;
        Some(if due > 0.0 { (1.0 - came / due).clamp(0.0, 1.0) } else { 0.0 })
    }

    /// The latency beyond the least one that a share of the fixes did not exceed, s, to a millisecond.
    #[expect(clippy::cast_precision_loss, reason = "counts are small")]
    pub fn late_s(&self, share: f64) -> f64 {
        let wanted = share.clamp(0.0, 1.0) * self.fixes as f64;
        let mut seen = 0;
        let class = self.late.iter().position(|count| {
            seen += count;
            seen as f64 >= wanted
        });
        class.map_or(0.0, |class| CLASS_S * class as f64)
    }

    /// The bodies that were in frames.
    pub fn bodies(&self) -> &BTreeMap<Label, BodyFigures> {
        &self.bodies
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Body, Frame};
    use crate::time::{HostInstant, ServerInstant};

    fn arrival(number: u32, at_s: f64, tracked: bool) -> Arrival {
        let body = Body {
            label: Label::named("boat"),
            position: Vector3::new(at_s, 0.0, 0.0),
            attitude: Quaternion::identity(),
            tracked,
            error: None,
        };
        let frame = Frame { number: Some(number), captured: ServerInstant(0), bodies: vec![body] };
        Arrival { frame, arrived: HostInstant::from_seconds(at_s) }
    }

    #[test]
    fn every_eighth_frame_is_not_a_loss_and_a_gap_is() {
        let mut figures = Figures::default();
        for count in (0..100).filter(|count| *count != 50) {
            figures.count(&arrival(
                (u32::MAX - 400).wrapping_add(8 * count),
                0.01 * f64::from(count),
                count % 4 > 0,
            ));
        }
        assert_eq!((figures.step(), figures.frames()), (8, 99));
        let missing = figures.missing_share().expect("numbers");
        assert!((missing - 1.0 / 99.0).abs() < 1e-12, "{missing}");
        assert!((figures.rate_hz() - 98.0 / 0.99).abs() < 1e-9);
        let body = &figures.bodies()[&Label::named("boat")];
        assert_eq!((body.frames, body.tracked), (99, 74));
        assert_eq!(body.position, Some(Vector3::new(0.99, 0.0, 0.0)));
    }

    #[test]
    fn latencies_by_share() {
        let mut figures = Figures::default();
        let fix = |late_s| Fix { number: None, captured_s: 0.0, arrived_s: 0.0, late_s, bodies: Vec::new() };
        (0..100).for_each(|count| figures.count_fix(&fix(0.0005 + 0.001 * f64::from(count))));
        figures.count_fix(&fix(1e9));
        assert!((figures.late_s(0.5) - 0.05).abs() < 1e-9, "{}", figures.late_s(0.5));
        assert!((figures.late_s(1.0) - 0.999).abs() < 1e-9);
        assert!(Figures::default().late_s(0.5).abs() < 1e-9);
    }
}
