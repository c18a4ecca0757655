//! Table (j): from wherever tails rest without touching, plans that any module may miss lead out of the neighbours' reach and swim.

use std::f64::consts::PI;

use host::run::experiment::simulate;
use host::run::scenario::Scenario;
use modboat::motion::Swing;
use modboat::parameters::Parameters;
use modboat::plan::Outcome;
use modboat::planner_config::{LossTolerance, PlannerConfig};
use modboat::planner_kind::PlannerKind;
use modboat::tail::Tail;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::checker::{Modboat, Request, check};
use tests::convert::{of_plan, swings};
use tests::random;
use tests::stream::{Kind, on_both_cores, settings};

use super::{SHAPES, alone, finish, full, structure};

/// Tails of a start rest at least that far apart, m: nearer ones touch as they are, for all that a module may be off.
const APART_M: f64 = 0.006;
/// Share of the envelope, and chance that a module misses a plan.
const SHARE: f64 = 0.3;
const MISSES: f64 = 0.3;
/// Plans after which everything must swim, with no plan missed: four were seen.
const PLANS: usize = 8;

/// Of whole runs.
const SEEDS: [u64; 3] = [1, 2, 3];

/// Random angles of tails that are apart, one module after another.
fn start(shape: &str, kind: &Kind, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let structure = structure(shape);
    let tail = Tail::new(&kind.parameters);
    let pairs: Vec<(usize, usize, [i32; 2])> = [[1, 0], [0, 1]]
        .into_iter()
        .flat_map(|offset| structure.neighbours(offset).map(move |(i, j)| (i, j, offset)).collect::<Vec<_>>())
        .collect();
    let mut tails = vec![f64::NAN; structure.len()];
    for module in 0..tails.len() {
        loop {
            tails[module] = rng.random_range(-PI..PI);
            let apart = |&(i, j, offset): &(usize, usize, [i32; 2])| {
                i.max(j) > module || tail.clearance_m(offset, tails[i], tails[j]) > APART_M
            };
            if pairs.iter().filter(|pair| pair.0 == module || pair.1 == module).all(apart) {
                break;
            }
        }
    }
    tails
}

/// Plans until all has swum; how many, or what was wrong.
fn swim(shape: &str, kind: &Kind, asked: LossTolerance, seed: u64, misses: f64) -> Result<usize, String> {
    let (structure, modboat) = (structure(shape), Modboat::default());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut tails = if seed == 0 { vec![0.0; structure.len()] } else { start(shape, kind, &mut rng) };
    let config = PlannerConfig { loss_tolerant: asked, ..settings(PlannerKind::Exact) };
    let mut planner = kind.planner(&structure, &config);
    let wanted = random::border(&modboat, structure.cells(), &mut rng).map(|f| SHARE * f);
    // A cycle that any module may stop in has its price; half of the demand is met by it all the same.
    let good = if asked == LossTolerance::Power { 0.5 } else { 1e-6 };
    let mut previous: Option<Vec<Swing>> = None;
    let mut least = f64::INFINITY;
    for count in 1..=4 * PLANS {
        let wrench = modboat::motion::Wrench::from_array(wanted);
        let plan = planner.plan(wrench, Some(&tails), previous.as_deref());
        if plan.outcome != Outcome::Planned || !plan.loss_tolerant {
            return Err(format!(
                "plan {count}: {} from {tails:?}, loss tolerant: {}",
                plan.outcome.name(),
                plan.loss_tolerant
            ));
        }
        let request = Request {
            cells: structure.cells().to_vec(),
            demand: wanted,
            tail_rad: Some(tails.clone()),
            previous: previous.as_deref().map(swings),
        };
        check(&modboat, &request, &of_plan(&plan)).map_err(|what| format!("plan {count}: {what}"))?;
        least = least.min(plan.error);
        if plan.error < good {
            return Ok(count);
        }
        for (module, turn) in plan.transition.iter().flatten().enumerate() {
            if !rng.random_bool(misses) {
                tails[module] = turn.to_rad;
            }
        }
        previous = Some(plan.cycle);
    }
    Err(format!("after {} plans the least error is {least:.3}", 4 * PLANS))
}

