//! Which start times are possible together, and what the waiting robots draw meanwhile.
//!
//! Two robots keep clear of each other or not whatever the others do, and if both move once, only the difference of
//! their start times counts: such answers are kept. So are the balances of waiting configurations.

use std::collections::HashMap;
use std::rc::Rc;

use reconfiguration::plan::{Holding, Move};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;

use super::super::balance::balance;
use super::super::conditions::Conditions;
use super::super::configuration::{adjacency, clusters};
use super::super::power::PowerLaw;
use super::meeting::{Size, keep_clear};
use super::track::{Piece, pieces};

/// Events nearer to each other are one, s.
pub(super) const SAME_S: f64 = 1e-9;
/// Before everything and after it, s.
const FAR_S: f64 = 1e9;
/// A robot that is under way.
const AWAY: u8 = u8::MAX;

/// A move at a certain pace, from time 0 on.
pub(super) struct Passage {
    pub own: Move,
    pieces: Vec<Piece>,
}

/// A robot's moves by their number in the plan, in order.
struct Traveller {
    start: Pose,
    size: Size,
    moves: Vec<usize>,
}

/// What waits, and what that takes.
pub(super) struct Waiting {
    pub power_w: f64,
    pub balance: Vec<Holding>,
    clusters: usize,
}

/// From one event to the next.
pub(super) struct Span {
    pub from_s: f64,
    pub to_s: f64,
    /// Moves under way.
    pub movers: Vec<usize>,
    pub waiting: Rc<Waiting>,
}

/// A whole table of times, or what is known of it.
pub(super) struct Laid {
    pub spans: Vec<Span>,
    pub balance_j: f64,
    pub time_s: f64,
}

/// Two robots at certain paces with a difference of start times, µs.
type Pair = (usize, usize, usize, usize, i64);

/// See the module's documentation.
pub(super) struct Timetable<'a> {
    problem: &'a Problem,
    law: &'a PowerLaw,
    limits_n: (f64, f64),
    origin_m: [f64; 3],
    travellers: Vec<Traveller>,
    /// The robot of each move.
    robots: Vec<usize>,
    /// By move and pace.
    passages: Vec<Vec<Passage>>,
    /// Which pace each move has now.
    pub paces: Vec<usize>,
    /// Waiting robots may fall into so many clusters: those of one move after the other.
    clusters_most: usize,
    waiting: HashMap<Vec<u8>, Option<Rc<Waiting>>>,
    pairs: HashMap<Pair, bool>,
}

impl<'a> Timetable<'a> {
    /// For moves at one or more paces each, in an order in which one after the other is possible.
    pub fn new(problem: &'a Problem, law: &'a PowerLaw, limits_n: (f64, f64), moves: Vec<Vec<Move>>) -> Self {
        let origin_m = problem.robots.first().map_or([0.0; 3], |robot| robot.start.position_m);
        let robot_of = |own: &Move| problem.robots.iter().position(|robot| robot.id == own.robot);
        let robots: Vec<usize> =
            moves.iter().map(|paces| paces.first().and_then(robot_of).unwrap_or(usize::MAX)).collect();
        let travellers: Vec<Traveller> = problem
            .robots
            .iter()
            .enumerate()
            .map(|(index, robot)| {
                let vehicle = &problem.vehicles[robot.vehicle];
                let half_m = vehicle.box_m.map(|side| side / 2.0);
                Traveller {
                    start: robot.start,
                    size: Size { half_m, distance_m: problem.clearance_m(vehicle) },
                    moves: (0..robots.len()).filter(|&own| robots[own] == index).collect(),
                }
            })
            .collect();
        let passage = |own: Move, robot: usize| {
            let distance_m = travellers.get(robot).map_or(0.0, |traveller| traveller.size.distance_m);
            Passage { pieces: pieces(&own, origin_m, distance_m), own }
        };
        let passages = moves
            .into_iter()
            .zip(&robots)
            .map(|(paces, &robot)| paces.into_iter().map(|own| passage(own, robot)).collect())
            .collect();
        let paces = vec![0; robots.len()];
        let mut table = Self {
            problem,
            law,
            limits_n,
            origin_m,
            travellers,
            robots,
            passages,
            paces,
            clusters_most: usize::MAX,
            waiting: HashMap::new(),
            pairs: HashMap::new(),
        };
        let mut now_s = 0.0;
        let one_by_one: Vec<Option<f64>> = (0..table.robots.len())
            .map(|own| {
                let start_s = now_s;
                now_s += table.passage(own).own.duration_s;
                Some(start_s)
            })
            .collect();
        let most = table
            .laid(&one_by_one)
            .map(|laid| laid.spans.iter().map(|span| span.waiting.clusters).max().unwrap_or_default());
        table.clusters_most = most.unwrap_or(usize::MAX);
        table
    }

