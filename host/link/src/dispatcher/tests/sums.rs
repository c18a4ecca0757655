//! The ledgers in a storm: exact at every instant, and in the end in line with what the medium did.

use protocol::{Kind, MAX_DATAGRAM, Radio};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::super::super::faults::{FaultCount, FaultParameters, Faulty};
use super::super::super::loopback::{Ether, LoopbackRadio, Node};
use super::super::*;
use super::played::*;

const STEP: Duration = Duration(5_000);
const STEPS: u64 = 8_000;
/// Cycles come so often, in steps, and start so much later.
const CYCLE_EVERY: u64 = 100;
const AHEAD: Duration = Duration(300_000);

const WEATHER: FaultParameters = FaultParameters {
    loss: 0.15,
    burst: 0.02,
    burst_s: 0.2,
    duplication: 0.15,
    corruption: 0.03,
    truncation: 0.01,
    delay_s: 0.002,
    jitter_s: 0.03,
    reordering: 0.05,
    reorder_s: 0.1,
    late: 0.02,
    late_s: 1.0,
    replay: 0.05,
    replay_s: 1.0,
    forgery: 0.05,
};

type Medium = Faulty<LoopbackRadio>;

/// What the test itself has counted of one module.
#[derive(Debug, Default)]
struct Tally {
    /// Datagrams that the host gave to its radio.
    from_host: u64,
    /// Those that the module let in, and those of them that it called late.
    let_in: u64,
    late: u64,
    /// Datagrams of sessions that the module gave to its radio, and that the host let in.
    from_module: u64,
    host_let_in: u64,
    incoming: Incoming,
}

struct Storm {
    dispatcher: Dispatcher<Node>,
    host: Medium,
    host_received: u64,
    modules: Vec<(Played, Medium, Tally)>,
    rng: ChaCha8Rng,
    now: FleetInstant,
    number: u32,
}

impl Storm {
    fn new(seed: u64, weather: FaultParameters) -> Self {
        let ether = Ether::default();
        let ids = [1, 2, 3].map(ModuleId);
        let module = |id: ModuleId| {
            let radio = Faulty::new(ether.radio(Node(id.0)), weather, seed * 100 + u64::from(id.0));
            (Played::new(&KEY, id), radio, Tally::default())
        };
        Self {
            dispatcher: Dispatcher::new(&ids, &KEY, HOST),
            host: Faulty::new(ether.radio(Node(0)), weather, seed * 100),
            host_received: 0,
            modules: ids.into_iter().map(module).collect(),
            rng: ChaCha8Rng::seed_from_u64(seed),
            now: FleetInstant(0),
            number: 0,
        }
    }

