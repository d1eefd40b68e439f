//! The statistics that sampling tests share. All seeds are fixed, so a verdict never changes.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Significance of a whole test; each of its `comparisons` gets its share (Šidák 1967).
pub const SIGNIFICANCE: f64 = 0.01;

/// Fewest counts expected in a bin, below which Pearson's statistic is not yet chi-squared.
const EXPECTED_MIN: f64 = 5.0;

/// Pearson's chi-square test of counts; bins that expect too little are pooled. The probability of
/// counts at least as odd.
pub fn chi_square_p(observed: &[f64], expected: &[f64]) -> f64 {
    let mut bins: Vec<_> = expected.iter().zip(observed).collect();
    bins.sort_by(|a, b| a.0.total_cmp(b.0));
    let (mut statistic, mut degrees) = (0.0, -1.0);
    let (mut pooled_expected, mut pooled_observed) = (0.0, 0.0);
    for (&expected, &observed) in bins {
        if expected == 0.0 {
            if observed > 0.0 {
                return 0.0; // what cannot be has been
            }
            continue;
        }
        pooled_expected += expected;
        pooled_observed += observed;
        if pooled_expected >= EXPECTED_MIN {
            statistic += (pooled_observed - pooled_expected).powi(2) / pooled_expected;
            degrees += 1.0;
            (pooled_expected, pooled_observed) = (0.0, 0.0);
        }
    }
    if degrees < 1.0 {
        return 1.0;
    }
    1.0 - ChiSquared::new(degrees).unwrap().cdf(statistic)
}

/// Asserts that numbers in [0, 1) are uniform, in `bins` equal bins.
pub fn assert_uniform(
    what: &str,
    values: impl IntoIterator<Item = f64>,
    bins: usize,
    comparisons: u32,
) {
    let mut observed = vec![0.0; bins];
    let mut count = 0.0;
    for value in values {
        assert!(
            (0.0..=1.0).contains(&value),
            "{what}: {value} is not in [0, 1]"
        );
        observed[((value * bins as f64) as usize).min(bins - 1)] += 1.0;
        count += 1.0;
    }
    let p = chi_square_p(&observed, &vec![count / bins as f64; bins]);
    assert_p(what, p, comparisons);
}

/// Asserts a p-value against the significance shared among `comparisons`.
pub fn assert_p(what: &str, p: f64, comparisons: u32) {
    let level = 1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / f64::from(comparisons));
    assert!(p > level, "{what}: p = {p:.3e}, the level is {level:.3e}");
}