    /// How many moves there are.
    pub fn moves(&self) -> usize {
        self.robots.len()
    }

    /// How many paces a move has.
    pub fn paces_of(&self, own: usize) -> usize {
        self.passages[own].len()
    }

    /// A move at its pace of now.
    pub fn passage(&self, own: usize) -> &Passage {
        &self.passages[own][self.paces[own]]
    }

    /// Σ over all moves at their paces, J.
    pub fn navigate_j(&self) -> f64 {
        (0..self.moves()).map(|own| self.passage(own).own.energy_navigate_j).sum()
    }

    /// When a move may begin at the earliest: its robot has made all moves before it. `None` if one of them has no time yet.
    pub fn earliest_s(&self, own: usize, starts: &[Option<f64>]) -> Option<f64> {
        let traveller = &self.travellers[self.robots[own]];
        match traveller.moves.iter().rfind(|&&other| other < own) {
            None => Some(0.0),
            Some(&before) => starts[before].map(|start_s| start_s + self.passage(before).own.duration_s),
        }
    }

    /// Where a robot is at all times.
    fn track(&self, robot: usize, starts: &[Option<f64>]) -> Vec<Piece> {
        let traveller = &self.travellers[robot];
        let (mut at, mut now_s) = (traveller.start, -FAR_S);
        let mut track = Vec::new();
        for &own in &traveller.moves {
            let Some(start_s) = starts[own] else { break };
            let passage = self.passage(own);
            track.push(Piece::at_rest(at, self.origin_m, now_s, start_s));
            track.extend(passage.pieces.iter().map(|piece| piece.later(start_s)));
            now_s = start_s + passage.own.duration_s;
            at = passage.own.actions.last().map_or(at, |last| last.to);
        }
        track.push(Piece::at_rest(at, self.origin_m, now_s, FAR_S));
        track
    }

    /// Whether the robot of a move keeps clear of all others.
    pub fn is_clear(&mut self, own: usize, starts: &[Option<f64>]) -> bool {
        let robot = self.robots[own];
        (0..self.travellers.len()).all(|other| other == robot || self.are_clear(robot, other, starts))
    }

    fn are_clear(&mut self, first: usize, second: usize, starts: &[Option<f64>]) -> bool {
        let key = self.pair(first, second, starts);
        if let Some(&known) = key.as_ref().and_then(|key| self.pairs.get(key)) {
            return known;
        }
        let tracks = [first, second].map(|robot| self.track(robot, starts));
        let sizes = [first, second].map(|robot| self.travellers[robot].size);
        let clear = keep_clear((sizes[0], &tracks[0]), (sizes[1], &tracks[1]));
        if let Some(key) = key {
            self.pairs.insert(key, clear);
        }
        clear
    }

