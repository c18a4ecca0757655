//! Least clearance between tails in a plan: as planned, as modules may execute it, and if some modules miss it.
//!
//! The tube about a motion comes nearer than the motion by at most what both tips move within their errors, 2·L·e. So the hexagon of
//! a pair is looked at only where its motion is that near to the least found.

use super::{Setting, swim_ends, turn_ends};
use crate::motion::Swing;
use crate::pairs::Pair;
use crate::planner_config::LawOfTime;
use crate::tail::CLEARANCE_TOLERANCE_M;
use crate::transition::STILL_RAD;
use crate::tube::Tube;
use crate::way::Steps;

/// Least distances between the surfaces of two tails, m; +∞ if no two tails can meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clearance {
    /// As planned.
    pub(super) planned_m: f64,
    /// For tails as far off as modules let them be; `None` where transitions go at constant speed, which no motor follows.
    pub(super) kept_m: Option<f64>,
}

impl Setting {
    /// Over these steps of a transition and this cycle.
    ///
    /// A few poses of every motion are looked at first: the nearest of them bounds both distances, so that most motions need no
    /// closer look.
    pub(super) fn clearance(&self, steps: Steps<'_>, slow: bool, cycle: &[Swing]) -> Clearance {
        let guaranteed = self.config.law() == LawOfTime::RestToRest;
        let (tail, offsets, errors) = (self.distance.tail(), self.distance.offsets(), self.distance.errors());
        let mut nearest = (f64::INFINITY, None);
        self.motions(steps, slow, cycle, |pair, tube, [from, to]| {
            let offset = offsets[pair.offset];
            let (sampled_m, pose) = tail.nearest_sample(offset, from, to);
            if sampled_m < nearest.0 {
                nearest = (sampled_m, Some((offset, pose, errors.of(tube))));
            }
        });
        let mut planned_m = nearest.0;
        let mut kept_m = nearest.1.map_or(f64::INFINITY, |(offset, [i, j], e)| {
            let corners = [[e, e], [e, -e], [-e, e], [-e, -e]].into_iter();
            corners.fold(planned_m, |least, [a, b]| least.min(tail.clearance_m(offset, i + a, j + b)))
        });
        self.motions(steps, slow, cycle, |pair, tube, [from, to]| {
            let offset = offsets[pair.offset];
            if !guaranteed {
                planned_m = tail.least_along_m(offset, from, to, planned_m);
                return;
            }
            let error_rad = errors.of(tube);
            let near_m = kept_m + 2.0 * tail.length_m * error_rad;
            let own_m = tail.least_along_m(offset, from, to, planned_m.max(near_m));
            planned_m = planned_m.min(own_m);
            if own_m < near_m {
                kept_m = tail.tube_clearance_m(offset, from, to, error_rad, kept_m.min(own_m));
            }
        });
        Clearance { planned_m, kept_m: guaranteed.then_some(kept_m) }
    }

    /// Calls `look` with every pair whose angles are known, in the swim cycle and in each step, with the tube to keep about its motion.
    fn motions(
        &self,
        steps: Steps<'_>,
        slow: bool,
        cycle: &[Swing],
        mut look: impl FnMut(&Pair, Tube, [[f64; 2]; 2]),
    ) {
        let known = || self.pairs.all().iter().filter(|pair| !self.is_unknown(pair));
        for pair in known() {
            let moves = [pair.i, pair.j].map(|module| cycle[module].amplitude_rad != 0.0);
            look(pair, Tube::of(moves), swim_ends(cycle, pair));
        }
        for step in steps.iter() {
            for pair in known() {
                let moves =
                    [pair.i, pair.j].map(|module| step.turn(module).rotation_rad().abs() >= STILL_RAD);
                let tube = match Tube::of(moves) {
                    Tube::Both if slow => Tube::Slow,
                    tube => tube,
                };
                look(pair, tube, turn_ends(step, pair));
            }
        }
    }

    /// Whether each pair stays clear with only i moving, and with only j; both moving is known to be. Of two steps a module
    /// may miss both, or the second: then it rests between them.
    pub(super) fn loss_tolerant(&self, steps: Steps<'_>, cycle: &[Swing], tails: &[f64]) -> bool {
        let (tail, offsets) = (self.distance.tail(), self.distance.offsets());
        let error_rad =
            (self.config.law() == LawOfTime::RestToRest).then(|| self.distance.errors().of(Tube::One));
        // Beside a tail whose angle is unknown nothing changes if a plan is missed.
        self.pairs.all().iter().filter(|pair| !self.is_unknown(pair)).all(|pair| {
            let offset = offsets[pair.offset];
            let free = |from: [f64; 2], to: [f64; 2]| match error_rad {
                Some(error_rad) => {
                    // Only its sign is asked for: what is certainly above twice the tolerance needs no closer look.
                    tail.tube_clearance_m(offset, from, to, error_rad, 2.0 * CLEARANCE_TOLERANCE_M) > 0.0
                }
                None => !tail.collides_along(offset, from, to),
            };
            let clear = |rest: [f64; 2], [from, to]: [[f64; 2]; 2]| {
                free([from[0], rest[1]], [to[0], rest[1]]) && free([rest[0], from[1]], [rest[0], to[1]])
            };
            let rest = [tails[pair.i], tails[pair.j]];
            let between = steps.via_rad.map(|via_rad| [via_rad[pair.i], via_rad[pair.j]]);
            // A tail that rests out of reach is in no other's way.
            let reach = &self.reaches[pair.offset];
            let away = |rest: [f64; 2]| reach.clears(0, rest[0]) && reach.clears(1, rest[1]);
            if away(rest) && between.is_none_or(away) {
                return true;
            }
            let motions = steps.iter().map(|step| turn_ends(step, pair)).chain([swim_ends(cycle, pair)]);
            motions.enumerate().all(|(phase, ends)| {
                clear(rest, ends) && between.filter(|_| phase > 0).is_none_or(|rest| clear(rest, ends))
            })
        })
    }
}
