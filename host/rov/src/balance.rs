//! Balance of a waiting cluster: thrusts that keep it level (v6), at least electric power: (5) and (16).
//!
//! Every connected component of what rests is a cluster of its own. It is balanced when its thrusters give the wrench
//! that (7) asks for at rest, τ_c = g(level): all six components, so that K and M are balanced and nothing drifts. K and
//! M that no thruster of it can push in are left to its own stability, within the limit of tilt. The power it takes is
//! P_bal of (17).
//!
//! In a current c it rests against the water: ν' = −Rᵀc is its velocity through it, and
//!
//! ```text
//! τ_c = C(ν')ν' + D(ν')ν' + g(level)                                              after (7)
//! ```

use nalgebra::{UnitQuaternion, Vector3, Vector6};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Rules, is_still};
use reconfiguration::vehicle::Vehicle;

use super::allocation::{Allocation, Allocator};
use super::cluster::Cluster;
use super::configuration::{adjacency, clusters};
use super::configuration_matrix::ConfigurationMatrix;
use super::dynamics::coriolis;
use super::power::{PowerLaw, limits_of};

/// Wrenches smaller than this need no balance, N and N·m.
const NOTHING: f64 = 1e-9;

/// Thrusts that keep a resting configuration level, and their power.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Balance {
    /// P_bal, W.
    pub power_w: f64,
    /// Thrusts of every body's thrusters, N, in the order of the bodies.
    pub thrusts_n: Vec<Vec<f64>>,
}

/// Why a configuration cannot wait.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unbalanced {
    /// This tool (index of the body) has no connection left (v4).
    Alone(usize),
    /// Two bodies that no chain of connections joins, where the rules ask for one cluster.
    Apart(usize, usize),
    /// The cluster of this body cannot be balanced (v6): this share of the wrench can.
    OutOfReach {
        /// Index of its first body.
        body: usize,
        /// Share served.
        served: f64,
    },
}

/// Balances bodies at rest in still water. Bodies without thrusters are tools.
///
/// # Errors
/// [`Unbalanced`].
pub fn balance(
    bodies: &[(Pose, &Vehicle)],
    law: &PowerLaw,
    limits_n: (f64, f64),
    rules: &Rules,
) -> Result<Balance, Unbalanced> {
    balance_in([0.0; 3], bodies, law, limits_n, rules)
}

/// [`balance`], in a current, world, m/s.
///
/// # Errors
/// [`Unbalanced`].
pub fn balance_in(
    current_m_s: [f64; 3],
    bodies: &[(Pose, &Vehicle)],
    law: &PowerLaw,
    limits_n: (f64, f64),
    rules: &Rules,
) -> Result<Balance, Unbalanced> {
    let mut thrusts_n: Vec<Vec<f64>> =
        bodies.iter().map(|(_, vehicle)| vec![0.0; vehicle.thrusters.len()]).collect();
    let mut power_w = 0.0;
    let clusters = clusters(&adjacency(bodies));
    for cluster in &clusters {
        let members: Vec<(Pose, &Vehicle)> = cluster.iter().map(|&k| bodies[k]).collect();
        let first = cluster[0];
        if members.iter().all(|(_, vehicle)| vehicle.thrusters.is_empty()) {
            return Err(Unbalanced::Alone(first));
        }
        if rules.one_cluster && first != clusters[0][0] {
            return Err(Unbalanced::Apart(clusters[0][0], first));
        }
        let allocation = match of_cluster(current_m_s, &members, law, limits_n, rules) {
            Some(allocation) if allocation.served >= 1.0 - 1e-9 => allocation,
            other => {
                let served = other.map_or(0.0, |allocation| allocation.served);
                return Err(Unbalanced::OutOfReach { body: first, served });
            }
        };
        power_w += allocation.power_w;
        let mut rest = allocation.thrusts_n.as_slice();
        for &body in cluster {
            let (own, others) = rest.split_at(thrusts_n[body].len());
            thrusts_n[body].copy_from_slice(own);
            rest = others;
        }
    }
    Ok(Balance { power_w, thrusts_n })
}

/// The least power that balances a cluster, W; `None` if it cannot be.
#[must_use]
pub fn power_of_cluster(
    members: &[(Pose, &Vehicle)],
    law: &PowerLaw,
    limits_n: (f64, f64),
    rules: &Rules,
) -> Option<f64> {
    of_cluster([0.0; 3], members, law, limits_n, rules)
        .filter(|allocation| allocation.served >= 1.0 - 1e-9)
        .map(|allocation| allocation.power_w)
}

/// Thrusts that give τ_c (16), about the first member.
fn of_cluster(
    current_m_s: [f64; 3],
    members: &[(Pose, &Vehicle)],
    law: &PowerLaw,
    limits_n: (f64, f64),
    rules: &Rules,
) -> Option<Allocation> {
    let origin = members.first()?.0;
    let at_rest = Cluster::new(&origin, members).ok()?;
    let wrench: [f64; 6] = if is_still(&current_m_s) {
        // τ_c = g(level)
        at_rest.hydrostatics().restoring(&Vector3::z()).into()
    } else {
        // τ_c = C(ν')ν' + D(ν')ν' + g(level)
        let level = UnitQuaternion::from_euler_angles(0.0, 0.0, origin.yaw_rad);
        let v = level.inverse_transform_vector(&-Vector3::from(current_m_s));
        let nu = Vector6::new(v.x, v.y, v.z, 0.0, 0.0, 0.0);
        let mass = at_rest.rigid_body_mass() + at_rest.added_mass();
        (coriolis(&mass, &nu) * nu + Vector6::from(at_rest.force_needed(&nu.into()))).into()
    };
    let thrusters: Vec<(&Vehicle, Pose)> = members.iter().map(|&(pose, vehicle)| (vehicle, pose)).collect();
    let matrix = ConfigurationMatrix::of_cluster(&thrusters, &origin).ok()?;
    if wrench.iter().all(|component| component.abs() < NOTHING) {
        let thrusts_n = vec![0.0; matrix.thrusters()];
        return Some(Allocation { thrusts_n, power_w: 0.0, served: 1.0, missing: [0.0; 6] });
    }
    let limits: Vec<(f64, f64)> =
        members.iter().flat_map(|&(_, vehicle)| limits_of(vehicle, limits_n)).collect();
    // About the mean depth of the members.
    let depths = members.iter().map(|(pose, _)| pose.position_m[2] - origin.position_m[2]);
    let stiffness_nm = at_rest.hydrostatics().stiffness_nm(depths.sum::<f64>() / members.len() as f64);
    let allocator = Allocator::new(matrix, &limits, law.clone()).ok()?;
    allocator.with_passive(stiffness_nm * rules.tilt_limit_rad.sin()).allocate(&wrench).ok()
}

#[cfg(test)]
mod tests;
