//! The loop that a batch of plans from Python is measured against: `host/python/bench/plans.py` starts it.
//!
//! Its argument is a file of demands, three numbers of 64 bits each. For every line of standard input it plans for all of them, one after
//! the other, and prints how many seconds of the processor that took and the sum of all errors.

use std::io::{BufRead, Write};
use std::sync::Arc;

use modboat::distance::DistanceToCollision;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::plan::Plan;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::structure::Structure;
use rustix::time::{ClockId, clock_gettime};

/// What this thread has had of a processor, s: what else goes on does not count.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn main() {
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    let (Some(shape), Some(file)) = (words.next(), words.next()) else {
        println!("started by host/python/bench/plans.py");
        return;
    };
    let bytes = std::fs::read(file).expect("the demands");
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|number| f64::from_ne_bytes(*number)).collect();
    let demands = numbers.as_chunks::<3>().0;
    let structure = Structure::from_word(&shape).expect("columns x rows");
    let (parameters, config) = (Parameters::default(), PlannerConfig::default());
    let distance = Arc::new(DistanceToCollision::new(&parameters));
    let mut planner = Planner::with_distance(&structure, &parameters, &config, distance);
    for line in std::io::stdin().lock().lines() {
        line.expect("a line");
        let (mut plan, mut errors) = (Plan::default(), 0.0);
        let began_s = processor_s();
        for &demand in demands {
            planner.plan_into(Wrench::from_array(demand), None, None, &mut plan);
            errors += plan.error;
        }
        println!("{} {errors}", processor_s() - began_s);
        std::io::stdout().flush().expect("a reader");
    }
}
