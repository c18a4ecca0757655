//! The figures of a run: `summary.json`, and what is printed.

use link::faults::FaultCount;
use link::ledger::{Ledger, Quantiles};
use modboat::motion::Wrench;
use protocol::ledger::{Incoming, Outgoing};
use protocol::time::FleetInstant;
use quantity::wrap_rad;
use record::{LegRecord, PoseSample, RunRecord};
use runlog::flotilla;
use serde::Serialize;

use super::clock::Gap;
pub use super::leg_figures::{LegFigures, StationFigures};
use super::scenario::Scenario;
use super::shortfall::{self, FLOOR, Shortfall, attainable_m_s};
use super::watch::LegWatch;

pub use poses::{PoseFigures, TroubleFigures};

mod poses;

/// Velocity is averaged over the last so many seconds of a leg.
const MEAN_OVER_S: f64 = 60.0;
/// Heading errors count from so many seconds after the start of a leg.
const SETTLED_AFTER_S: f64 = 20.0;

/// The figures of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Scenario.
    pub scenario: String,
    /// Modules.
    pub modules: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// The planner.
    pub planner: &'static str,
    /// Time from the start of the first cycle, s.
    pub duration_s: f64,
    /// Time the scenario takes, s.
    pub planned_s: f64,
    /// Whether the whole scenario was run.
    pub complete: bool,
    /// What went wrong; null if the run did what it was to do.
    pub failure: Option<String>,
    /// What was asked and not done, of that which ends no run.
    pub shortfalls: Vec<Shortfall>,
    /// Spans in which the host did not run. No figure uses them, but for those of time.
    pub gaps: Vec<GapFigures>,
    /// For how long modules took no part, from the start of the first cycle.
    pub absences: Vec<AbsenceFigures>,
    /// Modules that were found to push less than the others.
    pub weak_modules: Vec<WeakFigures>,
    /// Each leg's figures.
    pub legs: Vec<LegFigures>,
    /// Cycles by outcome.
    pub cycles: CycleFigures,
    /// Times two tails touched; each would have undocked a pair.
    pub contacts: Vec<ContactFigures>,
    /// Least distance between the surfaces of two tails, m; null where no two can meet.
    pub least_clearance_m: Option<f64>,
    /// What came of the motion capture; left out where poses are simulated in this process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses: Option<PoseFigures>,
    /// Each module's link, in order.
    pub link: Vec<LinkFigures>,
    /// Datagrams that no module can be charged with: damaged ones, other fleets', strangers'.
    pub strays: Incoming,
    /// What the simulated medium did, all radios together.
    pub faults: Option<FaultCount>,
    /// Greatest error of a module's fleet time while it swam, µs.
    pub clock_error_us: Option<u64>,
    /// Time the run took, s.
    pub wall_s: f64,
}

/// A span in which the host did not run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GapFigures {
    /// When it began, s after the start of the first cycle; for a plan of ROVs, s of the plan's time, which stands still in it.
    pub start_s: f64,
    /// How long it was, until it was known again what the modules do, s.
    pub length_s: f64,
}

impl GapFigures {
    /// Of a run that began at `origin`.
    fn new(gap: &Gap, origin: FleetInstant) -> Self {
        Self { start_s: gap.start.as_secs_f64() - origin.as_secs_f64(), length_s: gap.length_s() }
    }
}

/// A module took no part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AbsenceFigures {
    /// Its id.
    pub module: u16,
    /// For how long, s.
    pub time_s: f64,
    /// Why.
    pub reason: String,
}

impl AbsenceFigures {
    /// Of all legs.
    pub(super) fn of_all(legs: &[LegWatch], id: impl Fn(usize) -> u16) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for absence in legs.iter().flat_map(|leg| &leg.absences) {
            let (module, reason) = (id(absence.module), absence.reason.to_string());
            match all.iter_mut().find(|known| known.module == module && known.reason == reason) {
                Some(known) => known.time_s += absence.time_s,
                None => all.push(Self { module, time_s: absence.time_s, reason }),
            }
        }
        all
    }
}

