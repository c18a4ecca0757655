use std::f64::consts::{PI, TAU};

use quantity::wrap_rad;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::distance::DistanceToCollision;
use crate::parameters::Parameters;
use crate::planner_config::{DistanceSource, PlannerConfig};
use crate::planner_kind::PlannerKind;
use crate::structure::Structure;

impl FieldPlanner {
    fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let mut plan = Plan::default();
        self.plan_into(demand, tails, previous.map(Previous::cycle), &mut plan);
        plan
    }
}

fn planner(word: &str, parameters: &Parameters) -> FieldPlanner {
    let (structure, distance) =
        (Structure::from_word(word).expect(word), Arc::new(DistanceToCollision::new(parameters)));
    let config = PlannerConfig { kind: PlannerKind::PotentialField, ..PlannerConfig::default() };
    FieldPlanner::new(Setting::new(&structure, parameters, &config, distance))
}

/// A demand that thrusts of at most `share` of the greatest yield.
fn demand(planner: &FieldPlanner, share: f64, rng: &mut ChaCha8Rng) -> Wrench {
    let thrust_max_n = planner.setting.parameters.thrust_n(planner.setting.parameters.amplitude_max_rad);
    planner.setting.positions_m.iter().fold(Wrench::default(), |sum, [x, y]| {
        let (f, angle) = (share * thrust_max_n * rng.random_range(0.0..1.0_f64), rng.random_range(-PI..PI));
        let (fx, fy) = (f * angle.cos(), f * angle.sin());
        sum + Wrench { fx_n: fx, fy_n: fy, tau_nm: x * fy - y * fx }
    })
}

fn start(cycle: &[Swing]) -> Vec<f64> {
    cycle.iter().map(|swing| swing.start_rad()).collect()
}

/// Least surface distance of any two tails over transition and cycle, by samples, when only `moving` take part.
fn sampled_clearance_m(
    planner: &FieldPlanner,
    plan: &Plan,
    tails: &[f64],
    moving: impl Fn(usize) -> bool,
) -> f64 {
    let (tail, mut least) = (*planner.setting.distance.tail(), f64::INFINITY);
    for k in 0..=600 {
        let share = f64::from(k) / 600.0;
        for phase in 0..2 {
            let angles: Vec<f64> = (0..tails.len())
                .map(|m| match (&plan.transition, phase) {
                    _ if !moving(m) => tails[m],
                    (Some(turns), 0) => turns[m].from_rad + share * turns[m].rotation_rad(),
                    (None, 0) => tails[m],
                    _ => plan.cycle[m].centerline_rad + plan.cycle[m].amplitude_rad * (TAU * share).cos(),
                })
                .collect();
            for i in 0..tails.len() {
                for j in 0..tails.len() {
                    let offset =
                        [0, 1].map(|axis| planner.setting.cells[j][axis] - planner.setting.cells[i][axis]);
                    if offset[0].abs() + offset[1].abs() == 1 {
                        least = least.min(tail.clearance_m(offset, angles[i], angles[j]));
                    }
                }
            }
        }
    }
    least
}

