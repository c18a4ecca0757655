use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::allocation::Met;
use super::approach;
use super::asked::Asked;
use super::neighbours::Rules;
use super::search::Search;
use super::*;
use crate::buffers::Buffers;
use crate::distance::DistanceToCollision;
use crate::parameters::Parameters;
use crate::planner_config::PlannerConfig;
use crate::reason::Reason;
use crate::structure::Structure;
use crate::transition::solver::{Signs, Solver};
use quantity::wrap_rad;

fn setting(word: &str, parameters: &Parameters, config: &PlannerConfig) -> Setting {
    let structure = match word {
        "ring" => Structure::from_picture("###\n#.#\n###"),
        word => Structure::from_word(word),
    };
    let distance = Arc::new(DistanceToCollision::new(parameters));
    Setting::new(&structure.expect(word), parameters, config, distance)
}

impl ExactPlanner {
    fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let mut plan = Plan::default();
        self.plan_into(demand, tails, previous.map(Previous::cycle), &mut plan);
        plan
    }
}

fn planner(word: &str, config: &PlannerConfig) -> ExactPlanner {
    ExactPlanner::new(setting(word, &Parameters::default(), config))
}

/// A wrench in a random direction, a `share` of the way to the envelope's border.
fn demand(planner: &ExactPlanner, share: f64, rng: &mut ChaCha8Rng) -> Wrench {
    let direction = Wrench {
        fx_n: rng.random_range(-1.0..1.0),
        fy_n: rng.random_range(-1.0..1.0),
        tau_nm: 0.1 * rng.random_range(-1.0..1.0),
    };
    Wrench::from_array(planner.envelope.boundary(direction).to_array().map(|component| share * component))
}

fn ends(plan: &Plan) -> Vec<f64> {
    match &plan.transition {
        Some(turns) => turns.iter().map(|turn| turn.to_rad).collect(),
        None => plan.cycle.iter().map(|swing| swing.start_rad()).collect(),
    }
}