/// A module pushes less than the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeakFigures {
    /// Its id.
    pub module: u16,
    /// What it gives of what the others do, as it was planned with last.
    pub share: f64,
    /// When it was found, s after the start of the first cycle.
    pub at_s: f64,
}

impl WeakFigures {
    fn of_all(flotilla::WeakModules { module, share, at_s, .. }: &flotilla::WeakModules) -> Vec<Self> {
        let all = module.iter().zip(share).zip(at_s);
        all.map(|((&module, &share), &at_s)| Self { module, share, at_s }).collect()
    }
}

/// What became of the decisions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CycleFigures {
    /// All of them.
    pub total: usize,
    /// With a plan for their demand.
    pub planned: usize,
    /// The same cycle once more.
    pub repeated: usize,
    /// Nothing moved.
    pub held: usize,
    /// That needed a transition.
    pub with_transition: usize,
    /// Share of all that needed none.
    pub without_transition_share: f64,
    /// Share of all that any modules may miss without a collision.
    pub loss_tolerant_share: f64,
    /// Share of all in which any module may lose its power at any time without a collision.
    pub power_tolerant_share: f64,
    /// Mean time from one decision to the next, s.
    pub mean_interval_s: f64,
    /// With a demand outside the envelope, which nothing could have met.
    pub outside_envelope: usize,
    /// For less than what the leg asks, to keep off the edge of the water.
    pub bounded: usize,
    /// Mean error of the wrench: relative, and in N where the demand is zero.
    pub mean_error: f64,
    /// Mean relative error of the wrench where one is demanded.
    pub mean_relative_error: f64,
    /// With a demand of zero.
    pub zero_demands: usize,
    /// Mean weighted size of the wrench that is planned for those, N.
    pub mean_zero_error_n: f64,
    /// Mean tail travel in the transitions, rad a module.
    pub mean_travel_rad: f64,
    /// Median time of the planner, µs.
    pub solve_us_median: u64,
    /// Greatest time of the planner, µs.
    pub solve_us_max: u64,
    /// Reboots of modules seen.
    pub reboots: u32,
    /// Cycles refused by modules.
    pub refusals: u32,
}

/// Two tails touched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactFigures {
    /// When, s after the start of the first cycle.
    pub t_s: f64,
    /// Ids of the two modules.
    pub modules: [usize; 2],
    /// Deepest overlap, m.
    pub overlap_m: f64,
}

/// One module's link.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkFigures {
    /// Its id.
    pub module: u16,
    /// Its cycles.
    #[serde(flatten)]
    pub ledger: Ledger,
    /// Datagrams to it: sent = acknowledged + late + lost + under way.
    pub to_module: Outgoing,
    /// Datagrams that claimed to be from it: received = accepted + duplicate + stale + corrupt + forged + foreign.
    pub from_module: Incoming,
    /// What it last said came to it, of the same kinds; null if it never did.
    pub module_received: Option<Incoming>,
    /// From a cycle's first datagram to its answer.
    pub answer: Quantiles,
    /// How far its fleet time may be off, by its own word, µs.
    pub clock_uncertainty_us: Option<u32>,
    /// How much faster fleet time runs than its clock, by its own word, 10⁻⁹.
    pub clock_drift_ppb: Option<i32>,
    /// Boots seen.
    pub boots: u32,
    /// Sessions it has had.
    pub sessions: u32,
    /// What it last said was wrong with it.
    pub faults: Vec<&'static str>,
}

/// How often modules were seen to reboot.
pub fn reboots(links: &[LinkFigures]) -> u32 {
    links.iter().map(|link| link.boots.saturating_sub(1)).sum()
}

