//! Cycles from other rest poses, for a demand that cannot be met from the present ones.
//!
//! Choices of rest poses are made one after another: first the present ones, turned a little, then poses that raise the
//! margin at the demand ([`Orientation`](super::orientation::Orientation)) from ever other starts. For each the amplitudes
//! follow as when staying, then the way there. Of many modules the first choice that meets the demand is taken. Few have
//! less to spare, so that among those that meet it the one is taken from which most demands about this one can be met
//! without turning again ([`merit`](super::merit)), less what the tails travel. They are tried in the order of what they can be worth at
//! most.
//!
//! What cannot be met from free rest poses is looked for among the cycles of Algorithm 1, polished.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::allocation::{Aim, Met, Poses};
use super::approach;
use super::asked::{Asked, Quiet};
use super::choice::{Choice, FEW, SMALL};
use super::law::Sign;
use super::neighbours::Cycle;
use super::orientation::may_hold;
use super::search::{CycleCandidate, Search};
use crate::motion::{Swing, Wrench, ends};
use crate::setting::Case;

/// How long few modules are looked for.
#[derive(Clone, Copy)]
struct Effort {
    /// Choices of rest poses made.
    choices: usize,
    /// Of these so many at most are tried, best first.
    tried: usize,
    /// So many that meet the demand are compared.
    compared: usize,
}

/// Where the tails are not known yet, or rest in a neighbour's reach as at the start.
const FIRST: Effort = Effort { choices: 120, tried: 120, compared: 120 };
/// Of fewer than [`SMALL`] modules, of as many, of up to [`FEW`].
const FEWER: Effort = Effort { choices: 64, tried: 24, compared: 10 };
const AS_SMALL: Effort = Effort { choices: 36, tried: 14, compared: 6 };
/// Of as few, where the quietest is looked for.
const QUIET: Effort = Effort { choices: 300, tried: 300, compared: 300 };
const MORE: Effort = Effort { choices: 10, tried: 10, compared: 1 };

impl Effort {
    fn of(modules: usize, once: bool) -> Self {
        match modules {
            ..=SMALL if once => FIRST,
            ..SMALL => FEWER,
            SMALL => AS_SMALL,
            _ => MORE,
        }
    }
}

/// Choices tried for larger ones: so many modules altogether, between two bounds.
const CHOICES_MODULES: usize = 800;
const CHOICES_LEAST: usize = 8;
const CHOICES_MOST: usize = 48;
/// In so many choices no tail turns that may stay where it is.
const STAYING: usize = 2;
/// Starts of a descent over all rest poses where no choice meets the demand: so many modules altogether, between two bounds.
const STARTS_MODULES: usize = 200;
const STARTS_LEAST: usize = 2;
const STARTS_MOST: usize = 24;
/// Chance that one of few modules is not turned in a choice of rest poses.
const STAYS: f64 = 0.4;
/// Below what any price leaves of a merit: the demand is out of what such rest poses can push. So many of these are tried.
const OUT: f64 = -1e3;
const NEAREST: usize = 4;

/// The best so far.
#[derive(Default)]
pub(super) struct Best {
    pub(super) found: Option<CycleCandidate>,
    score: f64,
    /// How many that meet the demand were compared.
    compared: usize,
}

impl Best {
    /// Whether it meets the demand.
    pub(super) fn met(&self) -> bool {
        self.found.as_ref().is_some_and(|found| found.met)
    }
}

impl Search {
    /// Cycles from other rest poses, with the way there. The nearest found, if none meets the demand; `None` if no way was
    /// found. Where the tails are known and may stay, the allocation must hold cycles that start there.
    pub fn turn(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        tails: Option<&[f64]>,
        loss_tolerant: bool,
    ) -> Option<CycleCandidate> {
        let modules = self.order.len();
        let once = !tails.is_some_and(|tails| self.may_stay(tails));
        let signs = approach::signs(&self.rest, modules);
        let asked = Asked { case, demand, tails, loss_tolerant, signs, once, quiet: None };
        let mut rng = ChaCha8Rng::seed_from_u64(case.config.seed);
        let mut best = Best::default();
        let starts = (STARTS_MODULES / modules).clamp(STARTS_LEAST, STARTS_MOST);
        if modules > FEW {
            let count = (CHOICES_MODULES / modules).clamp(CHOICES_LEAST, CHOICES_MOST);
            self.try_some(&asked, Poses::Kept, count, &mut rng, &mut best);
        } else {
            self.try_best(&asked, Effort::of(modules, once), &mut rng, &mut best);
        }
        // Near the border few rest poses hold a demand: descended to together with the amplitudes.
        self.try_some(&asked, Poses::Offered, starts, &mut rng, &mut best);
        best.found
    }

