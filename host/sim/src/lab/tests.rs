use pose::axes::{Unit, Up};

use super::*;

fn still(count: usize) -> Vec<Pose> {
    let at = |index| Vector3::new(0.15 * index as f64, 0.0, 0.0);
    (0..count).map(|index| Pose { position: at(index), attitude: UnitQuaternion::identity() }).collect()
}

fn parameters() -> CameraParameters {
    CameraParameters {
        rate_hz: 100.0,
        position_noise_m: 5e-4,
        attitude_noise_rad: 2e-3,
        latency_s: 0.02,
        jitter_s: 0.01,
        loss: 0.0,
        clock_ahead_s: 100.0,
    }
}

/// Every frame of 40 s, and when it is sent.
fn frames(parameters: CameraParameters, faults: &[&str]) -> Vec<(f64, Frame)> {
    let labels = (1..=3).map(|number| Label::new(number, &format!("module-{number}"))).collect();
    let faults = faults.iter().map(|fault| fault.parse().expect(fault)).collect();
    let axes = Axes::new(Up::Z, Unit::Metre);
    let mut cameras = Cameras::new(parameters, axes, labels, faults, 7).expect("valid");
    let mut frames = Vec::new();
    for tick in 0..40_000 {
        let now_s = f64::from(tick) * 1e-3;
        cameras.look(now_s, &still(3));
        while let Some(frame) = cameras.poll(now_s) {
            frames.push((now_s, frame));
        }
    }
    frames
}

fn during(frames: &[(f64, Frame)], from_s: f64, to_s: f64) -> impl Iterator<Item = &Frame> {
    frames.iter().filter(move |(at_s, _)| (from_s..to_s).contains(at_s)).map(|(_, frame)| frame)
}

#[test]
fn latency_loss_and_noise_are_as_asked() {
    let frames = frames(CameraParameters { loss: 0.1, ..parameters() }, &[]);
    let share = frames.len() as f64 / 4000.0;
    assert!((share - 0.9).abs() < 0.02, "{share}");
    let late: Vec<f64> = frames.iter().map(|(at_s, frame)| at_s + 100.0 - frame.captured.seconds()).collect();
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    // Frames that would overtake wait: a little above the mean of 20 ms.
    assert!((0.019..0.026).contains(&mean), "{mean}");
    assert!(late.iter().all(|late_s| (0.0099..0.0312).contains(late_s)));
    let x: Vec<f64> = frames.iter().map(|(_, frame)| frame.bodies[1].position.x - 0.15).collect();
    let deviation = (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    assert!((deviation / 5e-4 - 1.0).abs() < 0.05, "{deviation}");
}

#[test]
fn each_mishap_is_what_it_says_and_ends() {
    let numbers =
        |frame: &Frame| frame.bodies.iter().map(|body| body.label.number.unwrap()).collect::<Vec<_>>();
    let blind = frames(parameters(), &["blind@10+5"]);
    assert_eq!(during(&blind, 10.0, 15.0).count(), 0);
    assert!(during(&blind, 15.0, 16.0).count() > 90);
    let swapped = frames(parameters(), &["swap:1,3@10+5"]);
    let places =
        |frame: &Frame| frame.bodies.iter().map(|body| (body.position.x / 0.15).round()).collect::<Vec<_>>();
    assert!(
        during(&swapped, 10.1, 14.9)
            .all(|frame| places(frame) == [2.0, 1.0, 0.0] && numbers(frame) == [1, 2, 3])
    );
    assert!(during(&swapped, 15.1, 20.0).all(|frame| places(frame) == [0.0, 1.0, 2.0]));
    let frozen = frames(parameters(), &["frozen@10+5"]);
    let mut still = during(&frozen, 10.1, 14.9);
    let first = still.next().expect("frames come").bodies.clone();
    assert!(still.all(|frame| frame.bodies == first));
    assert!(during(&frozen, 15.1, 16.0).all(|frame| frame.bodies != first));
    let lost = frames(parameters(), &["lost:2@10"]);
    assert!(during(&lost, 10.1, 40.0).all(|frame| !frame.bodies[1].tracked && frame.bodies[0].tracked));
    let away = frames(parameters(), &["away:2@10"]);
    let last = &away.last().expect("frames").1.bodies[1].position;
    assert!((((last.x - 0.15).hypot(last.y)) - 0.03 * 30.0).abs() < 0.01, "{last}");
    let clock = frames(parameters(), &["clock:3600@10"]);
    assert!(during(&clock, 10.1, 40.0).all(|frame| frame.captured.seconds() > 3700.0));
    let nan = frames(parameters(), &["nan:1@10+1"]);
    assert!(during(&nan, 10.1, 10.9).all(|frame| frame.bodies[0].position.x.is_nan()));
    let doubled = frames(parameters(), &["doubled@10"]);
    assert!((7990..=8000).contains(&(doubled.len() + during(&doubled, 0.0, 10.0).count())));
}

#[test]
fn what_is_no_fault_is_refused() {
    for (text, says) in [
        ("blind", "a fault reads"),
        ("blind:1@2", "a fault reads"),
        ("lost@2", "a fault reads"),
        ("deaf@2", "no fault \"deaf\"; there are blind"),
        ("lost:0@2", "must be the number of a body"),
        ("blind@-1", "must be seconds"),
        ("blind@2+nan", "must be seconds"),
        ("clock:inf@2", "must be seconds"),
    ] {
        let error = text.parse::<Fault>().expect_err(text).to_string();
        assert!(error.contains(says), "{text}: {error}");
    }
    let beyond = "lost:4@2".parse::<Fault>().expect("reads").check(3);
    assert_eq!(beyond, Err(FaultError::UnknownBody { body: 4, bodies: 3 }));
}
