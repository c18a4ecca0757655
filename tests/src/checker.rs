//! A checker of plans that shares no code with the planner: numbers in, the first broken promise out.
//!
//! It takes a request and an answer as `flotilla plan` exchanges them and works out again, with constants, geometry and
//! laws of its own, everything the answer claims:
//!
//! ```text
//! φᵢ(t) = fromᵢ + (toᵢ − fromᵢ)·t/t_trans                           transition, constant speed
//! φᵢ(t) = φ₀ᵢ + Aᵢ·cos(2πt/T)                                        swim cycle               (1)
//! F(A) = 0.022·|A| − 0.019                                                                    (2)
//! F = Σ (−F(Aᵢ)·cos φ₀ᵢ, −F(Aᵢ)·sin φ₀ᵢ, −F(Aᵢ)·(sin φ₀ᵢ·xᵢ − cos φ₀ᵢ·yᵢ))                   (7)
//! error = ‖w∘(F_des − F)‖ / ‖w∘F_des‖,  w = (1, 1, 10);  absolute for a zero demand
//! ```
//!
//! - no two tails overlap, in transition and swim, at samples between which no tip moves more than [`STEP_M`];
//! - every turn begins where the tail is and ends, a number of turns aside, at φ₀ + A, in one step or by way of a pose that
//!   all tails rest at; no tail is faster than it can be;
//! - |A| lies in its range, or is zero and that tail rests; if the plan is called held, all do;
//! - wrench, error, travel and clearance are what the motion makes them;
//! - a plan called loss tolerant stays clear when either module of a pair rests where it was, or between the two steps.
//!
//! Pairs are all modules up to three cells apart whose circles of tails meet. Limits: an overlap of less than [`STEP_M`] that
//! comes and goes between two samples is not seen.

use std::f64::consts::TAU;

pub use answer::{Answer, Request};

mod answer;
pub mod geometry;

/// The farthest that a tip moves from one sample to the next, m.
pub const STEP_M: f64 = 5e-4;
/// Angles that should be equal may differ by this, rad.
const ANGLE_RAD: f64 = 1e-6;
/// Forces, torques and errors that should be equal may differ by this, N, N·m, –.
const ROUNDING: f64 = 1e-9;
/// A turn may be this much faster, rad/s: its time is rounded to whole microseconds.
const SPEED_RAD_S: f64 = 1e-4;

/// The checker's own copy of what it needs to know of a module.
#[derive(Clone, Debug)]
pub struct Modboat {
    /// Lattice pitch, m.
    pub pitch_m: f64,
    /// Tail from motor axis to the centre of its round tip, m.
    pub tail_length_m: f64,
    /// Tail's full width, m.
    pub tail_width_m: f64,
    /// T, s.
    pub period_s: f64,
    /// t_trans, s.
    pub transition_s: f64,
    /// Least |A|, rad.
    pub amplitude_min_rad: f64,
    /// Greatest |A|, rad.
    pub amplitude_max_rad: f64,
    /// Slope of (2), N/rad.
    pub force_slope_n_rad: f64,
    /// Offset of (2), N.
    pub force_offset_n: f64,
    /// Greatest speed of a tail, rad/s.
    pub tail_speed_max_rad_s: f64,
    /// w.
    pub weights: [f64; 3],
}

impl Default for Modboat {
    fn default() -> Self {
        Self {
            pitch_m: 0.15,
            tail_length_m: 0.6 * 0.15,
            tail_width_m: 0.1 * 0.15,
            period_s: 1.5,
            transition_s: 0.5,
            amplitude_min_rad: 0.9,
            amplitude_max_rad: 2.6,
            force_slope_n_rad: 0.022,
            force_offset_n: 0.019,
            tail_speed_max_rad_s: 13.0,
            weights: [1.0, 1.0, 10.0],
        }
    }
}

