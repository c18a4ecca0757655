//! What a log of Modboats says: its record, and its figures.

use std::collections::BTreeMap;

use modboat::motion::{Swing, Turn, Wrench};
use protocol::time::{Duration, FleetInstant};
use record::{CycleRecord, LegRecord, PoseSample, RunRecord, TailSample, ViaRecord};
use runlog::flotilla;
use runlog::ros::Time;

use super::super::super::clock::Gap;
use super::super::super::scenario::{Demand, Scenario};
use super::super::super::summary::{Counts, Summary};
use super::super::topics::Told;
use super::super::{counts, instant};
use super::POSE_EVERY_S;

/// See the module's documentation. What is told is taken in message by message.
pub struct Reading {
    scenario: Scenario,
    seed: u64,
    ids: Vec<u16>,
    origin: Option<FleetInstant>,
    truth: Vec<PoseSample>,
    estimates: Vec<PoseSample>,
    tails: Vec<TailSample>,
    /// By index, as are cycles, gaps and contacts: what is told again takes the place of what was told before.
    decisions: BTreeMap<u32, flotilla::Decision>,
    cycles: BTreeMap<u32, flotilla::Cycle>,
    gaps: BTreeMap<u32, Gap>,
    contacts: BTreeMap<u32, flotilla::Contact>,
    links: flotilla::Links,
    ledger: flotilla::Ledger,
    poses: Option<flotilla::Poses>,
    legs: flotilla::Legs,
    absences: flotilla::Absences,
    holds: flotilla::Holds,
    weak: flotilla::WeakModules,
    end: Option<flotilla::End>,
    /// An operator gave targets: what the legs ask for is not what was to be done.
    steered: bool,
    /// What makes no sense, first of all.
    flaw: Option<String>,
}

/// What became of a run.
pub struct Outcome {
    /// The figures.
    pub summary: Summary,
    /// Everything over time.
    pub record: RunRecord,
    /// Whether its end was told.
    pub ended: bool,
}

