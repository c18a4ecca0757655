//! An experiment that shows the constants: legs of velocity and heading, one after the other the most informative of many.
//!
//! Each leg is tried in a simulation of the mean motion, by what is believed: every period a force is decided on that halves the error of
//! the velocity in two periods and holds the drag, and a torque that turns the structure, both within what the tails can give. Where it goes, the balance of forces has for each of the constants p = (M_x, M_y, I, D_x, D_y, C_R), in logarithms, the
//! regressors
//!
//! ```text
//! sway:   ( M_x·v̇_x, −M_y·Ω·v_y, 0, D_x·v_x|v_x|, 0, 0 ) / σ_F
//! surge:  ( M_x·Ω·v_x, M_y·v̇_y, 0, 0, D_y·v_y|v_y|, 0 ) / σ_F                                          (i15)
//! yaw:    ( −M_x·v_x·v_y, M_y·v_x·v_y, I·Ω̇, 0, 0, C_R·Ω|Ω| ) / σ_τ
//! ```
//!
//! and its information is F = Σ (rows)ᵀ(rows). The leg with the greatest gain of ln det F a second is taken (D-optimal, greedy), and
//! the next one tried from where it ends. Starting and stopping shows masses, going on shows drags, along each axis and both ways.
//!
//! A leg counts only where the whole structure keeps off the edge of the water by [`SAFETY_M`] beyond its margin, with the way to stop
//! behind its end. In a run the governor keeps it off besides, and plans are free of contacts as always.
//!
//! Assumptions: σ_F a twentieth of the greatest thrust, σ_τ that on one pitch. Limits: greedy; which modules push for a wrench is the
//! planner's choice, and so is what is shown of single modules.

use modboat::bounds::{Place, centres_m, footprint_m};
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use nalgebra::{SMatrix, SVector};
use quantity::bounds::Bounds;
use quantity::wrap_rad;

/// Share of the way that is kept beyond the margin, m. *Assumed*: boats that push half again as much.
pub const SAFETY_M: f64 = 0.05;
/// Step of the simulation, s.
const STEP_S: f64 = 0.25;
/// Lengths of legs that are tried, s.
const LENGTHS_S: [f64; 3] = [6.0, 9.0, 15.0];
/// Shares of the greatest speed that are tried.
const SPEEDS: [f64; 3] = [0.0, 0.45, 0.8];
/// Turns that are tried, rad.
const TURNS_RAD: [f64; 5] = [0.0, 0.6, -0.6, 1.5, -1.5];
/// Directions that are tried, a turn of them.
const COURSES: usize = 8;
/// Share of the greatest thrust that is counted on. *Assumed*: collisions shrink the envelope.
const THRUST_SHARE: f64 = 0.6;
/// Gains of velocity, 1/s, heading, 1/s², and yaw rate, 1/s. *Assumed*: near those of the controllers.
const GAINS: [f64; 3] = [0.25, 0.15, 0.5];
/// Water that moves along, as a share of the dry mass and inertia. *Assumed*.
const ADDED: f64 = 0.5;

/// One leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignedLeg {
    /// How long, s.
    pub duration_s: f64,
    /// East and north, m/s.
    pub velocity_m_s: [f64; 2],
    /// Heading, rad.
    pub heading_rad: f64,
}

/// What an experiment is designed for.
#[derive(Clone, Copy, Debug)]
pub struct Site<'a> {
    /// Which modules are docked where.
    pub structure: &'a Structure,
    /// What is believed of them.
    pub belief: &'a Parameters,
    /// The edge of the water.
    pub bounds: &'a Bounds,
    /// Where the structure is at first, at rest.
    pub start: Place,
    /// How long all legs are together, s.
    pub duration_s: f64,
}

type Information = SMatrix<f64, 6, 6>;

#[derive(Clone, Copy)]
struct Motion {
    place: Place,
    /// Sway and surge, m/s.
    velocity: [f64; 2],
    yaw_rate: f64,
}

struct Water {
    mass: [f64; 2],
    inertia: f64,
    drag: f64,
    yaw_drag: f64,
    thrust_n: f64,
    torque_nm: f64,
    force_error: f64,
    torque_error: f64,
    positions_m: Vec<[f64; 2]>,
    radius_m: f64,
    speed_m_s: f64,
    period_s: f64,
}

impl Water {
    fn new(site: &Site<'_>) -> Self {
        let (structure, belief) = (site.structure, site.belief);
        let modules = structure.len() as f64;
        let thrust_n = THRUST_SHARE * modules * belief.thrust_n(belief.amplitude_max_rad);
        let arm_m =
            structure.positions_m(belief.pitch_m).iter().map(|[x, y]| x.hypot(*y)).sum::<f64>() / modules;
        let drag = modules * belief.drag_n_s2_m2;
        Self {
            mass: [(1.0 + ADDED) * structure.mass_kg(belief); 2],
            inertia: (1.0 + ADDED) * structure.inertia_kg_m2(belief),
            drag,
            yaw_drag: structure.yaw_drag_n_m_s2(belief),
            thrust_n,
            torque_nm: 0.5 * thrust_n * arm_m,
            force_error: 0.05 * thrust_n,
            torque_error: 0.05 * thrust_n * belief.pitch_m,
            positions_m: structure.positions_m(belief.pitch_m),
            radius_m: footprint_m(belief),
            speed_m_s: (thrust_n / drag.max(1e-9)).sqrt(),
            period_s: belief.period_s,
        }
    }

