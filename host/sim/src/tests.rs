//! The chain as a run uses it: tails → tank → motion capture → observer.

use std::f64::consts::{FRAC_PI_2, TAU};

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use modboat::motion::{Swing, Wrench};
use modboat::observer::{Observer, ObserverParameters};
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use record::PoseSample;

use super::mocap::{Mocap, MocapParameters};
use super::motor::{MAX_DUTY, MotorParameters, SimMotor};
use super::tank::{Tank, TankParameters};
use super::thrust::{Thrust, ThrustParameters};
use super::*;

const DT_S: f64 = 1e-3;
const PERIOD_MS: usize = 1500;

fn waveform(swing: Swing, t_s: f64) -> TailState {
    let w = TAU / 1.5;
    let (sin, cos) = (w * t_s).sin_cos();
    TailState {
        angle_rad: swing.centerline_rad + swing.amplitude_rad * cos,
        rate_rad_s: -swing.amplitude_rad * w * sin,
        acceleration_rad_s2: -swing.amplitude_rad * w * w * cos,
        inertia_kg_m2: 1.5e-4,
    }
}

fn swing(centerline_rad: f64, amplitude_rad: f64) -> Swing {
    Swing { centerline_rad, amplitude_rad }
}

/// A tail behind a real motor and a plain servo lags and jitters, and still pushes by law (2).
#[test]
fn a_motor_that_follows_the_waveform_by_its_encoder_gives_the_thrust_of_the_law() {
    for amplitude_rad in [1.0, 1.6, 2.6] {
        let target = swing(0.7, amplitude_rad);
        let (mut motor, mut pins) =
            SimMotor::new(&MotorParameters::default(), target.start_rad()).expect("valid");
        let mut thrust = Thrust::new(&Parameters::default(), &ThrustParameters::default());
        let (mut sum, mut worst_rad) = ([0.0; 2], 0.0_f64);
        for step in 1..=10 * PERIOD_MS {
            let wanted = waveform(target, step as f64 * DT_S);
            let seen_rad = f64::from(pins.sensors.encoder_counts()) * TAU / 4096.0;
            let error_rad = quantity::wrap_rad(wanted.angle_rad - seen_rad);
            let duty = ((wanted.rate_rad_s + 20.0 * error_rad) / 18.0).clamp(-1.0, 1.0);
            pins.in1.set_state((duty > 0.0).into()).expect("infallible");
            pins.in2.set_state((duty < 0.0).into()).expect("infallible");
            pins.pwm.set_duty_cycle((duty.abs() * f64::from(MAX_DUTY)) as u16).expect("infallible");
            motor.step(DT_S);
            worst_rad = worst_rad.max((motor.angle_rad() - wanted.angle_rad).abs());
            let force_n = thrust.step(DT_S, &motor.state());
            if step > 5 * PERIOD_MS {
                sum = [sum[0] + force_n[0], sum[1] + force_n[1]];
            }
        }
        let mean = sum.map(|f| f / (5 * PERIOD_MS) as f64);
        let (sin, cos) = 0.7_f64.sin_cos();
        let along_n = -(mean[0] * cos + mean[1] * sin);
        let law_n = 0.022 * amplitude_rad - 0.019;
        println!(
            "A {amplitude_rad}: {along_n:.5} N for {law_n:.5} N, tail off by at most {worst_rad:.3} rad"
        );
        // The servo's amplitude is off by a few hundredths of a radian at 0.022 N/rad.
        assert!((along_n - law_n).abs() < 0.022 * worst_rad + 1e-4, "{along_n} N for {law_n} N");
        assert!(worst_rad < 0.1, "{worst_rad} rad");
    }
}

/// One run of three modules in a row with given swings per cycle, watched by motion capture and observer.
struct Watched {
    /// True velocity north and its estimate, and the same of the yaw rate, each millisecond.
    velocity_m_s: Vec<[f64; 2]>,
    yaw_rate_rad_s: Vec<[f64; 2]>,
}