    /// Of few modules, cycles that turn the structure little, now as after, and have room about them, wherever they start. The allocation must hold cycles that start at `tails`.
    pub(super) fn quietest(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        tails: &[f64],
        quiet: Quiet,
    ) -> Option<CycleCandidate> {
        let signs = approach::signs(&self.rest, self.order.len());
        let tails = Some(tails);
        let asked =
            Asked { case, demand, tails, loss_tolerant: true, signs, once: false, quiet: Some(quiet) };
        let mut rng = ChaCha8Rng::seed_from_u64(case.config.seed);
        let mut best = Best::default();
        self.try_best(&asked, QUIET, &mut rng, &mut best);
        best.found
    }

    /// So many choices one after another, until one meets the demand.
    fn try_some(
        &mut self,
        asked: &Asked<'_>,
        poses: Poses,
        count: usize,
        rng: &mut ChaCha8Rng,
        best: &mut Best,
    ) {
        // Descents begin at choices in which tails turn.
        let skipped = if poses == Poses::Offered { STAYING } else { 0 };
        for number in 0..count {
            if best.met() {
                break;
            }
            self.choose(asked, skipped + number, rng);
            self.try_choice(asked, number, number * self.order.len() / count, poses, best);
        }
    }

    /// Of few modules: the tails turned a little, then choices in the order of what they can be worth.
    fn try_best(&mut self, asked: &Asked<'_>, effort: Effort, rng: &mut ChaCha8Rng, best: &mut Best) {
        let modules = self.order.len();
        if !asked.once {
            self.turn_a_little(asked, effort.compared, best);
        }
        self.collect(asked, effort.choices, rng);
        for place in 0..self.choices.len() {
            let Choice { number, at_most, .. } = self.choices[place];
            let enough = best.compared >= effort.compared || place >= effort.tried;
            let no_better = at_most <= best.score && asked.quiet.is_none();
            if best.met() && (no_better || enough) || at_most < OUT && place >= NEAREST {
                break;
            }
            self.poses_rad.clear();
            self.poses_rad.extend_from_slice(&self.choices[place].poses_rad[..modules]);
            let first = number * modules / effort.choices;
            self.try_choice(asked, number, first, Poses::Kept, best);
        }
    }

    /// From where the tails are, turned within their free arcs: all, or one after another, until so many that meet the demand are
    /// compared.
    fn turn_a_little(&mut self, asked: &Asked<'_>, compared: usize, best: &mut Best) {
        self.best.clone_from(&self.allocation.cycles);
        let aim = self.aim(&asked.case, asked.demand);
        let rules = asked.rules();
        for turning in 0..=self.order.len() {
            if best.compared >= compared {
                break;
            }
            let Self { allocation, rest, law, best: cycles, .. } = &mut *self;
            let turns = |module: usize| turning == 0 || module + 1 == turning;
            allocation.begin(cycles.iter().enumerate().map(|(m, &cycle)| Cycle { turns: turns(m), ..cycle }));
            let met = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            self.weigh(asked, met, best);
        }
    }

    /// So many choices, best first by the most that they can be worth; last those that cannot meet the demand, the nearest
    /// first.
    fn collect(&mut self, asked: &Asked<'_>, choices: usize, rng: &mut ChaCha8Rng) {
        let modules = self.order.len();
        self.choices.clear();
        // Once for all that may come.
        self.choices.reserve(QUIET.choices);
        for number in 0..choices {
            self.choose(asked, number, rng);
            let Self { law, orientation, merit, poses_rad, .. } = &mut *self;
            let poses = poses_rad.iter().map(|&pose_rad| (pose_rad, Some(Sign::Any)));
            let slacks = orientation.slacks(law, poses, asked.demand.to_array());
            let at_most = if may_hold(slacks) {
                merit.at_most(slacks) - asked.price(poses_rad.iter().copied())
            } else {
                slacks.iter().fold(0.0, |least: f64, &slack| least.min(slack)) + 2.0 * OUT
            };
            let mut choice = Choice { number, at_most, poses_rad: [0.0; FEW] };
            choice.poses_rad[..modules].copy_from_slice(poses_rad);
            self.choices.push(choice);
        }
        self.choices.sort_unstable_by(|a, b| b.at_most.total_cmp(&a.at_most).then(a.number.cmp(&b.number)));
    }

    /// Amplitudes for the choice of rest poses at hand, or for others from there, if there are any. The module at the place
    /// `first` is the first to choose.
    fn try_choice(&mut self, asked: &Asked<'_>, number: usize, first: usize, poses: Poses, best: &mut Best) {
        let plain = self.aim(&asked.case, asked.demand);
        let rules = asked.rules();
        let Self { allocation, rest, law, order, poses_rad, .. } = &mut *self;
        let turns = number % 2 == 1 || poses == Poses::Offered;
        allocation.begin(poses_rad.iter().enumerate().map(|(module, &pose_rad)| {
            // A tail that stays stays to the bit.
            let stays = poses == Poses::Kept
                && asked.tails.is_some_and(|tails| tails[module].to_bits() == pose_rad.to_bits());
            Cycle { turns: turns && !stays, ..rest.cycle(module, pose_rad, 0.0) }
        }));
        let pull_n2_rad2 = if number % 4 < 2 { plain.pull_n2_rad2 } else { 0.0 };
        let aim = Aim { pull_n2_rad2, ..plain };
        allocation.descend(&rules, rest, law, &aim, poses, order, first);
        let met = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
        self.weigh(asked, met, best);
    }

