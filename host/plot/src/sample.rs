//! A made-up run for the tests of the pictures: modules that swim as demanded, with a wobble.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use modboat::motion::{Swing, Turn, Wrench};
use modboat::parameters::Parameters;
use record::{CycleRecord, LegRecord, PoseSample, RunRecord, TailSample};

/// `columns` × `rows` modules, two legs of `leg_s` seconds each.
pub fn run(columns: i32, rows: i32, leg_s: f64, courses: [[f64; 2]; 2]) -> RunRecord {
    let parameters = Parameters::default();
    let cells: Vec<[i32; 2]> = (0..rows).flat_map(|r| (0..columns).map(move |c| [c, r])).collect();
    let centre = [0.5 * f64::from(columns - 1), 0.5 * f64::from(rows - 1)];
    let positions_m: Vec<[f64; 2]> = cells
        .iter()
        .map(|c| [0, 1].map(|axis| (f64::from(c[axis]) - centre[axis]) * parameters.pitch_m))
        .collect();
    let legs: Vec<LegRecord> = (0..2)
        .map(|n| LegRecord {
            start_s: n as f64 * leg_s,
            end_s: (n + 1) as f64 * leg_s,
            velocity_m_s: courses[n],
            station_m: None,
            heading_rad: FRAC_PI_2,
        })
        .collect();
    let end_s = 2.0 * leg_s;
    let (cycles, tails) = swim(&parameters, &positions_m, end_s);
    RunRecord {
        name: "holonomic-4".to_owned(),
        description: "East for a minute, then north for another, facing north".to_owned(),
        poses: drift(&legs, end_s),
        parameters,
        cells,
        positions_m,
        legs,
        gaps: Vec::new(),
        tails,
        cycles,
    }
}

fn drift(legs: &[LegRecord], end_s: f64) -> Vec<PoseSample> {
    let mut position_m = [0.4, -0.2];
    let mut smooth = [0.0; 2];
    let dt = 0.05;
    (0..=(end_s / dt) as usize)
        .map(|n| {
            let t_s = n as f64 * dt;
            let leg = legs.iter().rev().find(|l| l.start_s <= t_s).expect("a leg from the start");
            let wave = (PI * t_s).sin();
            for axis in 0..2 {
                smooth[axis] += (leg.velocity_m_s[axis] - smooth[axis]) * dt / 5.0;
                position_m[axis] += (smooth[axis] + 0.004 * (0.11 * t_s + axis as f64).sin()) * dt;
            }
            PoseSample {
                t_s,
                position_m,
                heading_rad: FRAC_PI_2 + 0.08 * (0.23 * t_s).sin() + 0.04 * wave,
                velocity_m_s: [smooth[0] + 0.01 * wave, smooth[1] - 0.006 * wave],
                yaw_rate_rad_s: 0.02 * (0.23 * t_s).cos(),
            }
        })
        .collect()
}

fn swim(
    parameters: &Parameters,
    positions_m: &[[f64; 2]],
    end_s: f64,
) -> (Vec<CycleRecord>, Vec<TailSample>) {
    let length_s = parameters.period_s + parameters.transition_s;
    let mut pose: Vec<f64> = vec![-FRAC_PI_2; positions_m.len()];
    let (mut cycles, mut tails) = (Vec::new(), Vec::new());
    for number in 0..(end_s / length_s) as u32 {
        let start_s = f64::from(number) * length_s;
        let swings: Vec<Swing> = (0..positions_m.len())
            .map(|i| {
                // Slow walks, different for every module, some across the cut at ±π.
                let phase = f64::from(number) * 0.13 + i as f64 * 2.1;
                let sign = if (number as usize + i).is_multiple_of(5) { -1.0 } else { 1.0 };
                Swing {
                    centerline_rad: (phase.sin() * 3.0 + PI).rem_euclid(TAU) - PI,
                    amplitude_rad: sign * (1.3 + 0.4 * (0.7 * phase).cos()),
                }
            })
            .collect();
        let turns: Vec<Turn> = swings
            .iter()
            .zip(&pose)
            .map(|(swing, &from_rad)| {
                let ahead = (swing.start_rad() - from_rad).rem_euclid(TAU);
                Turn { from_rad, to_rad: from_rad + if ahead > PI { ahead - TAU } else { ahead } }
            })
            .collect();
        for step in 0..(length_s / 0.02) as u32 {
            let t = f64::from(step) * 0.02;
            let actual_rad = turns.iter().zip(&swings).map(|(turn, swing)| {
                let lag = 0.03;
                let swum = t - parameters.transition_s - lag;
                if swum < 0.0 {
                    turn.from_rad
                        + turn.rotation_rad() * ((t - lag) / parameters.transition_s).clamp(0.0, 1.0)
                } else {
                    turn.to_rad + swing.amplitude_rad * ((TAU * swum / parameters.period_s).cos() - 1.0)
                }
            });
            tails.push(TailSample { t_s: start_s + t, actual_rad: actual_rad.collect() });
        }
        pose = turns.iter().map(|turn| turn.to_rad).collect();
        let total = swings
            .iter()
            .zip(positions_m)
            .map(|(swing, &at)| swing.wrench(parameters, at))
            .fold(Wrench::default(), |sum, w| sum + w);
        let miss = 0.002 * (f64::from(number) * 0.9).sin();
        cycles.push(CycleRecord {
            number,
            start_s,
            transition_s: parameters.transition_s,
            ramps_s: [0.0; 2],
            period_s: parameters.period_s,
            outcome: "planned",
            demand: total + Wrench { fx_n: 0.0, fy_n: 0.5 * miss.max(0.0), tau_nm: 0.0 },
            commanded: total,
            achieved: Some(total + Wrench { fx_n: miss, fy_n: -miss, tau_nm: 0.1 * miss }),
            error: 0.0,
            travel_rad: turns.iter().map(|turn| turn.rotation_rad().abs()).sum(),
            clearance_m: 0.01,
            guarantee_m: Some(0.008),
            solve_us: 900,
            swings,
            turns,
            via: None,
            outside_envelope: false,
            bounded: false,
            loss_tolerant: true,
            power_tolerant: true,
        });
    }
    (cycles, tails)
}
