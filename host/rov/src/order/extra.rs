//! What orders cost at least above the cheapest assignment because others rest at starts and in slots.
//!
//! A robot on its way from start i into slot s pays c(i, s) at least, and e(i, s, p) above it while place p is taken. u and v are the potentials of
//! the cheapest [`assignment`](super::assignment) at c, so that no pair costs less than u_i + v_s:
//!
//! ```text
//! r(i, s) = c(i, s) − u_i − v_s ≥ 0
//! D(∅) = 0,   D(x) = min over i, s, one of them in x, of   r(i, s) + max over p of e(i, s, p) + D(x∖{i, s})
//! an order from a state on costs at least   Σ u_i (starts taken) + Σ v_s (slots empty) + D(x)
//! ```
//!
//! x are those of the *watched* starts that are taken and of the watched slots that are empty; p goes over the watched places that are taken then,
//! i apart. Every order takes x apart, one hop after the other, and each such hop costs what D counts or more; every hop of two places that are not
//! watched costs u_i + v_s at least. So D is below every order, and where all places are watched it is the least over all orders at these costs.
//! Detours around several places at once cost no less than around the one of them that counts. Without parking.
//!
//! Places are watched that stand in the way of many cheap pairs, `WATCHED_MOST` of them: D has 2^that many values.

use std::ops::ControlFlow;
use std::sync::OnceLock;

use super::assignment::{Assignment, Costs};
use super::{DESKS, GoesOn, MOST, Workers};

/// Most places that are watched: 16 MB, and some 4 s of one core.
const WATCHED_MOST: usize = 22;
/// So many are tried first, which takes 0.05 s; where that is not worth this factor of the cheapest assignment, more are not either.
const WATCHED_FEW: usize = 16;
const WORTH: f64 = 1.005;
/// D is worked out in blocks of 2^this many values, several at a time.
const BLOCK_BITS: usize = 16;
/// A pair this share of the mean cost of a pair above the cheapest assignment counts for 1/e in the choice of places.
const DEAR: f64 = 0.4;
/// A detour counts for so many means at most there.
const FAR: f64 = 2.0;

/// What sums in single precision may be too great by.
const ROUNDING: f64 = 1.0 - 1e-5;

/// What a robot pays from a start to a slot at least: with nothing in its way, and more while others rest in some places.
#[derive(Clone, Debug, Default)]
pub struct Pair {
    /// With nothing in its way, J or m.
    pub least: f64,
    /// Places, as [`taken`] numbers them, and what is paid above `least` while one of them is taken; infinite if it is shut.
    pub above: Vec<(u32, f64)>,
}

