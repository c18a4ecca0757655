//! The host's side of the link: knows the modules, answers their clocks, sends each cycle ahead of its start and
//! again until it is acknowledged.
//!
//! A cycle of a Modboat is of use until it starts, the thrusts of an ROV until their lease ends; a newer cycle takes the
//! place of one that is still open.
//!
//! Sans-IO: datagrams and the time go in, datagrams come out of [`Dispatcher::poll_transmit`]. Host time is fleet
//! time. A module is known by its id; its address is wherever its last datagram came from.

use std::collections::VecDeque;

use protocol::units::{Micros, MicrosSpan};
use protocol::{
    Acknowledge, Cycle, DecodeError, Header, MAX_DATAGRAM, Message, ModuleId, Motion, Refusal, RovTelemetry,
    Telemetry, TimeReply, Verdict, decode, encode,
};

use super::ledger::Ledger;

/// Pause between two sends of one cycle. *Assumed*: some ten sends fit into the time a cycle is sent ahead.
pub const RESEND_EVERY: MicrosSpan = MicrosSpan(20_000);

/// What a datagram meant to the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A module spoke for the first time.
    Joined(usize),
    /// A module speaks with a new session: it lost its memory and no longer has any cycle.
    Rebooted(usize),
    /// A module took a cycle.
    Accepted {
        /// Which module (index).
        module: usize,
        /// Which cycle.
        cycle: u32,
    },
    /// A module refused a cycle.
    Refused {
        /// Which module (index).
        module: usize,
        /// Which cycle.
        cycle: u32,
        /// Why.
        reason: Refusal,
    },
    /// A module reported.
    Reported(usize),
}

/// A cycle on its way to a module.
#[derive(Clone, Debug)]
struct Pending {
    cycle: Cycle,
    next_send: Micros,
}

/// What the host knows of one module.
#[derive(Clone, Debug)]
pub struct ModuleLink<A> {
    id: ModuleId,
    address: Option<A>,
    session: Option<u32>,
    former_session: Option<u32>,
    last_sequence: u32,
    sequence: u32,
    pending: Option<Pending>,
    accepted: Option<u32>,
    telemetry: Option<Telemetry>,
    rov_telemetry: Option<RovTelemetry>,
    heard: Micros,
    boots: u32,
    ledger: Ledger,
}

impl<A> ModuleLink<A> {
    /// The module's id.
    pub fn id(&self) -> ModuleId {
        self.id
    }

    /// Whether it has ever spoken.
    pub fn is_known(&self) -> bool {
        self.session.is_some()
    }

    /// How often it was seen to boot.
    pub fn boots(&self) -> u32 {
        self.boots
    }

    /// When it was last heard, fleet time.
    pub fn heard(&self) -> Micros {
        self.heard
    }

    /// Its last report since its last boot, if it is an ROV.
    pub fn rov_telemetry(&self) -> Option<&RovTelemetry> {
        self.rov_telemetry.as_ref()
    }

    /// Its last report since its last boot, if it is a Modboat.
    pub fn telemetry(&self) -> Option<&Telemetry> {
        self.telemetry.as_ref()
    }

    /// Whether the module certainly has `cycle`: it acknowledged it, or reports that it runs or ran it.
    pub fn has(&self, cycle: u32) -> bool {
        self.accepted == Some(cycle)
            || self.telemetry.is_some_and(|telemetry| telemetry.cycle == cycle)
            || self.rov_telemetry.as_ref().is_some_and(|telemetry| telemetry.cycle == cycle)
    }

    /// Counts of its link.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Dispatcher<A> {
    session: u32,
    modules: Vec<ModuleLink<A>>,
    outbox: VecDeque<(A, Vec<u8>)>,
    damaged: u64,
    foreign: u64,
}

impl<A: Copy> Dispatcher<A> {
    /// For the modules 1 … `modules`; `session` tells this life of the host from its earlier ones.
    pub fn new(modules: u16, session: u32) -> Self {
        let link = |id| ModuleLink {
            id: ModuleId(id),
            address: None,
            session: None,
            former_session: None,
            last_sequence: 0,
            sequence: 0,
            pending: None,
            accepted: None,
            telemetry: None,
            rov_telemetry: None,
            heard: Micros(0),
            boots: 0,
            ledger: Ledger::default(),
        };
        let modules = (1..=modules).map(link).collect();
        Self { session, modules, outbox: VecDeque::new(), damaged: 0, foreign: 0 }
    }

