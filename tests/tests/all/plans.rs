//! Plans for random demands on random shapes, each through the independent checker. 100 shapes as they are; `FLOTILLA_SHAPES=400` plans
//! ten thousand times.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use modboat::distance::DistanceToCollision;
use modboat::motion::{Swing, Wrench};
use modboat::parameters::Parameters;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::structure::Structure;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::checker::{Modboat, Request, check};
use tests::convert::{of_plan, swings};
use tests::figures::Quantiles;
use tests::random;
use tests::seeds::{number, on_all_cores};

const SEQUENCES: u64 = 100;
const PLANS_EACH: usize = 25;

/// One plan's figures.
struct Row {
    modules: usize,
    outcome: String,
    /// Part of the envelope that was asked for.
    share: f64,
    error: f64,
    tails_known: bool,
    loss_tolerant: bool,
    transition: bool,
    clearance_m: f64,
    plan_ms: f64,
}

/// Modules of one kind, as the host and as the checker know them.
struct Kind {
    parameters: Parameters,
    modboat: Modboat,
    distance: Arc<DistanceToCollision>,
}

impl Kind {
    /// Tails of the given length, m; everything else as by default.
    fn new(tail_length_m: f64) -> Self {
        let parameters = Parameters { tail_length_m, ..Parameters::default() };
        let distance = Arc::new(DistanceToCollision::new(&parameters));
        Self { parameters, modboat: Modboat { tail_length_m, ..Modboat::default() }, distance }
    }

    fn planner(&self, cells: &[[i32; 2]]) -> Planner {
        let structure = Structure::from_cells(cells).expect("a connected shape");
        let distance = Arc::clone(&self.distance);
        Planner::with_distance(&structure, &self.parameters, &PlannerConfig::default(), distance)
    }
}

/// A sequence of plans in which every request's tails are where the last plan left them.
fn sequence(seed: u64, kind: &Kind) -> Result<Vec<Row>, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let modules = 3 + (seed % 10) as usize;
    let cells = random::shape(modules, &mut rng);
    let modboat = &kind.modboat;
    let mut planner = kind.planner(&cells);
    // A first cycle with tail angles unknown, or with all tails alike, any number of turns away.
    let mut tails: Option<Vec<f64>> =
        rng.random_bool(0.5).then(|| vec![rng.random_range(-20.0..20.0); modules]);
    let mut previous: Option<Vec<Swing>> = None;
    let mut rows = Vec::with_capacity(PLANS_EACH);
    for step in 0..PLANS_EACH {
        let share = match rng.random_range(0..20) {
            0 => 0.0,
            1..=3 => rng.random_range(1.0..2.0),
            _ => rng.random_range(0.0..1.0),
        };
        let demand = random::border(modboat, &cells, &mut rng).map(|f| share * f);
        let began = Instant::now();
        let plan = planner.plan(Wrench::from_array(demand), tails.as_deref(), previous.as_deref());
        let plan_ms = began.elapsed().as_secs_f64() * 1e3;
        let request = Request {
            cells: cells.clone(),
            demand,
            tail_rad: tails.clone(),
            previous: previous.as_deref().map(swings),
        };
        let answer = of_plan(&plan);
        let least = check(modboat, &request, &answer)
            .map_err(|broken| format!("seed {seed}, plan {step}: {broken}\n{request:?}\n{answer:?}"))?;
        rows.push(Row {
            modules,
            outcome: answer.outcome,
            share,
            error: plan.error,
            tails_known: tails.is_some(),
            loss_tolerant: plan.loss_tolerant,
            transition: plan.transition.is_some(),
            clearance_m: least.unwrap_or(f64::INFINITY),
            plan_ms,
        });
        tails = match (&plan.transition, tails) {
            (Some(turns), _) => Some(turns.iter().map(|turn| turn.to_rad).collect()),
            (None, Some(tails)) => Some(tails),
            (None, None) => Some(plan.cycle.iter().map(|swing| swing.start_rad()).collect()),
        };
        if rows[step].outcome != "held" {
            previous = Some(plan.cycle);
        }
    }
    Ok(rows)
}

/// Sequences 0 … `count` − 1.
fn sequences(count: u64, kind: &Kind) -> Vec<Row> {
    let results = on_all_cores(0..count, |seed| sequence(seed, kind));
    let rows: Vec<Row> =
        results.into_iter().flat_map(|result| result.unwrap_or_else(|broken| panic!("{broken}"))).collect();
    assert_eq!(rows.len(), count as usize * PLANS_EACH);
    rows
}

