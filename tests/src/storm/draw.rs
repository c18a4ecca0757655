//! The draw of a storm: all its faults, from its seed.

use host::run::scenario::{Demand, Leg, Scenario};
use link::faults::FaultParameters;
use modboat::planner_config::LossTolerance;
use modboat::structure::Structure;
use protocol::time::Duration;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::{CALM_S, Outcome, STEP_S, STORM_S, TICK_US, World};

/// One storm: its fleet and its faults.
#[derive(Clone, Debug)]
pub struct Storm {
    /// Modules: 3, 9 or 25.
    pub modules: usize,
    /// Decides everything.
    pub seed: u64,
    /// What the medium does.
    pub weather: FaultParameters,
    /// Whether what is under way when the medium heals is lost.
    pub drop_under_way: bool,
    /// Reboots of modules: when, which module, for how long.
    pub(super) reboots: Vec<(u64, usize, Duration)>,
    /// Clock steps: when, which module, by how much, s.
    pub(super) steps: Vec<(u64, usize, f64)>,
    /// Deaths of the host: when, for how long, µs.
    pub(super) deaths: Vec<(u64, u64)>,
    /// Faults of ends rather than of the medium.
    pub(super) kinds: Kinds,
}

/// A machine that has refused sends lets some through for that long at least, before it refuses again.
const REFUSES_AGAIN_US: u64 = 200_000;

/// Faults of machines, hosts and modules, and what strangers do. Times in µs.
#[derive(Clone, Debug, Default)]
pub(super) struct Kinds {
    /// Share of sends that fail, at every radio.
    pub(super) send_errors: f64,
    /// Sends of one node all fail: from when, until when, which node.
    pub(super) refusals: Vec<(u64, u64, usize)>,
    /// The host does not run: when, for how long.
    pub(super) pauses: Vec<(u64, u64)>,
    /// A second module with a number: which module, when it gets power, when it loses it.
    pub(super) double: Option<(usize, u64, u64)>,
    /// Announcements of so many old boots are played round to the host, one a millisecond.
    pub(super) recordings: usize,
    /// Forged calls a second.
    pub(super) calls_per_s: f64,
    /// A module that lies: which, from when, until when.
    pub(super) liar: Option<(usize, u64, u64)>,
}

impl Kinds {
    /// Each kind in one storm of four, the doubled module and the liar in one of six.
    fn new(modules: usize, seed: u64) -> Self {
        const MS: u64 = 1_000;
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6B69_6E64);
        let healed_us = ((CALM_S + STORM_S) * 1e6) as u64;
        let at =
            |rng: &mut ChaCha8Rng| rng.random_range((CALM_S * 1e6) as u64..healed_us) / TICK_US * TICK_US;
        let mut kinds = Self::default();
        if rng.random_bool(0.25) {
            kinds.send_errors = rng.random_range(0.0..0.2);
            let refusals = (0..rng.random_range(0..4)).map(|_| {
                let from_us = at(&mut rng);
                let until_us = (from_us + rng.random_range(50..2_000) * MS).min(healed_us);
                (from_us, until_us, rng.random_range(0..=modules))
            });
            for refusal @ (from_us, until_us, node) in refusals {
                // Two that run into each other would be one that breaks the host's radio.
                let apart = |&(from, until, of): &(u64, u64, usize)| {
                    of != node || from_us > until + REFUSES_AGAIN_US || from > until_us + REFUSES_AGAIN_US
                };
                if kinds.refusals.iter().all(apart) {
                    kinds.refusals.push(refusal);
                }
            }
        }
        if rng.random_bool(0.25) {
            let pauses =
                (0..rng.random_range(1..3)).map(|_| (at(&mut rng), rng.random_range(600..5_000) * MS));
            kinds.pauses = pauses.collect();
        }
        if rng.random_bool(0.25) {
            kinds.recordings = rng.random_range(1..=20);
        }
        if rng.random_bool(0.25) {
            kinds.calls_per_s = rng.random_range(10.0..1_000.0);
        }
        let span = |rng: &mut ChaCha8Rng| {
            let from_us = at(rng);
            let until_us = (from_us + rng.random_range(500..10_000) * MS).min(healed_us);
            (rng.random_range(0..modules), from_us, until_us)
        };
        if rng.random_bool(1.0 / 6.0) {
            kinds.double = Some(span(&mut rng));
        }
        if rng.random_bool(1.0 / 6.0) {
            kinds.liar = Some(span(&mut rng));
        }
        kinds
    }
}

