//! The clock against a simulated server: drift, jitter, stalls and jumps.

use std::time::Duration;

use pose::clock::{Clock, Reading};
use pose::source::Exchange;
use pose::time::{HostInstant, ServerInstant};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Seconds between frames.
const PERIOD_S: f64 = 0.01;
/// The least latency, s.
const LEAST_S: f64 = 0.01;

/// A server whose clock is ahead by `ahead_s` and runs fast by `drift`.
struct Server {
    ahead_s: f64,
    drift: f64,
    random: ChaCha8Rng,
}

impl Server {
    fn new(seed: u64) -> Self {
        Self { ahead_s: 1.7e9, drift: 5e-5, random: ChaCha8Rng::seed_from_u64(seed) }
    }

    fn stamp(&self, host_s: f64) -> ServerInstant {
        let seconds = host_s * (1.0 + self.drift);
        // Whole seconds apart, so that no digits are lost.
        ServerInstant(ServerInstant::from_seconds(seconds).0 + ServerInstant::from_seconds(self.ahead_s).0)
    }

    /// A latency of 20 ms ± 10 ms.
    fn latency_s(&mut self) -> f64 {
        LEAST_S + self.random.random_range(0.0..0.02)
    }
}

/// What the clock makes of frames captured from `from_s` on: the time of capture and the reading.
fn run(clock: &mut Clock, server: &mut Server, from_s: f64, seconds: f64) -> Vec<(f64, Option<Reading>)> {
    let mut found = Vec::new();
    let mut at_s = from_s;
    while at_s < from_s + seconds {
        let arrived = HostInstant::from_seconds(at_s + server.latency_s());
        found.push((at_s, clock.read(server.stamp(at_s), arrived)));
        at_s += PERIOD_S;
    }
    found
}

/// The largest error of a reading beyond the least latency, s.
fn worst(found: &[(f64, Option<Reading>)]) -> f64 {
    let errors = found
        .iter()
        .map(|(at_s, reading)| (reading.expect("a stamp that fits").captured_s - at_s - LEAST_S).abs());
    errors.fold(0.0, f64::max)
}

