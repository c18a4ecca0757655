//! The velocity that keeps a structure inside the edge of the water ([`Bounds`]).
//!
//! The edge is a simple polygon in the world. The footprint of a module is a disc of radius ρ, the greater of its body's half diagonal
//! and its tail's reach; that of a structure is the union of its modules' discs, at every heading from the present one to the one
//! that is wanted. A disc centred at c has the room
//!
//! ```text
//! d = ‖c − p‖ − ρ − margin       p: the nearest point of an edge; inside
//! d = −‖c − p‖ − ρ − margin      p: the nearest point of all edges; outside                    (b1)
//! ```
//!
//! and may move towards p, along n, no faster than it can be stopped before it: with delay h until a demand acts, and
//! deceleration a,
//!
//! ```text
//! d = v h + v²/2a   ⇒   v_max(d) = a (√(h² + 2d/a) − h)                                       (b2)
//! v_max(d) = d / h for d < 0: it comes back                                                   (b3)
//! ```
//!
//! The velocity asked for is moved to the nearest one that has n·v ≤ v_max for the worst disc of each edge, (b4). One that is too fast
//! already brakes first: the velocity it has is moved instead, so that no thrust goes into a change along the edge. A turn for which
//! there is no room waits until there is.
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | d | m | room left: at the margin it is zero |
//! | n | – | unit vector from the disc to the edge (from the edge outwards, where the centre is outside) |
//! | a | m/s² | [`BRAKING_SHARE`] of what all modules together give the structure with its added mass |
//! | h | s | from the pose to the end of the cycle that is decided on, and one interval more |
//!
//! Assumptions: a is the same in all directions and at all headings; a current shows as a velocity. Limits: where
//! no velocity fits all edges, the one that is least beyond any is taken.

use quantity::bounds::Bounds;
use quantity::vector::{dot, length};
use quantity::wrap_rad;

use super::control::{ControlConfig, Target};
use super::parameters::Parameters;
use super::structure::Structure;

#[cfg(test)]
mod tests;

/// Share of the greatest deceleration that (b2) counts on. *Assumed*: collisions shrink the envelope, and the loop needs some in hand.
pub const BRAKING_SHARE: f64 = 0.5;
/// Angle between two headings at which a turn's footprint is looked at, rad. *Assumed*: a module of a structure of 24 by 24 moves by
/// half of its radius meanwhile.
const TURN_STEP_RAD: f64 = 0.05;

/// Where the structure is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Centre of mass in the world, m.
    pub position_m: [f64; 2],
    /// Heading Θ, rad.
    pub heading_rad: f64,
}

/// A target that stays inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Governed {
    /// What may be asked for.
    pub target: Target,
    /// Whether that is less than what was wanted.
    pub is_limited: bool,
    /// Least room of any module at the present heading, m; negative within the margin of the edge.
    pub room_m: f64,
}

/// Keeps a structure inside its bounds.
#[derive(Clone, Debug)]
pub struct Governor {
    bounds: Bounds,
    positions_m: Vec<[f64; 2]>,
    /// ρ, m.
    radius_m: f64,
    /// a, m/s².
    braking_m_s2: f64,
    limits: Vec<Limit>,
}

/// n·v ≤ v_max.
#[derive(Clone, Copy, Debug)]
struct Limit {
    normal: [f64; 2],
    room_m: f64,
    most_m_s: f64,
}

impl Limit {
    fn excess(&self, velocity: [f64; 2]) -> f64 {
        dot(self.normal, velocity) - self.most_m_s
    }
}

/// Radius ρ of a module's footprint about its centre, m.
#[must_use]
pub fn footprint_m(parameters: &Parameters) -> f64 {
    let tail_m = parameters.tail_length_m + 0.5 * parameters.tail_width_m;
    tail_m.max(parameters.pitch_m * std::f64::consts::FRAC_1_SQRT_2)
}

/// Centres of the modules in the world, m, of a structure at `place` with module centres `positions_m` in S.
pub fn centres_m(positions_m: &[[f64; 2]], place: Place) -> impl Iterator<Item = [f64; 2]> + '_ {
    let (sin, cos) = place.heading_rad.sin_cos();
    let [x, y] = place.position_m;
    // x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ)
    positions_m.iter().map(move |&[sway, surge]| [x + sway * sin + surge * cos, y - sway * cos + surge * sin])
}

impl Governor {
    /// For one structure.
    #[must_use]
    pub fn new(
        bounds: &Bounds,
        structure: &Structure,
        parameters: &Parameters,
        control: &ControlConfig,
    ) -> Self {
        let thrust_n = structure.len() as f64
            * control.thrust_share
            * parameters.thrust_n(parameters.amplitude_max_rad)
            * parameters.period_s
            / (parameters.period_s + parameters.transition_s);
        let mass_kg = control.added_mass_factor.max(1.0) * structure.mass_kg(parameters);
        Self {
            bounds: bounds.clone(),
            positions_m: structure.positions_m(parameters.pitch_m),
            radius_m: footprint_m(parameters),
            braking_m_s2: BRAKING_SHARE * thrust_n / mass_kg,
            limits: Vec::new(),
        }
    }

