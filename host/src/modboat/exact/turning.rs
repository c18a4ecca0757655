//! Cycles from other rest poses, for a demand that cannot be met from the present ones.
//!
//! Choices of rest poses are made one after another: first the present ones, turned a little, then poses that raise the
//! margin at the demand ([`Orientation`](super::orientation::Orientation)) from ever other starts. For each the amplitudes
//! follow as when staying, then the way there. Of many modules the first choice that meets the demand is taken. Few have
//! less to spare, so that among those that meet it the one is taken from which most demands about this one can be met
//! without turning again ([`merit`](super::merit)), less what the tails travel.
//!
//! What cannot be met from free rest poses is looked for among the cycles of Algorithm 1, polished.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::allocation::{Aim, Met};
use super::approach;
use super::neighbours::{Cycle, Rules};
use super::search::{FEW, Found, SMALL, SWEEPS, Search};
use crate::modboat::motion::{Swing, Wrench};
use crate::modboat::potential_field::PotentialField;
use crate::modboat::setting::{Setting, ends};
use crate::modboat::transition::solver::Signs;
use crate::quantity::wrap_rad;

/// Choices tried for small structures, and those that meet the demand among which few modules' is chosen.
const CHOICES_SMALL: usize = 80;
const CHOICES_FIRST: usize = 120;
const COMPARED_FEW: usize = 8;
/// Choices tried for larger ones: so many modules altogether, between two bounds.
const CHOICES_MODULES: usize = 800;
const CHOICES_LEAST: usize = 8;
const CHOICES_MOST: usize = 48;
/// So many times more where none of them meets the demand.
const LONGER: usize = 3;
/// Chance that one of few modules is not turned in a choice of rest poses.
const STAYS: f64 = 0.4;
/// What turning the tails by a radian each costs against the share of demands about one that are met, 1/rad. Three modules
/// must turn now and then whatever they do: little.
const TRAVEL_1_RAD: f64 = 0.3;
const TRAVEL_OF_THREE_1_RAD: f64 = 2.0;

/// The best so far.
pub(super) struct Best {
    pub(super) found: Found,
    score: f64,
}

impl Search {
    /// Cycles from other rest poses, with the way there. The nearest found, if none meets the demand; `None` if no way was
    /// found. Where the tails are known and may stay, the allocation must hold cycles that start there.
    pub fn turn(
        &mut self,
        setting: &Setting,
        demand: Wrench,
        tails: Option<&[f64]>,
        loss_tolerant: bool,
    ) -> Option<Found> {
        let modules = self.order.len();
        let signs = approach::signs(&self.rest, modules);
        let plain = self.aim(setting, demand);
        let rules = Rules { setting, loss_tolerant };
        let mut rng = ChaCha8Rng::seed_from_u64(setting.config.seed);
        let choices = match modules {
            // Where the tails are not known all is open, and it happens once.
            ..=SMALL if tails.is_none() => CHOICES_FIRST,
            ..=SMALL => CHOICES_SMALL,
            _ => (CHOICES_MODULES / modules).clamp(CHOICES_LEAST, CHOICES_MOST),
        };
        let here = tails.filter(|tails| modules <= FEW && self.may_stay(tails));
        self.best.clone_from(&self.allocation.cycles);
        let price_1_rad = if modules < SMALL { TRAVEL_OF_THREE_1_RAD } else { TRAVEL_1_RAD };
        // What is taken off a score for the tails' travel by the shortest way.
        let price = |cycles: &[Cycle]| {
            let travel_rad: f64 = tails.map_or(0.0, |tails| {
                let cycles = cycles.iter().zip(tails);
                cycles.map(|(cycle, tail)| wrap_rad(cycle.rest_rad - tail).abs()).sum()
            });
            price_1_rad * travel_rad / modules as f64
        };
        let (mut best, mut compared): (Option<Best>, usize) = (None, 0);
        // Few modules go on for longer while none meets the demand.
        let most = if modules <= FEW { LONGER * choices } else { choices };
        for choice in 0..most {
            if choice >= choices && best.as_ref().is_some_and(|best| best.found.met) {
                break;
            }
            let turned_here = here.is_some() && choice <= modules;
            if turned_here {
                // Everybody, or one after another, from where they are.
                let all = choice == 0;
                self.allocation.begin(
                    self.best
                        .iter()
                        .enumerate()
                        .map(|(module, &cycle)| Cycle { turns: all || module + 1 == choice, ..cycle }),
                );
            } else {
                self.choose(setting, demand, tails, choice, &mut rng);
            }
            let Self { allocation, rest, law, order, merit, .. } = &mut *self;
            // No merit is above one: what travels too far need not be looked at.
            let hopeless = |cycles: &[Cycle], best: &Option<Best>| {
                modules <= FEW
                    && best.as_ref().is_some_and(|best| best.found.met && 1.0 - price(cycles) <= best.score)
            };
            if hopeless(&allocation.cycles, &best) {
                continue;
            }
            let pull_n2_rad2 = if choice % 4 < 2 { plain.pull_n2_rad2 } else { 0.0 };
            let aim = Aim { pull_n2_rad2, ..plain };
            let mut met = turned_here && allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            if !met {
                let shift = choice % choices * order.len() / choices;
                for _ in 0..SWEEPS {
                    let order = order[shift..].iter().chain(&order[..shift]).copied();
                    allocation.descend(&rules, law, &aim, order);
                }
                met = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            }
            let mut score = 0.0;
            if met && modules <= FEW {
                if hopeless(&allocation.cycles, &best) {
                    continue;
                }
                score = merit.of(allocation, &rules, rest, law, &plain) - price(&allocation.cycles);
                compared += 1;
            }
            self.consider(setting, demand, tails, signs, loss_tolerant, met, score, &mut best);
            if met && (modules > FEW || modules > SMALL && compared >= COMPARED_FEW) && best.is_some() {
                break;
            }
        }
        best.map(|best| best.found)
    }

