//! Data packets: `u64` µs, `u32` frame number, `u32` components; each component `u32` size with its header, `u32` type, content.
//!
//! | type | component | content of one body |
//! |---|---|---|
//! | 5 | `6D` | `3 f32` position, `9 f32` rotation, column by column |
//! | 11 | `6DRes` | the same and `f32` residual |
//! | 6 | `6DEuler` | `3 f32` position, `3 f32` angles, ° |
//! | 12 | `6DEulerRes` | the same and `f32` residual |
//!
//! The content begins with `u32` bodies, `u16` drop rate, `u16` out-of-sync rate. A body that was not seen is NaN throughout. Read
//! are 5 and 11; 6 and 12 are written for clients that ask for them, with QTM's standard angles: R = R_x(roll)·R_y(pitch)·R_z(yaw).

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::bytes::{Malformed, Reader};

/// Length of a component's header, bytes.
const HEADER: usize = 8;
/// What every number of a body that was not seen is: all bits set, a quiet NaN.
const UNSEEN: f32 = f32::from_bits(u32::MAX);

/// A component with bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// Position and rotation matrix.
    Matrix,
    /// The same and the residual.
    MatrixResidual,
    /// Position and angles.
    Euler,
    /// The same and the residual.
    EulerResidual,
}

impl Component {
    /// The component that a command names.
    pub fn named(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "6d" => Some(Self::Matrix),
            "6dres" => Some(Self::MatrixResidual),
            "6deuler" => Some(Self::Euler),
            "6deulerres" => Some(Self::EulerResidual),
            _ => None,
        }
    }

    fn kind(self) -> u32 {
        match self {
            Self::Matrix => 5,
            Self::MatrixResidual => 11,
            Self::Euler => 6,
            Self::EulerResidual => 12,
        }
    }
}

/// A body of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SixD {
    /// Where, in mm and QTM's axes.
    pub position: Vector3<f64>,
    /// How turned.
    pub attitude: Quaternion<f64>,
    /// The residual, mm; `None` where the component has none.
    pub residual: Option<f64>,
    /// Whether it was seen.
    pub tracked: bool,
}

/// A frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// When it was captured, µs from the start of the measurement.
    pub timestamp_us: u64,
    /// QTM's count.
    pub number: u32,
    /// The bodies in the order of the parameters; `None` without a component that has bodies.
    pub bodies: Option<Vec<SixD>>,
}

/// From the content of a data packet.
///
/// # Errors
/// Content that is not laid out as it should be.
pub fn decode(content: &[u8]) -> Result<Data, Malformed> {
    let mut reader = Reader::new(content);
    let timestamp_us = reader.u64_le()?;
    let number = reader.u32_le()?;
    let components = reader.count_le(HEADER)?;
    let mut bodies = None;
    for _ in 0..components {
        let size = usize::try_from(reader.u32_le()?).unwrap_or(usize::MAX);
        let kind = reader.u32_le()?;
        let length =
            size.checked_sub(HEADER).ok_or(reader.malformed("a component shorter than its header"))?;
        let mut inside = reader.section(length)?;
        match kind {
            5 => bodies = Some(matrices(&mut inside, false)?),
            11 => bodies = Some(matrices(&mut inside, true)?),
            _ => {}
        }
    }
    Ok(Data { timestamp_us, number, bodies })
}

fn matrices(reader: &mut Reader<'_>, residuals: bool) -> Result<Vec<SixD>, Malformed> {
    let count = usize::try_from(reader.u32_le()?).unwrap_or(usize::MAX);
    reader.take(4)?;
    // The count stands before the rates, so it is held against what is behind them.
    let length = if residuals { 52 } else { 48 };
    if count > reader.left() / length {
        return Err(reader.malformed("a count larger than the rest of the message"));
    }
    let mut bodies = Vec::with_capacity(count);
    for _ in 0..count {
        let mut numbers = [0.0; 12];
        for number in &mut numbers {
            *number = f64::from(reader.f32_le()?);
        }
        let residual = if residuals { Some(f64::from(reader.f32_le()?)) } else { None };
        let [x, y, z, matrix @ ..] = numbers;
        bodies.push(SixD {
            position: Vector3::new(x, y, z),
            attitude: attitude_of(&Matrix3::from_column_slice(&matrix)),
            residual,
            tracked: numbers.iter().all(|number| number.is_finite()),
        });
    }
    Ok(bodies)
}

/// The quaternion of a rotation matrix; NaN for what is no rotation.
fn attitude_of(matrix: &Matrix3<f64>) -> Quaternion<f64> {
    // Single precision leaves 1e-7; a matrix further off is not one that QTM sends.
    let rotation =
        (matrix.transpose() * matrix - Matrix3::identity()).amax() < 1e-3 && matrix.determinant() > 0.0;
    if !rotation {
        return Quaternion::new(f64::NAN, f64::NAN, f64::NAN, f64::NAN);
    }
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix)).into_inner()
}

