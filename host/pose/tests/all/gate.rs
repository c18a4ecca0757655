//! The gate against a stream of three drifting bodies with faults put into it: each is dropped, named and counted, and the account
//! balances.

use std::time::Duration;

use nalgebra::{Quaternion, Vector3};
use pose::axes::{Axes, Unit, Up};
use pose::frame::{Arrival, Body, Frame, Label};
use pose::gate::{Fix, Gate, Limits};
use pose::ledger::FrameFault;
use pose::time::{HostInstant, ServerInstant};
use proptest::prelude::*;

/// Frame `number` of a stream at 100 Hz, 20 ms under way.
fn arrival(number: u32) -> Arrival {
    let at_s = 0.01 * f64::from(number);
    let bodies = (0..3).map(|index| Body {
        label: Label::named(&format!("boat {index}")),
        // 0.1 m/s: a millimetre a frame.
        position: Vector3::new(f64::from(index), 0.1 * at_s, 0.0),
        attitude: Quaternion::new(1.0, 0.0, 0.0, 0.0),
        tracked: true,
        error: None,
    });
    let captured = ServerInstant(10_000_000 * i64::from(number));
    Arrival {
        frame: Frame { number: Some(number), captured, bodies: bodies.collect() },
        arrived: HostInstant::from_seconds(at_s + 0.02),
    }
}

fn gate() -> Gate {
    Gate::new(Axes::new(Up::Z, Unit::Metre), Limits::default())
}

fn feed(gate: &mut Gate, numbers: std::ops::Range<u32>) {
    for number in numbers {
        let fix = gate.take(&arrival(number)).expect("a sound frame");
        assert_eq!(fix.bodies.len(), 3);
        assert!((fix.captured_s - fix.arrived_s + 0.0).abs() < 1e-9, "the least delay stays in the time");
    }
}

#[test]
fn sound_frames_pass_with_their_poses_in_the_world() {
    let mut gate = Gate::new(Axes::new(Up::Y, Unit::Millimetre), Limits::default());
    let fix: Fix = gate.take(&arrival(0)).expect("a sound frame");
    assert_eq!(fix.bodies[2].1.position, Vector3::new(0.002, 0.0, 0.0));
    assert_eq!(fix.bodies[2].0, Label::named("boat 2"));
}

#[test]
fn doubled_late_and_misstamped_frames_are_dropped() {
    let mut gate = gate();
    feed(&mut gate, 0..200);
    assert_eq!(gate.take(&arrival(199)), Err(FrameFault::Doubled));
    let mut late = arrival(150);
    late.arrived = arrival(200).arrived;
    assert_eq!(gate.take(&late), Err(FrameFault::OutOfOrder));
    let mut off = arrival(200);
    off.frame.captured = ServerInstant(3_600_000_000_000);
    assert_eq!(gate.take(&off), Err(FrameFault::OffTheClock));
    feed(&mut gate, 200..210);
    let frames = gate.ledger().frames;
    assert_eq!((frames.received, frames.accepted), (213, 210));
    assert_eq!((frames.doubled, frames.out_of_order, frames.off_the_clock), (1, 1, 1));
    assert!(gate.ledger().balances());
}

#[test]
fn a_stream_that_stands_still_is_frozen_until_it_moves() {
    let mut gate = gate();
    feed(&mut gate, 0..100);
    let still = arrival(99).frame.bodies;
    let mut faults = Vec::new();
    for number in 100..200 {
        let mut arrival = arrival(number);
        arrival.frame.bodies.clone_from(&still);
        faults.extend(gate.take(&arrival).err());
    }
    // Half a second is allowed, at 100 Hz.
    assert_eq!(faults, [FrameFault::Frozen; 50]);
    feed(&mut gate, 200..210);
    // Nothing stands still where nothing is seen.
    for number in 210..300 {
        let mut arrival = arrival(number);
        arrival.frame.bodies.iter_mut().for_each(|body| body.tracked = false);
        assert_eq!(gate.take(&arrival), Err(FrameFault::WithoutBody));
    }
    assert_eq!(gate.ledger().frames.frozen, 50);
    assert_eq!(gate.ledger().bodies.untracked, 270);
    assert!(gate.ledger().balances());
}

#[test]
fn a_simulation_without_noise_may_stand_still() {
    let limits = Limits { frozen_after_s: None, ..Limits::default() };
    let mut gate = Gate::new(Axes::new(Up::Z, Unit::Metre), limits);
    let still = arrival(0).frame.bodies;
    for number in 0..300 {
        let mut arrival = arrival(number);
        arrival.frame.bodies.clone_from(&still);
        gate.take(&arrival).expect("a sound frame");
    }
}

