//! Modules that lost their power in the decision before: what a plan calls power tolerant meets none of them, wherever it stopped.
//!
//! The oracle shares no code with the planner: it samples where a module can stand and where its neighbour passes, and measures between
//! two capsules.

use std::f64::consts::PI;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::motion::Turn;
use crate::plan::{Outcome, Previous};
use crate::planner_config::LossTolerance;

/// Samples are that near each other, rad.
const STEP_RAD: f64 = 0.03;
/// How far beyond the end of a turn and of a swing a tail came to rest at most that lost its power (`cargo test -p sim --lib tracking`), rad.
const PAST_TURN_RAD: f64 = 0.0854;
const PAST_SWING_RAD: f64 = 0.0234;

/// Structures: cells, and their pairs side by side.
const STRUCTURES: [&str; 3] = ["2x1", "3x1", "2x2"];
const SEEDS: std::ops::Range<u64> = 0..120;

/// Any decision before: tails turn by way of poses between, and swing.
#[derive(Clone)]
struct Before {
    turns: Vec<Turn>,
    via_rad: Vec<f64>,
    cycle: Vec<Swing>,
}

/// Where in it a module stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    First,
    Second,
    Swing,
}

const PARTS: [Part; 3] = [Part::First, Part::Second, Part::Swing];

impl Before {
    /// One that ends at `tails`.
    fn new(tails: &[f64], rng: &mut ChaCha8Rng) -> Self {
        let mut off =
            |range_rad: f64| if rng.random_bool(0.3) { 0.0 } else { rng.random_range(-range_rad..range_rad) };
        let via_rad: Vec<f64> = tails.iter().map(|tail| tail + off(1.5)).collect();
        let turns = via_rad.iter().zip(tails).map(|(via, &to_rad)| Turn { from_rad: via + off(1.5), to_rad });
        let turns = turns.collect();
        let cycle = tails.iter().map(|tail_rad| {
            let amplitude_rad = off(1.5);
            let amplitude_rad = if amplitude_rad.abs() < 0.9 { 0.0 } else { amplitude_rad };
            Swing { centerline_rad: tail_rad - amplitude_rad, amplitude_rad }
        });
        Self { cycle: cycle.collect(), turns, via_rad }
    }

    /// All of it but this part: there every tail is where the part ends.
    fn without(&self, part: Part) -> Self {
        let mut less = self.clone();
        match part {
            Part::First => {
                less.turns.iter_mut().zip(&self.via_rad).for_each(|(turn, via)| turn.from_rad = *via);
            }
            Part::Second => {
                let moved: Vec<f64> =
                    self.turns.iter().zip(&self.via_rad).map(|(turn, via)| turn.to_rad - via).collect();
                less.turns.iter_mut().zip(&moved).for_each(|(turn, moved)| turn.from_rad += moved);
                less.via_rad = self.turns.iter().map(|turn| turn.to_rad).collect();
            }
            Part::Swing => {
                less.cycle.iter_mut().zip(&self.turns).for_each(|(swing, turn)| {
                    *swing = Swing { centerline_rad: turn.to_rad, amplitude_rad: 0.0 };
                });
            }
        }
        less
    }

    fn as_previous(&self) -> Previous<'_> {
        Previous {
            cycle: &self.cycle,
            transition: Some(&self.turns),
            via_rad: Some(&self.via_rad),
            is_over: false,
        }
    }

    /// Every pose in which a module can stand that lost its power in this part, rad; none where it did not move.
    fn stands(&self, part: Part, module: usize) -> Vec<f64> {
        let (Turn { from_rad, to_rad }, via_rad) = (self.turns[module], self.via_rad[module]);
        let turned = |from_rad: f64, to_rad: f64| match to_rad - from_rad {
            0.0 => Vec::new(),
            by_rad => way(from_rad, to_rad + PAST_TURN_RAD.copysign(by_rad)),
        };
        match part {
            Part::First => turned(from_rad, via_rad),
            Part::Second => turned(via_rad, to_rad),
            Part::Swing => match self.cycle[module].amplitude_rad {
                0.0 => Vec::new(),
                amplitude_rad => {
                    let past_rad = PAST_SWING_RAD.copysign(amplitude_rad);
                    way(to_rad + past_rad, to_rad - 2.0 * amplitude_rad - past_rad)
                }
            },
        }
    }
}

/// Angles from one to another.
fn way(from_rad: f64, to_rad: f64) -> Vec<f64> {
    let steps = ((to_rad - from_rad).abs() / STEP_RAD).ceil().max(1.0);
    (0..=steps as u32).map(|k| from_rad + (to_rad - from_rad) * f64::from(k) / steps).collect()
}

