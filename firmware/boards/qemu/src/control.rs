//! The control loop: an interrupt at every tick, and whenever a datagram waits. Nothing delays it, least of all the network.
//!
//! ```text
//! main loop   frames → smoltcp → inbox ─┐ call                    ┌→ outbox → smoltcp → frames
//! interrupt                             └→ tick?  handle…  poll_transmit…
//! ```
//!
//! Datagrams are handled after the tick, and no more of them once the next one is due: whatever comes, ticks go first.

use core::cell::RefCell;

use critical_section::Mutex;
use firmware::modboat::Modboat;
use firmware::module::{Module, Status, Supply};
use heapless::Vec;
use heapless::spsc::{Consumer, Producer, Queue};
use protocol::configuration::SupplyConstants;
use protocol::ledger::Incoming;
use protocol::time::{Duration, LocalInstant};
use protocol::units::Volts;
use protocol::{Faults, MAX_DATAGRAM, ModuleState};

use crate::clock::{self, Tick};
use crate::disturbance::Disturbances;
use crate::motor::{self, DirectionPin, PwmPin, Sensors, Wheel};

/// The firmware on this board.
pub type Firmware = Modboat<Wheel, Sensors, PwmPin, DirectionPin, DirectionPin>;

/// One datagram.
pub type Datagram = Vec<u8, MAX_DATAGRAM>;

/// Datagrams on their way between the loops, one less than the number, each way.
const WAITING: usize = 17;

/// A queue of datagrams.
pub type Mail = Queue<Datagram, WAITING>;

/// What two lithium cells show at the divider's output. *Assumed*, and constant.
const BATTERY: Volts = Volts(7.4);

/// How the loop does.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    /// Ticks done.
    pub ticks: u64,
    /// Ticks that never came, because the loop was at something else.
    pub missed: u64,
    /// Ticks that never came while the loop waited for them: the emulator had no processor to run on.
    pub stalled: u64,
    /// Longest wait of a tick for its turn.
    pub latest: Duration,
    /// Longest tick.
    pub longest_tick: Duration,
    /// Longest stay in the interrupt.
    pub longest_turn: Duration,
    /// What came over the link.
    pub incoming: Incoming,
    /// Datagrams that found the outbox full.
    pub unsent: u64,
    /// What the module does.
    pub state: Option<ModuleState>,
    /// What is wrong with it.
    pub faults: Faults,
    /// Whether its motor is shorted, and its drive otherwise, a thousandth of the supply.
    pub drive: (bool, i32),
    /// The cycle that it runs.
    pub running: u32,
}

/// The control loop of the emulated board.
pub struct Control {
    firmware: Firmware,
    supply: SupplyConstants,
    disturbances: Disturbances,
    tick: Tick,
    interval: Duration,
    /// When the last tick was due.
    due: Option<LocalInstant>,
    /// When the loop was done last.
    done: LocalInstant,
    /// The motor stands as of then.
    stepped: LocalInstant,
    inbox: Consumer<'static, Datagram>,
    outbox: Producer<'static, Datagram>,
    statistics: Statistics,
}

static CONTROL: Mutex<RefCell<Option<Control>>> = Mutex::new(RefCell::new(None));

impl Control {
    /// Starts ticking `firmware` every `interval`.
    pub fn start(
        firmware: Firmware,
        supply: SupplyConstants,
        interval: Duration,
        inbox: Consumer<'static, Datagram>,
        outbox: Producer<'static, Datagram>,
    ) {
        let tick = Tick::start(interval);
        let control = Self {
            firmware,
            supply,
            disturbances: Disturbances::asked_for(),
            tick,
            interval,
            due: None,
            done: LocalInstant(0),
            stepped: clock::now(),
            inbox,
            outbox,
            statistics: Statistics::default(),
        };
        critical_section::with(|cs| *CONTROL.borrow_ref_mut(cs) = Some(control));
        // SAFETY: what its handler needs is in place.
        unsafe { cortex_m::peripheral::NVIC::unmask(clock::Interrupt::Tick) };
    }