    /// All modules, by index (id − 1).
    pub fn modules(&self) -> &[ModuleLink<A>] {
        &self.modules
    }

    /// Datagrams that did not decode.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Datagrams from modules that are not of this fleet.
    pub fn foreign(&self) -> u64 {
        self.foreign
    }

    /// Takes in one datagram. What does not decode is counted and otherwise ignored.
    ///
    /// # Errors
    /// [`DecodeError`], for those who want to show it; nothing needs to be done about it.
    pub fn handle_datagram(
        &mut self,
        now: Micros,
        from: A,
        datagram: &[u8],
    ) -> Result<Option<Event>, DecodeError> {
        let (header, message) = decode(datagram).inspect_err(|_| self.damaged += 1)?;
        let Some(index) = (header.module.0 as usize).checked_sub(1).filter(|&i| i < self.modules.len())
        else {
            self.foreign += 1;
            return Ok(None);
        };
        let link = &mut self.modules[index];
        if link.former_session == Some(header.session) {
            // From before its reboot, and late.
            link.ledger.stale += 1;
            return Ok(None);
        }
        let first_seen = match link.session {
            Some(session) if session == header.session => None,
            Some(_) => Some(Event::Rebooted(index)),
            None => Some(Event::Joined(index)),
        };
        if first_seen.is_some() {
            link.former_session = link.session.replace(header.session);
            link.last_sequence = header.sequence;
            link.boots += 1;
        }
        if matches!(first_seen, Some(Event::Rebooted(_))) {
            // Nothing said to its former life counts any more.
            (link.accepted, link.telemetry, link.rov_telemetry) = (None, None, None);
            link.close_pending();
        }
        link.ledger.datagrams_received += 1;
        link.address = Some(from);
        link.heard = now;
        let event = match message {
            Message::TimeRequest(request) => {
                let reply = TimeReply { request_sent: request.sent, received: now, sent: now };
                self.send(index, &Message::TimeReply(reply));
                None
            }
            Message::Acknowledge(acknowledge) => self.modules[index].acknowledged(index, acknowledge),
            // Reports may overtake each other; only the newest counts.
            Message::Telemetry(telemetry) if header.sequence >= link.last_sequence => {
                link.last_sequence = header.sequence;
                link.telemetry = Some(telemetry);
                Some(Event::Reported(index))
            }
            Message::RovTelemetry(telemetry) if header.sequence >= link.last_sequence => {
                link.last_sequence = header.sequence;
                link.rov_telemetry = Some(telemetry);
                Some(Event::Reported(index))
            }
            _ => None,
        };
        Ok(first_seen.or(event))
    }

    /// Queues what is due: cycles not acknowledged yet are sent again for as long as they are of use.
    pub fn handle_timer(&mut self, now: Micros) {
        for index in 0..self.modules.len() {
            let link = &mut self.modules[index];
            let Some(pending) = &mut link.pending else { continue };
            if useful_until(&pending.cycle) <= now {
                link.close_pending();
            } else if pending.next_send <= now {
                pending.next_send = now.after(RESEND_EVERY);
                let cycle = pending.cycle.clone();
                link.ledger.resent += 1;
                self.send(index, &Message::Cycle(cycle));
            }
        }
    }

    /// Sends every module its part of cycle `number`, in the order of the modules, and keeps at it. One that was
    /// dispatched before and is still open is given up.
    pub fn dispatch(&mut self, now: Micros, number: u32, start: Micros, motions: &[Motion]) {
        debug_assert_eq!(motions.len(), self.modules.len(), "one motion for each module");
        for (index, motion) in motions.iter().enumerate() {
            let cycle = Cycle { number, start, motion: motion.clone() };
            let link = &mut self.modules[index];
            link.close_pending();
            link.ledger.cycles += 1;
            link.pending = Some(Pending { cycle: cycle.clone(), next_send: now.after(RESEND_EVERY) });
            self.send(index, &Message::Cycle(cycle));
        }
    }