fn outcomes(rows: &[Row]) -> [usize; 3] {
    ["planned", "repeated", "held"].map(|name| rows.iter().filter(|row| row.outcome == name).count())
}

/// Tails of 0.75 pitches reach across a diagonal.
#[test]
fn plans_for_tails_that_reach_across_a_diagonal_keep_their_word() {
    let kind = Kind::new(0.75 * 0.15);
    assert!(kind.distance.offsets().len() > 2, "{:?}", kind.distance.offsets());
    let rows = sequences(40, &kind);
    let [planned, repeated, held] = outcomes(&rows);
    println!(
        "tails of 0.75 pitches: {} plans accepted by the checker, {planned} planned, {repeated} repeated, {held} held",
        rows.len()
    );
    assert_eq!(planned, rows.len(), "planned");
}

/// From random poses, many of which touch already.
#[test]
fn plans_from_arbitrary_poses_keep_their_word() {
    let kind = Kind::new(0.09);
    let mut counts = BTreeMap::new();
    for seed in 0..1000 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let cells = random::shape(rng.random_range(2..=8), &mut rng);
        let tails: Vec<f64> = cells.iter().map(|_| rng.random_range(-20.0..20.0)).collect();
        let demand = random::border(&kind.modboat, &cells, &mut rng).map(|f| 0.7 * f);
        let plan = kind.planner(&cells).plan(Wrench::from_array(demand), Some(&tails), None);
        let request = Request { cells, demand, tail_rad: Some(tails), previous: None };
        let answer = of_plan(&plan);
        if let Err(broken) = check(&kind.modboat, &request, &answer) {
            panic!("seed {seed}: {broken}\n{request:?}\n{answer:?}");
        }
        *counts.entry((answer.outcome, plan.clearance_m > 0.0)).or_insert(0) += 1;
    }
    println!("1000 plans from arbitrary poses, by outcome and whether tails are apart: {counts:?}");
    // No way out of a contact is planned: what touches is held.
    assert!(!counts.contains_key(&("planned".to_owned(), false)));
    assert!(counts.contains_key(&("held".to_owned(), false)), "no pose touched");
    assert!(!counts.contains_key(&("held".to_owned(), true)), "held although no tails touch");
    assert!(counts[&("planned".to_owned(), true)] >= 850, "most poses do not touch");
}

#[test]
fn table_plans_keep_their_word() {
    let shapes = number("FLOTILLA_SHAPES").unwrap_or(SEQUENCES);
    let rows = sequences(shapes, &Kind::new(0.09));
    let mut table = String::new();
    let mut sizes: BTreeMap<usize, Vec<&Row>> = BTreeMap::new();
    rows.iter().for_each(|row| sizes.entry(row.modules).or_default().push(row));
    table += &format!("{} plans on {shapes} random shapes, all accepted by the checker\n", rows.len());
    table += "modules plans planned repeated  held | error within the envelope      | loss-     no     | clearance | plan ms\n";
    table += "                                     | <= 80 %: p50  p99  <= 100 % p99 | tolerant  transn | least mm  |  p50   p99    max\n";
    let count = |rows: &[&Row], of: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| of(row)).count();
    for (modules, rows) in &sizes {
        let outcome = |name: &str| count(rows, &|row| row.outcome == name);
        let errors = |most: f64| {
            let within = rows.iter().filter(move |row| row.share > 0.0 && row.share <= most);
            Quantiles::of(within.map(|row| row.error))
        };
        let known = count(rows, &|row| row.tails_known) as f64;
        let share =
            |of: &dyn Fn(&Row) -> bool| 100.0 * count(rows, &|row| row.tails_known && of(row)) as f64 / known;
        let time = Quantiles::of(rows.iter().map(|row| row.plan_ms));
        table += &format!(
            "{modules:>7} {:>5} {:>7} {:>8} {:>5} | {:>11.4} {:>6.4} {:>13.4} | {:>6.1} % {:>6.1} % | {:>9.2} | {:>5.2} {:>6.2} {:>6.2}\n",
            rows.len(),
            outcome("planned"),
            outcome("repeated"),
            outcome("held"),
            errors(0.8).median,
            errors(0.8).p99,
            errors(1.0).p99,
            share(&|row| row.loss_tolerant),
            share(&|row| !row.transition),
            1e3 * Quantiles::of(rows.iter().map(|row| row.clearance_m)).least,
            time.median,
            time.p99,
            time.most,
        );
    }
    // In one piece, whatever else is printed meanwhile.
    print!("{table}");
    let [planned, ..] = outcomes(&rows);
    assert_eq!(planned, rows.len(), "planned");
}
