//! Table (i): near the border of the envelope the exact planner is never worse than the potential field.

use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::plan::Outcome;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::planner_kind::PlannerKind;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::checker::Modboat;
use tests::random;
use tests::stream::{Kind, on_both_cores, settings};

use super::{EXACT, alone, finish, full, structure};

/// Shapes, and how many demands of each share are asked; ten times as many with the full counts.
const SIZES: [(&str, u64); 11] = [
    ("3x1", 20),
    ("2x2", 20),
    ("4x1", 20),
    ("3x2", 20),
    ("3x3", 20),
    ("ring", 10),
    ("line of 12", 10),
    ("5x5", 10),
    ("10x10", 6),
    ("16x16", 6),
    ("24x24", 2),
];
const SHARES: [f64; 6] = [0.6, 0.72, 0.8, 0.88, 0.95, 0.98];

/// What one demand came to.
struct Told {
    seed: u64,
    exact: f64,
    field: f64,
    planned: bool,
}

/// One demand from where the exact planner's plan for another one ended, or from nowhere: the same question to both planners.
fn ask(shape: &str, share: f64, seed: u64, kind: &Kind) -> Told {
    let (structure, modboat) = (structure(shape), Modboat::default());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut demand = |share: f64| {
        Wrench::from_array(random::border(&modboat, structure.cells(), &mut rng).map(|f| share * f))
    };
    let (wanted, before) = (demand(share), demand(0.5));
    let [mut exact, mut field]: [Planner; 2] =
        [PlannerKind::Exact, PlannerKind::PotentialField].map(|planner| {
            // Both by the same law of time, so that both may turn alike.
            let config =
                PlannerConfig { transition_law: Some(PlannerConfig::default().law()), ..settings(planner) };
            kind.planner(&structure, &config)
        });
    let last = rng.random_bool(0.5).then(|| exact.plan(before, None, None).cycle);
    let tails: Option<Vec<f64>> =
        last.as_ref().map(|cycle| cycle.iter().map(|swing| swing.start_rad()).collect());
    let plans =
        [&mut exact, &mut field].map(|planner| planner.plan(wanted, tails.as_deref(), last.as_deref()));
    let [exact, field] = plans;
    Told { seed, exact: exact.error, field: field.error, planned: exact.outcome == Outcome::Planned }
}

#[test]
fn table_i_near_the_border_the_exact_planner_is_never_worse() {
    let _alone = alone();
    let kind = Kind::new(Parameters::default());
    let jobs: Vec<_> =
        SIZES.iter().flat_map(|&(shape, count)| SHARES.map(|share| (shape, share, count))).collect();
    let rows = on_both_cores(&jobs, |&(shape, share, count)| {
        let count = if full() { 10 * count } else { count };
        // One that fails is found again by its shape, share and seed.
        (0..count).map(|seed| ask(shape, share, seed, &kind)).collect::<Vec<_>>()
    });
    let mut table =
        "(i) Demands of a share of the border, from known tails and unknown: greatest errors\nstructure  share | demands | <= 1e-6 | exact: most | potential field: most\n"
            .to_owned();
    let mut broken = Vec::new();
    for ((shape, share, _), told) in jobs.iter().zip(rows) {
        let most = |of: fn(&Told) -> f64| told.iter().map(of).fold(0.0, f64::max);
        let met = told.iter().filter(|told| told.exact <= EXACT).count();
        table += &format!(
            "{shape:<10} {:>3.0} % | {:>7} | {:>5.1} % | {:>11.1e} | {:>21.4}\n",
            100.0 * share,
            told.len(),
            100.0 * met as f64 / told.len() as f64,
            most(|told| told.exact),
            most(|told| told.field),
        );
        for Told { seed, exact, field, planned } in told {
            if exact > field.max(EXACT) || !planned {
                broken.push(format!("{shape}, {share}, seed {seed}: error {exact:e}, potential field {field:e}, planned: {planned}"));
            }
        }
    }
    finish(&table, &broken);
}
