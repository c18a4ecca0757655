//! Three emulated modules swim a shortened experiment 1 in real time, as three in the host's process do.

use std::sync::atomic::AtomicBool;

use host::run::experiment::{Pace, Quiet, run};
use host::run::fleet::InProcess;
use host::run::scenario::Scenario;
use protocol::units::Micros;
use qemu::fleet::Emulated;

const SEED: u64 = 1;

fn scenario() -> Scenario {
    let text = "name = \"emulated\"\ndescription = \"Experiment 1, shortened\"\n[structure]\nsize = \"3x1\"\n[[leg]]\n\
                duration_s = 15.0\nvelocity_m_s = [0.04, 0.0]\nheading_rad = 1.5707963267948966\n";
    Scenario::parse("emulated.toml", text).expect("a scenario")
}

#[test]
fn swims_as_in_process() {
    let scenario = scenario();
    let stop = AtomicBool::new(false);
    // In process: every tail at every millisecond since the first cycle began.
    let mut reference = InProcess::new(&scenario, SEED).expect("a fleet");
    let mut courses: Vec<Vec<f64>> = Vec::new();
    let simulated = run(
        &scenario,
        SEED,
        &mut reference,
        Pace::Simulated,
        &mut Quiet,
        &stop,
        &mut |now, origin, fleet| {
            if origin.is_some_and(|origin| origin <= now) {
                courses.push(fleet.modules().iter().map(|module| module.tail().angle_rad).collect());
            }
        },
    )
    .expect("a run");

    let mut fleet = Emulated::start(
        &scenario,
        SEED,
        &std::env::var("QARGS").map(|s| s.leak().split(' ').collect::<Vec<_>>()).unwrap_or_default(),
    );
    let mut began: Option<Micros> = None;
    let emulated =
        run(&scenario, SEED, &mut fleet, Pace::Real, &mut Quiet, &stop, &mut |_, origin, _| began = origin)
            .expect("a run");
    let began = began.expect("it began");
    for (a, b) in simulated.record.cycles.iter().zip(&emulated.record.cycles) {
        println!("{} {:.3} {:.3} {:.3}", a.number, a.start_s, b.start_s, a.transition_s - b.transition_s);
        for (s, t) in a.swings.iter().zip(&b.swings) {
            print!(
                "   {:.4}/{:.4} {:.4}/{:.4}",
                s.centerline_rad, t.centerline_rad, s.amplitude_rad, t.amplitude_rad
            );
        }
        println!();
    }
    for (index, seen) in fleet.seen.iter().enumerate() {
        let mut sum = 0.0;
        let mut n = 0;
        let mut worst: f64 = 0.0;
        let mut late = Vec::new();
        for s in seen {
            late.push(s.arrival.0 as i64 - s.telemetry.at.0 as i64);
            if s.telemetry.at < began {
                continue;
            }
            let t = (s.telemetry.at.0 - began.0) as f64 / 1000.0;
            let k = t as usize;
            if k + 1 >= courses.len() {
                continue;
            }
            let f = t - k as f64;
            let r = courses[k][index] * (1.0 - f) + courses[k + 1][index] * f;
            let d = f64::from(s.telemetry.tail.0) - r;
            sum += d * d;
            n += 1;
            worst = worst.max(d.abs());
        }
        late.sort();
        println!(
            "module {}: {n} reports, rms {:.4} rad, worst {worst:.4}; arrival-at us: min {} median {} 99% {} max {}",
            index + 1,
            (sum / n as f64).sqrt(),
            late[0],
            late[late.len() / 2],
            late[late.len() * 99 / 100],
            late[late.len() - 1]
        );
    }
    for m in &mut fleet.modules {
        for l in m.lines().iter().rev().take(3) {
            println!("{l}");
        }
    }
    println!("{:?}", emulated.summary.legs);
}
