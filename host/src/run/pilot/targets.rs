//! What the fleet is steered by: the legs of its scenario, or what an operator has given instead.

use std::collections::VecDeque;

use modboat::bounds::Place;
use modboat::parameters::Parameters;

use super::super::scenario::{Demand, Scenario};
use super::super::steering::Steering;

/// A waypoint is reached within this share of a module's pitch. *Assumed.*
const REACHED: f64 = 0.5;

/// Where the target comes from.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    /// The scenario's legs.
    Legs,
    /// There is none, why: empty before the first.
    None(&'static str),
    /// An operator's, until the next.
    Given(Demand),
    /// An operator's, one after the other; never empty.
    Waypoints(VecDeque<[f64; 2]>),
}

/// What is asked for at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Changes with each target.
    pub target: usize,
    /// Where to, or how fast.
    pub demand: Demand,
    /// Heading Θ, rad.
    pub heading_rad: f64,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Targets {
    source: Source,
    /// The heading that goes with it; the leg's where there is none.
    heading_rad: Option<f64>,
    /// How many targets were given.
    given: usize,
}

impl Targets {
    /// By the legs of `scenario`; without a target where it has none.
    pub(super) fn new(scenario: &Scenario) -> Self {
        let source = if scenario.legs.is_empty() { Source::None("") } else { Source::Legs };
        Self { source, heading_rad: None, given: 0 }
    }

    /// Why there is no target, if there is none.
    pub(super) fn lacks_target(&self) -> Option<&'static str> {
        match self.source {
            Source::None(why) => Some(why),
            _ => None,
        }
    }

    /// What is asked for `t_s` after time zero.
    #[must_use]
    pub fn asked(&self, scenario: &Scenario, t_s: f64) -> Option<Asked> {
        let leg_at = scenario.leg_at(t_s);
        let leg = scenario.legs.get(leg_at);
        let (target, demand) = match &self.source {
            Source::None(_) => return None,
            Source::Legs if self.given == 0 => (leg_at, leg?.demand),
            Source::Legs => (leg_at + scenario.legs.len() * self.given, leg?.demand),
            Source::Given(demand) => (scenario.legs.len() + self.given, *demand),
            Source::Waypoints(all) => (scenario.legs.len() + self.given, Demand::Station(*all.front()?)),
        };
        let heading_rad = self.heading_rad.or(leg.map(|leg| leg.heading_rad));
        Some(Asked {
            target,
            demand,
            heading_rad: heading_rad.unwrap_or_else(|| scenario.start_heading_rad()),
        })
    }

    /// Whether the target is an operator's.
    #[must_use]
    pub fn is_given(&self) -> bool {
        self.source != Source::Legs
    }

    /// Waypoints that are left.
    pub fn waypoints(&self) -> impl Iterator<Item = &[f64; 2]> {
        let all = match &self.source {
            Source::Waypoints(all) => Some(all),
            _ => None,
        };
        all.into_iter().flatten()
    }

    /// How many targets there were: it changes with what [`asked`](Self::asked) says, but for the legs.
    #[must_use]
    pub fn changes(&self) -> (usize, usize) {
        (self.given, self.waypoints().count())
    }

    /// The structure is at `position_m`: a waypoint that it has reached gives way to the next, but for the last.
    pub(super) fn arrive(&mut self, position_m: [f64; 2], parameters: &Parameters) {
        if let Source::Waypoints(all) = &mut self.source {
            let near = |&[x, y]: &[f64; 2]| {
                (x - position_m[0]).hypot(y - position_m[1]) < REACHED * parameters.pitch_m
            };
            while all.len() > 1 && all.front().is_some_and(near) {
                all.pop_front();
                self.given += 1;
            }
        }
    }

    /// A stop or a hold: a velocity is for now, and does not go on after it.
    pub(super) fn halt(&mut self) {
        if matches!(self.source, Source::Given(Demand::Velocity(_))) {
            self.source = Source::None("it was stopped or held");
            self.given += 1;
        }
    }

    /// Another target, given with the structure at `place`, `t_s` after time zero.
    ///
    /// # Errors
    /// Why it is none that can be followed.
    pub(super) fn steer(
        &mut self,
        steering: &Steering,
        scenario: &Scenario,
        place: Option<Place>,
        t_s: f64,
    ) -> Result<(), String> {
        let heading_rad = match steering {
            Steering::Velocity(_, heading_rad)
            | Steering::Station(_, heading_rad)
            | Steering::Waypoints(_, heading_rad) => *heading_rad,
            Steering::Heading(heading_rad) => Some(*heading_rad),
            Steering::Legs | Steering::LetGo(_) => None,
        };
        if let Some(heading_rad) = heading_rad.filter(|rad| !(-1e3..=1e3).contains(rad)) {
            return Err(format!("heading {heading_rad} rad: must lie between −1000 and 1000"));
        }
        let here =
            || place.map(|place| place.position_m).ok_or("there is no pose yet: where it is is not known");
        let source = match steering {
            Steering::Velocity(velocity_m_s, _) => {
                slow_enough(*velocity_m_s, &scenario.modboat)?;
                Source::Given(Demand::Velocity(*velocity_m_s))
            }
            Steering::Station(position_m, _) => {
                inside(*position_m, scenario)?;
                Source::Given(Demand::Station(*position_m))
            }
            Steering::Waypoints(all, _) if all.is_empty() => Source::Given(Demand::Station(here()?)),
            Steering::Waypoints(all, _) => {
                all.iter().try_for_each(|position_m| inside(*position_m, scenario))?;
                Source::Waypoints(all.iter().copied().collect())
            }
            Steering::Heading(_) if self.lacks_target().is_some() => Source::Given(Demand::Station(here()?)),
            Steering::Heading(_) => self.source.clone(),
            Steering::Legs if scenario.legs.is_empty() => return Err("this run has no legs".to_owned()),
            Steering::Legs => Source::Legs,
            Steering::LetGo(why) => Source::None(why),
        };
        let kept = self.asked(scenario, t_s).map(|asked| asked.heading_rad);
        let kept = kept.or(self.heading_rad).or(place.map(|place| place.heading_rad));
        self.heading_rad = match steering {
            Steering::Legs => None,
            _ => heading_rad.or(kept),
        };
        self.source = source;
        self.given += 1;
        Ok(())
    }
}

