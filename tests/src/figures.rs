//! Quantiles for the tables that tests print.

/// Least, median, 99th percentile and greatest of some values; NaN without any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// The least.
    pub least: f64,
    /// The median.
    pub median: f64,
    /// 99 % are at most this.
    pub p99: f64,
    /// The greatest.
    pub most: f64,
}

impl Quantiles {
    /// Of `values`, in any order; nearest rank.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * values.len() as f64).ceil() as usize;
            values.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN)
        };
        Self { least: at(0.0), median: at(0.5), p99: at(0.99), most: at(1.0) }
    }
}

/// Mean of some values; NaN without any.
#[must_use]
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_one_to_two_hundred() {
        let q = Quantiles::of((1..=200).rev().map(f64::from));
        let found = [q.least, q.median, q.p99, q.most].map(|value| value as u32);
        assert_eq!(found, [1, 100, 198, 200]);
        assert!(Quantiles::of([]).median.is_nan());
        assert!((mean([1.0, 2.0, 6.0]) - 3.0).abs() < 1e-15);
    }
}
