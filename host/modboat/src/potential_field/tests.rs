use super::*;
use crate::distance::DistanceToCollision;
use crate::pairs::Pair;
use crate::structure::Structure;

/// A structure with all that a search for it needs.
struct Setup {
    parameters: Parameters,
    config: PlannerConfig,
    positions_m: Vec<[f64; 2]>,
    distance: DistanceToCollision,
    field: PotentialField,
}

impl Setup {
    fn new(word: &str) -> Self {
        let (parameters, config) = (Parameters::default(), PlannerConfig::default());
        let structure = Structure::from_word(word).expect(word);
        let distance = DistanceToCollision::new(&parameters);
        let list = distance.offsets().iter().enumerate().flat_map(|(offset, &cells)| {
            let pairs: Vec<_> = structure.neighbours(cells).map(|(i, j)| Pair { i, j, offset }).collect();
            pairs
        });
        let pairs = Pairs::new(structure.len(), list);
        let positions_m = structure.positions_m(parameters.pitch_m);
        let field = PotentialField::new(structure.cells(), &positions_m, &pairs, &parameters, &config);
        Self { parameters, config, positions_m, distance, field }
    }

    fn solve(&mut self, demand: Wrench, previous: Option<&[Swing]>) -> Vec<Candidate> {
        let distance = &self.distance;
        let swim = |offset: usize, i: Swing, j: Swing, _margin_rad: f64| distance.swim(offset, i, j);
        self.field.solve(demand, previous, &swim).to_vec()
    }

    /// ‖w∘(F_des − F)‖, N, with (2) and (7) written out once more.
    fn error_n(&self, demand: Wrench, cycle: &[Swing]) -> f64 {
        let mut error = demand.to_array();
        for (swing, [x, y]) in cycle.iter().zip(&self.positions_m) {
            let f = 0.022 * swing.amplitude_rad.abs() - 0.019;
            let (fx, fy) = (-f * swing.centerline_rad.cos(), -f * swing.centerline_rad.sin());
            error[0] -= fx;
            error[1] -= fy;
            error[2] -= x * fy - y * fx;
        }
        (error[0].powi(2) + error[1].powi(2) + (10.0 * error[2]).powi(2)).sqrt()
    }

    /// Least distance between any two tails' surfaces at 400 instants of the cycle: points along each centre line.
    fn sampled_clearance_m(&self, cycle: &[Swing]) -> f64 {
        let mut least = f64::INFINITY;
        for k in 0..400 {
            let phase = PI * f64::from(k) / 399.0;
            let tips: Vec<[f64; 2]> = cycle
                .iter()
                .map(|s| {
                    let phi = s.centerline_rad + s.amplitude_rad * phase.cos();
                    [0.09 * phi.cos(), 0.09 * phi.sin()]
                })
                .collect();
            for i in 0..cycle.len() {
                for j in 0..i {
                    let [a, b] = [self.positions_m[i], self.positions_m[j]];
                    if (a[0] - b[0]).hypot(a[1] - b[1]) > 0.22 {
                        continue;
                    }
                    for m in 0..=20 {
                        let share = f64::from(m) / 20.0;
                        let point = [a[0] + share * tips[i][0] - b[0], a[1] + share * tips[i][1] - b[1]];
                        let along =
                            ((point[0] * tips[j][0] + point[1] * tips[j][1]) / (0.09 * 0.09)).clamp(0.0, 1.0);
                        let apart = (point[0] - along * tips[j][0]).hypot(point[1] - along * tips[j][1]);
                        least = least.min(apart - 0.015);
                    }
                }
            }
        }
        least
    }
}

/// A demand that a known set of thrusts yields, each of at most `share` of the greatest: certainly in the envelope.
fn feasible(setup: &Setup, share: f64, rng: &mut ChaCha8Rng) -> Wrench {
    let thrust_max_n = setup.parameters.thrust_n(setup.parameters.amplitude_max_rad);
    setup.positions_m.iter().fold(Wrench::default(), |sum, [x, y]| {
        let (f, angle) = (share * thrust_max_n * rng.random_range(0.3..1.0_f64), rng.random_range(-PI..PI));
        let (fx, fy) = (f * angle.cos(), f * angle.sin());
        sum + Wrench { fx_n: fx, fy_n: fy, tau_nm: x * fy - y * fx }
    })
}

