//! A judge of execution: the true angles of the tails of a run, tick by tick, held against geometry and formulas of its own.
//!
//! The checker of plans ([`checker`](crate::checker)) asks whether a plan is free. This asks whether what came of it was:
//!
//! | asked | how |
//! |---|---|
//! | did tails touch | all pairs, between two ticks at samples between which no tip moves more than [`STEP_M`] |
//! | were they ever nearer than the plan guarantees | the pairs of which both run that cycle |
//! | did they keep to their plans | angle less planned angle, by phase, over the e that plans count on |
//! | were the clocks that good | a module's reckoning of the fleet time less the true time, while its tail moves |
//!
//! φ(t) = φ_planned(t + ε) + δ,   |ε| ≤ ε_c,   |δ| ≤ e_s: ε is what the simulation knows of the module's clock, δ what is left.
//!
//! What a tail is planned to do says the host's decision; which of them a module runs says the module, so that one that missed a
//! decision is expected to rest where it was. After a reboot it is expected to rest where it was found. Without power nothing is
//! expected of it, and it must not touch anybody all the same; a contact with such a tail is told apart where the plan under way was
//! not tolerant of a loss of power.
//!
//! Assumptions and limits: angles go straight from one tick to the next; at the motor's greatest acceleration that is wrong by 0.1 mrad.

pub use course::{Course, Phase, Step};
pub use report::{Limits, Near, Off, Report};

use crate::checker::{Modboat, Pair, STEP_M, geometry, pairs};

pub mod course;
pub mod draw;
mod report;
mod watch;

pub use watch::{Reboot, judged, limits_of};

/// A guarantee may be missed by so much, m: it is exact to a hundredth of a millimetre.
const ROUNDING_M: f64 = 1e-5;

/// One module at one tick.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// True angle of its tail, rad (unwrapped).
    pub angle_rad: f64,
    /// Whether it has power.
    pub powered: bool,
    /// The order that it runs, if it runs one.
    pub runs: Option<u32>,
    /// Fleet time by its own reckoning less the true one, s; zero while it knows none.
    pub clock_error_s: f64,
}

/// What a module is expected to do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Expected {
    /// Nothing.
    Powerless,
    /// To rest at this angle, rad.
    Rest(f64),
    /// This order of this course, and to rest after it.
    Order { course: usize, number: u32 },
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Judge {
    modboat: Modboat,
    pairs: Vec<Pair>,
    courses: Vec<Course>,
    expected: Vec<Expected>,
    /// By module: it lost its power and has begun no order since then; whether all plans under way since were tolerant of that.
    powerless: Vec<Option<bool>>,
    /// By module, at the tick before.
    angles_rad: Vec<f64>,
    /// By pair: the contact and the broken guarantee that last.
    lasting: Vec<[Option<usize>; 2]>,
    report: Report,
}

impl Judge {
    /// Of modules at `cells`.
    #[must_use]
    pub fn new(modboat: &Modboat, cells: &[[i32; 2]]) -> Self {
        let pairs = pairs(modboat, cells);
        Self {
            modboat: modboat.clone(),
            courses: Vec::new(),
            expected: vec![Expected::Powerless; cells.len()],
            powerless: vec![None; cells.len()],
            angles_rad: Vec::new(),
            lasting: vec![[None; 2]; pairs.len()],
            pairs,
            report: Report::default(),
        }
    }

    /// Takes in decision `index`; one that was changed takes the place of what it was.
    pub fn decided(&mut self, index: usize, course: Course) {
        self.courses.truncate(index);
        self.courses.push(course);
    }

    /// What was found so far.
    #[must_use]
    pub fn report(self) -> Report {
        self.report
    }

    /// Looks at all modules at the tick `t_s`, s of true time.
    pub fn observe(&mut self, t_s: f64, seen: &[Seen]) {
        if self.angles_rad.len() != seen.len() {
            self.angles_rad = seen.iter().map(|seen| seen.angle_rad).collect();
        }
        let under_way = |course: &&Course| (course.start_s..course.end_s()).contains(&t_s);
        let tolerant =
            self.courses.iter().rev().take(3).filter(under_way).all(|course| course.power_tolerant);
        for (module, seen) in seen.iter().enumerate() {
            self.expect(module, t_s, seen);
            self.measure(module, t_s, seen);
            self.powerless[module] = match self.powerless[module] {
                _ if seen.runs.is_some() => None,
                None if !seen.powered && !self.courses.is_empty() => Some(tolerant),
                so_far => so_far.map(|so_far| so_far && tolerant),
            };
        }
        for pair in 0..self.pairs.len() {
            self.look_at(pair, t_s, seen);
        }
        self.angles_rad.iter_mut().zip(seen).for_each(|(before, seen)| *before = seen.angle_rad);
        self.report.ticks += 1;
    }