impl Modboat {
    /// F(A) of (2), N.
    #[must_use]
    pub fn thrust_n(&self, amplitude_rad: f64) -> f64 {
        self.force_slope_n_rad * amplitude_rad.abs() - self.force_offset_n
    }

    /// Module centres about their mean, m.
    #[must_use]
    pub fn positions_m(&self, cells: &[[i32; 2]]) -> Vec<[f64; 2]> {
        let sum = cells.iter().fold([0, 0], |[col, row], cell| [col + cell[0], row + cell[1]]);
        let n = cells.len() as f64;
        let about = |cell: &[i32; 2], k: usize| self.pitch_m * (f64::from(cell[k]) - f64::from(sum[k]) / n);
        cells.iter().map(|cell| [about(cell, 0), about(cell, 1)]).collect()
    }

    fn weighted(&self, wrench: [f64; 3]) -> f64 {
        wrench.iter().zip(self.weights).map(|(f, w)| (w * f) * (w * f)).sum::<f64>().sqrt()
    }
}

/// Motion of one tail during one phase of a plan: its angle over the share of the phase that has passed.
#[derive(Clone, Copy, Debug)]
enum TailMotion {
    Rest(f64),
    Turn { from: f64, to: f64 },
    Swing { centerline: f64, amplitude: f64 },
}

impl TailMotion {
    fn at(self, share: f64) -> f64 {
        match self {
            Self::Rest(angle) => angle,
            Self::Turn { from, to } => from + (to - from) * share,
            // φ = φ₀ + A·cos(2πt/T)                                                                (1)
            Self::Swing { centerline, amplitude } => centerline + amplitude * (TAU * share).cos(),
        }
    }

    /// The greatest |dφ/dshare|, rad.
    fn speed(self) -> f64 {
        match self {
            Self::Rest(_) => 0.0,
            Self::Turn { from, to } => (to - from).abs(),
            Self::Swing { amplitude, .. } => TAU * amplitude.abs(),
        }
    }
}

/// Two modules with tails that can meet: the second at `apart_m` from the first.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The first, from 0.
    pub i: usize,
    /// The second.
    pub j: usize,
    /// Where it is from the first, m.
    pub apart_m: [f64; 2],
}

/// All modules up to three cells apart whose circles of tails meet.
#[must_use]
pub fn pairs(modboat: &Modboat, cells: &[[i32; 2]]) -> Vec<Pair> {
    let reach_m = 2.0 * modboat.tail_length_m + modboat.tail_width_m;
    let mut pairs = Vec::new();
    for (j, b) in cells.iter().enumerate() {
        for (i, a) in cells[..j].iter().enumerate() {
            let [right, up] = [b[0] - a[0], b[1] - a[1]];
            let apart_m = [modboat.pitch_m * f64::from(right), modboat.pitch_m * f64::from(up)];
            if right.abs() <= 3 && up.abs() <= 3 && apart_m[0].hypot(apart_m[1]) <= reach_m {
                pairs.push(Pair { i, j, apart_m });
            }
        }
    }
    pairs
}

/// The least clearance of a pair in one phase, m; or where (share) it first overlaps, and by how much (m).
fn least_m(modboat: &Modboat, apart_m: [f64; 2], i: TailMotion, j: TailMotion) -> Result<f64, (f64, f64)> {
    let tip_m = modboat.tail_length_m * i.speed().max(j.speed());
    let samples = (tip_m / STEP_M).ceil().max(1.0) as usize;
    let (mut least, mut k) = (f64::INFINITY, 0);
    while k <= samples {
        let share = k as f64 / samples as f64;
        let distance_m = geometry::between_tails_m(modboat.tail_length_m, apart_m, i.at(share), j.at(share));
        let clearance_m = distance_m - modboat.tail_width_m;
        if clearance_m < 0.0 || clearance_m.is_nan() {
            return Err((share, clearance_m));
        }
        least = least.min(clearance_m);
        // Each tail comes nearer by at most a step a sample: what cannot fall below the least is passed over.
        let idle = (clearance_m - least) / (2.0 * STEP_M);
        k += (idle as usize).max(1);
    }
    Ok(least)
}

