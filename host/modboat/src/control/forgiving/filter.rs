//! A Kalman filter of one motion: position, velocity, unknown acceleration of each axis, and how far thrust and drag differ from
//! what is believed.
//!
//! ```text
//! x = (p, v, d, k…),   ṗ = v,   v̇ = Σ k·u + d                                                      (f1)
//! Φ(t): sensitivity of the prediction to x at the last correction;  C = mean of Φ's rows of p over the window
//! K = P Cᵀ/(C P Cᵀ + r),   x ← x + Φ K e,   P ← Φ (P − K C P) Φᵀ + Q                              (f2)
//! ```
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | u | m/s² or rad/s² | accelerations that are believed: of the thrust, of the drag, of the Munk moment |
//! | k | – | what each is over what is believed |
//! | e | m or rad | mean of measured less predicted positions over the window |
//! | r | m² or rad² | variance of that mean |
//!
//! An innovation belongs to the state at the beginning of its window: what changed since counts from the next on, so that one
//! correction needs one window, and nothing of the window is used twice.

/// `A` axes and N = 3A + K states, K factors.
#[derive(Clone, Debug)]
pub(super) struct Filter<const A: usize, const N: usize> {
    /// P.
    covariance: [[f64; N]; N],
    /// Φ.
    sensitivity: [[f64; N]; N],
}

/// What a step of the prediction needs of the model.
pub(super) struct Slope<const A: usize, const K: usize> {
    /// −∂v̇/∂v, 1/s.
    pub drag_1_s: [[f64; A]; A],
    /// −∂v̇/∂p, of each axis by itself, 1/s².
    pub spring_1_s2: [f64; A],
    /// u of each factor.
    pub factors: [[f64; A]; K],
}

fn unit<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { 1.0 } else { 0.0 }))
}

impl<const A: usize, const N: usize> Filter<A, N> {
    /// With standard deviations of the states.
    pub(super) fn new(deviations: [f64; N]) -> Self {
        let mut covariance = unit();
        (0..N).for_each(|state| covariance[state][state] = deviations[state].powi(2));
        Self { covariance, sensitivity: unit() }
    }

    /// The variance of a state grows; `most` is where it stops.
    pub(super) fn loosen(&mut self, state: usize, variance: f64, most: f64) {
        let now = self.covariance[state][state];
        self.covariance[state][state] = now.max((now + variance).min(most));
    }

    /// Standard deviation of a state.
    pub(super) fn deviation(&self, state: usize) -> f64 {
        self.covariance[state][state].max(0.0).sqrt()
    }

    /// Φ over one step of the prediction.
    pub(super) fn step<const K: usize>(&mut self, dt_s: f64, slope: &Slope<A, K>) {
        const { assert!(N == 3 * A + K, "position, velocity, unknown of each axis, and the factors") };
        for column in 0..N {
            let mut change = [0.0; A];
            for (axis, change) in change.iter_mut().enumerate() {
                for other in 0..A {
                    *change -= slope.drag_1_s[axis][other] * self.sensitivity[A + other][column];
                }
                let mut push = self.sensitivity[2 * A + axis][column];
                for (factor, u) in slope.factors.iter().enumerate() {
                    push += u[axis] * self.sensitivity[3 * A + factor][column];
                }
                *change += push - slope.spring_1_s2[axis] * self.sensitivity[axis][column];
            }
            for (axis, change) in change.into_iter().enumerate() {
                let velocity = self.sensitivity[A + axis][column];
                self.sensitivity[axis][column] += dt_s * (velocity + 0.5 * dt_s * change);
                self.sensitivity[A + axis][column] += dt_s * change;
            }
        }
    }

    /// Rows of Φ for the positions.
    pub(super) fn rows(&self) -> [[f64; N]; A] {
        std::array::from_fn(|axis| self.sensitivity[axis])
    }

    /// Variance of an innovation, C P Cᵀ + r.
    pub(super) fn spread(&self, row: &[f64; N], variance: f64) -> f64 {
        let p: [f64; N] = std::array::from_fn(|state| dot(&self.covariance[state], row));
        dot(&p, row) + variance
    }

    /// (f2) but for Q: what to add to the states. `rows` are C.
    pub(super) fn correct(&mut self, rows: &[[f64; N]; A], errors: [f64; A], variance: f64) -> [f64; N] {
        let mut change = [0.0; N];
        for (row, error) in rows.iter().zip(errors) {
            let p: [f64; N] = std::array::from_fn(|state| dot(&self.covariance[state], row));
            let spread = dot(&p, row) + variance;
            let rest = error - dot(row, &change);
            for (state, gain) in p.iter().map(|p| p / spread).enumerate() {
                change[state] += gain * rest;
                (0..N).for_each(|other| self.covariance[state][other] -= gain * p[other]);
            }
        }
        self.carry();
        let moved = std::array::from_fn(|state| dot(&self.sensitivity[state], &change));
        self.sensitivity = unit();
        moved
    }

    /// P ← Φ P Φᵀ, kept symmetric.
    fn carry(&mut self) {
        let half: [[f64; N]; N] = std::array::from_fn(|row| {
            std::array::from_fn(|column| dot(&self.sensitivity[row], &self.covariance[column]))
        });
        let whole: [[f64; N]; N] = std::array::from_fn(|row| {
            std::array::from_fn(|column| dot(&half[row], &self.sensitivity[column]))
        });
        self.covariance = std::array::from_fn(|row| {
            std::array::from_fn(|column| 0.5 * (whole[row][column] + whole[column][row]))
        });
    }
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