/// Every pose of a module in a plan that starts at `tail_rad`; none where it does not move.
fn passes(plan: &Plan, module: usize, tail_rad: f64) -> Vec<f64> {
    let turn =
        plan.transition.as_ref().map_or(Turn { from_rad: tail_rad, to_rad: tail_rad }, |turns| turns[module]);
    let via_rad = plan.via_rad.as_ref().map_or(turn.to_rad, |via| via[module]);
    let Swing { centerline_rad, amplitude_rad } = plan.cycle[module];
    let parts = [
        (turn.from_rad, via_rad),
        (via_rad, turn.to_rad),
        (centerline_rad + amplitude_rad, centerline_rad - amplitude_rad),
    ];
    parts
        .into_iter()
        .filter(|(from, to)| (from - to).abs() > 0.0)
        .flat_map(|(from, to)| way(from, to))
        .collect()
}

/// Distance between two centre lines, each from its module's centre, the second at `apart_m` from the first, m: the least of an end of one from the
/// other; zero where they cross.
fn between_m(length_m: f64, apart_m: [f64; 2], i_rad: f64, j_rad: f64) -> f64 {
    let tip =
        |from_m: [f64; 2], rad: f64| [from_m[0] + length_m * rad.cos(), from_m[1] + length_m * rad.sin()];
    let lines = [([0.0; 2], tip([0.0; 2], i_rad)), (apart_m, tip(apart_m, j_rad))];
    let less = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let off_m = |point: [f64; 2], (from, to): ([f64; 2], [f64; 2])| {
        let (along, reached) = (less(to, from), less(point, from));
        let share = (reached[0] * along[0] + reached[1] * along[1]) / (length_m * length_m);
        let share = share.clamp(0.0, 1.0);
        (reached[0] - share * along[0]).hypot(reached[1] - share * along[1])
    };
    let side = |point: [f64; 2], (from, to): ([f64; 2], [f64; 2])| {
        let (along, reached) = (less(to, from), less(point, from));
        along[0] * reached[1] - along[1] * reached[0]
    };
    let [a, b] = lines;
    if side(b.0, a) * side(b.1, a) < 0.0 && side(a.0, b) * side(a.1, b) < 0.0 {
        return 0.0;
    }
    [off_m(b.0, a), off_m(b.1, a), off_m(a.0, b), off_m(a.1, b)].into_iter().fold(f64::INFINITY, f64::min)
}

/// Modules of which the first stopped in `part` of `before` and is met by the second in `plan`, if there are such.
fn met(structure: &Structure, plan: &Plan, tails: &[f64], before: &Before, part: Part) -> Option<[usize; 2]> {
    let Parameters { pitch_m, tail_length_m, tail_width_m, .. } = Parameters::default();
    let cells = structure.cells();
    let mut pairs = (0..cells.len()).flat_map(|i| (0..cells.len()).map(move |j| [i, j]));
    pairs.find(|&[i, j]| {
        let apart = [0, 1].map(|k| cells[j][k] - cells[i][k]);
        if apart[0].abs() + apart[1].abs() != 1 {
            return false;
        }
        let apart_m = apart.map(|cells| f64::from(cells) * pitch_m);
        let passes = passes(plan, j, tails[j]);
        before.stands(part, i).into_iter().any(|stands_rad| {
            passes.iter().any(|&rad| between_m(tail_length_m, apart_m, stands_rad, rad) < tail_width_m - 1e-9)
        })
    })
}

fn planner(word: &str, loss_tolerant: LossTolerance) -> (Structure, Planner) {
    let structure = Structure::from_word(word).expect("a structure");
    let (parameters, config) =
        (Parameters::default(), PlannerConfig { loss_tolerant, ..PlannerConfig::default() });
    let distance = Arc::new(DistanceToCollision::new(&parameters));
    let planner = Planner::with_distance(&structure, &parameters, &config, distance);
    (structure, planner)
}

/// Tails on diagonals, off which they may be a little, and a small demand.
fn draw(modules: usize, rng: &mut ChaCha8Rng) -> (Vec<f64>, Wrench) {
    let tail_rad = |rng: &mut ChaCha8Rng| {
        f64::from(rng.random_range(-4..4)) * PI / 2.0 + PI / 4.0 + rng.random_range(-0.02..0.02)
    };
    let tails = (0..modules).map(|_| tail_rad(rng)).collect();
    let mut part = |most: f64| rng.random_range(-most..most);
    (tails, Wrench { fx_n: part(0.02), fy_n: part(0.02), tau_nm: part(0.002) })
}

