//! The cycles as poses show them that are older than their stamp by one delay: three in a row for each step of the filter.

use std::collections::VecDeque;

use quantity::wrap_rad;

use super::Found;
use super::means::Means;
use super::regression::Regression;

/// (h3).
const WEIGHTS: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
/// What the likelihood of the cycles before counts in a cycle. *Assumed*: a minute is remembered.
const KEPT: f64 = 0.98;

/// One cycle with what it tells.
#[derive(Clone, Debug)]
struct Window {
    start_s: f64,
    /// Mean over the interval of what each module gives of law (2): N, N, N·m in S.
    given: Vec<[f64; 3]>,
    about_rad: f64,
    /// (x, y, Θ), m and rad; Θ without what the rotors' own turning does.
    mean: Option<[f64; 3]>,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(super) struct Late {
    delay_s: f64,
    /// At most two with means that are still of use, and those whose poses have not all come.
    windows: VecDeque<Window>,
    regression: Regression,
    /// Logarithm, of the last cycles.
    likelihood: f64,
}

impl Late {
    pub(super) fn new(delay_s: f64, regression: Regression) -> Self {
        Self { delay_s, windows: VecDeque::new(), regression, likelihood: 0.0 }
    }

    pub(super) fn forget_cycles(&mut self) {
        self.windows.clear();
    }

    pub(super) fn swum(&mut self, start_s: f64, given: &[[f64; 3]], about_rad: f64) {
        self.windows.push_back(Window { start_s, given: given.to_vec(), about_rad, mean: None });
    }

    pub(super) fn likelihood(&self) -> f64 {
        self.likelihood
    }

    pub(super) fn munk(&self) -> Found {
        self.regression.munk()
    }

    pub(super) fn relative(&self) -> impl Iterator<Item = Found> + '_ {
        self.regression.relative()
    }

    /// Learns of the cycles whose poses have all come.
    pub(super) fn look(&mut self, means: &Means, period_s: f64) {
        while let Some(window) = self.windows.iter_mut().find(|window| window.mean.is_none()) {
            let start_s = window.start_s + self.delay_s;
            if means.newest_s() < start_s + period_s {
                return;
            }
            let Some(mut mean) = means.over(start_s, start_s + period_s) else {
                self.forget_cycles();
                return;
            };
            // Θ + J/I·Σφ turns by what is from outside alone.
            mean[2] += self.regression.rotor_share() * window.about_rad;
            window.mean = Some(mean);
            self.learn();
        }
    }

    /// Takes in the three newest means, once there are as many.
    fn learn(&mut self) {
        let mut windows = self.windows.iter().filter_map(|window| window.mean.map(|mean| (window, mean)));
        let (Some(first), Some(middle), Some(last)) = (windows.next(), windows.next(), windows.next()) else {
            return;
        };
        let poses = [first.1, middle.1, last.1];
        let [first, middle, last] = [first.0, middle.0, last.0];
        let [before_s, after_s] = [middle.start_s - first.start_s, last.start_s - middle.start_s];
        // a = 2·[(p̄₃ − p̄₂)/h₂ − (p̄₂ − p̄₁)/h₁]/(h₁ + h₂),     v = (p̄₃ − p̄₁)/(h₁ + h₂)           (h1)
        let step = |axis: usize, from: usize, to: usize| {
            let difference = poses[to][axis] - poses[from][axis];
            if axis == 2 { wrap_rad(difference) } else { difference }
        };
        let whole_s = before_s + after_s;
        let acceleration =
            [0, 1, 2].map(|axis| 2.0 * (step(axis, 1, 2) / after_s - step(axis, 0, 1) / before_s) / whole_s);
        let rate = [0, 1, 2].map(|axis| (step(axis, 0, 1) + step(axis, 1, 2)) / whole_s);
        // fᵢ = ⅙·fᵢ(1) + ⅔·fᵢ(2) + ⅙·fᵢ(3)                                                       (h3)
        let turned_rad = [-step(2, 0, 1), 0.0, step(2, 1, 2)];
        let mut given = vec![[0.0; 3]; middle.given.len()];
        for ((window, weight), turned_rad) in [first, middle, last].into_iter().zip(WEIGHTS).zip(turned_rad) {
            let (sin, cos) = turned_rad.sin_cos();
            for (sum, [x_n, y_n, tau_nm]) in given.iter_mut().zip(&window.given) {
                sum[0] += weight * (x_n * cos - y_n * sin);
                sum[1] += weight * (x_n * sin + y_n * cos);
                sum[2] += weight * tau_nm;
            }
        }
        let likelihood = self.regression.learn(poses[1][2], rate, acceleration, &given, after_s);
        self.likelihood = KEPT * self.likelihood + likelihood;
        self.windows.pop_front();
    }
}