    /// Moves on by a leg; the information of it, and the least room beyond the margin, m.
    fn follow(&self, motion: &mut Motion, leg: &DesignedLeg, bounds: &Bounds) -> (Information, f64) {
        let (mut information, mut room_m) = (Information::zeros(), f64::INFINITY);
        let per_decision = (self.period_s / STEP_S).round().max(1.0) as usize;
        let mut force = [0.0; 3];
        for step in 0..(leg.duration_s / STEP_S).round() as usize {
            let (sin, cos) = motion.place.heading_rad.sin_cos();
            let [vx, vy] = motion.velocity;
            let world = [sin * vx + cos * vy, -cos * vx + sin * vy];
            if step % per_decision == 0 {
                force = self.demand(motion, leg);
            }
            let omega = motion.yaw_rate;
            let [mx, my] = self.mass;
            let ax = (force[0] - self.drag * vx * vx.abs() + omega * my * vy) / mx;
            let ay = (force[1] - self.drag * vy * vy.abs() - omega * mx * vx) / my;
            let turning = (force[2] - self.yaw_drag * omega * omega.abs()) / self.inertia;
            // (i15)
            let rows = [
                ([mx * ax, -my * omega * vy, 0.0, self.drag * vx * vx.abs(), 0.0, 0.0], self.force_error),
                ([mx * omega * vx, my * ay, 0.0, 0.0, self.drag * vy * vy.abs(), 0.0], self.force_error),
                (
                    [
                        -mx * vx * vy,
                        my * vx * vy,
                        self.inertia * turning,
                        0.0,
                        0.0,
                        self.yaw_drag * omega * omega.abs(),
                    ],
                    self.torque_error,
                ),
            ];
            for (row, error) in rows {
                let row = SVector::from(row) / error;
                information += row * row.transpose() * STEP_S;
            }
            motion.velocity = [vx + ax * STEP_S, vy + ay * STEP_S];
            motion.yaw_rate += turning * STEP_S;
            motion.place.heading_rad += motion.yaw_rate * STEP_S;
            motion.place.position_m = [0, 1].map(|axis| motion.place.position_m[axis] + world[axis] * STEP_S);
            // The way to a stop: half the speed each period.
            room_m = room_m.min(self.room_m(motion.place, world, 2.0 * self.period_s, bounds));
            if room_m < 0.0 {
                break;
            }
        }
        (information, room_m)
    }

    /// The wrench that is asked for.
    fn demand(&self, motion: &Motion, leg: &DesignedLeg) -> [f64; 3] {
        let (sin, cos) = motion.place.heading_rad.sin_cos();
        let [east, north] = leg.velocity_m_s;
        let wanted = [sin * east - cos * north, cos * east + sin * north];
        let push = [0, 1].map(|axis| {
            let error = wanted[axis] - motion.velocity[axis];
            self.drag * wanted[axis] * wanted[axis].abs() + self.mass[axis] * GAINS[0] * error
        });
        let scale = (self.thrust_n / push[0].hypot(push[1]).max(1e-12)).min(1.0);
        let (off_rad, omega) = (wrap_rad(leg.heading_rad - motion.place.heading_rad), motion.yaw_rate);
        let turn =
            self.inertia * (GAINS[1] * off_rad - GAINS[2] * omega) + self.yaw_drag * omega * omega.abs();
        [scale * push[0], scale * push[1], turn.clamp(-self.torque_nm, self.torque_nm)]
    }

    /// Least room of any module, now and where the structure comes to rest, m.
    fn room_m(&self, place: Place, world: [f64; 2], stop_s: f64, bounds: &Bounds) -> f64 {
        let rests = [0, 1].map(|axis| place.position_m[axis] + world[axis] * stop_s);
        let mut room_m = f64::INFINITY;
        for at in [place, Place { position_m: rests, ..place }] {
            for centre in centres_m(&self.positions_m, at) {
                if !bounds.contains(centre) {
                    return f64::NEG_INFINITY;
                }
                bounds.nearest(centre, |_, _, distance_m| {
                    room_m = room_m.min(distance_m - self.radius_m - bounds.margin_m);
                });
            }
        }
        room_m
    }
}

fn log_det(information: &Information) -> f64 {
    // A little of everything is known before: 100 % of each constant.
    let known = information + Information::identity();
    known.cholesky().map_or(f64::NEG_INFINITY, |factor| 2.0 * factor.l().diagonal().map(f64::ln).sum())
}

