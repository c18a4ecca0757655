//! A scenario as a document again, with every value that its file left out: what a log keeps of it. Reading it gives the same scenario.

use link::faults::FaultParameters;
use modboat::control::ControlConfig;
use modboat::observer::ObserverParameters;
use modboat::parameters::Parameters;
use modboat::planner_config::PlannerConfig;
use quantity::bounds::Bounds;
use serde::Serialize;
use sim::clock::ClockParameters;
use sim::mocap::MocapParameters;
use sim::motor::MotorParameters;
use sim::tank::TankParameters;

use super::{Demand, PoseParameters, Scenario, Start, Timing};

#[derive(Serialize)]
struct Document<'a> {
    name: &'a str,
    description: &'a str,
    seed: i64,
    structure: Shape<'a>,
    leg: Vec<LegTable>,
    start: &'a Start,
    modboat: &'a Parameters,
    planner: &'a PlannerConfig,
    control: &'a ControlConfig,
    observer: &'a ObserverParameters,
    timing: &'a Timing,
    pose: &'a PoseParameters,
    bounds: Option<&'a Bounds>,
    tank: &'a TankParameters,
    motor: &'a MotorParameters,
    clock: &'a ClockParameters,
    mocap: &'a MocapParameters,
    radio: &'a FaultParameters,
}

#[derive(Serialize)]
struct Shape<'a> {
    cells: &'a [[i32; 2]],
}

#[derive(Serialize)]
struct LegTable {
    duration_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity_m_s: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_m: Option<[f64; 2]>,
    heading_rad: f64,
}

impl Scenario {
    /// As TOML.
    #[must_use]
    pub fn document(&self) -> String {
        let leg = self.legs.iter().map(|leg| {
            let (velocity_m_s, position_m) = match leg.demand {
                Demand::Velocity(velocity_m_s) => (Some(velocity_m_s), None),
                Demand::Station(position_m) => (None, Some(position_m)),
            };
            LegTable { duration_s: leg.duration_s, velocity_m_s, position_m, heading_rad: leg.heading_rad }
        });
        let Self {
            start,
            modboat,
            planner,
            control,
            observer,
            timing,
            pose,
            tank,
            motor,
            clock,
            mocap,
            radio,
            ..
        } = self;
        let document = Document {
            name: &self.name,
            description: &self.description,
            // TOML has no greater numbers. The seed that was run from stands beside the document.
            seed: i64::try_from(self.seed).unwrap_or(i64::MAX),
            structure: Shape { cells: self.structure.cells() },
            leg: leg.collect(),
            start,
            modboat,
            planner,
            control,
            observer,
            timing,
            pose,
            bounds: self.bounds.as_ref(),
            tank,
            motor,
            clock,
            mocap,
            radio,
        };
        toml::to_string(&document).unwrap_or_else(|error| format!("# {error}\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::BUILT_IN;
    use super::*;

    #[test]
    fn a_document_reads_back_as_its_scenario() {
        for (name, _) in BUILT_IN {
            let scenario = Scenario::open(name).expect(name);
            let document = scenario.document();
            let again =
                Scenario::parse(name, &document).unwrap_or_else(|error| panic!("{error}\n{document}"));
            assert_eq!(again.structure.cells(), scenario.structure.cells(), "{name}");
            // All but the structure, whose map has no order.
            let shown = |scenario: &Scenario| {
                let text = format!("{scenario:?}");
                text.find("legs: ").map_or_else(String::new, |at| text[at..].to_owned())
            };
            assert!(shown(&again).len() > 1000);
            assert_eq!(shown(&again), shown(&scenario), "{document}");
        }
    }
}