    /// What an answer is kept under: for robots that move once at most.
    fn pair(&self, first: usize, second: usize, starts: &[Option<f64>]) -> Option<Pair> {
        let (first, second) = (first.min(second), first.max(second));
        let once = |robot: usize| match self.travellers[robot].moves[..] {
            [] => Some((None, 0)),
            [own] => Some((starts[own], self.paces[own])),
            _ => None,
        };
        let ((a, pace_a), (b, pace_b)) = (once(first)?, once(second)?);
        let after_us = match (a, b) {
            (Some(a), Some(b)) => ((b - a) * 1e6).round() as i64,
            (Some(_), None) => i64::MAX,
            (None, Some(_)) => i64::MIN,
            (None, None) => i64::MAX - 1,
        };
        Some((first, pace_a, second, pace_b, after_us))
    }

    /// The table of the moves that have a time; `None` where no robot is under way for a while, or those that wait cannot.
    pub fn laid(&mut self, starts: &[Option<f64>]) -> Option<Laid> {
        let times: Vec<(usize, f64, f64)> = (0..self.moves())
            .filter_map(|own| starts[own].map(|s| (own, s, s + self.passage(own).own.duration_s)))
            .collect();
        let mut cuts: Vec<f64> = times.iter().flat_map(|&(_, from_s, to_s)| [from_s, to_s]).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|b, a| *b - *a < SAME_S);
        if cuts.first().is_some_and(|first_s| *first_s > SAME_S) {
            return None;
        }
        let mut laid =
            Laid { spans: Vec::new(), balance_j: 0.0, time_s: cuts.last().copied().unwrap_or(0.0) };
        for cut in cuts.windows(2) {
            let middle_s = 0.5 * (cut[0] + cut[1]);
            let mut key = vec![0_u8; self.travellers.len()];
            let mut movers = Vec::new();
            for &(own, from_s, to_s) in &times {
                let place = &mut key[self.robots[own]];
                if to_s < middle_s {
                    *place = place.saturating_add(1);
                } else if from_s < middle_s {
                    *place = AWAY;
                    movers.push(own);
                }
            }
            if movers.is_empty() {
                return None;
            }
            let waiting = self.waiting(&key)?;
            if waiting.clusters > self.clusters_most {
                return None;
            }
            laid.balance_j += waiting.power_w * (cut[1] - cut[0]);
            laid.spans.push(Span { from_s: cut[0], to_s: cut[1], movers, waiting });
        }
        Some(laid)
    }

    /// What waits where every robot has made so many moves, or is [`AWAY`].
    fn waiting(&mut self, key: &[u8]) -> Option<Rc<Waiting>> {
        if !self.waiting.contains_key(key) {
            let found = self.balanced(key).map(Rc::new);
            self.waiting.insert(key.to_vec(), found);
        }
        self.waiting[key].clone()
    }

    fn balanced(&self, key: &[u8]) -> Option<Waiting> {
        let problem = self.problem;
        let tools = problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle]));
        let place = |robot: usize, made: u8| {
            let traveller = &self.travellers[robot];
            let last = usize::from(made).checked_sub(1).and_then(|index| traveller.moves.get(index));
            let end = last.and_then(|&own| self.passages[own][0].own.actions.last());
            end.map_or(traveller.start, |action| action.to)
        };
        let waits: Vec<usize> = (0..key.len()).filter(|&robot| key[robot] != AWAY).collect();
        let robots = waits
            .iter()
            .map(|&robot| (place(robot, key[robot]), &problem.vehicles[problem.robots[robot].vehicle]));
        let bodies: Vec<(Pose, &Vehicle)> = tools.chain(robots).collect();
        let balanced = balance(&bodies, self.law, self.limits_n, &problem.rules).ok()?;
        let thrusts_n = balanced.thrusts_n.into_iter().skip(problem.tools.len());
        let balance = waits
            .iter()
            .zip(thrusts_n)
            .map(|(&robot, thrusts_n)| Holding { robot: problem.robots[robot].id, thrusts_n })
            .collect();
        let clusters = clusters(&adjacency(&bodies)).len();
        Some(Waiting { power_w: balanced.power_w, balance, clusters })
    }
}
