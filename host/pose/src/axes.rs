//! From the laboratory's axes and unit to the world's, and to those of underwater vehicles.
//!
//! ```text
//! p_w = R_z(−h)·A·(u·p − o)         R_w = R_z(−h)·A·R·Aᵀ
//! p_n = T·p_w                        R_n = T·R_w·B
//! ```
//!
//! | symbol | what | unit |
//! |---|---|---|
//! | p, R | a body's position and attitude as the server says | server's unit |
//! | u | metres in the server's unit | m |
//! | o | the world's origin in the laboratory's axes | m |
//! | A | turns the axis that is up into z: the identity for z up, a quarter turn about x for y up | – |
//! | h | heading of the world's x axis (east) in the laboratory, counter-clockwise seen from above, from the laboratory's x axis | rad |
//! | T, B | east-north-up to north-east-down; forward-left-up to forward-right-down | – |
//!
//! With y up, bodies have y up too: a body that is not turned in the laboratory is not turned here, and one that turns about the
//! vertical turns about z. Nothing is guessed: up axis and unit are the operator's word.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// The axis that points up in the laboratory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// QTM, Vicon, and Motive where it is set so.
    Z,
    /// Motive's standard.
    Y,
}

/// What the server measures lengths in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// NatNet and VRPN.
    Metre,
    /// QTM.
    Millimetre,
}

impl Unit {
    /// Metres in it.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Millimetre => 1e-3,
        }
    }
}

/// A place and a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Where.
    pub position: Vector3<f64>,
    /// How turned: body to frame.
    pub attitude: UnitQuaternion<f64>,
}

/// How the world lies in the laboratory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// The axis that points up.
    pub up: Up,
    /// The unit of lengths.
    pub unit: Unit,
    /// The world's origin in the laboratory's axes, m.
    pub origin_m: Vector3<f64>,
    /// Heading of the world's x axis in the laboratory, rad.
    pub heading_rad: f64,
}

impl Axes {
    /// A laboratory whose axes are the world's but for the one that is up.
    pub fn new(up: Up, unit: Unit) -> Self {
        Self { up, unit, origin_m: Vector3::zeros(), heading_rad: 0.0 }
    }

    /// A: the axis that is up becomes z.
    fn upright(&self) -> UnitQuaternion<f64> {
        match self.up {
            Up::Z => UnitQuaternion::identity(),
            Up::Y => UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2),
        }
    }

    /// R_z(−h)·A.
    fn turn(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -self.heading_rad) * self.upright()
    }

    /// A pose in the world (m; x east, y north, z up; body x forward, y left, z up) of what the server says.
    pub fn to_world(&self, said: &Pose) -> Pose {
        let turn = self.turn();
        Pose {
            position: turn * (said.position * self.unit.metres() - self.origin_m),
            attitude: turn * said.attitude * self.upright().inverse(),
        }
    }

    /// What a server of this laboratory would say of a pose in the world.
    pub fn from_world(&self, pose: &Pose) -> Pose {
        let back = self.turn().inverse();
        Pose {
            position: (back * pose.position + self.origin_m) / self.unit.metres(),
            attitude: back * pose.attitude * self.upright(),
        }
    }
}

/// T: x north is the world's y, y east its x, z down.
fn world_to_ned() -> Matrix3<f64> {
    Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0)
}

/// B: right is minus left, down is minus up.
fn up_to_down() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0))
}

/// The same pose in north-east-down, of a body with x forward, y right, z down. It is its own inverse.
pub fn swap_world_and_ned(pose: &Pose) -> Pose {
    let matrix = world_to_ned() * pose.attitude.to_rotation_matrix().into_inner() * up_to_down();
    Pose {
        position: world_to_ned() * pose.position,
        attitude: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix)),
    }
}

/// The heading of a body's x axis: counter-clockwise from the frame's x axis in the x-y plane, rad.
pub fn heading_rad(attitude: &UnitQuaternion<f64>) -> f64 {
    let forward = attitude * Vector3::x();
    forward.y.atan2(forward.x)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn yaw(angle: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
    }

    fn near(found: &Pose, right: &Pose) -> bool {
        (found.position - right.position).norm() < 1e-12 && found.attitude.angle_to(&right.attitude) < 1e-7
    }

    #[test]
    fn motive_s_standard_is_y_up_in_metres() {
        let axes = Axes::new(Up::Y, Unit::Metre);
        // x stays x, y is up, z points at the viewer: minus north.
        let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.3);
        let said = Pose { position: Vector3::new(1.0, 2.0, -3.0), attitude: turned };
        let right = Pose { position: Vector3::new(1.0, 3.0, 2.0), attitude: yaw(0.3) };
        assert!(near(&axes.to_world(&said), &right));
    }

    #[test]
    fn origin_and_heading_of_the_world_in_the_laboratory() {
        let axes = Axes {
            up: Up::Z,
            unit: Unit::Millimetre,
            origin_m: Vector3::new(2.0, 1.0, 0.5),
            heading_rad: FRAC_PI_2,
        };
        // One metre along the laboratory's y, from the origin: one metre east.
        let said = Pose { position: Vector3::new(2000.0, 2000.0, 500.0), attitude: yaw(FRAC_PI_2) };
        let right = Pose { position: Vector3::new(1.0, 0.0, 0.0), attitude: yaw(0.0) };
        assert!(near(&axes.to_world(&said), &right));
    }

    #[test]
    fn there_and_back_for_every_laboratory() {
        let pose = Pose {
            position: Vector3::new(0.3, -1.7, 0.4),
            attitude: UnitQuaternion::from_euler_angles(0.2, -0.5, 2.4),
        };
        for up in [Up::Z, Up::Y] {
            for unit in [Unit::Metre, Unit::Millimetre] {
                let axes = Axes { up, unit, origin_m: Vector3::new(1.0, -2.0, 0.7), heading_rad: 1.1 };
                assert!(near(&axes.to_world(&axes.from_world(&pose)), &pose));
            }
        }
        assert!(near(&swap_world_and_ned(&swap_world_and_ned(&pose)), &pose));
    }

    #[test]
    fn north_is_ahead_of_a_vehicle_without_yaw() {
        // Heading north in the world is a quarter turn from east.
        let pose = Pose { position: Vector3::new(1.0, 2.0, -3.0), attitude: yaw(FRAC_PI_2) };
        let ned = swap_world_and_ned(&pose);
        assert!(near(&ned, &Pose { position: Vector3::new(2.0, 1.0, 3.0), attitude: yaw(0.0) }));
        // Turning to the east is a positive yaw there and a negative one here.
        let east = swap_world_and_ned(&Pose { position: Vector3::zeros(), attitude: yaw(0.0) });
        assert!((heading_rad(&east.attitude) - FRAC_PI_2).abs() < 1e-7);
        // Nose up is a positive pitch there, about the right.
        let up = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -0.2);
        let nose = swap_world_and_ned(&Pose { position: Vector3::zeros(), attitude: yaw(FRAC_PI_2) * up });
        let (roll, pitch, yawed) = nose.attitude.euler_angles();
        assert!(roll.abs() < 1e-7 && (pitch - 0.2).abs() < 1e-7 && yawed.abs() < 1e-7);
    }

    #[test]
    fn headings() {
        assert!((heading_rad(&yaw(3.0)) - 3.0).abs() < 1e-12);
        assert!((heading_rad(&yaw(-PI + 0.1)) + PI - 0.1).abs() < 1e-12);
    }
}
