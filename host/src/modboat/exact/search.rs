//! The search for a cycle: from where the tails rest if that will do, from other rest poses if not.
//!
//! *Staying.* From the cycle before, Newton's method alone meets most demands of a closed loop. If not, coordinate descent
//! looks for other amplitudes, unless the margin of the present rest poses ([`Orientation`]) says that there are none. In
//! structures of up to [`SMALL`] modules, which have little to spare, all patterns of signs are gone through.
//!
//! *Turning.* Rest poses are chosen for the demand and those about it, then amplitudes as before, then the way there. Of
//! small structures many choices are tried, and the one is taken from which most demands about this one can be met without
//! turning again.
//!
//! Everything is deterministic: randomness comes from the seed in the settings alone.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::allocation::{Aim, Allocation, Met};
use super::approach;
use super::law::Law;
use super::neighbours::{Cycle, Rules};
use super::orientation::Orientation;
use super::rest::RestPoses;
use crate::modboat::motion::{Swing, Turn, Wrench};
use crate::modboat::setting::{Approach, Setting};
use crate::modboat::transition::solver::Solver;
use crate::quantity::wrap_rad;

/// Structures of so few modules are searched through.
const SMALL: usize = 4;
/// Structures of so few modules have little to spare: more is tried.
const FEW: usize = 8;
/// Choices that meet the demand among which theirs is chosen.
const COMPARED_FEW: usize = 8;
/// Choices of rest poses tried for them, and for larger ones until one meets the demand.
const CHOICES_SMALL: usize = 60;
const CHOICES_MOST: usize = 48;
const CHOICES_LEAST: usize = 8;
/// Choices times modules, between the two.
const CHOICES_MODULES: usize = 800;
/// Sweeps of coordinate descent.
const SWEEPS: usize = 3;
/// Starts of coordinate descent from given rest poses: of modules that can spare them, and of fewer.
const STARTS: usize = 3;
const STARTS_FEW: usize = 8;
/// Rounds of taking back what neighbours do not allow.
const ROUNDS: usize = 8;
/// Amplitudes to start Newton's method from, rad.
const STARTS_RAD: [f64; 3] = [1.75, 1.2, 2.3];
/// The amplitude that leaves most room either way, rad.
const MIDDLE_RAD: f64 = 1.75;
/// A cycle belongs to where a tail is if it starts no further from it, rad.
const SAME_RAD: f64 = 1e-6;
/// Chance that a small structure's module is not turned in a choice of rest poses.
const STAYS: f64 = 0.4;
/// Distances to the demands about one, as shares of the envelope along each axis.
const ABOUT: [f64; 2] = [0.1, 0.25];
/// What the net amplitude, ΣA in units of all amplitudes, costs against the share of demands about one that are met. The
/// rotors turn the structure against it.
const BALANCE: f64 = 0.2;

/// What was found for a demand.
#[derive(Clone, Debug)]
pub struct Found {
    /// Each module's cycle.
    pub cycle: Vec<Swing>,
    /// The way there; `None` where the tails' angles are not known.
    pub approach: Option<Approach>,
    /// Relative weighted error; zero where it is met to rounding.
    pub error: f64,
    /// Whether it meets the demand to rounding.
    pub met: bool,
}

/// The search, with the memory it works in.
#[derive(Clone, Debug)]
pub struct Search {
    rest: RestPoses,
    law: Law,
    orientation: Orientation,
    allocation: Allocation,
    solver: Solver,
    /// Modules in the order in which they are visited.
    order: Vec<usize>,
    poses_rad: Vec<f64>,
    kept: Vec<Cycle>,
    best: Vec<Cycle>,
    /// The envelope's extent along the weighted axes, N.
    extent_n: [f64; 3],
}

