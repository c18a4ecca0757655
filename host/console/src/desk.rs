//! From the server to the closed loop: what persons ask for, in the order in which it came, and what came of it.
//!
//! The loop's end looks once a tick. It has the deadman, so that a velocity ends even where the server does not run any more.

use std::sync::mpsc::{Receiver, Sender, SyncSender, TryRecvError, channel, sync_channel};
use std::time::Instant;

use super::deadman::Deadman;

/// Asks that may wait for the loop.
const QUEUE: usize = 256;
/// Asks that are handed to the loop at one look: it goes on between.
const AT_ONCE: u32 = 32;

/// What is asked of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// Emergency stop.
    Stop,
    /// The fleet finishes its cycle and holds.
    Hold,
    /// Ends a hold.
    Resume,
    /// Ends a stop or a hold, of one module or all.
    Release(Option<u16>),
    /// A velocity, east and north, m/s, and a heading, rad. To be asked for again and again.
    Velocity([f64; 2], Option<f64>),
    /// The velocity ends: why.
    LetGo(&'static str),
    /// A place to go to and to keep, m.
    Station([f64; 2], Option<f64>),
    /// A heading, rad.
    Heading(f64),
    /// Places to go to, one after the other, m.
    Waypoints(Vec<[f64; 2]>, Option<f64>),
    /// Back to what the scenario asks for.
    Legs,
    /// Ends the run.
    End,
}

/// Whose ask it is: client, and the number that it gave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ticket {
    /// Number of the client.
    pub client: u32,
    /// The client's number of the ask.
    pub id: u32,
}

/// One ask.
#[derive(Clone, Debug, PartialEq)]
pub struct Ask {
    /// Whose.
    pub ticket: Ticket,
    /// Who that is, for the log.
    pub by: String,
    /// What.
    pub wanted: Wanted,
}

/// What came of an ask.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Of which.
    pub ticket: Ticket,
    /// In words; why not, if not.
    pub outcome: Result<String, String>,
}

/// The loop's end.
pub struct Desk {
    asks: Receiver<Ask>,
    answers: Sender<Answer>,
    deadman: Deadman,
    /// The velocity in force.
    velocity: Option<([f64; 2], Option<f64>)>,
    handed: u32,
}

/// The server's end.
pub struct Counter {
    asks: SyncSender<Ask>,
    answers: Receiver<Answer>,
}

/// Both ends.
#[must_use]
pub fn desk() -> (Counter, Desk) {
    let (asks, asked) = sync_channel(QUEUE);
    let (answers, answered) = channel();
    let desk = Desk { asks: asked, answers, deadman: Deadman::default(), velocity: None, handed: 0 };
    (Counter { asks, answers: answered }, desk)
}

impl Counter {
    /// Puts in an ask; false if there is no room, or no loop any more.
    #[must_use]
    pub fn ask(&self, ask: Ask) -> bool {
        self.asks.try_send(ask).is_ok()
    }

    /// The next answer.
    #[must_use]
    pub fn answer(&self) -> Option<Answer> {
        self.answers.try_recv().ok()
    }
}

impl Desk {
    /// The next ask at `now` that changes anything. A velocity that is only asked for again is answered here.
    pub fn ask(&mut self, now: Instant) -> Option<Ask> {
        while self.handed < AT_ONCE {
            self.handed += 1;
            match self.asks.try_recv() {
                Ok(ask) => {
                    if let Some(ask) = self.judge(ask, now) {
                        return Some(ask);
                    }
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) if self.deadman.is_armed() => {
                    self.deadman.disarm();
                    return Some(self.lapse("the console is gone"));
                }
                Err(TryRecvError::Disconnected) => break,
            }
        }
        self.handed = 0;
        self.deadman.expires(now).then(|| self.lapse("not refreshed"))
    }

    fn judge(&mut self, ask: Ask, now: Instant) -> Option<Ask> {
        match ask.wanted {
            Wanted::Velocity(velocity_m_s, heading_rad)
                if self.deadman.is_armed() && self.velocity == Some((velocity_m_s, heading_rad)) =>
            {
                self.deadman.refresh(ask.ticket.client, now);
                self.answer(ask.ticket, Ok("goes on".to_owned()));
                None
            }
            Wanted::LetGo(_) if !self.deadman.let_go(ask.ticket.client) => {
                self.answer(ask.ticket, Ok("there is no velocity of this page to let go of".to_owned()));
                None
            }
            _ => Some(ask),
        }
    }

    fn lapse(&self, why: &'static str) -> Ask {
        let ticket = Ticket { client: 0, id: 0 };
        Ask { ticket, by: "deadman".to_owned(), wanted: Wanted::LetGo(why) }
    }

    /// Tells what came of an ask, at `now`. A velocity is in force from when it was followed on, and until another target or a halt was: one
    /// that was refused leaves the one before, which ends if it is not asked for again.
    pub fn tell(&mut self, ask: &Ask, outcome: Result<String, String>, now: Instant) {
        if outcome.is_ok() {
            match ask.wanted {
                Wanted::Velocity(velocity_m_s, heading_rad) => {
                    self.deadman.refresh(ask.ticket.client, now);
                    self.velocity = Some((velocity_m_s, heading_rad));
                }
                Wanted::Station(..) | Wanted::Waypoints(..) | Wanted::Legs | Wanted::Stop | Wanted::Hold => {
                    self.interrupt();
                }
                Wanted::LetGo(_) | Wanted::Resume | Wanted::Release(_) | Wanted::Heading(_) | Wanted::End => {
                }
            }
        }
        self.answer(ask.ticket, outcome);
    }

