//! Counterexamples that the checker finds when the protocol is broken on purpose, and for what no protocol can promise.

use model::fleet::{Broken, Budget, Config};
use model::properties::{
    BOTH_OR_NONE, CERTAINLY, CERTAINLY_NOT, COMBINATIONS, NEIGHBOUR_HOLDS, NO_OLD_SESSION, NOTHING_DROPPED,
    NOTHING_VOID, POSES, RECOVERS, STOP_LASTS, STOPPED_RESTS,
};
use model::run::breaks;
use protocol::Delivery;

const ONE: Budget =
    Budget { cycles: 1, module_boots: 0, host_boots: 0, doubts: 0, holds: 0, orders: 0, stalls: 0 };

fn broken(broken: Broken, slots: u8, budget: Budget, property: &'static str) {
    let config = Config { broken: Some(broken), ..Config::new(slots, budget) };
    let steps = breaks(&format!("{broken:?}"), config, &[property]);
    assert!(steps > 3, "{steps} steps");
}

#[test]
fn without_the_commit_phase() {
    broken(Broken::NoCommit, 3, ONE, NEIGHBOUR_HOLDS);
}

#[test]
fn with_a_commit_before_all_have_prepared() {
    broken(Broken::HastyCommit, 3, ONE, NEIGHBOUR_HOLDS);
}

#[test]
fn with_a_nonce_that_serves_twice() {
    broken(Broken::SameNonce, 3, Budget { module_boots: 1, ..ONE }, NO_OLD_SESSION);
}

#[test]
fn with_a_number_that_serves_twice() {
    broken(Broken::ReusedNumber, 4, Budget { cycles: 2, ..ONE }, NEIGHBOUR_HOLDS);
}

/// The four that follow were in the protocol until the checker found them.
#[test]
fn when_a_cycle_overtaken_by_a_hold_counts() {
    broken(Broken::NoFence, 3, Budget { holds: 1, ..ONE }, NOTHING_VOID);
    // Even if the network delivers everything once at most.
    let config = Config::new(3, Budget { holds: 1, ..ONE });
    let config = Config { broken: Some(Broken::NoFence), once: true, ..config };
    breaks("NoFence, each sent once", config, &[NOTHING_VOID]);
}

#[test]
fn when_a_refusal_is_not_final() {
    broken(Broken::ForgetfulRefusals, 3, Budget { doubts: 1, ..ONE }, CERTAINLY_NOT);
}

#[test]
fn when_a_committed_cycle_is_given_up() {
    broken(Broken::DropAfterCommit, 3, Budget { module_boots: 1, ..ONE }, NOTHING_DROPPED);
}

#[test]
fn when_taking_a_cycle_passes_for_running_it() {
    broken(Broken::AcceptanceIsProof, 3, Budget { doubts: 1, ..ONE }, CERTAINLY);
    broken(Broken::AcceptanceIsProof, 4, Budget { cycles: 2, doubts: 1, ..ONE }, POSES);
}

#[test]
fn when_a_late_copy_of_a_release_ends_a_later_stop() {
    // A stop, its release, and a stall after that; then one of two stops of the host.
    broken(Broken::BlindRelease, 2, Budget { cycles: 0, orders: 2, stalls: 1, ..ONE }, STOP_LASTS);
    broken(Broken::BlindRelease, 2, Budget { cycles: 0, orders: 3, ..ONE }, STOP_LASTS);
}

#[test]
fn when_a_stop_waits_for_the_end_of_the_cycle() {
    broken(Broken::LateStop, 3, Budget { orders: 1, ..ONE }, STOPPED_RESTS);
    broken(Broken::LateStop, 3, Budget { stalls: 1, ..ONE }, STOPPED_RESTS);
}

#[test]
fn when_a_reboot_of_the_host_ends_a_stop() {
    broken(Broken::StopOfOneHost, 3, Budget { cycles: 0, host_boots: 1, orders: 1, ..ONE }, STOP_LASTS);
}

/// No protocol can promise this: the last message that would make the module run the cycle may be the lost one, and one more to
/// confirm it would be the last in its place (J. Gray, Notes on Data Base Operating Systems, 1978; J. Halpern and
/// Y. Moses, JACM 37, 1990: agreement on a time needs common knowledge, which no message over such a link brings about).
#[test]
fn a_prepared_cycle_by_both_or_by_none_cannot_be_promised() {
    let config = Config { deliveries: &[Delivery::Prepare], ..Config::new(2, ONE) };
    breaks("the last commit is lost", config, &[BOTH_OR_NONE]);
    breaks("the last commit is lost, by the table", config, &[COMBINATIONS]);
}

/// The search for stuck states looks: a fleet that has just begun a cycle needs more than the next slot.
#[test]
fn one_slot_is_too_few_to_heal() {
    let config = Config { recovery: 1, ..Config::new(3, ONE) };
    breaks("healing within one slot", config, &[RECOVERS]);
}
