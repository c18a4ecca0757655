//! Three emulated modules execute, over UDP and in lock step with their host, the plan of a shortened experiment 1, as three in the
//! host's process do.
//!
//! Both get the same cycles. Two runs that plan for themselves do not: which of several equally good cycles is taken turns on the last
//! digit of an observed pose, and after a few seconds the plans have nothing in common but what they achieve.

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, RunResult, run};
use host::run::fleet::InProcess;
use host::run::orders::Unattended;
use host::run::pilot::{Pilot, SentCycle};
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use protocol::time::{Duration, FleetInstant};
use qemu::bench::{Bench, Seen};

const SEED: u64 = 1;

/// How long a cycle is sent before it starts, as in `flotilla run`.
const LEAD: Duration = Duration(300_000);

/// From the first order to the first cycle.
const NOTICE: Duration = Duration(500_000);

/// What is allowed: a tick, and two milliseconds between two reports; for the host a step more, in which the report is on its way.
const START_MAX_US: i64 = 3_000;
/// *Assumed*: planned clearances bear several times as much.
const RMS_MAX_RAD: f64 = 0.01;

fn scenario() -> Scenario {
    let text = "name = \"emulated\"\ndescription = \"Experiment 1, shortened\"\n[structure]\nsize = \"3x1\"\n[[leg]]\n\
                duration_s = 20.0\nvelocity_m_s = [0.04, 0.0]\nheading_rad = 1.5707963267948966\n";
    Scenario::parse("emulated.toml", text).expect("a scenario")
}

