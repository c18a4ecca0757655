//! Planar motion of a floating rigid body with added mass and quadratic drag in moving water.
//!
//! The origin of S is the mean of the modules' centres; the centre of mass lies at (x_g, y_g). With v the velocity of the origin over
//! ground, v_c that of the water (uniform) and v_r = v − v_c, all in S, and wrench (F_x, F_y, τ) about the origin in S:
//!
//! ```text
//! (m + m_x)·v̇_x − m·y_g·Ω̇ = F_x + F_Dx + Ω·(m·(v_y + Ω·x_g) + m_x·v_cy + m_y·v_ry)                (b1)
//! (m + m_y)·v̇_y + m·x_g·Ω̇ = F_y + F_Dy − Ω·(m·(v_x − Ω·y_g) + m_y·v_cx + m_x·v_rx)                (b2)
//! (I + m·(x_g² + y_g²) + I_a)·Ω̇ + m·(x_g·v̇_y − y_g·v̇_x)
//!              = τ + τ_D − (m_y − m_x)·v_rx·v_ry − m·Ω·(x_g·v_x + y_g·v_y)                        (b3)
//!
//! w = (v_rx − Ω·y_p, v_ry + Ω·x_p)                       the drag's centre through the water       (b4)
//! F_Dx = −D_x·w_x|w_x| − D_c·|w_y|·w_x,   F_Dy = −D_y·w_y|w_y| − D_c·|w_x|·w_y                    (b5)
//! τ_D  = x_p·F_Dy − y_p·F_Dx − C_R·Ω|Ω| − (E_x·|w_x| + E_y·|w_y|)·Ω                               (b6)
//! ```
//!
//! These are Kirchhoff's equations for the momentum m·(v + Ω×r_g) + M_A·v_r; the terms with v_c are M_A times the change that
//! the water's velocity shows in the turning frame, the one with m_y − m_x of (b3) is the Munk moment. In still water
//! and without drag the momentum in the world, the angular momentum and the kinetic energy are conserved. Drag
//! per axis is as in the paper's (19), yaw drag as in (15), but for the terms with D_c, E and (x_p, y_p), which are zero unless a
//! scenario's `[tank]` says otherwise.
//!
//! Assumptions and limits: the surface is unbounded (no walls, no memory of the water). Added mass has its centre at the origin.
//! Current and gusts that speed up or slow down act through drag alone; what waves do beside that is in the wrench ([`super::waves`]).
//! Integrated by RK4 with wrench and water held over a step.

use modboat::motion::Wrench;
use record::PoseSample;

/// What resists motion. Axes are sway (x) and surge (y).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Body {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Moment of inertia I about the centre of mass, kg·m².
    pub inertia_kg_m2: f64,
    /// Centre of mass (x_g, y_g), m.
    pub centre_m: [f64; 2],
    /// Added mass (m_x, m_y), kg.
    pub added_mass_kg: [f64; 2],
    /// Added moment of inertia I_a, kg·m².
    pub added_inertia_kg_m2: f64,
    /// Translational drag (D_x, D_y) of the whole body, N·s²/m².
    pub drag_n_s2_m2: [f64; 2],
    /// D_c, N·s²/m².
    pub drag_cross_n_s2_m2: f64,
    /// The drag's centre (x_p, y_p), m.
    pub drag_centre_m: [f64; 2],
    /// Rotational drag C_R, N·m·s².
    pub yaw_drag_n_m_s2: f64,
    /// Yaw damping (E_x, E_y) by speed, N·s².
    pub yaw_drag_speed_n_s2: [f64; 2],
}

/// Where the body is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyState {
    /// Origin of S in the world, m.
    pub position_m: [f64; 2],
    /// Heading Θ of the surge axis, rad (unwrapped).
    pub heading_rad: f64,
    /// Velocity over ground in S (sway, surge), m/s.
    pub velocity_s_m_s: [f64; 2],
    /// Ω, rad/s.
    pub yaw_rate_rad_s: f64,
}

/// (x, y) in S → world: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
pub(crate) fn to_world(heading_rad: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    world_by(heading_rad.sin_cos(), [x, y])
}

/// [`to_world`] by sin and cos of the heading.
fn world_by((sin, cos): (f64, f64), [x, y]: [f64; 2]) -> [f64; 2] {
    [sin * x + cos * y, -cos * x + sin * y]
}

