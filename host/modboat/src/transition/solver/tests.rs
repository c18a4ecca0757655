use std::f64::consts::PI;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::distance::DistanceToCollision;
use crate::parameters::Parameters;

/// A clearance without geometry: a pseudo-random verdict for each motion, `share` of them forbidden.
struct Arbitrary {
    share: f64,
}

impl Arbitrary {
    fn hash(seed: u64, values: &[f64]) -> u64 {
        // Rounded: however an angle was computed, the verdict is the same.
        values.iter().fold(seed ^ 0x9e37_79b9_7f4a_7c15, |hash, value| {
            let hash = (hash ^ ((value * 1e6).round() as i64 as u64)).wrapping_mul(0xff51_afd7_ed55_8ccd);
            hash ^ hash >> 32
        })
    }

    fn allows(&self, hash: u64) -> bool {
        (hash.wrapping_mul(0xc4ce_b9fe_1a85_ec53) >> 11) as f64 / (1_u64 << 53) as f64 >= self.share
    }
}

impl Clearance for Arbitrary {
    fn turn(&self, pair: &Pair, from: [f64; 2], to: [f64; 2]) -> bool {
        let offset = pair.offset;
        self.allows(Self::hash(offset as u64, &[from[0], from[1], to[0], to[1]]))
    }

    fn swim(&self, pair: &Pair, i: Swing, j: Swing) -> bool {
        let offset = pair.offset;
        // The same segment from either end.
        if i.amplitude_rad == 0.0 || j.amplitude_rad == 0.0 {
            // What one at rest asks of the other does not depend on signs; the cycle as given is clear.
            return true;
        }
        let [i_neg, j_neg] = [i, j].map(|swing| swing.centerline_rad - swing.amplitude_rad);
        let ends = [[i.start_rad(), j.start_rad()], [i_neg, j_neg]];
        self.allows(ends.iter().fold(7, |sum: u64, end| sum.wrapping_add(Self::hash(offset as u64, end))))
    }
}

/// Clearance by the tails themselves.
struct Exact(DistanceToCollision);

impl Clearance for Exact {
    fn turn(&self, pair: &Pair, from: [f64; 2], to: [f64; 2]) -> bool {
        let offset = pair.offset;
        self.0.clear(offset, from, to, 0.0)
    }

    fn swim(&self, pair: &Pair, i: Swing, j: Swing) -> bool {
        self.0.swim(pair.offset, i, j) >= 0.0
    }
}

impl Exact {
    fn new() -> Self {
        let distance = DistanceToCollision::new(&Parameters::default());
        assert_eq!(distance.offsets(), [[1, 0], [0, 1]], "the offsets of grid()");
        Self(distance)
    }
}

fn grid(columns: usize, rows: usize) -> Pairs {
    let mut list = Vec::new();
    for i in 0..columns * rows {
        if i % columns + 1 < columns {
            list.push(Pair { i, j: i + 1, offset: 0 });
        }
        if i + columns < columns * rows {
            list.push(Pair { i, j: i + columns, offset: 1 });
        }
    }
    Pairs::new(columns * rows, list)
}

/// Everything a case needs to own.
struct Case {
    pairs: Pairs,
    from: Vec<f64>,
    cycle: Vec<Swing>,
    limit: f64,
    stranded: bool,
}

impl Case {
    fn problem(&self) -> Problem<'_> {
        Problem {
            pairs: &self.pairs,
            from_rad: &self.from,
            cycle: &self.cycle,
            limit_rad: self.limit,
            stranded: self.stranded,
        }
    }

    /// Tails and cycles that are clear of each other (as far as `clear` says, once each can be placed).
    fn new(columns: usize, rows: usize, rng: &mut ChaCha8Rng, clear: Option<&Exact>) -> Self {
        let pairs = grid(columns, rows);
        let swing = |rng: &mut ChaCha8Rng| Swing {
            centerline_rad: rng.random_range(-PI..PI),
            amplitude_rad: rng.random_range(0.9..2.6) * [1.0, -1.0, 1.0, -1.0, 0.0][rng.random_range(0..5)],
        };
        let (mut from, mut cycle): (Vec<f64>, Vec<Swing>) = (Vec::new(), Vec::new());
        while from.len() < pairs.modules() {
            let module = from.len();
            let placed = (0..300).find_map(|_| {
                let (pose, swing) = (rng.random_range(-9.0..9.0), swing(rng));
                let before = pairs.of(module).iter().map(|&index| pairs.all()[index]);
                let free = before.filter(|pair| pair.j == module).all(|pair| {
                    let rest = [from[pair.i], pose];
                    clear.is_none_or(|clear| {
                        clear.turn(&pair, rest, rest) && clear.swim(&pair, cycle[pair.i], swing)
                    })
                });
                free.then_some((pose, swing))
            });
            match placed {
                Some((pose, swing)) => {
                    from.push(pose);
                    cycle.push(swing);
                }
                None => {
                    from.clear();
                    cycle.clear();
                }
            }
        }
        // Sometimes a tail is there already, turns away.
        if rng.random_bool(0.3) {
            from[0] = cycle[0].start_rad() + TAU;
        }
        let limit = [4.0, 6.3, 6.5][rng.random_range(0..3)];
        Self { pairs, from, cycle, limit, stranded: rng.random_bool(0.2) }
    }
}

