//! Three emulated modules execute, in real time over UDP, the plan of a shortened experiment 1, as three in the host's process do.
//!
//! Both get the same cycles. Two runs that plan for themselves do not: which of several equally good cycles is taken turns on the last
//! digit of an observed pose, and after a few seconds the plans have nothing in common but what they achieve.

use std::sync::atomic::AtomicBool;

use host::run::experiment::{Pace, Quiet, RunResult, run};
use host::run::fleet::InProcess;
use host::run::scenario::Scenario;
use protocol::units::{Micros, MicrosSpan};
use qemu::bench::{Bench, Seen};

const SEED: u64 = 1;

/// A cycle is sent so long before it starts, as in `flotilla run`.
const LEAD: MicrosSpan = MicrosSpan(300_000);

/// From the first order to the first cycle.
const NOTICE: MicrosSpan = MicrosSpan(500_000);

/// What is allowed. *Assumed*: planned clearances bear twice as much.
const START_MAX_US: i64 = 5_000;
const RMS_MAX_RAD: f64 = 0.02;

fn scenario() -> Scenario {
    let text = "name = \"emulated\"\ndescription = \"Experiment 1, shortened\"\n[structure]\nsize = \"3x1\"\n[[leg]]\n\
                duration_s = 20.0\nvelocity_m_s = [0.04, 0.0]\nheading_rad = 1.5707963267948966\n";
    Scenario::parse("emulated.toml", text).expect("a scenario")
}

/// The run in this process, and every tail at every millisecond since its first cycle began.
fn in_process(scenario: &Scenario) -> (RunResult, Vec<Vec<f64>>) {
    let mut fleet = InProcess::new(scenario, SEED).expect("a fleet");
    let mut courses: Vec<Vec<f64>> = Vec::new();
    let stop = AtomicBool::new(false);
    let result =
        run(scenario, SEED, &mut fleet, Pace::Simulated, &mut Quiet, &stop, &mut |now, origin, fleet| {
            if origin.is_some_and(|origin| origin <= now) {
                courses.push(fleet.modules().iter().map(|module| module.tail().angle_rad).collect());
            }
        });
    (result.expect("a run"), courses)
}

/// Signed, µs.
fn less(a: Micros, b: Micros) -> i64 {
    a.0 as i64 - b.0 as i64
}

/// When a module began `cycle`: by its own fleet time between these two, and by the host's clock no later than the third.
fn began(seen: &[Seen], cycle: u32) -> Option<(Micros, Micros, Micros)> {
    let first = seen.iter().position(|seen| seen.telemetry.cycle >= cycle)?;
    let before = seen.get(first.checked_sub(1)?)?;
    Some((before.telemetry.at, seen[first].telemetry.at, seen[first].arrival))
}

#[test]
fn three_emulated_modules_execute_a_plan_as_three_in_process_do() {
    let scenario = scenario();
    let (result, courses) = in_process(&scenario);
    let reference = result.decisions.first().expect("it decided").start;
    let length_us = courses.len() as u64 * 1_000;

    let mut bench = Bench::start(scenario.structure.len() as u16, SEED);
    bench.until_ready();
    let origin = bench.now().after(NOTICE);
    let shifted = |start: Micros| Micros(start.0 - reference.0 + origin.0);
    // Only what the reference ran to its end.
    let decisions = result.decisions.iter().filter(|decision| decision.end().0 - reference.0 <= length_us);
    let orders: Vec<_> = decisions.flat_map(|decision| decision.orders()).collect();
    assert!(orders.len() >= 10, "{} cycles", orders.len());
    for order in &orders {
        let start = shifted(order.start);
        bench.until("time to send", |bench, _| bench.now().after(LEAD) >= start);
        bench.dispatch(order.number, start, &order.motions);
    }
    let end = shifted(result.decisions[orders.len().min(result.decisions.len()) - 1].end());
    bench.until("end", |bench, _| bench.now() >= end);

    println!("longest wait of the bench for its turn: {:?}", bench.stalled);
    for (index, seen) in bench.seen.iter().enumerate() {
        let (mut squares, mut worst_rad, mut count) = (0.0_f64, 0.0_f64, 0);
        for Seen { telemetry, .. } in seen.iter().filter(|seen| seen.telemetry.at >= origin) {
            let at_ms = (telemetry.at.0 - origin.0) as f64 * 1e-3;
            let Some([before, after]) = courses.get(at_ms as usize..at_ms as usize + 2) else { continue };
            let expected_rad = before[index] + (after[index] - before[index]) * at_ms.fract();
            let off_rad = f64::from(telemetry.tail.0) - expected_rad;
            squares += off_rad * off_rad;
            worst_rad = worst_rad.max(off_rad.abs());
            count += 1;
        }
        let rms_rad = (squares / f64::from(count)).sqrt();

        let mut errors_us = Vec::new();
        for order in &orders {
            let start = shifted(order.start);
            let (before, after, arrival) = began(seen, order.number)
                .unwrap_or_else(|| panic!("module {} never began cycle {}", index + 1, order.number));
            errors_us.push([less(before, start), less(after, start), less(arrival, start)]);
        }
        let ahead_us = seen.iter().map(|seen| less(seen.telemetry.at, seen.arrival)).max().expect("reports");
        let latest = |which: usize| errors_us.iter().map(|error| error[which]).max().expect("cycles");
        let earliest_us = errors_us.iter().map(|error| error[1]).min().expect("cycles");
        println!(
            "module {}: {count} reports, RMS {rms_rad:.4} rad, at most {worst_rad:.4}; {} cycles begun {:.1} to {:.1} ms after \
             their start by its own fleet time, and {:.1} ms by the host's clock with the way of the report; its fleet time is \
             {:.2} ms ahead of the host's at most",
            index + 1,
            orders.len(),
            earliest_us as f64 * 1e-3,
            latest(1) as f64 * 1e-3,
            latest(2) as f64 * 1e-3,
            ahead_us as f64 * 1e-3,
        );
        assert!(count > 5_000, "it reports every 2 ms: {count}");
        assert!(rms_rad <= RMS_MAX_RAD, "module {}: RMS {rms_rad} rad", index + 1);
        for (order, [before_us, after_us, arrival_us]) in orders.iter().zip(&errors_us) {
            let right = *before_us < START_MAX_US && *after_us >= -START_MAX_US && *after_us <= START_MAX_US;
            assert!(
                right && *arrival_us <= START_MAX_US && ahead_us <= START_MAX_US,
                "module {}, cycle {}: begun {before_us} to {after_us} µs after its start, seen after {arrival_us} µs",
                index + 1,
                order.number
            );
        }
    }
    // Nobody was asked twice: the loopback loses nothing.
    for link in bench.dispatcher.modules() {
        assert_eq!((link.ledger().acknowledged, link.ledger().refused), (orders.len() as u64, 0));
    }
}