/// (x, y) in the world → S, the transpose of [`to_world`].
pub(crate) fn to_structure(heading_rad: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    structure_by(heading_rad.sin_cos(), [x, y])
}

/// [`to_structure`] by sin and cos of the heading.
fn structure_by((sin, cos): (f64, f64), [x, y]: [f64; 2]) -> [f64; 2] {
    [sin * x - cos * y, cos * x + sin * y]
}

/// Time derivatives of position (world), heading, velocity (S), yaw rate.
type Rates = [f64; 6];

/// What (b1) to (b3) are solved for the accelerations by, the same over all of a step.
struct Inertia {
    /// (m + m_x, m + m_y), kg.
    masses_kg: [f64; 2],
    /// What Ω̇ takes from v̇_x and v̇_y, m.
    arms_m: [f64; 2],
    /// What is left about the vertical, kg·m².
    left_kg_m2: f64,
}

impl BodyState {
    /// That of `sample`.
    pub(crate) fn of(sample: &PoseSample) -> Self {
        Self {
            position_m: sample.position_m,
            heading_rad: sample.heading_rad,
            velocity_s_m_s: to_structure(sample.heading_rad, sample.velocity_m_s),
            yaw_rate_rad_s: sample.yaw_rate_rad_s,
        }
    }

    /// Pose and velocity over ground, at `t_s`.
    pub(crate) fn sample(&self, t_s: f64) -> PoseSample {
        PoseSample {
            t_s,
            position_m: self.position_m,
            heading_rad: self.heading_rad,
            velocity_m_s: to_world(self.heading_rad, self.velocity_s_m_s),
            yaw_rate_rad_s: self.yaw_rate_rad_s,
        }
    }

    fn plus(&self, rates: &Rates, dt_s: f64) -> Self {
        Self {
            position_m: [self.position_m[0] + rates[0] * dt_s, self.position_m[1] + rates[1] * dt_s],
            heading_rad: self.heading_rad + rates[2] * dt_s,
            velocity_s_m_s: [
                self.velocity_s_m_s[0] + rates[3] * dt_s,
                self.velocity_s_m_s[1] + rates[4] * dt_s,
            ],
            yaw_rate_rad_s: self.yaw_rate_rad_s + rates[5] * dt_s,
        }
    }
}

impl Body {
    /// The state `dt_s` later, with wrench (S) and velocity of the water (world) held.
    pub(crate) fn step(
        &self,
        state: &BodyState,
        dt_s: f64,
        wrench: Wrench,
        water_m_s: [f64; 2],
    ) -> BodyState {
        let inertia = self.inertia();
        let rates = |state: &BodyState| self.rates(&inertia, state, wrench, water_m_s);
        let k1 = rates(state);
        let k2 = rates(&state.plus(&k1, 0.5 * dt_s));
        let k3 = rates(&state.plus(&k2, 0.5 * dt_s));
        let k4 = rates(&state.plus(&k3, dt_s));
        let mean = std::array::from_fn(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0);
        state.plus(&mean, dt_s)
    }

    /// (b1) and (b2) put into (b3) leave Ω̇ alone.
    fn inertia(&self) -> Inertia {
        let (m, [m_x, m_y], [x_g, y_g]) = (self.mass_kg, self.added_mass_kg, self.centre_m);
        let (mass_x_kg, mass_y_kg) = (m + m_x, m + m_y);
        let (arm_x, arm_y) = (-m * y_g / mass_x_kg, m * x_g / mass_y_kg);
        let left_kg_m2 = self.inertia_kg_m2 + m * (x_g * x_g + y_g * y_g) + self.added_inertia_kg_m2
            - (arm_x * arm_x * mass_x_kg + arm_y * arm_y * mass_y_kg);
        Inertia { masses_kg: [mass_x_kg, mass_y_kg], arms_m: [arm_x, arm_y], left_kg_m2 }
    }

