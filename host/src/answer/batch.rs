//! Many demands at once, each planned for by itself: as the first plan of a planner that was just made.

use std::thread;

use modboat::motion::{Turn, Wrench};
use modboat::plan::Plan;
use modboat::planner::Planner;

use super::plan::{clearance_m, guarantee_m};

/// Plans by column; what a plan has for each module stands plan by plan, module by module. Not a number where a plan has none.
#[derive(Clone, Debug, Default)]
pub struct Plans {
    /// How many modules a plan is for.
    pub modules: usize,
    /// 0 planned, 1 repeated, 2 held.
    pub outcome: Vec<u8>,
    /// φ₀, rad, by module.
    pub centerline_rad: Vec<f64>,
    /// A, rad, by module.
    pub amplitude_rad: Vec<f64>,
    /// Where the transition begins, rad, by module.
    pub from_rad: Vec<f64>,
    /// Where it is between its two steps, rad, by module.
    pub via_rad: Vec<f64>,
    /// Where it ends, rad, by module.
    pub to_rad: Vec<f64>,
    /// Three numbers a plan: N, N, N·m.
    pub wrench: Vec<f64>,
    /// Relative weighted error.
    pub error: Vec<f64>,
    /// Sum of all rotations, rad.
    pub travel_rad: Vec<f64>,
    /// How long the transition takes, s.
    pub transition_s: Vec<f64>,
    /// Least distance between two tails, m.
    pub clearance_m: Vec<f64>,
    /// The same with tails as far off as modules let them be, m.
    pub guarantee_m: Vec<f64>,
    /// Whether any modules may miss it.
    pub loss_tolerant: Vec<bool>,
    /// Whether the demand lies outside the envelope.
    pub outside_envelope: Vec<bool>,
}

impl Plans {
    /// None yet, with room for `count`.
    #[must_use]
    pub fn with_room(modules: usize, count: usize) -> Self {
        let each = || Vec::with_capacity(modules * count);
        let one = || Vec::with_capacity(count);
        Self {
            modules,
            outcome: Vec::with_capacity(count),
            centerline_rad: each(),
            amplitude_rad: each(),
            from_rad: each(),
            via_rad: each(),
            to_rad: each(),
            wrench: Vec::with_capacity(3 * count),
            error: one(),
            travel_rad: one(),
            transition_s: one(),
            clearance_m: one(),
            guarantee_m: one(),
            loss_tolerant: Vec::with_capacity(count),
            outside_envelope: Vec::with_capacity(count),
        }
    }

    /// One more.
    pub fn push(&mut self, plan: &Plan) {
        self.outcome.push(plan.outcome as u8);
        self.centerline_rad.extend(plan.cycle.iter().map(|swing| swing.centerline_rad));
        self.amplitude_rad.extend(plan.cycle.iter().map(|swing| swing.amplitude_rad));
        let turns = |to: &mut Vec<f64>, of: fn(&Turn) -> f64| match &plan.transition {
            Some(turns) => to.extend(turns.iter().map(of)),
            None => to.resize(to.len() + self.modules, f64::NAN),
        };
        turns(&mut self.from_rad, |turn| turn.from_rad);
        turns(&mut self.to_rad, |turn| turn.to_rad);
        match &plan.via_rad {
            Some(via_rad) => self.via_rad.extend_from_slice(via_rad),
            None => self.via_rad.resize(self.via_rad.len() + self.modules, f64::NAN),
        }
        self.wrench.extend_from_slice(&plan.wrench.to_array());
        self.error.push(plan.error);
        self.travel_rad.push(plan.travel_rad);
        self.transition_s.push(plan.transition_s);
        self.clearance_m.push(clearance_m(plan).unwrap_or(f64::NAN));
        self.guarantee_m.push(guarantee_m(plan).unwrap_or(f64::NAN));
        self.loss_tolerant.push(plan.loss_tolerant);
        self.outside_envelope.push(plan.outside_envelope);
    }

    fn append(&mut self, other: Self) {
        self.outcome.extend(other.outcome);
        self.loss_tolerant.extend(other.loss_tolerant);
        self.outside_envelope.extend(other.outside_envelope);
        let Self { centerline_rad, amplitude_rad, from_rad, via_rad, to_rad, wrench, .. } = self;
        centerline_rad.extend(other.centerline_rad);
        amplitude_rad.extend(other.amplitude_rad);
        from_rad.extend(other.from_rad);
        via_rad.extend(other.via_rad);
        to_rad.extend(other.to_rad);
        wrench.extend(other.wrench);
        let Self { error, travel_rad, transition_s, clearance_m, guarantee_m, .. } = self;
        error.extend(other.error);
        travel_rad.extend(other.travel_rad);
        transition_s.extend(other.transition_s);
        clearance_m.extend(other.clearance_m);
        guarantee_m.extend(other.guarantee_m);
    }
}

/// A plan for each of `demands`, by planners like this one, on so many threads. `tails_rad` has the tails' angles for each, or is
/// empty where nothing is known of them. What comes out does not depend on the number of threads.
#[must_use]
pub fn batch(
    planner: &Planner,
    modules: usize,
    demands: &[[f64; 3]],
    tails_rad: &[f64],
    threads: usize,
) -> Plans {
    let one = |demands: &[[f64; 3]], tails_rad: &[f64]| {
        let mut planner = planner.clone();
        let (mut plan, mut plans) = (Plan::default(), Plans::with_room(modules, demands.len()));
        for (index, &demand) in demands.iter().enumerate() {
            planner.forget();
            let tails = tails_rad.get(index * modules..(index + 1) * modules);
            planner.plan_into(Wrench::from_array(demand), tails, None, &mut plan);
            plans.push(&plan);
        }
        plans
    };
    let share = demands.len().div_ceil(threads.max(1)).max(1);
    if share >= demands.len() {
        return one(demands, tails_rad);
    }
    thread::scope(|scope| {
        let parts = demands.chunks(share).enumerate().map(|(part, demands)| {
            let tails_rad = tails_rad.get(part * share * modules..).unwrap_or_default();
            let one = &one;
            scope.spawn(move || one(demands, tails_rad))
        });
        let parts: Vec<_> = parts.collect();
        let mut plans = Plans::with_room(modules, demands.len());
        for part in parts {
            plans.append(part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        plans
    })
}
