//! One environment: an episode after the other, each from its seed.
//!
//! Everything random of an episode follows from its seed: start, what is asked for, and in the fidelity `module` the modules' clocks and
//! boot times, spread, gusts and the medium. A reset without a seed draws the next one from the environment's own.

use std::sync::Arc;

use host::run::scenario::{Demand, Scenario};
use modboat::motion::Wrench;
use modboat::planner_kind::PlannerKind;
use quantity::wrap_rad;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use record::PoseSample;

use crate::baseline::{Allocator, Baseline};
use crate::command::Command;
use crate::goal::{Asked, asked, draw, mean_velocity_m_s, mean_yaw_rate_rad_s};
use crate::layout::{INFO, Info, Layout, SHARED, in_structure};
use crate::mean::Mean;
use crate::modules::Modules;
use crate::settings::{ActionKind, ContactRule, EnvironmentError, Fidelity, Settings, Task};

/// What a step came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// See [`crate::goal`].
    pub reward: f64,
    /// Tails touched where that ends an episode, or a module took no cycle any more.
    pub terminated: bool,
    /// The time of the episode is over.
    pub truncated: bool,
}

enum Simulation {
    Modules(Box<Modules>),
    Mean(Box<Mean>),
}

/// See the module's documentation.
pub struct Environment {
    settings: Arc<Settings>,
    layout: Arc<Layout>,
    /// That of the settings, with the start of this episode.
    scenario: Scenario,
    rng: ChaCha8Rng,
    simulation: Option<Simulation>,
    asked: Option<Asked>,
    before: PoseSample,
    now: PoseSample,
    command: Command,
    /// What the next command is written into.
    next: Command,
    wrench: Wrench,
    allocator: Option<Allocator>,
    baseline: Option<Baseline>,
    info: Info,
    is_over: bool,
}

impl Environment {
    /// Before its first reset.
    #[must_use]
    pub fn new(settings: Arc<Settings>, layout: Arc<Layout>) -> Self {
        let scenario = settings.scenario.clone();
        let wants_planner = settings.action == ActionKind::Wrench;
        Self {
            allocator: wants_planner
                .then(|| Allocator::new(&scenario, PlannerKind::Exact, Arc::clone(&layout.distance))),
            scenario,
            settings,
            layout,
            rng: ChaCha8Rng::seed_from_u64(0),
            simulation: None,
            asked: None,
            before: PoseSample::default(),
            now: PoseSample::default(),
            command: Command::default(),
            next: Command::default(),
            wrench: Wrench::default(),
            baseline: None,
            info: [0.0; INFO.len()],
            is_over: true,
        }
    }

    /// Begins an episode, and writes what is seen then.
    ///
    /// # Errors
    /// [`EnvironmentError`] for a scenario that cannot be simulated so.
    pub fn reset(&mut self, seed: Option<u64>, observation: &mut [f64]) -> Result<(), EnvironmentError> {
        if let Some(seed) = seed {
            self.rng = ChaCha8Rng::seed_from_u64(seed);
        }
        let episode: u64 = self.rng.random();
        let mut rng = ChaCha8Rng::seed_from_u64(episode);
        let Self { settings, layout, scenario, .. } = self;
        let goal = draw(settings.task, &mut rng, &settings.scenario, &mut scenario.start);
        // A run of legs from the seed itself is the run of `flotilla run --seed`.
        let seed = if settings.task == Task::Legs { seed.unwrap_or(episode) } else { episode };
        match (settings.fidelity, &mut self.simulation) {
            (Fidelity::Module, simulation) => {
                *simulation = Some(Simulation::Modules(Box::new(Modules::new(scenario, seed)?)));
            }
            (Fidelity::Cycle, simulation) => {
                if simulation.is_none() {
                    let Scenario { structure, modboat, tank, timing, .. } = &*scenario;
                    let distance = Arc::clone(&layout.distance);
                    let mean = Mean::new(structure, modboat, tank, timing.lead_s, distance)?;
                    *simulation = Some(Simulation::Mean(Box::new(mean)));
                }
                if let Some(Simulation::Mean(mean)) = simulation {
                    mean.place(&scenario.start_pose(), scenario.start.tail_rad);
                }
            }
        }
        self.asked = Some(goal);
        self.wrench = Wrench::default();
        self.command.cycle.clear();
        self.command.turns.clear();
        self.is_over = false;
        if let Some(baseline) = &mut self.baseline {
            baseline.forget(&self.scenario);
        }
        self.now = self.pose();
        self.before = self.now;
        self.tell(0);
        self.observe(observation);
        Ok(())
    }