/// What was counted in a run, by its log.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Numbers that persons know the modules by.
    pub(super) ids: Vec<u16>,
    /// Time zero.
    pub(super) origin: Option<FleetInstant>,
    /// Spans in which the host did not run.
    pub(super) gaps: Vec<Gap>,
    /// Times two tails touched.
    pub(super) contacts: Vec<flotilla::Contact>,
    /// Each module's link.
    pub(super) links: Vec<LinkFigures>,
    /// See [`Summary::strays`].
    pub(super) strays: Incoming,
    /// See [`Summary::faults`].
    pub(super) faults: Option<FaultCount>,
    /// What was seen in each leg.
    pub(super) watched: Vec<LegWatch>,
    /// Cycles refused by modules.
    pub(super) refusals: u32,
    /// See [`Summary::weak_modules`].
    pub(super) weak: flotilla::WeakModules,
    /// Infinite where no two tails can meet.
    pub(super) least_clearance_m: Option<f64>,
    /// Of a motion capture.
    pub(super) poses: Option<flotilla::Poses>,
    /// See [`Summary::clock_error_us`].
    pub(super) clock_error_us: Option<u64>,
    /// See [`Summary::wall_s`].
    pub(super) wall_s: f64,
}

impl Summary {
    /// From what a run left behind.
    pub(super) fn new(scenario: &Scenario, seed: u64, record: &RunRecord, counts: Counts) -> Self {
        let Counts { ids, origin, gaps, contacts, links, strays, faults, watched, .. } = counts;
        let zero_s = origin.unwrap_or_default().as_secs_f64();
        let duration_s = record.poses.last().map_or(0.0, |pose| pose.t_s);
        let id = |index: usize| ids.get(index).copied().unwrap_or_default();
        let contacts = contacts.iter().map(|contact| ContactFigures {
            t_s: contact.began_s - zero_s,
            modules: contact.modules.map(usize::from),
            overlap_m: contact.overlap_m,
        });
        let legs: Vec<(usize, LegFigures)> = leg_figures_of_all(scenario, record, &watched);
        let shortfalls = shortfalls(scenario, &legs, &watched, id);
        let begun = |gap: &&Gap| origin.is_some_and(|origin| gap.end > origin);
        let figures = |gap| GapFigures::new(gap, origin.unwrap_or_default());
        Self {
            scenario: scenario.name.clone(),
            modules: scenario.structure.len(),
            seed,
            planner: scenario.planner.kind.name(),
            duration_s,
            planned_s: scenario.duration_s(),
            complete: duration_s >= scenario.duration_s() - 0.1,
            failure: None,
            shortfalls,
            gaps: gaps.iter().filter(begun).map(figures).collect(),
            absences: AbsenceFigures::of_all(&watched, id),
            weak_modules: WeakFigures::of_all(&counts.weak),
            legs: legs.into_iter().map(|(_, figures)| figures).collect(),
            cycles: cycle_figures(record, reboots(&links), counts.refusals),
            contacts: contacts.collect(),
            least_clearance_m: counts.least_clearance_m.filter(|least_m| least_m.is_finite()),
            link: links,
            strays,
            faults,
            poses: counts.poses.map(PoseFigures::from),
            clock_error_us: counts.clock_error_us,
            wall_s: counts.wall_s,
        }
    }

    /// Whether the run did what it was to do: to its end, without two tails touching, all that was asked.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.failure.is_none()
    }

    /// What is to be said of it, a line each.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        complaints(self.failure.as_deref(), &self.shortfalls)
    }

    /// Says in [`failure`](Self::failure) what went wrong; `cut_short` is why the run ended before its time, if that
    /// is known; `turned` is how many cycles modules were sent that only turn, before the first swim.
    pub(super) fn judge(&mut self, cut_short: Option<String>, turned: u64) {
        let Self { duration_s, planned_s, complete, .. } = *self;
        let cycles: u64 = self.link.iter().map(|link| link.ledger.cycles).sum();
        let cycles = cycles.saturating_sub(turned);
        let taken: u64 = self.link.iter().map(|link| link.ledger.acknowledged).sum();
        let refused: u64 = self.link.iter().map(|link| link.ledger.refused + link.ledger.late).sum();
        self.failure = if let Some(first) = self.contacts.first() {
            Some(format!(
                "{} tail contacts, the first between modules {} and {} at {:.2} s: the structure would have come apart",
                self.contacts.len(),
                first.modules[0],
                first.modules[1],
                first.t_s
            ))
        } else if !complete {
            let why = cut_short.map_or(String::new(), |why| format!(": {why}"));
            Some(format!("ended early, after {duration_s:.1} of {planned_s:.1} s{why}"))
        } else if cycles == 0 && planned_s <= 0.0 {
            // It waited for targets, and none came.
            None
        } else if cycles == 0 {
            Some("no cycle was found in which no tails meet; every module held".to_owned())
        } else if taken <= turned {
            // No module moved, so no tails touched.
            Some(format!(
                "the modules took none of {cycles} cycles and refused {refused}: motor, period and transition do not go \
                 together, or the clocks are not sure"
            ))
        } else {
            all_of(&self.shortfalls)
        };
    }
}

