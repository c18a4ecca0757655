//! The host's side: what it knows of each module, what it sends, and when it plans.
//!
//! | here | mirrors, in `host` |
//! |---|---|
//! | [`DeliveryState`], [`PhaseOutcome`], [`Knowledge`] | the real ones of `link/delivery.rs` |
//! | [`Host::offers`], [`Host::offer`], [`Host::join`] | `link/member.rs` `announced`, `offer`, `join`; `link/dispatcher.rs` `handle_datagram` |
//! | [`Host::acknowledged`] | `link/dispatcher.rs` `acknowledged` |
//! | [`Host::reported`] | `link/member.rs` `note_report` |
//! | [`Host::settle`], [`Host::slot_begins`] | `link/dispatcher.rs` `handle_timer`, `decide`; `run/pilot.rs` `forget_if_dropped` |
//! | [`Host::knowledge`], `Host::is_up_to_date` | `link/member.rs`, the same names |
//! | [`Host::decide`] | `run/pilot.rs` `handle_timer`, `decide`, `pose_of`, `swimming_over_if_unknown`; `link/dispatcher.rs` `dispatch` |
//! | [`Host::hold`], [`Host::order`] | `link/dispatcher.rs` `hold`, `order` |

use link::delivery::{DeliveryState, Knowledge, PhaseOutcome};
use protocol::{Delivery, ModuleState, Refusal, Verdict};

use crate::fleet::{Broken, Config};
use crate::said::{Ack, Answer, Held, MODULES, Pose, Report, Say, SessionId, Up, life_of};

/// Messages to be sent, each with the index of its module.
pub type Outgoing = Vec<(usize, Say)>;

/// The cycle that all modules were sent last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DispatchedCycle {
    /// As [`Held::number`].
    pub number: u8,
    /// As [`Held::id`].
    pub id: u8,
    /// As [`Held::start`].
    pub start: u8,
    /// As [`Held::delivery`].
    pub delivery: Delivery,
    /// As [`Held::from`], of each.
    pub from: [Pose; MODULES],
}

/// The host's knowledge of one module.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Link {
    /// The session in force.
    pub live: Option<SessionId>,
    /// Sessions on offer.
    pub calling: Vec<SessionId>,
    /// Orders said in the session in force.
    sent: u8,
    /// What the module said in it and may still come.
    pub up: Up,
    /// The number it took.
    accepted: u8,
    /// Its newest report.
    pub report: Option<Report>,
    /// How far the delivery of the cycle has got, and whether nothing more is sent for it.
    standing: Option<(DeliveryState, bool)>,
}

impl Link {
    /// The number of what is said to it next.
    pub fn next_sequence(&mut self) -> u8 {
        self.sent += 1;
        self.sent
    }

    fn standing(&self) -> Option<DeliveryState> {
        self.standing.map(|(standing, _)| standing)
    }

    fn is_open(&self) -> bool {
        self.standing.is_some_and(|(standing, closed)| !closed && standing.is_open())
    }

    fn abandon(&mut self, standing: Option<DeliveryState>) {
        if self.is_open() {
            self.standing = standing.or(self.standing()).map(|standing| (standing, true));
        }
    }
}

/// State of the host.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Host {
    /// Number of its boot, from 1.
    pub life: u8,
    /// Last number given away, as sent and as it is.
    number: (u8, u8),
    /// The last decision is on its way or being executed.
    swimming: bool,
    /// When to plan again after that was given up.
    retry: u8,
    /// What was sent last.
    pub cycle: Option<DispatchedCycle>,
    /// What is known of each module.
    pub links: [Link; MODULES],
    /// A stop or its release in force.
    ordered: Option<bool>,
}

impl Host {
    /// That has just started.
    #[must_use]
    pub fn new(life: u8) -> Self {
        let number = (0, 8 * (life - 1));
        let links = <[Link; MODULES]>::default();
        Self { life, number, swimming: false, retry: 0, cycle: None, links, ordered: None }
    }