#[test]
fn free_poses_are_out_of_reach_and_no_others() {
    for (word, parameters) in [
        ("3x3", Parameters::default()),
        ("ring", Parameters::default()),
        ("4x2", Parameters { tail_length_m: 0.102, ..Parameters::default() }),
    ] {
        let setting = setting(word, &parameters, &PlannerConfig::default());
        let rest = rest::RestPoses::new(&setting);
        let (tail, offsets) = (setting.distance.tail(), setting.distance.offsets());
        let tracking_rad = parameters.tracking_error_rad;
        // Least clearance of a tail at rest, anywhere within its error, to any neighbour at any angle.
        let least_m = |module: usize, pose_rad: f64| {
            let pairs = setting.pairs.of(module).iter().map(|&index| setting.pairs.all()[index]);
            pairs.fold(f64::INFINITY, |least: f64, pair| {
                (0..1440).fold(least, |least, k| {
                    let other_rad = f64::from(k) * PI / 720.0;
                    [-tracking_rad, 0.0, tracking_rad].iter().fold(least, |least, off_rad| {
                        let own_rad = pose_rad + off_rad;
                        let (i, j) =
                            if pair.i == module { (own_rad, other_rad) } else { (other_rad, own_rad) };
                        least.min(tail.clearance_m(offsets[pair.offset], i, j))
                    })
                })
            })
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for module in 0..setting.cells.len() {
            for &station_rad in rest.stations_rad(module) {
                assert!(!rest.has_free(module) || rest.is_free(module, station_rad), "{word} {module}");
            }
            for _ in 0..50 {
                let pose_rad = rng.random_range(-7.0..7.0);
                let clear_m = least_m(module, pose_rad);
                // Sampled every quarter of a degree, a clearance may come out too large by what a tip moves in half of one.
                if rest.is_free(module, pose_rad) {
                    assert!(clear_m >= -1e-9, "{word} {module} at {pose_rad}: {clear_m} m");
                    let [back, on] = rest.room_rad(module, pose_rad);
                    assert!(back <= 0.0 && on >= 0.0);
                    // At the end of its arc it is still there after a thousand turns either way.
                    for turned_rad in [pose_rad + back, pose_rad + on] {
                        for turns in [-1000.0, -1.0, 0.0, 1.0, 1000.0] {
                            let end_rad = turned_rad + turns * TAU;
                            assert!(
                                rest.may_stay(module, end_rad),
                                "{word} {module} at {pose_rad}: {end_rad}"
                            );
                        }
                    }
                } else {
                    assert!(clear_m < 4e-4, "{word} {module} at {pose_rad}: {clear_m} m");
                }
            }
        }
    }
    // In the middle of a lattice the diagonals are left, and with long tails nothing.
    let middle = |parameters: &Parameters| {
        let rest = rest::RestPoses::new(&setting("3x3", parameters, &PlannerConfig::default()));
        let diagonals = [1.0, 3.0, -3.0, -1.0].map(|k| rest.is_free(4, k * PI / 4.0));
        (rest.arcs(4).len(), diagonals.iter().filter(|free| **free).count(), rest.stations_rad(4).len())
    };
    assert_eq!(middle(&Parameters::default()), (4, 4, 4));
    assert_eq!(middle(&Parameters { tail_length_m: 0.102, ..Parameters::default() }), (0, 0, 4));
}

#[test]
fn the_spirals_are_law_seven_turned_to_the_rest_pose() {
    let parameters = Parameters::default();
    let law = law::Law::new(&parameters);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..500 {
        let (rest_rad, magnitude): (f64, f64) = (rng.random_range(-9.0..9.0), rng.random_range(0.9..2.6));
        let amplitude_rad = if rng.random_bool(0.5) { magnitude } else { -magnitude };
        let cycle = neighbours::Cycle { rest_rad, amplitude_rad, ..Default::default() };
        assert!((cycle.swing().start_rad() - rest_rad).abs() < 1e-12);
        let wrench = cycle.swing().wrench(&parameters, [0.0, 0.0]);
        let law::Push { thrust_n: [fx_n, fy_n], by_amplitude } = law.push(rest_rad, amplitude_rad);
        assert!((fx_n - wrench.fx_n).hypot(fy_n - wrench.fy_n) < 1e-15);
        let step = 1e-6;
        let [after, before] = [step, -step].map(|step| law.push(rest_rad, amplitude_rad + step).thrust_n);
        for k in 0..2 {
            assert!(((after[k] - before[k]) / (2.0 * step) - by_amplitude[k]).abs() < 1e-9);
        }
        // In the frame of the rest pose it is u₀.
        let ([x, y], (sin, cos)) = (law.thrust_n(amplitude_rad), rest_rad.sin_cos());
        assert!((cos * x - sin * y - fx_n).hypot(sin * x + cos * y - fy_n) < 1e-15);
        // Nothing pushes further than the support function says, but for its steps of a degree and a half.
        let off_rad: f64 = rng.random_range(-9.0..9.0);
        let [x, y] = law.thrust_n(amplitude_rad);
        assert!(x * off_rad.cos() + y * off_rad.sin() <= law.support_n(law::Sign::Any, off_rad) + 1e-3);
    }
}

#[test]
fn an_allocation_meets_the_demand_by_law_seven_within_its_limits() {
    for word in ["4x2", "ring"] {
        let setting = setting(word, &Parameters::default(), &PlannerConfig::default());
        let mut search = Search::new(&setting);
        let mut met = 0;
        for seed in 0..60 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let wanted = Wrench {
                fx_n: rng.random_range(-0.02..0.02),
                fy_n: rng.random_range(-0.02..0.02),
                tau_nm: rng.random_range(-0.001..0.001),
            };
            let aim = search.aim(&setting, wanted);
            let rules = Rules { case: setting.as_configured(), loss_tolerant: true };
            let Search { rest, law, allocation, order, .. } = &mut search;
            allocation
                .begin((0..order.len()).map(|module| rest.cycle(module, rest.stations_rad(module)[0], 0.0)));
            allocation.descend(&rules, rest, law, &aim, allocation::Poses::Kept, order, 0);
            let polished = allocation.polish(&rules, rest, law, &aim) == Met::Yes;
            met += u32::from(polished);
            assert!(allocation.allowed(&rules, law), "{word}, seed {seed}");
            let cycle: Vec<Swing> = allocation.cycles.iter().map(|cycle| cycle.swing()).collect();
            let error = setting.error(wanted, setting.wrench(&cycle));
            assert_eq!(polished, error <= 1e-9, "{word}, seed {seed}: {error}");
        }
        assert!(met > 10, "{word}: {met}");
    }
}

