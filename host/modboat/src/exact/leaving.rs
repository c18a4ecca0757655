//! Out of the neighbours' reach, so that any module may miss it: turns to free rest poses and no swim.
//!
//! Where a tail rests within a neighbour's reach, hardly any swim of that neighbour is one that the tail may miss. So it leaves
//! first. Every module that rests in a neighbour's reach is offered its free poses, either way round, and to stay where it is;
//! of each pair both moving, only i, only j must keep clear. What leaves the fewest tails in reach, then travels least, is a problem
//! for [`choice`](crate::transition::choice). A module that stays is offered the same in the next plan, when others are out of the
//! way.
//!
//! *There is always one that can go.* What one tail forbids another, with the first at rest, is one interval of angles within ±reach
//! of the direction to it. The tail stands on one side of it, and on that side its way to the nearest free pose is open: no third
//! tail comes there, as that pose is out of every reach. Where reach exceeds π/4 there are modules without a free pose, and this
//! has nothing to offer.

use crate::buffers::Buffers;
use crate::motion::{Swing, Turn};
use crate::setting::{Approach, Case, Setting};
use crate::transition::choice::{Answer, Chooser, OPTIONS_MAX};
use crate::transition::solver::{Clearance, rotations};

use super::approach::Turning;
use super::rest::RestPoses;

/// What a tail costs that stays in a neighbour's reach, as if it travelled so far, rad.
const STAYS_RAD: f64 = 1e3;
/// What a tail costs that does not come to rest where it is wanted, rad.
const ELSEWHERE_RAD: f64 = 20.0;

/// The search for turns out of reach, with its workspace.
#[derive(Clone, Debug, Default)]
pub struct Leaving {
    chooser: Chooser,
    /// Where a module may turn to, by module from `first` on, least travel first.
    to_rad: Vec<f64>,
    first: Vec<usize>,
}

impl Leaving {
    /// With room for plans of one structure.
    #[must_use]
    pub fn new(setting: &Setting) -> Self {
        let mut leaving = Self::default();
        let modules = setting.cells.len();
        leaving.chooser.reserve(&setting.pairs);
        leaving.to_rad.reserve(OPTIONS_MAX * (modules + 4));
        leaving.first.reserve(modules + 1);
        leaving
    }

    /// Turns out of reach from `tails`, if need be slowly, and the rest that follows. `None` where no tail has to leave, or none can.
    /// Where free poses are `wanted`, tails turn to those if they can, also such that may stay.
    pub fn find(
        &mut self,
        case: Case<'_>,
        rest: &RestPoses,
        tails: &[f64],
        wanted: Option<&[f64]>,
        slow: bool,
        buffers: &mut Buffers,
    ) -> Option<(Vec<Swing>, Approach)> {
        let Self { chooser, to_rad, first, .. } = self;
        chooser.clear();
        to_rad.clear();
        first.clear();
        first.push(0);
        for (module, &tail_rad) in tails.iter().enumerate() {
            let start = to_rad.len();
            let offer = |to_rad: &mut Vec<f64>, pose_rad: f64| {
                let ways = rotations(tail_rad, pose_rad, case.rotation_max_rad());
                to_rad.extend(ways.map(|rotation_rad| tail_rad + rotation_rad));
            };
            let pose_rad =
                wanted.map(|poses_rad| poses_rad[module]).filter(|&pose| rest.is_free(module, pose));
            if let Some(pose_rad) = pose_rad {
                offer(to_rad, pose_rad);
            }
            let others = to_rad.len();
            let stays = rest.may_stay(module, tail_rad);
            if !stays {
                for &pose_rad in rest.stations_rad(module) {
                    offer(to_rad, pose_rad);
                }
                let travel_rad = |to_rad: &f64| (to_rad - tail_rad).abs();
                to_rad[others..].sort_unstable_by(|a, b| travel_rad(a).total_cmp(&travel_rad(b)));
                to_rad.truncate(start + OPTIONS_MAX - 1);
            }
            let elsewhere_rad = if pose_rad.is_some() { ELSEWHERE_RAD } else { 0.0 };
            let stays_rad = if stays { elsewhere_rad } else { STAYS_RAD };
            let cost_rad = |(option, to_rad): (usize, &f64)| {
                (to_rad - tail_rad).abs() + if start + option < others { 0.0 } else { elsewhere_rad }
            };
            chooser.module(to_rad[start..].iter().enumerate().map(cost_rad).chain([stays_rad]));
            to_rad.push(tail_rad);
            first.push(to_rad.len());
        }
        let (pairs, clear) = (&case.pairs, Turning { case, slow });
        let answer = chooser.choose(pairs, |index, option_i, option_j| {
            let pair = &pairs.all()[index];
            let from = [tails[pair.i], tails[pair.j]];
            let to = [to_rad[first[pair.i] + option_i], to_rad[first[pair.j] + option_j]];
            let stays = [0, 1].map(|k| to[k].to_bits() == from[k].to_bits());
            (stays[0] && stays[1])
                || clear.turn(pair, from, to)
                    && (stays[0]
                        || stays[1]
                        || clear.turn(pair, from, [to[0], from[1]])
                            && clear.turn(pair, from, [from[0], to[1]]))
        });
        if !matches!(answer, Answer::Best { .. }) {
            return None;
        }
        let chosen = tails.iter().zip(chooser.chosen()).zip(first.iter());
        let turns = buffers.turns(chosen.map(|((&from_rad, &option), first)| Turn {
            from_rad,
            to_rad: to_rad[first + usize::from(option)],
        }));
        let longest_rad = turns.iter().map(|turn| turn.rotation_rad().abs()).fold(0.0, f64::max);
        let rests = |turn: &Turn| Swing { centerline_rad: turn.to_rad, amplitude_rad: 0.0 };
        let cycle = buffers.cycle(turns.iter().map(rests));
        let times = [case.step_time(longest_rad, slow); 2];
        let approach = Approach { turns, via_rad: None, times, slow };
        if longest_rad > 0.0 {
            return Some((cycle, approach));
        }
        buffers.keep(cycle, Some(approach));
        None
    }
}
