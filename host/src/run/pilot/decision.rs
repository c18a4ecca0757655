//! One decision, and what goes over the wire for it.

use firmware::modboat::cycle::SwimCycle;
use firmware::modboat::waveform::Waveform;
use link::dispatcher::{Dispatcher, ModuleLink};
use modboat::motion::StepTime;
use modboat::motion::{Swing, Turn, Wrench};
use modboat::plan::{Outcome, Plan, Previous};
use protocol::configuration::TailLimits;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;
use protocol::{Delivery, ModboatCycle, ModuleState, Motion, TransitionLaw};

use super::super::host::Dispatch;
use super::phase::Phase;
use super::span;

/// One decision, as dispatched (or, where the fleet is held, as not dispatched).
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Cycle number k, from 1.
    pub number: u32,
    /// Start of the transition, fleet time.
    pub start: FleetInstant,
    /// Length of the transition, all of it; zero where none is needed.
    pub transition: Duration,
    /// Its first step, where it has two.
    pub via: Option<Via>,
    /// Length of the swim cycle.
    pub period: Duration,
    /// The wrench asked for.
    pub demand: Wrench,
    /// Whether it is for less than what the leg asks, to keep off the edge of the water.
    pub bounded: bool,
    /// By module: it was missing, and got nothing.
    pub missing: Vec<bool>,
    /// Each module's transition; from = to where it does not move.
    pub turns: Vec<Turn>,
    /// The plan.
    pub plan: Plan,
    /// Time the planner took, µs.
    pub solve_us: u64,
}

/// One cycle of every module.
#[derive(Clone, Debug, PartialEq)]
pub struct SentCycle {
    /// Its number.
    pub number: u32,
    /// When it starts, fleet time.
    pub start: FleetInstant,
    /// What each module does.
    pub motions: Vec<Motion>,
}

impl SentCycle {
    /// Where it has the tail of a module (by index) at `at`, modulo 2π, rad.
    #[must_use]
    pub fn tail_rad(&self, index: usize, at: FleetInstant) -> Option<f64> {
        let Motion::Modboat(cycle) = self.motions.get(index)? else { return None };
        let waveform = Waveform::new(cycle.centerline, cycle.amplitude, cycle.period);
        let turning = (cycle.transition, cycle.law);
        let cycle = SwimCycle::new(self.number, self.start, cycle.rotation, turning, waveform);
        Some(f64::from(cycle.reference(at).angle_rad))
    }
}

/// The first of two steps of a transition.
#[derive(Clone, Debug, PartialEq)]
pub struct Via {
    /// Where it ends, rad by module.
    pub rad: Vec<f64>,
    /// How long it turns.
    pub turning: Duration,
    /// How long it rests then: the least period a module takes.
    pub rest: Duration,
}

impl Via {
    fn length(&self) -> Duration {
        Duration(self.turning.0 + self.rest.0)
    }
}

impl Decision {
    /// Number of the last cycle that is sent for it.
    #[must_use]
    pub fn last_number(&self) -> u32 {
        self.number + u32::from(self.via.is_some())
    }

    /// Start of the cycle with the last step.
    pub(super) fn last_start(&self) -> FleetInstant {
        self.via.as_ref().map_or(self.start, |via| self.start.after(via.length()))
    }

    /// What goes over the wire for it: one cycle, or the two that it takes.
    #[must_use]
    pub fn sent_cycles(&self) -> Vec<SentCycle> {
        let first = SentCycle { number: self.number, start: self.start, motions: first_cycles(self) };
        let last =
            || SentCycle { number: self.last_number(), start: self.last_start(), motions: cycles(self) };
        if self.via.is_some() { vec![first, last()] } else { vec![first] }
    }

    /// Start of the swim cycle.
    #[must_use]
    pub fn swim_start(&self) -> FleetInstant {
        self.start.after(self.transition)
    }

    /// End of the swim cycle.
    #[must_use]
    pub fn end(&self) -> FleetInstant {
        self.swim_start().after(self.period)
    }
}

/// The first step of a plan's transition, if it has two, and the length of all of it.
pub(super) fn steps(plan: &Plan, turns: &[Turn]) -> (Option<Via>, Duration) {
    if plan.transition.is_none() {
        return (None, Duration(0));
    }
    let [first, second] = plan.step_times.map(|step| span(step.duration_s));
    let Some(via_rad) = plan.via_rad.as_ref().filter(|via| via.len() == turns.len()) else {
        return (None, first);
    };
    // A cycle that only turns still has a period: the least that a module takes.
    let rest = TailLimits::default().period_min;
    (Some(Via { rad: via_rad.clone(), turning: first, rest }), Duration(first.0 + rest.0 + second.0))
}

/// The law of time of one step of the plan's transition.
fn law(step: StepTime) -> TransitionLaw {
    match span(step.ramp_s) {
        Duration(0) => TransitionLaw::ConstantSpeed,
        // Both are rounded to the microsecond: the ramp must not exceed half of the step.
        ramp => TransitionLaw::RestToRest { ramp: Duration(ramp.0.min(span(step.duration_s).0 / 2)) },
    }
}

/// What is left of a decision that no module runs: every tail rests where it was, for `rest`.
pub(super) fn give_up(decision: &mut Decision, rest: Duration) {
    let rad: Vec<f64> = decision.turns.iter().map(|turn| turn.from_rad).collect();
    leave(decision, &rad, Duration(0), rest);
}

/// What is left of a decision whose second step was never sent: a turn to the poses between, and a rest there.
pub(super) fn give_up_second(decision: &mut Decision) {
    if let Some(Via { rad, turning, rest }) = decision.via.take() {
        leave(decision, &rad, turning, rest);
    }
}