/// Everything the answer promises. The least clearance met, m, if any two tails can meet.
///
/// # Errors
/// The first broken promise, with module numbers (from 1), time and figures.
pub fn check(modboat: &Modboat, request: &Request, answer: &Answer) -> Result<Option<f64>, String> {
    let modules = request.cells.len();
    let other = |length: Option<usize>| length.is_some_and(|length| length != modules);
    if answer.cycle.len() != modules
        || other(answer.transition.as_ref().map(Vec::len))
        || other(answer.via_rad.as_ref().map(Vec::len))
    {
        return Err(format!("{modules} modules asked, {} answered", answer.cycle.len()));
    }
    match answer.outcome.as_str() {
        "held" => check_held(request, answer)?,
        "planned" => check_amplitudes(modboat, answer)?,
        "repeated" => {
            check_amplitudes(modboat, answer)?;
            check_repeated(request, answer)?;
        }
        other => return Err(format!("outcome {other:?} is none")),
    }
    check_turns(modboat, request, answer)?;
    check_figures(modboat, request, answer)?;
    check_tails(modboat, request, answer)
}

/// Whether the tails stay clear when the modules in `missing` (from 0) rest where the turns begin and all others carry the
/// answer out.
///
/// # Errors
/// The first overlap, or that the tail angles are unknown.
pub fn check_without(
    modboat: &Modboat,
    request: &Request,
    answer: &Answer,
    missing: &[usize],
) -> Result<(), String> {
    let tails = request.tail_rad.as_ref().ok_or("tail angles unknown")?;
    for pair in pairs(modboat, &request.cells) {
        let steps = answer.steps();
        for phase in 0..=steps.len() {
            let motion = |k: usize| match steps.get(phase) {
                _ if missing.contains(&k) => TailMotion::Rest(tails[k]),
                Some(turns) => TailMotion::Turn { from: turns[k][0], to: turns[k][1] },
                None => TailMotion::Swing { centerline: answer.cycle[k][0], amplitude: answer.cycle[k][1] },
            };
            least_m(modboat, pair.apart_m, motion(pair.i), motion(pair.j)).map_err(|(_, clearance_m)| {
                format!("modules {} and {}: {:.3} mm", pair.i + 1, pair.j + 1, clearance_m * 1e3)
            })?;
        }
    }
    Ok(())
}

fn check_held(request: &Request, answer: &Answer) -> Result<(), String> {
    for (k, &[centerline, amplitude]) in answer.cycle.iter().enumerate() {
        if amplitude != 0.0 {
            return Err(format!("held, but module {} swings by {amplitude} rad", k + 1));
        }
        if let Some(tails) = &request.tail_rad
            && !same_angle(centerline, tails[k])
        {
            return Err(format!(
                "held, but module {} is at {} rad and would be at {centerline} rad",
                k + 1,
                tails[k]
            ));
        }
    }
    match &answer.transition {
        Some(_) => Err("held, but with a transition".to_owned()),
        None => Ok(()),
    }
}

fn check_amplitudes(modboat: &Modboat, answer: &Answer) -> Result<(), String> {
    let range = modboat.amplitude_min_rad - ROUNDING..=modboat.amplitude_max_rad + ROUNDING;
    for (k, &[centerline, amplitude]) in answer.cycle.iter().enumerate() {
        let fits = amplitude == 0.0 || range.contains(&amplitude.abs());
        if !fits || !centerline.is_finite() {
            return Err(format!("module {}: ({centerline}, {amplitude}) rad is out of range", k + 1));
        }
        let peak_rad_s = TAU / modboat.period_s * amplitude.abs();
        if peak_rad_s > modboat.tail_speed_max_rad_s + ROUNDING {
            return Err(format!("module {}: swings at {peak_rad_s} rad/s", k + 1));
        }
    }
    Ok(())
}

