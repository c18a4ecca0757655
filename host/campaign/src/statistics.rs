//! Means and shares with 95 % intervals.
//!
//! ```text
//! mean    x̄ ± t·s/√n                                                  (Student)
//! share   (p + z²/2n ± z·√(p(1 − p)/n + z²/4n²)) / (1 + z²/n)          (Wilson, J. Am. Stat. Assoc. 22, 1927)
//! ```
//!
//! t is the 0.975 quantile of Student's distribution with n − 1 degrees of freedom, z that of the normal distribution.

/// The 0.975 quantile of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;
/// Those of Student's distribution with 1 to 10 degrees of freedom.
const STUDENT: [f64; 10] = [
    12.706_205, 4.302_653, 3.182_446, 2.776_445, 2.570_582, 2.446_912, 2.364_624, 2.306_004, 2.262_157,
    2.228_139,
];

/// An estimate over several runs.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Runs that have the figure.
    pub count: usize,
    /// Mean, or share.
    pub mean: f64,
    /// Lower end of the interval; null with a single value.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

/// The 0.975 quantile of Student's distribution: beyond ten degrees of freedom ν by Abramowitz and Stegun, 26.7.5, off by less than
/// 10⁻⁵.
fn student(freedom: usize) -> f64 {
    if let Some(value) = freedom.checked_sub(1).and_then(|at| STUDENT.get(at)) {
        return *value;
    }
    let (z, v) = (Z, freedom as f64);
    let terms = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
        (79.0 * z.powi(9) + 776.0 * z.powi(7) + 1482.0 * z.powi(5) - 1920.0 * z.powi(3) - 945.0 * z)
            / 92_160.0,
    ];
    terms.iter().zip(1..).fold(z, |sum, (term, power)| sum + term / v.powi(power))
}

/// Of numbers; `None` if there are none. All 0 or 1 where `is_share`.
#[must_use]
pub fn estimate(values: &[f64], is_share: bool) -> Option<Estimate> {
    let count = values.len();
    if count == 0 {
        return None;
    }
    let n = count as f64;
    let mean = values.iter().sum::<f64>() / n;
    let interval = if is_share {
        let (centre, scale) = ((mean + Z * Z / (2.0 * n)), 1.0 + Z * Z / n);
        let half = Z * (mean * (1.0 - mean) / n + Z * Z / (4.0 * n * n)).sqrt();
        Some(((centre - half) / scale, (centre + half) / scale))
    } else if count > 1 {
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let half = student(count - 1) * (variance / n).sqrt();
        Some((mean - half, mean + half))
    } else {
        None
    };
    Some(Estimate {
        count,
        mean,
        low: interval.map(|ends| ends.0),
        high: interval.map(|ends| ends.1),
        least: values.iter().copied().fold(f64::INFINITY, f64::min),
        greatest: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // scipy.stats.t.ppf(0.975, ν).
        for (freedom, known) in [
            (1, 12.706_204_7),
            (4, 2.776_445_1),
            (10, 2.228_138_9),
            (11, 2.200_985_2),
            (19, 2.093_024_1),
            (30, 2.042_272_5),
            (1000, 1.962_339_1),
        ] {
            assert!((student(freedom) - known).abs() < 1e-5, "{freedom}: {}", student(freedom));
        }
    }

    #[test]
    fn intervals_are_those_of_textbooks() {
        let found = estimate(&[1.0, 2.0, 3.0, 4.0], false).expect("values");
        // Standard deviation 1.2910, over two: 0.6455 times 3.1824.
        assert!(
            (found.mean - 2.5).abs() < 1e-12 && (found.high.expect("several") - 4.5543).abs() < 1e-4,
            "{found:?}"
        );
        // statsmodels.stats.proportion.proportion_confint(18, 20, method="wilson").
        let values: Vec<f64> = (0..20).map(|k| f64::from(u8::from(k < 18))).collect();
        let found = estimate(&values, true).expect("values");
        let (low, high) = (found.low.expect("a share"), found.high.expect("a share"));
        assert!((low - 0.698_97).abs() < 1e-4 && (high - 0.972_1).abs() < 1e-4, "{found:?}");
        assert_eq!(estimate(&[], false), None);
        assert_eq!(estimate(&[3.0], false).expect("one").low, None);
    }
}