    fn rates(&self, inertia: &Inertia, state: &BodyState, wrench: Wrench, water_m_s: [f64; 2]) -> Rates {
        let (m, [m_x, m_y], omega) = (self.mass_kg, self.added_mass_kg, state.yaw_rate_rad_s);
        let [v_x, v_y] = state.velocity_s_m_s;
        let turned = state.heading_rad.sin_cos();
        let [c_x, c_y] = structure_by(turned, water_m_s);
        let (r_x, r_y) = (v_x - c_x, v_y - c_y);
        let world = world_by(turned, state.velocity_s_m_s);
        let ([x_g, y_g], [x_p, y_p]) = (self.centre_m, self.drag_centre_m);
        // w = (v_rx − Ω·y_p, v_ry + Ω·x_p)                                                          (b4)
        let (w_x, w_y) = (r_x - omega * y_p, r_y + omega * x_p);
        // F_Dx = −D_x·w_x|w_x| − D_c·|w_y|·w_x,   F_Dy = −D_y·w_y|w_y| − D_c·|w_x|·w_y             (b5)
        let drag_x_n = self.drag_n_s2_m2[0] * w_x * w_x.abs() + self.drag_cross_n_s2_m2 * w_y.abs() * w_x;
        let drag_y_n = self.drag_n_s2_m2[1] * w_y * w_y.abs() + self.drag_cross_n_s2_m2 * w_x.abs() * w_y;
        // τ_D  = x_p·F_Dy − y_p·F_Dx − C_R·Ω|Ω| − (E_x·|w_x| + E_y·|w_y|)·Ω                         (b6)
        let [e_x, e_y] = self.yaw_drag_speed_n_s2;
        let drag_nm = self.yaw_drag_n_m_s2 * omega * omega.abs()
            + (x_p * drag_y_n - y_p * drag_x_n)
            + (e_x * w_x.abs() + e_y * w_y.abs()) * omega;
        // F_x + F_Dx + Ω·(m·(v_y + Ω·x_g) + m_x·v_cy + m_y·v_ry)                                    (b1)
        let force_x_n = wrench.fx_n - drag_x_n + omega * (m * (v_y + omega * x_g) + m_x * c_y + m_y * r_y);
        // F_y + F_Dy − Ω·(m·(v_x − Ω·y_g) + m_y·v_cx + m_x·v_rx)                                    (b2)
        let force_y_n = wrench.fy_n - drag_y_n - omega * (m * (v_x - omega * y_g) + m_y * c_x + m_x * r_x);
        // τ + τ_D − (m_y − m_x)·v_rx·v_ry − m·Ω·(x_g·v_x + y_g·v_y)                                 (b3)
        let torque_nm =
            wrench.tau_nm - drag_nm - (m_y - m_x) * r_x * r_y - m * omega * (x_g * v_x + y_g * v_y);
        let &Inertia { masses_kg: [mass_x_kg, mass_y_kg], arms_m: [arm_x, arm_y], left_kg_m2 } = inertia;
        let turning_rad_s2 = (torque_nm - (arm_x * force_x_n + arm_y * force_y_n)) / left_kg_m2;
        [
            world[0],
            world[1],
            omega,
            force_x_n / mass_x_kg - arm_x * turning_rad_s2,
            force_y_n / mass_y_kg - arm_y * turning_rad_s2,
            turning_rad_s2,
        ]
    }
}

