//! Plans of the potential field by the table of distances (§II-A of the paper) against plans by the collision regions: the same demands, the
//! same seeds, each planner going on from its own plans.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use criterion::Criterion;
use modboat::distance::DistanceToCollision;
use modboat::parameters::Parameters;
use modboat::plan::Outcome;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::planner_kind::PlannerKind;
use modboat::structure::Structure;
use modboat::table::{Row, Table};

use crate::demands::{SHAPES, Sequence, demands, planner, stream};

/// Demands in each sequence.
const DEMANDS: usize = 300;

/// Times each question is asked; the least time counts, which is what other work on the machine disturbs least.
const TIMES: usize = 3;

/// What became of one sequence.
#[derive(Default)]
struct Score {
    times_us: Vec<f64>,
    errors: Vec<f64>,
    planned: usize,
    met: usize,
}

impl Score {
    fn of(mut planner: Planner, structure: &Structure, sequence: Sequence) -> Self {
        let goal = PlannerConfig::default().error_goal;
        let mut score = Self::default();
        stream(&mut planner, &demands(structure, sequence, DEMANDS), sequence, |question, planner| {
            let mut time = Duration::MAX;
            for _ in 1..TIMES {
                let began = Instant::now();
                std::hint::black_box(question.ask(planner));
                time = time.min(began.elapsed());
            }
            let began = Instant::now();
            let plan = question.ask(planner);
            score.times_us.push(time.min(began.elapsed()).as_secs_f64() * 1e6);
            score.errors.push(plan.error);
            score.planned += usize::from(plan.outcome == Outcome::Planned);
            score.met += usize::from(plan.outcome == Outcome::Planned && plan.error <= goal);
            plan
        });
        score.times_us.sort_by(f64::total_cmp);
        score.errors.sort_by(f64::total_cmp);
        score
    }

    fn mean_us(&self) -> f64 {
        self.times_us.iter().sum::<f64>() / self.times_us.len() as f64
    }

    fn print(&self, search: &str, ratio: &str) {
        let at = |values: &[f64], share: f64| values[((values.len() - 1) as f64 * share) as usize];
        let percent = |count: usize| 100.0 * count as f64 / DEMANDS as f64;
        eprintln!(
            "  {search:<8} {:>8.0} {:>8.0} {:>8.0} {ratio:>7}    {:>7.4} {:>7.4} {:>7.4}   {:>6.1} {:>6.1}",
            at(&self.times_us, 0.5),
            self.mean_us(),
            at(&self.times_us, 0.95),
            at(&self.errors, 0.5),
            at(&self.errors, 0.9),
            at(&self.errors, 1.0),
            percent(self.planned),
            percent(self.met),
        );
    }
}

/// Every core computes its share of the rows.
fn on_all_cores(rows: Vec<Row<'_>>) {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let mut shares: Vec<Vec<Row<'_>>> = (0..cores).map(|_| Vec::new()).collect();
    rows.into_iter().enumerate().for_each(|(k, row)| shares[k % cores].push(row));
    thread::scope(|scope| {
        for share in shares {
            scope.spawn(|| share.into_iter().for_each(Row::compute));
        }
    });
}

/// Prints the comparison on standard error; nothing is left to criterion.
pub fn print(_: &mut Criterion) {
    // Told to test or to list, there is nobody to read it.
    if std::env::args().any(|argument| argument == "--test" || argument == "--list") {
        return;
    }
    let parameters = Parameters::default();
    let timed = |what: &str, began: Instant| {
        eprintln!("  {what:<34} {:>8.1} ms", began.elapsed().as_secs_f64() * 1e3);
    };
    eprintln!("\nStart-up");
    let began = Instant::now();
    let distance = Arc::new(DistanceToCollision::new(&parameters));
    timed("collision regions", began);
    let began = Instant::now();
    let generated = Table::generate_with(&parameters, on_all_cores);
    timed("table, generated on all cores", began);
    let file = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(file.path(), generated.encode(&parameters)).expect("written");
    let began = Instant::now();
    let bytes = std::fs::read(file.path()).expect("read");
    let table = Table::decode(&bytes, &parameters).expect("its own file");
    timed("table, loaded (with the regions)", began);
    assert!(table == generated, "what is kept is found again");
    let table = Arc::new(table);
    eprintln!("\n{DEMANDS} plans each, with transition and exact check");
    eprintln!(
        "  search     median     mean      95 %   ratio    error: 50 %    90 %    most   planned  goal met"
    );
    eprintln!(
        "                 µs       µs        µs                                               %       %"
    );
    let field = PlannerKind::PotentialField;
    for shape in SHAPES {
        let structure = Structure::from_word(shape).expect(shape);
        for sequence in Sequence::BOTH {
            eprintln!("{} modules, {}", structure.len(), sequence.name());
            let direct = Score::of(planner(field, &structure, &distance), &structure, sequence);
            let by_table = planner(field, &structure, &distance).with_table(Arc::clone(&table));
            let by_table = Score::of(by_table, &structure, sequence);
            direct.print("direct", "");
            by_table.print("table", &format!("{:.2}", by_table.mean_us() / direct.mean_us()));
        }
    }
    eprintln!();
}
