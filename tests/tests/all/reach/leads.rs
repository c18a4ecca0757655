//! The lead of a prepared cycle keeps its promise: counted at the modules, by fleet and loss.
//!
//! `FLOTILLA_CYCLES=2000 cargo test -p tests --test all reach::leads -- --nocapture` counts more cycles of each.

use link::delivery::COMMIT_LEAD;
use link::faults::FaultParameters;
use link::lead::{UNCOMMITTED, UNPREPARED};
use modboat::parameters::Parameters;
use protocol::Delivery;
use protocol::time::Duration;
use tests::seeds::{number, on_all_cores};

use super::calculation::two_phase;
use super::rig::Rig;

/// Cycles in which the losses are measured first.
const WARM_UP: usize = 10;
const FLEETS: [u16; 4] = [3, 9, 25, 49];
const LOSSES: [f64; 4] = [0.0, 0.1, 0.3, 0.4];
/// Time under way, s: the shortest, and what is drawn beyond it.
const DELAY_S: [f64; 2] = [0.005, 0.01];

/// What became of the cycles of one fleet at one loss.
#[derive(Clone, Copy, Default)]
struct Count {
    cycles: usize,
    /// Every module could run it at its start.
    in_time: usize,
    dropped: usize,
    /// Some modules could run it, and others not.
    split: usize,
    lead_s: f64,
}

fn span(seconds: f64) -> Duration {
    Duration((seconds * 1e6).round() as u32)
}

/// Cycles that are sent with the lead that suits what is measured, or always 0.3 s ahead.
fn count(modules: u16, loss: f64, suits: bool, cycles: usize) -> Count {
    let seed = u64::from(modules) * 1_000 + (loss * 100.0) as u64;
    let mut rig = Rig::new(modules, seed);
    let [delay_s, jitter_s] = DELAY_S;
    let weather = FaultParameters { loss, delay_s, jitter_s, ..FaultParameters::default() };
    let (least, most) = (super::lead_us() as u32, span(Parameters::default().period_s));
    let mut count = Count::default();
    for cycle in 0..WARM_UP + cycles {
        let measured = rig.lead().total().min(most).max(Duration(least));
        let lead = if suits { measured } else { Duration(least) };
        let reached = rig.cycle(weather, lead, Delivery::Prepare);
        if cycle < WARM_UP {
            continue;
        }
        count.cycles += 1;
        count.in_time += usize::from(reached.modules == usize::from(modules));
        count.split += usize::from((1..usize::from(modules)).contains(&reached.modules));
        count.dropped += usize::from(reached.dropped);
        count.lead_s += f64::from(lead.as_secs_f32()) / cycles as f64;
    }
    count
}

/// At most so many of `cycles` that happen with probability `share` at most: five standard deviations, and one.
fn at_most(cycles: usize, share: f64) -> usize {
    let expected = cycles as f64 * share;
    (expected + 5.0 * expected.sqrt() + 1.0) as usize
}

#[test]
fn prepared_cycles_are_committed_in_time_at_any_loss_that_is_measured() {
    let cycles = number("FLOTILLA_CYCLES").unwrap_or(60) as usize;
    let all = on_all_cores(0..32, |index| {
        let (fleet, loss, suits) = (index / 8, index / 2 % 4, index % 2 == 1);
        count(FLEETS[fleet as usize], LOSSES[loss as usize], suits, cycles)
    });
    println!(
        "\n{cycles} cycles each, {DELAY_S:?} s under way\nmodules  loss    0.3 s ahead   as measured    lead"
    );
    for (pair, both) in all.chunks(2).enumerate() {
        let (modules, loss) = (FLEETS[pair / 4], LOSSES[pair % 4]);
        let [fixed, suited] = both else { unreachable!("chunks of two") };
        // With the least commit lead, as without a measurement.
        let mean_us = (1e6 * (DELAY_S[0] + 0.5 * DELAY_S[1])) as u64;
        let least_us = u64::from(COMMIT_LEAD.0);
        let before = two_phase(loss, mean_us, super::lead_us(), least_us, usize::from(modules));
        let share = |count: &Count| 100.0 * count.in_time as f64 / count.cycles as f64;
        println!(
            "{modules:>7} {:>3.0} % {:>22.2} % {:>11.2} % {:>11.2} % {:>5.0} ms",
            100.0 * loss,
            100.0 * (1.0 - before.dropped - before.split),
            share(fixed),
            share(suited),
            1e3 * suited.lead_s
        );
        let what = format!("{modules} modules, {loss}: {} dropped, {} split", suited.dropped, suited.split);
        assert!(suited.dropped <= at_most(cycles, UNPREPARED), "{what}");
        assert!(suited.split <= at_most(cycles, UNCOMMITTED), "{what}");
        assert_eq!(suited.in_time + suited.dropped + suited.split, cycles, "{what}");
        // Nothing is waited for that is not needed.
        assert!(loss > 0.0 || suited.lead_s < 0.301, "{modules} modules without loss: {} s", suited.lead_s);
    }
    let lossy = all.iter().step_by(2).skip(3).step_by(4);
    let dropped: usize = lossy.map(|fixed| fixed.dropped).sum();
    assert!(dropped > cycles / 10, "the rig drops nothing at a fixed lead: {dropped}");
}
