//! Modules that push less than the others: found while the fleet swims, named, and planned with. With them the Munk moment is found, which twists the
//! structure as a weak module does, and the controller takes it off.
//!
//! [`ShareEstimator`] tells the shares. The planner takes other ones where a module is surely off by [`WORTH`]: each such change makes the tails
//! swing otherwise, and a share that is not known well is not worth that. The sum of the shares stays as it was: what all modules have in
//! common, the controller learns.

use link::dispatcher::Dispatcher;
use modboat::control::ControllerKind;
use modboat::motion;
use modboat::observer::Fix;
use modboat::parameters::Parameters;
use modboat::shares::{Found, ShareEstimator, Swum};
use protocol::time::FleetInstant;

use super::super::scenario::Scenario;
use super::Pilot;
use super::decision::{Decision, all_have};
use super::planners::planner_of;

/// A share that is off by less is not planned with. *Assumed.*
const WORTH: f64 = 0.12;
/// So many standard deviations are sure. *Assumed.*
const SURE: f64 = 3.0;
/// A module is weak with less than this share of what the others give, and not any more with more than that. *Assumed.*
const WEAK: f64 = 0.8;
const WHOLE: f64 = 0.9;
/// The same of m, which costs no other cycles. *Assumed.*
const MUNK_SURE: f64 = 2.5;
const MUNK_WORTH: f64 = 0.15;
/// Shares that planners take.
const SHARES: [f64; 2] = [0.1, 4.0];

/// A module that pushes less than the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weak {
    /// What it gives of what the others do.
    pub share: f64,
    /// Since when that is known.
    pub found: FleetInstant,
}

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct WeakModules {
    estimator: ShareEstimator,
    /// Mean of the shares that are believed.
    mean: f64,
    /// m, as the controller takes it.
    munk: f64,
    /// By module, where it is weak.
    weak: Vec<Option<Weak>>,
}

impl WeakModules {
    /// `None` where they are not looked for: by the paper's controller, or where none is unsure.
    pub(super) fn new(scenario: &Scenario) -> Option<Self> {
        let Scenario { structure, modboat, observer, control, .. } = scenario;
        if control.kind != ControllerKind::Forgiving {
            return None;
        }
        let estimator = ShareEstimator::new(
            structure,
            modboat,
            observer,
            (control.forgiving.unsure_share, control.forgiving.munk),
        )?;
        let mean = (0..structure.len()).map(|module| modboat.share(module)).sum::<f64>();
        Some(Self {
            estimator,
            mean: mean / structure.len() as f64,
            munk: control.forgiving.munk,
            weak: vec![None; structure.len()],
        })
    }

    /// Takes a pose.
    pub(super) fn update(&mut self, fix: &Fix) {
        self.estimator.update(fix);
    }

    /// The decision that runs: whether all modules have it is known by now.
    pub(super) fn swum<A: Copy>(&mut self, decision: &Decision, links: &Dispatcher<A>) {
        if decision.missing.contains(&true) || !all_have(links, decision, decision.last_number()) {
            self.estimator.forget_cycles();
            return;
        }
        let start_s = decision.swim_start().as_secs_f64();
        let about = decision.turns.iter().zip(&decision.plan.cycle);
        self.estimator.swum(&Swum {
            start_s,
            interval_s: decision.end().as_secs_f64() - decision.start.as_secs_f64(),
            cycle: &decision.plan.cycle,
            about_rad: about.map(|(turn, swing)| turn.to_rad - swing.amplitude_rad).sum(),
        });
    }

    /// m of the Munk moment, where it is surely another than it is taken for.
    pub(super) fn munk(&mut self) -> Option<f64> {
        let found = self.estimator.munk()?;
        let off = (found.share - self.munk).abs();
        (off > (MUNK_SURE * found.deviation).max(MUNK_WORTH)).then(|| {
            self.munk = found.share;
            found.share
        })
    }

    /// Shares of law (2) to plan with from now on, where those that the planner has, by module, are surely off.
    pub(super) fn due(&mut self, parameters: &Parameters) -> Option<Vec<f64>> {
        let off = |(module, found): (usize, Found)| {
            let share = parameters.share(module) / self.mean;
            (found.share - share).abs() > (SURE * found.deviation).max(WORTH)
        };
        if !self.estimator.relative().enumerate().any(off) {
            return None;
        }
        let share = |found: Found| (self.mean * found.share).clamp(SHARES[0], SHARES[1]);
        Some(self.estimator.relative().map(share).collect())
    }

    /// Takes down which modules are weak by `shares`, which are planned with from `now` on. What a person is to know of it; `id` says what a
    /// module (by index) is called.
    pub(super) fn name(
        &mut self,
        now: FleetInstant,
        shares: &[f64],
        id: impl Fn(usize) -> u16,
    ) -> Vec<String> {
        let mut sorted = shares.to_vec();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let mut news = Vec::new();
        for (module, (share, weak)) in shares.iter().zip(&mut self.weak).enumerate() {
            let (id, share) = (id(module), share / median);
            match weak {
                None if share < WEAK => {
                    news.push(format!(
                        "module {id} pushes {:.0} % of what the others do: planned with that",
                        100.0 * share
                    ));
                    *weak = Some(Weak { share, found: now });
                }
                Some(_) if share > WHOLE => {
                    news.push(format!("module {id} pushes like the others again"));
                    *weak = None;
                }
                Some(weak) => weak.share = share,
                None => {}
            }
        }
        news
    }

    /// Those that are weak, by module.
    pub(super) fn weak(&self) -> impl Iterator<Item = (usize, Weak)> + '_ {
        self.weak.iter().enumerate().filter_map(|(module, weak)| Some((module, (*weak)?)))
    }
}

impl Pilot {
    /// Takes the running decision in; the planner is made again where modules push otherwise than it knows.
    pub(super) fn plan_with_weak_modules<A: Copy>(&mut self, now: FleetInstant, links: &Dispatcher<A>) {
        let (Some(weak), Some(last)) = (&mut self.weak, self.decisions.last()) else { return };
        weak.swum(last, links);
        if let Some(munk) = weak.munk() {
            self.control.set_munk(munk);
        }
        let Scenario { structure, modboat, planner, .. } = &mut self.scenario;
        let Some(shares) = weak.due(modboat) else { return };
        self.news.extend(weak.name(now, &shares, |module| links.modules()[module].id().0));
        modboat.module_share = shares;
        self.planner = planner_of(structure, modboat, planner, &self.distance, self.table.clone());
        self.partial = None;
        let wrench = motion::wrench(&last.plan.cycle, modboat, &structure.positions_m(modboat.pitch_m));
        self.corrected = Some((last.number, wrench));
        let wrench = self.wrench_at(now);
        self.control.correct_wrench(wrench);
    }

    /// Modules (by index) that push less than the others.
    pub fn weak_modules(&self) -> impl Iterator<Item = (usize, Weak)> + '_ {
        self.weak.iter().flat_map(WeakModules::weak)
    }
}