#[test]
fn orientation_raises_the_margin_which_never_passes_what_the_envelope_leaves() {
    for word in ["3x1", "3x3", "ring"] {
        let planner = planner(word, &PlannerConfig::default());
        let mut search = Search::new(&planner.setting);
        let (mut raised, runs) = (0, 40);
        for seed in 0..runs {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let wanted = demand(&planner, 0.5, &mut rng).to_array();
            let Search { rest, law, orientation, order, .. } = &mut search;
            let mut poses_rad: Vec<f64> = (0..order.len())
                .map(|module| {
                    let stations = rest.stations_rad(module);
                    stations[rng.random_range(0..stations.len())]
                })
                .collect();
            let before = orientation.margin(law, poses_rad.iter().copied(), wanted);
            orientation.orient(law, rest, wanted, &mut poses_rad, order);
            let after = orientation.margin(law, poses_rad.iter().copied(), wanted);
            raised += u64::from(after >= before);
            assert!(after <= 1.0 && before <= 1.0, "{word}, seed {seed}");
            assert!((0..order.len()).all(|module| rest.is_free(module, poses_rad[module])));
        }
        // Module by module, it is not always raised where there are three.
        assert!(raised * 10 >= runs * 8, "{word}: raised in {raised} of {runs}");
    }
}

#[test]
fn between_free_poses_there_is_always_a_way() {
    for word in ["3x1", "4x4", "ring"] {
        let setting = setting(word, &Parameters::default(), &PlannerConfig::default());
        let rest = rest::RestPoses::new(&setting);
        let (mut solver, mut buffers) = (Solver::default(), Buffers::new(setting.cells.len()));
        for seed in 0..200 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut poses = || -> Vec<f64> {
                let station = |module| {
                    let stations = rest.stations_rad(module);
                    stations[rng.random_range(0..stations.len())]
                };
                (0..setting.cells.len()).map(station).collect()
            };
            let (tails, ends) = (poses(), poses());
            let rests = |&centerline_rad: &f64| Swing { centerline_rad, amplitude_rad: 0.0 };
            let mut cycle: Vec<Swing> = ends.iter().map(rests).collect();
            let asked = Asked {
                case: setting.as_configured(),
                demand: Wrench::default(),
                tails: Some(&tails),
                loss_tolerant: true,
                signs: Signs::Given,
                once: false,
                quiet: None,
            };
            let way = approach::find(&mut solver, &mut buffers, &rest, &asked, &tails, &mut cycle)
                .unwrap_or_else(|| panic!("{word}, seed {seed}: no way"));
            assert!(way.transition_s() > 0.0 || way.is_still());
            let plan = setting
                .as_configured()
                .examine(Outcome::Planned, cycle, Some(way), Some(&tails), Wrench::default(), &mut buffers)
                .unwrap_or_else(|| panic!("{word}, seed {seed}: tails touch"));
            assert!(plan.loss_tolerant, "{word}, seed {seed}");
            for (turn, end) in plan.transition.iter().flatten().zip(&ends) {
                assert!(wrap_rad(turn.to_rad - end).abs() < 1e-9, "{word}, seed {seed}");
            }
        }
    }
}

/// Streams of demands, each from where the last plan ended.
fn stream(word: &str, config: &PlannerConfig, share: f64, check: impl Fn(&str, &Plan, &[f64])) -> u32 {
    let mut planner = planner(word, config);
    let mut turned = 0;
    for seed in 0..4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut tails = vec![PI / 4.0; planner.setting.cells.len()];
        let mut previous: Option<Vec<Swing>> = None;
        for step in 0..12 {
            let wanted = demand(&planner, share, &mut rng);
            let plan = planner.plan(wanted, Some(&tails), previous.as_deref());
            let again = planner.clone().plan(wanted, Some(&tails), previous.as_deref());
            assert_eq!(plan, again, "the same input, the same plan");
            check(&format!("{word}, seed {seed}, step {step}"), &plan, &tails);
            turned += u32::from(plan.transition.is_some());
            tails = ends(&plan);
            previous = Some(plan.cycle);
        }
    }
    turned
}

#[test]
fn demands_inside_are_met_and_any_module_may_miss_them() {
    for word in ["3x1", "2x2", "ring", "4x3"] {
        stream(word, &PlannerConfig::default(), 0.5, |at, plan, _| {
            assert_eq!(plan.outcome, Outcome::Planned, "{at}");
            assert!(plan.error <= 1e-6 && plan.loss_tolerant && plan.clearance_m > 1e-3, "{at}: {plan:?}");
            assert!(plan.transition.is_some() == (plan.transition_s > 0.0), "{at}");
        });
    }
}

