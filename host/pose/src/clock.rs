//! The server's clock on the host's: when a frame was captured, although its journey took its time.
//!
//! ```text
//! d = arrived − captured = offset + delay,   delay ≥ least delay
//! ```
//!
//! The lowest d of every second is kept for a minute. Below all of them lies a straight line, offset and drift together: of all such
//! lines the one whose mean distance to the points is least (Moon, Skelly and Towsley, *Estimation and removal of clock skew from
//! network delay measurements*, INFOCOM 1999). A frame's time is its stamp plus the line, so that a frame which was held up keeps
//! the time it was captured at, and jitter does not become velocity.
//!
//! What this leaves in every time is the least delay itself: stamps of one direction do not show it. Exchanges of stamps do
//! ([`Clock::exchanged`]), where the protocol has them; half their round trip is what is left then.
//!
//! A stamp further than [`JUMP_S`] from the line is set aside. When stamps agree with each other like that for [`RELEARN_S`], on the
//! server's clock and on the host's, the server's clock has jumped, and is learned from the start. A burst after a stall does not:
//! it arrives in one moment. A latency that grows by more than [`JUMP_S`] at once cannot be told from a jump.

use std::collections::VecDeque;

use crate::source::Exchange;
use crate::time::{HostInstant, ServerInstant};

/// A stamp this far from the line is set aside, s. *Assumed*: more than any latency worth steering with.
pub const JUMP_S: f64 = 1.0;
/// Stamps that agree with each other for this time are believed, s. *Assumed.*
pub const RELEARN_S: f64 = 0.3;
/// The time of which one lowest point is kept, s.
const BUCKET_S: f64 = 1.0;
/// Points that are kept.
const BUCKETS: usize = 60;
/// Drift is taken for zero until points span this time, s: before, noise of the points would be more than any drift. *Assumed.*
const DRIFT_AFTER_S: f64 = 10.0;
/// The largest drift. *Assumed*: twice what a cheap quartz has.
const MOST_DRIFT: f64 = 2e-4;
/// An exchange is used for this time, s; then a worse one will do. *Assumed.*
const EXCHANGE_S: f64 = 60.0;

/// The lowest d of one bucket; both on scales of their own.
#[derive(Clone, Copy, Debug)]
struct Point {
    captured_s: f64,
    d_s: f64,
}

/// What was learned of one clock since it jumped.
#[derive(Clone, Debug)]
struct Learned {
    /// Where the scales begin: large numbers would cost digits.
    server: ServerInstant,
    host_s: f64,
    points: VecDeque<Point>,
    /// The line: d at the first instant, and drift.
    offset_s: f64,
    drift: f64,
    /// How far the line lies above the offset that the best exchange shows, that exchange's round trip, and when it was.
    least_delay: Option<(f64, f64, f64)>,
}

/// Stamps that were set aside and agree with each other.
#[derive(Clone, Copy, Debug)]
struct Strays {
    captured: ServerInstant,
    arrived_s: f64,
    first_d_s: f64,
}

/// When a frame was captured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// On the host's clock, s from the program's start; may be before it.
    pub captured_s: f64,
    /// How much longer than the least delay it was on its way, s.
    pub late_s: f64,
}

/// The map from the server's clock to the host's.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    learned: Option<Learned>,
    strays: Option<Strays>,
    jumps: u64,
}

impl Clock {
    /// Takes a frame's stamp and its arrival; `None` for a stamp that does not fit the clock as it is known.
    pub fn read(&mut self, captured: ServerInstant, arrived: HostInstant) -> Option<Reading> {
        let arrived_s = arrived.seconds();
        if let Some(learned) = &mut self.learned {
            let late_s = learned.d_s(captured, arrived_s) - learned.line_s(captured);
            if late_s.abs() <= JUMP_S {
                self.strays = None;
                return Some(learned.take(captured, arrived_s));
            }
            if !self.believed(captured, arrived_s) {
                return None;
            }
            self.jumps += 1;
        }
        self.strays = None;
        let mut learned = Learned::new(captured, arrived_s);
        let reading = learned.take(captured, arrived_s);
        self.learned = Some(learned);
        Some(reading)
    }

    /// Whether a stamp that does not fit agrees with those before it for long enough.
    fn believed(&mut self, captured: ServerInstant, arrived_s: f64) -> bool {
        let fresh = Strays { captured, arrived_s, first_d_s: 0.0 };
        let strays = *self.strays.get_or_insert(fresh);
        let on_server = captured.seconds_since(strays.captured);
        let on_host = arrived_s - strays.arrived_s;
        let d_s = on_host - on_server - strays.first_d_s;
        if d_s.abs() > JUMP_S / 2.0 || on_server < 0.0 {
            self.strays = Some(fresh);
            return false;
        }
        on_server >= RELEARN_S && on_host >= RELEARN_S
    }

