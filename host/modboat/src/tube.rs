//! The tube about a planned motion: every pair of angles that two tails may be at while they follow it.
//!
//! A module keeps its tail within e_s of its reference, or stops with a fault; its reference is that of an instant up to ε_c
//! early or late, because its clock is off by that much:
//!
//! φ(t) = φ_planned(t + ε) + δ,   |ε| ≤ ε_c,   |δ| ≤ e_s                                                                 (t1)
//!
//! So of two tails that are planned to go along the segment AB of their phase space (φᵢ, φⱼ), the real ones are somewhere in
//!
//! tube = AB ⊕ [−e, e]²                                                                                                  (t2)
//!
//! a hexagon, and the plan is free if no pose of it is a collision. A clock that is off moves a tail along its own path and not out
//! of it. So it counts only where both move:
//!
//! | what | e |
//! |---|---|
//! | one moves, the other rests | e_s ([`Parameters::tracking_error_rad`]) |
//! | both move, at up to ω | e_s + ω·ε_c ([`Parameters::clock_error_s`]) |
//! | both move slowly, out of a place too narrow for that | e_s + [`SLOW_RAD_S`]·ε_c |
//!
//! For the search, the collision region is dilated by the box once, and AB is held against that: AB meets R ⊕ box exactly when
//! the tube meets R. For the examination of a plan, the hexagon's edges are held against the exact geometry
//! ([`Tail::tube_clearance_m`](super::tail::Tail::tube_clearance_m)).

use super::parameters::Parameters;
use super::region::DEPTH_RAD;

/// Greatest speed of a tail in a slow transition, rad/s. *Assumed*: the clock's share of the error is then 4 mrad.
pub const SLOW_RAD_S: f64 = 2.0;

/// Which tube holds for a pair: by what its two tails do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tube {
    /// One moves, or none.
    One,
    /// Both move.
    Both,
    /// Both move slowly.
    Slow,
}

impl Tube {
    /// All tubes; each stands at `self as usize`.
    pub const ALL: [Self; 3] = [Self::One, Self::Both, Self::Slow];

    /// The tube of a pair of which these move.
    #[must_use]
    pub const fn of(moves: [bool; 2]) -> Self {
        if moves[0] && moves[1] { Self::Both } else { Self::One }
    }
}

/// Half the width e of each tube, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    by_tube_rad: [f64; 3],
}

impl Errors {
    /// Of modules with these parameters.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let fastest_rad_s = parameters.swing_speed_max_rad_s().max(parameters.transition_speed_rad_s());
        let by_tube_rad = Tube::ALL.map(|tube| {
            let speed_rad_s = match tube {
                Tube::One => 0.0,
                Tube::Both => fastest_rad_s,
                Tube::Slow => SLOW_RAD_S,
            };
            // e = e_s + ω·ε_c
            parameters.tracking_error_rad + speed_rad_s * parameters.clock_error_s
        });
        Self { by_tube_rad }
    }

    /// Greatest error e of an angle in a tube, rad.
    #[must_use]
    pub const fn of(&self, tube: Tube) -> f64 {
        self.by_tube_rad[tube as usize]
    }

    /// e_s: how far a tail may be from where it rests, and from the path that it moves along, rad.
    #[must_use]
    pub const fn tracking_rad(&self) -> f64 {
        self.of(Tube::One)
    }

    /// A collision region's polygon (counter-clockwise) ⊕ the box of `tube`, rad. What the polygon misses of the region, at most
    /// [`DEPTH_RAD`], is made up for.
    #[must_use]
    pub fn dilate(&self, tube: Tube, polygon: &[[f64; 2]]) -> Vec<[f64; 2]> {
        dilated(polygon, [self.of(tube) + DEPTH_RAD; 2])
    }
}