impl Reading {
    /// Of a run of `scenario` from `seed`, with these modules.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64, ids: &[u16]) -> Self {
        Self {
            scenario: scenario.clone(),
            seed,
            ids: ids.to_vec(),
            origin: None,
            truth: Vec::new(),
            estimates: Vec::new(),
            tails: Vec::new(),
            decisions: BTreeMap::new(),
            cycles: BTreeMap::new(),
            gaps: BTreeMap::new(),
            contacts: BTreeMap::new(),
            links: flotilla::Links::default(),
            ledger: flotilla::Ledger::default(),
            poses: None,
            legs: flotilla::Legs::default(),
            absences: flotilla::Absences::default(),
            holds: flotilla::Holds::default(),
            weak: flotilla::WeakModules::default(),
            end: None,
            steered: false,
            flaw: None,
        }
    }

    /// Takes in one message.
    pub fn take(&mut self, told: Told<'_>) {
        match told {
            Told::Begin(begin) => self.origin = Some(FleetInstant(begin.origin_us)),
            Told::Truth(state) => self.truth.push(self.pose(state)),
            Told::Estimate(state) => self.estimates.push(self.pose(state)),
            Told::Tails(tails) => {
                let sample =
                    TailSample { t_s: self.time_s(&tails.header.stamp), actual_rad: tails.position.clone() };
                self.fits("tails", &[sample.actual_rad.len()]);
                self.tails.push(sample);
            }
            Told::Decision(decision) => {
                self.fits(
                    "a decision",
                    &[
                        decision.from_rad.len(),
                        decision.to_rad.len(),
                        decision.centerline_rad.len(),
                        decision.amplitude_rad.len(),
                    ],
                );
                if !decision.via_rad.is_empty() {
                    self.fits("a decision", &[decision.via_rad.len()]);
                }
                self.decisions.insert(decision.index, decision.clone());
            }
            Told::Cycle(cycle) => {
                self.cycles.insert(cycle.index, cycle.clone());
            }
            Told::Gap(gap) => {
                let [start, end] = [gap.start_us, gap.end_us].map(FleetInstant);
                self.gaps.insert(gap.index, Gap { start, end });
            }
            Told::Contact(contact) => {
                self.contacts.insert(contact.index, contact.clone());
            }
            Told::Links(links) => self.links.clone_from(links),
            Told::Ledger(ledger) => self.ledger.clone_from(ledger),
            Told::Poses(poses) => self.poses = Some(poses.clone()),
            Told::Legs(legs) => self.legs.clone_from(legs),
            Told::Absences(absences) => self.absences.clone_from(absences),
            Told::Order(order) => self.steered |= order.followed && order.steers,
            Told::Holds(holds) => self.holds.clone_from(holds),
            Told::WeakModules(weak) => self.weak.clone_from(weak),
            Told::End(end) => self.end = Some(end.clone()),
            // Of the first the reading is made; the others are told of ROVs.
            Told::Scenario(_)
            | Told::Robots(_)
            | Told::Moves(_)
            | Told::Pauses(_)
            | Told::DeadThrusters(_) => {}
        }
    }

    /// Every module has its part in a message, or the log is none of this scenario.
    fn fits(&mut self, what: &str, lengths: &[usize]) {
        let modules = self.scenario.structure.len();
        if self.flaw.is_none()
            && let Some(length) = lengths.iter().find(|length| **length != modules)
        {
            self.flaw = Some(format!("{what} of {length} modules, in a log of {modules}"));
        }
    }

    fn time_s(&self, stamp: &Time) -> f64 {
        instant(stamp).as_secs_f64() - self.origin.unwrap_or_default().as_secs_f64()
    }

    fn pose(&self, state: &flotilla::BoatState) -> PoseSample {
        PoseSample {
            t_s: self.time_s(&state.stamp),
            position_m: state.position_m,
            heading_rad: state.heading_rad,
            velocity_m_s: state.velocity_m_s,
            yaw_rate_rad_s: state.yaw_rate_rad_s,
        }
    }

    /// Everything. Of a log without its end: until there.
    ///
    /// # Errors
    /// What makes no sense in it.
    pub fn finish(mut self) -> Result<Outcome, String> {
        if let Some(flaw) = self.flaw.take() {
            return Err(flaw);
        }
        let record = self.record()?;
        let before =
            |decision: &&flotilla::Decision| self.origin.is_some_and(|origin| start(decision) < origin);
        let turned = self.decisions.values().filter(before).count() * self.ids.len();
        let ended = self.end.is_some();
        let end = self.end.unwrap_or_else(|| flotilla::End {
            why: Some("the log ends there".to_owned()),
            ..flotilla::End::default()
        });
        let counts = Counts {
            watched: counts::watched(self.scenario.legs.len(), &self.legs, &self.absences, &self.holds),
            ids: self.ids,
            origin: self.origin,
            gaps: self.gaps.into_values().collect(),
            contacts: self.contacts.into_values().collect(),
            links: counts::link_figures(&self.links),
            strays: counts::received(&self.ledger.strays),
            faults: self.ledger.medium.as_ref().map(counts::fault_count),
            refusals: self.ledger.refusals,
            weak: self.weak,
            poses: self.poses.take(),
            least_clearance_m: self.ledger.least_clearance_m,
            clock_error_us: self.ledger.clock_error_us,
            wall_s: end.wall_s,
        };
        let mut summary = Summary::new(&self.scenario, self.seed, &record, counts);
        if self.steered {
            summary.shortfalls.clear();
        }
        summary.judge(end.why, turned as u64);
        Ok(Outcome { summary, record, ended })
    }

    /// Poses are true where the water is simulated, and the observer's where it is real. A cycle that was not over, or not seen all
    /// through, is left out, and so are turns before the first swim.
    fn record(&mut self) -> Result<RunRecord, String> {
        let scenario = &self.scenario;
        let zero_s = self.origin.unwrap_or_default().as_secs_f64();
        let gaps = self.gaps.values().map(|gap| [gap.start, gap.end].map(|at| at.as_secs_f64() - zero_s));
        let gaps: Vec<[f64; 2]> = gaps.filter(|&[_, end_s]| end_s > 0.0).collect();
        let poses = std::mem::take(if self.truth.is_empty() { &mut self.estimates } else { &mut self.truth });
        let end_s = poses.last().map_or(0.0, |pose| pose.t_s);
        let mut cycles = Vec::new();
        for decision in self.decisions.values() {
            let [from_s, until_s] = [start(decision), end(decision)].map(|at| at.as_secs_f64() - zero_s);
            let over = until_s <= end_s + 2.0 * POSE_EVERY_S;
            if over && from_s >= 0.0 && !gaps.iter().any(|gap| from_s < gap[1] && gap[0] < until_s) {
                let achieved = self.cycles.get(&decision.index).map(|cycle| wrench(&cycle.achieved));
                cycles.push(cycle(decision, from_s, achieved)?);
            }
        }
        let mut start_s = 0.0;
        let legs = scenario.legs.iter().map(|leg| {
            let (velocity_m_s, station_m) = match leg.demand {
                Demand::Velocity(velocity_m_s) => (velocity_m_s, None),
                Demand::Station(station_m) => ([0.0; 2], Some(station_m)),
            };
            let record = LegRecord {
                start_s,
                end_s: start_s + leg.duration_s,
                velocity_m_s,
                station_m,
                heading_rad: leg.heading_rad,
            };
            start_s = record.end_s;
            record
        });
        Ok(RunRecord {
            name: scenario.name.clone(),
            description: scenario.description.clone(),
            parameters: scenario.modboat.clone(),
            cells: scenario.structure.cells().to_vec(),
            positions_m: scenario.structure.positions_m(scenario.modboat.pitch_m),
            legs: legs.collect(),
            gaps,
            poses,
            tails: std::mem::take(&mut self.tails),
            cycles,
        })
    }
}

