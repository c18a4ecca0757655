//! Properties that hold in every state that any order of events leads to.

use model::fleet::{Budget, Config};
use model::heal::SLOTS;
use model::properties::COMBINATIONS;
use model::run::{holds, keeps};
use protocol::Delivery;

const NONE: Budget =
    Budget { cycles: 0, module_boots: 0, host_boots: 0, doubts: 0, holds: 0, orders: 0, stalls: 0 };
const PREPARE: &[Delivery] = &[Delivery::Prepare];
const DIRECT: &[Delivery] = &[Delivery::Direct];

#[test]
fn cycles_follow_each_other() {
    holds("three cycles", Config::new(4, Budget { cycles: 3, ..NONE }));
}

#[test]
fn doubts_holds_and_stops() {
    holds("two cycles, doubt", Config::new(3, Budget { cycles: 2, doubts: 1, ..NONE }));
    holds("two cycles, a hold", Config::new(3, Budget { cycles: 2, holds: 1, ..NONE }));
    holds("a cycle, a stop and its release", Config::new(2, Budget { cycles: 1, orders: 2, ..NONE }));
    holds("two stops, a release and a stall", Config::new(2, Budget { orders: 3, stalls: 1, ..NONE }));
}

#[test]
fn a_reboot_of_the_host_and_stalls() {
    let reboot = Budget { orders: 2, host_boots: 1, ..NONE };
    holds("a stop, a reboot of the host, a release", Config::new(3, reboot));
    holds(
        "a cycle, a stop, its release and a stall",
        Config { deliveries: DIRECT, ..Config::new(2, Budget { cycles: 1, orders: 2, stalls: 1, ..NONE }) },
    );
    holds("two cycles, a stall", Config::new(3, Budget { cycles: 2, stalls: 1, ..NONE }));
}

#[test]
fn boots() {
    holds("two cycles, a module boots", Config::new(3, Budget { cycles: 2, module_boots: 1, ..NONE }));
    let both = Budget { cycles: 2, host_boots: 1, module_boots: 1, ..NONE };
    holds("two prepared cycles, each boots", Config { deliveries: PREPARE, ..Config::new(3, both) });
    holds("two cycles, the host boots", Config::new(4, Budget { cycles: 2, host_boots: 1, ..NONE }));
}

/// Every other run is one without a replay window, for there any order comes as often as it likes: commands are idempotent, and the
/// window is needed for the exact ledger alone.
#[test]
fn with_the_replay_window_and_without() {
    let config = Config::new(3, Budget { cycles: 2, holds: 1, ..NONE });
    let with =
        holds("two cycles, a hold, each sent once", Config { once: true, deliveries: PREPARE, ..config });
    let without = holds("two cycles, a hold, with any replay", Config { deliveries: PREPARE, ..config });
    assert!(with > 0 && without > 0);
}

#[test]
fn no_state_is_stuck() {
    let recovers = |name: &str, slots, budget| {
        holds(name, Config { recovery: SLOTS, ..Config::new(slots, budget) });
    };
    recovers("healing: two cycles", 3, Budget { cycles: 2, ..NONE });
    recovers("healing: a cycle, doubt and a hold", 3, Budget { cycles: 1, doubts: 1, holds: 1, ..NONE });
    recovers("healing: a cycle, a stall and a stop", 2, Budget { cycles: 1, stalls: 1, orders: 1, ..NONE });
    recovers("healing: a cycle, the host boots", 3, Budget { cycles: 1, host_boots: 1, ..NONE });
    recovers("healing: a cycle, a module boots", 3, Budget { cycles: 1, module_boots: 1, ..NONE });
}

/// The table of combinations, holding included: what loss tolerant plans promise.
#[test]
fn direct_cycles_are_safe_whichever_modules_miss_them() {
    let config = Config { deliveries: DIRECT, ..Config::new(4, Budget { cycles: 3, doubts: 1, ..NONE }) };
    keeps("three direct cycles, doubt", config, &[COMBINATIONS]);
}