fn inside(position_m: [f64; 2], scenario: &Scenario) -> Result<(), String> {
    let [x, y] = position_m;
    if !position_m.iter().all(|value| (-1e6..=1e6).contains(value)) {
        return Err(format!("[{x}, {y}] m: must lie between −1000000 and 1000000"));
    }
    match &scenario.bounds {
        Some(bounds) if !bounds.contains(position_m) => {
            Err(format!("[{x:.3}, {y:.3}] m: lies outside of the bounds"))
        }
        _ => Ok(()),
    }
}

fn slow_enough(velocity_m_s: [f64; 2], parameters: &Parameters) -> Result<(), String> {
    let (speed_m_s, most_m_s) = (velocity_m_s[0].hypot(velocity_m_s[1]), speed_max_m_s(parameters));
    // What a page rounds up is no mistake. Not a number is none either.
    if speed_m_s <= most_m_s * 1.001 {
        return Ok(());
    }
    Err(format!("{speed_m_s:.3} m/s: at most {most_m_s:.3}"))
}

/// The greatest steady speed along an axis, with every tail pushing that way: v_max = √(F(A_max) / C_L), by (2) and (19), m/s.
#[must_use]
pub fn speed_max_m_s(parameters: &Parameters) -> f64 {
    (parameters.thrust_n(parameters.amplitude_max_rad) / parameters.drag_n_s2_m2).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATION: Demand = Demand::Station([1.0, 0.5]);

    fn scenario(bounds: bool) -> Scenario {
        let edge = "[bounds]\nedge_m = [[-2, -2], [2, -2], [2, 2], [-2, 2]]\n";
        let text = format!(
            "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 5.0\nvelocity_m_s = [0.04, 0.0]\n\
             heading_rad = 1.5\n{}",
            if bounds { edge } else { "" }
        );
        Scenario::parse("t.toml", &text).expect("a scenario")
    }

    fn place() -> Option<Place> {
        Some(Place { position_m: [0.25, 0.0], heading_rad: 7.8 })
    }

    #[test]
    fn targets_take_the_place_of_legs_and_give_way_to_them() {
        let scenario = scenario(false);
        let mut targets = Targets::new(&scenario);
        let leg = targets.asked(&scenario, 0.0).expect("a leg");
        assert_eq!((leg.demand, targets.is_given()), (Demand::Velocity([0.04, 0.0]), false));
        targets.steer(&Steering::Station([1.0, 0.5], None), &scenario, place(), 0.0).expect("followed");
        let given = targets.asked(&scenario, 0.0).expect("a target");
        assert!(
            given.demand == STATION && given.target != leg.target && (given.heading_rad - 1.5).abs() < 1e-12
        );
        targets.steer(&Steering::Heading(1.6), &scenario, place(), 0.0).expect("followed");
        let turned = targets.asked(&scenario, 0.0).expect("a target");
        assert!(turned.demand == STATION && (turned.heading_rad - 1.6).abs() < 1e-12);
        targets.halt();
        assert!(targets.asked(&scenario, 0.0).is_some_and(|asked| asked.demand == STATION));
        targets.steer(&Steering::Velocity([0.0, 0.05], None), &scenario, place(), 0.0).expect("followed");
        targets.halt();
        assert_eq!(targets.lacks_target(), Some("it was stopped or held"));
        targets.steer(&Steering::LetGo("let go"), &scenario, place(), 0.0).expect("followed");
        assert_eq!((targets.asked(&scenario, 0.0), targets.lacks_target()), (None, Some("let go")));
        targets.steer(&Steering::Legs, &scenario, place(), 0.0).expect("followed");
        let again = targets.asked(&scenario, 0.0).expect("a leg");
        assert!(again.demand == leg.demand && again.target != leg.target && !targets.is_given());
    }

    #[test]
    fn waypoints_follow_each_other_and_the_last_is_kept() {
        let scenario = scenario(true);
        let mut targets = Targets::new(&scenario);
        let all = vec![[0.5, 0.0], [1.0, 0.0], [1.0, 1.0]];
        targets.steer(&Steering::Waypoints(all, None), &scenario, place(), 0.0).expect("followed");
        let mut met = Vec::new();
        for at in [[0.0, 0.0], [0.45, 0.0], [0.96, 0.0], [1.0, 1.0], [1.0, 1.0]] {
            targets.arrive(at, &scenario.modboat);
            met.push(targets.asked(&scenario, 0.0).map(|asked| asked.demand));
        }
        let station = |x, y| Some(Demand::Station([x, y]));
        assert_eq!(
            met,
            [station(0.5, 0.0), station(1.0, 0.0), station(1.0, 1.0), station(1.0, 1.0), station(1.0, 1.0)]
        );
        targets.steer(&Steering::Waypoints(Vec::new(), None), &scenario, place(), 0.0).expect("followed");
        assert_eq!(targets.asked(&scenario, 0.0).map(|asked| asked.demand), station(0.25, 0.0));
    }

    #[test]
    fn what_cannot_be_followed_changes_nothing() {
        let scenario = scenario(true);
        let mut targets = Targets::new(&scenario);
        for steering in [
            Steering::Station([3.0, 0.0], None),
            Steering::Station([f64::NAN, 0.0], None),
            Steering::Waypoints(vec![[0.0, 0.0], [0.0, 3.0]], None),
            Steering::Velocity([0.5, 0.0], None),
            Steering::Velocity([f64::NAN, 0.0], None),
            Steering::Velocity([0.0, 0.0], Some(f64::INFINITY)),
            Steering::Heading(f64::NAN),
        ] {
            let why = targets.steer(&steering, &scenario, place(), 0.0).expect_err("cannot be followed");
            assert!(!why.is_empty() && targets.changes() == (0, 0), "{steering:?}: {why}");
        }
        let waits = Scenario { legs: Vec::new(), ..scenario };
        let mut targets = Targets::new(&waits);
        assert!(targets.steer(&Steering::Legs, &waits, place(), 0.0).is_err());
        assert!(targets.steer(&Steering::Heading(0.0), &waits, None, 0.0).is_err());
        assert_eq!(targets.lacks_target(), Some(""));
    }
}
