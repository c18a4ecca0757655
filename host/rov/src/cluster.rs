//! A rigid assembly of docked robots and tools as one body. A robot alone is a cluster of one.
//!
//! With member i at p, R in the cluster's frame, its own velocity is νᵢ = Hᵢ ν,
//!
//! ```text
//! H = [ Rᵀ  −Rᵀ S(p) ]        M = Σ Hᵢᵀ Mᵢ Hᵢ  for M_RB and M_A        D(ν)ν = Σ Hᵢᵀ Dᵢ(νᵢ) νᵢ
//!     [ 0    Rᵀ      ]
//! D(ν) = D_V + D_N(ν) = diag(d_V) + diag(d_N |ν|)
//! ```
//!
//! which keeps kinetic energy and dissipated power: ½νᵀMν = Σ ½νᵢᵀMᵢνᵢ and νᵀDν = Σ νᵢᵀDᵢνᵢ. Damping is evaluated at
//! each member's own velocity, so that a turning line of robots drags more the longer it is.
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | S(a) | the matrix of a × | |
//! | M_RB | rigid-body mass: [mI, −mS(r_G); mS(r_G), I_G − mS(r_G)²] | cluster; kg, kg·m, kg·m² |
//! | M_A | added mass | cluster; kg, kg·m, kg·m² |
//!
//! Assumed: members do not shield each other. Docked hulls do: added mass across the line and drag along it are
//! less in water than this sum.

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};
use reconfiguration::body::Body;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use thiserror::Error;

use super::hydrostatics::Hydrostatics;

/// Why bodies form no cluster.
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ClusterError {
    /// It has no members.
    #[error("a cluster of no members")]
    Empty,
    /// A pose that is no pose.
    #[error("member {member}: pose {pose:?} (m, m, m, rad): must be finite")]
    Pose { member: usize, pose: [f64; 4] },
}

/// Damping of one member and where it is.
#[derive(Clone, Debug, PartialEq)]
struct Damping {
    /// Member axes in the cluster's frame.
    rotation: Matrix3<f64>,
    offset_m: Vector3<f64>,
    linear: Vector6<f64>,
    quadratic: Vector6<f64>,
}

/// Several bodies that move as one.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    hydrostatics: Hydrostatics,
    rigid_body: Matrix6<f64>,
    added: Matrix6<f64>,
    damping: Vec<Damping>,
}

impl Cluster {
    /// Vehicles at level poses in the world, as one body whose frame is that of a level body at `origin`.
    ///
    /// # Errors
    /// [`ClusterError`] for no members, or a pose that is not finite.
    pub fn new(origin: &Pose, members: &[(Pose, &Vehicle)]) -> Result<Self, ClusterError> {
        for (member, pose) in std::iter::once(origin).chain(members.iter().map(|(pose, _)| pose)).enumerate()
        {
            let pose: [f64; 4] = (*pose).into();
            if !pose.iter().all(|number| number.is_finite()) {
                return Err(ClusterError::Pose { member: member.saturating_sub(1), pose });
            }
        }
        let world_to_cluster = yaw(-origin.yaw_rad);
        members
            .iter()
            .map(|(pose, vehicle)| {
                let offset_m =
                    world_to_cluster * (Vector3::from(pose.position_m) - Vector3::from(origin.position_m));
                Self::carried(&vehicle.body, offset_m, yaw(pose.yaw_rad - origin.yaw_rad))
            })
            .reduce(Self::with)
            .ok_or(ClusterError::Empty)
    }

    /// A cluster of one body, in the body's own frame.
    #[must_use]
    pub fn of(body: &Body) -> Self {
        Self::carried(body, Vector3::zeros(), Matrix3::identity())
    }

    fn carried(body: &Body, offset_m: Vector3<f64>, rotation: Matrix3<f64>) -> Self {
        // M_RB at the body's own origin.
        let offset = Vector3::from(body.r_g_m).cross_matrix();
        let inertia = Matrix3::from_diagonal(&body.inertia_kg_m2.into());
        let mut rigid_body = Matrix6::zeros();
        rigid_body.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(body.mass_kg);
        rigid_body.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-body.mass_kg * offset));
        rigid_body.fixed_view_mut::<3, 3>(3, 0).copy_from(&(body.mass_kg * offset));
        rigid_body.fixed_view_mut::<3, 3>(3, 3).copy_from(&(inertia - body.mass_kg * offset * offset));
        let added = Matrix6::from_diagonal(&body.added_mass.into());
        // νᵢ = H ν
        let back = rotation.transpose();
        let mut h = Matrix6::zeros();
        h.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
        h.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-back * offset_m.cross_matrix()));
        h.fixed_view_mut::<3, 3>(3, 3).copy_from(&back);
        Self {
            hydrostatics: Hydrostatics::of(body).carried(&offset_m, &rotation),
            rigid_body: h.transpose() * rigid_body * h,
            added: h.transpose() * added * h,
            damping: vec![Damping {
                rotation,
                offset_m,
                linear: body.linear_damping.into(),
                quadratic: body.quadratic_damping.into(),
            }],
        }
    }

    fn with(mut self, other: Self) -> Self {
        self.hydrostatics = self.hydrostatics.with(&other.hydrostatics);
        self.rigid_body += other.rigid_body;
        self.added += other.added;
        self.damping.extend(other.damping);
        self
    }

    /// Weight, buoyancy and their centres in the cluster's frame.
    #[must_use]
    pub fn hydrostatics(&self) -> &Hydrostatics {
        &self.hydrostatics
    }

    /// Rigid-body mass matrix M_RB at the cluster's origin.
    #[must_use]
    pub fn rigid_body_mass(&self) -> &Matrix6<f64> {
        &self.rigid_body
    }

    /// Added-mass matrix M_A at the cluster's origin.
    #[must_use]
    pub fn added_mass(&self) -> &Matrix6<f64> {
        &self.added
    }

    /// D(ν)ν: what the water takes, N and N·m.
    #[must_use]
    pub fn drag(&self, nu: &[f64; 6]) -> [f64; 6] {
        let (v, omega) = (Vector3::new(nu[0], nu[1], nu[2]), Vector3::new(nu[3], nu[4], nu[5]));
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for member in &self.damping {
            let v_i = member.rotation.tr_mul(&(v + omega.cross(&member.offset_m)));
            let omega_i = member.rotation.tr_mul(&omega);
            let part = |axis: usize, speed: f64| {
                (member.linear[axis] + member.quadratic[axis] * speed.abs()) * speed
            };
            let f = member.rotation * Vector3::new(part(0, v_i.x), part(1, v_i.y), part(2, v_i.z));
            let m =
                member.rotation * Vector3::new(part(3, omega_i.x), part(4, omega_i.y), part(5, omega_i.z));
            force += f;
            moment += m + member.offset_m.cross(&f);
        }
        [force.x, force.y, force.z, moment.x, moment.y, moment.z]
    }

    /// What thrusters bring in steady level motion (12): τ = D(ν)ν + g, N and N·m.
    #[must_use]
    pub fn force_needed(&self, nu: &[f64; 6]) -> [f64; 6] {
        (Vector6::from(self.drag(nu)) + self.hydrostatics.restoring(&Vector3::z())).into()
    }
}

/// Turned to the right by `yaw_rad` about the downward axis.
fn yaw(yaw_rad: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_rad).into_inner()
}

#[cfg(test)]
mod tests;