    /// Cycles of Algorithm 1, polished, wherever they start.
    pub fn turn_by_field(
        &mut self,
        setting: &Setting,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
    ) -> Option<Found> {
        let Setting { cells, positions_m, pairs, parameters, config, distance, .. } = setting;
        let mut field = self
            .field
            .take()
            .unwrap_or_else(|| Box::new(PotentialField::new(cells, positions_m, pairs, parameters, config)));
        let swim = |offset: usize, i: Swing, j: Swing, margin_rad: f64| {
            let [from, to] = ends(i, j);
            distance.along_bounded(offset, from, to, margin_rad)
        };
        let aim = self.aim(setting, demand);
        let aim = Aim { recentre: 0.0, ..aim };
        let rules = Rules { setting, loss_tolerant: false };
        let mut best = None;
        for candidate in field.solve(demand, previous, &swim) {
            self.begin_at(&candidate.cycle);
            let Self { allocation, rest, law, .. } = &mut *self;
            if !allocation.allowed(&rules, law) {
                continue;
            }
            let met = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            self.consider(setting, demand, tails, Signs::PerModule, false, met, 0.0, &mut best);
            if met && best.is_some() {
                break;
            }
            if !met {
                // Polished it is nearer, or there is no way to it: then as it was.
                self.begin_at(&candidate.cycle);
                self.consider(setting, demand, tails, Signs::PerModule, false, false, 0.0, &mut best);
            }
        }
        self.field = Some(field);
        best.map(|best| best.found)
    }

    /// Puts given cycles in the allocation.
    fn begin_at(&mut self, cycle: &[Swing]) {
        let Self { allocation, rest, .. } = self;
        allocation.begin(
            cycle
                .iter()
                .enumerate()
                .map(|(module, swing)| rest.cycle(module, swing.start_rad(), swing.amplitude_rad)),
        );
    }

    /// The next choice of rest poses, everybody at rest.
    fn choose(
        &mut self,
        setting: &Setting,
        demand: Wrench,
        tails: Option<&[f64]>,
        choice: usize,
        rng: &mut ChaCha8Rng,
    ) {
        let Self { rest, law, allocation, order, orientation, poses_rad, .. } = self;
        let few = setting.cells.len() <= FEW;
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
        if setting.cells.len() > SMALL || choice.is_multiple_of(3) {
            orientation.orient(law, rest, demand.to_array(), poses_rad, order);
        }
        let turns = choice % 2 == 1;
        allocation.begin(poses_rad.iter().enumerate().map(|(module, &pose_rad)| {
            // Who stays stays to the bit.
            let stays = tails.is_some_and(|tails| tails[module].to_bits() == pose_rad.to_bits());
            Cycle { turns: turns && !stays, ..rest.cycle(module, pose_rad, 0.0) }
        }));
    }

    /// Keeps the cycles of the allocation if they are better than the best so far and there is a way to them.
    #[expect(clippy::too_many_arguments, reason = "one step of two loops")]
    pub(super) fn consider(
        &mut self,
        setting: &Setting,
        demand: Wrench,
        tails: Option<&[f64]>,
        signs: Signs,
        loss_tolerant: bool,
        met: bool,
        score: f64,
        best: &mut Option<Best>,
    ) {
        let mut cycle: Vec<Swing> = self.allocation.cycles.iter().map(|cycle| cycle.swing()).collect();
        let error = setting.error(demand, setting.wrench(&cycle));
        let better = best.as_ref().is_none_or(|best| match (met, best.found.met) {
            (true, true) => score > best.score,
            (met, other) => met && !other || met == other && error < best.found.error,
        });
        if !better {
            return;
        }
        let approach = match tails {
            None => None,
            Some(tails) => {
                let Self { solver, rest, .. } = self;
                let way = approach::find(solver, setting, rest, tails, &mut cycle, signs, loss_tolerant);
                if way.is_none() {
                    return;
                }
                way
            }
        };
        *best = Some(Best { found: Found { cycle, approach, error, met }, score });
    }
}
