//! What waiting clusters draw: balances by the seats of a cluster, each worked out once.
//!
//! A cluster of robots that feel nothing themselves needs no balance. Any other one is looked up by its seats: most
//! configurations differ in where robots rest that are not docked to the tool.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use reconfiguration::pose::Pose;
use reconfiguration::problem::Rules;
use reconfiguration::vehicle::Vehicle;

use super::super::balance::{Unbalanced, power_of_cluster};
use super::super::power::PowerLaw;
use super::places::Places;

/// No more balances are kept.
const KEPT_MOST: usize = 500_000;

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Waits {
    law: PowerLaw,
    limits_n: (f64, f64),
    rules: Rules,
    known: Mutex<HashMap<Vec<u16>, Option<f64>>>,
    /// As bits: such floats, not negative, sort like them.
    least_met_w: AtomicU64,
}

impl Waits {
    pub(super) fn new(law: &PowerLaw, limits_n: (f64, f64), rules: &Rules) -> Self {
        Self {
            law: law.clone(),
            limits_n,
            rules: rules.clone(),
            known: Mutex::default(),
            least_met_w: AtomicU64::new(f64::INFINITY.to_bits()),
        }
    }

    /// The least that has been told, W.
    pub(super) fn least_met_w(&self) -> f64 {
        f64::from_bits(self.least_met_w.load(Ordering::Relaxed))
    }

    /// Power that balances what rests, W; why it cannot be balanced otherwise. The reason names no share.
    pub(super) fn power_w(&self, places: &Places<'_>, taken: &[usize]) -> Result<f64, Unbalanced> {
        let mut power_w = 0.0;
        let clusters = places.clusters(taken);
        if let [first, second, ..] = clusters.as_slice()
            && self.rules.one_cluster
        {
            return Err(Unbalanced::Apart(first[0], second[0]));
        }
        for cluster in clusters {
            let members: Vec<(Pose, &Vehicle)> = cluster.iter().map(|&seat| places.body(seat)).collect();
            if members.iter().all(|(_, vehicle)| feels_nothing(vehicle)) {
                continue;
            }
            if members.iter().all(|(_, vehicle)| vehicle.thrusters.is_empty()) {
                return Err(Unbalanced::Alone(cluster[0]));
            }
            let key: Vec<u16> = cluster.iter().map(|&seat| seat as u16).collect();
            let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&key).copied();
            let own_w = known.unwrap_or_else(|| {
                let own_w = power_of_cluster(&members, &self.law, self.limits_n, &self.rules);
                let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
                if known.len() < KEPT_MOST {
                    known.insert(key, own_w);
                }
                own_w
            });
            power_w += own_w.ok_or(Unbalanced::OutOfReach { body: cluster[0], served: 0.0 })?;
        }
        self.least_met_w.fetch_min(power_w.to_bits(), Ordering::Relaxed);
        Ok(power_w)
    }
}

/// A robot that neither sinks nor rises, and stays level.
pub(super) fn feels_nothing(vehicle: &Vehicle) -> bool {
    let body = &vehicle.body;
    !vehicle.thrusters.is_empty()
        && (body.weight_n - body.buoyancy_n).abs() < 1e-12
        && (0..2).all(|k| (body.r_g_m[k] - body.r_b_m[k]).abs() < 1e-12)
}