#[test]
fn a_stream_of_plans_keeps_its_word() {
    for word in ["3x1", "2x2", "3x2"] {
        let mut planner = planner(word, &Parameters::default());
        let mut previous: Option<Plan> = None;
        let mut tolerant = 0;
        for seed in 0..40 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let demand = demand(&planner, 0.6, &mut rng);
            let tails = previous.as_ref().map(|p| start(&p.cycle));
            let plan = planner.plan(demand, tails.as_deref(), previous.as_ref().map(|p| p.cycle.as_slice()));
            assert_eq!(plan.outcome, Outcome::Planned, "{word}, seed {seed}");
            let error = (demand - plan.wrench).weighted_norm([1.0, 1.0, 10.0])
                / demand.weighted_norm([1.0, 1.0, 10.0]);
            assert!((error - plan.error).abs() < 1e-12, "{word}, seed {seed}");
            let Some(tails) = tails else {
                assert!(plan.transition.is_none() && !plan.loss_tolerant);
                previous = Some(plan);
                continue;
            };
            let mut travel_rad = 0.0;
            for (m, turn) in plan.transition.iter().flatten().enumerate() {
                assert!((turn.from_rad - tails[m]).abs() < 1e-15, "{word}, seed {seed}");
                let away = wrap_rad(turn.to_rad - plan.cycle[m].start_rad());
                assert!(away.abs() < 1e-9 && turn.rotation_rad().abs() <= 6.5, "{word}, seed {seed}");
                travel_rad += turn.rotation_rad().abs();
            }
            assert!((travel_rad - plan.travel_rad).abs() < 1e-9, "{word}, seed {seed}");
            // Samples see a little less than the exact minimum, never more.
            let sampled_m = sampled_clearance_m(&planner, &plan, &tails, |_| true);
            assert!(plan.clearance_m > 0.004, "{word}, seed {seed}: {}", plan.clearance_m);
            assert!(
                (plan.clearance_m - 1e-4..plan.clearance_m + 2e-3).contains(&(sampled_m.min(1.0) - 1e-6)),
                "{word}, seed {seed}: {sampled_m} m sampled, {} m said",
                plan.clearance_m
            );
            // Every subset that misses the plan.
            let safe = (0_u32..1 << tails.len())
                .all(|subset| sampled_clearance_m(&planner, &plan, &tails, |m| subset >> m & 1 == 1) > 0.0);
            assert_eq!(safe, plan.loss_tolerant, "{word}, seed {seed}");
            tolerant += usize::from(safe);
            previous = Some(plan);
        }
        assert!(tolerant > 0 && tolerant < 39, "{word}: both must occur, {tolerant} of 39");
    }
}

#[test]
fn square_structures_nearly_always_have_a_transition() {
    let distance = Arc::new(DistanceToCollision::new(&Parameters::default()));
    let (mut all_found, mut all_tried) = (0, 0);
    for (side, runs) in [(2, 150), (3, 100), (4, 60), (5, 40)] {
        let structure = Structure::from_word(&format!("{side}x{side}")).expect("a square");
        let config = PlannerConfig::default();
        let distance = Arc::clone(&distance);
        let mut planner =
            FieldPlanner::new(Setting::new(&structure, &Parameters::default(), &config, distance));
        let (mut found, mut tried, mut planned) = (0_u32, 0_u32, 0);
        let mut before: Option<Vec<Swing>> = None;
        for seed in 0..runs {
            let demand = demand(&planner, 1.0, &mut ChaCha8Rng::seed_from_u64(seed));
            let tails = before.as_deref().map(start);
            // Without the cycle before, so that the next does not resemble it.
            let plan = planner.plan(demand, tails.as_deref(), None);
            planned += u64::from(plan.outcome == Outcome::Planned);
            if let Some(tails) = &tails {
                // Each single candidate, as the paper counts; a plan has several to choose from.
                let FieldPlanner { setting, field, solver, buffers, .. } = &mut planner;
                for candidate in solve(setting, None, field, demand, None) {
                    tried += 1;
                    found += u32::from(reach(setting, solver, buffers, candidate, Some(tails)).is_some());
                }
            }
            before = Some(plan.cycle);
        }
        println!(
            "{side}x{side}: {found} of {tried} random cycles have a transition, {planned} of {runs} plans"
        );
        assert_eq!(planned, runs, "{side}x{side}");
        all_found += found;
        all_tried += tried;
    }
    assert!(f64::from(all_found) >= 0.99 * f64::from(all_tried), "{all_found} of {all_tried}");
}