/// Places as bits: start k is bit k, slot k bit [`MOST`] + k.
#[must_use]
pub const fn taken(starts: u32, slots: u32) -> u32 {
    starts | slots << MOST
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Extra {
    count: usize,
    /// [start][slot]: what counts while places are taken, greatest first.
    pairs: Vec<Vec<(u32, f64)>>,
    /// u and v.
    potentials: [[f64; MOST]; 2],
    /// Watched places, and bits of x that are starts.
    watched: Vec<usize>,
    starts: u32,
    blocks: Vec<Vec<f32>>,
}

/// A hop as D sees it: bits of x that it clears, its cost, and what else it costs while one of these bits tells a place taken.
struct Step {
    clears: u32,
    cost: f32,
    above: Vec<(u32, f32)>,
}

impl Extra {
    /// Of as many robots as slots, `[start][slot]`; `None` where a pair is not allowed. None if there is no assignment.
    ///
    /// # Errors
    /// If `goes_on`, which is asked now and then, says so.
    pub fn new(
        pairs: &[Vec<Option<Pair>>],
        workers: &dyn Workers,
        goes_on: &mut GoesOn<'_>,
    ) -> ControlFlow<(), Option<Self>> {
        let few = Self::watching(WATCHED_FEW, pairs, workers, goes_on)?;
        let all = ((1_u64 << pairs.len()) - 1) as u32;
        let Some(found) = few else { return ControlFlow::Continue(None) };
        let assigned: f64 = found.potentials.iter().flatten().sum();
        if found.watched.len() < WATCHED_FEW || found.of(all, 0) < WORTH * assigned {
            return ControlFlow::Continue(Some(found));
        }
        Self::watching(WATCHED_MOST, pairs, workers, goes_on)
    }

    fn watching(
        most: usize,
        pairs: &[Vec<Option<Pair>>],
        workers: &dyn Workers,
        goes_on: &mut GoesOn<'_>,
    ) -> ControlFlow<(), Option<Self>> {
        let count = pairs.len();
        let mut costs: Costs = [[f64::INFINITY; MOST]; MOST];
        for (row, pairs) in costs.iter_mut().zip(pairs) {
            for (cost, pair) in row.iter_mut().zip(pairs) {
                *cost = pair.as_ref().map_or(f64::INFINITY, |pair| pair.least);
            }
        }
        let Some(cheapest) = Assignment::new(&costs, count, count) else {
            return ControlFlow::Continue(None);
        };
        let sorted = |pair: &Option<Pair>| {
            let mut above = pair.as_ref().map_or_else(Vec::new, |pair| pair.above.clone());
            above.sort_by(|a, b| b.1.total_cmp(&a.1));
            above
        };
        let mut extra = Self {
            count,
            pairs: pairs.iter().flatten().map(sorted).collect(),
            potentials: cheapest.potentials(),
            watched: Vec::new(),
            starts: 0,
            blocks: Vec::new(),
        };
        extra.watch(most, &costs, cheapest.cost / count as f64);
        let steps = extra.steps(&costs);
        extra.work_out(&steps, workers, goes_on)?;
        ControlFlow::Continue(Some(extra))
    }

    fn reduced(&self, costs: &Costs, start: usize, slot: usize) -> f64 {
        (costs[start][slot] - self.potentials[0][start] - self.potentials[1][slot]).max(0.0)
    }

    /// Chooses the places that are watched.
    fn watch(&mut self, most: usize, costs: &Costs, mean: f64) {
        let mut weights = [0.0; 2 * MOST];
        for (index, above) in self.pairs.iter().enumerate() {
            let dear = self.reduced(costs, index / self.count, index % self.count) / (DEAR * mean);
            for &(place, more) in above.iter().filter(|_| dear.is_finite()) {
                for bit in bits(place) {
                    weights[bit] += (-dear).exp() * more.min(FAR * mean);
                }
            }
        }
        let places = (0..self.count).chain(MOST..MOST + self.count);
        let mut places: Vec<usize> = places.collect();
        places.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]).then(a.cmp(&b)));
        // What is in no way tells of the assignment alone, which is known otherwise.
        let in_the_way = places.iter().filter(|&&bit| weights[bit] > 0.0).count();
        places.truncate(most.min(in_the_way.max(WATCHED_FEW)));
        self.starts = bits_of(&places, |bit| bit < MOST);
        self.watched = places;
    }

    /// Bits of x for these places.
    fn bits_of_x(&self, places: u32) -> u32 {
        bits_of(&self.watched, |bit| places >> bit & 1 == 1)
    }

    fn steps(&self, costs: &Costs) -> Vec<Step> {
        let mut steps = Vec::new();
        for (index, above) in self.pairs.iter().enumerate() {
            let (start, slot) = (index / self.count, index % self.count);
            let cost = self.reduced(costs, start, slot);
            let clears = self.bits_of_x(taken(1 << start, 1 << slot));
            if clears == 0 || !cost.is_finite() {
                continue;
            }
            let above = above.iter().map(|&(places, more)| (self.bits_of_x(places), rounded_down(more)));
            let above = above.filter(|(places, _)| *places != 0).collect();
            steps.push(Step { clears, cost: rounded_down(cost), above });
        }
        // The cheap ones first: they make most of the others not worth a look.
        steps.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        steps
    }

    /// D of every x, in blocks of equal upper bits; those with as many of them wait for none of each other.
    fn work_out(
        &mut self,
        steps: &[Step],
        workers: &dyn Workers,
        goes_on: &mut GoesOn<'_>,
    ) -> ControlFlow<()> {
        let upper = self.watched.len().saturating_sub(BLOCK_BITS);
        let lower = self.watched.len() - upper;
        let cells: Vec<OnceLock<Vec<f32>>> = (0..1_usize << upper).map(|_| OnceLock::new()).collect();
        for level in 0..=upper as u32 {
            let level: Vec<usize> = (0..cells.len()).filter(|block| block.count_ones() == level).collect();
            for group in level.chunks(DESKS) {
                workers.run(group.len(), &|job| {
                    // Each number comes once.
                    let _ = cells[group[job]].set(self.block(group[job], lower, steps, &cells));
                });
                goes_on()?;
            }
        }
        self.blocks = cells.into_iter().map(|cell| cell.into_inner().unwrap_or_default()).collect();
        ControlFlow::Continue(())
    }

    fn block(&self, block: usize, lower: usize, steps: &[Step], known: &[OnceLock<Vec<f32>>]) -> Vec<f32> {
        let mask = (1_u32 << lower) - 1;
        let none = Vec::new();
        // Below and including this one.
        let others: Vec<&Vec<f32>> = known.iter().map(|other| other.get().unwrap_or(&none)).collect();
        let mut own: Vec<f32> = Vec::with_capacity(1 << lower);
        for low in 0..1_u32 << lower {
            let x = (block as u32) << lower | low;
            let present = self.present(x);
            let mut least = if x == 0 { 0.0 } else { f32::INFINITY };
            for step in steps.iter().filter(|step| x & step.clears == step.clears) {
                if step.cost >= least {
                    break;
                }
                let after = x & !step.clears;
                let before = (after >> lower) as usize;
                let rest = if before == block {
                    own[(after & mask) as usize]
                } else {
                    others[before][(after & mask) as usize]
                };
                if step.cost + rest < least {
                    let sum = step.cost + rest + most(&step.above, present & !(step.clears & self.starts));
                    least = least.min(sum);
                }
            }
            own.push(least);
        }
        own
    }

    /// Bits of x whose places are taken: starts that are set, slots that are not.
    const fn present(&self, x: u32) -> u32 {
        x & self.starts | !x & !self.starts
    }

    /// What is paid at least from a state on.
    #[must_use]
    pub fn of(&self, taken_starts: u32, filled: u32) -> f64 {
        let sum = |set: u32, potentials: &[f64; MOST]| bits(set).map(|k| potentials[k]).sum::<f64>();
        let empty = !filled & ((1_u64 << self.count) - 1) as u32;
        let x = self.bits_of_x(taken(taken_starts, empty)) as usize;
        let lower = self.watched.len().min(BLOCK_BITS);
        let above = ROUNDING * f64::from(self.blocks[x >> lower][x & ((1 << lower) - 1)]);
        sum(taken_starts, &self.potentials[0]) + sum(empty, &self.potentials[1]) + above
    }

    /// What one hop costs at least above what it costs with nothing in its way.
    #[must_use]
    pub fn of_hop(&self, (start, slot): (usize, usize), taken_starts: u32, filled: u32) -> f64 {
        let others = taken(taken_starts & !(1 << start), filled);
        let above = self.pairs[start * self.count + slot].iter();
        above.clone().find(|(places, _)| places & others != 0).map_or(0.0, |(_, more)| *more)
    }
}

/// The greatest of those that count, which come greatest first.
fn most(above: &[(u32, f32)], present: u32) -> f32 {
    above.iter().find(|(places, _)| places & present != 0).map_or(0.0, |(_, more)| *more)
}

/// Single precision, never above.
fn rounded_down(value: f64) -> f32 {
    let single = value as f32;
    if f64::from(single) > value { single.next_down() } else { single }
}

fn bits(set: u32) -> impl Iterator<Item = usize> {
    (0..u32::BITS as usize).filter(move |bit| set >> bit & 1 == 1)
}

/// Numbers of the places that are told, as bits.
fn bits_of(places: &[usize], of: impl Fn(usize) -> bool) -> u32 {
    places.iter().enumerate().filter(|(_, place)| of(**place)).fold(0, |set, (k, _)| set | 1 << k)
}

#[cfg(test)]
mod tests;