#[test]
fn bodies_that_are_no_fixes_leave_the_others() {
    let mut gate = gate();
    feed(&mut gate, 0..10);
    let spoiled: [fn(&mut Body); 5] = [
        |body| body.tracked = false,
        |body| body.position.x = f64::NAN,
        |body| body.attitude.w = f64::INFINITY,
        |body| body.attitude = Quaternion::new(0.0, 0.0, 0.0, 0.0),
        |body| body.position.x += 0.5,
    ];
    for (number, spoil) in (10..).zip(spoiled) {
        let mut arrival = arrival(number);
        spoil(&mut arrival.frame.bodies[1]);
        let fix = gate.take(&arrival).expect("two bodies are left");
        let names: Vec<String> = fix.bodies.iter().map(|(label, _)| label.to_string()).collect();
        assert_eq!(names, ["\"boat 0\"", "\"boat 2\""]);
    }
    let bodies = gate.ledger().bodies;
    assert_eq!((bodies.untracked, bodies.not_finite, bodies.teleported), (1, 3, 1));
    assert!(gate.ledger().balances());
    feed(&mut gate, 15..20);
}

#[test]
fn a_body_that_stays_elsewhere_is_believed_there() {
    let mut gate = gate();
    feed(&mut gate, 0..10);
    let counts: Vec<usize> = (10..20)
        .map(|number| {
            let mut arrival = arrival(number);
            arrival.frame.bodies[1].position.x += 0.5;
            gate.take(&arrival).expect("two bodies are left").bodies.len()
        })
        .collect();
    assert_eq!(counts, [2, 2, 2, 2, 3, 3, 3, 3, 3, 3]);
    assert_eq!(gate.ledger().bodies.teleported, 4);
}

#[test]
fn parts_of_a_frame_without_number_are_no_doubles() {
    let mut gate = gate();
    for number in 0..50 {
        let whole = arrival(number);
        for body in &whole.frame.bodies {
            let mut part = whole.clone();
            (part.frame.number, part.frame.bodies) = (None, vec![body.clone()]);
            gate.take(&part).expect("a part");
        }
        let mut again = whole;
        again.frame.number = None;
        assert_eq!(gate.take(&again), Err(FrameFault::Doubled));
    }
    assert_eq!((gate.ledger().frames.accepted, gate.ledger().frames.doubled), (150, 50));
}

#[test]
fn a_server_whose_clock_jumps_is_followed_again() {
    let mut gate = gate();
    feed(&mut gate, 0..200);
    let mut accepted = 0;
    for number in 200..400 {
        let mut arrival = arrival(number);
        arrival.frame.captured.0 -= 3_600_000_000_000;
        accepted += u32::from(gate.take(&arrival).is_ok());
    }
    assert_eq!(gate.clock().jumps(), 1);
    let aside = gate.ledger().frames.off_the_clock;
    // 0.3 s at 100 Hz.
    assert!((30..=31).contains(&aside), "{aside}");
    assert_eq!(u64::from(accepted) + aside, 200);
    assert!(gate.ledger().balances());
}

proptest! {
    #[test]
    fn the_account_balances_whatever_comes(
        steps in prop::collection::vec((0_u32..300, 0_i64..4, 0_u64..60, 0_usize..4, 0_u8..6), 1..200),
    ) {
        let mut gate = gate();
        let mut now = HostInstant::default();
        let mut accepted = (0, 0);
        for (number, hours, pause_ms, gone, fault) in steps {
            now = now.after(Duration::from_millis(pause_ms));
            let mut arrival = arrival(number);
            arrival.arrived = now;
            arrival.frame.captured.0 += hours / 3 * 3_600_000_000_000;
            arrival.frame.bodies.drain(..gone.min(3));
            for body in &mut arrival.frame.bodies {
                match fault {
                    0 => body.tracked = false,
                    1 => body.position.y = f64::NAN,
                    2 => body.position.z = 1e300,
                    3 => body.attitude = Quaternion::new(f64::MAX, 1.0, 0.0, 0.0),
                    _ => {}
                }
            }
            if let Ok(fix) = gate.take(&arrival) {
                accepted = (accepted.0 + 1, accepted.1 + fix.bodies.len() as u64);
                prop_assert!(fix.bodies.iter().all(|(_, pose)| pose.position.iter().all(|x| x.is_finite())));
            }
            prop_assert!(gate.ledger().balances(), "{}", gate.ledger());
        }
        let ledger = gate.ledger();
        prop_assert_eq!((ledger.frames.accepted, ledger.bodies.accepted), accepted);
    }
}
