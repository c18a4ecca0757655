//! How long the order of many robots takes: rows and random clusters, each line a problem.
//!
//! ```sh
//! cargo bench -p host --bench orders                              # 4, 6 and 8 robots 10 s each, 16 robots 60 s
//! cargo bench -p host --bench orders -- 16 --seconds 20 --seeds 1 --family random
//! ```
//!
//! *first* is when the first plan is known; *gap* is how far above the least the plan may still be when the time is up, 0 where it is proved
//! least. Both cores, the measured power table. Seconds are those of processors: what threads have computed, so that other
//! programs on the machine do not count.

use std::ops::ControlFlow;

use host::answer::threads::Threads;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::Vehicle;
use rov::order::{Known, Progress};
use rov::planner::{OrderRule, Request, plan_with};
use rov::power::PowerLaw;

type Cell = [i32; 3];

/// What all threads have computed, s.
fn computed_s() -> f64 {
    // utime and stime, in hundredths of a second, are the 12th and 13th after the name in brackets (proc(5)).
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / 100.0
}

/// Notes when there is a first plan, and ends the search when its time is up.
struct Clock {
    began_s: f64,
    limit_s: f64,
    first_s: Option<f64>,
    first: f64,
    at: Vec<(f64, Option<f64>)>,
}

const MARKS_S: [f64; 4] = [1.0, 5.0, 10.0, 30.0];

impl Progress for Clock {
    fn report(&mut self, known: &Known) -> ControlFlow<()> {
        let now_s = computed_s() - self.began_s;
        if let (Some(best), None) = (known.best, self.first_s) {
            (self.first_s, self.first) = (Some(now_s), best);
        }
        while self.at.len() < MARKS_S.len() && now_s >= MARKS_S[self.at.len()] {
            self.at.push((MARKS_S[self.at.len()], known.gap()));
        }
        if now_s >= self.limit_s { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

fn problem(starts: &[Cell], slots: &[Cell], aside_m: [f64; 2], tool: bool) -> Problem {
    let vehicles = ["bluerov1", "tool-20n"].map(|name| Vehicle::built_in(name).expect("built in")).to_vec();
    let box_m = vehicles[0].box_m;
    let at = |cell: &Cell, [x_m, y_m]: [f64; 2]| {
        let [x, y, z] = std::array::from_fn(|k| f64::from(cell[k]) * box_m[k]);
        Pose::from([x + x_m, y + y_m, 5.0 + z, 0.0])
    };
    let robot = |(index, cell): (usize, &Cell)| Robot {
        id: index as u16 + 1,
        vehicle: 0,
        start: at(cell, [0.0; 2]),
        capabilities: Vec::new(),
    };
    Problem {
        name: "orders".to_owned(),
        description: String::new(),
        robots: starts.iter().enumerate().map(robot).collect(),
        tools: if tool { vec![Tool { vehicle: 1, pose: at(&[0; 3], [0.0; 2]) }] } else { Vec::new() },
        slots: slots.iter().map(|cell| Slot { pose: at(cell, aside_m), requires: Vec::new() }).collect(),
        rules: Rules::default(),
        bounds: None,
        vehicles,
    }
}

/// `robots` cells grown from one cell, which is the tool's if there is one.
fn grown(rng: &mut ChaCha8Rng, robots: usize, tool: bool, spatial: bool) -> Vec<Cell> {
    let mut cells = vec![[0; 3]];
    while cells.len() < robots + usize::from(tool) {
        let mut cell: Cell = cells[rng.random_range(0..cells.len())];
        cell[rng.random_range(0..if spatial { 3 } else { 2 })] += if rng.random_bool(0.5) { 1 } else { -1 };
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    cells.split_off(usize::from(tool))
}

const FAMILIES: [&str; 5] = ["row", "random", "solid", "tool", "solid tool"];

fn drawn(family: &str, robots: usize, seed: u64) -> Problem {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let row: Vec<Cell> = (0..robots as i32).map(|n| [n, 0, 0]).collect();
    let (tool, spatial) = (family.contains("tool"), family.contains("solid"));
    match family {
        "row" => {
            // Four metres aside, by seed across, along or askew.
            let aside_m = [[0.0, 4.0], [4.0, 4.0], [0.483 * robots as f64 + 4.0, 0.0]];
            problem(&row, &row, aside_m[seed as usize % 3], false)
        }
        _ => {
            let start = grown(&mut rng, robots, tool, spatial);
            let goal = grown(&mut rng, robots, tool, spatial);
            problem(&start, &goal, if tool { [0.0; 2] } else { [4.0, 0.0] }, tool)
        }
    }
}

fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kilobytes.unwrap_or(f64::NAN) / 1024.0
}

fn main() {
    let (mut counts, mut seconds, mut seeds, mut from, mut families) =
        (Vec::new(), None, 3_u64, 0_u64, Vec::new());
    let mut fitted = false;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|value| value.parse::<u64>().ok()).expect("a number");
        match argument.as_str() {
            "--seconds" => seconds = Some(number()),
            "--seeds" => seeds = number(),
            "--from" => from = number(),
            "--fitted" => fitted = true,
            "--family" => families.push(arguments.next().expect("a family")),
            count => counts.extend(count.parse::<usize>()),
        }
    }
    if counts.is_empty() {
        counts = vec![4, 6, 8, 16];
    }
    if families.is_empty() {
        families = FAMILIES.map(str::to_owned).to_vec();
    }
    let workers = Threads::new();
    println!("robots family     seed   first s   first J    best J  at least   gap %    s      priced  MB");
    for robots in counts {
        for family in &families {
            for seed in from..from + seeds {
                let problem = drawn(family, robots, seed);
                let volts = problem.rules.battery_v;
                let law = if fitted { PowerLaw::fitted(volts) } else { PowerLaw::table(volts) };
                let request = Request {
                    criterion: Criterion::Energy,
                    manner: Manner::Best,
                    order: OrderRule::Exact,
                    law: law.expect("in the table"),
                };
                let limit_s = seconds.unwrap_or(if robots > 8 { 60 } else { 10 }) as f64;
                let began_s = computed_s();
                let mut clock = Clock { began_s, limit_s, first_s: None, first: f64::NAN, at: Vec::new() };
                let planned = plan_with(&problem, &request, &workers, &mut clock);
                let took_s = computed_s() - began_s;
                match planned {
                    Ok(planned) => {
                        let faults = judge::verify(&problem, &planned.plan);
                        let marks: Vec<String> = clock
                            .at
                            .iter()
                            .map(|(at, gap)| format!("{at:.0}s:{:.1}", 100.0 * gap.unwrap_or(f64::NAN)))
                            .collect();
                        println!(
                            "{robots:6} {family:10} {seed:4} {:9.3} {:9.2} {:9.2} {:9.2} {:7.2} {took_s:7.2} {:7} {:5.0} {}{}",
                            clock.first_s.unwrap_or(took_s),
                            clock.first,
                            planned.cost,
                            planned.bound,
                            100.0 * planned.gap().unwrap_or(f64::NAN),
                            planned.priced,
                            peak_mb(),
                            marks.join(" "),
                            if faults.is_empty() { String::new() } else { format!(" REFUSED {faults:?}") },
                        );
                    }
                    Err(error) => println!("{robots:6} {family:10} {seed:4} {took_s:7.2} s: {error}"),
                }
            }
        }
    }
}
