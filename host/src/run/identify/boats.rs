//! From a log of Modboats to what constants are identified from: measured poses, reported tails, planned cycles, batteries.

use std::collections::BTreeMap;

use identify::data::{Boat, Cycle, Recording, Tails};
use modboat::motion::Swing;
use modboat::observer::Fix;
use runlog::flotilla::{Decision, Fix as FixMessage, Gap, Scenario as Head};
use runlog::reader::{Entry, LogError};
use runlog::ros::{BatteryState, JointState};

use super::super::log::instant;
use super::super::log::replay::ReplayError;
use super::super::scenario::Scenario;

/// A run of Modboats, as its log has it.
pub struct Logged {
    /// What was run.
    pub scenario: Scenario,
    /// The structure, and what was believed of it.
    pub boat: Boat,
    /// What was measured.
    pub recording: Recording,
}

#[derive(Default)]
pub(super) struct Taken {
    recording: Recording,
    /// By index: one that is given up is told again.
    decisions: BTreeMap<u32, Decision>,
    gaps: BTreeMap<u32, [f64; 2]>,
    voltage: (f64, u32),
}

impl Taken {
    pub(super) fn take(&mut self, entry: &Entry<'_>) -> Result<(), LogError> {
        match entry.topic {
            "/fix" => {
                let fix: FixMessage = entry.read()?;
                let FixMessage { captured_s: t_s, position_m, heading_rad, .. } = fix;
                self.recording.fixes.push(Fix { t_s, position_m, heading_rad });
            }
            "/tails" => {
                let tails: JointState = entry.read()?;
                let t_s = instant(&tails.header.stamp).as_secs_f64();
                let (angle_rad, rate_rad_s) = (tails.position, tails.velocity);
                self.recording.tails.push(Tails { t_s, angle_rad, rate_rad_s });
            }
            "/decision" => {
                let decision: Decision = entry.read()?;
                self.decisions.insert(decision.index, decision);
            }
            "/gap" => {
                let gap: Gap = entry.read()?;
                self.gaps.insert(gap.index, [gap.start_us, gap.end_us].map(|us| us as f64 * 1e-6));
            }
            topic if topic.starts_with("/module_") && topic.ends_with("/battery") => {
                let voltage = f64::from(entry.read::<BatteryState>()?.voltage);
                if voltage.is_finite() && voltage > 0.0 {
                    self.voltage = (self.voltage.0 + voltage, self.voltage.1 + 1);
                }
            }
            _ => {}
        }
        Ok(())
    }

    pub(super) fn finish(self, name: &str, head: Head) -> Result<Logged, ReplayError> {
        let scenario = Scenario::parse("/scenario", &head.document)
            .map_err(|error| ReplayError::Senseless(error.to_string()))?;
        let recording = self.recording(name, scenario.structure.len())?;
        let boat = Boat {
            structure: scenario.structure.clone(),
            ids: head.modules,
            belief: scenario.modboat.clone(),
            rotor_inertia_kg_m2: scenario.motor.rotor_inertia_kg_m2,
        };
        Ok(Logged { scenario, boat, recording })
    }

    fn recording(self, name: &str, modules: usize) -> Result<Recording, ReplayError> {
        let Self { mut recording, decisions, gaps, voltage } = self;
        name.clone_into(&mut recording.name);
        let wrong = |count: usize| count != modules;
        if recording.tails.iter().any(|tails| wrong(tails.angle_rad.len()) || wrong(tails.rate_rad_s.len())) {
            let message = format!("/tails of another number of modules than {modules}");
            return Err(ReplayError::Senseless(message));
        }
        recording.cycles = decisions.values().filter(|decision| decision.period_us > 0).map(cycle).collect();
        recording.gaps = gaps.into_values().collect();
        recording.battery_v = (voltage.1 > 0).then(|| voltage.0 / f64::from(voltage.1));
        Ok(recording)
    }
}

/// The swim cycle of a decision; a module that was missing rests.
fn cycle(decision: &Decision) -> Cycle {
    let start_us = decision.start_us + u64::from(decision.transition_us);
    let missing = |place: usize| decision.missing.get(place).copied().unwrap_or(false);
    let swings = decision.centerline_rad.iter().zip(&decision.amplitude_rad).enumerate();
    let swings = swings.map(|(place, (&centerline_rad, &amplitude_rad))| Swing {
        centerline_rad,
        amplitude_rad: if missing(place) { 0.0 } else { amplitude_rad },
    });
    Cycle {
        start_s: start_us as f64 * 1e-6,
        period_s: f64::from(decision.period_us) * 1e-6,
        swings: swings.collect(),
    }
}