    /// Tells everybody to finish the running cycle and hold.
    pub fn hold(&mut self) {
        self.broadcast(&Message::Hold);
    }

    /// Tells everybody to freeze at once.
    pub fn emergency_stop(&mut self) {
        self.broadcast(&Message::EmergencyStop);
    }

    fn broadcast(&mut self, message: &Message) {
        for index in 0..self.modules.len() {
            self.modules[index].close_pending();
            self.send(index, message);
        }
    }

    /// The next datagram to send, if any, and where to.
    pub fn poll_transmit(&mut self) -> Option<(A, Vec<u8>)> {
        self.outbox.pop_front()
    }

    fn send(&mut self, index: usize, message: &Message) {
        let link = &mut self.modules[index];
        // Nobody knows yet where this module is; the next send will find it.
        let Some(address) = link.address else { return };
        let header = Header { module: link.id, session: self.session, sequence: link.sequence };
        link.sequence = link.sequence.wrapping_add(1);
        let mut buffer = [0; MAX_DATAGRAM];
        if let Ok(datagram) = encode(&header, message, &mut buffer) {
            link.ledger.datagrams_sent += 1;
            self.outbox.push_back((address, datagram.to_vec()));
        }
    }
}

/// When it makes no difference any more whether the cycle arrives.
fn useful_until(cycle: &Cycle) -> Micros {
    match &cycle.motion {
        Motion::Modboat(_) => cycle.start,
        Motion::Rov(thrusts) => cycle.start.after(thrusts.lease),
    }
}

impl<A> ModuleLink<A> {
    fn acknowledged(&mut self, index: usize, acknowledge: Acknowledge) -> Option<Event> {
        let cycle = acknowledge.cycle;
        if self.pending.as_ref().is_none_or(|pending| pending.cycle.number != cycle) {
            return None;
        }
        self.pending = None;
        Some(match acknowledge.verdict {
            Verdict::Accepted | Verdict::Duplicate => {
                self.ledger.acknowledged += 1;
                self.accepted = Some(cycle);
                Event::Accepted { module: index, cycle }
            }
            Verdict::Refused(reason) => {
                self.ledger.refused += 1;
                Event::Refused { module: index, cycle, reason }
            }
        })
    }

    fn close_pending(&mut self) {
        if self.pending.take().is_some() {
            self.ledger.unanswered += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use protocol::units::{Amperes, Newtons, PulseMicros, Radians, RadiansPerSecond, Volts};
    use protocol::{Hello, ModboatCycle, ModuleKind, ModuleState, RovCycle};

    use super::*;

    const CYCLE: Motion = Motion::Modboat(ModboatCycle {
        rotation: Radians(0.5),
        centerline: Radians(0.0),
        amplitude: Radians(1.0),
        transition: MicrosSpan(500_000),
        period: MicrosSpan(1_500_000),
    });

    fn from_module(id: u16, session: u32, sequence: u32, message: Message) -> Vec<u8> {
        let mut buffer = [0; MAX_DATAGRAM];
        encode(&Header { module: ModuleId(id), session, sequence }, &message, &mut buffer).unwrap().to_vec()
    }

    fn hello() -> Message {
        Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: (0, 1, 0) })
    }

    fn sent(dispatcher: &mut Dispatcher<char>) -> Vec<(char, Message)> {
        std::iter::from_fn(|| dispatcher.poll_transmit())
            .map(|(to, datagram)| (to, decode(&datagram).unwrap().1))
            .collect()
    }

