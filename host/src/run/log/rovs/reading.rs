//! What the log of a reconfiguration says: its record, and its figures.

use reconfiguration::pose::Pose;
use record::reconfigure::{Record, RobotSample, Sample};
use runlog::flotilla;

use super::super::super::host::Controller;
use super::super::super::reconfigure::controller::Execution;
use super::super::super::reconfigure::summary::{Energy, MoveFigures, Summary};
use super::super::super::shortfall::{self, Shortfall};
use super::super::super::summary::{AbsenceFigures, GapFigures, PoseFigures, all_of, reboots};
use super::super::counts;
use super::super::topics::Told;
use super::{Document, Title};

/// A robot that takes no part, or is waited for, for less than this in all is no shortfall, s: what a move waits for a robot that is not
/// quite there. *Assumed.*
const FLOOR_S: f64 = 4.0;

/// See the module's documentation. What is told is taken in message by message.
pub struct Reading {
    document: Document,
    seed: u64,
    ids: Vec<u16>,
    samples: Vec<Sample>,
    links: flotilla::Links,
    ledger: flotilla::Ledger,
    legs: flotilla::Legs,
    absences: flotilla::Absences,
    holds: flotilla::Holds,
    moves: flotilla::Moves,
    pauses: flotilla::Pauses,
    poses: Option<flotilla::Poses>,
    dead: flotilla::DeadThrusters,
    end: Option<flotilla::End>,
    /// What makes no sense, first of all.
    flaw: Option<String>,
}

/// What became of an execution.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What it is called.
    pub title: Title,
    /// The figures.
    pub summary: Summary,
    /// Everything over time.
    pub record: Record,
    /// Whether its end was told.
    pub ended: bool,
}

impl Reading {
    /// Of the execution of `document` from `seed`.
    #[must_use]
    pub fn new(document: Document, seed: u64) -> Self {
        let ids = document.problem.robots.iter().map(|robot| robot.id).collect();
        Self {
            document,
            seed,
            ids,
            samples: Vec::new(),
            links: flotilla::Links::default(),
            ledger: flotilla::Ledger::default(),
            legs: flotilla::Legs::default(),
            absences: flotilla::Absences::default(),
            holds: flotilla::Holds::default(),
            moves: flotilla::Moves::default(),
            pauses: flotilla::Pauses::default(),
            poses: None,
            dead: flotilla::DeadThrusters::default(),
            end: None,
            flaw: None,
        }
    }

    /// Takes in one message.
    pub fn take(&mut self, told: Told<'_>) {
        match told {
            Told::Robots(robots) => {
                let modules = self.ids.len();
                if robots.robots.len() != modules {
                    let flaw = format!("{} robots, in a log of {modules}", robots.robots.len());
                    self.flaw.get_or_insert(flaw);
                }
                self.samples.push(sample(robots));
            }
            Told::Links(links) => self.links.clone_from(links),
            Told::Ledger(ledger) => self.ledger.clone_from(ledger),
            Told::Legs(legs) => self.legs.clone_from(legs),
            Told::Absences(absences) => self.absences.clone_from(absences),
            Told::Holds(holds) => self.holds.clone_from(holds),
            Told::Moves(moves) => self.moves.clone_from(moves),
            Told::DeadThrusters(dead) => self.dead.clone_from(dead),
            Told::Pauses(pauses) => self.pauses.clone_from(pauses),
            Told::Poses(poses) => self.poses = Some(poses.clone()),
            Told::End(end) => self.end = Some(end.clone()),
            // Of the first the reading is made; the others are told of Modboats.
            Told::Scenario(_)
            | Told::Begin(_)
            | Told::Truth(_)
            | Told::Estimate(_)
            | Told::Tails(_)
            | Told::Decision(_)
            | Told::Cycle(_)
            | Told::Gap(_)
            | Told::Contact(_)
            | Told::WeakModules(_)
            | Told::Order(_) => {}
        }
    }

