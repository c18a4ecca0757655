//! Offset and drift from the blocks: two half planes, and how likely each drift is.
//!
//! Every f = t2 − t1 lies above the line o + δx by its delay, every b = t3 − t4 below it by its own. For a drift δ
//!
//! ```text
//! h(δ) = min (f − δx),   l(δ) = max (b − δx),   gap(δ) = h − l,   offset(δ) = ½(h + l)                 now: x = 0
//! ```
//!
//! gap is concave; its widest place is the drift of Moon, Skelly & Towsley (INFOCOM 1999), whose linear programme also
//! minimises the sum of all delays. That sum grows by N·(gap* − gap(δ)) elsewhere, so that with delays
//! which are exponential near their least, at a rate that is not known either (its prior ∝ 1/rate),
//!
//! ```text
//! p(δ) ∝ (1 + N·max(gap* − gap(δ) − q, 0)/S)^−ν · exp(−½(δ − δ₀)²/σ²)
//! S = Σ n·min(r, c),   ν = K − 2,   scale of an edge s(δ) = S·(1 + …)/(N·(ν − 1))
//! offset = E offset(δ),   u² = 2.6²·Var offset(δ) + 3.3²·E s²/2,   drift = E δ
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x | own clock less now | s |
//! | δ, δ₀, σ | drift; its prior, 0 ± 60 *assumed* | ppm |
//! | K, n, N | blocks (of each direction), exchanges in one, in all | 1 |
//! | r | block's best less the edge at the widest gap | µs |
//! | c | the median of all r: only what is near the edge tells how sharp it is | µs |
//! | q | what polling hides: 400 µs, in windows over 20 s falling as 1/length | µs |
//! | u | 99 % bound of the offset | µs |
//!
//! q: two loops at 1 kHz put t1 and t2 on two grids, so that f moves in steps of 1 ms while the clocks drift smoothly: a
//! window shorter than a few steps sees no drift at all and is very sure of it. q was found by trial.
//!
//! Assumptions and limits: single precision. Delays without a sharp lower edge (sums of many) are less exponential than
//! said: u then holds for 95 % rather than 99 %.

use super::blocks::{BLOCKS, Block};
use super::exact::{along, micros, number, seconds};

/// The most two clocks drift apart, ppm. *Assumed.*
pub(super) const DRIFT_MAX_PPM: f32 = 300.0;
/// The same, ppb.
pub(super) const DRIFT_MAX_PPB: i32 = 300_000;

/// Standard deviations that are not exceeded in 99 % of the time: of a normal distribution, and of the difference of
/// two exponential ones.
pub(super) const SURE_NORMAL: f32 = 2.6;
const SURE_EXPONENTIAL: f32 = 3.3;

/// q for short windows, and the longest of these.
const HIDDEN_US: f32 = 400.0;
const HIDDEN_FOR_S: f32 = 20.0;

/// Points of the numerical integration over δ.
const POINTS: u16 = 24;

/// −ln of how likely the least likely drift is that counts.
const LEAST_LIKELY: f32 = 10.0;

/// What is known of the drift beforehand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub drift_ppm: f32,
    pub deviation_ppm: f32,
}

impl Prior {
    /// Two quartzes of which nothing is known. *Assumed.*
    pub(super) const QUARTZ: Self = Self { drift_ppm: 0.0, deviation_ppm: 60.0 };
}

/// Offset and drift with their uncertainty. Offsets are above the reference.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub offset_us: f32,
    /// u
    pub unsure_us: f32,
    pub drift_ppm: f32,
    pub drift_deviation_ppm: f32,
    /// h and l.
    pub edges_us: [f32; 2],
}

/// A block: forward and backward.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// x, s.
    at_s: [f32; 2],
    offset_us: [f32; 2],
    count: f32,
}

impl Point {
    /// f − δx, b − δx
    fn now_us(&self, drift_ppm: f32) -> [f32; 2] {
        let ([forward_s, backward_s], [forward_us, backward_us]) = (self.at_s, self.offset_us);
        // µs = ppm·s
        [forward_us - drift_ppm * forward_s, backward_us - drift_ppm * backward_s]
    }
}

struct Planes {
    points: heapless::Vec<Point, BLOCKS>,
}