impl Search {
    /// For one structure.
    #[must_use]
    pub fn new(setting: &Setting) -> Self {
        let rest = RestPoses::new(setting);
        let law = Law::new(&setting.parameters);
        let thrust_max_n = setting.parameters.thrust_n(setting.parameters.amplitude_max_rad);
        let orientation = Orientation::new(&setting.positions_m, &rest, &law, thrust_max_n);
        let weights = setting.config.weights;
        let modules = setting.cells.len();
        let mut order: Vec<usize> = (0..modules).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(setting.config.seed));
        let levers_m: f64 = setting.positions_m.iter().map(|[x, y]| x.hypot(*y)).sum();
        let extent_n = [
            weights[0] * thrust_max_n * modules as f64,
            weights[1] * thrust_max_n * modules as f64,
            weights[2] * thrust_max_n * levers_m,
        ];
        Self {
            rest,
            law,
            orientation,
            allocation: Allocation::new(&setting.positions_m, weights),
            solver: Solver::default(),
            order,
            poses_rad: vec![0.0; modules],
            kept: Vec::with_capacity(modules),
            best: Vec::with_capacity(modules),
            extent_n,
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

    fn aim(&self, setting: &Setting, demand: Wrench) -> Aim {
        let (weights, demand) = (setting.config.weights, demand.to_array());
        let thrust_max_n = setting.parameters.thrust_n(setting.parameters.amplitude_max_rad);
        let [least_rad, most_rad] = self.law.range_rad;
        Aim {
            target_n: [0, 1, 2].map(|k| weights[k] * demand[k]),
            amplitude_rad: MIDDLE_RAD.clamp(least_rad, most_rad),
            pull_n2_rad2: (0.02 * thrust_max_n).powi(2),
            recentre: 0.3,
            turn_rests: false,
            rounds: ROUNDS,
        }
    }

    /// Cycles that start where the tails rest. The nearest found, if none meets the demand; `None` if a tail must not stay
    /// where it is.
    pub fn stay(
        &mut self,
        setting: &Setting,
        demand: Wrench,
        tails: &[f64],
        previous: Option<&[Swing]>,
        loss_tolerant: bool,
    ) -> Option<Found> {
        if !self.may_stay(tails) {
            return None;
        }
        let aim = self.aim(setting, demand);
        self.best.clear();
        let continued =
            previous.and_then(|cycle| self.continue_cycle(setting, &aim, tails, cycle, loss_tolerant));
        if continued.is_none() {
            let at_rest = |(module, &tail_rad): (usize, &f64)| self.rest.cycle(module, tail_rad, 0.0);
            self.allocation.begin(tails.iter().enumerate().map(at_rest));
        }
        let mut met = continued.unwrap_or(Met::No);
        let tails_rad = tails.iter().copied();
        if met != Met::Yes && self.orientation.margin(&self.law, tails_rad, demand.to_array()) >= 0.0 {
            met = if tails.len() <= SMALL {
                self.all_signs(setting, &aim, tails, loss_tolerant)
            } else {
                self.descend(setting, &aim, tails, loss_tolerant, continued.is_some())
            };
        }
        let turns = tails.iter().map(|&tail| Turn { from_rad: tail, to_rad: tail }).collect();
        let cycle: Vec<Swing> = self.allocation.cycles.iter().map(|cycle| cycle.swing()).collect();
        Some(Found {
            error: setting.error(demand, setting.wrench(&cycle)),
            cycle,
            approach: Some(Approach { turns, via_rad: None, transition_s: 0.0 }),
            met: met == Met::Yes,
        })
    }

    /// From the amplitudes of the cycle before, where they start at the tails; `None` if they are not allowed there.
    fn continue_cycle(
        &mut self,
        setting: &Setting,
        aim: &Aim,
        tails: &[f64],
        previous: &[Swing],
        loss_tolerant: bool,
    ) -> Option<Met> {
        let Self { rest, law, allocation, .. } = self;
        let rules = Rules { setting, loss_tolerant };
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
        setting: &Setting,
        aim: &Aim,
        tails: &[f64],
        loss_tolerant: bool,
        near: bool,
    ) -> Met {
        let Self { rest, law, allocation, order, .. } = self;
        let rules = Rules { setting, loss_tolerant };
        let starts = if tails.len() <= FEW { STARTS_FEW } else { STARTS };
        for start in 0..starts {
            // First from what could not be polished, if that is near; then from rest.
            if start > 0 || !near {
                let at_rest = |(module, &tail_rad): (usize, &f64)| rest.cycle(module, tail_rad, 0.0);
                allocation.begin(tails.iter().enumerate().map(at_rest));
            }
            let shift = start * order.len() / starts;
            for _ in 0..SWEEPS {
                let order = order[shift..].iter().chain(&order[..shift]).copied();
                allocation.descend(&rules, law, aim, order);
            }
            if allocation.polish(&rules, rest, law, aim) == Met::Yes {
                return Met::Yes;
            }
        }
        Met::No
    }

    /// By Newton's method from every pattern of signs, resting modules included; of those that meet the aim the one with
    /// most room about it.
    fn all_signs(&mut self, setting: &Setting, aim: &Aim, tails: &[f64], loss_tolerant: bool) -> Met {
        let Self { rest, law, allocation, kept, best, extent_n, .. } = self;
        let rules = Rules { setting, loss_tolerant };
        let mut score = f64::NEG_INFINITY;
        for pattern in 0..3_u32.pow(tails.len() as u32) {
            let sign = |module: usize| f64::from(pattern / 3_u32.pow(module as u32) % 3) - 1.0;
            let met = STARTS_RAD.iter().any(|&start_rad| {
                allocation.begin(tails.iter().enumerate().map(|(module, &rest_rad)| {
                    let amplitude_rad = sign(module) * start_rad.clamp(law.range_rad[0], law.range_rad[1]);
                    rest.cycle(module, rest_rad, amplitude_rad)
                }));
                allocation.allowed(&rules, law) && allocation.polish(&rules, rest, law, aim) == Met::Yes
            });
            if met {
                let own = merit(allocation, &rules, rest, law, aim, extent_n, kept);
                if own > score {
                    score = own;
                    best.clone_from(kept);
                }
            }
        }
        if score == f64::NEG_INFINITY {
            return Met::No;
        }
        allocation.begin(best.iter().copied());
        Met::Yes
    }

    /// Cycles from other rest poses, with the way there. The nearest found, if none meets the demand; `None` if no way was
    /// found.
    pub fn turn(
        &mut self,
        setting: &Setting,
        demand: Wrench,
        tails: Option<&[f64]>,
        loss_tolerant: bool,
    ) -> Option<Found> {
        let plain = self.aim(setting, demand);
        let Self { rest, law, allocation, order, orientation, poses_rad, solver, kept, extent_n, .. } = self;
        let rules = Rules { setting, loss_tolerant };
        let (small, few) = (order.len() <= SMALL, order.len() <= FEW);
        let mut compared = 0;
        let mut rng = ChaCha8Rng::seed_from_u64(setting.config.seed);
        let mut best: Option<(Found, f64)> = None;
        let choices = if small {
            CHOICES_SMALL
        } else {
            (CHOICES_MODULES / order.len()).clamp(CHOICES_LEAST, CHOICES_MOST)
        };
        for choice in 0..choices {
            for (module, pose_rad) in poses_rad.iter_mut().enumerate() {
                let here = tails.map(|tails| tails[module]).filter(|&tail| rest.may_stay(module, tail));
                *pose_rad = match here {
                    Some(tail_rad) if choice < 2 || few && rng.random_bool(STAYS) => tail_rad,
                    _ => {
                        let stations = rest.stations_rad(module);
                        stations[rng.random_range(0..stations.len())]
                    }
                };
            }
            // Small structures are offered poses at random too.
            if !small || choice % 3 == 0 {
                orientation.orient(law, rest, demand.to_array(), poses_rad, order);
            }
            let pull_n2_rad2 = if choice % 4 < 2 { plain.pull_n2_rad2 } else { 0.0 };
            let aim = Aim { turn_rests: choice % 2 == 1, pull_n2_rad2, ..plain };
            allocation.begin(
                poses_rad.iter().enumerate().map(|(module, &pose_rad)| rest.cycle(module, pose_rad, 0.0)),
            );
            let shift = choice * order.len() / choices;
            for _ in 0..SWEEPS {
                let order = order[shift..].iter().chain(&order[..shift]).copied();
                allocation.descend(&rules, law, &aim, order);
            }
            let met = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            let mut cycle: Vec<Swing> = allocation.cycles.iter().map(|cycle| cycle.swing()).collect();
            let error = setting.error(demand, setting.wrench(&cycle));
            let score =
                if met && small { merit(allocation, &rules, rest, law, &plain, extent_n, kept) } else { 0.0 };
            let better = best.as_ref().is_none_or(|(found, most)| match (met, found.met) {
                (true, true) => score > *most,
                (met, other) => met && !other || met == other && error < found.error,
            });
            if !better {
                continue;
            }
            let approach = match tails {
                None => None,
                Some(tails) => {
                    let way = approach::find(solver, setting, rest, tails, &mut cycle, loss_tolerant);
                    let Some(way) = way else { continue };
                    Some(way)
                }
            };
            best = Some((Found { cycle, approach, error, met }, score));
            compared += usize::from(met);
            if met && !few || compared >= COMPARED_FEW && !small {
                break;
            }
        }
        best.map(|(found, _)| found)
    }
}

/// How good a cycle's rest poses are for what may come next: the share of the demands about the aim that can be met from
/// them too, less what its net amplitude costs. Leaves the cycles as they were, also in `kept`.
fn merit(
    allocation: &mut Allocation,
    rules: &Rules<'_>,
    rest: &RestPoses,
    law: &Law,
    aim: &Aim,
    extent_n: &[f64; 3],
    kept: &mut Vec<Cycle>,
) -> f64 {
    kept.clear();
    kept.extend_from_slice(&allocation.cycles);
    let (mut met, mut tried) = (0.0, 0.0);
    for radius in ABOUT {
        // The six ways along the axes and the eight between them.
        for code in 0..27 {
            let way = [code % 3, code / 3 % 3, code / 9].map(|digit| f64::from(digit) - 1.0);
            let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !matches!(way.iter().filter(|x| **x != 0.0).count(), 1 | 3) {
                continue;
            }
            let target_n = [0, 1, 2].map(|k| aim.target_n[k] + radius * way[k] / length * extent_n[k]);
            let about = Aim { target_n, recentre: 0.0, turn_rests: false, rounds: 0, ..*aim };
            met += f64::from(allocation.polish(rules, rest, law, &about) == Met::Yes);
            tried += 1.0;
            allocation.begin(kept.iter().copied());
        }
    }
    let net_rad: f64 = kept.iter().map(|cycle| cycle.amplitude_rad).sum();
    let all_rad: f64 = kept.iter().map(|cycle| cycle.amplitude_rad.abs()).sum();
    met / tried - BALANCE * if all_rad > 0.0 { net_rad.abs() / all_rad } else { 0.0 }
}