/// Shortfalls as one line, if there are any.
pub(super) fn all_of(shortfalls: &[Shortfall]) -> Option<String> {
    let lines: Vec<String> = shortfalls.iter().map(ToString::to_string).collect();
    (!lines.is_empty()).then(|| lines.join("; "))
}

/// `failure`, unless it is made of the shortfalls, and each of them.
pub(super) fn complaints(failure: Option<&str>, shortfalls: &[Shortfall]) -> Vec<String> {
    let other = failure.filter(|&failure| all_of(shortfalls).as_deref() != Some(failure));
    other.map(str::to_owned).into_iter().chain(shortfalls.iter().map(ToString::to_string)).collect()
}

/// Figures of the legs that were begun, with their indices.
fn leg_figures_of_all(
    scenario: &Scenario,
    record: &RunRecord,
    watched: &[LegWatch],
) -> Vec<(usize, LegFigures)> {
    let legs = record.legs.iter().zip(&scenario.legs).zip(watched).enumerate();
    let figures = legs.filter_map(|(index, ((leg, asked), seen))| {
        let figures = leg_figures(leg, record)?;
        let attainable_m_s = attainable_m_s(&scenario.structure, &scenario.modboat, asked);
        Some((index, LegFigures { attainable_m_s, held_s: seen.held_s, ..figures }))
    });
    figures.collect()
}

fn shortfalls(
    scenario: &Scenario,
    legs: &[(usize, LegFigures)],
    watched: &[LegWatch],
    id: impl Fn(usize) -> u16,
) -> Vec<Shortfall> {
    let Scenario { modboat, timing, .. } = scenario;
    let floor_s = FLOOR * (modboat.period_s + modboat.transition_s);
    let mut all = Vec::new();
    for (index, (seen, asked)) in watched.iter().zip(&scenario.legs).enumerate() {
        let leg = index + 1;
        let found = shortfall::of_watch(Some(leg), seen, floor_s, "module", &id);
        // Where fewer are required, those that are missing may be left out.
        let tolerated = |found: &Shortfall| timing.require > 0 && matches!(found, Shortfall::Absent { .. });
        all.extend(found.into_iter().filter(|found| !tolerated(found)));
        let figures = legs.iter().find(|(known, _)| *known == index);
        all.extend(figures.and_then(|(_, figures)| shortfall::of_velocity(leg, figures, asked.duration_s)));
    }
    all
}

