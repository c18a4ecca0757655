//! Orders straight to modules, where no run is going on: a host of its own, which takes in whatever module of the fleet announces
//! itself, and plans nothing.

use std::time::{Duration, Instant};

use link::dispatcher::Dispatcher;
use link::udp::UdpRadio;
use protocol::time::FleetInstant;
use protocol::{MAX_DATAGRAM, ModuleId, Radio};

use super::super::{could, keygen};
use super::{Arguments, Failure, Wish};
use crate::run::orders::ModuleStatus;

/// Numbers that a module may have.
const NUMBERS: std::ops::RangeInclusive<u16> = 1..=1024;
/// How long it waits for other modules once all that were heard have followed.
const OTHERS_WITHIN: Duration = Duration::from_secs(1);
/// Pause between two looks at the radio.
const LOOK_EVERY: Duration = Duration::from_millis(1);
/// Pause between two looks at what all modules have said: there may be a thousand.
const JUDGE_EVERY: Duration = Duration::from_millis(100);

/// Tells the modules, or `only` one, what is wanted, until all that were heard have followed it and no other is heard any more, or for
/// [`Arguments::wait`]. What was heard.
pub(super) fn ask(
    wish: Wish,
    only: Option<ModuleId>,
    arguments: &Arguments,
) -> Result<Vec<ModuleStatus>, Failure> {
    let identity = keygen::host(arguments.key.as_deref())?;
    let mut radio = UdpRadio::bind(arguments.listen.as_str()).map_err(|error| {
        Failure::Bad(format!("{error}: a host that is no run of this user may be going on"))
    })?;
    let roster: Vec<ModuleId> = match only {
        Some(id) => vec![id],
        None => NUMBERS.map(ModuleId).collect(),
    };
    let mut dispatcher = Dispatcher::new(&roster, &identity.key, identity.boot);
    let began = Instant::now();
    let now = || FleetInstant(began.elapsed().as_micros() as u64);
    match wish {
        Wish::Stop => dispatcher.emergency_stop(now()),
        Wish::Release => dispatcher.release(now()),
        Wish::Hold | Wish::Status => {}
    }
    let mut buffer = [0; MAX_DATAGRAM];
    let (mut heard, mut changed, mut judged) = (0, began, began);
    let wait = Duration::from_secs_f64(arguments.wait);
    loop {
        std::thread::sleep(LOOK_EVERY);
        while let Some((length, from)) = radio.receive(now(), &mut buffer).map_err(could)? {
            // What is not to be followed is counted.
            let _ = dispatcher.handle_datagram(now(), from, &buffer[..length]);
        }
        dispatcher.handle_timer(now());
        let joined = dispatcher.modules().iter().filter(|link| link.is_known()).count();
        if joined != std::mem::replace(&mut heard, joined) {
            changed = Instant::now();
            if wish == Wish::Hold {
                dispatcher.hold();
            }
        }
        while let Some((to, datagram)) = dispatcher.poll_transmit(now(), &mut buffer) {
            radio.send(now(), to, datagram).map_err(could)?;
        }
        if judged.elapsed() < JUDGE_EVERY {
            continue;
        }
        judged = Instant::now();
        let modules = statuses(&dispatcher, now());
        let said = |module: &ModuleStatus| module.state.is_some() && wish.is_followed(module) != Some(false);
        let done = !modules.is_empty() && modules.iter().all(said) && changed.elapsed() >= OTHERS_WITHIN;
        if done || began.elapsed() >= wait {
            return Ok(modules);
        }
    }
}

/// Of the modules that have been heard.
fn statuses<A: Copy>(dispatcher: &Dispatcher<A>, now: FleetInstant) -> Vec<ModuleStatus> {
    let known = dispatcher.modules().iter().filter(|link| link.is_known());
    known.map(|link| ModuleStatus::of(now, link.id().0, link)).collect()
}
