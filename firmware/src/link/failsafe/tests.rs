use std::collections::HashSet;
use std::vec::Vec;

use proptest::prelude::*;
use protocol::ModuleState::{
    Arming, Boot, Executing, Holding, Ready, Stopped, Unprovisioned, Unsynchronised,
};

use super::*;

/// In line with Ready.
const READY: Conditions = Conditions {
    configured: true,
    located: true,
    clock_known: true,
    armed: true,
    running: false,
    low_battery: false,
};

/// All conditions there are.
fn all_conditions() -> impl Iterator<Item = Conditions> {
    (0..64_u8).map(|bits| Conditions {
        configured: bits & 1 != 0,
        located: bits & 2 != 0,
        clock_known: bits & 4 != 0,
        armed: bits & 8 != 0,
        running: bits & 16 != 0,
        low_battery: bits & 32 != 0,
    })
}

/// States that the table leads to from there.
fn reachable(from: ModuleState) -> HashSet<ModuleState> {
    let mut seen = HashSet::from([from]);
    let mut open = Vec::from([from]);
    while let Some(state) = open.pop() {
        for next in TRANSITIONS.iter().filter(|transition| transition.from == state) {
            if seen.insert(next.to) {
                open.push(next.to);
            }
        }
    }
    seen
}

/// Every value of a [`Failsafe`] that any sequence of events and conditions leads to.
fn every_failsafe() -> HashSet<Failsafe> {
    let mut seen = HashSet::from([Failsafe::new()]);
    let mut open = Vec::from([Failsafe::new()]);
    while let Some(failsafe) = open.pop() {
        let by_event = FailsafeEvent::ALL.map(|event| {
            let mut next = failsafe.clone();
            next.handle(event);
            next
        });
        let by_tick = all_conditions().map(|conditions| {
            let mut next = failsafe.clone();
            next.follow(&conditions);
            next
        });
        for next in by_event.into_iter().chain(by_tick) {
            if seen.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    seen
}

/// A module in line with `conditions`.
fn following(conditions: Conditions) -> Failsafe {
    let mut failsafe = Failsafe::new();
    failsafe.follow(&conditions);
    failsafe
}

#[test]
fn the_table_is_a_function_and_says_why() {
    let keys: HashSet<_> = TRANSITIONS.iter().map(|t| (t.from, t.event)).collect();
    assert_eq!(keys.len(), TRANSITIONS.len(), "two transitions for one event");
    for t in TRANSITIONS {
        assert!(t.from != t.to && t.why.len() > 10 && t.why.len() < 100, "{t:?}");
        assert!(!t.why.ends_with('.') && !t.why.contains('|'), "{t:?} stands in a table");
    }
    let used: HashSet<_> = TRANSITIONS.iter().map(|t| t.event).collect();
    assert_eq!(used, HashSet::from(FailsafeEvent::ALL), "an event that nothing listens to");
}

#[test]
fn every_state_is_reached_and_leads_back() {
    assert_eq!(reachable(Boot), HashSet::from(STATES));
    for state in STATES.into_iter().filter(|&state| state != Unprovisioned) {
        assert!(reachable(state).contains(&Ready), "{state:?}");
    }
    assert_eq!(reachable(Unprovisioned), HashSet::from([Unprovisioned]), "for good");
}

#[test]
fn stops_stop_everything_and_only_a_release_ends_them() {
    for event in FailsafeEvent::ALL {
        let stops = event.fault() != Faults(0);
        for state in STATES.into_iter().filter(|&state| state != Unprovisioned && state != Stopped) {
            let to = transition(state, event).map(|t| t.to);
            assert_eq!(to == Some(Stopped), stops, "{event:?} in {state:?}");
        }
        assert_eq!(transition(Stopped, event).is_some(), event == FailsafeEvent::Released, "{event:?}");
    }
}

#[test]
fn follow_settles_and_then_stays() {
    for failsafe in every_failsafe() {
        for conditions in all_conditions() {
            let mut settled = failsafe.clone();
            let changed = settled.follow(&conditions);
            assert_eq!(changed, (settled.state() != failsafe.state()).then_some(settled.state()));
            assert_eq!(conditions.event(settled.state()), None, "{failsafe:?}, {conditions:?}");
            let again = settled.clone();
            assert_eq!(settled.follow(&conditions), None);
            assert_eq!(settled, again);
        }
    }
}

#[test]
fn conditions_call_for_events_of_the_table_only() {
    for (state, conditions) in STATES.into_iter().flat_map(|s| all_conditions().map(move |c| (s, c))) {
        if let Some(event) = conditions.event(state) {
            assert!(transition(state, event).is_some(), "{event:?} in {state:?}");
            assert_eq!(event.fault(), Faults(0), "{event:?}");
        }
    }
}

#[test]
fn permissions_hold_in_everything_that_can_be() {
    let all = every_failsafe();
    std::println!("{} different failsafes", all.len());
    assert_eq!(all.iter().map(Failsafe::state).collect::<HashSet<_>>(), HashSet::from(STATES));
    for failsafe in all {
        let (state, faults) = (failsafe.state(), failsafe.faults());
        let stops = Faults(faults.0 & !Faults::LOW_BATTERY.0);
        let silent = matches!(state, Boot | Unprovisioned);
        assert_eq!(failsafe.announces(), !silent);
        assert!(!(silent && failsafe.may_drive()), "{failsafe:?}");
        assert_eq!(stops != Faults(0), state == Stopped, "{failsafe:?}");
        match failsafe.permission() {
            Permission::Drive => assert!(!silent && state != Stopped, "{failsafe:?}"),
            Permission::Brake => assert!(state == Stopped && !faults.has(Faults::OUTPUT), "{failsafe:?}"),
            Permission::Coast => assert!(silent || faults.has(Faults::OUTPUT), "{failsafe:?}"),
        }
        match failsafe.takes_cycles() {
            Ok(()) => {
                assert!(matches!(state, Arming | Ready | Executing | Holding), "{failsafe:?}");
                assert!(faults == Faults(0) && failsafe.may_drive(), "{failsafe:?}");
            }
            Err(Refusal::Stopped) => assert_eq!(state, Stopped),
            Err(Refusal::LowBattery) => assert!(faults.has(Faults::LOW_BATTERY)),
            Err(refusal) => assert_eq!(refusal, Refusal::NotSynchronised),
        }
    }
}

#[test]
fn a_day_of_a_module() {
    let mut failsafe = Failsafe::new();
    assert_eq!(failsafe.follow(&Conditions { configured: true, ..Conditions::default() }), None);
    assert!(failsafe.state() == Boot && !failsafe.may_drive() && !failsafe.announces());
    let mut conditions = Conditions { clock_known: false, armed: false, ..READY };
    assert_eq!(failsafe.follow(&conditions), Some(Unsynchronised));
    assert!(failsafe.may_drive() && failsafe.announces());
    assert_eq!(failsafe.takes_cycles(), Err(Refusal::NotSynchronised));
    conditions.clock_known = true;
    assert_eq!(failsafe.follow(&conditions), Some(Arming));
    assert_eq!(failsafe.takes_cycles(), Ok(()), "to run once it is armed");
    assert_eq!(failsafe.follow(&READY), Some(Ready));
    let running = Conditions { running: true, ..READY };
    assert_eq!(failsafe.follow(&running), Some(Executing));
    assert_eq!(failsafe.follow(&running), None);
    assert_eq!(failsafe.follow(&READY), Some(Holding));
    assert_eq!(failsafe.follow(&running), Some(Executing));
    assert_eq!(failsafe.handle(FailsafeEvent::EmergencyStop), Some(Stopped));
    assert_eq!(failsafe.follow(&running), None, "latched");
    assert_eq!((failsafe.permission(), failsafe.faults()), (Permission::Brake, Faults::EMERGENCY));
    assert_eq!(failsafe.handle(FailsafeEvent::MotorStalled), None);
    assert_eq!(failsafe.faults(), Faults::EMERGENCY.with(Faults::STALLED), "both are shown");
    assert_eq!(failsafe.permission(), Permission::Brake);
    assert_eq!(failsafe.handle(FailsafeEvent::OutputFailed), None);
    assert_eq!(failsafe.permission(), Permission::Coast, "what a brake would do is unknown");
    assert_eq!(failsafe.handle(FailsafeEvent::Released), Some(Boot));
    assert!(!failsafe.may_drive() && failsafe.faults() == Faults(0));
    assert_eq!(failsafe.follow(&READY), Some(Ready));
}

#[test]
fn the_cycle_outlives_the_clock() {
    let mut failsafe = following(Conditions { running: true, ..READY });
    assert_eq!((failsafe.state(), failsafe.takes_cycles()), (Executing, Ok(())));
    let lost = Conditions { clock_known: false, running: true, ..READY };
    assert_eq!(failsafe.follow(&lost), None);
    assert_eq!(failsafe.takes_cycles(), Err(Refusal::NotSynchronised), "but takes no other");
    assert_eq!(failsafe.handle(FailsafeEvent::HostChanged), None, "nor another host");
    assert_eq!(failsafe.follow(&Conditions { running: false, ..lost }), Some(Unsynchronised));
    assert_eq!(failsafe.follow(&READY), Some(Ready));
    assert_eq!(failsafe.handle(FailsafeEvent::HostChanged), Some(Unsynchronised));
}

#[test]
fn thrusters_that_disarm_show_arming() {
    for running in [false, true] {
        let conditions = Conditions { running, ..READY };
        let mut failsafe = following(conditions);
        assert_eq!(failsafe.follow(&Conditions { armed: false, ..conditions }), Some(Arming));
        assert_eq!(failsafe.follow(&conditions), Some(if running { Executing } else { Ready }));
    }
}

#[test]
fn a_low_battery_lets_the_cycle_end_and_recovers() {
    let mut failsafe = following(Conditions { running: true, ..READY });
    let low = Conditions { low_battery: true, ..READY };
    assert_eq!(failsafe.follow(&Conditions { running: true, ..low }), None);
    assert_eq!((failsafe.state(), failsafe.takes_cycles()), (Executing, Err(Refusal::LowBattery)));
    assert_eq!(failsafe.follow(&low), Some(Holding));
    assert!(failsafe.may_drive(), "it holds its pose");
    failsafe.handle(FailsafeEvent::EmergencyStop);
    failsafe.handle(FailsafeEvent::Released);
    assert!(failsafe.faults().has(Faults::LOW_BATTERY), "a release does not charge it");
    failsafe.follow(&READY);
    assert_eq!((failsafe.faults(), failsafe.takes_cycles()), (Faults(0), Ok(())));
}

#[test]
fn an_encoder_dead_from_the_start_is_said() {
    let mut failsafe = following(Conditions { located: false, ..READY });
    assert_eq!(failsafe.handle(FailsafeEvent::Blind), Some(Stopped));
    assert!(failsafe.announces() && !failsafe.may_drive());
    failsafe.handle(FailsafeEvent::Released);
    assert_eq!(failsafe.handle(FailsafeEvent::EmergencyStop), Some(Stopped));
    assert!(!failsafe.may_drive(), "the tail angle is still unknown");
}

proptest! {
    /// Whatever happens, in whatever order: nothing is driven before the module has looked where it is.
    #[test]
    fn never_drives_unseen(steps in proptest::collection::vec((0..FailsafeEvent::ALL.len(), 0..64_usize, any::<bool>()), 0..200)) {
        let conditions: Vec<_> = all_conditions().collect();
        let mut failsafe = Failsafe::new();
        let mut seen = false;
        for (event, tick, ticks) in steps {
            if ticks {
                seen |= failsafe.state() == Boot && conditions[tick].located;
                failsafe.follow(&conditions[tick]);
            } else {
                let event = FailsafeEvent::ALL[event];
                let released = event == FailsafeEvent::Released && failsafe.state() == Stopped;
                seen = event == FailsafeEvent::Located || (seen && !released);
                failsafe.handle(event);
            }
            let silent = matches!(failsafe.state(), Boot | Unprovisioned);
            prop_assert!(seen || !failsafe.may_drive());
            prop_assert!(!silent || (!failsafe.may_drive() && !failsafe.announces()));
            prop_assert!(!silent || failsafe.takes_cycles().is_err());
            prop_assert!(failsafe.state() != Stopped || failsafe.takes_cycles() == Err(Refusal::Stopped));
        }
    }
}