/// The run in this process, and every tail at every millisecond since its first cycle began.
fn in_process(scenario: &Scenario) -> (RunResult, Vec<Vec<f64>>) {
    let mut fleet = InProcess::boats(scenario, SEED).expect("a fleet");
    let mut courses: Vec<Vec<f64>> = Vec::new();
    let mut watch = |now: FleetInstant, pilot: &Pilot, fleet: &mut InProcess| {
        // Turns before the first swim are part of it.
        if pilot.decisions().first().is_some_and(|first| first.start <= now) {
            courses.push(fleet.modules().iter().map(|module| module.tail().angle_rad).collect());
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut watch };
    let result = run(scenario, SEED, &mut fleet, drive, &mut Quiet);
    (result.expect("a run"), courses)
}

/// Signed, µs.
fn less(a: FleetInstant, b: FleetInstant) -> i64 {
    a.0 as i64 - b.0 as i64
}

/// When a module began `cycle`: by its own fleet time between these two, and by the host's clock no later than the third.
fn began(seen: &[Seen], cycle: u32) -> Option<(FleetInstant, FleetInstant, FleetInstant)> {
    let first = seen.iter().position(|seen| seen.telemetry.cycle >= cycle)?;
    let before = seen.get(first.checked_sub(1)?)?;
    Some((before.telemetry.at, seen[first].telemetry.at, seen[first].arrival))
}

/// What both execute.
struct Plan {
    /// Starts are those of the run in this process.
    orders: Vec<SentCycle>,
    /// When the first one starts there.
    origin: FleetInstant,
    /// When the last one ends there.
    end: FleetInstant,
    /// Every tail of that run at every millisecond since.
    courses: Vec<Vec<f64>>,
}

impl Plan {
    fn of(scenario: &Scenario) -> Self {
        let (RunResult { decisions, .. }, courses) = in_process(scenario);
        let origin = decisions.first().expect("it decided").start;
        let length_us = courses.len() as u64 * 1_000;
        // Only what was run to its end.
        let whole = || decisions.iter().filter(|decision| decision.end().0 - origin.0 <= length_us);
        let orders: Vec<_> = whole().flat_map(|decision| decision.sent_cycles()).collect();
        assert!(orders.len() >= 10, "{} cycles", orders.len());
        let end = whole().map(|decision| decision.end()).max().expect("some");
        Self { orders, origin, end, courses }
    }

    /// Where tail `index` was, `us` after the first start.
    fn tail_rad(&self, index: usize, us: u64) -> Option<f64> {
        let (ms, rest) = ((us / 1_000) as usize, (us % 1_000) as f64 * 1e-3);
        let [before, after] = self.courses.get(ms..ms + 2)? else { return None };
        Some(before[index] + (after[index] - before[index]) * rest)
    }
}

/// What one module made of the plan.
struct Made {
    reports: usize,
    rms_rad: f64,
    worst_rad: f64,
    /// Of each cycle after its start, µs: the report before it began, the first one since, and when that came to the host.
    starts_us: Vec<[i64; 3]>,
    /// Its fleet time less the host's clock, at most.
    ahead_us: i64,
}

impl Made {
    /// Of the plan that began at `origin`, by what the module with this index reported.
    fn of(plan: &Plan, index: usize, origin: FleetInstant, seen: &[Seen]) -> Self {
        let errors_rad: Vec<f64> = seen
            .iter()
            .filter_map(|seen| {
                let us = seen.telemetry.at.0.checked_sub(origin.0)?;
                Some(f64::from(seen.telemetry.tail.0) - plan.tail_rad(index, us)?)
            })
            .collect();
        let squares: f64 = errors_rad.iter().map(|error| error * error).sum();
        let starts_us = plan.orders.iter().map(|order| {
            let start = FleetInstant(order.start.0 - plan.origin.0 + origin.0);
            let (before, after, arrival) = began(seen, order.number)
                .unwrap_or_else(|| panic!("module {} never began cycle {}", index + 1, order.number));
            [before, after, arrival].map(|at| less(at, start))
        });
        Self {
            reports: errors_rad.len(),
            rms_rad: (squares / errors_rad.len() as f64).sqrt(),
            worst_rad: errors_rad.iter().fold(0.0, |worst, error| worst.max(error.abs())),
            starts_us: starts_us.collect(),
            ahead_us: seen.iter().map(|seen| less(seen.telemetry.at, seen.arrival)).max().expect("reports"),
        }
    }

    fn is_within(&self) -> bool {
        let on_time = |[before, after, arrival]: &[i64; 3]| {
            *before < START_MAX_US && after.abs() <= START_MAX_US && *arrival <= START_MAX_US
        };
        self.rms_rad <= RMS_MAX_RAD && self.ahead_us <= START_MAX_US && self.starts_us.iter().all(on_time)
    }
}

impl std::fmt::Display for Made {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { reports, rms_rad, worst_rad, starts_us, ahead_us } = self;
        let ms = |us: Option<i64>| us.unwrap_or(0) as f64 * 1e-3;
        let of = |which: usize| starts_us.iter().map(move |start| start[which]);
        write!(
            f,
            "{reports} reports, RMS {rms_rad:.4} rad, at most {worst_rad:.4}; {} cycles begun {:.1} to {:.1} ms after their start by its \
             own fleet time, {:.1} ms by the host's clock with the way of the report; its fleet time {:.2} ms ahead at most",
            starts_us.len(),
            ms(of(1).min()),
            ms(of(1).max()),
            ms(of(2).max()),
            ms(Some(*ahead_us)),
        )
    }
}

/// Executes the plan on emulated modules: what each made of it.
fn execute(plan: &Plan, modules: usize) -> Vec<Made> {
    let mut bench = Bench::start(modules as u16, SEED);
    bench.until_ready();
    let origin = bench.now().after(NOTICE);
    let shifted = |start: FleetInstant| FleetInstant(start.0 - plan.origin.0 + origin.0);
    for order in &plan.orders {
        let start = shifted(order.start);
        bench.until("time to send", |bench, _| bench.now().after(LEAD) >= start);
        bench.dispatch(order.number, start, &order.motions);
    }
    bench.until("end", |bench, _| bench.now() >= shifted(plan.end));
    for link in bench.dispatcher.modules() {
        // The first word was enough: the loopback loses nothing.
        let asked = (link.ledger().acknowledged, link.ledger().refused, link.ledger().resent);
        assert_eq!(asked, (plan.orders.len() as u64, 0, 0));
    }
    bench.seen.iter().enumerate().map(|(index, seen)| Made::of(plan, index, origin, seen)).collect()
}

#[test]
fn three_emulated_modules_execute_a_plan_as_three_in_process_do() {
    let scenario = scenario();
    let plan = Plan::of(&scenario);
    let made = execute(&plan, scenario.structure.len());
    made.iter().zip(1..).for_each(|(made, id)| println!("module {id}: {made}"));
    assert!(made.iter().all(|made| made.reports > 5_000), "they report every 2 ms");
    assert!(made.iter().all(Made::is_within));
}