fn start(decision: &flotilla::Decision) -> FleetInstant {
    FleetInstant(decision.start_us)
}

fn end(decision: &flotilla::Decision) -> FleetInstant {
    start(decision).after(Duration(decision.transition_us)).after(Duration(decision.period_us))
}

fn wrench(wrench: &flotilla::Wrench) -> Wrench {
    Wrench { fx_n: wrench.fx_n, fy_n: wrench.fy_n, tau_nm: wrench.tau_nm }
}

fn cycle(
    decision: &flotilla::Decision,
    start_s: f64,
    achieved: Option<Wrench>,
) -> Result<CycleRecord, String> {
    let span_s = |us: u32| f64::from(Duration(us).as_secs_f32());
    let outcome = ["planned", "repeated", "held"].into_iter().find(|name| *name == decision.outcome);
    let swings = decision.centerline_rad.iter().zip(&decision.amplitude_rad);
    let turns = decision.from_rad.iter().zip(&decision.to_rad);
    Ok(CycleRecord {
        number: decision.number,
        start_s,
        transition_s: span_s(decision.transition_us),
        ramps_s: decision.ramps_s,
        period_s: span_s(decision.period_us),
        outcome: outcome.ok_or_else(|| format!("a decision that is {:?}", decision.outcome))?,
        demand: wrench(&decision.demand),
        commanded: wrench(&decision.commanded),
        achieved,
        error: decision.error,
        travel_rad: decision.travel_rad,
        outside_envelope: decision.outside_envelope,
        bounded: decision.bounded,
        clearance_m: decision.clearance_m,
        guarantee_m: decision.guarantee_m,
        solve_us: decision.solve_us,
        swings: swings
            .map(|(&centerline_rad, &amplitude_rad)| Swing { centerline_rad, amplitude_rad })
            .collect(),
        turns: turns.map(|(&from_rad, &to_rad)| Turn { from_rad, to_rad }).collect(),
        via: (!decision.via_rad.is_empty()).then(|| ViaRecord {
            via_rad: decision.via_rad.clone(),
            turning_s: span_s(decision.via_turning_us),
            rest_s: span_s(decision.via_rest_us),
        }),
        loss_tolerant: decision.loss_tolerant,
        power_tolerant: decision.power_tolerant,
    })
}