    /// The planned angle of a module at `t_s` by its own reckoning, rad, and its phase.
    fn planned(&self, module: usize, t_s: f64) -> Option<(f64, Phase)> {
        match self.expected[module] {
            Expected::Powerless => None,
            Expected::Rest(rad) => Some((rad, Phase::Rest)),
            Expected::Order { course, number } => self.courses[course].planned(module, number, t_s),
        }
    }

    /// Finds out what a module is expected to do from now on.
    fn expect(&mut self, module: usize, t_s: f64, seen: &Seen) {
        let before = self.expected[module];
        let now = match (seen.powered, before, seen.runs) {
            (false, ..) => Expected::Powerless,
            (true, _, Some(number)) => match self.courses.iter().rposition(|course| course.has(number)) {
                Some(course) => Expected::Order { course, number },
                None => before,
            },
            (true, Expected::Powerless, None) => Expected::Rest(seen.angle_rad),
            (true, before, None) => before,
        };
        if now != before && before != Expected::Powerless && now != Expected::Powerless {
            let at = |judge: &Self| judge.planned(module, t_s + seen.clock_error_s).map(|(rad, _)| rad);
            let from_rad = at(self);
            self.expected[module] = now;
            if let (Some(from_rad), Some(to_rad)) = (from_rad, at(self)) {
                self.report.leap_rad = self.report.leap_rad.max(less_rad(to_rad, from_rad).abs());
            }
        }
        self.expected[module] = now;
    }

    /// How far off a module is.
    fn measure(&mut self, module: usize, t_s: f64, seen: &Seen) {
        let Some((planned_rad, phase)) = self.planned(module, t_s + seen.clock_error_s) else { return };
        self.report.off[phase as usize].add(less_rad(seen.angle_rad, planned_rad), (module, t_s));
        if phase != Phase::Rest {
            self.report.clock_s = self.report.clock_s.max(seen.clock_error_s.abs());
        }
    }

    /// How near the tails of a pair come from the tick before to this one.
    fn look_at(&mut self, index: usize, t_s: f64, seen: &[Seen]) {
        let pair = self.pairs[index];
        let [i, j] = [pair.i, pair.j].map(|module| [self.angles_rad[module], seen[module].angle_rad]);
        let length_m = self.modboat.tail_length_m;
        let tip_m = length_m * [i, j].map(|[from, to]| (to - from).abs()).into_iter().fold(0.0, f64::max);
        let samples = (tip_m / STEP_M).ceil().max(1.0);
        let mut least_m = f64::INFINITY;
        for k in 1..=samples as u32 {
            let [i, j] = [i, j].map(|[from, to]| from + (to - from) * f64::from(k) / samples);
            let apart_m = geometry::between_tails_m(length_m, pair.apart_m, i, j);
            least_m = least_m.min(apart_m - self.modboat.tail_width_m);
        }
        self.report.least_m = self.report.least_m.min(least_m);
        self.note(index, 0, t_s, least_m, 0.0);
        let guarantee_m = match (self.expected[pair.i], self.expected[pair.j]) {
            (Expected::Order { course, number }, other) if other == (Expected::Order { course, number }) => {
                self.courses[course].guarantee_m
            }
            _ => None,
        };
        if let Some(guarantee_m) = guarantee_m {
            self.report.spare_m = self.report.spare_m.min(least_m - guarantee_m);
        }
        self.note(index, 1, t_s, least_m, guarantee_m.map_or(f64::NEG_INFINITY, |m| m - ROUNDING_M));
    }

    /// Notes it if a pair is nearer than promised: once while that lasts.
    fn note(&mut self, index: usize, kind: usize, t_s: f64, least_m: f64, promised_m: f64) {
        if least_m >= promised_m {
            self.lasting[index][kind] = None;
            return;
        }
        let Pair { i, j, .. } = self.pairs[index];
        let doing = |module: usize| {
            let planned = self.planned(module, t_s);
            let (expected, powerless) = (self.expected[module], self.powerless[module]);
            format!("{expected:?} {planned:?} {powerless:?}")
        };
        let new = self.lasting[index][kind].is_none().then(|| format!("{} and {}", doing(i), doing(j)));
        let nears = if kind == 0 { &mut self.report.contacts } else { &mut self.report.broken };
        let near = *self.lasting[index][kind].get_or_insert(nears.len());
        if let Some(doing) = new {
            let powerless = [i, j].iter().any(|&module| self.powerless[module] == Some(false));
            nears.push(Near { t_s, modules: [i + 1, j + 1], least_m, promised_m, powerless, doing });
        }
        nears[near].least_m = nears[near].least_m.min(least_m);
    }
}

/// The difference of two angles, in [−π, π], rad.
fn less_rad(a_rad: f64, b_rad: f64) -> f64 {
    let turn_rad = std::f64::consts::TAU;
    let rad = a_rad - b_rad;
    rad - turn_rad * (rad / turn_rad).round()
}

#[cfg(test)]
mod tests;
