//! The search for a cycle: from where the tails rest if that will do, from other rest poses if not.
//!
//! *Staying.* From the cycle before, Newton's method alone meets most demands of a closed loop. If not, coordinate descent
//! looks for other amplitudes, unless the margin of the present rest poses ([`Orientation`]) says that there are none. In
//! structures of up to four modules, which have little to spare, all patterns of signs are gone through.
//!
//! *Turning* is in [`turning`](super::turning).
//!
//! Everything is deterministic: randomness comes from the seed in the settings alone.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;

use super::allocation::{Aim, Allocation, GOAL, Met, Poses};
use super::asked::Quiet;
use super::choice::{Choice, FEW, SMALL};
use super::law::{Law, Sign};
use super::merit::Merit;
use super::neighbours::{Cycle, Rules};
use super::orientation::{Orientation, may_hold};
use super::rest::RestPoses;
use super::wobble::Wobble;
use crate::buffers::Buffers;
use crate::motion::{Swing, Turn, Wrench};
use crate::planner_config::LossTolerance;
use crate::potential_field::PotentialField;
use crate::setting::{Approach, Case, Setting};
use crate::transition::solver::Solver;
use quantity::wrap_rad;

/// Starts of coordinate descent from given rest poses: of modules that can spare them, and of fewer.
const STARTS: usize = 3;
const STARTS_FEW: usize = 4;
/// Below this margin one start has to do.
const SMALL_MARGIN: f64 = 0.05;
/// Amplitudes to start Newton's method from, rad.
const STARTS_RAD: [f64; 3] = [1.75, 1.2, 2.3];
/// Patterns of signs that meet the demand among which one is chosen.
const COMPARED: usize = 4;
/// What a change of the net amplitude costs where signs change, against the share of demands about one that are met, 1/rad.
const JUMP_1_RAD: f64 = 0.1;
/// What a pattern is worth in which any module may stop anywhere, where that is preferred: more than all else.
const STOPS_CLEAR: f64 = 1.0;
/// The amplitude that leaves most room either way, rad.
const MIDDLE_RAD: f64 = 1.75;
/// A cycle belongs to where a tail is if it starts no further from it, rad.
const SAME_RAD: f64 = 1e-6;

/// A cycle found for a demand, with the transition before it.
#[derive(Debug)]
pub struct CycleCandidate {
    /// Each module's cycle.
    pub cycle: Vec<Swing>,
    /// The way there; `None` where the tails' angles are not known.
    pub approach: Option<Approach>,
    /// Relative weighted error; zero where it is met to rounding.
    pub error: f64,
    /// Whether it meets the demand to rounding.
    pub met: bool,
}

impl CycleCandidate {
    /// Takes the place of another.
    pub(super) fn replace(self, other: &mut Option<Self>, buffers: &mut Buffers) {
        if let Some(other) = other.replace(self) {
            other.discard(buffers);
        }
    }

    /// Gives back what it is held in.
    pub(super) fn discard(self, buffers: &mut Buffers) {
        buffers.keep(self.cycle, self.approach);
    }
}

/// How cycles are looked for that start where the tails rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Staying {
    /// From the cycle before alone.
    Continued,
    /// In all ways.
    Searched,
}

/// The search for cycles, with its workspace.
#[derive(Clone, Debug)]
pub struct Search {
    pub(super) rest: RestPoses,
    pub(super) law: Law,
    pub(super) orientation: Orientation,
    pub(super) allocation: Allocation,
    pub(super) solver: Solver,
    pub(super) merit: Merit,
    pub(super) wobble: Wobble,
    /// Algorithm 1, where all modules take part.
    pub(super) field: Option<Box<PotentialField>>,
    /// Modules in the order in which they are visited.
    pub(super) order: Vec<usize>,
    pub(super) poses_rad: Vec<f64>,
    /// What each module is to push, N in S.
    pub(super) thrusts_n: Vec<[f64; 2]>,
    /// The best of several.
    pub(super) best: Vec<Cycle>,
    /// Patterns of signs with the most that their merit can be, best first.
    patterns: Vec<(f64, u32)>,
    /// Choices of rest poses.
    pub(super) choices: Vec<Choice>,
    /// What cycles found, and plans, are held in.
    pub(super) buffers: Buffers,
}