#[test]
fn jitter_and_drift_stay_out_of_the_times() {
    for seed in 0..20 {
        let (mut clock, mut server) = (Clock::default(), Server::new(seed));
        run(&mut clock, &mut server, 0.0, 3.0);
        // Before the drift is known it adds 50 µs a second.
        let early = worst(&run(&mut clock, &mut server, 3.0, 10.0));
        assert!(early < 1.5e-3, "seed {seed}: {early} s");
        run(&mut clock, &mut server, 13.0, 60.0);
        let late = run(&mut clock, &mut server, 73.0, 60.0);
        assert!(worst(&late) < 1e-3, "seed {seed}: {} s", worst(&late));
        assert!((clock.drift() - 5e-5).abs() < 1e-5, "seed {seed}: {}", clock.drift());
        // Velocity of a body at 0.1 m/s from two frames: an error of the times is an error of the velocity.
        let ends = late.windows(2).map(|pair| {
            let [(_, a), (_, b)] = pair else { unreachable!("windows of two") };
            b.expect("a reading").captured_s - a.expect("a reading").captured_s
        });
        let off = ends.map(|step_s| (step_s / PERIOD_S - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < 0.1, "seed {seed}: velocity off by {off}; the jitter itself would make 2");
        assert_eq!(clock.jumps(), 0);
    }
}

#[test]
fn exchanges_show_the_least_delay() {
    for seed in 0..20 {
        let (mut clock, mut server) = (Clock::default(), Server::new(seed));
        run(&mut clock, &mut server, 0.0, 5.0);
        assert_eq!(clock.least_delay_s(), None);
        for count in 0..10 {
            let sent_s = 5.0 + 0.5 * f64::from(count);
            let there_s = server.random.random_range(0.0002..0.001);
            let back_s = server.random.random_range(0.0002..0.001);
            clock.exchanged(&Exchange {
                sent: HostInstant::from_seconds(sent_s),
                server: server.stamp(sent_s + there_s),
                received: HostInstant::from_seconds(sent_s + there_s + back_s),
            });
        }
        let (least_s, within_s) = clock.least_delay_s().expect("exchanges");
        assert!((least_s - LEAST_S).abs() < within_s + 1e-3, "seed {seed}: {least_s} ± {within_s}");
        for (at_s, reading) in run(&mut clock, &mut server, 10.0, 5.0) {
            let off_s = reading.expect("a stamp that fits").captured_s - at_s;
            assert!(off_s.abs() < within_s + 1e-3, "seed {seed}: {off_s} s");
        }
    }
}

#[test]
fn a_jump_of_an_hour_either_way_is_learned_again_and_counted() {
    for (seed, hours) in [(1, 1.0), (2, -1.0), (3, 1.0), (4, -1.0)] {
        let (mut clock, mut server) = (Clock::default(), Server::new(seed));
        run(&mut clock, &mut server, 0.0, 20.0);
        server.ahead_s += hours * 3600.0;
        let found = run(&mut clock, &mut server, 20.0, 5.0);
        let aside = found.iter().filter(|(_, reading)| reading.is_none()).count();
        assert!((25..45).contains(&aside), "seed {seed}: {aside} frames set aside");
        assert_eq!(clock.jumps(), 1);
        assert!(worst(&found[aside + 100..]) < 1.5e-3, "seed {seed}");
    }
}

#[test]
fn one_wrong_stamp_is_set_aside_and_no_jump() {
    let (mut clock, mut server) = (Clock::default(), Server::new(5));
    run(&mut clock, &mut server, 0.0, 20.0);
    for at_s in [20.0, 20.5, 21.0] {
        assert_eq!(clock.read(ServerInstant(17), HostInstant::from_seconds(at_s)), None);
        assert!(worst(&run(&mut clock, &mut server, at_s, 0.4)) < 1.5e-3);
    }
    assert_eq!(clock.jumps(), 0);
}

#[test]
fn a_stall_of_three_seconds_is_no_jump() {
    let (mut clock, mut server) = (Clock::default(), Server::new(6));
    run(&mut clock, &mut server, 0.0, 20.0);
    // Frames of three seconds come at once, then all goes on.
    for frame in 0..300 {
        let captured_s = 20.0 + PERIOD_S * f64::from(frame);
        clock.read(server.stamp(captured_s), HostInstant::from_seconds(23.0 + 1e-5 * f64::from(frame)));
    }
    assert!(worst(&run(&mut clock, &mut server, 23.01, 20.0)) < 1.5e-3);
    assert_eq!(clock.jumps(), 0);
}

#[test]
fn half_a_second_more_of_latency_is_seen_as_latency() {
    let (mut clock, mut server) = (Clock::default(), Server::new(7));
    run(&mut clock, &mut server, 0.0, 20.0);
    for frame in 0..1000 {
        let at_s = 20.0 + PERIOD_S * f64::from(frame);
        let reading = clock.read(server.stamp(at_s), HostInstant::from_seconds(at_s + 0.5 + LEAST_S));
        let reading = reading.expect("a stamp that fits");
        assert!((reading.captured_s - at_s - LEAST_S).abs() < 2e-3, "{reading:?} at {at_s}");
        assert!((reading.late_s - 0.5).abs() < 2e-3);
    }
    assert_eq!(clock.jumps(), 0);
}

#[test]
fn extreme_stamps_do_no_harm() {
    let mut clock = Clock::default();
    let mut host = HostInstant::default();
    for stamp in [0, i64::MAX, i64::MIN, -1, i64::MAX, i64::MAX, 0, i64::MIN] {
        for _ in 0..50 {
            host = host.after(Duration::from_millis(10));
            if let Some(reading) = clock.read(ServerInstant(stamp), host) {
                assert!(reading.captured_s.is_finite());
            }
        }
    }
}