#[test]
fn demands_are_met_without_a_collision() {
    for word in ["3x1", "2x2", "3x3"] {
        let mut setup = Setup::new(word);
        let mut previous: Option<Vec<Swing>> = None;
        for seed in 0..60 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let demand = feasible(&setup, 0.6, &mut rng);
            let candidates = setup.solve(demand, previous.as_deref());
            let best = candidates.first().unwrap_or_else(|| panic!("{word}, seed {seed}: nothing found"));
            let relative = best.error_n / demand.weighted_norm(setup.config.weights).max(0.004);
            assert!(relative < 0.05, "{word}, seed {seed}: error {relative}");
            for candidate in &candidates {
                let error_n = setup.error_n(demand, &candidate.cycle);
                assert!((error_n - candidate.error_n).abs() < 1e-9, "{word}, seed {seed}");
                let clearance_m = setup.sampled_clearance_m(&candidate.cycle);
                assert!(clearance_m > 0.01, "{word}, seed {seed}: {clearance_m} m");
                for swing in &candidate.cycle {
                    assert!((0.9..=2.6).contains(&swing.amplitude_rad.abs()), "{word}, seed {seed}");
                    assert!(swing.centerline_rad.abs() <= PI, "{word}, seed {seed}");
                }
            }
            previous = Some(best.cycle.clone());
        }
    }
}

#[test]
fn beyond_the_envelope_the_nearest_is_found() {
    // Sway of three in a row reaches 3·F(2.6) = 0.1146 N, at all tails along x; twice that leaves an error of ½.
    let mut setup = Setup::new("3x1");
    let demand = Wrench { fx_n: 2.0 * 3.0 * (0.022 * 2.6 - 0.019), ..Default::default() };
    let best = &setup.solve(demand, None)[0];
    assert!((best.error_n / demand.fx_n - 0.5).abs() < 0.005, "{best:?}");
}

#[test]
fn candidates_are_distinct_and_in_order() {
    let mut setup = Setup::new("2x2");
    let demand = feasible(&setup, 0.5, &mut ChaCha8Rng::seed_from_u64(3));
    let candidates = setup.solve(demand, None);
    assert!(candidates.len() == setup.config.candidates, "{}", candidates.len());
    assert!(candidates.is_sorted_by(|a, b| a.error_n <= b.error_n));
    for (k, a) in candidates.iter().enumerate() {
        for b in &candidates[..k] {
            let apart = a.cycle.iter().zip(&b.cycle).any(|(a, b)| {
                wrap_rad(a.centerline_rad - b.centerline_rad).abs() >= DISTINCT_RAD
                    || (a.amplitude_rad - b.amplitude_rad).abs() >= DISTINCT_RAD
            });
            assert!(apart, "{a:?} {b:?}");
        }
    }
}

#[test]
fn the_same_input_gives_the_same_answer() {
    let (mut one, mut other) = (Setup::new("3x1"), Setup::new("3x1"));
    let demand = Wrench { fx_n: 0.01, fy_n: 0.02, tau_nm: -0.001 };
    let first = one.solve(demand, None);
    one.solve(Wrench { fx_n: -0.03, ..Default::default() }, Some(&first[0].cycle));
    assert_eq!(one.solve(demand, None), first, "what was solved in between must not matter");
    assert_eq!(other.solve(demand, None), first);
}

#[test]
fn bounds_spare_questions_and_change_nothing() {
    let asked = std::cell::Cell::new([0_u32; 2]);
    for word in ["3x1", "3x3"] {
        let mut setup = Setup::new(word);
        for seed in 0..20 {
            let demand = feasible(&setup, 0.8, &mut ChaCha8Rng::seed_from_u64(seed));
            let distance = setup.distance.clone();
            // Told no more than the margin, the search has nothing to spare and must ask each time.
            let [all, some] = [0, 1].map(|most: usize| {
                let swim = |offset: usize, i: Swing, j: Swing, margin_rad: f64| {
                    let mut count = asked.get();
                    count[most] += 1;
                    asked.set(count);
                    let doc_rad = distance.swim(offset, i, j);
                    if most == 0 { doc_rad.min(margin_rad) } else { doc_rad }
                };
                setup.field.solve(demand, None, &swim).to_vec()
            });
            assert_eq!(all, some, "{word}, seed {seed}");
        }
    }
    let [all, some] = asked.get();
    assert!(2 * some < all, "{some} of {all} questions");
}

#[test]
fn a_cycle_that_still_meets_the_demand_is_kept() {
    let mut setup = Setup::new("3x3");
    let demand = feasible(&setup, 0.5, &mut ChaCha8Rng::seed_from_u64(11));
    let before = setup.solve(demand, None)[0].cycle.clone();
    assert!(setup.solve(demand, Some(&before)).iter().any(|c| c.cycle == before));
}
