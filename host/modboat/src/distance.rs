//! Distance to collision (DoC) of two tails' motion, §II-A and Fig. 3.
//!
//! In phase space a motion is the segment AB, A = (φᵢ, φⱼ) at its start and B at its end. Its DoC against one polygon is
//! the paper's four cases, see [`outline`]. The polygons repeat every 2π in both angles; the DoC is the least over all
//! copies. The paper takes those in \[−2π, 2π\]²; here it is all of them, for angles unwrapped to any number of turns.
//!
//! So DoC > 0 means clear by that much, DoC < 0 means a collision, and for any motion DoC ≥ 0 exactly when no pose of it
//! lies inside a polygon.
//!
//! A search that only tells distances below its margin apart asks for [`DistanceToCollision::along_bounded`]: exact below
//! the margin, beyond it some lower bound, which a few circles about each polygon give. Most motions are far from everything.
//!
//! Limit: a turn beyond [`TURN_MAX_RAD`], an angle beyond [`ANGLE_MAX_RAD`], or one that is not finite, has the DoC −∞.

use std::f64::consts::TAU;

use super::motion::{Swing, ends};
use super::parameters::Parameters;
use super::region::CollisionRegion;
use super::tail::{TURN_MAX_RAD, Tail};
use super::tube::{Errors, Tube};
use outline::Segment;

pub mod outline;

pub use outline::Outline;

/// The greatest angle that is wrapped, rad: beyond it the 1e-10 rad that an f64 resolves are lost.
pub const ANGLE_MAX_RAD: f64 = 1e6;
/// ⌊x⌋ without the library call that `f64::floor` is on a processor of the baseline.
#[inline]
pub(super) fn floor(x: f64) -> i32 {
    let whole = x as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > x))
}

/// The whole number nearest to x.
#[inline]
pub(super) fn nearest_whole(x: f64) -> i32 {
    floor(x + 0.5)
}

/// DoC for every lattice offset at which two tails can touch.
#[derive(Clone, Debug)]
pub struct DistanceToCollision {
    tail: Tail,
    offsets: Vec<[i32; 2]>,
    regions: Vec<CollisionRegion>,
    outlines: Vec<Vec<Outline>>,
    errors: Errors,
    /// The outlines of the regions dilated by each [`Tube`]'s box.
    tubes: [Vec<Vec<Outline>>; 3],
}

impl DistanceToCollision {
    /// Traces the regions of all reachable offsets.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let tail = Tail::new(parameters);
        let offsets = tail.reachable_offsets();
        let regions = CollisionRegion::all(&tail, &offsets);
        let outlines =
            regions.iter().map(|r| r.polygons().iter().map(|p| Outline::new(p)).collect()).collect();
        let errors = Errors::new(parameters);
        let tubes = Tube::ALL.map(|tube| {
            let dilate = |polygon: &Vec<[f64; 2]>| Outline::new(&errors.dilate(tube, polygon));
            regions.iter().map(|region| region.polygons().iter().map(dilate).collect()).collect()
        });
        Self { tail, offsets, regions, outlines, errors, tubes }
    }

    /// The tail that the collision regions are of.
    #[must_use]
    pub fn tail(&self) -> &Tail {
        &self.tail
    }

    /// How far tails may be off their planned angles.
    #[must_use]
    pub fn errors(&self) -> &Errors {
        &self.errors
    }

    /// True if no pose of the tube about the motion is a collision: both tails anywhere within their errors of it.
    #[must_use]
    pub fn tube_clear(&self, tube: Tube, offset_index: usize, from: [f64; 2], to: [f64; 2]) -> bool {
        let outlines = self.tubes[tube as usize].get(offset_index).map_or(&[][..], Vec::as_slice);
        least(outlines, from, to, 0.0, 0.0) >= 0.0
    }

    /// The offsets cell_j − cell_i at which tails can touch, one of each ± pair. An offset's place is its `offset_index`.
    #[must_use]
    pub fn offsets(&self) -> &[[i32; 2]] {
        &self.offsets
    }

    /// The collision regions, by `offset_index`.
    #[must_use]
    pub fn regions(&self) -> &[CollisionRegion] {
        &self.regions
    }

    /// DoC of the motion from `from` to `to` (φᵢ, φⱼ), the least over all copies; rad. Exact. +∞ where nothing can touch.
    #[must_use]
    pub fn along(&self, offset_index: usize, from: [f64; 2], to: [f64; 2]) -> f64 {
        least(self.at(offset_index), from, to, f64::INFINITY, f64::NEG_INFINITY)
    }

    /// True if the DoC is at least `margin_rad`. Leaves at the first copy that is nearer.
    #[must_use]
    pub fn clear(&self, offset_index: usize, from: [f64; 2], to: [f64; 2], margin_rad: f64) -> bool {
        least(self.at(offset_index), from, to, margin_rad.max(0.0), margin_rad) >= margin_rad
    }

    /// D(φ₀ᵢ, Aᵢ, φ₀ⱼ, Aⱼ): DoC of a swim cycle by waveform (1), which is the segment between φ₀ + A and φ₀ − A.
    #[must_use]
    pub fn swim(&self, offset_index: usize, i: Swing, j: Swing) -> f64 {
        let [from, to] = ends(i, j);
        self.along(offset_index, from, to)
    }

    /// DoC if that is below `margin_rad` (≥ 0), otherwise a lower bound of it that is not; rad. The fastest of all.
    #[must_use]
    pub fn along_bounded(&self, offset_index: usize, [from, to]: [[f64; 2]; 2], margin_rad: f64) -> f64 {
        let margin_rad = margin_rad.max(0.0);
        let mut best = f64::INFINITY;
        let sound = against(self.at(offset_index), from, to, |outline, segment| {
            best = best.min(outline.bounded_over_copies(segment, margin_rad));
            true
        });
        if sound { best } else { f64::NEG_INFINITY }
    }

    fn at(&self, offset_index: usize) -> &[Outline] {
        self.outlines.get(offset_index).map_or(&[], Vec::as_slice)
    }
}

/// The least DoC against any of `outlines` if it is below `cap` (≥ 0), else `cap`; the first found below `enough` will do.
fn least(outlines: &[Outline], from: [f64; 2], to: [f64; 2], cap: f64, enough: f64) -> f64 {
    let mut best = cap;
    let sound = against(outlines, from, to, |outline, segment| {
        best = outline.least_of_copies(segment, best, enough);
        best >= enough
    });
    if sound { best } else { f64::NEG_INFINITY }
}

/// Hands `look` each outline and the motion relative to its centre, start wrapped, until it returns false. False if the motion is
/// none that is looked at.
fn against(
    outlines: &[Outline],
    from: [f64; 2],
    to: [f64; 2],
    mut look: impl FnMut(&Outline, &Segment) -> bool,
) -> bool {
    let step = [to[0] - from[0], to[1] - from[1]];
    // Said so that a NaN fails it too.
    let sound = |k: usize| step[k].abs() <= TURN_MAX_RAD && from[k].abs() <= ANGLE_MAX_RAD;
    if !(sound(0) && sound(1)) {
        return false;
    }
    for outline in outlines {
        let wrapped = [0, 1].map(|k| {
            let off = from[k] - outline.centre[k];
            off - TAU * f64::from(nearest_whole(off / TAU))
        });
        let segment = Segment::new(wrapped, [wrapped[0] + step[0], wrapped[1] + step[1]]);
        if !look(outline, &segment) {
            break;
        }
    }
    true
}