/// Makes it a turn to `rest_rad`, and a rest there.
fn leave(decision: &mut Decision, rest_rad: &[f64], turning: Duration, rest: Duration) {
    decision.via = None;
    (decision.transition, decision.period) = (turning, rest);
    for (turn, &rad) in decision.turns.iter_mut().zip(rest_rad) {
        turn.to_rad = rad;
    }
    let plan = &mut decision.plan;
    plan.outcome = Outcome::Held;
    plan.cycle = rest_rad.iter().map(|&rad| Swing { centerline_rad: rad, amplitude_rad: 0.0 }).collect();
    plan.wrench = Wrench::default();
    plan.error = if decision.demand == Wrench::default() { 0.0 } else { 1.0 };
    plan.transition = (turning.0 > 0).then(|| decision.turns.clone());
    plan.via_rad = None;
    plan.transition_s = f64::from(turning.as_secs_f32());
    plan.travel_rad = decision.turns.iter().map(|turn| turn.rotation_rad().abs()).sum();
}

/// What goes over the wire first: all of a decision, or the first of its two steps.
pub(super) fn first_cycles(decision: &Decision) -> Vec<Motion> {
    let Some(via) = &decision.via else { return cycles(decision) };
    let one = |(turn, &rad): (&Turn, &f64)| {
        Motion::Modboat(ModboatCycle {
            rotation: Radians((rad - turn.from_rad) as f32),
            centerline: Radians(rad as f32),
            amplitude: Radians(0.0),
            transition: via.turning,
            period: via.rest,
            law: law(decision.plan.step_times[0]),
        })
    };
    decision.turns.iter().zip(&via.rad).map(one).collect()
}

/// What goes over the wire for the last step of a decision, and its swim cycle.
pub(super) fn cycles(decision: &Decision) -> Vec<Motion> {
    let via = decision.via.as_ref();
    let step = decision.plan.step_times[usize::from(via.is_some())];
    let transition = Duration(decision.transition.0 - via.map_or(0, |via| via.length().0));
    let from_rad = |module: usize, turn: &Turn| via.map_or(turn.from_rad, |via| via.rad[module]);
    let one = |(module, (swing, turn)): (usize, (&Swing, &Turn))| {
        Motion::Modboat(ModboatCycle {
            rotation: Radians((turn.to_rad - from_rad(module, turn)) as f32),
            centerline: Radians(swing.centerline_rad as f32),
            amplitude: Radians(swing.amplitude_rad as f32),
            transition,
            period: decision.period,
            law: law(step),
        })
    };
    decision.plan.cycle.iter().zip(&decision.turns).enumerate().map(one).collect()
}

/// Where a module will rest when what it has is over, if that is known.
pub(super) fn pose_of<A: Copy>(
    phase: Phase,
    last: Option<&Decision>,
    index: usize,
    link: &ModuleLink<A>,
) -> Option<f64> {
    let report = link.telemetry()?;
    match last.filter(|_| phase.is_under_way()) {
        Some(Decision { number, via: Some(via), .. }) if phase == Phase::Turning && link.has(*number) => {
            Some(via.rad[index])
        }
        Some(decision) if link.has(decision.last_number()) => Some(decision.turns[index].to_rad),
        // It rests where it says, if it says so after the start of all that it may have taken.
        _ => (matches!(report.state, ModuleState::Ready | ModuleState::Holding) && link.is_up_to_date())
            .then(|| f64::from(report.tail.0)),
    }
}

/// Turns of a decision in which modules can still have stopped when the next one is planned.
#[derive(Debug, Default)]
pub(super) struct Remaining {
    turns: Vec<Turn>,
}

impl Remaining {
    /// What `last` leaves to the decision after it, by what the modules report. All that are not missing have reported that they run its
    /// last cycle, or `is_over`: they rest, and have said where. So a first step is behind them; and behind one that executes its swim
    /// is the turn.
    pub(super) fn of<'a, A: Copy>(
        &'a mut self,
        last: &'a Decision,
        links: &Dispatcher<A>,
        is_over: bool,
    ) -> Previous<'a> {
        self.turns.clear();
        let turns = links.modules().iter().zip(&last.turns).enumerate().map(|(index, (link, turn))| {
            let is_through = link.was_executing(last.last_number(), last.swim_start());
            let via_rad = last.via.as_ref().map_or(turn.from_rad, |via| via.rad[index]);
            Turn { from_rad: if is_through { turn.to_rad } else { via_rad }, to_rad: turn.to_rad }
        });
        self.turns.extend(turns);
        let turn = self.turns.iter().any(|turn| turn.rotation_rad() != 0.0);
        Previous {
            cycle: &last.plan.cycle,
            transition: turn.then_some(self.turns.as_slice()),
            via_rad: None,
            is_over,
        }
    }
}

/// A step of a decision for the modules that are not missing. A plan that is not loss tolerant goes to all of them or to none.
pub(super) fn dispatch(
    decision: &Decision,
    number: u32,
    start: FleetInstant,
    motions: Vec<Motion>,
) -> Dispatch {
    let present = motions.into_iter().zip(&decision.missing);
    let motions = present.map(|(motion, missing)| (!missing).then_some(motion)).collect();
    let delivery = if decision.plan.loss_tolerant { Delivery::Direct } else { Delivery::Prepare };
    Dispatch { number, start, motions, delivery }
}

/// Whether every module that is not missing certainly has cycle `number` of this decision.
pub(super) fn all_have<A: Copy>(links: &Dispatcher<A>, decision: &Decision, number: u32) -> bool {
    links.modules().iter().zip(&decision.missing).all(|(link, &missing)| missing || link.has(number))
}