    /// The velocity in force has ended, by what did not come this way.
    pub fn interrupt(&mut self) {
        self.deadman.disarm();
    }

    /// A server that is gone needs no answers.
    fn answer(&self, ticket: Ticket, outcome: Result<String, String>) {
        let _ = self.answers.send(Answer { ticket, outcome });
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn ask(client: u32, wanted: Wanted) -> Ask {
        Ask { ticket: Ticket { client, id: 1 }, by: "test".to_owned(), wanted }
    }

    fn velocity() -> Wanted {
        Wanted::Velocity([0.04, 0.0], None)
    }

    /// Takes an ask out and says that it was followed.
    fn follow(desk: &mut Desk, now: Instant) -> Option<Wanted> {
        let ask = desk.ask(now)?;
        desk.tell(&ask, Ok(String::new()), now);
        Some(ask.wanted)
    }

    #[test]
    fn a_velocity_goes_to_the_loop_once_and_its_end_too() {
        let (counter, mut desk) = desk();
        let began = Instant::now();
        let at = |ms| began + Duration::from_millis(ms);
        for ms in [0, 100, 200] {
            assert!(counter.ask(ask(1, velocity())));
            let came = follow(&mut desk, at(ms));
            assert_eq!(came.is_some(), ms == 0, "at {ms} ms");
        }
        assert_eq!(counter.answer().map(|answer| answer.outcome), Some(Ok(String::new())));
        assert_eq!(counter.answer().map(|answer| answer.outcome), Some(Ok("goes on".to_owned())));
        assert_eq!(follow(&mut desk, at(499)), None);
        assert_eq!(follow(&mut desk, at(501)), Some(Wanted::LetGo("not refreshed")));
        assert_eq!(follow(&mut desk, at(2000)), None);
    }

    #[test]
    fn a_socket_that_closes_ends_its_own_velocity_alone() {
        let (counter, mut desk) = desk();
        let now = Instant::now();
        let gone = || Wanted::LetGo("the page is gone");
        assert!(counter.ask(ask(1, velocity())));
        assert_eq!(follow(&mut desk, now), Some(velocity()));
        assert!(counter.ask(ask(2, gone())));
        assert_eq!(follow(&mut desk, now), None);
        assert!(counter.ask(ask(1, gone())));
        assert_eq!(follow(&mut desk, now), Some(gone()));
    }

    #[test]
    fn a_velocity_ends_with_the_server() {
        let (counter, mut desk) = desk();
        let now = Instant::now();
        assert!(counter.ask(ask(1, velocity())));
        assert!(follow(&mut desk, now).is_some());
        drop(counter);
        assert_eq!(follow(&mut desk, now), Some(Wanted::LetGo("the console is gone")));
        assert_eq!(follow(&mut desk, now), None);
    }

    /// What is refused changes nothing: neither is a velocity in force that was refused, nor does it keep the one before alive, nor does
    /// another target that was refused.
    #[test]
    fn what_was_refused_changes_nothing() {
        let (counter, mut desk) = desk();
        let began = Instant::now();
        let at = |ms| began + Duration::from_millis(ms);
        let refuse = |desk: &mut Desk, wanted: Wanted, now: Instant| {
            assert!(counter.ask(ask(1, wanted)));
            let refused = desk.ask(now).expect("it is handed on");
            desk.tell(&refused, Err("no".to_owned()), now);
        };
        refuse(&mut desk, velocity(), at(0));
        assert_eq!(desk.ask(at(1000)), None);
        assert!(counter.ask(ask(1, velocity())));
        assert_eq!(follow(&mut desk, at(1000)), Some(velocity()));
        refuse(&mut desk, Wanted::Velocity([9.0, 0.0], None), at(1200));
        refuse(&mut desk, Wanted::Station([9.0, 0.0], None), at(1250));
        assert_eq!(desk.ask(at(1299)), None);
        assert_eq!(follow(&mut desk, at(1301)), Some(Wanted::LetGo("not refreshed")));
    }

    #[test]
    fn another_target_or_a_halt_ends_a_velocity() {
        let (counter, mut desk) = desk();
        let now = Instant::now();
        let later = now + Duration::from_secs(1);
        for wanted in [Wanted::Stop, Wanted::Hold, Wanted::Station([0.0; 2], None), Wanted::Legs] {
            assert!(counter.ask(ask(1, velocity())) && counter.ask(ask(1, wanted.clone())));
            assert_eq!((follow(&mut desk, now), follow(&mut desk, now)), (Some(velocity()), Some(wanted)));
            assert_eq!(follow(&mut desk, later), None);
        }
        assert!(counter.ask(ask(1, velocity())));
        assert_eq!(follow(&mut desk, now), Some(velocity()));
        desk.interrupt();
        assert_eq!(follow(&mut desk, later), None);
        // It can be asked for again.
        assert!(counter.ask(ask(1, velocity())));
        assert_eq!(follow(&mut desk, later), Some(velocity()));
    }

    #[test]
    fn the_loop_goes_on_between_many_asks() {
        let (counter, mut desk) = desk();
        let full = (0..QUEUE + 5).filter(|_| !counter.ask(ask(1, Wanted::Heading(0.0)))).count();
        assert_eq!(full, 5);
        let now = Instant::now();
        let looks: Vec<usize> = (0..9).map(|_| std::iter::from_fn(|| desk.ask(now)).count()).collect();
        assert_eq!(looks.iter().sum::<usize>(), QUEUE);
        assert!(looks.iter().all(|&asks| asks <= AT_ONCE as usize), "{looks:?}");
    }
}