impl Storm {
    /// The storm of this seed.
    #[must_use]
    pub fn new(modules: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5707_2D00);
        let mut share = |most: f64| rng.random_range(0.0..most);
        let mut weather = FaultParameters {
            loss: share(0.4),
            duplication: share(0.3),
            corruption: share(0.05),
            truncation: share(0.05),
            delay_s: share(0.03),
            jitter_s: share(0.05),
            replay: share(0.3),
            replay_s: share(5.0),
            forgery: share(0.3),
            ..FaultParameters::default()
        };
        if share(1.0) < 0.5 {
            (weather.burst, weather.burst_s) = (share(0.2), 0.05 + share(0.5));
        }
        if share(1.0) < 0.5 {
            (weather.reordering, weather.reorder_s) = (share(0.3), 0.001 + share(0.2));
        }
        match share(4.0) {
            // Delays of up to a cycle, of all or of some.
            x if x < 1.0 => weather.jitter_s = share(1.5),
            x if x < 2.0 => (weather.late, weather.late_s) = (share(0.1), 0.001 + share(1.5)),
            _ => {}
        }
        let storm_us = (CALM_S * 1e6) as u64..((CALM_S + STORM_S) * 1e6) as u64;
        let at = |rng: &mut ChaCha8Rng| rng.random_range(storm_us.clone()) / TICK_US * TICK_US;
        let reboots = (0..rng.random_range(0..4)).map(|_| {
            let off = Duration(rng.random_range(50_000..1_000_000));
            (at(&mut rng), rng.random_range(0..modules), off)
        });
        let reboots = reboots.collect();
        let steps = (0..rng.random_range(0..4))
            .map(|_| (at(&mut rng), rng.random_range(0..modules), rng.random_range(-STEP_S..STEP_S)));
        let steps = steps.collect();
        let deaths =
            (0..rng.random_range(0..3)).map(|_| (at(&mut rng), rng.random_range(100_000..3_000_000)));
        let deaths = deaths.collect();
        let drop_under_way = rng.random_bool(0.5);
        let kinds = Kinds::new(modules, seed);
        Self { modules, seed, weather, drop_under_way, reboots, steps, deaths, kinds }
    }

    /// Whether no module's power and no host fails, so that only the medium is to blame.
    #[must_use]
    pub fn is_radio_only(&self) -> bool {
        let Kinds { pauses, double, liar, .. } = &self.kinds;
        let ends_fail = !pauses.is_empty() || double.is_some() || liar.is_some();
        self.reboots.is_empty() && self.deaths.is_empty() && !ends_fail
    }

    /// How far the clock that jumps most jumps, all jumps together, µs.
    pub(super) fn jumped_us(&self) -> u64 {
        let of = |module: usize| -> f64 {
            self.steps.iter().filter(|step| step.1 == module).map(|(_, _, by_s)| by_s.abs()).sum()
        };
        (1e6 * (0..self.modules).map(of).fold(0.0, f64::max)) as u64
    }

    pub(super) fn scenario(&self) -> Scenario {
        let mut scenario = Scenario::open("holonomic-1").expect("built in");
        let side = match self.modules {
            9 => [3, 3],
            25 => [5, 5],
            modules => [modules as i32, 1],
        };
        let cells: Vec<[i32; 2]> =
            (0..side[1]).flat_map(|row| (0..side[0]).map(move |col| [col, row])).collect();
        scenario.structure = Structure::from_cells(&cells).expect("connected");
        let demand = Demand::Velocity([0.03, 0.01]);
        scenario.legs = vec![Leg { duration_s: 1e4, demand, heading_rad: 1.5 }];
        scenario.clock.drift_ppm = 100.0;
        scenario.planner.loss_tolerant = LossTolerance::Power;
        scenario
    }

    /// Runs it.
    ///
    /// # Panics
    /// If the scenario cannot be run at all.
    #[must_use]
    pub fn run(&self) -> Outcome {
        World::new(self).run()
    }
}
