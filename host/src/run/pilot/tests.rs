use super::*;
use crate::run::fleet::{Fleet, InProcess};
use link::loopback::Node;
use modboat::motion::StepTime;
use modboat::motion::Swing;
use protocol::{MAX_DATAGRAM, Radio};
use sim::TailState;
use sim::module::TICK;

const SCENARIO: &str = "name = \"t\"\n[structure]\nsize = \"2x1\"\n[[leg]]\nduration_s = 60.0\n\
                        velocity_m_s = [0.0, 0.0]\nheading_rad = 0.0\n";
/// Poses between and after; module 2 rests in the cycle that follows.
const VIA_RAD: [f64; 2] = [1.0, -0.5];
const TO_RAD: [f64; 2] = [2.0, -2.5];

/// Two modules and their pilot, which decides nothing by itself: no fix ever reaches it.
struct Drill {
    pilot: Pilot<Node>,
    fleet: InProcess,
    now: FleetInstant,
    deaf: Option<Node>,
}

impl Drill {
    fn ready() -> Self {
        let scenario = Scenario::parse("t.toml", SCENARIO).expect("valid");
        let fleet = InProcess::new(&scenario, 1).expect("valid");
        let pilot =
            Pilot::new(&scenario, fleet.host(), fleet.roster(), None, || FleetInstant(0)).expect("valid");
        let mut drill = Self { pilot, fleet, now: FleetInstant(0), deaf: None };
        while !drill.pilot.missing().is_empty() {
            assert!(drill.now < FleetInstant(10_000_000), "still missing {:?}", drill.pilot.missing());
            drill.tick();
        }
        drill
    }

    fn tick(&mut self) {
        self.now = self.now.after(TICK);
        self.fleet.advance(self.now).expect("a loopback");
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((length, from)) =
            self.fleet.radio().receive(self.now, &mut buffer).expect("a loopback")
        {
            let _ = self.pilot.handle_datagram(self.now, from, &buffer[..length]);
        }
        self.pilot.handle_timer(self.now);
        while let Some((to, datagram)) = self.pilot.poll_transmit(self.now, &mut buffer) {
            if self.deaf != Some(to) {
                self.fleet.radio().send(self.now, to, datagram).expect("a loopback");
            }
        }
    }

    /// Tail angles at `at`.
    fn tails_at(&mut self, at: FleetInstant) -> Vec<f64> {
        while self.now < at {
            self.tick();
        }
        let mut tails: Vec<TailState> = Vec::new();
        self.fleet.tails(self.now, self.pilot.dispatcher(), &mut tails);
        tails.iter().map(|tail| tail.angle_rad).collect()
    }

    /// Sends a plan by way of [`VIA_RAD`]; 0.4 s to turn in all.
    fn by_way(&mut self) -> Decision {
        self.send(Some(VIA_RAD.to_vec()), true)
    }

    /// Sends a plan that turns by way of `via_rad`, if there is a way; 0.4 s in all.
    fn send(&mut self, via_rad: Option<Vec<f64>>, loss_tolerant: bool) -> Decision {
        let start = self.now.after(self.pilot.lead);
        let cycle = [1.2, 0.0].iter().zip(TO_RAD);
        let cycle = cycle.map(|(&amplitude_rad, start_rad)| Swing {
            centerline_rad: start_rad - amplitude_rad,
            amplitude_rad,
        });
        let plan = Plan {
            cycle: cycle.collect(),
            transition: Some(TO_RAD.map(|to_rad| Turn { from_rad: 0.0, to_rad }).to_vec()),
            via_rad: via_rad.clone(),
            transition_s: 0.4,
            // With a way between: 0.15 and 0.25 s. Otherwise all of it.
            step_times: if via_rad.is_some() { [step(0.15), step(0.25)] } else { [step(0.4), step(0.0)] },
            outcome: Outcome::Planned,
            loss_tolerant,
            ..self.pilot.planner.plan(Wrench::default(), Some(&[0.0; 2]), None)
        };
        let now = self.now;
        self.pilot.carry_out(now, start, Wrench::default(), (&[0.0; 2], vec![false; 2]), plan, 0);
        self.pilot.decisions()[0].clone()
    }
}

/// One step of a transition, with ramps of 50 ms where that fits.
fn step(duration_s: f64) -> StepTime {
    StepTime { duration_s, ramp_s: 0.05_f64.min(0.5 * duration_s) }
}