#[test]
fn table_j_out_of_reach_by_plans_that_any_module_may_miss() {
    let _alone = alone();
    let kind = Kind::new(Parameters::default());
    let seeds = if full() { 200 } else { 20 };
    let mut jobs = Vec::new();
    for shape in SHAPES {
        for asked in [LossTolerance::Require, LossTolerance::Power] {
            for misses in [0.0, MISSES] {
                jobs.push((shape, asked, misses));
            }
        }
    }
    let rows = on_both_cores(&jobs, |&(shape, asked, misses)| {
        (0..seeds).map(|seed| swim(shape, &kind, asked, seed, misses)).collect::<Vec<_>>()
    });
    let mut table =
        "(j) From random rest poses to the first swim that meets the demand, every plan loss tolerant\nstructure  asked   missed | starts | plans: mean  most\n"
            .to_owned();
    let mut broken = Vec::new();
    for ((shape, asked, misses), rows) in jobs.iter().zip(rows) {
        let counts: Vec<usize> = rows.iter().filter_map(|row| row.as_ref().ok().copied()).collect();
        let most = counts.iter().copied().max().unwrap_or(0);
        table += &format!(
            "{shape:<10} {:<7} {:>4.0} % | {:>6} | {:>11.2} {most:>5}\n",
            format!("{asked:?}").to_lowercase(),
            100.0 * misses,
            rows.len(),
            counts.iter().sum::<usize>() as f64 / counts.len().max(1) as f64,
        );
        if *misses == 0.0 && most > PLANS {
            broken.push(format!("{shape}, {asked:?}: {most} plans until it swims, not {PLANS}"));
        }
        for (seed, row) in rows.iter().enumerate() {
            if let Err(what) = row {
                broken.push(format!("{shape}, {asked:?}, {misses} missed, seed {seed}: {what}"));
            }
        }
    }
    finish(&table, &broken);
}

#[test]
fn scenarios_swim_loss_tolerant_from_the_default_start() {
    let _alone = alone();
    let jobs: Vec<_> = ["holonomic-1", "nine", "twenty-five"]
        .iter()
        .flat_map(|&name| [LossTolerance::Require, LossTolerance::Power].map(|asked| (name, asked)))
        .flat_map(|(name, asked)| SEEDS.map(|seed| (name, asked, seed)))
        .collect();
    let rows = on_both_cores(&jobs, |&(name, asked, seed)| {
        let mut scenario = Scenario::open(name).expect(name);
        scenario.planner.loss_tolerant = asked;
        let run = simulate(&scenario, seed)
            .unwrap_or_else(|error| panic!("{name}, {asked:?}, seed {seed}: {error}"));
        run.summary
    });
    for (jobs, rows) in jobs.chunks(SEEDS.len()).zip(rows.chunks(SEEDS.len())) {
        let (name, asked, _) = jobs[0];
        for (&(.., seed), summary) in jobs.iter().zip(rows) {
            let cycles = &summary.cycles;
            let planned = cycles.planned as f64 / cycles.total as f64;
            assert!(planned > 0.9, "{name}, {asked:?}, seed {seed}: {cycles:?}");
            assert!(
                cycles.loss_tolerant_share > 0.999 && summary.contacts.is_empty(),
                "{name}, {asked:?}, seed {seed}: {summary:?}"
            );
        }
        for leg in 0..rows[0].legs.len() {
            // Twice what was seen, or less. What a stop anywhere in every cycle costs where neighbours are many: 0.41 at nine.
            let most = match (name, asked) {
                ("holonomic-1", _) => 7e-4,
                ("nine", LossTolerance::Power) => 0.6,
                ("twenty-five", LossTolerance::Require) => 0.056,
                _ => 0.12,
            };
            let errors = rows.iter().map(|summary| summary.legs[leg].velocity_error);
            let mean = errors.sum::<f64>() / rows.len() as f64;
            println!("{name}, {asked:?}, leg {leg}: velocity off by {mean:.4} over seeds {SEEDS:?}");
            assert!(
                mean <= most,
                "{name}, {asked:?}, leg {leg}: velocity off by {mean} over seeds {SEEDS:?}"
            );
        }
    }
}