/// Nothing for a leg that was not begun.
fn leg_figures(leg: &LegRecord, record: &RunRecord) -> Option<LegFigures> {
    let within = |from_s: f64| {
        record.poses.iter().filter(move |pose| (from_s - 1e-6..=leg.end_s + 1e-6).contains(&pose.t_s))
    };
    let mean_from_s = leg.start_s.max(leg.end_s - MEAN_OVER_S);
    let averaged: Vec<PoseSample> = within(mean_from_s).copied().collect();
    within(mean_from_s).next()?;
    // Over the ways between gaps.
    let (mut way_m, mut time_s) = ([0.0; 2], 0.0);
    for piece in record.pieces(&averaged, |pose| pose.t_s) {
        let [first, .., last] = piece else { continue };
        way_m = [0, 1].map(|axis| way_m[axis] + (last.position_m[axis] - first.position_m[axis]));
        time_s += last.t_s - first.t_s;
    }
    let mean_m_s = way_m.map(|way_m| way_m / f64::max(time_s, f64::MIN_POSITIVE));
    let [dx, dy] = [0, 1].map(|axis| mean_m_s[axis] - leg.velocity_m_s[axis]);
    let demand = leg.velocity_m_s[0].hypot(leg.velocity_m_s[1]);
    let settled_s = (leg.start_s + SETTLED_AFTER_S).min(leg.end_s);
    let (sum, count) = within(settled_s).fold((0.0, 0.0), |(sum, count), pose| {
        let error = wrap_rad(pose.heading_rad - leg.heading_rad);
        (sum + error * error, count + 1.0)
    });
    let station = leg.station_m.map(|position_m| {
        let (mut square_m2, mut max_m) = (0.0, 0.0_f64);
        for pose in within(settled_s) {
            let off_m = (pose.position_m[0] - position_m[0]).hypot(pose.position_m[1] - position_m[1]);
            (square_m2, max_m) = (square_m2 + off_m * off_m, max_m.max(off_m));
        }
        StationFigures { position_m, rms_m: f64::sqrt(square_m2 / f64::max(count, 1.0)), max_m }
    });
    Some(LegFigures {
        demand_m_s: leg.velocity_m_s,
        mean_m_s,
        velocity_error: dx.hypot(dy) / if demand > 0.0 { demand } else { 1.0 },
        attainable_m_s: None,
        held_s: 0.0,
        heading_rad: leg.heading_rad,
        heading_rms_rad: if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 },
        station,
    })
}

fn cycle_figures(record: &RunRecord, reboots: u32, refusals: u32) -> CycleFigures {
    let cycles = &record.cycles;
    let outcome = |name| cycles.iter().filter(|cycle| cycle.outcome == name).count();
    let mean = |of: &dyn Fn(&record::CycleRecord) -> f64| {
        if cycles.is_empty() { 0.0 } else { cycles.iter().map(of).sum::<f64>() / cycles.len() as f64 }
    };
    let is_zero = |cycle: &&record::CycleRecord| cycle.demand == Wrench::default();
    let zero_demands = cycles.iter().filter(is_zero).count();
    let mean_of = |zero: bool, count: usize| {
        let errors = cycles.iter().filter(|cycle| is_zero(cycle) == zero).map(|cycle| cycle.error);
        errors.fold(0.0, |sum, error| sum + error) / count.max(1) as f64
    };
    let mut solve_us: Vec<u64> = cycles.iter().map(|cycle| cycle.solve_us).collect();
    solve_us.sort_unstable();
    CycleFigures {
        total: cycles.len(),
        planned: outcome("planned"),
        repeated: outcome("repeated"),
        held: outcome("held"),
        with_transition: cycles.iter().filter(|cycle| cycle.transition_s > 0.0).count(),
        without_transition_share: mean(&|cycle| f64::from(u8::from(cycle.transition_s == 0.0))),
        loss_tolerant_share: mean(&|cycle| f64::from(u8::from(cycle.loss_tolerant))),
        power_tolerant_share: mean(&|cycle| f64::from(u8::from(cycle.power_tolerant))),
        mean_interval_s: record.mean_interval_s(),
        outside_envelope: cycles.iter().filter(|cycle| cycle.outside_envelope).count(),
        bounded: cycles.iter().filter(|cycle| cycle.bounded).count(),
        mean_error: mean(&|cycle| cycle.error),
        mean_relative_error: mean_of(false, cycles.len() - zero_demands),
        zero_demands,
        mean_zero_error_n: mean_of(true, zero_demands),
        mean_travel_rad: mean(&|cycle| cycle.travel_rad / cycle.swings.len().max(1) as f64),
        solve_us_median: solve_us.get(solve_us.len() / 2).copied().unwrap_or(0),
        solve_us_max: solve_us.last().copied().unwrap_or(0),
        reboots,
        refusals,
    }
}
