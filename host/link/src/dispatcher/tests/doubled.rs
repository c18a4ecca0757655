//! Two modules with one number, and one that boots.

use protocol::{Kind, MAX_DATAGRAM};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::super::super::rival::ALIVE_FOR;
use super::super::*;
use super::played::*;

const STEP: u64 = 20_000;

/// A module that speaks as the firmware does: reports, asks for the time, and looks for a host once it hears none.
struct Speaker {
    played: Played,
    address: char,
    heard: u64,
    on: bool,
    /// What the host told it.
    told: Vec<Message>,
}

/// A host and modules of one number, over a medium that may lose.
struct Water {
    host: Dispatcher<char>,
    speakers: Vec<Speaker>,
    us: u64,
    loss: f64,
    rng: ChaCha8Rng,
    events: Vec<(u64, DispatcherEvent)>,
    /// Everything that the modules said, come or not.
    recorded: Vec<Vec<u8>>,
}

impl Water {
    fn new(seed: u64, speakers: usize) -> Self {
        let first = Played::new(&KEY, ModuleId(1));
        let speaker = |k: usize| {
            let address = char::from(b'a' + u8::try_from(k).expect("few"));
            let played = first.twin(10 * u8::try_from(k + 1).expect("few"));
            Speaker { played, address, heard: 0, on: k == 0, told: Vec::new() }
        };
        Self {
            host: Dispatcher::new(&[ModuleId(1)], &KEY, HOST),
            speakers: (0..speakers).map(speaker).collect(),
            us: 10_000_000,
            loss: 0.0,
            rng: ChaCha8Rng::seed_from_u64(seed),
            events: Vec::new(),
            recorded: Vec::new(),
        }
    }

    fn link(&self) -> &ModuleLink<char> {
        &self.host.modules()[0]
    }

    fn comes(&mut self) -> bool {
        !self.rng.random_bool(self.loss)
    }

    fn hears(&mut self, from: char, datagram: &[u8]) -> Result<(), Class> {
        let event = self.host.handle_datagram(FleetInstant(self.us), from, datagram)?;
        self.events.extend(event.map(|event| (self.us, event)));
        Ok(())
    }

    fn step(&mut self) {
        self.us += STEP;
        for k in 0..self.speakers.len() {
            let Speaker { played, address, heard, on, .. } = &mut self.speakers[k];
            if !*on {
                continue;
            }
            let (from, mut said) = (*address, Vec::new());
            if self.us.saturating_sub(*heard) > 1_500_000 && self.us.is_multiple_of(200_000) {
                said.push(played.announce());
            }
            if played.session.is_some() {
                said.push(played.say(&report(self.us, 0, ModuleState::Ready)));
            }
            self.recorded.extend(said.iter().cloned());
            for datagram in said {
                if self.comes() {
                    let _ = self.hears(from, &datagram);
                }
            }
        }
        self.host.handle_timer(FleetInstant(self.us));
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((to, datagram)) = self.host.poll_transmit(FleetInstant(self.us), &mut buffer) {
            let datagram = datagram.to_vec();
            if !self.comes() {
                continue;
            }
            for speaker in self.speakers.iter_mut().filter(|speaker| speaker.on && speaker.address == to) {
                if let Ok(opened) = speaker.played.handle_datagram(&datagram) {
                    speaker.heard = self.us;
                    speaker.told.push(opened.message);
                }
            }
        }
    }

    fn run(&mut self, us: u64) {
        (0..us / STEP).for_each(|_| self.step());
    }

    fn doubled(&self) -> Option<u64> {
        self.events.iter().find_map(|(us, event)| (*event == DispatcherEvent::Doubled(0)).then_some(*us))
    }
}

fn addresses(link: &ModuleLink<char>) -> Option<[char; 2]> {
    link.doubled().map(|mut both| {
        both.sort_unstable();
        both
    })
}

#[test]
fn two_that_answer_are_both_named_and_neither_is_used() {
    let mut water = Water::new(1, 2);
    water.run(3_000_000);
    assert!(water.link().telemetry().is_some() && !water.link().is_doubled());
    water.host.dispatch(
        FleetInstant(water.us),
        1,
        FleetInstant(water.us + 900_000),
        &[Some(SWIM)],
        Delivery::Direct,
    );
    water.run(100_000);
    let came = water.us;
    water.speakers[1].on = true;
    water.run(1_000_000);
    let after = water.doubled().expect("they are two") - came;
    assert!(after <= 600_000, "{after} µs");
    let link = water.link();
    assert_eq!((addresses(link), link.is_reachable()), (Some(['a', 'b']), false));
    assert!(link.telemetry().is_none() && link.state().is_none() && link.health().is_none());
    assert_eq!(water.host.silence(FleetInstant(water.us), ModuleId(1)), Some(Silence::Doubled));
    // Either may have it.
    assert_eq!(link.knowledge(1), super::super::super::delivery::Knowledge::Possibly);
    // No cycle goes to either, and one that all must have is given up.
    water.speakers.iter_mut().for_each(|speaker| speaker.told.clear());
    let start = FleetInstant(water.us + 400_000);
    water.host.dispatch(FleetInstant(water.us), 2, start, &[Some(SWIM)], Delivery::Prepare);
    water.run(300_000);
    assert!(water.host.is_dropped(2));
    water.host.dispatch(
        FleetInstant(water.us),
        3,
        FleetInstant(water.us + 400_000),
        &[Some(SWIM)],
        Delivery::Direct,
    );
    water.run(5_000_000);
    for speaker in &water.speakers {
        let cycles =
            speaker.told.iter().filter(|message| matches!(message, Message::Cycle(_) | Message::Commit(_)));
        assert_eq!(cycles.count(), 0, "at {}", speaker.address);
    }
    assert!(
        water.link().is_doubled() && water.link().telemetry().is_none() && water.link().incoming().is_exact()
    );
    // Both stay where they are: they are asked, and do not look for another host.
    assert_eq!(water.events.iter().filter(|(_, event)| *event == DispatcherEvent::Doubled(0)).count(), 1);
    // A stop is for both.
    water.host.emergency_stop(FleetInstant(water.us));
    water.run(100_000);
    assert!(water.speakers.iter().all(|speaker| speaker.told.contains(&Message::EmergencyStop)));
}