fn watch(swings: impl Fn(usize) -> [Swing; 3], cycles: usize, tank: &TankParameters, lost: bool) -> Watched {
    let parameters = Parameters::default();
    let structure = Structure::from_word("3x1").expect("three in a row");
    let positions_m = structure.positions_m(parameters.pitch_m);
    let start = PoseSample { heading_rad: FRAC_PI_2, ..PoseSample::default() };
    let mut tank = Tank::new(&structure, &parameters, tank, &start, 1).expect("valid");
    let mut mocap = Mocap::new(&MocapParameters::default(), 2).expect("valid");
    let mut observer = Observer::new(&structure, &parameters, &ObserverParameters::default()).expect("valid");
    let mut watched = Watched { velocity_m_s: Vec::new(), yaw_rate_rad_s: Vec::new() };
    for cycle in 0..cycles {
        let swings = swings(cycle);
        let wrench = swings
            .iter()
            .zip(&positions_m)
            .fold(Wrench::default(), |sum, (swing, &at)| sum + swing.wrench(&parameters, at));
        observer.set_wrench(tank.pose().t_s, wrench);
        for step in 1..=PERIOD_MS {
            let tails = swings.map(|swing| waveform(swing, step as f64 * DT_S));
            tank.step(DT_S, &tails);
            let pose = tank.pose();
            if let Some(fix) = mocap.sample(pose.t_s, &pose)
                && !(lost && step % 97 < 60)
            {
                observer.update(&fix);
            }
            let estimate = observer.estimate().unwrap_or_default();
            watched.velocity_m_s.push([pose.velocity_m_s[1], estimate.velocity_m_s[1]]);
            watched.yaw_rate_rad_s.push([pose.yaw_rate_rad_s, estimate.yaw_rate_rad_s]);
        }
    }
    watched
}

/// Mean and half of the peak-to-peak range.
fn mean_and_ripple(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let (low, high) = values.clone().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    (values.sum::<f64>() / count, 0.5 * (high - low))
}

fn astern(amplitude_rad: f64) -> [Swing; 3] {
    [swing(-FRAC_PI_2, amplitude_rad), swing(-FRAC_PI_2, amplitude_rad), swing(-FRAC_PI_2, amplitude_rad)]
}

#[test]
fn the_observer_lets_no_wobble_through_and_no_current_deceive_it() {
    for (current_m_s, lost) in [(0.0, false), (0.015, false), (-0.01, true)] {
        let parameters = TankParameters { current_m_s: [0.0, current_m_s], ..TankParameters::default() };
        let watched = watch(|_| astern(1.4), 60, &parameters, lost);
        let last = watched.velocity_m_s.len() - 10 * PERIOD_MS;
        let (true_mean, true_ripple) = mean_and_ripple(watched.velocity_m_s[last..].iter().map(|v| v[0]));
        let (mean, ripple) = mean_and_ripple(watched.velocity_m_s[last..].iter().map(|v| v[1]));
        let (_, true_yaw) = mean_and_ripple(watched.yaw_rate_rad_s[last..].iter().map(|v| v[0]));
        let (yaw_mean, yaw) = mean_and_ripple(watched.yaw_rate_rad_s[last..].iter().map(|v| v[1]));
        println!(
            "current {current_m_s} lost {lost}: v {true_mean:.5} ± {true_ripple:.5} seen as {mean:.5} ± {ripple:.5} m/s; \
             Ω ± {true_yaw:.4} seen as {yaw_mean:.5} ± {yaw:.5} rad/s"
        );
        assert!((mean / true_mean - 1.0).abs() < 0.01, "{mean} m/s for {true_mean} m/s");
        assert!(ripple < 0.1 * true_ripple && ripple < 0.02 * true_mean, "{ripple} m/s of {true_ripple} m/s");
        assert!(yaw_mean.abs() < 5e-4 && yaw < 0.1 * true_yaw, "{yaw_mean} ± {yaw} of {true_yaw} rad/s");
    }
}