#[cfg(test)]
mod tests_beyond;

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const DT_S: f64 = 1e-3;

    /// Three modules in a row, with very different added masses.
    fn body(drag: f64) -> Body {
        Body {
            mass_kg: 3.0,
            inertia_kg_m2: 0.054,
            centre_m: [0.0; 2],
            added_mass_kg: [2.5, 0.6],
            added_inertia_kg_m2: 0.03,
            drag_n_s2_m2: [13.5 * drag; 2],
            drag_cross_n_s2_m2: 0.0,
            drag_centre_m: [0.0; 2],
            yaw_drag_n_m_s2: 0.03 * drag,
            yaw_drag_speed_n_s2: [0.0; 2],
        }
    }

    fn moving() -> BodyState {
        BodyState {
            position_m: [0.3, -0.2],
            heading_rad: 0.7,
            velocity_s_m_s: [0.2, -0.35],
            yaw_rate_rad_s: 0.9,
        }
    }

    /// Momentum (world), angular momentum about the world's origin, kinetic energy; in still water.
    fn invariants(body: &Body, state: &BodyState) -> [f64; 4] {
        let [v_x, v_y] = state.velocity_s_m_s;
        let in_s =
            [(body.mass_kg + body.added_mass_kg[0]) * v_x, (body.mass_kg + body.added_mass_kg[1]) * v_y];
        let [p_x, p_y] = to_world(state.heading_rad, in_s);
        let spin = (body.inertia_kg_m2 + body.added_inertia_kg_m2) * state.yaw_rate_rad_s;
        let [x, y] = state.position_m;
        let energy_j = 0.5 * (in_s[0] * v_x + in_s[1] * v_y + spin * state.yaw_rate_rad_s);
        [p_x, p_y, spin + x * p_y - y * p_x, energy_j]
    }

    #[test]
    fn the_frames_are_those_of_the_design() {
        // Heading 0: surge is world x, sway (right) is world −y.
        let close = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-15 && (a[1] - b[1]).abs() < 1e-15;
        assert!(close(to_world(0.0, [0.0, 1.0]), [1.0, 0.0]));
        assert!(close(to_world(0.0, [1.0, 0.0]), [0.0, -1.0]));
        // Heading north: S and world coincide.
        assert!(close(to_world(FRAC_PI_2, [0.3, 0.4]), [0.3, 0.4]));
        assert!(close(to_structure(0.8, to_world(0.8, [0.3, 0.4])), [0.3, 0.4]));
    }

    #[test]
    fn without_drag_momentum_angular_momentum_and_energy_are_conserved() {
        let body = body(0.0);
        let mut state = moving();
        let before = invariants(&body, &state);
        let mut swung_rad: f64 = 0.0;
        for step in 0..60_000 {
            state = body.step(&state, DT_S, Wrench::default(), [0.0; 2]);
            swung_rad = swung_rad.max((state.heading_rad - 0.7).abs());
            for (now, then) in invariants(&body, &state).iter().zip(before) {
                assert!((now - then).abs() < 1e-10, "step {step}: {now} against {then}");
            }
        }
        // The Munk moment swings it to and fro meanwhile: nothing above held by standing still.
        assert!(swung_rad > 0.5, "{swung_rad} rad");
    }

    #[test]
    fn drag_in_still_water_takes_energy_at_every_step() {
        let body = body(1.0);
        let mut state = moving();
        let mut energy_j = invariants(&body, &state)[3];
        let first_j = energy_j;
        for step in 0..120_000 {
            state = body.step(&state, DT_S, Wrench::default(), [0.0; 2]);
            let now_j = invariants(&body, &state)[3];
            assert!(now_j < energy_j, "step {step}: {now_j} J after {energy_j} J");
            energy_j = now_j;
        }
        assert!(energy_j < 1e-3 * first_j, "{energy_j} J of {first_j} J left");
    }

    #[test]
    fn a_constant_wrench_leads_to_the_hand_worked_terminal_velocities() {
        let body = body(1.0);
        for (wrench, expected) in [
            // √(0.0216/13.5) = 0.04 m/s forward or sideways, √(0.003/0.03) = 0.3162 rad/s.
            (Wrench { fy_n: 0.0216, ..Wrench::default() }, [0.0, 0.04, 0.0]),
            (Wrench { fx_n: -0.0216, ..Wrench::default() }, [-0.04, 0.0, 0.0]),
            (Wrench { tau_nm: -0.003, ..Wrench::default() }, [0.0, 0.0, -0.1_f64.sqrt()]),
        ] {
            let mut state = BodyState {
                velocity_s_m_s: [0.0; 2],
                yaw_rate_rad_s: 0.0,
                heading_rad: 1.0,
                position_m: [0.0; 2],
            };
            for _ in 0..60_000 {
                state = body.step(&state, DT_S, wrench, [0.0; 2]);
            }
            let [v_x, v_y] = state.velocity_s_m_s;
            for (seen, value) in [v_x, v_y, state.yaw_rate_rad_s].into_iter().zip(expected) {
                assert!((seen - value).abs() < 1e-6, "{wrench:?}: {seen} for {value}");
            }
        }
    }

    #[test]
    fn a_body_at_rest_in_the_water_drifts_along_whatever_its_heading_and_spin() {
        // Turning does not move a body that rests in the water: in the water's own frame it is still water.
        let body = body(1.0);
        let water_m_s = [0.03, -0.05];
        let mut state =
            BodyState { velocity_s_m_s: to_structure(0.4, water_m_s), heading_rad: 0.4, ..moving() };
        for _ in 0..20_000 {
            state = body.step(&state, DT_S, Wrench::default(), water_m_s);
            let ground_m_s = to_world(state.heading_rad, state.velocity_s_m_s);
            assert!(
                (ground_m_s[0] - 0.03).abs() < 1e-9 && (ground_m_s[1] + 0.05).abs() < 1e-9,
                "{ground_m_s:?}"
            );
        }
    }
}