/// A module's way as poses gone through, whether its amplitude is negated, and the travel.
#[derive(Clone)]
struct Path {
    poses: Vec<f64>,
    negated: bool,
    travel: f64,
}

/// The unwrapped poses that are ≡ `to` at most one turn from `from`.
fn reachable(from: f64, to: f64, limit: f64) -> Vec<f64> {
    let ahead = (to - from).rem_euclid(TAU);
    if !(1e-9..=TAU - 1e-9).contains(&ahead) {
        return vec![from];
    }
    [from + ahead, from + ahead - TAU].into_iter().filter(|end| (end - from).abs() <= limit).collect()
}

/// The least travel by trying every combination, module by module.
fn brute_force(case: &Case, paths: &[Vec<Path>], clear: &impl Clearance) -> Option<f64> {
    let along = |pair: &Pair, i: &[f64], j: &[f64]| {
        (1..i.len()).all(|k| clear.turn(pair, [i[k - 1], j[k - 1]], [i[k], j[k]]))
    };
    let goes = |pair: &Pair, i: &Path, j: &Path| {
        let stay = |path: &Path| vec![path.poses[0]; path.poses.len()];
        let signed = |module: usize, path: &Path| {
            let Swing { centerline_rad, amplitude_rad } = case.cycle[module];
            let amplitude_rad = if path.negated { -amplitude_rad } else { amplitude_rad };
            Swing { centerline_rad, amplitude_rad }
        };
        along(pair, &i.poses, &j.poses)
            && (!case.stranded || along(pair, &i.poses, &stay(j)) && along(pair, &stay(i), &j.poses))
            && (i.negated == j.negated || clear.swim(pair, signed(pair.i, i), signed(pair.j, j)))
    };
    let mut open = vec![(0.0, Vec::<usize>::new())];
    let mut least: Option<f64> = None;
    while let Some((travel, chosen)) = open.pop() {
        let module = chosen.len();
        if module == paths.len() {
            least = Some(least.map_or(travel, |least| least.min(travel)));
            continue;
        }
        for (number, path) in paths[module].iter().enumerate() {
            let agrees = case.pairs.all().iter().filter(|pair| pair.j == module).all(|pair| {
                assert!(pair.i < module);
                goes(pair, &paths[pair.i][chosen[pair.i]], path)
            });
            if agrees {
                let mut chosen = chosen.clone();
                chosen.push(number);
                open.push((travel + path.travel, chosen));
            }
        }
    }
    least
}

fn one_step_paths(case: &Case, signs: &[bool]) -> Vec<Vec<Path>> {
    let of = |(from, swing): (&f64, &Swing)| {
        let ends = |&negated: &bool| {
            let amplitude = if negated { -swing.amplitude_rad } else { swing.amplitude_rad };
            let ends = reachable(*from, swing.centerline_rad + amplitude, case.limit);
            ends.into_iter().map(move |end| Path {
                poses: vec![*from, end],
                negated,
                travel: (end - from).abs(),
            })
        };
        signs.iter().flat_map(ends).collect()
    };
    case.from.iter().zip(&case.cycle).map(of).collect()
}

fn two_step_paths(case: &Case, via: &[f64]) -> Vec<Vec<Path>> {
    let of = |(from, swing): (&f64, &Swing)| {
        let (from, to) = (*from, swing.start_rad());
        let mut paths = Vec::new();
        let differs = |a: f64, b: f64| ((a - b) / TAU - ((a - b) / TAU).round()).abs() > 1e-9;
        let others = via.iter().copied().filter(|&pose| differs(pose, from) && differs(pose, to));
        for middle in reachable(from, to, case.limit)
            .into_iter()
            .chain([from])
            .chain(others.flat_map(|pose| reachable(from, pose, case.limit)))
        {
            for end in reachable(middle, to, case.limit) {
                let travel = (middle - from).abs() + (end - middle).abs();
                paths.push(Path { poses: vec![from, middle, end], negated: false, travel });
            }
        }
        paths
    };
    case.from.iter().zip(&case.cycle).map(of).collect()
}