#[test]
fn the_observer_follows_a_manoeuvre_with_little_lag() {
    // Half a minute forward, then stronger, then resting tails.
    let amplitude = |cycle: usize| [1.3, 1.9, 0.0][(cycle / 20).min(2)];
    let watched = watch(|cycle| astern(amplitude(cycle)), 60, &TankParameters::default(), false);
    // The truth without its wobble: the mean over one period around each instant.
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(watched.velocity_m_s.iter().scan(0.0, |sum, v| {
            *sum += v[0];
            Some(*sum)
        }))
        .collect();
    let smooth = |at: usize| (sums[at + PERIOD_MS / 2] - sums[at - PERIOD_MS / 2]) / PERIOD_MS as f64;
    let error = |lag_ms: usize| {
        let span = 2 * PERIOD_MS..watched.velocity_m_s.len() - PERIOD_MS;
        let count = span.len() as f64;
        let square: f64 = span.map(|at| (watched.velocity_m_s[at][1] - smooth(at - lag_ms)).powi(2)).sum();
        (square / count).sqrt()
    };
    let best_ms = (0..750).step_by(10).min_by(|&a, &b| error(a).total_cmp(&error(b))).expect("some lag");
    println!("lag {best_ms} ms, error there {:.5} m/s, without shift {:.5} m/s", error(best_ms), error(0));
    assert!(best_ms < 200, "{best_ms} ms");
    assert!(error(0) < 0.002, "{} m/s", error(0));
}

/// A transition without thrust before each swim cycle makes the velocity a saw, and decisions fall on its teeth. With
/// the mean wrench over both, the estimate at the decisions is the mean velocity all the same.
#[test]
fn transitions_do_not_bias_what_the_decisions_see() {
    let parameters = Parameters::default();
    let structure = Structure::from_word("3x1").expect("three in a row");
    let start = PoseSample { heading_rad: FRAC_PI_2, ..PoseSample::default() };
    let mut tank = Tank::new(&structure, &parameters, &TankParameters::default(), &start, 1).expect("valid");
    let mut mocap = Mocap::new(&MocapParameters::default(), 2).expect("valid");
    let mut observer = Observer::new(&structure, &parameters, &ObserverParameters::default()).expect("valid");
    let mut from_rad = -FRAC_PI_2 + 1.4;
    let (mut seen_m_s, mut moved_m, mut time_s) = (0.0, 0.0, 0.0);
    for cycle in 0..60 {
        let target = swing(-FRAC_PI_2 + [0.3, -0.3][cycle % 2], 1.4);
        let planned = structure
            .positions_m(parameters.pitch_m)
            .iter()
            .fold(Wrench::default(), |sum, &at| sum + target.wrench(&parameters, at));
        let before = tank.pose();
        observer.set_wrench(before.t_s, Wrench::from_array(planned.to_array().map(|f| f * 1.5 / 2.0)));
        let rate_rad_s = (target.start_rad() - from_rad) / 0.5;
        for step in 1..=500 + PERIOD_MS {
            let tail = if step <= 500 {
                let angle_rad = from_rad + rate_rad_s * step as f64 * DT_S;
                TailState { angle_rad, rate_rad_s, ..TailState::default() }
            } else {
                waveform(target, (step - 500) as f64 * DT_S)
            };
            tank.step(DT_S, &[tail; 3]);
            let pose = tank.pose();
            if let Some(fix) = mocap.sample(pose.t_s, &pose) {
                observer.update(&fix);
            }
        }
        from_rad = target.start_rad();
        if cycle >= 30 {
            seen_m_s += observer.estimate().expect("has fixes").velocity_m_s[1] / 30.0;
            moved_m += tank.pose().position_m[1] - before.position_m[1];
            time_s += tank.pose().t_s - before.t_s;
        }
    }
    let mean_m_s = moved_m / time_s;
    println!("seen {seen_m_s:.5} m/s, moved at {mean_m_s:.5} m/s");
    assert!((seen_m_s / mean_m_s - 1.0).abs() < 0.01, "{seen_m_s} m/s for {mean_m_s} m/s");
}
