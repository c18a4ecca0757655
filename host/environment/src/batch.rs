//! Many environments, stepped on all cores; flat arrays in and out.
//!
//! Each thread makes and keeps an even, contiguous share of the environments: a simulated module shares cells with its pins and does not
//! change threads. Work goes to them and comes back in buffers that are made once, over channels that hold one each: once warm, a step
//! allocates nothing in the fidelity `cycle`, and in `module` what datagrams are made of.
//!
//! Environments know nothing of each other: what one does depends on its seed and its actions alone, not on its place, the size of the
//! batch or the number of threads.

use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::thread::available_parallelism;

use modboat::planner_kind::PlannerKind;

use crate::environment::{Environment, Outcome};
use crate::layout::{INFO, Layout};
use crate::settings::{EnvironmentError, Settings};
use crate::worker::Worker;

/// What a thread is to do with its environments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    Reset,
    Step,
    Advise(PlannerKind),
}

/// What goes to a thread and comes back; each array by environment.
struct Job {
    work: Work,
    seeds: Vec<Option<u64>>,
    /// Which are to be reset.
    chosen: Vec<bool>,
    actions: Vec<f64>,
    observations: Vec<f64>,
    outcomes: Vec<Outcome>,
    info: Vec<f64>,
    error: Option<EnvironmentError>,
}

/// A thread's part of the batch.
struct Share {
    first: usize,
    count: usize,
    worker: Worker<Box<Job>, Box<Job>>,
    job: Option<Box<Job>>,
}

/// Where a step writes: each array by environment.
pub struct Seen<'a> {
    /// [`Layout::observation`] numbers each.
    pub observations: &'a mut [f64],
    /// One each.
    pub rewards: &'a mut [f64],
    /// One each.
    pub terminated: &'a mut [bool],
    /// One each.
    pub truncated: &'a mut [bool],
    /// [`INFO`] numbers each.
    pub info: &'a mut [f64],
}

/// See the module's documentation.
pub struct Batch {
    layout: Arc<Layout>,
    shares: Vec<Share>,
    count: usize,
}

impl Batch {
    /// `count` environments on `threads` threads; on all cores if that is zero. None is reset yet.
    ///
    /// # Errors
    /// [`EnvironmentError::Parameter`].
    pub fn new(settings: &Settings, count: usize, threads: usize) -> Result<Self, EnvironmentError> {
        settings.validate()?;
        let layout = Arc::new(Layout::new(settings));
        let settings = Arc::new(settings.clone());
        let cores = || available_parallelism().map_or(1, usize::from);
        let threads = if threads == 0 { cores() } else { threads }.clamp(1, count.max(1));
        let first = |thread: usize| count * thread / threads;
        let shares = (0..threads).map(|thread| {
            let (first, end) = (first(thread), first(thread + 1));
            Share::new(&settings, &layout, first, end - first)
        });
        Ok(Self { shares: shares.collect(), layout, count })
    }

    /// Sizes and bounds of one environment.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// How many environments there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Begins an episode in each environment that is `chosen`, from its seed, or from its own generator where it has none. Writes what
    /// the chosen ones see.
    ///
    /// # Errors
    /// [`EnvironmentError`].
    pub fn reset(
        &mut self,
        seeds: &[Option<u64>],
        chosen: &[bool],
        observations: &mut [f64],
        info: &mut [f64],
    ) -> Result<(), EnvironmentError> {
        let size = self.layout.observation;
        is_of("seeds", seeds.len(), self.count)?;
        is_of("chosen", chosen.len(), self.count)?;
        is_of("observations", observations.len(), self.count * size)?;
        is_of("info", info.len(), self.count * INFO.len())?;
        let fill = |job: &mut Job, first: usize, count: usize| {
            job.seeds.copy_from_slice(&seeds[first..first + count]);
            job.chosen.copy_from_slice(&chosen[first..first + count]);
        };
        self.all(Work::Reset, fill, |job, first| {
            for index in (0..job.chosen.len()).filter(|&index| job.chosen[index]) {
                let (from, to) = (index * size, (first + index) * size);
                observations[to..to + size].copy_from_slice(&job.observations[from..from + size]);
                let (from, to) = (index * INFO.len(), (first + index) * INFO.len());
                info[to..to + INFO.len()].copy_from_slice(&job.info[from..from + INFO.len()]);
            }
        })
    }