/// Same feasibility, same least travel, and the answer does what it says. True if there was one.
fn agrees(
    case: &Case,
    answer: Option<Least>,
    paths: &[Vec<Path>],
    clear: &impl Clearance,
    name: &str,
) -> bool {
    let least = brute_force(case, paths, clear);
    assert_eq!(answer.is_some(), least.is_some(), "{name}");
    let (Some(answer), Some(least)) = (answer, least) else { return false };
    assert!((answer.travel_rad - least).abs() < 1e-9, "{name}: {} {least}", answer.travel_rad);
    assert!((answer.bound_rad - least).abs() < 1e-9, "{name}: not proved");
    let steps = paths[0][0].poses.len() - 1;
    let taken: Vec<Vec<Path>> = (0..case.from.len())
        .map(|module| {
            let (turn, negated) = (answer.turns[module], answer.negated[module]);
            let mut poses = vec![turn.from_rad, turn.to_rad];
            if let Some(via) = answer.via_rad {
                poses.insert(1, via[module]);
            }
            assert_eq!(poses.len(), steps + 1, "{name}");
            assert!(poses.windows(2).all(|ends| (ends[1] - ends[0]).abs() <= case.limit + 1e-8), "{name}");
            let sign = if negated { -1.0 } else { 1.0 };
            let to = case.cycle[module].centerline_rad + sign * case.cycle[module].amplitude_rad;
            assert!(
                ((turn.to_rad - to) / TAU).rem_euclid(1.0).min(((to - turn.to_rad) / TAU).rem_euclid(1.0))
                    < 1e-9
            );
            let travel = poses.windows(2).map(|ends| (ends[1] - ends[0]).abs()).sum();
            vec![Path { poses, negated, travel }]
        })
        .collect();
    let travel = brute_force(case, &taken, clear).unwrap_or(f64::NAN);
    assert!(
        (travel - answer.travel_rad).abs() < 1e-9,
        "{name}: what was answered collides or travels {travel}"
    );
    true
}

const SHAPES: [(usize, usize); 10] =
    [(2, 1), (1, 2), (3, 1), (2, 2), (3, 2), (1, 6), (4, 2), (3, 3), (5, 2), (10, 1)];

fn shape(seed: u64, most: usize) -> (usize, usize) {
    let fits: Vec<_> = SHAPES.into_iter().filter(|(columns, rows)| columns * rows <= most).collect();
    fits[seed as usize % fits.len()]
}

#[test]
fn one_step_is_as_good_as_trying_everything() {
    let (mut solver, exact, mut found) = (Solver::default(), Exact::new(), [[0; 2]; 2]);
    for seed in 0..6000 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let geometry = seed % 3 == 0;
        let (columns, rows) = shape(seed, 10);
        let case = Case::new(columns, rows, &mut rng, geometry.then_some(&exact));
        let (signs, sign) = [(Signs::Given, false), (Signs::Negated, true)][seed as usize / 3 % 2];
        let (paths, name) = (one_step_paths(&case, &[sign]), format!("seed {seed}"));
        let there = if geometry {
            agrees(&case, solver.one_step(&case.problem(), signs, &exact), &paths, &exact, &name)
        } else {
            let clear = Arbitrary { share: rng.random_range(0.0..0.8) };
            agrees(&case, solver.one_step(&case.problem(), signs, &clear), &paths, &clear, &name)
        };
        found[usize::from(geometry)][usize::from(there)] += 1;
    }
    eprintln!("one step, [without, with] a transition: verdicts {:?}, geometry {:?}", found[0], found[1]);
    assert!(found.as_flattened().iter().all(|&count| count > 100), "{found:?}");
}

#[test]
fn signs_by_module_are_as_good_as_trying_everything() {
    let (mut solver, exact, mut found) = (Solver::default(), Exact::new(), [[0; 2]; 2]);
    let mut mixed = 0;
    for seed in 0..2500 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let geometry = seed % 3 == 0;
        let (columns, rows) = shape(seed, 6);
        let case = Case::new(columns, rows, &mut rng, geometry.then_some(&exact));
        let (paths, name) = (one_step_paths(&case, &[false, true]), format!("seed {seed}"));
        let clear = Arbitrary { share: rng.random_range(0.2..0.8) };
        let answer = if geometry {
            solver.one_step(&case.problem(), Signs::PerModule, &exact)
        } else {
            solver.one_step(&case.problem(), Signs::PerModule, &clear)
        };
        mixed += usize::from(answer.is_some_and(|a| a.negated.windows(2).any(|pair| pair[0] != pair[1])));
        let there = if geometry {
            agrees(&case, answer, &paths, &exact, &name)
        } else {
            agrees(&case, answer, &paths, &clear, &name)
        };
        found[usize::from(geometry)][usize::from(there)] += 1;
    }
    eprintln!("signs by module: verdicts {:?}, geometry {:?}, {mixed} mixed", found[0], found[1]);
    assert!(found[0][0] > 100 && found[0][1] > 100 && found[1][1] > 100 && mixed > 100, "{found:?} {mixed}");
}

