//! `Simulation`: tanks with Modboats, stepped a cycle at a time, on threads of their own.
//!
//! Each is the simulation of `flotilla run` without its pilot ([`environment::modules`]): the firmware crate on simulated motors at
//! 1 kHz, the link, and the tank. A simulated module does not change threads, so each thread makes and keeps its share.

use std::sync::mpsc::{Receiver, SyncSender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use environment::baseline::Allocator;
use environment::command::Command;
use environment::modules::Modules;
use environment::worker::{Gone, Worker};
use host::answer::plan::check_demand;
use host::run::scenario::Scenario;
use modboat::distance::DistanceToCollision;
use modboat::motion::Wrench;
use modboat::planner_kind::PlannerKind;
use pyo3::prelude::*;
use record::PoseSample;

use crate::array::{self, Matrix, Vector, matrix, vector};
use crate::error::{bad, could};
use crate::named::named;
use crate::threads::threads;

/// What one tank is to do next.
enum Order {
    Wrench(Wrench),
    /// φ₀, A and the way round of each module.
    Swings(Vec<f64>),
}

/// One tank after a step.
#[derive(Clone, Default)]
struct Seen {
    pose: PoseSample,
    tail_rad: Vec<f64>,
    swings: Vec<[f64; 2]>,
    wrench: [f64; 3],
    contacts: usize,
    stuck: bool,
}

struct Tank {
    scenario: Arc<Scenario>,
    modules: Modules,
    allocator: Allocator,
    command: Command,
    next: Command,
    positions_m: Vec<[f64; 2]>,
    contacts: usize,
}

impl Tank {
    fn new(
        scenario: &Arc<Scenario>,
        kind: PlannerKind,
        distance: &Arc<DistanceToCollision>,
        seed: u64,
    ) -> Result<Self, String> {
        let modules = Modules::new(scenario, seed).map_err(|error| error.to_string())?;
        Ok(Self {
            modules,
            allocator: Allocator::new(scenario, kind, Arc::clone(distance)),
            command: Command::default(),
            next: Command::default(),
            positions_m: scenario.structure.positions_m(scenario.modboat.pitch_m),
            contacts: 0,
            scenario: Arc::clone(scenario),
        })
    }

    fn step(&mut self, order: &Order) -> Result<(), String> {
        let (tails, scenario) = (self.modules.rests_rad(), &self.scenario);
        match order {
            Order::Wrench(demand) => {
                self.allocator.allocate(*demand, tails, &self.command.cycle, scenario, &mut self.next);
            }
            Order::Swings(swings) => self.next.take_swings(swings, tails, &scenario.modboat),
        }
        std::mem::swap(&mut self.command, &mut self.next);
        self.contacts += self.modules.run(&self.command).map_err(|error| error.to_string())?;
        Ok(())
    }

    fn seen(&self) -> Seen {
        let swing = |swing: &modboat::motion::Swing| [swing.centerline_rad, swing.amplitude_rad];
        Seen {
            pose: self.modules.pose(),
            tail_rad: self.modules.rests_rad().to_vec(),
            swings: self.command.cycle.iter().map(swing).collect(),
            wrench: self.command.wrench(&self.scenario.modboat, &self.positions_m).to_array(),
            contacts: self.contacts,
            stuck: self.modules.is_stuck(),
        }
    }
}

type Answer = Result<Vec<Seen>, String>;

/// A thread's part of the tanks. Its first answer comes without an order.
struct Share {
    count: usize,
    worker: Worker<Vec<Order>, Answer>,
}

impl Share {
    fn new(
        scenario: Arc<Scenario>,
        kind: PlannerKind,
        distance: Arc<DistanceToCollision>,
        seeds: Vec<u64>,
    ) -> Self {
        let count = seeds.len();
        let worker = Worker::new(move |ordered: Receiver<Vec<Order>>, answered: SyncSender<Answer>| {
            let tanks = seeds.iter().map(|&seed| Tank::new(&scenario, kind, &distance, seed));
            let made: Result<Vec<Tank>, String> = tanks.collect();
            let mut tanks = match made {
                Ok(tanks) => tanks,
                Err(error) => {
                    let _ = answered.send(Err(error));
                    return;
                }
            };
            let all = |tanks: &[Tank]| tanks.iter().map(Tank::seen).collect();
            let mut open = answered.send(Ok(all(&tanks))).is_ok();
            while open && let Ok(orders) = ordered.recv() {
                let outcome = tanks.iter_mut().zip(&orders).try_for_each(|(tank, order)| tank.step(order));
                open = answered.send(outcome.map(|()| all(&tanks))).is_ok();
            }
        });
        Self { count, worker }
    }

    fn answer(&self) -> Answer {
        self.worker.answer().map_err(gone)?
    }
}

fn gone(_: Gone) -> String {
    "a thread of this simulation has ended".to_owned()
}

struct State {
    shares: Vec<Share>,
    seen: Vec<Seen>,
}

/// See the module's documentation.
#[pyclass(frozen, module = "flotilla")]
pub struct Simulation {
    modules: usize,
    /// Least and greatest |A|, rad.
    amplitude_rad: [f64; 2],
    state: Mutex<State>,
}

impl Simulation {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn column<T>(&self, of: impl FnMut(&Seen) -> T) -> Vec<T> {
        self.state().seen.iter().map(of).collect()
    }

    fn each<const N: usize>(&self, of: impl FnMut(&Seen) -> [f64; N]) -> Vec<f64> {
        self.column(of).concat()
    }

    /// φ₀ and A of each module of each tank, and the way round.
    fn swings(
        &self,
        count: usize,
        centerline_rad: &Bound<'_, PyAny>,
        amplitude_rad: &Bound<'_, PyAny>,
        direction: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Order>> {
        let centerlines = array::rows_or_row("centerline_rad", centerline_rad, count, self.modules)?;
        let amplitudes = array::rows_or_row("amplitude_rad", amplitude_rad, count, self.modules)?;
        let ways = match direction {
            Some(direction) => array::rows_or_row("direction", direction, count, self.modules)?,
            None => vec![0.0; count * self.modules],
        };
        let [least, most] = self.amplitude_rad;
        for (index, (centerline, amplitude)) in centerlines.iter().zip(&amplitudes).enumerate() {
            let (tank, module) = (index / self.modules, index % self.modules);
            if !centerline.is_finite() {
                return Err(bad(format!(
                    "centerline_rad[{tank}, {module}] = {centerline} rad: must be a number"
                )));
            }
            if *amplitude != 0.0 && !(least..=most).contains(&amplitude.abs()) {
                return Err(bad(format!(
                    "amplitude_rad[{tank}, {module}] = {amplitude} rad: must be 0, or from {least} to {most} in size"
                )));
            }
        }
        let numbers = centerlines.iter().zip(&amplitudes).zip(&ways);
        let numbers: Vec<f64> = numbers.flat_map(|((phi, a), way)| [*phi, *a, *way]).collect();
        Ok(numbers.chunks(3 * self.modules).map(|swings| Order::Swings(swings.to_vec())).collect())
    }

    fn give(&self, py: Python<'_>, orders: Vec<Order>) -> PyResult<()> {
        py.detach(|| {
            let mut state = self.state();
            let mut orders = orders.into_iter();
            for share in &state.shares {
                let own = orders.by_ref().take(share.count).collect();
                share.worker.give(own).map_err(gone)?;
            }
            // All are heard, so that none speaks of this step in the next.
            let answers: Vec<Answer> = state.shares.iter().map(Share::answer).collect();
            state.seen = answers.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
            Ok(())
        })
        .map_err(|error: String| could(error))
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scenario = "holonomic-1", seeds = None, *, planner = "exact", threads = 1))]
    fn new(
        py: Python<'_>,
        scenario: &str,
        seeds: Option<Vec<u64>>,
        planner: &str,
        threads: usize,
    ) -> PyResult<Self> {
        let scenario = Arc::new(Scenario::open(scenario).map_err(bad)?);
        let kind: PlannerKind = named("planner", planner)?;
        let seeds = seeds.unwrap_or_else(|| vec![scenario.seed]);
        let threads = self::threads(threads)?;
        let (modules, boat) = (scenario.structure.len(), &scenario.modboat);
        let amplitude_rad = [boat.amplitude_min_rad, boat.amplitude_max_rad];
        let state = py.detach(|| {
            let distance = Arc::new(DistanceToCollision::new(&scenario.modboat));
            let one = |seeds: &[u64]| {
                Share::new(Arc::clone(&scenario), kind, Arc::clone(&distance), seeds.to_vec())
            };
            let shares: Vec<Share> = seeds.chunks(seeds.len().div_ceil(threads).max(1)).map(one).collect();
            let answers: Vec<Answer> = shares.iter().map(Share::answer).collect();
            let seen = answers.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
            Ok(Mutex::new(State { shares, seen }))
        });
        Ok(Self { modules, amplitude_rad, state: state.map_err(|error: String| could(error))? })
    }

    fn __len__(&self) -> usize {
        self.state().seen.len()
    }

    #[getter]
    fn modules(&self) -> usize {
        self.modules
    }

    /// One cycle of every tank, for a demanded wrench: (3,) for all, or (n, 3).
    fn step_wrench(&self, wrench: &Bound<'_, PyAny>) -> PyResult<()> {
        let numbers = array::rows_or_row("wrench", wrench, self.__len__(), 3)?;
        let demands = numbers.as_chunks::<3>().0.iter().map(|&demand| Wrench::from_array(demand));
        let orders = demands.enumerate().map(|(tank, demand)| {
            check_demand(demand).map_err(|error| bad(format!("wrench[{tank}]: {error}")))?;
            Ok(Order::Wrench(demand))
        });
        self.give(wrench.py(), orders.collect::<PyResult<_>>()?)
    }

    /// One cycle of every tank, by the swing of each module: (m,) for all, or (n, m).
    #[pyo3(signature = (centerline_rad, amplitude_rad, direction = None))]
    fn step_swings(
        &self,
        centerline_rad: &Bound<'_, PyAny>,
        amplitude_rad: &Bound<'_, PyAny>,
        direction: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let orders = self.swings(self.__len__(), centerline_rad, amplitude_rad, direction)?;
        self.give(centerline_rad.py(), orders)
    }

    #[getter]
    fn t_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.column(|seen| seen.pose.t_s))
    }

    #[getter]
    fn position_m<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.each(|seen| seen.pose.position_m), 2)
    }

    #[getter]
    fn heading_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.column(|seen| seen.pose.heading_rad))
    }

    #[getter]
    fn velocity_m_s<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.each(|seen| seen.pose.velocity_m_s), 2)
    }

    #[getter]
    fn yaw_rate_rad_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.column(|seen| seen.pose.yaw_rate_rad_s))
    }

    #[getter]
    fn tail_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.column(|seen| seen.tail_rad.clone()).concat(), self.modules)
    }

    #[getter]
    fn centerline_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        self.swung(py, 0)
    }

    #[getter]
    fn amplitude_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        self.swung(py, 1)
    }

    /// The mean wrench of the last cycle by law (7).
    #[getter]
    fn wrench<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.each(|seen| seen.wrench), 3)
    }

    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> Vector<'py, u64> {
        vector(py, self.column(|seen| seen.contacts as u64))
    }

    #[getter]
    fn stuck<'py>(&self, py: Python<'py>) -> Vector<'py, bool> {
        vector(py, self.column(|seen| seen.stuck))
    }
}

impl Simulation {
    /// φ₀ or A of the last cycle; zero before the first.
    fn swung<'py>(&self, py: Python<'py>, which: usize) -> PyResult<Matrix<'py>> {
        let modules = self.modules;
        let of = |seen: &Seen| -> Vec<f64> {
            (0..modules).map(|module| seen.swings.get(module).map_or(0.0, |swing| swing[which])).collect()
        };
        matrix(py, self.column(of).concat(), modules)
    }
}
