//! Collects what a run leaves behind.

use modboat::motion::Wrench;
use protocol::time::FleetInstant;
use record::{CycleRecord, LegRecord, PoseSample, RunRecord, TailSample, ViaRecord};
use sim::TailState;
use sim::module::TICK;

use super::RunError;
use super::boats::BoatRun;
use super::clock::Gap;
use super::closed_loop::Observer;
use super::fleet::Fleet;
use super::host::Controller;
use super::pilot::{Decision, Pilot};
use super::scenario::{Demand, Scenario};

/// Seconds between two recorded poses: 20 Hz.
const POSE_EVERY_S: f64 = 0.05;
/// Seconds between two recorded sets of tails: 50 Hz.
const TAILS_EVERY_S: f64 = 0.02;

/// Impulse of the tails on the water over one swim cycle.
#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    sum: Wrench,
    time_s: f64,
}

/// See the module's documentation.
#[derive(Debug, Default)]
pub struct Recorder {
    poses: Vec<PoseSample>,
    tails: Vec<TailSample>,
    impulses: Vec<Impulse>,
    clock_error_us: Option<u64>,
}

impl<F: Fleet<Actuation = TailState>> Observer<BoatRun<'_, F>> for Recorder {
    fn observe(&mut self, now: FleetInstant, run: &BoatRun<'_, F>) -> Result<(), RunError> {
        let pilot = &run.host.controller;
        if run.is_blind() {
            return Ok(());
        }
        if let Some(tank) = &run.world {
            let sample = (&tank.pose(), run.actuation.as_slice(), tank.last_wrench());
            self.step(now, pilot.origin(), sample, pilot.decisions());
        }
        if pilot.is_under_way() {
            self.clock_error_us = self.clock_error_us.max(run.fleet.clock_error_us(now));
        }
        Ok(())
    }
}

impl Recorder {
    /// Greatest error of a module's fleet time while the fleet swam, µs, where that is known.
    #[must_use]
    pub fn clock_error_us(&self) -> Option<u64> {
        self.clock_error_us
    }

    /// Takes in one tick that ends at `now`: pose, tails, and the wrench that acted. `origin` is time zero; before it nothing is
    /// recorded.
    fn step(
        &mut self,
        now: FleetInstant,
        origin: Option<FleetInstant>,
        sample: (&PoseSample, &[TailState], Wrench),
        decisions: &[Decision],
    ) {
        let Some(origin) = origin.filter(|&origin| origin <= now) else { return };
        let ((pose, tails, wrench), dt_s) = (sample, f64::from(TICK.as_secs_f32()));
        let t_s = now.as_secs_f64() - origin.as_secs_f64();
        if self.poses.last().is_none_or(|last| t_s >= last.t_s + POSE_EVERY_S - 1e-9) {
            self.poses.push(PoseSample { t_s, ..*pose });
        }
        if self.tails.last().is_none_or(|last| t_s >= last.t_s + TAILS_EVERY_S - 1e-9) {
            let actual_rad = tails.iter().map(|tail| tail.angle_rad).collect();
            self.tails.push(TailSample { t_s, actual_rad });
        }
        self.impulses.resize(decisions.len(), Impulse::default());
        // The last decision may wait for its start while the one before it runs.
        for (decision, impulse) in decisions.iter().zip(&mut self.impulses).rev().take(2) {
            if decision.swim_start() < now && now <= decision.end() {
                let [fx, fy, tau] = wrench.to_array().map(|component| component * dt_s);
                impulse.sum = impulse.sum + Wrench { fx_n: fx, fy_n: fy, tau_nm: tau };
                impulse.time_s += dt_s;
            }
        }
    }

    /// Everything, at the end of the run, with the gaps of the host. A cycle that was not over, or not seen all through, is left out,
    /// and so are turns before the first swim.
    #[must_use]
    pub fn finish(self, scenario: &Scenario, pilot: &Pilot, gaps: &[Gap]) -> RunRecord {
        let zero_s = pilot.origin().unwrap_or_default().as_secs_f64();
        let gaps = gaps.iter().map(|gap| [gap.start, gap.end].map(|at| at.as_secs_f64() - zero_s));
        let gaps: Vec<[f64; 2]> = gaps.filter(|&[_, end_s]| end_s > 0.0).collect();
        let is_seen = |decision: &Decision| {
            let [start_s, end_s] = [decision.start, decision.end()].map(|at| at.as_secs_f64() - zero_s);
            !gaps.iter().any(|gap| start_s < gap[1] && gap[0] < end_s)
        };
        let end_s = self.poses.last().map_or(0.0, |pose| pose.t_s);
        let cycles = pilot
            .decisions()
            .iter()
            .zip(&self.impulses)
            .filter(|(decision, _)| decision.end().as_secs_f64() - zero_s <= end_s + 2.0 * POSE_EVERY_S)
            .filter(|(decision, _)| is_seen(decision) && decision.start.as_secs_f64() >= zero_s)
            .map(|(decision, impulse)| {
                let per_s = if impulse.time_s > 0.0 { 1.0 / impulse.time_s } else { 0.0 };
                let achieved = Wrench::from_array(impulse.sum.to_array().map(|component| component * per_s));
                let plan = &decision.plan;
                CycleRecord {
                    number: decision.number,
                    start_s: decision.start.as_secs_f64() - zero_s,
                    transition_s: f64::from(decision.transition.as_secs_f32()),
                    ramps_s: plan.step_times.map(|step| step.ramp_s),
                    period_s: f64::from(decision.period.as_secs_f32()),
                    outcome: plan.outcome.name(),
                    demand: decision.demand,
                    commanded: plan.wrench,
                    achieved,
                    error: plan.error,
                    travel_rad: plan.travel_rad,
                    clearance_m: plan.clearance_m,
                    guarantee_m: plan.guarantee_m,
                    solve_us: decision.solve_us,
                    swings: plan.cycle.clone(),
                    turns: decision.turns.clone(),
                    via: decision.via.as_ref().map(|via| ViaRecord {
                        via_rad: via.rad.clone(),
                        turning_s: f64::from(via.turning.as_secs_f32()),
                        rest_s: f64::from(via.rest.as_secs_f32()),
                    }),
                    outside_envelope: plan.outside_envelope,
                    loss_tolerant: plan.loss_tolerant,
                    power_tolerant: plan.power_tolerant,
                }
            })
            .collect();
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
        RunRecord {
            name: scenario.name.clone(),
            description: scenario.description.clone(),
            parameters: scenario.modboat.clone(),
            cells: scenario.structure.cells().to_vec(),
            positions_m: scenario.structure.positions_m(scenario.modboat.pitch_m),
            legs: legs.collect(),
            gaps,
            poses: self.poses,
            tails: self.tails,
            cycles,
        }
    }
}