    /// The target nearest to `wanted` that keeps the structure inside, which is at `place` and moves at `velocity_m_s` (world);
    /// `delay_s` is h of (b2).
    pub fn govern(
        &mut self,
        wanted: &Target,
        place: Place,
        velocity_m_s: [f64; 2],
        delay_s: f64,
    ) -> Governed {
        self.limits.clear();
        self.limits.resize(self.bounds.edge_m.len(), NO_LIMIT);
        self.take(place, delay_s);
        let room_m = self.limits.iter().fold(f64::INFINITY, |least, limit| least.min(limit.room_m));
        let mut target = *wanted;
        let turn_rad = wrap_rad(wanted.heading_rad - place.heading_rad);
        let steps = (turn_rad.abs() / TURN_STEP_RAD).ceil() as usize;
        for step in 1..=steps {
            let heading_rad = place.heading_rad + turn_rad * step as f64 / steps as f64;
            self.take(Place { heading_rad, ..place }, delay_s);
        }
        let turn_room_m = self.limits.iter().fold(f64::INFINITY, |least, limit| least.min(limit.room_m));
        let waits = turn_room_m < 0.0 && turn_room_m < room_m;
        if waits {
            target.heading_rad = place.heading_rad;
        }
        let brakes =
            self.limits.iter().any(|limit| dot(limit.normal, velocity_m_s) > limit.most_m_s.max(0.0));
        let is_limited = waits || brakes || self.excess(wanted.velocity_m_s) > 0.0;
        target.velocity_m_s = self.nearest(if brakes { velocity_m_s } else { wanted.velocity_m_s });
        Governed { target, is_limited, room_m }
    }

    /// Takes in the footprint at `place`: the worst disc of each edge stays in `limits`.
    fn take(&mut self, place: Place, delay_s: f64) {
        let Self { bounds, positions_m, radius_m, braking_m_s2, limits } = self;
        for centre_m in centres_m(positions_m, place) {
            bounds.nearest(centre_m, |edge, normal, distance_m| {
                // (b1)
                let room_m = distance_m - *radius_m - bounds.margin_m;
                if room_m < limits[edge].room_m {
                    limits[edge] =
                        Limit { normal, room_m, most_m_s: most_m_s(room_m, *braking_m_s2, delay_s) };
                }
            });
        }
    }

    /// How far a velocity is beyond the limits at most, m/s.
    fn excess(&self, velocity: [f64; 2]) -> f64 {
        self.limits.iter().map(|limit| limit.excess(velocity)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The velocity nearest to `wanted` that is within all limits: itself, its projection on one, or a corner of two (b4).
    fn nearest(&self, wanted: [f64; 2]) -> [f64; 2] {
        if self.excess(wanted) <= 0.0 {
            return wanted;
        }
        let mut best = (f64::INFINITY, f64::INFINITY, [0.0; 2]);
        let mut consider = |velocity: [f64; 2]| {
            let beyond = self.excess(velocity).max(1e-12);
            let away = length([0, 1].map(|k| velocity[k] - wanted[k]));
            if (beyond, away) < (best.0, best.1) {
                best = (beyond, away, velocity);
            }
        };
        consider([0.0; 2]);
        for (index, limit) in self.limits.iter().enumerate().filter(|(_, limit)| limit.room_m.is_finite()) {
            let along = limit.excess(wanted);
            consider([0, 1].map(|k| wanted[k] - along * limit.normal[k]));
            for other in self.limits[..index].iter().filter(|other| other.room_m.is_finite()) {
                let determinant = limit.normal[0] * other.normal[1] - limit.normal[1] * other.normal[0];
                if determinant.abs() > 1e-9 {
                    consider([
                        (limit.most_m_s * other.normal[1] - limit.normal[1] * other.most_m_s) / determinant,
                        (limit.normal[0] * other.most_m_s - limit.most_m_s * other.normal[0]) / determinant,
                    ]);
                }
            }
        }
        best.2
    }
}

const NO_LIMIT: Limit = Limit { normal: [0.0; 2], room_m: f64::INFINITY, most_m_s: f64::INFINITY };

/// (b2) and (b3).
fn most_m_s(room_m: f64, braking_m_s2: f64, delay_s: f64) -> f64 {
    if room_m < 0.0 {
        return room_m / delay_s;
    }
    braking_m_s2 * ((delay_s * delay_s + 2.0 * room_m / braking_m_s2).sqrt() - delay_s)
}