    /// Takes an exchange of stamps: it shows how much of every delay is the least delay.
    pub fn exchanged(&mut self, exchange: &Exchange) {
        let Some(learned) = &mut self.learned else { return };
        let (sent_s, received_s) = (exchange.sent.seconds(), exchange.received.seconds());
        let round_trip_s = received_s - sent_s;
        // The server read its clock between the two, in the middle as far as is known.
        let d_s = learned.d_s(exchange.server, sent_s.midpoint(received_s));
        let least_delay_s = learned.line_s(exchange.server) - d_s;
        if least_delay_s.abs() > JUMP_S {
            return;
        }
        let better = learned
            .least_delay
            .is_none_or(|(_, best_s, at_s)| round_trip_s <= best_s || received_s - at_s > EXCHANGE_S);
        if better {
            learned.least_delay = Some((least_delay_s.max(0.0), round_trip_s, received_s));
        }
    }

    /// How often the server's clock has jumped.
    pub fn jumps(&self) -> u64 {
        self.jumps
    }

    /// The least delay of a frame, s, and how well it is known, ± s; `None` without an exchange.
    pub fn least_delay_s(&self) -> Option<(f64, f64)> {
        let (least_delay_s, round_trip_s, _) = self.learned.as_ref()?.least_delay?;
        Some((least_delay_s, round_trip_s / 2.0))
    }

    /// How much faster the server's clock runs than the host's, from the line.
    pub fn drift(&self) -> f64 {
        self.learned.as_ref().map_or(0.0, |learned| -learned.drift)
    }

    /// Whether the line rests on more than the first moments.
    pub fn is_settled(&self) -> bool {
        self.learned.as_ref().is_some_and(|learned| learned.points.len() > 2)
    }
}

impl Learned {
    fn new(server: ServerInstant, host_s: f64) -> Self {
        let points = VecDeque::with_capacity(BUCKETS + 1);
        Self { server, host_s, points, offset_s: 0.0, drift: 0.0, least_delay: None }
    }

    /// arrived − captured, on the scales of this clock.
    fn d_s(&self, captured: ServerInstant, arrived_s: f64) -> f64 {
        arrived_s - self.host_s - captured.seconds_since(self.server)
    }

    fn line_s(&self, captured: ServerInstant) -> f64 {
        self.offset_s + self.drift * captured.seconds_since(self.server)
    }

    fn take(&mut self, captured: ServerInstant, arrived_s: f64) -> Reading {
        let (captured_s, d_s) = (captured.seconds_since(self.server), self.d_s(captured, arrived_s));
        let point = Point { captured_s, d_s };
        let bucket = |point: &Point| (point.captured_s / BUCKET_S).floor();
        let same = |newest: &&mut Point| bucket(newest).total_cmp(&bucket(&point)).is_eq();
        let lower = match self.points.back_mut().filter(same) {
            Some(newest) if newest.d_s <= d_s => false,
            Some(newest) => {
                *newest = point;
                true
            }
            None => {
                self.points.push_back(point);
                if self.points.len() > BUCKETS {
                    self.points.pop_front();
                }
                true
            }
        };
        if lower {
            self.fit();
        }
        let line_s = self.line_s(captured);
        let least_delay_s = self.least_delay.map_or(0.0, |(least_delay_s, ..)| least_delay_s);
        Reading {
            captured_s: self.host_s + captured_s + line_s - least_delay_s,
            late_s: (d_s - line_s).max(0.0),
        }
    }

    /// The line below all points with the least mean distance: the edge of their lower hull above their mean time.
    fn fit(&mut self) {
        let (Some(first), Some(last)) = (self.points.front(), self.points.back()) else { return };
        if last.captured_s - first.captured_s < DRIFT_AFTER_S {
            let lowest_s = self.points.iter().map(|point| point.d_s).fold(f64::INFINITY, f64::min);
            (self.offset_s, self.drift) = (lowest_s, 0.0);
            return;
        }
        let mut hull: Vec<Point> = Vec::with_capacity(self.points.len());
        for &point in &self.points {
            while let [.., a, b] = *hull
                && cross(a, b, point) <= 0.0
            {
                hull.pop();
            }
            hull.push(point);
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 60 points")]
        let mean_s = self.points.iter().map(|point| point.captured_s).sum::<f64>() / self.points.len() as f64;
        let edge = hull.windows(2).find(|edge| matches!(edge, [_, b] if b.captured_s >= mean_s));
        if let Some([a, b]) = edge {
            let drift = (b.d_s - a.d_s) / (b.captured_s - a.captured_s);
            self.drift = drift.clamp(-MOST_DRIFT, MOST_DRIFT);
            // A drift that was clamped turns the line about nothing in particular: it goes below all points again.
            let below = self.points.iter().map(|point| point.d_s - self.drift * point.captured_s);
            self.offset_s = below.fold(f64::INFINITY, f64::min);
        }
    }
}

/// Positive where the path a, b, c turns to the left.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b.captured_s - a.captured_s) * (c.d_s - a.d_s) - (b.d_s - a.d_s) * (c.captured_s - a.captured_s)
}