    /// One cycle by `action`, and writes what is seen then. After the end of an episode it begins the next one instead, where the settings
    /// say so. `index` names it in errors.
    ///
    /// # Errors
    /// [`EnvironmentError`], among them for a number of the action that is not finite.
    pub fn step(
        &mut self,
        index: usize,
        action: &[f64],
        observation: &mut [f64],
    ) -> Result<Outcome, EnvironmentError> {
        if self.is_over && self.settings.autoreset {
            self.reset(None, observation)?;
            return Ok(Outcome::default());
        }
        let (Some(goal), false) = (self.asked, self.is_over) else {
            return Err(EnvironmentError::Over { environment: index });
        };
        if let Some(at) = action.iter().position(|value| !value.is_finite()) {
            return Err(EnvironmentError::Action { environment: index, index: at, value: action[at] });
        }
        self.decide(action);
        std::mem::swap(&mut self.command, &mut self.next);
        self.wrench = self.command.wrench(&self.scenario.modboat, &self.layout.positions_m);
        let contacts = match &mut self.simulation {
            Some(Simulation::Modules(modules)) => modules.run(&self.command)?,
            Some(Simulation::Mean(mean)) => mean.run(&self.command, self.wrench),
            None => 0,
        };
        let now = self.pose();
        self.before = std::mem::replace(&mut self.now, now);
        let reward = goal.reward(&self.before, &self.now, self.scenario.modboat.period_s);
        let (starts_s, is_stuck) = self.progress();
        if self.settings.task == Task::Legs {
            // A cycle that straddles two legs belongs to the one that has more of it.
            self.asked = Some(asked(&self.scenario, starts_s + 0.5 * self.scenario.modboat.period_s));
        }
        let outcome = Outcome {
            reward: reward - contacts as f64,
            terminated: is_stuck || contacts > 0 && self.settings.contact == ContactRule::Terminate,
            truncated: starts_s >= self.settings.duration_s - 1e-9,
        };
        self.is_over = outcome.terminated || outcome.truncated;
        self.tell(contacts);
        self.observe(observation);
        Ok(outcome)
    }

    /// Writes what the baseline of this kind would do now: an action as the settings have it. Zeros where no episode is under way.
    pub fn advise(&mut self, kind: PlannerKind, action: &mut [f64]) {
        action.fill(0.0);
        let (Some(goal), false) = (self.asked, self.is_over) else { return };
        if self.baseline.as_ref().is_none_or(|baseline| baseline.kind != kind) {
            let distance = Arc::clone(&self.layout.distance);
            self.baseline = Some(Baseline::new(&self.scenario, kind, distance));
        }
        let tails_rad = rests_rad(self.simulation.as_ref());
        let Some(baseline) = &mut self.baseline else { return };
        let demand = baseline.demand(&goal, (&self.before, &self.now), &self.command, &self.scenario);
        match self.settings.action {
            ActionKind::Wrench => action.copy_from_slice(&demand.to_array()),
            ActionKind::Swing => {
                let before = &self.command.cycle;
                baseline.allocator.allocate(demand, tails_rad, before, &self.scenario, &mut self.next);
                self.next.write_swings(action);
            }
        }
    }