/// A counter-clockwise polygon ⊕ [−hₓ, hₓ] × [−h_y, h_y].
///
/// Between its lowest, rightmost, highest and leftmost vertex the boundary of a polygon that every horizontal and vertical line
/// meets in one stretch is monotone in both coordinates. Each of these four chains moves by the corner of the box that is outward
/// of it; the box's edges join them. A chain that is not monotone is made so outwards: the sum is then larger, never smaller.
fn dilated(polygon: &[[f64; 2]], half: [f64; 2]) -> Vec<[f64; 2]> {
    let extreme = |key: fn(&[f64; 2]) -> f64| {
        let least = |a: &usize, b: &usize| key(&polygon[*a]).total_cmp(&key(&polygon[*b]));
        (0..polygon.len()).min_by(least).unwrap_or(0)
    };
    let ends = [extreme(|p| p[1]), extreme(|p| -p[0]), extreme(|p| -p[1]), extreme(|p| p[0])];
    let corners = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let mut sum = Vec::with_capacity(polygon.len() + 4);
    for (quarter, corner) in corners.iter().enumerate() {
        let (first, last) = (ends[quarter], ends[(quarter + 1) % 4]);
        let length = (last + polygon.len() - first) % polygon.len();
        let mut chain: Vec<[f64; 2]> = (0..=length).map(|k| polygon[(first + k) % polygon.len()]).collect();
        // One coordinate grows outwards along the chain, the other one against it.
        let along = quarter % 2;
        let further = |k: usize, a: f64, b: f64| if corner[k] > 0.0 { a.max(b) } else { a.min(b) };
        for k in 1..chain.len() {
            chain[k][along] = further(along, chain[k][along], chain[k - 1][along]);
        }
        for k in (1..chain.len()).rev() {
            chain[k - 1][1 - along] = further(1 - along, chain[k - 1][1 - along], chain[k][1 - along]);
        }
        sum.extend(chain.iter().map(|p| [0, 1].map(|k| p[k] + corner[k] * half[k])));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::CollisionRegion;
    use crate::tail::Tail;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn a_diamond_and_a_dent_are_hand_worked() {
        let diamond = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
        let sum = dilated(&diamond, [0.5, 0.25]);
        let expected = [
            [0.5, -1.25],
            [1.5, -0.25],
            [1.5, 0.25],
            [0.5, 1.25],
            [-0.5, 1.25],
            [-1.5, 0.25],
            [-1.5, -0.25],
            [-0.5, -1.25],
        ];
        assert_eq!(sum, expected);
        // A dent in the lower right chain is filled.
        let dented = [[0.0, -1.0], [0.6, -0.2], [0.4, -0.1], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
        let sum = dilated(&dented, [0.0, 0.0]);
        assert!(sum.windows(2).take(3).all(|pair| pair[1][0] >= pair[0][0]), "{sum:?}");
    }

    /// Against the exact geometry: wherever some pose of the box about a pose collides, the pose is in the dilated region; and
    /// the region is not larger than that by more than the polygon's own tolerance.
    #[test]
    fn dilated_regions_are_where_some_error_collides() {
        let seed = 11;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let parameters = Parameters::default();
        let (tail, errors) = (Tail::new(&parameters), Errors::new(&parameters));
        for region in CollisionRegion::all(&tail, &tail.reachable_offsets()) {
            for tube in Tube::ALL {
                let half = [errors.of(tube); 2];
                let dilated =
                    CollisionRegion::placed_at(region.offset(), errors.dilate(tube, &region.polygons()[0]));
                let (mut inside, mut outside) = (0, 0);
                for _ in 0..4_000 {
                    let pose = [0, 1].map(|k| region.centre()[k] + rng.random_range(-1.0..1.0));
                    let collides = |half: [f64; 2]| {
                        (0..400).any(|k| {
                            let share = [k / 20, k % 20].map(|k| f64::from(k) / 9.5 - 1.0);
                            let at = [0, 1].map(|k| pose[k] + share[k] * half[k]);
                            tail.clearance_m(region.offset(), at[0], at[1]) < 0.0
                        })
                    };
                    if collides(half) {
                        inside += 1;
                        assert!(dilated.contains(pose), "seed {seed}: {pose:?} for {tube:?}");
                    } else if !collides(half.map(|half| half + 4.0 * DEPTH_RAD)) {
                        outside += 1;
                        assert!(!dilated.contains(pose), "seed {seed}: {pose:?} for {tube:?}");
                    }
                }
                assert!(inside > 500 && outside > 500, "{inside} {outside}");
            }
        }
    }
}