/// Leave a part of the decision before out, and plans are called tolerant that meet a module that stopped in it; with all of it none is.
#[test]
fn a_plan_called_power_tolerant_meets_no_module_that_stopped_in_any_part_of_the_decision_before() {
    let (mut tolerant, mut shown) = (0, [0; 3]);
    for (word, seed) in STRUCTURES.into_iter().flat_map(|word| SEEDS.map(move |seed| (word, seed))) {
        let (structure, planner) = planner(word, LossTolerance::Prefer);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (tails, demand) = draw(structure.len(), &mut rng);
        let before = Before::new(&tails, &mut rng);
        let plan = |before: &Before| {
            let mut plan = Plan::default();
            planner.clone().plan_into(demand, Some(&tails), Some(before.as_previous()), &mut plan);
            plan
        };
        let whole = plan(&before);
        if whole.power_tolerant && whole.outcome == Outcome::Planned {
            tolerant += 1;
            for part in PARTS {
                let met = met(&structure, &whole, &tails, &before, part);
                assert!(met.is_none(), "{word}, seed {seed}, {part:?}: {met:?}\n{whole:?}");
            }
        }
        for (part, shown) in PARTS.into_iter().zip(&mut shown) {
            let less = plan(&before.without(part));
            let meets = less.power_tolerant && met(&structure, &less, &tails, &before, part).is_some();
            *shown += usize::from(meets);
        }
    }
    println!("{tolerant} tolerant; met where a part is left out: {shown:?}");
    assert!(tolerant >= 30, "only {tolerant} plans are tolerant");
    assert!(shown.iter().all(|&shown| shown > 0), "no part may be left out, and yet {shown:?}");
}

/// Where it is asked for, such a module is planned around, or nothing moves for a cycle.
#[test]
fn plans_that_must_be_power_tolerant_go_round_a_module_that_stopped_in_a_turn() {
    let mut moved = 0;
    for (word, seed) in STRUCTURES.into_iter().flat_map(|word| SEEDS.map(move |seed| (word, seed))) {
        let (structure, mut planner) = planner(word, LossTolerance::Power);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut tails, demand) = draw(structure.len(), &mut rng);
        let mut before = Before::new(&tails, &mut rng);
        // The second decision goes on from the first.
        for number in 0..2 {
            let mut plan = Plan::default();
            planner.plan_into(demand, Some(&tails), Some(before.as_previous()), &mut plan);
            let what = format!("{word}, seed {seed}, plan {number}");
            assert!(plan.power_tolerant, "{what}: {plan:?}");
            for part in PARTS {
                let met = met(&structure, &plan, &tails, &before, part);
                assert!(met.is_none(), "{what}, {part:?}: {met:?}\n{plan:?}");
            }
            moved += usize::from(number == 1 && plan.error < 0.5);
            let stays = || tails.iter().map(|&rad| Turn { from_rad: rad, to_rad: rad }).collect();
            let turns: Vec<Turn> = plan.transition.unwrap_or_else(stays);
            tails = turns.iter().map(|turn| turn.to_rad).collect();
            before =
                Before { cycle: plan.cycle, via_rad: plan.via_rad.unwrap_or_else(|| tails.clone()), turns };
        }
    }
    let all = STRUCTURES.len() * (SEEDS.end - SEEDS.start) as usize;
    println!("{moved} of {all} swim in the second");
    assert!(moved * 2 > all, "only {moved} of {all} do what was asked in the second");
}

/// Every module has said where it rests: none stands anywhere else.
#[test]
fn a_decision_that_is_over_keeps_no_plan_from_being_power_tolerant() {
    let mut differ = 0;
    for seed in SEEDS {
        let (structure, planner) = planner("2x1", LossTolerance::Prefer);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (tails, demand) = draw(structure.len(), &mut rng);
        let before = Before::new(&tails, &mut rng);
        let plan = |previous: Previous<'_>| {
            let mut plan = Plan::default();
            planner.clone().plan_into(demand, Some(&tails), Some(previous), &mut plan);
            plan.power_tolerant
        };
        let over = plan(Previous { is_over: true, ..before.as_previous() });
        let rest: Vec<Swing> =
            tails.iter().map(|&rad| Swing { centerline_rad: rad, amplitude_rad: 0.0 }).collect();
        assert_eq!(over, plan(Previous { is_over: true, ..Previous::cycle(&rest) }), "seed {seed}");
        differ += usize::from(over != plan(before.as_previous()));
    }
    assert!(differ > 0, "what may still be under way counts");
}
