//! Corners and headings of a polyline refined together: a pattern search that keeps to what is free.
//!
//! Each inner corner is tried a step to either side along the legs that meet in it, along what bisects them, across, up and
//! down, or left out; each leg's heading is tried a little to the left and to the right. What is cheaper and free stays; when nothing is, the step is
//! halved. Directions come from the polyline and the vertical, so that the result turns and moves with the problem.

use super::super::vector::{length, offset};
use super::fares::Direction;
use super::polyline::{Mode, Polyline, Pricer};
use quantity::vector::cross;

/// First step, where large ones end, and last one, as shares of the clearance d; most rounds at each.
const FIRST: f64 = 0.4;
const ROUGH: f64 = 0.05;
const LAST: f64 = 0.0015;
const ROUNDS: usize = 3;
/// A radian of heading for a step of so many d.
const TURN: f64 = 0.5;
/// What is gained by less than this share is not worth a try more.
const WORTH: f64 = 1e-7;

/// The polyline improved by large steps, and what it costs now.
pub(super) fn roughly(pricer: &Pricer<'_>, first: Polyline, price: f64) -> (Polyline, f64) {
    by_steps(pricer, (first, price), [FIRST, ROUGH], f64::INFINITY)
}

/// The polyline improved by small steps, and what it costs now; left unfinished where it stays far above `rival`.
pub(super) fn finely(pricer: &Pricer<'_>, first: Polyline, price: f64, rival: f64) -> (Polyline, f64) {
    by_steps(pricer, (first, price), [ROUGH, LAST], rival)
}

fn by_steps(
    pricer: &Pricer<'_>,
    (mut best, mut least): (Polyline, f64),
    [first, last]: [f64; 2],
    rival: f64,
) -> (Polyline, f64) {
    let d_m = pricer.query.clearance.distance_m;
    let mut step_m = first * d_m;
    while step_m > last * d_m {
        for _ in 0..ROUNDS {
            let before = least;
            round(pricer, &mut best, &mut least, step_m);
            if before - least < 1e-3 * before {
                break;
            }
        }
        step_m /= 2.0;
        if least > (1.0 + 0.5 * step_m / d_m) * rival {
            break;
        }
    }
    (best, least)
}

fn take(pricer: &Pricer<'_>, best: &mut Polyline, least: &mut f64, trial: Polyline) -> bool {
    match pricer.below(&trial, *least * (1.0 - WORTH)) {
        Some(price) => {
            (*best, *least) = (trial, price);
            true
        }
        None => false,
    }
}

fn round(pricer: &Pricer<'_>, best: &mut Polyline, least: &mut f64, step_m: f64) {
    let mut corner = 1;
    while corner + 1 < best.count {
        if [true, false].into_iter().any(|keep| take(pricer, best, least, best.without(corner, keep))) {
            continue;
        }
        for direction in directions(best, corner) {
            for sign in [1.0, -1.0] {
                let mut trial = *best;
                for (k, along) in direction.iter().enumerate() {
                    trial.points[corner][k] += sign * step_m * along;
                }
                if take(pricer, best, least, trial) {
                    break;
                }
            }
        }
        corner += 1;
    }
    // Two corners at once, with the leg between them.
    for corner in 1..best.count.saturating_sub(2) {
        for direction in directions(best, corner) {
            for sign in [1.0, -1.0] {
                let mut trial = *best;
                for (k, along) in direction.iter().enumerate() {
                    trial.points[corner][k] += sign * step_m * along;
                    trial.points[corner + 1][k] += sign * step_m * along;
                }
                if take(pricer, best, least, trial) {
                    break;
                }
            }
        }
    }
    let d_m = pricer.query.clearance.distance_m;
    for leg in 0..best.count - 1 {
        let along = Direction::of(offset(best.points[leg], best.points[leg + 1]));
        let yaw_rad = pricer.heading(best.modes[leg], &along);
        let tweaks = [step_m, -step_m].map(|step| Mode::At(yaw_rad + step / (TURN * d_m)));
        for mode in tweaks.into_iter().chain([Mode::Start, Mode::Slot, Mode::Along, Mode::Against]) {
            if mode == best.modes[leg] {
                continue;
            }
            let mut trial = *best;
            trial.modes[leg] = mode;
            if take(pricer, best, least, trial) {
                break;
            }
        }
    }
}

/// Ways to move a corner: along both legs, along what bisects them, across them, and the vertical.
fn directions(polyline: &Polyline, corner: usize) -> [[f64; 3]; 5] {
    let here = polyline.points[corner];
    let towards = |other: [f64; 3]| unit(offset(here, other));
    let (a, b) = (towards(polyline.points[corner - 1]), towards(polyline.points[corner + 1]));
    let up = [0.0, 0.0, 1.0];
    let bisector = unit(std::array::from_fn(|k| a[k] + b[k]));
    // On a straight line every direction across is as good: the level one.
    let across = [cross(a, b), cross(a, up)].map(unit);
    let across = if length(across[0]) > 0.5 { across[0] } else { across[1] };
    [bisector, a, b, across, up]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let size = length(v);
    if size < 1e-9 { [0.0; 3] } else { v.map(|component| component / size) }
}
