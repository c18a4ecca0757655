//! An emergency stop while a fleet swims in a bad medium: how soon every drive is off, and that nothing moves a tail again.
//!
//! `FLOTILLA_STOPS=1000 cargo test -p tests --test all stops:: -- --nocapture` prints the times of a thousand stops.

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run};
use host::run::fleet::InProcess;
use host::run::host::Controller;
use host::run::orders::{Operator, Order, RunStatus};
use host::run::pilot::Pilot;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use link::faults::FaultParameters;
use protocol::ModuleState;
use protocol::time::FleetInstant;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::cell::Cell;
use tests::seeds::{number, on_all_cores};

/// Orders what it is told to, once.
struct Told<'a>(&'a Cell<Option<Order>>);

impl Operator for Told<'_> {
    fn poll(&mut self, _: &dyn Fn() -> RunStatus) -> Option<Order> {
        self.0.take()
    }
}

/// Three, nine and twenty-five modules in turn.
const FLEETS: [&str; 3] = ["holonomic-1", "nine", "twenty-five"];
/// Share of datagrams lost, each way, and how long the others take, s.
const LOSS: f64 = 0.3;
const DELAY_S: f64 = 0.01;
/// Until then every drive is to be off, in 99 of 100 stops, s.
const OFF_WITHIN_S: f64 = 0.3;

/// What became of one stop.
struct Stop {
    /// From the order until the last module had stopped, s.
    off_s: f64,
    /// How far a tail turned from 0.3 s after that on, rad.
    turned_rad: f64,
    /// Whether a module was seen in another state after it had stopped.
    moved_again: bool,
}

/// Stops a fleet at a moment of its swim that the seed draws, and watches it for two seconds.
fn stop(seed: u64) -> Stop {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut scenario = Scenario::open(FLEETS[seed as usize % FLEETS.len()]).expect("built in");
    scenario.radio = FaultParameters { loss: LOSS, delay_s: DELAY_S, ..FaultParameters::default() };
    // How soon all have joined is not what is asked here.
    scenario.timing.join_s = 60.0;
    let at_s = rng.random_range(2.0..7.0);
    let mut fleet = InProcess::boats(&scenario, seed).expect("a fleet");
    let order = Cell::new(None);
    let mut ordered: Option<FleetInstant> = None;
    let mut seen = Stop { off_s: f64::INFINITY, turned_rad: 0.0, moved_again: false };
    let mut rested: Option<Vec<f64>> = None;
    let mut watch = |now: FleetInstant, pilot: &Pilot, fleet: &mut InProcess| {
        let since_s = |at: FleetInstant| now.as_secs_f64() - at.as_secs_f64();
        let Some(pressed) = ordered else {
            if pilot.origin().is_some_and(|origin| since_s(origin) >= at_s) {
                order.set(Some(Order::Stop));
                ordered = Some(now);
            }
            return;
        };
        let stopped = fleet.modules().iter().all(|module| module.state(now) == Some(ModuleState::Stopped));
        if stopped {
            seen.off_s = seen.off_s.min(since_s(pressed));
        } else if seen.off_s.is_finite() {
            seen.moved_again = true;
        }
        if since_s(pressed) >= seen.off_s + 0.3 {
            let angles = fleet.modules().iter().map(|module| module.tail().angle_rad);
            let rested = rested.get_or_insert_with(|| angles.clone().collect());
            let turned = angles.zip(rested.iter()).map(|(now, then)| (now - then).abs());
            seen.turned_rad = turned.fold(seen.turned_rad, f64::max);
        }
        if since_s(pressed) >= 2.0 {
            order.set(Some(Order::End));
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Told(&order), hook: &mut watch };
    let result = run(&scenario, seed, &mut fleet, drive, &mut Quiet);
    let summary = result.unwrap_or_else(|error| panic!("seed {seed}: {error}")).summary;
    assert!(!summary.complete, "seed {seed}");
    seen
}

#[test]
fn every_drive_is_off_soon_after_a_stop_and_stays_off() {
    let count = number("FLOTILLA_STOPS").unwrap_or(60);
    let stops = on_all_cores(0..count, stop);
    assert!(!stops.is_empty(), "no stop was asked for");
    for (seed, Stop { turned_rad, moved_again, .. }) in stops.iter().enumerate() {
        assert!(!moved_again, "seed {seed}: a module left its stop");
        // A braked tail creeps for as long as the water turns it.
        assert!(*turned_rad < 0.02, "seed {seed}: a tail turned by {turned_rad} rad after it was braked");
    }
    for (index, fleet) in FLEETS.iter().enumerate() {
        let mut off_s: Vec<f64> =
            stops.iter().skip(index).step_by(FLEETS.len()).map(|stop| stop.off_s).collect();
        off_s.sort_by(f64::total_cmp);
        let at = |share: f64| off_s[((off_s.len() - 1) as f64 * share).round() as usize];
        println!(
            "{fleet:<12} {:>4} stops at {:.0} % loss: drives off after {:.3} s (median), {:.3} s (99 %), {:.3} s (most)",
            off_s.len(),
            100.0 * LOSS,
            at(0.5),
            at(0.99),
            at(1.0)
        );
        let late = off_s.iter().filter(|off_s| **off_s > OFF_WITHIN_S).count();
        assert!(late * 100 <= off_s.len(), "{fleet}: {late} of {} stops took longer", off_s.len());
    }
}
