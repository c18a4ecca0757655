//! Table (d): outcomes on squares of 2 to 32 a side and on random shapes, with every k-th plan through the checker.

use modboat::parameters::Parameters;
use modboat::plan::Outcome;
use modboat::planner_kind::PlannerKind;
use modboat::structure::Structure;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::checker::{Modboat, check};
use tests::convert::of_plan;
use tests::random;
use tests::stream::{Kind, Sequence, follow, on_both_cores, settings};

use super::{NEAR, SHARE, alone, finish, full};

/// Plans for one structure.
struct Job {
    group: &'static str,
    structure: Structure,
    seed: u64,
    plans: usize,
    /// Pairs of modules to be put to the checker.
    pairs: usize,
}

/// What came of them.
#[derive(Clone, Debug, Default)]
struct Tally {
    plans: usize,
    planned: usize,
    repeated: usize,
    held: usize,
    checked: usize,
    pairs: usize,
    least_m: f64,
    refused: Vec<String>,
}

/// What is asked: four parts in ten a walk inside 60 % of the envelope, four unrelated demands there, one up to 95 %, one
/// up to 150 %, most of which nothing can meet.
const PARTS: [(Sequence, f64, usize); 4] =
    [(NEAR, SHARE, 4), (Sequence::Apart, SHARE, 4), (Sequence::Apart, 0.95, 1), (Sequence::Apart, 1.5, 1)];

fn run(job: &Job, kind: &Kind, planner: PlannerKind) -> Tally {
    let envelope = kind.envelope(&job.structure);
    let mut demands = Vec::new();
    for (sequence, share, tenths) in PARTS {
        demands.extend(sequence.demands(&envelope, share, job.seed, (job.plans * tenths).div_ceil(10)));
    }
    let modboat = Modboat::default();
    let neighbours =
        [[1, 0], [0, 1]].iter().map(|&offset| job.structure.neighbours(offset).count()).sum::<usize>();
    // Evenly over the plans.
    let stride = (job.plans * neighbours).div_ceil(job.pairs.max(1)).max(1);
    let mut tally = Tally { least_m: f64::INFINITY, ..Tally::default() };
    let mut planner = kind.planner(&job.structure, &settings(planner));
    follow(&mut planner, demands, 1, |asked, plan, _| {
        match plan.outcome {
            Outcome::Planned => tally.planned += 1,
            Outcome::Repeated => tally.repeated += 1,
            Outcome::Held => tally.held += 1,
        }
        if tally.plans.is_multiple_of(stride) && job.pairs > 0 {
            tally.checked += 1;
            tally.pairs += neighbours;
            match check(&modboat, &asked.request(&job.structure), &of_plan(plan)) {
                Ok(least) => tally.least_m = least.map_or(tally.least_m, |least| tally.least_m.min(least)),
                Err(what) => tally.refused.push(format!("seed {}, plan {}: {what}", job.seed, tally.plans)),
            }
        }
        tally.plans += 1;
    });
    tally
}

fn jobs() -> Vec<Job> {
    // Modules times plans for a structure; pairs to be checked for each; random shapes.
    let (work, pairs, shapes) = if full() { (80_000, 18_000, 320) } else { (1_800, 800, 24) };
    let plans = |modules: usize| (work / modules).clamp(12, if full() { 4_000 } else { 250 });
    let mut jobs: Vec<Job> = (2..=32_usize)
        .rev()
        .map(|side| Job {
            group: match side {
                2..=5 => "squares  2–5 a side",
                6..=10 => "squares  6–10",
                11..=20 => "squares 11–20",
                _ => "squares 21–32",
            },
            structure: Structure::from_word(&format!("{side}x{side}")).expect("a square"),
            seed: side as u64,
            plans: plans(side * side),
            pairs,
        })
        .collect();
    for seed in 0..shapes {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        // As many between 4 and 16 as between 16 and 64 and so on.
        let modules = 4.0_f64.powf(rng.random_range(1.0..4.0)) as usize;
        jobs.push(Job {
            group: match modules {
                ..16 => "random shapes of 4–15",
                16..64 => "random shapes of 16–63",
                _ => "random shapes of 64–255",
            },
            structure: Structure::from_cells(&random::shape(modules, &mut rng)).expect("a connected shape"),
            seed: 1000 + seed,
            plans: plans(modules).min(if full() { 300 } else { 100 }),
            pairs: pairs * 31 / shapes as usize,
        });
    }
    jobs
}

#[test]
fn table_d_outcomes_and_collisions() {
    let _alone = alone();
    let kind = Kind::new(Parameters::default());
    let jobs = jobs();
    let exact = on_both_cores(&jobs, |job| run(job, &kind, PlannerKind::Exact));
    // The potential field: the first demands of every part.
    let few = 10;
    let field = on_both_cores(&jobs, |job| {
        let (structure, plans) = (job.structure.clone(), job.plans.min(few));
        run(&Job { structure, plans, pairs: 0, ..*job }, &kind, PlannerKind::PotentialField)
    });
    let mut groups: Vec<(&str, Tally, Tally)> = Vec::new();
    for ((job, exact), field) in jobs.iter().zip(exact).zip(field) {
        let index = groups.iter().position(|(name, ..)| *name == job.group).unwrap_or_else(|| {
            let none = Tally { least_m: f64::INFINITY, ..Tally::default() };
            groups.push((job.group, none.clone(), none));
            groups.len() - 1
        });
        add(&mut groups[index].1, exact);
        add(&mut groups[index].2, field);
    }
    groups.sort_by_key(|(name, ..)| (name.contains("random"), *name));
    let mut all = ("all", Tally { least_m: f64::INFINITY, ..Tally::default() }, Tally::default());
    for (_, exact, field) in &groups {
        add(&mut all.1, exact.clone());
        add(&mut all.2, field.clone());
    }
    groups.push(all);
    let mut table = String::new();
    table += "(d) Outcomes, and what the dense checker says of the exact planner's; the potential field on fewer demands\n";
    table += "                        |                   exact                                               |      potential field\n";
    table += "structures              |  plans planned repeated held | checked   pairs refused clearance mm  | plans planned repeated held\n";
    for (name, exact, field) in &groups {
        table += &format!(
            "{name:<23} | {:>6} {:>7} {:>8} {:>4} | {:>7} {:>7} {:>7} {:>13.2} | {:>5} {:>7} {:>8} {:>4}\n",
            exact.plans,
            exact.planned,
            exact.repeated,
            exact.held,
            exact.checked,
            exact.pairs,
            exact.refused.len(),
            1e3 * exact.least_m,
            field.plans,
            field.planned,
            field.repeated,
            field.held,
        );
    }
    let mut broken = Vec::new();
    for (name, exact, _) in groups.iter().filter(|(name, ..)| *name != "all") {
        broken.extend(exact.refused.iter().map(|what| format!("{name}, {what}")));
        if exact.planned < exact.plans {
            broken.push(format!("{name}: {} repeated, {} held", exact.repeated, exact.held));
        }
    }
    finish(&table, &broken);
}

fn add(sum: &mut Tally, part: Tally) {
    sum.plans += part.plans;
    sum.planned += part.planned;
    sum.repeated += part.repeated;
    sum.held += part.held;
    sum.checked += part.checked;
    sum.pairs += part.pairs;
    sum.least_m = sum.least_m.min(part.least_m);
    sum.refused.extend(part.refused);
}