#[test]
fn a_search_by_the_table_keeps_the_margin_too() {
    // Few amplitudes, so that the table takes a moment.
    let parameters = Parameters { amplitude_min_rad: 2.2, ..Default::default() };
    let config = PlannerConfig { distance: DistanceSource::Table, ..Default::default() };
    let structure = Structure::from_word("2x2").expect("a square");
    let distance = Arc::new(DistanceToCollision::new(&parameters));
    let table = Arc::new(DistanceTable::generate(&parameters));
    let setting = Setting::new(&structure, &parameters, &config, distance);
    let mut planner = FieldPlanner::new(setting).with_table(table);
    let mut tails: Option<Vec<f64>> = None;
    for seed in 0..20 {
        let demand = demand(&planner, 0.8, &mut ChaCha8Rng::seed_from_u64(seed));
        let plan = planner.plan(demand, tails.as_deref(), None);
        assert_eq!(plan.outcome, Outcome::Planned, "seed {seed}");
        for pair in planner.setting.pairs.all() {
            let [from, to] = swim_ends(&plan.cycle, pair);
            let doc_rad = planner.setting.distance.along(pair.offset, from, to);
            assert!(doc_rad >= config.margin_rad, "seed {seed}: {doc_rad} rad");
        }
        tails = Some(start(&plan.cycle));
    }
    assert!(planner.table.is_some());
}

/// Parameters that leave no time to turn.
fn no_time() -> Parameters {
    Parameters { transition_s: 1e-4, ..Default::default() }
}

#[test]
fn the_same_again_when_nothing_else_can_be_reached() {
    let mut planner = planner("3x1", &no_time());
    let before = planner.plan(Wrench { fx_n: 0.05, ..Default::default() }, None, None).cycle;
    let tails = start(&before);
    let demand = Wrench { fx_n: -0.05, tau_nm: 0.002, ..Default::default() };
    let plan = planner.plan(demand, Some(&tails), Some(&before));
    assert_eq!(plan.outcome, Outcome::Repeated);
    assert_eq!(plan.cycle, before);
    assert!(plan.transition.is_none() && plan.error > 1.0 && plan.clearance_m > 0.0, "{plan:?}");
}

#[test]
fn held_when_not_even_that_is_possible() {
    let mut planner = planner("3x1", &no_time());
    let tails = [1.5, 1.4, 14.0];
    let plan = planner.plan(Wrench { fx_n: -0.05, ..Default::default() }, Some(&tails), None);
    assert_eq!(plan.outcome, Outcome::Held);
    assert_eq!(plan.transition, None);
    assert_eq!(plan.wrench, Wrench::default());
    for (swing, tail) in plan.cycle.iter().zip(tails) {
        assert!(swing.amplitude_rad == 0.0 && (swing.centerline_rad - tail).abs() < 1e-15);
    }
    assert!((plan.error - 1.0).abs() < 1e-15 && plan.travel_rad == 0.0 && plan.loss_tolerant);
    // Tails that touch already are held too, and it shows.
    let plan = planner.plan(Wrench::default(), Some(&[0.0, PI, 0.0]), None);
    assert!(plan.outcome == Outcome::Held && plan.clearance_m < 0.0 && !plan.loss_tolerant);
    assert!(plan.error == 0.0, "nothing was asked for, and nothing is done");
}

#[test]
fn odd_input_is_answered() {
    let mut planner = planner("3x1", &Parameters::default());
    // What is not a number is not obeyed.
    let plan = planner.plan(Wrench { fx_n: f64::NAN, ..Default::default() }, Some(&[1.5; 3]), None);
    assert_eq!(plan.outcome, Outcome::Held);
    let plan = planner.plan(Wrench { fx_n: 1e300, ..Default::default() }, Some(&[1.5; 3]), None);
    assert!(plan.error.is_finite());
    let plan = planner.plan(Wrench::default(), Some(&[f64::NAN; 3]), None);
    assert!(plan.outcome == Outcome::Held && !plan.loss_tolerant);
}

#[test]
fn a_lone_module_swims() {
    let mut planner = planner("1x1", &Parameters::default());
    let plan = planner.plan(Wrench { fy_n: 0.03, ..Default::default() }, Some(&[0.0]), None);
    assert_eq!(plan.outcome, Outcome::Planned);
    assert!(plan.error < 0.01 && plan.loss_tolerant && plan.clearance_m == f64::INFINITY, "{plan:?}");
}