    #[test]
    fn a_cycle_goes_out_again_until_acknowledged() {
        let mut dispatcher = Dispatcher::new(2, 5);
        let event = dispatcher.handle_datagram(Micros(0), 'a', &from_module(1, 9, 0, hello()));
        assert_eq!(event, Ok(Some(Event::Joined(0))));
        dispatcher.dispatch(Micros(0), 1, Micros(100_000), &[CYCLE, CYCLE]);
        assert_eq!(sent(&mut dispatcher).len(), 1, "module 2 has no address yet");
        dispatcher.handle_timer(Micros(19_999));
        assert!(sent(&mut dispatcher).is_empty());
        dispatcher.handle_datagram(Micros(19_999), 'b', &from_module(2, 3, 0, hello())).unwrap();
        dispatcher.handle_timer(Micros(20_000));
        assert_eq!(sent(&mut dispatcher).iter().map(|(to, _)| *to).collect::<String>(), "ab");
        let accepted = Message::Acknowledge(Acknowledge { cycle: 1, verdict: Verdict::Accepted });
        let event = dispatcher.handle_datagram(Micros(30_000), 'a', &from_module(1, 9, 1, accepted));
        assert_eq!(event, Ok(Some(Event::Accepted { module: 0, cycle: 1 })));
        dispatcher.handle_timer(Micros(40_000));
        assert_eq!(sent(&mut dispatcher).iter().map(|(to, _)| *to).collect::<String>(), "b");
        dispatcher.handle_timer(Micros(100_000));
        assert!(sent(&mut dispatcher).is_empty(), "the cycle has started");
        let [one, two] = [0, 1].map(|index| *dispatcher.modules()[index].ledger());
        assert_eq!((one.cycles, one.acknowledged, one.unanswered, one.open()), (1, 1, 0, 0));
        assert_eq!((two.cycles, two.acknowledged, two.unanswered, two.open()), (1, 0, 1, 0));
        assert!(dispatcher.modules()[0].has(1) && !dispatcher.modules()[1].has(1));
    }

    #[test]
    fn a_reboot_forgets_what_was_accepted() {
        let mut dispatcher = Dispatcher::new(1, 5);
        dispatcher.handle_datagram(Micros(0), 'a', &from_module(1, 9, 0, hello())).unwrap();
        dispatcher.dispatch(Micros(0), 1, Micros(100_000), &[CYCLE]);
        let accepted = Message::Acknowledge(Acknowledge { cycle: 1, verdict: Verdict::Accepted });
        dispatcher.handle_datagram(Micros(1), 'a', &from_module(1, 9, 1, accepted)).unwrap();
        assert!(dispatcher.modules()[0].has(1));
        let event = dispatcher.handle_datagram(Micros(2), 'a', &from_module(1, 10, 0, hello()));
        assert_eq!(event, Ok(Some(Event::Rebooted(0))));
        assert!(!dispatcher.modules()[0].has(1));
        assert_eq!(dispatcher.modules()[0].boots(), 2);
    }

    #[test]
    fn what_a_module_said_before_its_reboot_does_not_count_as_another() {
        let mut dispatcher = Dispatcher::new(1, 5);
        dispatcher.handle_datagram(Micros(0), 'a', &from_module(1, 9, 0, hello())).unwrap();
        dispatcher.handle_datagram(Micros(1), 'a', &from_module(1, 10, 0, hello())).unwrap();
        assert_eq!(dispatcher.handle_datagram(Micros(2), 'a', &from_module(1, 9, 1, hello())), Ok(None));
        assert_eq!(dispatcher.modules()[0].boots(), 2);
        assert_eq!(dispatcher.modules()[0].ledger().stale, 1);
    }

    #[test]
    fn an_older_report_does_not_replace_a_newer_one() {
        let mut dispatcher = Dispatcher::new(1, 5);
        let report = |cycle| {
            Message::Telemetry(Telemetry {
                at: Micros(0),
                state: ModuleState::Executing,
                cycle,
                tail: Radians(0.0),
                rate: RadiansPerSecond(0.0),
                current: Amperes(0.0),
                battery: Volts(7.4),
            })
        };
        dispatcher.handle_datagram(Micros(0), 'a', &from_module(1, 9, 0, hello())).unwrap();
        dispatcher.handle_datagram(Micros(1), 'a', &from_module(1, 9, 7, report(2))).unwrap();
        dispatcher.handle_datagram(Micros(2), 'a', &from_module(1, 9, 6, report(1))).unwrap();
        assert_eq!(dispatcher.modules()[0].telemetry().unwrap().cycle, 2);
    }