    /// The session that would be offered to a module which announces `nonce` and that it is in `session`.
    #[must_use]
    pub fn offers(&self, index: usize, nonce: (u8, u8), session: Option<SessionId>) -> Option<SessionId> {
        let link = &self.links[index];
        let (boot, count) = nonce;
        let offer = SessionId { boot, count, life: self.life };
        let known = session.is_some() && link.live == session;
        let used_up = link.live.is_some_and(|live| (live.boot, live.count) == nonce);
        (!known && !used_up && !link.calling.contains(&offer)).then_some(offer)
    }

    /// Offers it.
    pub fn offer(&mut self, index: usize, session: SessionId) {
        self.links[index].calling.push(session);
    }

    /// A datagram of a session on offer has come, from a module that has said `up` in it.
    pub fn join(&mut self, config: &Config, now: u8, index: usize, session: SessionId, up: Up) -> Outgoing {
        let link = &mut self.links[index];
        let rebooted = link.live.is_some_and(|former| former.boot != session.boot);
        link.live = Some(session);
        link.calling.clear();
        (link.accepted, link.report, link.sent, link.up) = (0, None, 0, up);
        if rebooted {
            link.abandon(Some(DeliveryState::Dropped));
        }
        let mut outgoing = Outgoing::new();
        if link.is_open()
            && let Some(cycle) = self.cycle
        {
            match link.standing() {
                Some(DeliveryState::Unsent | DeliveryState::Sent) => {
                    link.standing = Some((DeliveryState::Sent, false));
                    outgoing.push((index, part(cycle, index)));
                }
                Some(DeliveryState::Committing) => outgoing.push((index, Say::Commit(cycle.number))),
                _ => {}
            }
        }
        outgoing.extend(self.ordered.map(|stop| (index, self.order_to(index, stop))));
        outgoing.extend(self.settle(config, now, true));
        outgoing
    }

    /// An acknowledgement has come in the session in force.
    pub fn acknowledged(&mut self, config: &Config, now: u8, index: usize, ack: Ack) -> Outgoing {
        let Some(cycle) = self.cycle.filter(|cycle| cycle.number == ack.number) else {
            return Outgoing::new();
        };
        let link = &mut self.links[index];
        let verdict = match ack.answer {
            Answer::Taken => Verdict::Accepted,
            Answer::Prepared => Verdict::Prepared,
            Answer::Refused => Verdict::Refused(Refusal::Unsure),
        };
        let Some((standing, closed)) = link.standing else { return Outgoing::new() };
        let Some(standing) = standing.answered(verdict) else { return Outgoing::new() };
        link.standing = Some((standing, closed || !standing.is_open()));
        if standing == DeliveryState::Taken {
            link.accepted = cycle.number;
        }
        self.settle(config, now, true)
    }

    /// A report has come in the session in force, newer than the one before.
    pub fn reported(&mut self, index: usize, report: Report) {
        self.links[index].report = Some(report);
    }

    /// Whether a prepared cycle waits for all to answer.
    #[must_use]
    pub fn is_undecided(&self) -> bool {
        let prepare = self.cycle.is_some_and(|cycle| cycle.delivery == Delivery::Prepare);
        let decided = [DeliveryState::Committing, DeliveryState::Taken];
        let all = || self.links.iter();
        prepare
            && all().any(Link::is_open)
            && !all().any(|link| link.standing().is_some_and(|standing| decided.contains(&standing)))
    }