/// What is taken off the merit of cycles that start where the tails rest.
#[derive(Clone, Copy)]
enum Change {
    /// Nothing.
    Free,
    /// ΣA was this, rad: the structure turns by its change as the mean of the tails' angles does.
    Net(f64),
    /// How far they turn the structure.
    Quiet(Quiet),
}

impl Search {
    /// A search for the structure of `setting`.
    #[must_use]
    pub fn new(setting: &Setting) -> Self {
        let rest = RestPoses::new(setting);
        let law = Law::new(&setting.parameters);
        let orientation = Orientation::new(&setting.positions_m, &setting.parameters, &rest, &law);
        let weights = setting.config.weights;
        let modules = setting.cells.len();
        let mut order: Vec<usize> = (0..modules).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(setting.config.seed));
        let merit = Merit::new(&setting.positions_m, &setting.parameters, weights, &orientation);
        let Setting { cells, positions_m, pairs, parameters, config, .. } = setting;
        let field = || Box::new(PotentialField::new(cells, positions_m, pairs, parameters, config));
        let stations = (0..modules).map(|module| rest.stations_rad(module).len()).max().unwrap_or(0);
        let offered = stations * law.amplitudes_rad.len();
        Self {
            rest,
            law,
            orientation,
            allocation: Allocation::new(&setting.positions_m, &setting.parameters, weights, offered),
            solver: Solver::with_room(pairs),
            order,
            merit,
            wobble: Wobble::new(positions_m, parameters),
            field: setting.all_active().then(field),
            poses_rad: vec![0.0; modules],
            thrusts_n: Vec::with_capacity(modules),
            best: Vec::with_capacity(modules),
            patterns: Vec::with_capacity(if modules <= SMALL { 3_usize.pow(modules as u32) } else { 0 }),
            choices: Vec::new(),
            buffers: Buffers::new(modules),
        }
    }

    /// Whether every module has a free pose to rest in.
    #[must_use]
    pub fn all_free(&self) -> bool {
        (0..self.order.len()).all(|module| self.rest.has_free(module))
    }

    /// Whether all tails are where a cycle may start.
    #[must_use]
    pub fn may_stay(&self, tails: &[f64]) -> bool {
        tails.iter().enumerate().all(|(module, &tail_rad)| self.rest.may_stay(module, tail_rad))
    }

    /// See [`Wobble::unrest_rad`].
    pub(super) fn unrest_rad(&self, cycle: &[Swing], tails_rad: &[f64], about_rad: f64) -> f64 {
        let one = |swing: &Swing| Cycle {
            rest_rad: swing.start_rad(),
            amplitude_rad: swing.amplitude_rad,
            ..Cycle::default()
        };
        self.wobble.unrest_rad(&cycle.iter().map(one).collect::<Vec<_>>(), tails_rad, about_rad)
    }

    pub(super) fn aim(&self, setting: &Setting, demand: Wrench) -> Aim {
        let (weights, demand) = (setting.config.weights, demand.to_array());
        let thrust_max_n = setting.parameters.thrust_n(setting.parameters.amplitude_max_rad);
        let [least_rad, most_rad] = self.law.range_rad;
        Aim {
            target_n: [0, 1, 2].map(|k| weights[k] * demand[k]),
            amplitude_rad: MIDDLE_RAD.clamp(least_rad, most_rad),
            pull_n2_rad2: (0.02 * thrust_max_n).powi(2),
            recentre: 0.3,
            goal: GOAL,
            roams: false,
        }
    }

    /// Cycles that start where the tails rest. The nearest found, if none meets the demand; `None` if a tail must not stay
    /// where it is.
    pub fn stay(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        tails: &[f64],
        previous: Option<&[Swing]>,
        loss_tolerant: bool,
        staying: Staying,
    ) -> Option<CycleCandidate> {
        if !self.may_stay(tails) {
            return None;
        }
        let aim = self.aim(&case, demand);
        self.best.clear();
        let continued =
            previous.and_then(|cycle| self.continue_cycle(case, &aim, tails, cycle, loss_tolerant));
        if continued.is_none() {
            if staying == Staying::Continued {
                return None;
            }
            let at_rest = |(module, &tail_rad): (usize, &f64)| self.rest.cycle(module, tail_rad, 0.0);
            self.allocation.begin(tails.iter().enumerate().map(at_rest));
        }
        let mut met = continued.unwrap_or(Met::No);
        let margin = |search: &mut Self| {
            search.orientation.margin(&search.law, tails.iter().copied(), demand.to_array())
        };
        // Collisions aside nothing could meet the demand where the margin is below zero; with them little does where it is small.
        if met != Met::Yes
            && staying == Staying::Searched
            && let margin = margin(self)
            && margin >= 0.0
        {
            met = if tails.len() <= SMALL {
                let net_rad = |cycle: &[Swing]| cycle.iter().map(|swing| swing.amplitude_rad).sum();
                let change =
                    continued.and(previous).map_or(Change::Free, |cycle| Change::Net(net_rad(cycle)));
                self.all_signs(Rules { case, loss_tolerant }, &aim, demand, tails, change)
            } else {
                self.descend(case, &aim, tails, loss_tolerant, continued.is_some(), margin)
            };
        }
        Some(self.stayed(case, demand, tails, met))
    }

    /// Of few modules, cycles that start where the tails rest and turn the structure little; `None` if none meets the demand.
    pub(super) fn stay_still(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        tails: &[f64],
        quiet: Quiet,
    ) -> Option<CycleCandidate> {
        let aim = self.aim(&case, demand);
        let rules = Rules { case, loss_tolerant: true };
        let met = self.all_signs(rules, &aim, demand, tails, Change::Quiet(quiet));
        (met == Met::Yes).then(|| self.stayed(case, demand, tails, met))
    }

    /// The cycles of the allocation, with no way to go.
    fn stayed(&mut self, case: Case<'_>, demand: Wrench, tails: &[f64], met: Met) -> CycleCandidate {
        let turns = self.buffers.turns(tails.iter().map(|&tail| Turn { from_rad: tail, to_rad: tail }));
        let cycle = self.buffers.cycle(self.allocation.cycles.iter().map(|cycle| cycle.swing()));
        CycleCandidate {
            error: case.error(demand, case.wrench(&cycle)),
            cycle,
            approach: Some(Approach { turns, ..Approach::default() }),
            met: met == Met::Yes,
        }
    }

    /// From the amplitudes of the cycle before, where they start at the tails; `None` if they are not allowed there.
    fn continue_cycle(
        &mut self,
        case: Case<'_>,
        aim: &Aim,
        tails: &[f64],
        previous: &[Swing],
        loss_tolerant: bool,
    ) -> Option<Met> {
        let Self { rest, law, allocation, .. } = self;
        let rules = Rules { case, loss_tolerant };
        allocation.begin(tails.iter().zip(previous).enumerate().map(|(module, (&rest_rad, swing))| {
            let same = wrap_rad(swing.start_rad() - rest_rad).abs() < SAME_RAD;
            rest.cycle(module, rest_rad, if same { swing.amplitude_rad } else { 0.0 })
        }));
        // What was given as the cycle before need not be one of this planner's, under these rules.
        if !allocation.allowed(&rules, law) {
            return None;
        }
        Some(allocation.polish(&rules, rest, law, aim))
    }

    /// By coordinate descent: from where the allocation is, if that is `near`, and from rest.
    fn descend(
        &mut self,
        case: Case<'_>,
        aim: &Aim,
        tails: &[f64],
        loss_tolerant: bool,
        near: bool,
        margin: f64,
    ) -> Met {
        let Self { rest, law, allocation, order, .. } = self;
        let rules = Rules { case, loss_tolerant };
        let starts = match tails.len() {
            _ if margin < SMALL_MARGIN => 1,
            ..=FEW => STARTS_FEW,
            _ => STARTS,
        };
        for start in 0..starts {
            // First from what could not be polished, if that is near; then from rest.
            if start > 0 || !near {
                let at_rest = |(module, &tail_rad): (usize, &f64)| rest.cycle(module, tail_rad, 0.0);
                allocation.begin(tails.iter().enumerate().map(at_rest));
            }
            let shift = start * order.len() / starts;
            allocation.descend(&rules, rest, law, aim, Poses::Kept, order, shift);
            if allocation.polish(&rules, rest, law, aim) == Met::Yes {
                return Met::Yes;
            }
        }
        Met::No
    }

    /// By Newton's method from every pattern of signs, resting modules included, that may meet the demand; of those that meet the
    /// aim the one with most room about it.
    fn all_signs(
        &mut self,
        rules: Rules<'_>,
        aim: &Aim,
        demand: Wrench,
        tails: &[f64],
        change: Change,
    ) -> Met {
        let Self { rest, law, allocation, orientation, wobble, best, merit, patterns, .. } = self;
        let sign = |pattern: u32, module: usize| f64::from(pattern / 3_u32.pow(module as u32) % 3) - 1.0;
        patterns.clear();
        for pattern in 0..3_u32.pow(tails.len() as u32) {
            let modules = tails.iter().enumerate().map(|(m, &tail)| (tail, Sign::of(sign(pattern, m))));
            let slacks = orientation.slacks(law, modules, demand.to_array());
            if may_hold(slacks) {
                patterns.push((merit.at_most(slacks), pattern));
            }
        }
        patterns.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        // Where they are asked for, all are.
        let preferred = if rules.case.tolerance == LossTolerance::Prefer { STOPS_CLEAR } else { 0.0 };
        let (mut score, mut compared) = (f64::NEG_INFINITY, 0);
        let enough = if matches!(change, Change::Quiet(_)) { usize::MAX } else { COMPARED };
        for &(at_most, pattern) in patterns.iter() {
            if at_most + preferred <= score || compared >= enough {
                break;
            }
            let met = STARTS_RAD.iter().any(|&start_rad| {
                allocation.begin(tails.iter().enumerate().map(|(module, &rest_rad)| {
                    let amplitude_rad =
                        sign(pattern, module) * start_rad.clamp(law.range_rad[0], law.range_rad[1]);
                    rest.cycle(module, rest_rad, amplitude_rad)
                }));
                allocation.allowed(&rules, law) && allocation.polish(&rules, rest, law, aim) == Met::Yes
            });
            compared += usize::from(met);
            let about = (aim, demand.to_array());
            let (jump, room) = match change {
                Change::Free => (0.0, f64::NEG_INFINITY),
                Change::Net(before_rad) => {
                    let net_rad: f64 = allocation.cycles.iter().map(|cycle| cycle.amplitude_rad).sum();
                    (JUMP_1_RAD * (net_rad - before_rad).abs(), f64::NEG_INFINITY)
                }
                Change::Quiet(Quiet { about_rad, price_1_rad, room }) => {
                    (price_1_rad * wobble.unrest_rad(&allocation.cycles, tails, about_rad), room)
                }
            };
            let stops = met && preferred > 0.0 && allocation.allowed(&rules.stopping(), law);
            let bonus = if stops { preferred } else { 0.0 };
            let least = (score + jump - bonus).max(room);
            if met && let Some(own) = merit.of(allocation, orientation, &rules, rest, law, about, least) {
                score = own - jump + bonus;
                best.clone_from(&allocation.cycles);
            }
        }
        if score == f64::NEG_INFINITY {
            // Whatever was tried last need not be allowed.
            let at_rest = |(module, &tail_rad): (usize, &f64)| rest.cycle(module, tail_rad, 0.0);
            allocation.begin(tails.iter().enumerate().map(at_rest));
            return Met::No;
        }
        allocation.begin(best.iter().copied());
        Met::Yes
    }
}