    #[test]
    fn thrusts_twenty_times_a_second_are_each_accounted_for() {
        let mut dispatcher = Dispatcher::new(1, 5);
        dispatcher.handle_datagram(Micros(0), 'a', &from_module(1, 9, 0, hello())).unwrap();
        let thrusts = [Newtons(4.0)].into_iter().collect();
        let motion = Motion::Rov(RovCycle { thrusts, lease: MicrosSpan(200_000) });
        let accepted = |cycle| Message::Acknowledge(Acknowledge { cycle, verdict: Verdict::Accepted });
        let numbers = |dispatcher: &mut Dispatcher<char>| -> Vec<u32> {
            let numbers = sent(dispatcher).into_iter().map(|(_, message)| match message {
                Message::Cycle(cycle) => cycle.number,
                other => panic!("{other:?}"),
            });
            numbers.collect()
        };
        // 1 is answered; 2 is still open when 3 takes its place, and its late answer is not 3's.
        for (k, start) in [(1, 30_000), (2, 80_000), (3, 130_000)] {
            let now = Micros(start - 30_000);
            dispatcher.dispatch(now, k, Micros(start), std::slice::from_ref(&motion));
            assert_eq!(numbers(&mut dispatcher), [k]);
            dispatcher.handle_timer(Micros(start - 10_000));
            assert_eq!(numbers(&mut dispatcher), [k], "again");
            if k == 1 {
                let answer = from_module(1, 9, k, accepted(k));
                let event = dispatcher.handle_datagram(Micros(25_000), 'a', &answer);
                assert_eq!(event, Ok(Some(Event::Accepted { module: 0, cycle: 1 })));
            }
        }
        let event = dispatcher.handle_datagram(Micros(120_000), 'a', &from_module(1, 9, 2, accepted(2)));
        assert_eq!(event, Ok(None));
        // It goes on past its start, until its lease is over.
        dispatcher.handle_timer(Micros(329_999));
        assert_eq!(numbers(&mut dispatcher), [3]);
        dispatcher.handle_timer(Micros(330_000));
        assert_eq!(numbers(&mut dispatcher), [0; 0]);
        let ledger = *dispatcher.modules()[0].ledger();
        assert_eq!((ledger.cycles, ledger.acknowledged, ledger.unanswered, ledger.open()), (3, 1, 2, 0));
        assert_eq!(ledger.resent, 4);
        // What it reports counts as an answer as far as having it goes.
        let report = Message::RovTelemetry(RovTelemetry {
            at: Micros(200_000),
            state: ModuleState::Executing,
            cycle: 3,
            pulses: [PulseMicros(1580.0)].into_iter().collect(),
            battery: Volts(16.0),
            current: Amperes(1.0),
        });
        assert!(!dispatcher.modules()[0].has(3));
        let event = dispatcher.handle_datagram(Micros(201_000), 'a', &from_module(1, 9, 3, report));
        assert_eq!(event, Ok(Some(Event::Reported(0))));
        let link = &dispatcher.modules()[0];
        assert!(link.has(3) && link.telemetry().is_none());
        assert_eq!(link.rov_telemetry().map(|report| report.pulses.len()), Some(1));
    }

    #[test]
    fn clocks_are_answered_and_strangers_counted() {
        let mut dispatcher = Dispatcher::new(1, 5);
        let request = Message::TimeRequest(protocol::TimeRequest { sent: Micros(77) });
        dispatcher.handle_datagram(Micros(1_000), 'a', &from_module(1, 9, 0, request.clone())).unwrap();
        let reply = TimeReply { request_sent: Micros(77), received: Micros(1_000), sent: Micros(1_000) };
        assert_eq!(sent(&mut dispatcher), [('a', Message::TimeReply(reply))]);
        assert_eq!(dispatcher.handle_datagram(Micros(0), 'x', &from_module(2, 9, 0, request)), Ok(None));
        assert!(dispatcher.handle_datagram(Micros(0), 'x', b"noise").is_err());
        assert_eq!((dispatcher.foreign(), dispatcher.damaged()), (1, 1));
    }
}