/// The content of a data packet with the same bodies in each of `components`; numbers are rounded to single precision.
#[expect(clippy::cast_possible_truncation, reason = "the wire is single precision")]
pub fn encode(data: &Data, components: &[Component]) -> Vec<u8> {
    let bodies = data.bodies.as_deref().unwrap_or_default();
    let mut out = Vec::new();
    out.extend(data.timestamp_us.to_le_bytes());
    out.extend(data.number.to_le_bytes());
    out.extend(u32::try_from(components.len()).unwrap_or_default().to_le_bytes());
    for &component in components {
        let mut content = Vec::new();
        content.extend(u32::try_from(bodies.len()).unwrap_or_default().to_le_bytes());
        content.extend([0; 4]);
        for body in bodies {
            let mut numbers: Vec<f64> = body.position.iter().copied().collect();
            let rotation = UnitQuaternion::from_quaternion(body.attitude).to_rotation_matrix();
            match component {
                Component::Matrix | Component::MatrixResidual => numbers.extend(rotation.matrix().iter()),
                Component::Euler | Component::EulerResidual => {
                    numbers.extend(angles(rotation.matrix()).map(f64::to_degrees));
                }
            }
            if matches!(component, Component::MatrixResidual | Component::EulerResidual) {
                numbers.push(body.residual.unwrap_or_default());
            }
            let seen = |number: &f64| if body.tracked { *number as f32 } else { UNSEEN };
            numbers.iter().for_each(|number| content.extend(seen(number).to_le_bytes()));
        }
        out.extend(u32::try_from(HEADER + content.len()).unwrap_or(u32::MAX).to_le_bytes());
        out.extend(component.kind().to_le_bytes());
        out.extend(content);
    }
    out
}

/// Roll, pitch and yaw with R = R_x(roll)·R_y(pitch)·R_z(yaw), rad.
fn angles(r: &Matrix3<f64>) -> [f64; 3] {
    // R = [c_p·c_y, −c_p·s_y, s_p; …; …, c_r·c_p]: the first row and the last column alone.
    let pitch = r[(0, 2)].clamp(-1.0, 1.0).asin();
    if r[(0, 0)].hypot(r[(0, 1)]) < 1e-9 {
        // x points up or down: roll and yaw turn about one axis, and all of it is called yaw.
        return [0.0, pitch, r[(1, 0)].atan2(r[(1, 1)])];
    }
    let roll = (-r[(1, 2)]).atan2(r[(2, 2)]);
    let yaw = (-r[(0, 1)]).atan2(r[(0, 0)]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(attitude: Quaternion<f64>) -> SixD {
        SixD { position: Vector3::new(1250.0, -3.5, 0.25), attitude, residual: Some(0.5), tracked: true }
    }

    #[test]
    fn a_quarter_turn_to_the_left_is_written_column_by_column() {
        // x becomes y: the first column is (0, 1, 0).
        let left = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let data = Data { timestamp_us: 7, number: 3, bodies: Some(vec![body(left.into_inner())]) };
        let bytes = encode(&data, &[Component::Matrix]);
        let floats: Vec<f32> =
            bytes[32..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(floats[..3], [1250.0, -3.5, 0.25]);
        let near =
            |found: &[f32], right: [f32; 3]| found.iter().zip(right).all(|(f, r)| (f - r).abs() < 1e-6);
        assert!(near(&floats[3..6], [0.0, 1.0, 0.0]), "{floats:?}");
        assert!(near(&floats[6..9], [-1.0, 0.0, 0.0]), "{floats:?}");
    }

    #[test]
    fn a_body_that_was_not_seen_is_nan_throughout() {
        let unseen = SixD { tracked: false, ..body(Quaternion::identity()) };
        let data =
            Data { timestamp_us: 7, number: 3, bodies: Some(vec![unseen, body(Quaternion::identity())]) };
        let bytes = encode(&data, &[Component::MatrixResidual]);
        assert!(bytes[32..32 + 52].iter().all(|&byte| byte == 255));
        let bodies = decode(&bytes).expect("its own packet").bodies.expect("bodies");
        assert!(!bodies[0].tracked && bodies[0].position.x.is_nan());
        assert!(bodies[1].tracked);
    }

    #[test]
    fn angles_give_back_the_rotation() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
        let made = |[roll, pitch, yaw]: [f64; 3]| {
            about(Vector3::x_axis(), roll) * about(Vector3::y_axis(), pitch) * about(Vector3::z_axis(), yaw)
        };
        for given in [[0.3, -0.7, 2.1], [-3.0, 1.2, -0.4], [0.3, quarter, 0.5], [0.3, -quarter, 0.5]] {
            let rotation = made(given);
            let again = made(angles(rotation.matrix()));
            // The angle between the two is worth no better near the pole, where asin is flat.
            assert!(rotation.angle_to(&again) < 1e-7, "{given:?}");
        }
    }

    #[test]
    fn what_is_no_rotation_has_no_attitude() {
        assert!(attitude_of(&Matrix3::identity()).w > 0.99);
        assert!(attitude_of(&(Matrix3::identity() * 2.0)).w.is_nan());
        assert!(attitude_of(&Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0))).w.is_nan());
    }
}