    fn host_hears(&mut self) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Ok(Some((length, from))) = self.host.receive(self.now, &mut buffer) {
            self.host_received += 1;
            let heard = self.dispatcher.handle_datagram(self.now, from, &buffer[..length]);
            if heard.is_ok()
                && let Ok(frame) = Frame::parse(&buffer[..length])
                && frame.header.kind == Kind::ToHost
            {
                self.modules[usize::from(frame.header.module.0) - 1].2.host_let_in += 1;
            }
        }
    }

    fn host_speaks(&mut self) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((to, datagram)) = self.dispatcher.poll_transmit(self.now, &mut buffer) {
            let id = Frame::parse(datagram).expect("well made").header.module;
            self.modules[usize::from(id.0) - 1].2.from_host += 1;
            self.host.send(self.now, to, datagram).expect("a loopback");
        }
    }

    /// A module hears what there is and answers it; says what is due.
    fn module(&mut self, index: usize, due: &[Message]) {
        let (module, radio, tally) = &mut self.modules[index];
        let mut say: Vec<Message> = due.to_vec();
        let mut buffer = [0; MAX_DATAGRAM];
        while let Ok(Some((length, _))) = radio.receive(self.now, &mut buffer) {
            let heard = module.handle_datagram(&buffer[..length]);
            tally.incoming.count(heard.as_ref().err().copied().unwrap_or(Class::Accepted));
            let Ok(opened) = heard else { continue };
            tally.let_in += 1;
            let late = |start: FleetInstant| start <= self.now;
            let verdict = match &opened.message {
                Message::Cycle(cycle) if late(cycle.start) => Verdict::Refused(Refusal::Late),
                Message::Cycle(_) if self.rng.random_bool(0.02) => Verdict::Refused(Refusal::Unsure),
                Message::Cycle(cycle) if cycle.delivery == Delivery::Prepare => Verdict::Prepared,
                Message::Cycle(_) | Message::Commit(_) => Verdict::Accepted,
                _ => continue,
            };
            if verdict == Verdict::Refused(Refusal::Late) {
                module.session.as_mut().expect("it came through it").came_late();
                tally.late += 1;
            }
            let (Message::Cycle(Cycle { number, .. }) | Message::Commit(number)) = opened.message else {
                continue;
            };
            say.push(answer(number, verdict));
        }
        if module.session.is_none() {
            return;
        }
        for message in &say {
            tally.from_module += 1;
            radio.send(self.now, Node(0), &module.say(message)).expect("a loopback");
        }
    }

    fn announce(&mut self, index: usize) {
        let (module, radio, _) = &mut self.modules[index];
        radio.send(self.now, Node(0), &module.announce()).expect("a loopback");
    }

    fn step(&mut self, step: u64) {
        self.now = self.now.after(STEP);
        self.host_hears();
        if step % CYCLE_EVERY == 20 {
            self.number += 1;
            let delivery = if self.number.is_multiple_of(2) { Delivery::Prepare } else { Delivery::Direct };
            let (start, motions) = (self.now.after(AHEAD), [const { Some(SWIM) }; 3]);
            self.dispatcher.dispatch(self.now, self.number, start, &motions, delivery);
        }
        self.dispatcher.handle_timer(self.now);
        self.host_speaks();
        for index in 0..3 {
            let seeking = self.modules[index].0.session.is_none();
            if step.is_multiple_of(if seeking { 40 } else { 200 }) {
                self.announce(index);
            }
            let report = report(self.now.0, 0, ModuleState::Executing);
            self.module(index, if step.is_multiple_of(10) { std::slice::from_ref(&report) } else { &[] });
        }
        // The third boots now and then.
        if step % 2_500 == 2_499 {
            self.modules[2].0.reboot();
        }
        self.check();
    }

    /// What holds at every instant.
    fn check(&self) {
        for (link, (module, _, tally)) in self.dispatcher.modules().iter().zip(&self.modules) {
            let (ledger, incoming, outgoing) = (link.ledger(), link.incoming(), link.outgoing());
            let open = u64::from(link.delivery.as_ref().is_some_and(CycleDelivery::is_open));
            let decided = ledger.acknowledged + ledger.late + ledger.refused + ledger.unanswered;
            assert_eq!((ledger.cycles, ledger.open()), (decided + open, open), "{:?}: {ledger:?}", self.now);
            assert!(incoming.is_exact() && tally.incoming.is_exact(), "{:?}: {incoming:?}", self.now);
            assert_eq!(outgoing.sent, tally.from_host, "{:?}", self.now);
            let told = outgoing.acknowledged + outgoing.late + outgoing.lost;
            assert_eq!(outgoing.sent, told + outgoing.under_way(), "{:?}: {outgoing:?}", self.now);
            // No more is reported than there was.
            assert!(outgoing.acknowledged + outgoing.late <= tally.let_in, "{outgoing:?}, {tally:?}");
            assert!(outgoing.late <= tally.late, "{outgoing:?}, {tally:?}");
            if let Some(session) = &module.session {
                let back = session.outgoing();
                assert!(back.acknowledged + back.late <= tally.host_let_in, "{back:?}, {tally:?}");
                assert_eq!(back.sent, back.acknowledged + back.late + back.lost + back.under_way());
            }
        }
        assert!(self.dispatcher.strays().is_exact());
    }

    /// What the medium says came out of it, and what all receivers say came in.
    fn check_received(&self) {
        let mediums = self.modules.iter().map(|(_, radio, _)| radio.count()).chain([self.host.count()]);
        let medium = mediums.fold(FaultCount::default(), |sum, count| sum + count);
        assert!(medium.is_balanced() && medium.under_way == 0, "{medium:?}");
        let by_modules: u64 = self.modules.iter().map(|(.., tally)| u64::from(tally.incoming.received)).sum();
        assert_eq!(medium.delivered, self.host_received + by_modules);
        let links = self.dispatcher.modules().iter().map(ModuleLink::incoming);
        let counted: u64 = links.chain([self.dispatcher.strays()]).map(|i| u64::from(i.received)).sum();
        assert_eq!(counted, self.host_received);
        let sealed: u64 = self.modules.iter().map(|(.., tally)| tally.from_host).sum();
        assert_eq!(self.host.count().sent, sealed);
    }
}