#[test]
fn it_ends_when_one_of_them_is_silent() {
    for goes in [0, 1] {
        let mut water = Water::new(2, 2);
        water.speakers[1].on = true;
        water.run(6_000_000);
        assert!(water.link().is_doubled());
        water.speakers[goes].on = false;
        water.run(u64::from(ALIVE_FOR.0) - 300_000);
        assert!(water.link().is_doubled(), "it may come back");
        water.run(400_000);
        let link = water.link();
        assert!(!link.is_doubled() && link.is_reachable() && link.telemetry().is_some(), "{goes} goes");
        assert_eq!(link.address(), Some(water.speakers[1 - goes].address));
        // What is left is used again.
        let (now, start) = (FleetInstant(water.us), FleetInstant(water.us + 400_000));
        water.host.dispatch(now, 9, start, &[Some(SWIM)], Delivery::Direct);
        water.run(STEP);
        assert!(water.speakers[1 - goes].told.iter().any(|message| matches!(message, Message::Cycle(_))));
    }
}

/// Everything that its old boot ever said is played again, with what never came.
#[test]
fn a_boot_is_not_a_second_module() {
    for (seed, loss) in (0..20).map(|seed| (seed, if seed < 5 { 0.0 } else { 0.3 })) {
        let mut water = Water::new(seed, 1);
        water.loss = loss;
        for boot in 0..3 {
            water.run(4_000_000);
            let recorded = std::mem::take(&mut water.recorded);
            water.speakers[0].played.reboot();
            water.speakers[0].heard = 0;
            let boots = water.link().boots();
            while water.link().boots() == boots {
                water.step();
            }
            for datagram in &recorded {
                water.us += 1_000;
                let is_session = Frame::parse(datagram).expect("whole").header.kind == Kind::ToHost;
                let told = water.hears('x', datagram);
                assert!(!is_session || told == Err(Class::Stale), "seed {seed}, boot {boot}: {told:?}");
            }
            water.us = water.us.next_multiple_of(STEP);
            let (link, doubled) = (water.link(), water.doubled());
            assert!(!link.is_doubled() && doubled.is_none(), "seed {seed}, boot {boot}: {doubled:?}");
        }
        water.run(5_000_000);
        assert!(water.doubled().is_none() && water.link().telemetry().is_some(), "seed {seed}");
        assert_eq!(water.link().boots(), 4, "seed {seed}");
    }
}

/// What never came is let in when it is played later, and says nothing of now.
#[test]
fn nothing_that_is_played_keeps_one_alive_that_is_gone() {
    for (seed, goes) in (0..10).flat_map(|seed| [(seed, 0), (seed, 1)]) {
        let mut water = Water::new(seed, 2);
        (water.loss, water.speakers[1].on) = (0.1, true);
        water.run(8_000_000);
        assert!(water.link().is_doubled(), "seed {seed}");
        let (us, from) = (water.us, water.speakers[goes].address);
        let held = (0..100).map(|_| water.speakers[goes].played.say(&report(us, 0, ModuleState::Ready)));
        let held: Vec<Vec<u8>> = held.collect();
        water.speakers[goes].on = false;
        let mut played = 0;
        for datagram in held {
            water.run(100_000);
            played += usize::from(water.hears(from, &datagram).is_ok());
            let over = water.us >= us + u64::from(ALIVE_FOR.0) + 100_000;
            assert!(!over || !water.link().is_doubled(), "seed {seed}, {goes} goes: {} µs", water.us - us);
        }
        assert!(played > 20, "seed {seed}: {played} were let in");
        assert_eq!(water.link().address(), Some(water.speakers[1 - goes].address), "seed {seed}");
    }
}

#[test]
fn two_are_found_over_a_bad_link_and_by_a_host_that_starts_again() {
    for seed in 0..20 {
        let mut water = Water::new(seed, 2);
        (water.loss, water.speakers[1].on) = (0.3, true);
        let began = water.us;
        water.run(12_000_000);
        let found = water.doubled().map(|us| us - began);
        assert!(found.is_some_and(|us| us < 8_000_000), "seed {seed}: {found:?}");
        assert!(water.link().is_doubled(), "seed {seed}");
        // The host's memory is gone; the modules serve its next start.
        water.host = Dispatcher::new(&[ModuleId(1)], &KEY, [8; 12]);
        water.events.clear();
        let began = water.us;
        water.run(12_000_000);
        let found = water.doubled().map(|us| us - began);
        assert!(found.is_some_and(|us| us < 8_000_000), "seed {seed}, again: {found:?}");
        assert!(water.link().is_doubled(), "seed {seed}, again");
    }
}

#[test]
fn a_host_that_starts_again_takes_one_module_for_one() {
    for seed in 0..10 {
        let mut water = Water::new(seed, 1);
        water.loss = 0.3;
        water.run(4_000_000);
        water.host = Dispatcher::new(&[ModuleId(1)], &KEY, [8; 12]);
        water.run(8_000_000);
        assert!(water.doubled().is_none() && water.link().telemetry().is_some(), "seed {seed}");
    }
}