#[test]
fn two_steps_are_as_good_as_trying_everything() {
    let (mut solver, exact, mut found) = (Solver::default(), Exact::new(), [[0; 2]; 2]);
    for seed in 0..2000 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let geometry = seed % 3 == 0;
        let (columns, rows) = shape(seed, 4);
        let case = Case::new(columns, rows, &mut rng, geometry.then_some(&exact));
        // At most three: 4 + 3·4 ways.
        let via = &[PI / 4.0, -3.0 * PI / 4.0, 2.0][..rng.random_range(0..=3)];
        let (paths, name) = (two_step_paths(&case, via), format!("seed {seed}"));
        let there = if geometry {
            agrees(&case, solver.two_steps(&case.problem(), |_| via, &exact), &paths, &exact, &name)
        } else {
            let clear = Arbitrary { share: rng.random_range(0.3..0.9) };
            agrees(&case, solver.two_steps(&case.problem(), |_| via, &clear), &paths, &clear, &name)
        };
        found[usize::from(geometry)][usize::from(there)] += 1;
    }
    eprintln!("two steps, [without, with] a transition: verdicts {:?}, geometry {:?}", found[0], found[1]);
    assert!(found[0][0] > 100 && found[0][1] > 100 && found[1][1] > 100, "{found:?}");
}

/// With no tables and no search to speak of: what has a transition with one sign for all gets one, and the bound holds
/// against a solver that may spend what it needs.
#[test]
fn short_of_everything_there_is_still_an_answer() {
    let (mut solver, mut full) = (Solver::new(Limits { entries: 0, nodes: 0 }), Solver::default());
    let (mut open, mut uniform) = (0, 0);
    for seed in 0..600 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let side = [3, 5, 7][seed as usize % 3];
        let case = Case::new(side, side, &mut rng, None);
        let clear = Arbitrary { share: rng.random_range(0.1..0.6) };
        let problem = case.problem();
        let one_sign = [Signs::Given, Signs::Negated]
            .into_iter()
            .filter_map(|signs| full.one_step(&problem, signs, &clear).map(|least| least.travel_rad))
            .min_by(f64::total_cmp);
        let least = full.one_step(&problem, Signs::PerModule, &clear);
        let Some(answer) = solver.one_step(&problem, Signs::PerModule, &clear) else {
            assert!(one_sign.is_none(), "seed {seed}");
            continue;
        };
        let (travel, bound) = (answer.travel_rad, answer.bound_rad);
        let least = least.expect("one was found");
        let honest = bound <= least.travel_rad + 1e-9 && least.bound_rad <= travel + 1e-9;
        assert!(honest, "seed {seed}: {bound} {least:?} {travel}");
        open += usize::from(travel > bound + 1e-9);
        uniform += usize::from(one_sign.is_some());
    }
    assert!(
        open > 50 && uniform > 50,
        "{open} not proved: the limits must bite; {uniform} with one sign for all"
    );
}

/// Between rest poses on the diagonals, two steps and the colours of a chessboard are always enough; survivable ones too.
#[test]
fn diagonal_rest_poses_are_never_stuck() {
    let (mut solver, exact) = (Solver::default(), Exact::new());
    let diagonal = |rng: &mut ChaCha8Rng| PI / 4.0 + PI / 2.0 * f64::from(rng.random_range(-4..4));
    let mut one_step = 0;
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let side = [2, 3, 5, 8, 16, 32][seed as usize % 6];
        let pairs = grid(side, side);
        let from: Vec<f64> = (0..side * side).map(|_| diagonal(&mut rng)).collect();
        let cycle: Vec<Swing> = (0..side * side)
            .map(|_| {
                let amplitude_rad = rng.random_range(0.9..2.6);
                Swing { centerline_rad: diagonal(&mut rng) - amplitude_rad, amplitude_rad }
            })
            .collect();
        let case = Case { pairs, from, cycle, limit: 6.5, stranded: true };
        one_step += usize::from(solver.one_step(&case.problem(), Signs::Given, &exact).is_some());
        let least = solver.two_steps(&case.problem(), |_| &[], &exact);
        assert!(least.is_some(), "seed {seed}: {side} × {side}");
    }
    eprintln!("{one_step} of 60 in one step");
    assert!(one_step < 60);
}
