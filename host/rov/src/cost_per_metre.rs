//! Cost per metre by direction, and the straight-line bound that follows from it.
//!
//! ```text
//! r(d) = min over v of (P(v·d) + λ)/v          best speed
//! r(d) = (P(v·d) + λ)/v                        the paper's constant |velocity|
//! c(a, b) = |b − a|·r(direction from a to b)
//! ```
//!
//! With the best speed c is a norm as long as P is convex in the velocity, so that no detour beats the straight line.
//! With a constant speed it is not: a steep leg at full speed costs so much in heave that a zigzag can be 22 % cheaper,
//! and c itself is no admissible heuristic. The bound used here is admissible for every r:
//!
//! ```text
//! q_k = n_k · min over d of r(d)/(n_k·d)       h(x) = max over k of q_k·x ≤ the cost of every path that leads along x
//! ```
//!
//! since each leg's cost is at least q_k·(its displacement) and displacements add up. It is the support function of the
//! q_k: the greatest norm below c up to the fineness of the directions n_k.
//!
//! Headings: a robot that holds its heading has a cost per metre for every direction; one that may choose takes the cheapest
//! heading for the leg's elevation.

use std::f64::consts::{PI, TAU};

use super::propulsion::Propulsion;

/// Cells of the table of directions in azimuth and in elevation.
const AZIMUTHS: usize = 48;
const ELEVATIONS: usize = 24;
/// Speeds tried between the least and the greatest.
const SPEEDS: usize = 24;
/// Directions n_k of the bound.
const PLANES: usize = 120;
/// Samples of the cost per metre between two nodes of the table, and what the bound leaves for directions between those.
const BETWEEN: usize = 2;
const SAMPLING: f64 = 0.995;

/// Stands for a motion that thrusters do not give, W; infinity would make what lies beside it no number.
const BEYOND_W: f64 = 1e12;

/// Electric power of a robot by direction in its body and speed.
#[derive(Clone, Debug)]
pub struct PowerMap {
    speeds_m_s: Vec<f64>,
    /// [elevation][azimuth][speed], W.
    powers_w: Vec<f64>,
}

impl PowerMap {
    /// Steady level motion in every direction at speeds between the two; equal ones ask for a single speed.
    #[must_use]
    pub fn new(propulsion: &Propulsion, [low, high]: [f64; 2]) -> Self {
        let count = if high > low { SPEEDS } else { 1 };
        let step = if count > 1 { (high / low).ln() / (count - 1) as f64 } else { 0.0 };
        let speeds_m_s: Vec<f64> = (0..count).map(|n| low * (step * n as f64).exp()).collect();
        let mut powers_w = Vec::with_capacity((ELEVATIONS + 1) * AZIMUTHS * count);
        for elevation in 0..=ELEVATIONS {
            for azimuth in 0..AZIMUTHS {
                let [x, y, z] = unit(azimuth_rad(azimuth as f64), elevation_rad(elevation as f64));
                powers_w.extend(speeds_m_s.iter().map(|&v| {
                    let nu = [v * x, v * y, v * z, 0.0, 0.0, 0.0];
                    propulsion.power_w(&nu, &[0.0; 6]).unwrap_or(BEYOND_W)
                }));
            }
        }
        Self { speeds_m_s, powers_w }
    }

    /// min over v of (P + λ)/v by elevation, from straight up to straight down, J/m: ahead, or over all headings.
    pub(super) fn least_costs_per_metre(&self, lambda_w: f64, along: bool) -> Vec<f64> {
        let least = |ring: &[f64]| ring.iter().copied().fold(f64::INFINITY, f64::min);
        let all = self.costs_per_metre(lambda_w);
        all.chunks(AZIMUTHS).map(|ring| if along { ring[0] } else { least(ring) }).collect()
    }

    /// min over v of (P + λ)/v at every node, J/m.
    fn costs_per_metre(&self, lambda_w: f64) -> Vec<f64> {
        self.powers_w
            .chunks(self.speeds_m_s.len())
            .map(|powers_w| {
                let cost_per_metre = |(&power_w, &speed): (&f64, &f64)| (power_w + lambda_w) / speed;
                powers_w.iter().zip(&self.speeds_m_s).map(cost_per_metre).fold(f64::INFINITY, f64::min)
            })
            .collect()
    }
}

/// Heading of the robot on a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heading {
    /// Always there, rad.
    Held(f64),
    /// Along the leg.
    Along,
    /// Wherever the leg is cheapest.
    Free,
}

/// Cost of a metre by direction in the world, and its bound.
#[derive(Clone, Debug)]
pub struct CostPerMetre {
    /// [elevation][azimuth], a ring of one azimuth where it does not matter; empty where a metre is a metre.
    nodes: Vec<f64>,
    azimuths: usize,
    yaw_rad: f64,
    planes: Vec<[f64; 3]>,
}

impl CostPerMetre {
    /// Length itself: the Euclidean criterion.
    #[must_use]
    pub const fn euclidean() -> Self {
        Self { nodes: Vec::new(), azimuths: 1, yaw_rad: 0.0, planes: Vec::new() }
    }

