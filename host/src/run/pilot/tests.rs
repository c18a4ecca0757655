use super::super::host::Controller as _;
use super::*;
use crate::run::fleet::{Fleet, InProcess};
use crate::run::host::Host;
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
struct Bench {
    host: Host<Pilot, Node>,
    fleet: InProcess,
    now: FleetInstant,
    deaf: Option<Node>,
}

impl Bench {
    fn ready() -> Self {
        let scenario = Scenario::parse("t.toml", SCENARIO).expect("valid");
        let fleet = InProcess::boats(&scenario, 1).expect("valid");
        let pilot = Pilot::new(&scenario, None, || FleetInstant(0)).expect("valid");
        let host = Host::new(pilot, fleet.host(), fleet.roster());
        let mut bench = Self { host, fleet, now: FleetInstant(0), deaf: None };
        while !bench.missing().is_empty() {
            assert!(bench.now < FleetInstant(10_000_000), "still missing {:?}", bench.missing());
            bench.tick();
        }
        bench
    }

    fn missing(&self) -> Vec<usize> {
        self.host.controller.missing(self.host.dispatcher())
    }

    fn tick(&mut self) {
        self.now = self.now.after(TICK);
        self.fleet.advance(self.now).expect("a loopback");
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((length, from)) =
            self.fleet.radio().receive(self.now, &mut buffer).expect("a loopback")
        {
            let _ = self.host.handle_datagram(self.now, from, &buffer[..length]);
        }
        self.host.handle_timer(self.now).expect("a pilot does not fail");
        while let Some((to, datagram)) = self.host.poll_transmit(self.now, &mut buffer) {
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
        self.fleet.actuate(self.now, self.host.dispatcher(), &mut tails);
        tails.iter().map(|tail| tail.angle_rad).collect()
    }

    /// Sends a plan by way of [`VIA_RAD`]; 0.4 s to turn in all.
    fn by_way(&mut self) -> Decision {
        self.send(Some(VIA_RAD.to_vec()), true)
    }

    /// Sends a plan that turns by way of `via_rad`, if there is a way; 0.4 s in all.
    fn send(&mut self, via_rad: Option<Vec<f64>>, loss_tolerant: bool) -> Decision {
        let start = self.now.after(self.host.controller.lead);
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
            ..self.host.controller.planner.plan(Wrench::default(), Some(&[0.0; 2]), None)
        };
        let pilot = &mut self.host.controller;
        (pilot.known, pilot.poses) = (vec![Some(0.0); 2], vec![0.0; 2]);
        let Dispatch { number, start, motions, delivery } =
            pilot.carry_out(start, Wrench::default(), false, plan, 0, false).expect("it moves");
        let decision = pilot.decisions()[0].clone();
        self.host.dispatcher_mut().dispatch(self.now, number, start, &motions, delivery);
        decision
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
    let mut bench = Bench::ready();
    let decision = bench.by_way();
    let via = decision.via.clone().expect("two steps");
    assert_eq!(via.turning, Duration(150_000), "{via:?}");
    assert_eq!((via.rest, decision.transition), (Duration(500_000), Duration(900_000)));
    close(&bench.tails_at(decision.start), [0.0; 2]);
    close(&bench.tails_at(decision.start.after(via.turning).after(Duration(400_000))), VIA_RAD);
    close(&bench.tails_at(decision.swim_start()), TO_RAD);
    // Half a period on, module 1 is at the other end of its swing; module 2 rests.
    close(&bench.tails_at(decision.swim_start().after(Duration(750_000))), [2.0 - 2.4, -2.5]);
    close(&bench.tails_at(decision.end().after(Duration(100_000))), TO_RAD);
    assert_eq!(bench.host.controller.refusals(), 0);
    for link in bench.host.dispatcher().modules() {
        assert_eq!((link.ledger().cycles, link.ledger().acknowledged), (2, 2));
        assert!(link.has(decision.last_number()));
    }
}

#[test]
fn the_second_step_is_never_sent_if_a_module_has_not_the_first() {
    let mut bench = Bench::ready();
    bench.deaf = Some(Node(2));
    let decision = bench.by_way();
    close(&bench.tails_at(decision.end().after(Duration(1_000_000))), [VIA_RAD[0], 0.0]);
    assert!(!bench.host.controller.is_under_way());
    assert!(bench.host.dispatcher().modules().iter().all(|link| !link.has(decision.last_number())));
    // What is on record is what was sent: a turn to the poses between, and a rest.
    let left = &bench.host.controller.decisions()[0];
    assert_eq!(
        (left.via.as_ref(), left.plan.outcome, left.plan.wrench),
        (None, Outcome::Held, Wrench::default())
    );
    assert_eq!(left.turns.iter().map(|turn| turn.to_rad).collect::<Vec<_>>(), VIA_RAD);
    assert!(left.end() < decision.swim_start());
    // What hears nothing loses the time: it says so, until it hears again.
    bench.deaf = None;
    bench.tails_at(bench.now.after(Duration(2_000_000)));
    assert!(bench.missing().is_empty(), "both report where they rest");
}

#[test]
fn a_cycle_that_no_module_may_miss_is_swum_by_all() {
    let mut bench = Bench::ready();
    let decision = bench.send(None, false);
    close(&bench.tails_at(decision.start), [0.0; 2]);
    close(&bench.tails_at(decision.swim_start()), TO_RAD);
    close(&bench.tails_at(decision.swim_start().after(Duration(750_000))), [2.0 - 2.4, -2.5]);
    assert_eq!((bench.host.controller.dropped(), bench.host.controller.refusals()), (0, 0));
    for link in bench.host.dispatcher().modules() {
        assert!(link.has(decision.number));
        assert_eq!((link.ledger().cycles, link.ledger().acknowledged), (1, 1));
    }
}

#[test]
fn a_cycle_that_no_module_may_miss_is_swum_by_none_if_one_is_deaf() {
    for via_rad in [None, Some(VIA_RAD.to_vec())] {
        let mut bench = Bench::ready();
        bench.deaf = Some(Node(2));
        let decision = bench.send(via_rad, false);
        close(&bench.tails_at(decision.swim_start()), [0.0; 2]);
        close(&bench.tails_at(decision.end()), [0.0; 2]);
        assert!(
            !bench.host.controller.is_under_way() && bench.missing().is_empty(),
            "both rest where they were"
        );
        assert_eq!((bench.host.controller.dropped(), bench.host.controller.refusals()), (1, 0));
        // What is on record, and what the observer is told, is what was done.
        let left = &bench.host.controller.decisions()[0];
        assert_eq!(
            (left.plan.outcome, left.plan.wrench, left.transition),
            (Outcome::Held, Wrench::default(), Duration(0))
        );
        assert!(left.turns.iter().all(|turn| turn.rotation_rad() == 0.0) && left.via.is_none());
        assert_eq!(bench.host.dispatcher().modules()[0].ledger().unanswered, 1);
    }
}

/// The module lets go of its cycle, and where its tail will be is unknown: no plan counts on it.
#[test]
fn a_module_that_has_stopped_is_not_planned_for() {
    let mut bench = Bench::ready();
    let decision = bench.send(None, true);
    bench.tails_at(decision.swim_start());
    assert!(bench.missing().is_empty());
    bench.host.dispatcher_mut().emergency_stop(bench.now);
    bench.tails_at(decision.swim_start().after(Duration(100_000)));
    assert_eq!(bench.missing(), [0, 1]);
    bench.host.dispatcher_mut().release(bench.now);
    bench.tails_at(decision.end().after(Duration(500_000)));
    assert_eq!(bench.missing(), [0; 0]);
}

/// A module that loses its power in the turn stands on it, and reports nothing more: what it ran before tells that the turn is behind the other.
#[test]
fn a_turn_counts_for_the_next_plan_until_its_module_reports_that_it_is_through() {
    let mut bench = Bench::ready();
    let decision = bench.send(None, true);
    let mut remaining = Remaining::default();
    bench.tails_at(decision.start.after(Duration(200_000)));
    let before = remaining.of(&decision, bench.host.dispatcher(), false);
    assert_eq!(before.transition, Some(decision.turns.as_slice()));
    assert_eq!((before.cycle, before.via_rad, before.is_over), (decision.plan.cycle.as_slice(), None, false));
    bench.fleet.modules_mut()[1].reboot(bench.now, Duration(60_000_000));
    bench.tails_at(decision.swim_start().after(Duration(200_000)));
    let links = bench.host.dispatcher();
    assert!(links.modules()[1].has(decision.number), "it counts as one that runs the cycle");
    let through = Turn { from_rad: TO_RAD[0], to_rad: TO_RAD[0] };
    let before = remaining.of(&decision, links, false);
    assert_eq!(before.transition, Some([through, decision.turns[1]].as_slice()));
}

#[test]
fn of_two_steps_the_first_is_behind_all_that_run_the_second_and_nothing_is_left_of_a_turn_in_the_swim() {
    let mut bench = Bench::ready();
    let decision = bench.by_way();
    let mut remaining = Remaining::default();
    bench.tails_at(decision.last_start().after(Duration(100_000)));
    let second = [0, 1].map(|module| Turn { from_rad: VIA_RAD[module], to_rad: TO_RAD[module] });
    let before = remaining.of(&decision, bench.host.dispatcher(), false);
    assert_eq!((before.transition, before.via_rad), (Some(second.as_slice()), None));
    bench.tails_at(decision.swim_start().after(Duration(200_000)));
    assert_eq!(remaining.of(&decision, bench.host.dispatcher(), false).transition, None);
}