    /// Everything. Of a log without its end: until there.
    ///
    /// # Errors
    /// What makes no sense in it.
    pub fn finish(self) -> Result<Outcome, String> {
        if let Some(flaw) = self.flaw {
            return Err(flaw);
        }
        let ended = self.end.is_some();
        let end_s = self.samples.last().map_or(0.0, |sample| sample.t_s);
        let cut = || flotilla::End {
            why: Some(format!("ended early, after {end_s:.1} s: the log ends there")),
            ..flotilla::End::default()
        };
        let end = self.end.unwrap_or_else(cut);
        let Document { title, problem, plan } = self.document;
        let moves: Vec<MoveFigures> = self.moves.moves.iter().map(figures).collect();
        // Moves that overlap take less time than their sum.
        let lasting = |energy: Energy, time_s: f64| Energy { time_s, ..energy };
        let sum = |of: fn(&MoveFigures) -> Energy| moves.iter().map(of).sum::<Energy>();
        let [mut planned, mut expected] = [sum(|m| m.planned), sum(|m| m.expected)];
        let [mut executed, mut by_table] = [sum(|m| m.executed), sum(|m| m.by_table)];
        if plan.is_parallel() {
            [planned, expected] = [planned, expected].map(|energy| lasting(energy, plan.time_s));
            [executed, by_table] = [executed, by_table].map(|energy| lasting(energy, end_s));
        }
        let id = |robot: usize| self.ids.get(robot).copied().unwrap_or_default();
        let watched = counts::watched(1, &self.legs, &self.absences, &self.holds);
        let found =
            watched.iter().flat_map(|seen| shortfall::of_watch(None, seen, FLOOR_S, Execution::MODULE, id));
        let flotilla::DeadThrusters { robot, thruster, at_s, .. } = &self.dead;
        let dead = robot
            .iter()
            .zip(thruster)
            .zip(at_s)
            .map(|((&robot, &thruster), &at_s)| Shortfall::Thruster { robot, thruster, at_s });
        let shortfalls: Vec<_> = found.chain(dead).collect();
        let gaps = self.pauses.start_s.iter().zip(&self.pauses.length_s);
        let link = counts::link_figures(&self.links);
        let summary = Summary {
            problem: problem.name.clone(),
            criterion: plan.criterion,
            manner: plan.manner,
            seed: self.seed,
            failure: end.why.or_else(|| all_of(&shortfalls)),
            shortfalls,
            gaps: gaps.map(|(&start_s, &length_s)| GapFigures { start_s, length_s }).collect(),
            absences: AbsenceFigures::of_all(&watched, id),
            planned,
            expected,
            executed,
            by_table,
            ratio: (planned.total_j > 0.0).then(|| executed.total_j / planned.total_j),
            reboots: reboots(&link).into(),
            link,
            strays: counts::received(&self.ledger.strays),
            faults: self.ledger.medium.as_ref().map(counts::fault_count),
            poses: self.poses.map(PoseFigures::from),
            wall_s: end.wall_s,
            moves,
        };
        let record = Record { problem, plan, samples: self.samples };
        Ok(Outcome { title, summary, record, ended })
    }
}

fn sample(robots: &flotilla::Robots) -> Sample {
    let one = |robot: &flotilla::Robot| RobotSample {
        eta: robot.eta,
        nu: robot.nu,
        tau: robot.tau,
        thrusts_n: robot.thrusts_n.clone(),
        pulses_us: robot.pulses_us.clone(),
        power_w: robot.power_w,
        reference: robot
            .reference
            .as_ref()
            .map(|place| Pose::from([place.x_m, place.y_m, place.z_m, place.yaw_rad])),
        arrived: robot.arrived,
    };
    Sample {
        t_s: robots.t_s,
        moving: usize::try_from(robots.moving).ok(),
        restoring_nm: robots.restoring_nm,
        robots: robots.robots.iter().map(one).collect(),
    }
}

/// Figures of a move as a message.
pub(super) fn told(figures: &MoveFigures) -> flotilla::Move {
    let energy = |energy: &Energy| flotilla::Energy {
        navigate_j: energy.navigate_j,
        balance_j: energy.balance_j,
        total_j: energy.total_j,
        time_s: energy.time_s,
    };
    flotilla::Move {
        robot: figures.robot,
        slot: figures.slot.map_or(flotilla::PARKED, |slot| slot as u32),
        planned: energy(&figures.planned),
        expected: energy(&figures.expected),
        executed: energy(&figures.executed),
        by_table: energy(&figures.by_table),
        cross_track_m: figures.cross_track_m,
        least_gap_m: figures.least_gap_m,
        end_m: figures.end_m,
        end_rad: figures.end_rad,
    }
}

/// The same, back.
fn figures(told: &flotilla::Move) -> MoveFigures {
    let energy = |energy: &flotilla::Energy| Energy {
        navigate_j: energy.navigate_j,
        balance_j: energy.balance_j,
        total_j: energy.total_j,
        time_s: energy.time_s,
    };
    MoveFigures {
        robot: told.robot,
        slot: (told.slot != flotilla::PARKED).then_some(told.slot as usize),
        planned: energy(&told.planned),
        expected: energy(&told.expected),
        executed: energy(&told.executed),
        by_table: energy(&told.by_table),
        cross_track_m: told.cross_track_m,
        least_gap_m: told.least_gap_m,
        end_m: told.end_m,
        end_rad: told.end_rad,
    }
}