    /// Commits what every module holds or gives it up. `in_time`: a commit can still be repeated before the start.
    pub fn settle(&mut self, config: &Config, now: u8, in_time: bool) -> Outgoing {
        let mut outgoing = Outgoing::new();
        let Some(cycle) = self.cycle else { return outgoing };
        if cycle.delivery == Delivery::Prepare && self.links.iter().any(Link::is_open) {
            let all = || self.links.iter().filter_map(Link::standing);
            let mut outcome = DeliveryState::decide(all(), in_time);
            if config.broken == Some(Broken::DropAfterCommit) && all().any(DeliveryState::is_never_run) {
                outcome = PhaseOutcome::Drop;
            }
            if config.broken == Some(Broken::HastyCommit)
                && outcome == PhaseOutcome::Wait
                && all().any(|standing| standing == DeliveryState::Prepared)
            {
                outcome = PhaseOutcome::Commit;
            }
            match outcome {
                PhaseOutcome::Wait => {}
                PhaseOutcome::Commit => {
                    for (index, link) in self.links.iter_mut().enumerate() {
                        link.standing = Some((DeliveryState::Committing, false));
                        outgoing.push((index, Say::Commit(cycle.number)));
                    }
                }
                PhaseOutcome::Drop => {
                    self.links.iter_mut().for_each(|link| link.abandon(Some(DeliveryState::Dropped)));
                }
            }
        }
        self.forget_if_dropped(config, now, cycle);
        outgoing
    }

    fn forget_if_dropped(&mut self, config: &Config, now: u8, cycle: DispatchedCycle) {
        let all = || self.links.iter().filter_map(Link::standing);
        let dropped = cycle.delivery == Delivery::Prepare
            && all().any(|standing| matches!(standing, DeliveryState::Dropped | DeliveryState::Refused))
            && !all().any(|standing| matches!(standing, DeliveryState::Committing | DeliveryState::Taken));
        if self.swimming && now < cycle.start && dropped {
            (self.swimming, self.retry) = (false, cycle.start);
            if config.broken == Some(Broken::ReusedNumber) {
                self.number.0 -= 1;
            }
        }
    }

    /// What has started needs nothing more.
    pub fn slot_begins(&mut self, now: u8) {
        if self.cycle.is_some_and(|cycle| cycle.start <= now) {
            self.links.iter_mut().for_each(|link| link.abandon(None));
        }
    }

    /// What is known of the cycle, of one module.
    #[must_use]
    pub fn knowledge(&self, config: &Config, index: usize) -> Knowledge {
        let (Some(cycle), link) = (self.cycle, &self.links[index]) else { return Knowledge::Possibly };
        if config.broken == Some(Broken::AcceptanceIsProof) && link.accepted == cycle.number {
            return Knowledge::Certainly;
        }
        let says = |report: Report| {
            (report.latest == cycle.number || report.at >= cycle.start)
                .then_some(report.latest == cycle.number)
        };
        link.standing().map_or(Knowledge::Possibly, |standing| standing.knowledge(link.report.and_then(says)))
    }

    /// Whether a module's report is from after the start of all that it may run.
    fn is_up_to_date(&self, index: usize) -> bool {
        let link = &self.links[index];
        let at = link.report.map_or(0, |report| report.at);
        let never_run = link.standing().is_none_or(DeliveryState::is_never_run);
        never_run || self.cycle.is_none_or(|cycle| at >= cycle.start)
    }

    /// Where a module will rest.
    fn pose_of(&self, config: &Config, index: usize) -> Option<Pose> {
        let report = self.links[index].report?;
        if self.swimming && self.knowledge(config, index) == Knowledge::Certainly {
            return self.cycle.map(|cycle| Pose(cycle.id));
        }
        let rests = matches!(report.state, ModuleState::Ready | ModuleState::Holding);
        (rests && self.is_up_to_date(index)).then_some(report.tail)
    }

    /// Whether it plans in slot `now`.
    #[must_use]
    pub fn may_decide(&self, now: u8) -> bool {
        let begun = self.cycle.is_some_and(|cycle| cycle.start <= now);
        let room = life_of(self.number.1 + 1) == self.life;
        room && if self.swimming { begun } else { now >= self.retry }
    }