fn check_repeated(request: &Request, answer: &Answer) -> Result<(), String> {
    let before = request.previous.as_ref().ok_or("repeated, but nothing was before")?;
    let same = |(a, b): (&[f64; 2], &[f64; 2])| same_angle(a[0], b[0]) && (a[1] - b[1]).abs() < ANGLE_RAD;
    if answer.cycle.iter().zip(before).all(same) { Ok(()) } else { Err("not the cycle before".to_owned()) }
}

/// Where turns begin and end, and how fast they are.
fn check_turns(modboat: &Modboat, request: &Request, answer: &Answer) -> Result<(), String> {
    let Some(tails) = &request.tail_rad else {
        return match &answer.transition {
            Some(_) => Err("a transition with tail angles unknown".to_owned()),
            None => Ok(()),
        };
    };
    for (k, (&tail, &[centerline, amplitude])) in tails.iter().zip(&answer.cycle).enumerate() {
        let id = k + 1;
        let [from, to] = answer.transition.as_ref().map_or([tail, tail], |turns| turns[k]);
        if (from - tail).abs() > ROUNDING {
            return Err(format!("module {id}: turns from {from} rad, but is at {tail} rad"));
        }
        let start = centerline + amplitude;
        if !same_angle(to, start) {
            return Err(format!("module {id}: comes to {to} rad, but its cycle starts at {start} rad"));
        }
    }
    check_speeds(modboat, answer)
}

/// No tail is faster than it can be, in any step. Where only the whole time is known, the steps share it by their longest
/// turns.
fn check_speeds(modboat: &Modboat, answer: &Answer) -> Result<(), String> {
    let steps = answer.steps();
    let longest =
        |turns: &Vec<[f64; 2]>| turns.iter().map(|[from, to]| (to - from).abs()).fold(0.0, f64::max);
    let whole_rad: f64 = steps.iter().map(longest).sum();
    for turns in &steps {
        let length_s = match answer.turning_s {
            Some(whole_s) if whole_rad > 0.0 => whole_s * longest(turns) / whole_rad,
            _ => modboat.transition_s,
        };
        for (k, [from, to]) in turns.iter().enumerate() {
            let turn_rad = (to - from).abs();
            let rad_s = if turn_rad > 0.0 { turn_rad / length_s } else { turn_rad };
            if rad_s > modboat.tail_speed_max_rad_s + SPEED_RAD_S || rad_s.is_nan() {
                return Err(format!("module {}: turns at {rad_s} rad/s", k + 1));
            }
        }
    }
    Ok(())
}

/// Wrench, error and travel.
fn check_figures(modboat: &Modboat, request: &Request, answer: &Answer) -> Result<(), String> {
    let mut wrench = [0.0; 3];
    for (&[centerline, amplitude], [x, y]) in answer.cycle.iter().zip(modboat.positions_m(&request.cells)) {
        if amplitude == 0.0 {
            continue;
        }
        let f = modboat.thrust_n(amplitude);
        let [cos, sin] = [centerline.cos(), centerline.sin()];
        // F = (−F·cos φ₀, −F·sin φ₀, −F·sin φ₀·x + F·cos φ₀·y)                                     (7)
        let part = [-f * cos, -f * sin, -f * (sin * x - cos * y)];
        wrench = [wrench[0] + part[0], wrench[1] + part[1], wrench[2] + part[2]];
    }
    let apart = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let differs = |said: f64, is: f64| said.is_nan() || (said - is).abs() > ROUNDING * is.abs().max(1.0);
    if apart(answer.wrench, wrench).iter().any(|&d| differs(d, 0.0)) {
        return Err(format!("wrench {:?} said, {wrench:?} by (7)", answer.wrench));
    }
    let (missed, asked) = (modboat.weighted(apart(request.demand, wrench)), modboat.weighted(request.demand));
    let error = if asked > 0.0 { missed / asked } else { missed };
    if differs(answer.error, error) {
        return Err(format!("error {} said, {error} found", answer.error));
    }
    let travel_rad: f64 = answer.steps().iter().flatten().map(|[from, to]| (to - from).abs()).sum();
    // Turns too small to be made need not be counted.
    if answer.travel_rad.is_nan() || (answer.travel_rad - travel_rad).abs() > ANGLE_RAD {
        return Err(format!("travel {} rad said, {travel_rad} rad found", answer.travel_rad));
    }
    Ok(())
}