    /// One step of each environment by its `actions`, [`Layout::action`] numbers each.
    ///
    /// # Errors
    /// [`EnvironmentError`] of the first environment that has one; others may have gone on.
    pub fn step(&mut self, actions: &[f64], seen: Seen<'_>) -> Result<(), EnvironmentError> {
        let (size, width, count) = (self.layout.action(), self.layout.observation, self.count);
        let Seen { observations, rewards, terminated, truncated, info } = seen;
        is_of("actions", actions.len(), count * size)?;
        is_of("observations", observations.len(), count * width)?;
        is_of("rewards", rewards.len(), count)?;
        is_of("terminated", terminated.len(), count)?;
        is_of("truncated", truncated.len(), count)?;
        is_of("info", info.len(), count * INFO.len())?;
        let fill = |job: &mut Job, first: usize, count: usize| {
            job.actions.copy_from_slice(&actions[first * size..(first + count) * size]);
        };
        self.all(Work::Step, fill, |job, first| {
            observations[first * width..][..job.observations.len()].copy_from_slice(&job.observations);
            info[first * INFO.len()..][..job.info.len()].copy_from_slice(&job.info);
            for (index, outcome) in job.outcomes.iter().enumerate() {
                rewards[first + index] = outcome.reward;
                terminated[first + index] = outcome.terminated;
                truncated[first + index] = outcome.truncated;
            }
        })
    }

    /// Writes what the baseline with the planner of this `kind` would do in each environment.
    ///
    /// # Errors
    /// [`EnvironmentError`].
    pub fn advise(&mut self, kind: PlannerKind, actions: &mut [f64]) -> Result<(), EnvironmentError> {
        let size = self.layout.action();
        is_of("actions", actions.len(), self.count * size)?;
        self.all(
            Work::Advise(kind),
            |_, _, _| {},
            |job, first| {
                actions[first * size..][..job.actions.len()].copy_from_slice(&job.actions);
            },
        )
    }

    /// Has every thread do `work` on what `fill` wrote, and hands each result to `take` with the place of its first environment.
    fn all(
        &mut self,
        work: Work,
        fill: impl Fn(&mut Job, usize, usize),
        mut take: impl FnMut(&Job, usize),
    ) -> Result<(), EnvironmentError> {
        for share in &mut self.shares {
            let mut job = share.job.take().ok_or(EnvironmentError::Stopped)?;
            job.work = work;
            fill(&mut job, share.first, share.count);
            share.worker.give(job).map_err(|_| EnvironmentError::Stopped)?;
        }
        let mut failed = None;
        for share in &mut self.shares {
            let mut job = share.worker.answer().map_err(|_| EnvironmentError::Stopped)?;
            let error = job.error.take();
            if error.is_none() {
                take(&job, share.first);
            }
            failed = failed.or(error);
            share.job = Some(job);
        }
        failed.map_or(Ok(()), Err)
    }
}

impl Share {
    fn new(settings: &Arc<Settings>, layout: &Arc<Layout>, first: usize, count: usize) -> Self {
        let job = Job {
            work: Work::Reset,
            seeds: vec![None; count],
            chosen: vec![false; count],
            actions: vec![0.0; count * layout.action()],
            observations: vec![0.0; count * layout.observation],
            outcomes: vec![Outcome::default(); count],
            info: vec![0.0; count * INFO.len()],
            error: None,
        };
        let (settings, layout) = (Arc::clone(settings), Arc::clone(layout));
        let worker = Worker::new(move |orders: Receiver<Box<Job>>, done| {
            let make = |_| Environment::new(Arc::clone(&settings), Arc::clone(&layout));
            let mut environments: Vec<Environment> = (0..count).map(make).collect();
            while let Ok(mut job) = orders.recv() {
                job.error = work_on(&mut environments, &mut job, &layout, first).err();
                if done.send(job).is_err() {
                    return;
                }
            }
        });
        Self { first, count, worker, job: Some(Box::new(job)) }
    }
}

fn work_on(
    environments: &mut [Environment],
    job: &mut Job,
    layout: &Layout,
    first: usize,
) -> Result<(), EnvironmentError> {
    let (size, width) = (layout.action(), layout.observation);
    for (index, environment) in environments.iter_mut().enumerate() {
        let action = &mut job.actions[index * size..(index + 1) * size];
        let observation = &mut job.observations[index * width..(index + 1) * width];
        match job.work {
            Work::Reset if !job.chosen[index] => continue,
            Work::Reset => environment.reset(job.seeds[index], observation)?,
            Work::Step => job.outcomes[index] = environment.step(first + index, action, observation)?,
            Work::Advise(kind) => environment.advise(kind, action),
        }
        job.info[index * INFO.len()..(index + 1) * INFO.len()].copy_from_slice(environment.info());
    }
    Ok(())
}

fn is_of(what: &'static str, given: usize, wanted: usize) -> Result<(), EnvironmentError> {
    if given == wanted { Ok(()) } else { Err(EnvironmentError::Length { what, given, wanted }) }
}
