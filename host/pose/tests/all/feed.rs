//! From a simulated vehicle in the water to its pose and velocity in the world, over each protocol: 20 ms ± 10 ms of latency, 2 % of
//! the frames lost, another convention of axes.

use std::time::Duration;

use nalgebra::{UnitQuaternion, Vector3};
use pose::address::{Address, Options};
use pose::axes::{Axes, Pose, Unit, Up};
use pose::feed::{Event, Feed};
use pose::frame::{Body, Frame, Label};
use pose::gate::{Gate, Limits};
use pose::natnet::message::Version;
use pose::natnet::server::{NatNetServer, Settings, Transport};
use pose::qtm::server::QtmServer;
use pose::server::Server;
use pose::source::Link;
use pose::time::{HostInstant, ServerInstant};
use pose::velocity::Tracker;
use pose::vrpn::server::VrpnServer;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::rig::ANY_PORT;

/// The server's clock less the host's, ns; VRPN counts whole microseconds.
const AHEAD_NS: i64 = 7_123_456_000;
/// The least latency, s.
const LEAST_S: f64 = 0.01;

/// A vehicle that circles at 0.25 m/s.
fn truth(at_s: f64) -> (Pose, Vector3<f64>) {
    let (radius, rate) = (1.0, 0.25);
    let angle = rate * at_s;
    let pose = Pose {
        position: Vector3::new(radius * angle.cos(), radius * angle.sin(), -0.5),
        attitude: UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle),
    };
    (pose, Vector3::new(-radius * rate * angle.sin(), radius * rate * angle.cos(), 0.0))
}

/// Serves and watches for `seconds`; the largest errors of place, m, and of velocity, m/s.
fn follow(
    server: &mut dyn Server,
    protocol: &str,
    axes: Axes,
    label: &Label,
    seconds: f64,
    seed: u64,
) -> (f64, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let address: Address = format!("{protocol}:{}", server.address()).parse().expect("an address");
    let source = address.open(Options::default()).expect("a source");
    let mut feed = Feed::new(source, Gate::new(axes, Limits::default()));
    let mut tracker = Tracker::new(10.0);
    let mut due: Vec<(f64, Frame)> = Vec::new();
    let (mut number, mut lost, mut fixes, mut dropped) = (0_u32, 0, 0, 0);
    let (mut off_m, mut off_m_s) = (0.0_f64, 0.0_f64);
    let mut now = HostInstant::default();
    // The client connects first, at its own pace.
    for _ in 0..4000 {
        if feed.status().link != Link::Connecting && server.clients() > 0 && now.seconds() > 0.5 {
            break;
        }
        now = now.after(Duration::from_millis(1));
        server.poll(now);
        feed.poll(now).expect("a source that goes on");
        std::thread::sleep(Duration::from_micros(100));
    }
    let began_s = now.seconds();
    while now.seconds() < began_s + seconds {
        now = now.after(Duration::from_millis(1));
        if now.0.as_millis().is_multiple_of(10) {
            number += 1;
            let said = axes.from_world(&truth(now.seconds()).0);
            let body = Body {
                label: label.clone(),
                position: said.position,
                attitude: said.attitude.into_inner(),
                tracked: true,
                error: None,
            };
            let host_ns = i64::try_from(now.0.as_nanos()).expect("soon after the start");
            let frame = Frame {
                number: Some(number),
                captured: ServerInstant(host_ns + AHEAD_NS),
                bodies: vec![body],
            };
            if random.random_bool(0.02) {
                lost += 1;
            } else {
                due.push((now.seconds() + LEAST_S + random.random_range(0.0..0.02), frame));
            }
        }
        due.retain(|(at_s, frame)| {
            let later = *at_s > now.seconds();
            if !later {
                server.send(now, frame);
            }
            later
        });
        server.poll(now);
        while let Some(event) = feed.poll(now).expect("a source that goes on") {
            let Event::Fix(fix) = event else {
                dropped += 1;
                continue;
            };
            fixes += 1;
            assert_eq!(fix.bodies[0].0.name, label.name, "{protocol}");
            tracker.take(fix.captured_s, &fix.bodies[0].1);
            if now.seconds() > began_s + 4.0 {
                // The least latency stays in the times: the vehicle was here so much earlier.
                let (pose, velocity) = truth(fix.captured_s - LEAST_S);
                let motion = tracker.at(fix.captured_s).expect("a motion");
                off_m = off_m.max((motion.pose.position - pose.position).norm());
                off_m_s = off_m_s.max((motion.velocity_m_s - velocity).norm());
            }
        }
        std::thread::sleep(Duration::from_micros(50));
    }
    // Two frames may overtake each other on the way: the older one is out of order then.
    let ledger = feed.ledger();
    assert!(ledger.balances(), "{ledger}");
    assert_eq!(ledger.frames.received, fixes + dropped, "{protocol}");
    assert_eq!(ledger.frames.out_of_order, dropped, "{protocol}: {ledger}");
    let served = u64::from(number) - lost - due.len() as u64;
    assert!(ledger.frames.received + 3 >= served, "{protocol}: {ledger} of {served}");
    let late_s = feed.figures().late_s(1.0);
    assert!((0.015..0.03).contains(&late_s), "{protocol}: {late_s}");
    (off_m, off_m_s)
}

#[test]
fn jitter_and_losses_do_not_become_velocity() {
    let label = Label::named("rov");
    for (seed, (up, unit)) in (0..).zip([(Up::Z, Unit::Metre), (Up::Y, Unit::Millimetre)]) {
        let axes = Axes { up, unit, origin_m: Vector3::new(0.5, -0.25, 2.0), heading_rad: 0.7 };
        let numbered = [Label::new(3, "rov")];
        let settings =
            Settings { version: Version::V4_1, transport: Transport::Unicast, clock_ahead_ns: AHEAD_NS };
        let mut natnet = NatNetServer::new(ANY_PORT, settings, &numbered).expect("a free port");
        let mut qtm = QtmServer::new(ANY_PORT, std::slice::from_ref(&label)).expect("a free port");
        let mut vrpn = VrpnServer::new(ANY_PORT, std::slice::from_ref(&label)).expect("a free port");
        let mut servers: [(&mut dyn Server, &str); 3] =
            [(&mut natnet, "natnet"), (&mut qtm, "qtm"), (&mut vrpn, "vrpn")];
        for (server, protocol) in &mut servers {
            let (off_m, off_m_s) = follow(*server, protocol, axes, &label, 8.0, seed);
            // NatNet's echoes take the least latency out of the times, all but half a round trip.
            let (most_m, most_m_s) = if *protocol == "natnet" { (0.005, 0.02) } else { (0.001, 0.02) };
            assert!(
                off_m < most_m && off_m_s < most_m_s,
                "{protocol} {up:?} {unit:?}: {off_m} m, {off_m_s} m/s"
            );
        }
    }
}