    /// What is told beside observation and reward.
    #[must_use]
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// What is asked for now; nothing before the first reset.
    #[must_use]
    pub fn asked(&self) -> Option<&Asked> {
        self.asked.as_ref()
    }

    /// The command that runs.
    #[must_use]
    pub fn command(&self) -> &Command {
        &self.command
    }

    /// From an action to the next command.
    fn decide(&mut self, action: &[f64]) {
        let tails_rad = rests_rad(self.simulation.as_ref());
        match (&mut self.allocator, action) {
            (Some(allocator), &[fx_n, fy_n, tau_nm]) => {
                let [low, high] = [&self.layout.action_low, &self.layout.action_high];
                let clamped = [0, 1, 2].map(|axis| [fx_n, fy_n, tau_nm][axis].clamp(low[axis], high[axis]));
                let demand = Wrench::from_array(clamped);
                let before = &self.command.cycle;
                allocator.allocate(demand, tails_rad, before, &self.scenario, &mut self.next);
            }
            _ => self.next.take_swings(action, tails_rad, &self.scenario.modboat),
        }
    }

    fn pose(&self) -> PoseSample {
        match &self.simulation {
            Some(Simulation::Modules(modules)) => modules.pose(),
            Some(Simulation::Mean(mean)) => mean.pose(),
            None => PoseSample::default(),
        }
    }

    /// When the next cycle starts, s, and whether a module takes none any more.
    fn progress(&self) -> (f64, bool) {
        match &self.simulation {
            Some(Simulation::Modules(modules)) => (modules.starts_s(), modules.is_stuck()),
            Some(Simulation::Mean(mean)) => (mean.starts_s(), false),
            None => (0.0, false),
        }
    }

    fn tell(&mut self, contacts: usize) {
        let (starts_s, is_stuck) = self.progress();
        let PoseSample { position_m: [x_m, y_m], heading_rad, t_s, .. } = self.now;
        self.info = [
            starts_s,
            t_s - self.before.t_s,
            x_m,
            y_m,
            heading_rad,
            contacts as f64,
            f64::from(u8::from(is_stuck)),
        ];
    }

    fn observe(&self, observation: &mut [f64]) {
        let (Some(goal), Some((shared, tails))) = (self.asked, observation.split_at_mut_checked(SHARED))
        else {
            return;
        };
        let heading_rad = self.now.heading_rad;
        let turned = heading_rad.sin_cos();
        let in_s = |vector| in_structure(turned, vector);
        let (place_m, velocity_m_s) = match goal.demand {
            Demand::Station(station_m) => {
                let place_m = [0, 1].map(|axis| station_m[axis] - self.now.position_m[axis]);
                (in_s(place_m), [0.0; 2])
            }
            Demand::Velocity(velocity_m_s) => ([0.0; 2], in_s(velocity_m_s)),
        };
        let mean_m_s = in_s(mean_velocity_m_s(&self.before, &self.now));
        let (sin, cos) = wrap_rad(goal.heading_rad - heading_rad).sin_cos();
        let rate_rad_s = mean_yaw_rate_rad_s(&self.before, &self.now);
        let Wrench { fx_n, fy_n, tau_nm } = self.wrench;
        shared.copy_from_slice(&[
            place_m[0],
            place_m[1],
            velocity_m_s[0],
            velocity_m_s[1],
            mean_m_s[0],
            mean_m_s[1],
            sin,
            cos,
            rate_rad_s,
            fx_n,
            fy_n,
            tau_nm,
        ]);
        for (pair, tail_rad) in tails.chunks_exact_mut(2).zip(rests_rad(self.simulation.as_ref())) {
            let (sin, cos) = tail_rad.sin_cos();
            pair.copy_from_slice(&[sin, cos]);
        }
    }
}

fn rests_rad(simulation: Option<&Simulation>) -> &[f64] {
    match simulation {
        Some(Simulation::Modules(modules)) => modules.rests_rad(),
        Some(Simulation::Mean(mean)) => mean.rests_rad(),
        None => &[],
    }
}