#[test]
fn turning_may_be_given_a_price() {
    let turned = |travel_weight: f64| {
        let config = PlannerConfig { travel_weight, ..Default::default() };
        stream("3x1", &config, 0.3, |at, plan, _| assert_eq!(plan.outcome, Outcome::Planned, "{at}"))
    };
    let (dear, cheap) = (turned(100.0), turned(0.0));
    assert!(dear < cheap, "{dear} and {cheap} transitions");
}

#[test]
fn outside_the_envelope_the_direction_is_kept() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut planner = planner("3x2", &PlannerConfig::default());
    for _ in 0..10 {
        let wanted = demand(&planner, rng.random_range(1.01..3.0), &mut rng);
        let plan = planner.plan(wanted, None, None);
        assert!(plan.outside_envelope && plan.outcome == Outcome::Planned, "{plan:?}");
        let share = 1.0 - plan.error;
        assert!((wanted - plan.wrench).weighted_norm([1.0, 1.0, 10.0]) > 0.0 && share > 0.1, "{plan:?}");
        for (got, asked) in plan.wrench.to_array().iter().zip(wanted.to_array()) {
            assert!((got - share * asked).abs() < 1e-7, "{plan:?} for {wanted:?}");
        }
        let inside = planner.plan(plan.wrench, None, None);
        assert!(!inside.outside_envelope && inside.error < 1e-6);
    }
}

#[test]
fn odd_input_is_answered() {
    let mut planner = planner("3x1", &PlannerConfig::default());
    let small = Wrench { fx_n: 0.02, ..Default::default() };
    let plan = planner.plan(Wrench { fx_n: f64::NAN, ..small }, Some(&[1.5; 3]), None);
    assert!(plan.outcome == Outcome::Held && plan.reason == Some(Reason::Demand), "{:?}", plan.reason);
    let plan = planner.plan(small, Some(&[1.5, f64::NAN, 1.5]), None);
    assert!(
        plan.outcome == Outcome::Held && plan.reason == Some(Reason::Tail { module: 1 }),
        "{:?}",
        plan.reason
    );
    // Tails that touch already cannot be freed.
    let plan = planner.plan(small, Some(&[0.0, PI, 0.0]), None);
    assert!(plan.outcome == Outcome::Held && plan.clearance_m < 0.0 && !plan.loss_tolerant);
    let reason = plan.reason.expect("held").to_string();
    assert_eq!(reason, "tails of modules 0 and 1 touch at -15.0 mm");
    // A demand of zero: all modules rest, at once if the tails may stay.
    let plan = planner.plan(Wrench::default(), Some(&[PI / 2.0; 3]), None);
    assert!(plan.outcome == Outcome::Planned && plan.transition.is_none() && plan.error < 1e-9, "{plan:?}");
    // A cycle before that is none of this planner's.
    let wild = [Swing { centerline_rad: 1.5, amplitude_rad: 9.0 }; 3];
    let plan = planner.plan(small, Some(&[10.5; 3]), Some(&wild));
    assert!(plan.outcome == Outcome::Planned && plan.cycle.iter().all(|s| s.amplitude_rad.abs() <= 2.6));
    // Far more than there is.
    let plan = planner.plan(Wrench { fx_n: 1e300, ..small }, Some(&[1.5; 3]), None);
    assert!(plan.outcome == Outcome::Held && plan.error.is_finite(), "{plan:?}");
    let plan = planner.plan(Wrench { fx_n: 1e6, ..small }, Some(&[1.5; 3]), None);
    assert!(plan.outside_envelope && plan.outcome == Outcome::Planned, "{plan:?}");
    let mut lone = self::planner("1x1", &PlannerConfig::default());
    let plan = lone.plan(Wrench { fy_n: 0.03, ..Default::default() }, Some(&[0.0]), None);
    assert!(plan.outcome == Outcome::Planned && plan.error < 1e-6, "{plan:?}");
    // It has no torque to give.
    let plan = lone.plan(Wrench { tau_nm: 0.01, ..Default::default() }, Some(&[0.0]), None);
    assert!(plan.outside_envelope && plan.error > 0.99, "{plan:?}");
}

