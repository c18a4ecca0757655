//! The transition solver from 9 to 1,024 modules, between random cycles that have nothing to do with each other.

use std::f64::consts::{FRAC_PI_4, PI};
use std::hint::black_box;

use criterion::Criterion;
use modboat::distance::DistanceToCollision;
use modboat::motion::Swing;
use modboat::pairs::{Pair, Pairs};
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use modboat::transition::solver::{Clearance, Problem, Signs, Solver};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Cycles that a bench goes through in turn.
const CYCLES: usize = 33;
/// Random cycles tried for a module before it rests on a diagonal, out of reach.
const TRIES: usize = 60;

/// Clearance by the collision regions.
struct Regions(DistanceToCollision);

impl Clearance for Regions {
    fn turn(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        let offset = pair.offset;
        self.0.clear(offset, from_rad, to_rad, 0.0)
    }

    fn swim(&self, pair: &Pair, i: Swing, j: Swing) -> bool {
        let offset = pair.offset;
        let to_rad = [i, j].map(|swing| swing.centerline_rad - swing.amplitude_rad);
        self.0.clear(offset, [i.start_rad(), j.start_rad()], to_rad, 0.0)
    }
}

/// A random cycle without collisions, module by module.
fn cycle(pairs: &Pairs, clear: &Regions, rng: &mut ChaCha8Rng) -> Vec<Swing> {
    let mut cycle: Vec<Swing> = Vec::new();
    for module in 0..pairs.modules() {
        let mut random = || {
            let swing = Swing {
                centerline_rad: rng.random_range(-PI..PI),
                amplitude_rad: rng.random_range(0.9..2.6) * if rng.random_bool(0.5) { 1.0 } else { -1.0 },
            };
            let mut placed = pairs.of(module).iter().map(|&index| pairs.all()[index]);
            let free = placed.all(|pair| match cycle.get(pair.other(module)) {
                None => true,
                Some(&other) if pair.i == module => clear.swim(&pair, swing, other),
                Some(&other) => clear.swim(&pair, other, swing),
            });
            free.then_some(swing)
        };
        let swing = (0..TRIES).find_map(|_| random());
        cycle.push(swing.unwrap_or(Swing { centerline_rad: FRAC_PI_4, amplitude_rad: 0.0 }));
    }
    cycle
}

/// One step with the signs as given, with signs by module, and two steps; collision checks included.
pub fn solver(criterion: &mut Criterion) {
    let parameters = Parameters::default();
    let clear = Regions(DistanceToCollision::new(&parameters));
    let limit_rad = parameters.tail_speed_max_rad_s * parameters.transition_s;
    let mut group = criterion.benchmark_group("transition solver");
    for shape in ["3x3", "5x5", "10x10", "32x32"] {
        let structure = Structure::from_word(shape).expect(shape);
        let pairs = clear.0.offsets().iter().enumerate().flat_map(|(offset, &cells)| {
            structure.neighbours(cells).map(move |(i, j)| Pair { i, j, offset })
        });
        let pairs = Pairs::new(structure.len(), pairs);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let cycles: Vec<Vec<Swing>> = (0..CYCLES).map(|_| cycle(&pairs, &clear, &mut rng)).collect();
        let tails: Vec<Vec<f64>> =
            cycles.iter().map(|cycle| cycle.iter().map(|swing| swing.start_rad()).collect()).collect();
        let mut solver = Solver::default();
        for name in ["as given", "signs by module", "two steps"] {
            let mut turn = (0..CYCLES - 1).cycle();
            group.bench_function(format!("{} modules, {name}", structure.len()), |b| {
                b.iter(|| {
                    let k = turn.next()?;
                    let problem = Problem {
                        pairs: &pairs,
                        from_rad: &tails[k],
                        cycle: &cycles[k + 1],
                        limit_rad,
                        stranded: false,
                    };
                    let least = match name {
                        "as given" => solver.one_step(&problem, Signs::Given, &clear),
                        "signs by module" => solver.one_step(&problem, Signs::PerModule, &clear),
                        _ => solver.two_steps(&problem, |_| &[], &clear),
                    };
                    black_box(least.map(|least| least.travel_rad))
                });
            });
        }
    }
    group.finish();
}