#[test]
fn every_datagram_and_every_cycle_is_accounted_for_in_a_storm() {
    for seed in 1..=3 {
        let mut storm = Storm::new(seed, WEATHER);
        (0..STEPS).for_each(|step| storm.step(step));
        // Calm, and one word each way and back.
        storm.host.heal(true);
        storm.modules.iter_mut().for_each(|(_, radio, _)| radio.heal(true));
        for _ in 0..2 {
            (0..3).for_each(|index| storm.module(index, &[health()]));
            storm.host_hears();
            storm.dispatcher.hold();
            storm.host_speaks();
        }
        (0..3).for_each(|index| storm.module(index, &[]));
        (0..3).for_each(|index| storm.module(index, &[health()]));
        storm.host_hears();
        storm.check();
        storm.check_received();
        for (index, (link, (module, _, tally))) in
            storm.dispatcher.modules().iter().zip(&storm.modules).enumerate()
        {
            let (outgoing, ledger) = (link.outgoing(), link.ledger());
            println!("seed {seed}, module {}: {outgoing:?}, {ledger:?}, {:?}", index + 1, link.incoming());
            assert_eq!((ledger.cycles, ledger.open()), (u64::from(storm.number), 0));
            assert!(ledger.acknowledged > 20 && ledger.resent > 50, "{ledger:?}");
            let incoming = link.incoming();
            assert!(incoming.duplicate > 50 && incoming.stale > 0 && incoming.forged > 0, "{incoming:?}");
            if index < 2 {
                // One session: the two sides agree on every datagram.
                assert_eq!((link.boots(), link.sessions()), (1, 1));
                assert_eq!(
                    (outgoing.acknowledged + outgoing.late, outgoing.late),
                    (tally.let_in, tally.late)
                );
                assert_eq!((outgoing.lost, outgoing.under_way()), (tally.from_host - tally.let_in, 0));
                let back = module.session.as_ref().expect("a session").outgoing();
                // The last word of the module is not confirmed.
                assert_eq!((back.sent, back.under_way()), (tally.from_module, 1));
                assert_eq!(back.acknowledged + back.late, tally.host_let_in - 1);
                assert!(back.late > 5, "overtaken reports: {back:?}");
            } else {
                assert_eq!(link.boots(), 4, "{outgoing:?}");
            }
        }
        let refused: u64 = storm.dispatcher.modules().iter().map(|link| link.ledger().refused).sum();
        assert!(refused > 0, "seed {seed}");
        assert!(storm.dispatcher.strays().corrupt > 100, "{:?}", storm.dispatcher.strays());
    }
}

#[test]
fn in_good_weather_nothing_is_lost() {
    let mut storm = Storm::new(1, FaultParameters { delay_s: 0.002, ..FaultParameters::default() });
    (0..2_000).for_each(|step| storm.step(step));
    for (link, (.., tally)) in storm.dispatcher.modules().iter().zip(&storm.modules).take(2) {
        let (outgoing, incoming) = (link.outgoing(), link.incoming());
        assert_eq!((outgoing.lost, outgoing.late, incoming.received), (0, 0, incoming.accepted));
        assert!(outgoing.under_way() <= 2 && tally.from_host > 60, "{outgoing:?}");
    }
    assert_eq!(storm.dispatcher.strays().received, 0);
}
