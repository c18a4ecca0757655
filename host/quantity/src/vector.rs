//! Products of vectors.

/// Scalar product a·b.
#[must_use]
pub fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(&b).map(|(a, b)| a * b).sum()
}

/// Length |v| of a vector.
#[must_use]
pub fn length<const N: usize>(v: [f64; N]) -> f64 {
    dot(v, v).sqrt()
}

/// Cross product a × b.
#[must_use]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