/// The legs of an experiment; none where the water has no room for any.
#[must_use]
pub fn design(site: &Site<'_>) -> Vec<DesignedLeg> {
    let water = Water::new(site);
    let mut motion = Motion { place: site.start, velocity: [0.0; 2], yaw_rate: 0.0 };
    let mut information = Information::zeros();
    let mut heading_rad = site.start.heading_rad;
    let mut legs: Vec<DesignedLeg> = Vec::new();
    let mut left_s = site.duration_s;
    while left_s > STEP_S {
        let mut best: Option<([f64; 2], DesignedLeg, Motion, Information)> = None;
        for leg in candidates(&water, heading_rad, left_s) {
            let mut tried = motion;
            let (more, room_m) = water.follow(&mut tried, &leg, site.bounds);
            let sum = information + more;
            let gain = (log_det(&sum) - log_det(&information)) / leg.duration_s;
            // Where the last leg leaves no way to keep off by SAFETY_M, the one that keeps off the most.
            let merit = [room_m.min(SAFETY_M), gain];
            if room_m > 0.0 && best.as_ref().is_none_or(|(most, ..)| merit > *most) {
                best = Some((merit, leg, tried, sum));
            }
        }
        let Some((_, leg, moved, sum)) = best else { break };
        (motion, information, heading_rad) = (moved, sum, leg.heading_rad);
        left_s -= leg.duration_s;
        legs.push(leg);
    }
    legs
}

fn candidates(water: &Water, heading_rad: f64, left_s: f64) -> Vec<DesignedLeg> {
    let mut list = Vec::new();
    for turn_rad in TURNS_RAD {
        let heading_rad = heading_rad + turn_rad;
        for speed in SPEEDS {
            let courses = if speed == 0.0 { 1 } else { COURSES };
            for course in 0..courses {
                let angle_rad = heading_rad + std::f64::consts::TAU * course as f64 / COURSES as f64;
                let speed_m_s = speed * water.speed_m_s;
                // Five decimals: a scenario file has no more.
                let velocity_m_s =
                    [angle_rad.cos(), angle_rad.sin()].map(|part| (part * speed_m_s * 1e5).round() / 1e5);
                for duration_s in LENGTHS_S {
                    // What would be left is too short for a leg of its own.
                    let duration_s = if left_s - duration_s < LENGTHS_S[0] { left_s } else { duration_s };
                    list.push(DesignedLeg { duration_s, velocity_m_s, heading_rad });
                }
            }
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn tank(half_m: [f64; 2]) -> Bounds {
        let [x, y] = half_m;
        Bounds { edge_m: vec![[-x, -y], [x, -y], [x, y], [-x, y]], margin_m: 0.1 }
    }

    fn legs(word: &str, bounds: &Bounds) -> (Vec<DesignedLeg>, Information) {
        let structure = Structure::from_word(word).expect("a size");
        let belief = Parameters::default();
        let start = Place { position_m: [0.0; 2], heading_rad: FRAC_PI_2 };
        let site = Site { structure: &structure, belief: &belief, bounds, start, duration_s: 180.0 };
        let legs = design(&site);
        let water = Water::new(&site);
        let mut motion = Motion { place: start, velocity: [0.0; 2], yaw_rate: 0.0 };
        let mut sum = Information::zeros();
        for leg in &legs {
            let (more, room_m) = water.follow(&mut motion, leg, bounds);
            assert!(room_m > 0.0, "{word}: {room_m} m");
            sum += more;
        }
        (legs, sum)
    }

    #[test]
    fn an_experiment_fills_its_time_stays_inside_and_shows_every_constant() {
        for word in ["3x1", "3x3"] {
            let (legs, information) = legs(word, &tank([1.5, 1.25]));
            let total: f64 = legs.iter().map(|leg| leg.duration_s).sum();
            assert!(
                (total - 180.0).abs() < 1e-9 && legs.len() >= 10,
                "{word}: {} legs, {total} s",
                legs.len()
            );
            // Every constant alone and all together.
            let inverse = information.try_inverse().expect("every constant is shown");
            for index in 0..6 {
                assert!(inverse[(index, index)].sqrt() < 0.1, "{word}: constant {index}: {inverse}");
            }
        }
    }

    #[test]
    fn it_shows_more_than_a_leg_to_and_fro_and_knows_when_there_is_no_room() {
        let bounds = tank([1.5, 1.25]);
        let (_, best) = legs("3x1", &bounds);
        let structure = Structure::from_word("3x1").expect("a size");
        let belief = Parameters::default();
        let start = Place { position_m: [0.0; 2], heading_rad: FRAC_PI_2 };
        let site = Site { structure: &structure, belief: &belief, bounds: &bounds, start, duration_s: 180.0 };
        let water = Water::new(&site);
        let mut motion = Motion { place: start, velocity: [0.0; 2], yaw_rate: 0.0 };
        let mut plain = Information::zeros();
        for leg in 0..12 {
            let velocity_m_s = if leg % 2 == 0 { [0.04, 0.0] } else { [-0.04, 0.0] };
            let leg = DesignedLeg { duration_s: 15.0, velocity_m_s, heading_rad: FRAC_PI_2 };
            plain += water.follow(&mut motion, &leg, &bounds).0;
        }
        assert!(log_det(&best) > log_det(&plain) + 10.0, "{} {}", log_det(&best), log_det(&plain));
        let (none, _) = legs("3x1", &tank([0.4, 0.2]));
        assert!(none.is_empty(), "{none:?}");
    }
}