/// Overlaps, the clearance said, and loss tolerance.
fn check_tails(modboat: &Modboat, request: &Request, answer: &Answer) -> Result<Option<f64>, String> {
    let held = answer.outcome == "held";
    let swing = |k: usize| {
        let [centerline, amplitude] = answer.cycle[k];
        TailMotion::Swing { centerline, amplitude }
    };
    let steps = answer.steps();
    if answer.loss_tolerant && request.tail_rad.is_none() {
        return Err("loss tolerant, with tail angles unknown".to_owned());
    }
    let mut least: Option<f64> = None;
    for pair in pairs(modboat, &request.cells) {
        let (i, j) = (pair.i, pair.j);
        let look = |what: &str, length_s: f64, a: TailMotion, b: TailMotion| {
            least_m(modboat, pair.apart_m, a, b).map_err(|(share, clearance_m)| {
                let (t_s, mm) = (share * length_s, clearance_m * 1e3);
                format!(
                    "modules {} and {}: {mm:.3} mm at {t_s:.4} s of the {what}, at {:.4} and {:.4} rad",
                    i + 1,
                    j + 1,
                    a.at(share),
                    b.at(share)
                )
            })
        };
        let turn =
            |k: usize, step: usize| TailMotion::Turn { from: steps[step][k][0], to: steps[step][k][1] };
        let turns = (0..steps.len())
            .map(|step| (step, "transition", modboat.transition_s, turn(i, step), turn(j, step)));
        let swim = (steps.len(), "swim", modboat.period_s, swing(i), swing(j));
        for (phase, what, length_s, a, b) in turns.chain([swim]) {
            match look(what, length_s, a, b) {
                Ok(clearance_m) => least = Some(least.map_or(clearance_m, |least| least.min(clearance_m))),
                // Tails that touched before they were asked about may be told to stay as they are.
                Err(overlap) if held && !answer.loss_tolerant => {
                    let touching = answer.clearance_m.is_some_and(|clearance_m| clearance_m <= STEP_M);
                    return if touching { Ok(answer.clearance_m) } else { Err(overlap) };
                }
                Err(overlap) => return Err(overlap),
            }
            // A module that missed all of it rests where it was; one that missed the second step alone rests where the first ended.
            let between = answer.via_rad.as_ref().filter(|_| phase > 0);
            let rests = [request.tail_rad.as_ref(), between].into_iter().flatten();
            for tails in rests.filter(|_| answer.loss_tolerant) {
                let alone = format!("{what}, which one of them missed");
                look(&alone, length_s, a, TailMotion::Rest(tails[j]))?;
                look(&alone, length_s, TailMotion::Rest(tails[i]), b)?;
            }
        }
    }
    match (answer.clearance_m, least) {
        (None, None) => Ok(None),
        // A sample lies at most half a step of both tips away from the nearest pose.
        (Some(said), Some(found)) if said <= found + 2e-5 && said >= found - STEP_M - 2e-5 => Ok(least),
        (said, found) => Err(format!("clearance {said:?} m said, {found:?} m found")),
    }
}

/// Whether two angles are the same, a number of turns aside.
fn same_angle(a: f64, b: f64) -> bool {
    let turns = (a - b) / TAU;
    (turns - turns.round()).abs() * TAU <= ANGLE_RAD
}

#[cfg(test)]
mod tests;
