//! The status LED: which light shows which state, to an operator beside the tank.
//!
//! | light | meaning |
//! |---|---|
//! | two short flashes every two seconds | no valid configuration |
//! | slow, half a second on and off | it looks for its zero: turn the tail over the magnet, if nothing turns it |
//! | one short flash a second | on, and waits for a host |
//! | on, with a short gap a second | in a session, ready or holding |
//! | on | it executes a cycle |
//! | fast, five a second | stopped, or with a fault |

use protocol::time::LocalInstant;
use protocol::{Faults, ModuleState};

/// Whether the status LED is lit at `now`, own clock.
#[must_use]
pub fn is_lit(now: LocalInstant, state: ModuleState, faults: Faults) -> bool {
    // Of 32 bits, which small processors divide: every nine hours one flash is cut short.
    let eighths = u32::try_from(now.0 >> 3 & u64::from(u32::MAX)).unwrap_or(0);
    let within =
        |period_ms: u32| eighths.checked_div(125).and_then(|ms| ms.checked_rem(period_ms)).unwrap_or(0);
    match state {
        ModuleState::Stopped => within(200) < 100,
        _ if faults.0 != 0 => within(200) < 100,
        ModuleState::Unprovisioned => matches!(within(2_000), 0..100 | 300..400),
        ModuleState::Boot => within(1_000) < 500,
        ModuleState::Unsynchronised => within(1_000) < 100,
        ModuleState::Arming | ModuleState::Ready | ModuleState::Holding => within(1_000) >= 100,
        ModuleState::Executing => true,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::vec::Vec;

    use super::*;
    use crate::link::failsafe::STATES;

    /// The status LED over four seconds, in steps of 50 ms.
    fn seen(state: ModuleState, faults: Faults) -> Vec<bool> {
        (0..80).map(|step| is_lit(LocalInstant(step * 50_000), state, faults)).collect()
    }

    #[test]
    fn what_must_be_told_apart_is() {
        let mut meanings = BTreeMap::<Vec<bool>, Vec<ModuleState>>::new();
        for state in STATES {
            meanings.entry(seen(state, Faults::default())).or_default().push(state);
            assert_eq!(seen(state, Faults::LOW_BATTERY), seen(ModuleState::Stopped, Faults::default()));
        }
        assert_eq!(meanings.len(), 6, "{meanings:?}");
        let share = |state| seen(state, Faults::default()).iter().filter(|lit| **lit).count();
        assert_eq!(
            [ModuleState::Unprovisioned, ModuleState::Boot, ModuleState::Unsynchronised].map(share),
            [8, 40, 8]
        );
        assert_eq!(
            [ModuleState::Ready, ModuleState::Executing, ModuleState::Stopped].map(share),
            [72, 80, 40]
        );
    }
}