#[test]
fn long_tails_are_planned_for_with_and_without_losses_in_mind() {
    let parameters = Parameters { tail_length_m: 0.102, ..Parameters::default() };
    for (loss_tolerant, least_tolerant) in [(LossTolerance::Off, 0), (LossTolerance::Require, 30)] {
        let config = PlannerConfig { loss_tolerant, ..Default::default() };
        let mut planner = ExactPlanner::new(setting("3x3", &parameters, &config));
        let mut tails = vec![PI / 4.0; 9];
        let (mut previous, mut tolerant): (Option<Vec<Swing>>, _) = (None, 0);
        for seed in 0..30 {
            let wanted = demand(&planner, 0.3, &mut ChaCha8Rng::seed_from_u64(seed));
            let plan = planner.plan(wanted, Some(&tails), previous.as_deref());
            if loss_tolerant == LossTolerance::Off {
                assert!(plan.outcome == Outcome::Planned && plan.error < 1e-6, "seed {seed}: {plan:?}");
            }
            tolerant += u32::from(plan.loss_tolerant);
            tails = ends(&plan);
            previous = Some(plan.cycle);
        }
        assert!(tolerant >= least_tolerant, "{loss_tolerant:?}: {tolerant}");
    }
}

/// Modules that give more or less than law (2): the sum of what each gives is what is asked for, by a sum that the planner has no part in.
#[test]
fn modules_of_different_thrust_give_together_what_is_asked() {
    for word in ["3x1", "3x3", "ring", "5x5"] {
        for seed in 0..6 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let modules = setting(word, &Parameters::default(), &PlannerConfig::default()).cells.len();
            let share = |rng: &mut ChaCha8Rng| rng.random_range(0.5..1.2);
            let module_share: Vec<f64> = (0..modules).map(|_| share(&mut rng)).collect();
            let parameters = Parameters { module_share: module_share.clone(), ..Parameters::default() };
            let mut planner = ExactPlanner::new(setting(word, &parameters, &PlannerConfig::default()));
            let positions_m = planner.setting.positions_m.clone();
            let (mut tails, mut previous) = (vec![0.7; modules], None::<Vec<Swing>>);
            for step in 0..12 {
                let wanted = demand(&planner, 0.5, &mut rng);
                let plan = planner.plan(wanted, Some(&tails), previous.as_deref());
                let of = format!("{word}, seed {seed}, step {step}");
                let mut given = [0.0; 3];
                for ((swing, [x, y]), share) in plan.cycle.iter().zip(&positions_m).zip(&module_share) {
                    // (7), of so much of (2).
                    let f = if swing.amplitude_rad == 0.0 {
                        0.0
                    } else {
                        0.022 * swing.amplitude_rad.abs() - 0.019
                    };
                    let (sin, cos) = swing.centerline_rad.sin_cos();
                    let [fx, fy] = [-share * f * cos, -share * f * sin];
                    given = [given[0] + fx, given[1] + fy, given[2] + x * fy - y * fx];
                }
                for (given, asked) in given.into_iter().zip(wanted.to_array()) {
                    assert!((given - asked).abs() < 1e-7, "{of}: {given} of {asked}: {plan:?}");
                }
                (tails, previous) = (ends(&plan), Some(plan.cycle.clone()));
            }
        }
    }
}

/// What one module gives less, the envelope has less, and no direction is beyond it.
#[test]
fn an_envelope_shrinks_with_the_shares_of_its_modules() {
    let parameters = Parameters { module_share: vec![0.5; 9], ..Parameters::default() };
    let half = ExactPlanner::new(setting("3x3", &parameters, &PlannerConfig::default())).envelope;
    let whole = planner("3x3", &PlannerConfig::default()).envelope;
    for normal in [[1.0, 0.0, 0.0], [0.3, -0.8, 2.0], [0.0, 0.0, 1.0]] {
        let wrench = Wrench::from_array(normal);
        assert!((half.support(normal) / whole.support(normal) - 0.5).abs() < 1e-12);
        assert!((half.gauge(wrench) / whole.gauge(wrench) - 2.0).abs() < 1e-9);
    }
    let parameters = Parameters { module_share: vec![1.0, 0.2, 1.0], ..Parameters::default() };
    let row = ExactPlanner::new(setting("3x1", &parameters, &PlannerConfig::default())).envelope;
    let mut thrusts_n = Vec::new();
    row.thrusts(Wrench { fx_n: 0.02, fy_n: 0.03, tau_nm: 0.001 }, &mut thrusts_n);
    let sum = thrusts_n.iter().fold([0.0; 2], |sum, [x, y]| [sum[0] + x, sum[1] + y]);
    assert!((sum[0] - 0.02).abs() < 1e-9 && (sum[1] - 0.03).abs() < 1e-9, "{thrusts_n:?}");
    let sizes: Vec<f64> = thrusts_n.iter().map(|[x, y]| x.hypot(*y)).collect();
    assert!((sizes[1] / sizes[0] - 0.2).abs() < 1e-6, "{sizes:?}");
}