    fn turn(&mut self) {
        let began = clock::now();
        if self.tick.take() {
            // Read again: it may have come due since.
            let now = clock::now();
            self.count_tick(now);
            self.disturbances.act(now);
            self.let_motor_run(now);
            let battery = firmware::provision::battery(&self.supply, self.divided(now));
            // The pins of this board cannot fail.
            let supply = Supply { battery, ..Supply::default() };
            let _ = self.firmware.tick(now, &supply);
            let took = clock::now().since(now);
            self.statistics.longest_tick = self.statistics.longest_tick.max(took);
        }
        while !self.tick.is_due() {
            let Some(datagram) = self.inbox.dequeue() else { break };
            // What is not for it is counted there.
            let _ = self.firmware.handle_datagram(clock::now(), &datagram);
        }
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some(datagram) = self.firmware.poll_transmit(&mut buffer) {
            let datagram = Vec::from_slice(datagram).unwrap_or_default();
            if self.outbox.enqueue(datagram).is_err() {
                self.statistics.unsent += 1;
            }
        }
        self.done = clock::now();
        self.statistics.longest_turn = self.statistics.longest_turn.max(self.done.since(began));
    }

    /// The motor went on since the last tick, however long ago that was.
    fn let_motor_run(&mut self, now: LocalInstant) {
        let mut left = now.since(self.stepped);
        self.stepped = now;
        while left.0 > 0 {
            let step = left.min(self.interval);
            motor::step(f64::from(step.as_secs_f32()));
            left = Duration(left.0 - step.0);
        }
    }

    /// The battery as this board's input would show it.
    fn divided(&self, now: LocalInstant) -> Volts {
        Volts(self.disturbances.battery(now, BATTERY).0 / self.supply.volts_per_volt)
    }

    fn count_tick(&mut self, now: LocalInstant) {
        let late = self.tick.late();
        let due = LocalInstant(now.0.saturating_sub(u64::from(late.0)));
        let statistics = &mut self.statistics;
        statistics.ticks += 1;
        statistics.latest = statistics.latest.max(late);
        let Some(last) = self.due.replace(due) else { return };
        // From tick to tick, by the tick's own timer: its period need not be a whole number of microseconds.
        let interval = self.interval.0;
        let lost = ((due.since(last).0 + interval / 2) / interval).saturating_sub(1);
        let busy = (self.done.since(last).0 / interval).saturating_sub(1).min(lost);
        statistics.missed += u64::from(busy);
        statistics.stalled += u64::from(lost - busy);
    }

    fn statistics(&mut self) -> Statistics {
        let endpoint = self.firmware.endpoint();
        let now = clock::now();
        let Status { state, faults, running } = self.firmware.status(now);
        let present = Statistics {
            incoming: endpoint.link().map_or(Incoming::default(), |link| *link.incoming()),
            state: Some(state),
            faults,
            running: running.unwrap_or(0),
            drive: motor::drive(),
            ..self.statistics
        };
        let statistics = &mut self.statistics;
        (statistics.latest, statistics.longest_tick, statistics.longest_turn) =
            (Duration(0), Duration(0), Duration(0));
        present
    }
}

/// The tick's interrupt.
pub fn interrupted() {
    with(Control::turn);
}

/// How the loop has done since this was asked last, and in all.
#[must_use]
pub fn statistics() -> Statistics {
    with(Control::statistics).unwrap_or_default()
}

/// What the module does, and what is wrong with it.
#[must_use]
pub fn state() -> (ModuleState, Faults) {
    let state = |control: &mut Control| {
        let Status { state, faults, .. } = control.firmware.status(clock::now());
        (state, faults)
    };
    with(state).unwrap_or((ModuleState::Boot, Faults::default()))
}

fn with<T>(use_it: impl FnOnce(&mut Control) -> T) -> Option<T> {
    critical_section::with(|cs| CONTROL.borrow_ref_mut(cs).as_mut().map(use_it))
}