fn close(seen: &[f64], expected: [f64; 2]) {
    assert!(seen.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{seen:?} for {expected:?}");
}

#[test]
fn a_transition_in_two_steps_is_swum_by_way_of_its_poses_between() {
    let mut drill = Drill::ready();
    let decision = drill.by_way();
    let via = decision.via.clone().expect("two steps");
    assert_eq!(via.turning, Duration(150_000), "{via:?}");
    assert_eq!((via.rest, decision.transition), (Duration(500_000), Duration(900_000)));
    close(&drill.tails_at(decision.start), [0.0; 2]);
    close(&drill.tails_at(decision.start.after(via.turning).after(Duration(400_000))), VIA_RAD);
    close(&drill.tails_at(decision.swim_start()), TO_RAD);
    // Half a period on, module 1 is at the other end of its swing; module 2 rests.
    close(&drill.tails_at(decision.swim_start().after(Duration(750_000))), [2.0 - 2.4, -2.5]);
    close(&drill.tails_at(decision.end().after(Duration(100_000))), TO_RAD);
    assert_eq!(drill.pilot.refusals(), 0);
    for link in drill.pilot.dispatcher().modules() {
        assert_eq!((link.ledger().cycles, link.ledger().acknowledged), (2, 2));
        assert!(link.has(decision.last_number()));
    }
}

#[test]
fn the_second_step_is_never_sent_if_a_module_has_not_the_first() {
    let mut drill = Drill::ready();
    drill.deaf = Some(Node(2));
    let decision = drill.by_way();
    close(&drill.tails_at(decision.end().after(Duration(1_000_000))), [VIA_RAD[0], 0.0]);
    assert!(!drill.pilot.is_swimming());
    assert!(drill.pilot.dispatcher().modules().iter().all(|link| !link.has(decision.last_number())));
    // What is on record is what was sent: a turn to the poses between, and a rest.
    let left = &drill.pilot.decisions()[0];
    assert_eq!(
        (left.via.as_ref(), left.plan.outcome, left.plan.wrench),
        (None, Outcome::Held, Wrench::default())
    );
    assert_eq!(left.turns.iter().map(|turn| turn.to_rad).collect::<Vec<_>>(), VIA_RAD);
    assert!(left.end() < decision.swim_start());
    assert!(drill.pilot.missing().is_empty(), "both report where they rest");
}

#[test]
fn a_cycle_that_no_module_may_miss_is_swum_by_all() {
    let mut drill = Drill::ready();
    let decision = drill.send(None, false);
    close(&drill.tails_at(decision.start), [0.0; 2]);
    close(&drill.tails_at(decision.swim_start()), TO_RAD);
    close(&drill.tails_at(decision.swim_start().after(Duration(750_000))), [2.0 - 2.4, -2.5]);
    assert_eq!((drill.pilot.dropped(), drill.pilot.refusals()), (0, 0));
    for link in drill.pilot.dispatcher().modules() {
        assert!(link.has(decision.number));
        assert_eq!((link.ledger().cycles, link.ledger().acknowledged), (1, 1));
    }
}

#[test]
fn a_cycle_that_no_module_may_miss_is_swum_by_none_if_one_is_deaf() {
    for via_rad in [None, Some(VIA_RAD.to_vec())] {
        let mut drill = Drill::ready();
        drill.deaf = Some(Node(2));
        let decision = drill.send(via_rad, false);
        close(&drill.tails_at(decision.swim_start()), [0.0; 2]);
        close(&drill.tails_at(decision.end()), [0.0; 2]);
        assert!(!drill.pilot.is_swimming() && drill.pilot.missing().is_empty(), "both rest where they were");
        assert_eq!((drill.pilot.dropped(), drill.pilot.refusals()), (1, 0));
        // What is on record, and what the observer is told, is what was done.
        let left = &drill.pilot.decisions()[0];
        assert_eq!(
            (left.plan.outcome, left.plan.wrench, left.transition),
            (Outcome::Held, Wrench::default(), Duration(0))
        );
        assert!(left.turns.iter().all(|turn| turn.rotation_rad() == 0.0) && left.via.is_none());
        assert_eq!(drill.pilot.dispatcher().modules()[0].ledger().unanswered, 1);
    }
}

/// The module lets go of its cycle, and where its tail will be is unknown: no plan counts on it.
#[test]
fn a_module_that_has_stopped_is_not_planned_for() {
    let mut drill = Drill::ready();
    let decision = drill.send(None, true);
    drill.tails_at(decision.swim_start());
    assert!(drill.pilot.missing().is_empty());
    drill.pilot.dispatcher.emergency_stop(drill.now);
    drill.tails_at(decision.swim_start().after(Duration(100_000)));
    assert_eq!(drill.pilot.missing(), [0, 1]);
    drill.pilot.dispatcher.release(drill.now);
    drill.tails_at(decision.end().after(Duration(500_000)));
    assert_eq!(drill.pilot.missing(), [0; 0]);
}