    /// Plans the cycle that starts with the next slot, if it knows where all tails will be.
    pub fn decide(&mut self, config: &Config, now: u8, delivery: Delivery) -> Outgoing {
        let certain = |index| self.knowledge(config, index) == Knowledge::Certainly;
        self.swimming &= (0..MODULES).all(certain);
        let poses: Option<Vec<Pose>> = (0..MODULES).map(|index| self.pose_of(config, index)).collect();
        let from = poses.and_then(|poses| <[Pose; MODULES]>::try_from(poses).ok());
        let Some(from) = from else {
            self.swimming = false;
            return Outgoing::new();
        };
        self.swimming = true;
        self.number = (self.number.0 + 1, self.number.1 + 1);
        let (number, id) = self.number;
        let cycle = DispatchedCycle { number, id, start: now + 1, delivery, from };
        self.cycle = Some(cycle);
        let mut outgoing = Outgoing::new();
        for (index, link) in self.links.iter_mut().enumerate() {
            let known = link.live.is_some();
            link.standing = Some((if known { DeliveryState::Sent } else { DeliveryState::Unsent }, false));
            if known {
                outgoing.push((index, part(cycle, index)));
            }
        }
        outgoing
    }

    /// Tells all modules to hold.
    pub fn hold(&mut self) -> Outgoing {
        self.links.iter_mut().for_each(|link| link.abandon(None));
        self.to_all(Say::Hold)
    }

    /// Tells all modules to stop, or no longer to.
    pub fn order(&mut self, stop: bool) -> Outgoing {
        self.links.iter_mut().for_each(|link| link.abandon(None));
        self.ordered = Some(stop);
        let live = (0..MODULES).filter(|&index| self.links[index].live.is_some());
        live.map(|index| (index, self.order_to(index, stop))).collect()
    }

    /// The sender fills in when a release was sent.
    fn order_to(&self, index: usize, stop: bool) -> Say {
        let seen = self.links[index].report.map_or(0, |report| report.stops);
        if stop { Say::Stop } else { Say::Release { seen, sent_at: 0 } }
    }

    fn to_all(&self, say: Say) -> Outgoing {
        (0..MODULES).filter(|&index| self.links[index].live.is_some()).map(|index| (index, say)).collect()
    }

    /// Everything that is repeated until it is answered.
    #[must_use]
    pub fn repeats(&self) -> Outgoing {
        let mut outgoing = Outgoing::new();
        for (index, link) in self.links.iter().enumerate().filter(|(_, link)| link.live.is_some()) {
            let cycle = self.cycle.filter(|_| link.is_open());
            match (cycle, link.standing()) {
                (Some(cycle), Some(DeliveryState::Sent)) => outgoing.push((index, part(cycle, index))),
                (Some(cycle), Some(DeliveryState::Committing)) => {
                    outgoing.push((index, Say::Commit(cycle.number)));
                }
                _ => {}
            }
            outgoing.extend(self.ordered.map(|stop| (index, self.order_to(index, stop))));
        }
        outgoing
    }

    /// The number whose answers are still of interest.
    #[must_use]
    pub fn asks(&self) -> Option<u8> {
        self.cycle.map(|cycle| cycle.number)
    }

    /// Whether it has given up the cycle, as far as one module goes.
    #[must_use]
    pub fn has_dropped(&self, index: usize) -> bool {
        self.links[index].standing() == Some(DeliveryState::Dropped)
    }

    /// What it stops, or no longer stops, until now.
    #[must_use]
    pub const fn ordered(&self) -> Option<bool> {
        self.ordered
    }

    /// The same with the modules in the other order.
    pub fn swap(&mut self) {
        self.links.reverse();
        if let Some(cycle) = &mut self.cycle {
            cycle.from.reverse();
        }
    }
}

/// One module's part. The sender fills in the boot.
fn part(cycle: DispatchedCycle, index: usize) -> Say {
    let DispatchedCycle { number, id, start, delivery, from } = cycle;
    let (own, other) = (from[index], from[MODULES - 1 - index]);
    Say::Cycle(Held { number, id, start, delivery, from: own, beside: other, boot: 0 })
}
