//! Mean, median, spread and autocorrelation.

/// The root of the mean of the squares; 0 of no value.
pub(crate) fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Median; 0 for an empty list.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// 1/Φ⁻¹(3/4): the standard deviation of Gaussian errors over the median of their sizes.
const OVER_MEDIAN: f64 = 1.482_602_218_505_602;

/// The standard deviation that most errors have, whatever the largest are; 0 for an empty list.
pub(crate) fn typical_sd<'a>(errors: impl Iterator<Item = &'a f64>) -> f64 {
    let mut sizes: Vec<f64> = errors.map(|error| error.abs()).collect();
    OVER_MEDIAN * median(&mut sizes)
}

/// Lags up to which autocorrelations are summed, over the time that they sum up to.
const WINDOW: f64 = 5.0;

/// By how much the errors of neighbouring samples hang together: the integrated autocorrelation time of the residuals of
/// one sensor, in samples; 1 for white noise. `N` correlated samples tell as much as `N`/τ independent ones.
pub(crate) fn correlation_time(residuals: &[f64]) -> f64 {
    correlation_time_up_to(residuals, f64::INFINITY)
}

/// The same where it is no longer than this, else something longer: of a long log of which little is explained the whole takes a while.
pub(crate) fn correlation_time_up_to(residuals: &[f64], longest: f64) -> f64 {
    let count = residuals.len();
    let variance: f64 = residuals.iter().map(|e| e * e).sum();
    if count < 16 || variance <= 0.0 {
        return 1.0;
    }
    let mut tau = 1.0;
    for lag in 1..count / 4 {
        let products: f64 = residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum();
        tau += 2.0 * products / variance;
        // Sokal's window: stop once the lag is well beyond the time found so far.
        if lag as f64 >= WINDOW * tau.min(longest) {
            break;
        }
    }
    tau.max(1.0)
}

/// Autocorrelation of errors at a lag, in samples; 0 where there are too few.
pub(crate) fn autocorrelation(residuals: &[f64], lag: usize) -> f64 {
    let variance: f64 = residuals.iter().map(|e| e * e).sum();
    if lag >= residuals.len() || variance <= 0.0 {
        return 0.0;
    }
    residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum::<f64>() / variance
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    fn normal(seed: u64, count: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| rng.sample(StandardNormal)).collect()
    }

    #[test]
    fn a_time_that_is_too_long_is_not_looked_for_to_its_end() {
        let slow: Vec<f64> = (0..4000).map(|sample| (sample as f64 / 300.0).sin()).collect();
        let longer = correlation_time_up_to(&slow, 15.0);
        assert!(longer > 15.0 && longer < 200.0, "{longer}");
        let white = normal(1, 2000);
        assert_eq!(correlation_time_up_to(&white, 15.0), correlation_time(&white));
    }

    #[test]
    fn white_noise_is_uncorrelated() {
        let times: Vec<f64> = (0..20).map(|seed| correlation_time(&normal(seed, 2000))).collect();
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        assert!((0.97..1.1).contains(&mean) && times.iter().all(|time| *time < 1.4), "{times:?}");
    }

    #[test]
    fn the_memory_of_an_autoregressive_process_is_found() {
        // e_i = ρ e_{i−1} + white noise has the integrated correlation time (1 + ρ)/(1 − ρ).
        for rho in [0.5, 0.8] {
            let times: Vec<f64> = (0..20)
                .map(|seed| {
                    let mut state = 0.0;
                    let process = normal(100 + seed, 6000).into_iter().map(|white| {
                        state = rho * state + white;
                        state
                    });
                    correlation_time(&process.collect::<Vec<f64>>())
                })
                .collect();
            let mean = times.iter().sum::<f64>() / times.len() as f64;
            let expected = (1.0 + rho) / (1.0 - rho);
            assert!((mean / expected - 1.0).abs() < 0.1, "{mean} for {expected}");
        }
    }

    #[test]
    fn errors_are_correlated_by_the_lag_of_their_period() {
        let waves: Vec<f64> = (0..8000).map(|sample| (std::f64::consts::TAU * f64::from(sample) / 8.0).sin()).collect();
        for (lag, expected) in [(0, 1.0), (2, 0.0), (4, -1.0), (8, 1.0)] {
            assert!((autocorrelation(&waves, lag) - expected).abs() < 2e-3, "lag {lag}");
        }
        assert_eq!(autocorrelation(&waves, 8000), 0.0);
        assert_eq!(autocorrelation(&[0.0; 10], 1), 0.0);
    }

    #[test]
    fn the_typical_standard_deviation_is_that_of_gaussian_errors_and_heeds_no_outlier() {
        // Φ⁻¹ of 0.55, 0.65, 0.75, 0.85 and 0.95, both ways.
        let quantiles = [0.125_661, 0.385_320, 0.674_490, 1.036_433, 1.644_854];
        let mut errors: Vec<f64> = quantiles.iter().flat_map(|quantile| [2.0 * quantile, -2.0 * quantile]).collect();
        let typical = typical_sd(errors.iter());
        assert!((typical - 2.0).abs() < 1e-5, "{typical}");
        errors[9] = 1e9;
        assert_eq!(typical_sd(errors.iter()), typical);
        assert_eq!(typical_sd([].iter()), 0.0);
    }

    #[test]
    fn too_few_residuals_or_none_left_count_as_white() {
        assert_eq!(correlation_time(&[1.0; 10]), 1.0);
        assert_eq!(correlation_time(&[0.0; 100]), 1.0);
    }

    #[test]
    fn the_median_of_nothing_is_nothing() {
        assert_eq!(median(&mut []), 0.0);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
    }
}