impl Planes {
    fn of<'a>(blocks: impl Iterator<Item = &'a Block>, now_us: u64, reference_us: i64) -> Self {
        let point = |block: &Block| {
            let sights = [block.forward, block.backward];
            Point {
                at_s: sights.map(|sight| seconds(along(now_us, sight.at_us))),
                offset_us: sights.map(|sight| micros(sight.offset_us.saturating_sub(reference_us))),
                count: number(block.count),
            }
        };
        Self { points: blocks.map(point).take(BLOCKS).collect() }
    }

    /// h, l
    fn edges_us(&self, drift_ppm: f32) -> [f32; 2] {
        self.points.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[high, low], point| {
            let [forward, backward] = point.now_us(drift_ppm);
            [high.min(forward), low.max(backward)]
        })
    }

    fn gap_us(&self, drift_ppm: f32) -> f32 {
        let [high, low] = self.edges_us(drift_ppm);
        high - low
    }

    /// S and ν
    fn scatter_us(&self, drift_ppm: f32) -> (f32, f32) {
        let [high, low] = self.edges_us(drift_ppm);
        let distances = || {
            self.points.iter().flat_map(|point| {
                let [forward, backward] = point.now_us(drift_ppm);
                [(forward - high, point.count), (low - backward, point.count)]
            })
        };
        let half = self.points.len();
        // The one with half of the others below it; found by counting, as 32 are too few to be worth sorting.
        let is_median = |us: f32| {
            let (below, up_to) = distances().fold((0, 0), |(below, up_to): (usize, usize), (other, _)| {
                (below.saturating_add((other < us).into()), up_to.saturating_add((other <= us).into()))
            });
            below <= half && half < up_to
        };
        let median_us = distances().map(|(us, _)| us).find(|us| is_median(*us)).unwrap_or(0.0);
        let sum_us = distances().map(|(distance, count)| count * distance.min(median_us)).sum();
        (sum_us, (number(u32::try_from(half).unwrap_or(0)) - 2.0).max(1.0))
    }

    /// The δ of the widest gap: golden section, to 0.03 ppm.
    fn widest_ppm(&self) -> f32 {
        const GOLDEN: f32 = 0.618_034;
        let (mut low, mut high) = (-DRIFT_MAX_PPM, DRIFT_MAX_PPM);
        let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        let (mut at_left, mut at_right) = (self.gap_us(left), self.gap_us(right));
        for _ in 0..21 {
            if at_left >= at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - GOLDEN * (high - low);
                at_left = self.gap_us(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + GOLDEN * (high - low);
                at_right = self.gap_us(right);
            }
        }
        0.5 * (low + high)
    }

    /// How far from `inside` towards `outside` the gap stays wider than `gap_us`, to a five-hundredth of the way.
    fn reach_ppm(&self, mut inside: f32, mut outside: f32, gap_us: f32) -> f32 {
        if self.gap_us(outside) >= gap_us {
            return outside;
        }
        for _ in 0..9 {
            let middle = 0.5 * (inside + outside);
            if self.gap_us(middle) >= gap_us { inside = middle } else { outside = middle }
        }
        outside
    }

    /// q
    fn hidden_us(&self) -> f32 {
        let length_s = self.points.iter().map(|point| -point.at_s[0]).fold(HIDDEN_FOR_S, f32::max);
        HIDDEN_US * HIDDEN_FOR_S / length_s
    }
}

impl Estimate {
    /// From at least one block.
    pub(super) fn of<'a>(
        blocks: impl Iterator<Item = &'a Block>,
        now_us: u64,
        reference_us: i64,
        prior: Prior,
    ) -> Self {
        let planes = Planes::of(blocks, now_us, reference_us);
        let count: f32 = planes.points.iter().map(|point| point.count).sum();
        let widest_ppm = planes.widest_ppm();
        let (scatter_us, freedom) = planes.scatter_us(widest_ppm);
        // 1 µs each at the least: the stamps are no finer.
        let scatter_us = scatter_us.max(count);
        let plateau_us = planes.gap_us(widest_ppm) - planes.hidden_us();

        // The drifts that count.
        let least_us = plateau_us - scatter_us / count * (libm::expf(LEAST_LIKELY / freedom) - 1.0);
        let mut low = planes.reach_ppm(widest_ppm, -DRIFT_MAX_PPM, least_us);
        let mut high = planes.reach_ppm(widest_ppm, DRIFT_MAX_PPM, least_us);
        let span = 4.0 * prior.deviation_ppm;
        if prior.drift_ppm - span < high && prior.drift_ppm + span > low {
            (low, high) = (low.max(prior.drift_ppm - span), high.min(prior.drift_ppm + span));
        }

        let step = (high - low) / f32::from(POINTS);
        let (mut drift_ppm, mut best) = (low + 0.5 * step, f32::NEG_INFINITY);
        let drifts = [(); POINTS as usize].map(|()| {
            let [edge_high, edge_low] = planes.edges_us(drift_ppm);
            // 1 + N·max(gap* − gap(δ) − q, 0)/S
            let worse = 1.0 + count * (plateau_us - (edge_high - edge_low)).max(0.0) / scatter_us;
            let unlike = (drift_ppm - prior.drift_ppm) / prior.deviation_ppm;
            let likelihood = -freedom * libm::logf(worse) - 0.5 * unlike * unlike;
            let point = (drift_ppm, 0.5 * (edge_high + edge_low), worse, likelihood);
            (drift_ppm, best) = (drift_ppm + step, best.max(likelihood));
            point
        });
        let [mut offset, mut drift, mut edge] = [Moments::default(); 3];
        for (ppm, middle_us, worse, likelihood) in drifts {
            let weight = libm::expf(likelihood - best);
            offset.add(weight, middle_us);
            drift.add(weight, ppm);
            edge.add(weight, worse * scatter_us / (count * (freedom - 1.0).max(0.5)));
        }
        Self {
            offset_us: offset.mean(),
            unsure_us: libm::sqrtf(
                SURE_NORMAL * SURE_NORMAL * offset.variance()
                    + 0.5 * SURE_EXPONENTIAL * SURE_EXPONENTIAL * edge.square(),
            ),
            drift_ppm: drift.mean(),
            drift_deviation_ppm: libm::sqrtf(drift.variance() + step * step / 12.0),
            edges_us: planes.edges_us(drift.mean()),
        }
    }
}

/// Weighted sums for mean and variance.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    weight: f32,
    sum: f32,
    squares: f32,
}

impl Moments {
    fn add(&mut self, weight: f32, value: f32) {
        self.weight += weight;
        self.sum += weight * value;
        self.squares += weight * value * value;
    }

    fn mean(&self) -> f32 {
        self.sum / self.weight
    }

    fn square(&self) -> f32 {
        self.squares / self.weight
    }

    fn variance(&self) -> f32 {
        (self.square() - self.mean() * self.mean()).max(0.0)
    }
}
