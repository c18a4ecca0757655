//! Table (e): how long a whole plan takes, allocation, transition and exact examination, on one thread.
//!
//! Each question is put three times, with the same answer, and the least time counts: the one that other work on the machine
//! disturbs least.

use modboat::parameters::Parameters;
use modboat::planner_kind::PlannerKind;
use tests::stream::{DemandStream, Kind, Rows, Sequence, settings};

use super::{NEAR, SHARE, alone, full, structure};

/// Structures, and plans of either planner that are timed; fifty times as many with the full counts.
const SIZES: [(&str, usize, usize); 9] = [
    ("3x1", 200, 60),
    ("2x2", 200, 60),
    ("4x1", 200, 60),
    ("4x2", 200, 40),
    ("3x3", 200, 40),
    ("5x5", 200, 20),
    ("10x10", 40, 5),
    ("20x20", 10, 2),
    ("32x32", 6, 2),
];
const MORE: usize = 50;

#[test]
fn table_e_times() {
    let _alone = alone();
    let kind = Kind::new(Parameters::default());
    let mut table = String::new();
    table += "(e) Time for a whole plan on one thread, ms (60 % of the envelope)\n";
    table += "                                |             exact                 |     potential field\n";
    table += "structure modules demands       | plans      p50      p99       max | plans      p50      p99       max\n";
    let mut growth = String::new();
    for sequence in [NEAR, Sequence::Apart] {
        let mut figures = Vec::new();
        for (name, plans, field_plans) in SIZES {
            let structure = structure(name);
            let modules = structure.len();
            let time = |planner, plans: usize| -> Rows {
                let (structure, kind, config) = (structure.clone(), kind.clone(), settings(planner));
                // A few walks, so that no single one decides.
                let walks = plans.clamp(1, 5);
                DemandStream {
                    structure,
                    kind,
                    config,
                    share: SHARE,
                    sequence,
                    walks,
                    each: plans / walks,
                    times: 3,
                }
                .run()
            };
            let more = if full() { MORE } else { 1 };
            let exact = time(PlannerKind::Exact, more * plans);
            let field = time(PlannerKind::PotentialField, more * field_plans);
            let [own, other] = [&exact, &field].map(|rows| rows.quantiles(|row| 1e-3 * row.plan_us));
            table += &format!(
                "{name:<9} {modules:>7} {sequence:<13} | {:>5} {:>8.3} {:>8.3} {:>9.3} | {:>5} {:>8.3} {:>8.3} {:>9.3}\n",
                exact.0.len(),
                own.median,
                own.p99,
                own.most,
                field.0.len(),
                other.median,
                other.p99,
                other.most,
            );
            figures.push((modules as f64, exact.mean(|row| 1e-3 * row.plan_us), own.p99));
        }
        let [.., hundred, _, most] = figures[..] else { unreachable!("nine sizes") };
        let ratio = |a: f64, b: f64| a / b / (most.0 / hundred.0);
        growth += &format!(
            "{sequence}: from 100 to 1024 modules the mean grows by {:.2} × linear, the 99th percentile by {:.2} × linear\n",
            ratio(most.1, hundred.1),
            ratio(most.2, hundred.2),
        );
    }
    print!("\n{table}{growth}");
}