    /// Energy of the mover and of the waiting robots, which draw λ = `lambda_w`.
    #[must_use]
    pub fn energy(map: &PowerMap, heading: Heading, lambda_w: f64) -> Self {
        let all = map.costs_per_metre(lambda_w);
        let (nodes, azimuths, yaw_rad) = match heading {
            Heading::Held(yaw_rad) => (all, AZIMUTHS, yaw_rad),
            Heading::Along => (all.chunks(AZIMUTHS).map(|ring| ring[0]).collect(), 1, 0.0),
            Heading::Free => {
                let least = |ring: &[f64]| ring.iter().copied().fold(f64::INFINITY, f64::min);
                (all.chunks(AZIMUTHS).map(least).collect(), 1, 0.0)
            }
        };
        let mut cost_per_metre = Self { nodes, azimuths, yaw_rad, planes: Vec::new() };
        cost_per_metre.planes = cost_per_metre.supporting_planes();
        cost_per_metre
    }

    /// Cost of a straight leg along `leg_m`, J (m for the Euclidean criterion).
    #[must_use]
    pub fn cost(&self, leg_m: [f64; 3]) -> f64 {
        let [x, y, z] = leg_m;
        let level = (x * x + y * y).sqrt();
        let length = (x * x + y * y + z * z).sqrt();
        if self.nodes.is_empty() || length == 0.0 {
            return length;
        }
        let up = (z.atan2(level) / PI + 0.5) * ELEVATIONS as f64;
        let low = (up as usize).min(ELEVATIONS - 1);
        let share = up - low as f64;
        let per_metre = if self.azimuths == 1 {
            (1.0 - share) * self.nodes[low] + share * self.nodes[low + 1]
        } else {
            let round = ((y.atan2(x) - self.yaw_rad) / TAU).rem_euclid(1.0) * self.azimuths as f64;
            let left = (round as usize) % self.azimuths;
            let right = (left + 1) % self.azimuths;
            let across = round - round.floor();
            let ring = |elevation: usize| {
                let nodes = &self.nodes[elevation * self.azimuths..];
                (1.0 - across) * nodes[left] + across * nodes[right]
            };
            (1.0 - share) * ring(low) + share * ring(low + 1)
        };
        length * per_metre
    }

    /// Lower bound of every path that leads along `way_m` in the end, J (or m).
    #[must_use]
    pub fn bound(&self, way_m: [f64; 3]) -> f64 {
        if self.nodes.is_empty() {
            return self.cost(way_m);
        }
        // h(x) = max q_k·x
        let along = |q: &[f64; 3]| q[0] * way_m[0] + q[1] * way_m[1] + q[2] * way_m[2];
        self.planes.iter().map(along).fold(0.0, f64::max)
    }

    fn supporting_planes(&self) -> Vec<[f64; 3]> {
        let mut samples = Vec::new();
        let node = |sample: usize| sample as f64 / BETWEEN as f64;
        // Where the azimuth does not matter, the one towards n_k is the one that counts.
        let is_round = self.azimuths == 1;
        let azimuths = if is_round { 1 } else { BETWEEN * AZIMUTHS };
        for elevation in 0..=BETWEEN * ELEVATIONS {
            for azimuth in 0..azimuths {
                // Least costs per metre are at nodes of the table, so samples are taken there, turned as the robot is.
                let d = unit(self.yaw_rad + azimuth_rad(node(azimuth)), elevation_rad(node(elevation)));
                samples.push((d, self.cost(d)));
            }
        }
        (0..PLANES)
            .map(|k| {
                // Evenly on the sphere: the golden spiral.
                let z = 1.0 - (2 * k + 1) as f64 / PLANES as f64;
                let (sin, cos) = (PI * (3.0 - 5.0_f64.sqrt()) * k as f64).sin_cos();
                let level = (1.0 - z * z).sqrt();
                let n = [level * cos, level * sin, z];
                let towards = if is_round { [level, 0.0, z] } else { n };
                // q = n·min r(d)/(n·d)
                let reach = samples
                    .iter()
                    .map(|(d, r)| (towards[0] * d[0] + towards[1] * d[1] + towards[2] * d[2], r))
                    .filter(|(along, _)| *along > 1e-6)
                    .map(|(along, r)| r / along)
                    .fold(f64::INFINITY, f64::min);
                n.map(|component| SAMPLING * reach * component)
            })
            .collect()
    }
}

fn azimuth_rad(node: f64) -> f64 {
    node / AZIMUTHS as f64 * TAU
}

/// From straight up (−π/2: z is down) to straight down.
fn elevation_rad(node: f64) -> f64 {
    (node / ELEVATIONS as f64 - 0.5) * PI
}

fn unit(azimuth_rad: f64, elevation_rad: f64) -> [f64; 3] {
    let (sin, cos) = azimuth_rad.sin_cos();
    let level = elevation_rad.cos();
    [level * cos, level * sin, elevation_rad.sin()]
}

#[cfg(test)]
mod tests;
