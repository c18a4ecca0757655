//! The thruster configuration matrix: from thrusts to the wrench on a robot (9) and on a docked cluster (16).
//!
//! ```text
//! τ = T u,   T = [ e₁ … eₙ ; l₁ × e₁ … lₙ × eₙ ]                        (9)
//! T_c = [ e' … ; (r + l') × e' … ],   e' = R e,  l' = R l                 (16)
//! ```
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | e, l | direction (unit vector) and position of a thruster | robot's body; 1, m |
//! | u | thrusts, positive along e | N |
//! | R, r | rotation and position of a robot's body in the cluster's frame | 1, m |
//! | τ | wrench (X, Y, Z, K, M, N) at the origin of the frame | N, N·m |
//!
//! Robots are level, so R is a turn about z by the difference of headings. (16) as printed leaves out R.

use nalgebra::{DMatrix, Matrix6xX, Rotation3, Vector3, Vector6};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;

/// The six directions, in the order of a wrench.
pub const AXES: [&str; 6] = ["surge", "sway", "heave", "roll", "pitch", "yaw"];

/// Singular values below this share of the greatest count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// How far a direction's length may be from one.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Why a set of thrusters is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ThrusterError {
    /// No unit vector.
    #[error(
        "thruster {thruster} of {vehicle}: its direction has length {length}, a unit vector is asked for"
    )]
    Direction { vehicle: String, thruster: usize, length: f64 },
    /// A position that is no number.
    #[error("thruster {thruster} of {vehicle}: its position {position_m:?} m is not finite")]
    Position { vehicle: String, thruster: usize, position_m: [f64; 3] },
    /// Fewer than six directions can be pushed in.
    #[error("thruster matrix of rank {rank}: cannot push in {missing}")]
    Rank { rank: usize, missing: String },
}

/// T of a robot or a cluster: one column a thruster.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigurationMatrix(Matrix6xX<f64>);

impl ConfigurationMatrix {
    /// T of one vehicle about its body origin (9).
    ///
    /// # Errors
    /// [`ThrusterError`] for a direction that is no unit vector or a position that is not finite.
    pub fn of_vehicle(vehicle: &Vehicle) -> Result<Self, ThrusterError> {
        Self::of_cluster(&[(vehicle, Pose::default())], &Pose::default())
    }

    /// T_c of docked robots (16) about the position of `origin`, in axes turned by its heading; columns follow the
    /// robots' order. Vehicles without thrusters add none.
    pub fn of_cluster(members: &[(&Vehicle, Pose)], origin: &Pose) -> Result<Self, ThrusterError> {
        let into_frame = Rotation3::from_axis_angle(&Vector3::z_axis(), -origin.yaw_rad);
        let mut columns = Vec::new();
        for (vehicle, pose) in members {
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), pose.yaw_rad - origin.yaw_rad);
            let r = into_frame * (Vector3::from(pose.position_m) - Vector3::from(origin.position_m));
            for (k, thruster) in vehicle.thrusters.iter().enumerate() {
                let (e, l) = (Vector3::from(thruster.direction), Vector3::from(thruster.position_m));
                let (name, number) = (|| vehicle.name.clone(), k + 1);
                // No range contains NaN.
                if !(1.0 - UNIT_TOLERANCE..=1.0 + UNIT_TOLERANCE).contains(&e.norm()) {
                    return Err(ThrusterError::Direction {
                        vehicle: name(),
                        thruster: number,
                        length: e.norm(),
                    });
                }
                if !l.iter().all(|x| x.is_finite()) {
                    let position_m = thruster.position_m;
                    return Err(ThrusterError::Position { vehicle: name(), thruster: number, position_m });
                }
                // (e'; (r + l') × e')
                let e = turn * e;
                let m = (r + turn * l).cross(&e);
                columns.push(Vector6::new(e.x, e.y, e.z, m.x, m.y, m.z));
            }
        }
        // nalgebra makes no matrix from no columns.
        Ok(Self(if columns.is_empty() { Matrix6xX::zeros(0) } else { Matrix6xX::from_columns(&columns) }))
    }

    /// The columns: wrench of one newton of each thruster.
    #[must_use]
    pub fn matrix(&self) -> &Matrix6xX<f64> {
        &self.0
    }

    /// Number of thrusters.
    #[must_use]
    pub fn thrusters(&self) -> usize {
        self.0.ncols()
    }

    /// τ = T u; thrusts beyond the number of thrusters are left out.
    #[must_use]
    pub fn wrench(&self, thrusts_n: &[f64]) -> [f64; 6] {
        let mut tau = [0.0; 6];
        for (column, u) in self.0.column_iter().zip(thrusts_n) {
            for (t, c) in tau.iter_mut().zip(column.iter()) {
                *t += c * u;
            }
        }
        tau
    }

    /// The same thrusters, those that are not `usable` pushing nothing.
    pub(super) fn restricted(&self, usable: &[bool]) -> Self {
        let mut matrix = self.0.clone();
        for (mut column, _) in matrix.column_iter_mut().zip(usable).filter(|(_, usable)| !**usable) {
            column.fill(0.0);
        }
        Self(matrix)
    }

    /// Whether all six directions can be pushed in.
    ///
    /// # Errors
    /// [`ThrusterError::Rank`], naming the directions that are missing.
    pub fn require_full_rank(&self) -> Result<(), ThrusterError> {
        let null = self.null_space();
        if null.ncols() == 0 {
            return Ok(());
        }
        // The share of each axis that no thruster can serve.
        let share: Vec<f64> = (0..6).map(|axis| null.row(axis).norm()).collect();
        let named = |low: f64, high: f64| -> Vec<&str> {
            AXES.iter()
                .zip(&share)
                .filter(|(_, s)| (low..=high).contains(*s))
                .map(|(name, _)| *name)
                .collect()
        };
        let (whole, part) = (named(1.0 - 1e-6, 2.0), named(1e-6, 1.0 - 1e-6));
        let mut missing = whole.join(", ");
        if whole.len() < null.ncols() {
            let together = format!("a combination of {}", part.join(" and "));
            missing = if missing.is_empty() { together } else { format!("{missing}, {together}") };
        }
        Err(ThrusterError::Rank { rank: 6 - null.ncols(), missing })
    }

    /// Orthonormal basis of the wrenches that no thruster adds to, moments in units of the longest lever.
    fn null_space(&self) -> DMatrix<f64> {
        let lever = self.0.rows(3, 3).iter().fold(0.0, |a: f64, m| a.max(m.abs()));
        let mut scaled = DMatrix::zeros(6, self.thrusters().max(6));
        scaled.view_mut((0, 0), (6, self.thrusters())).copy_from(&self.0);
        if lever > 0.0 {
            scaled.rows_mut(3, 3).scale_mut(1.0 / lever);
        }
        let svd = scaled.svd(true, false);
        let greatest = svd.singular_values.max();
        let null: Vec<_> = svd
            .u
            .iter()
            .flat_map(|u| u.column_iter())
            .zip(svd.singular_values.iter())
            .filter(|(_, s)| **s <= RANK_TOLERANCE * greatest)
            .map(|(column, _)| column.into_owned())
            .collect();
        if null.is_empty() { DMatrix::zeros(6, 0) } else { DMatrix::from_columns(&null) }
    }
}

#[cfg(test)]
mod tests;
