//! Fixes that are late, misdated or lost.

use super::*;

/// What arrives in so many seconds, with the time it arrived at.
fn arrivals(parameters: MocapParameters, seconds: u32, seed: u64) -> Vec<(f64, Fix)> {
    let mut mocap = Mocap::new(&parameters, seed).expect("valid");
    let mut seen = Vec::new();
    for step in 0..1000 * seconds {
        let t_s = f64::from(step) * 1e-3;
        // The pose tells when it was.
        let pose = PoseSample { t_s, position_m: [t_s, 0.0], ..PoseSample::default() };
        seen.extend(mocap.sample(t_s, &pose).map(|fix| (t_s, fix)));
    }
    seen
}

fn exact() -> MocapParameters {
    MocapParameters { position_noise_m: 0.0, heading_noise_rad: 0.0, ..MocapParameters::default() }
}

#[test]
fn a_late_fix_shows_the_pose_of_its_exposure() {
    for stamped_on_arrival in [false, true] {
        let seen = arrivals(MocapParameters { latency_s: 0.15, stamped_on_arrival, ..exact() }, 10, 1);
        // Those of the last 0.15 s are still under way.
        assert!((1180..=1183).contains(&seen.len()), "{}", seen.len());
        for (t_s, fix) in seen {
            assert!((t_s - 0.15 - fix.position_m[0]).abs() < 1.1e-3, "{t_s} s: {fix:?}");
            let stamp_s = if stamped_on_arrival { t_s } else { fix.position_m[0] };
            assert!((fix.t_s - stamp_s).abs() < 1.1e-3, "{t_s} s: {fix:?}");
        }
    }
}

#[test]
fn losses_have_the_stated_share_and_bursts_their_length() {
    let seed = 5;
    let whole = arrivals(exact(), 400, seed).len() as f64;
    let kept = arrivals(MocapParameters { loss: 0.2, ..exact() }, 400, seed).len() as f64 / whole;
    // 48 000 draws.
    assert!((kept - 0.8).abs() < 0.01, "seed {seed}: {kept}");
    let blind = arrivals(MocapParameters { burst: 0.25, burst_s: 0.5, ..exact() }, 400, seed);
    let kept = blind.len() as f64 / whole;
    let gaps: Vec<f64> =
        blind.windows(2).map(|pair| pair[1].0 - pair[0].0).filter(|gap| *gap > 0.02).collect();
    let mean_s = gaps.iter().sum::<f64>() / gaps.len() as f64;
    // Some 200 spans.
    assert!((kept - 0.75).abs() < 0.06, "seed {seed}: {kept}");
    assert!((mean_s / 0.5 - 1.0).abs() < 0.25, "seed {seed}: {mean_s} s");
}

#[test]
fn losses_leave_the_noise_of_what_comes_as_it_was() {
    let by_time = |parameters| arrivals(parameters, 20, 9);
    let all = by_time(MocapParameters::default());
    let some = by_time(MocapParameters { loss: 0.5, ..MocapParameters::default() });
    assert!(some.len() < all.len());
    assert!(some.iter().all(|fix| all.contains(fix)));
}