    /// Keeps the cycles of the allocation if they are better than the best so far: of few modules, by their merit.
    fn weigh(&mut self, asked: &Asked<'_>, met: bool, best: &mut Best) {
        let mut score = 0.0;
        if met && self.order.len() <= FEW {
            let poses_rad = || self.allocation.cycles.iter().map(|cycle| cycle.rest_rad);
            let price = match (asked.quiet, asked.tails) {
                (Some(_), _) if asked.pushes(poses_rad()) => return,
                (Some(Quiet { about_rad, price_1_rad, .. }), Some(tails)) => {
                    price_1_rad * self.wobble.unrest_rad(&self.allocation.cycles, tails, about_rad)
                }
                _ => asked.price(poses_rad()),
            };
            let least = if best.met() { best.score + price } else { f64::NEG_INFINITY };
            let least = asked.quiet.map_or(least, |quiet| least.max(quiet.room));
            // No merit is above one: what travels too far need not be looked at.
            if least >= 1.0 {
                return;
            }
            best.compared += 1;
            let aim = self.aim(&asked.case, asked.demand);
            let Self { allocation, orientation, rest, law, merit, .. } = &mut *self;
            let about = (&aim, asked.demand.to_array());
            let Some(own) = merit.of(allocation, orientation, &asked.rules(), rest, law, about, least) else {
                return;
            };
            score = own - price;
        }
        self.consider(asked, met, score, best);
    }

    /// Cycles of Algorithm 1, polished, wherever they start.
    pub fn turn_by_field(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
    ) -> Option<CycleCandidate> {
        let mut field = self.field.take()?;
        let distance = &case.distance;
        let swim = |offset: usize, i: Swing, j: Swing, margin_rad: f64| {
            distance.along_bounded(offset, ends(i, j), margin_rad)
        };
        let aim = Aim { recentre: 0.0, ..self.aim(&case, demand) };
        let asked = Asked::plainly(case, demand, tails);
        let rules = asked.rules();
        let mut best = Best::default();
        for candidate in field.solve(demand, previous, &swim) {
            self.begin_at(&candidate.cycle);
            let Self { allocation, rest, law, .. } = &mut *self;
            if !allocation.allowed(&rules, law) {
                continue;
            }
            let met = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            self.consider(&asked, met, 0.0, &mut best);
            if best.met() {
                break;
            }
            if !met {
                // Polished it is nearer, or there is no way to it: then as it was.
                self.begin_at(&candidate.cycle);
                self.consider(&asked, false, 0.0, &mut best);
            }
        }
        self.field = Some(field);
        best.found
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

    /// The next choice of rest poses.
    fn choose(&mut self, asked: &Asked<'_>, number: usize, rng: &mut ChaCha8Rng) {
        let Self { rest, law, order, orientation, poses_rad, .. } = self;
        let modules = order.len();
        let few = modules <= FEW;
        poses_rad.clear();
        poses_rad.extend((0..modules).map(|module| {
            let here = asked.tails.map(|tails| tails[module]).filter(|&tail| rest.may_stay(module, tail));
            match here {
                Some(tail_rad) if number < STAYING || few && rng.random_bool(STAYS) => tail_rad,
                _ => {
                    let stations = rest.stations_rad(module);
                    stations[rng.random_range(0..stations.len())]
                }
            }
        }));
        // Small structures are offered poses at random too.
        if !few || number.is_multiple_of(if modules <= SMALL { 3 } else { 8 }) {
            orientation.orient(law, rest, asked.demand.to_array(), poses_rad, order);
        }
    }

    /// Keeps the cycles of the allocation if they are better than the best so far and there is a way to them.
    pub(super) fn consider(&mut self, asked: &Asked<'_>, met: bool, score: f64, best: &mut Best) {
        let Asked { case, demand, tails, .. } = *asked;
        let mut cycle = self.buffers.cycle(self.allocation.cycles.iter().map(|cycle| cycle.swing()));
        let error = case.error(demand, case.wrench(&cycle));
        let better = best.found.as_ref().is_none_or(|found| match (met, found.met) {
            (true, true) => score > best.score,
            (met, other) => met && !other || met == other && error < found.error,
        });
        if !better {
            self.buffers.keep(cycle, None);
            return;
        }
        let approach = match tails {
            None => None,
            Some(tails) => {
                let Self { solver, rest, buffers, .. } = self;
                let way = approach::find(solver, buffers, rest, asked, tails, &mut cycle);
                if way.is_none() {
                    self.buffers.keep(cycle, None);
                    return;
                }
                way
            }
        };
        best.score = score;
        CycleCandidate { cycle, approach, error, met }.replace(&mut best.found, &mut self.buffers);
    }
}
