//! Values and rates of a noisy signal by local polynomials: around each time a polynomial of degree 5 is fitted to the samples
//! nearby (Savitzky & Golay, *Analytical Chemistry* 36, 1964; here for any sample times). The window is as wide as
//! cross-validation likes it: wide over noise, seven samples where there is none, so that the rate of a smooth signal is
//! exact to the fifth order of the step.

use nalgebra::{SMatrix, SVector};

/// Coefficients of a local polynomial.
const TERMS: usize = 6;

/// Samples on either side of the middle one that are tried.
const HALF_WIDTHS: [usize; 11] = [3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96];

/// Fewest samples that can be smoothed.
pub(crate) const FEWEST: usize = 2 * HALF_WIDTHS[0] + 1;

/// Samples at which the windows are tried out.
const TRIALS: usize = 300;

/// Among windows that predict about equally well (mean square within this factor of the best) the widest gives the best rates.
const ABOUT_EQUAL: f64 = 1.03;

/// A signal with its window.
#[derive(Clone, Debug)]
pub(crate) struct Smoothing<'a> {
    times_s: &'a [f64],
    values: &'a [f64],
    half_width: usize,
}

impl<'a> Smoothing<'a> {
    /// `times_s` increase. `None` with fewer than [`FEWEST`] samples.
    pub fn new(times_s: &'a [f64], values: &'a [f64]) -> Option<Self> {
        if times_s.len() < FEWEST || values.len() != times_s.len() {
            return None;
        }
        let stride = times_s.len().div_ceil(TRIALS);
        let scores: Vec<(usize, f64)> = HALF_WIDTHS
            .into_iter()
            .filter(|half_width| 2 * half_width < times_s.len())
            .filter_map(|half_width| {
                let smoothing = Self { times_s, values, half_width };
                let missed: Vec<f64> =
                    (0..times_s.len()).step_by(stride).filter_map(|index| smoothing.missed(index)).collect();
                let score = missed.iter().map(|miss| miss * miss).sum::<f64>() / missed.len() as f64;
                score.is_finite().then_some((half_width, score))
            })
            .collect();
        let best = scores.iter().map(|(_, score)| *score).fold(f64::INFINITY, f64::min);
        let (half_width, _) = *scores.iter().rfind(|(_, score)| *score <= ABOUT_EQUAL * best)?;
        Some(Self { times_s, values, half_width })
    }

    /// Value and rate (per second) at a time.
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        let after = self.times_s.partition_point(|time| *time < time_s).min(self.times_s.len() - 1);
        let nearest = if after > 0 && time_s - self.times_s[after - 1] < self.times_s[after] - time_s {
            after - 1
        } else {
            after
        };
        let window = self.window(nearest);
        let fallback = (self.values[nearest], 0.0);
        let Some((coefficients, _)) = self.polynomial(&window, time_s) else { return fallback };
        // Legendre polynomials and their derivatives in the middle: P2(0) = −1/2, P4(0) = 3/8, P1'(0) = 1, P3'(0) = −3/2,
        // P5'(0) = 15/8.
        let value = coefficients[0] - 0.5 * coefficients[2] + 0.375 * coefficients[4];
        let rate = (coefficients[1] - 1.5 * coefficients[3] + 1.875 * coefficients[5]) / self.reach_s(&window, time_s);
        if value.is_finite() && rate.is_finite() { (value, rate) } else { fallback }
    }

    /// By how much the others miss a sample when it is left out.
    fn missed(&self, index: usize) -> Option<f64> {
        let window = self.window(index);
        let (coefficients, inverse) = self.polynomial(&window, self.times_s[index])?;
        let row = legendre(0.0);
        let leverage = (row.transpose() * inverse * row)[0];
        Some((self.values[index] - row.dot(&coefficients)) / (1.0 - leverage).max(1e-9))
    }

    /// The samples nearest to one, always as many.
    fn window(&self, middle: usize) -> std::ops::Range<usize> {
        let width = 2 * self.half_width + 1;
        let start = middle.saturating_sub(self.half_width).min(self.times_s.len() - width);
        start..start + width
    }

    /// The largest distance of a sample of the window from `time_s`.
    fn reach_s(&self, window: &std::ops::Range<usize>, time_s: f64) -> f64 {
        let (first, last) = (self.times_s[window.start], self.times_s[window.end - 1]);
        (time_s - first).abs().max((last - time_s).abs()).max(f64::MIN_POSITIVE)
    }

    /// Least squares over the window: coefficients of Legendre polynomials about `time_s`, and the inverse normal matrix.
    fn polynomial(
        &self,
        window: &std::ops::Range<usize>,
        time_s: f64,
    ) -> Option<(SVector<f64, TERMS>, SMatrix<f64, TERMS, TERMS>)> {
        let reach = self.reach_s(window, time_s);
        let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
        let mut right = SVector::<f64, TERMS>::zeros();
        // Values relative to one of them lose no digits.
        let origin = self.values[window.start];
        for index in window.clone() {
            let row = legendre((self.times_s[index] - time_s) / reach);
            normal += row * row.transpose();
            right += row * (self.values[index] - origin);
        }
        let inverse = normal.cholesky()?.inverse();
        let mut coefficients = inverse * right;
        coefficients[0] += origin;
        Some((coefficients, inverse))
    }
}

/// P0 … P5.
fn legendre(u: f64) -> SVector<f64, TERMS> {
    let u2 = u * u;
    SVector::from([
        1.0,
        u,
        1.5 * u2 - 0.5,
        u * (2.5 * u2 - 1.5),
        4.375 * u2 * u2 - 3.75 * u2 + 0.375,
        u * (7.875 * u2 * u2 - 8.75 * u2 + 1.875),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    fn sampled(count: usize, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let times: Vec<f64> = (0..count).map(|i| 6.0 * i as f64 / (count - 1) as f64).collect();
        let values = times.iter().map(|t| t.sin() + noise * rng.sample::<f64, _>(StandardNormal)).collect();
        (times, values)
    }

    fn worst_rate(count: usize, noise: f64) -> f64 {
        let (times, values) = sampled(count, noise);
        let smoothing = Smoothing::new(&times, &values).expect("enough samples");
        times.iter().map(|&t| (smoothing.at(t).1 - t.cos()).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn rates_of_a_smooth_signal_are_of_fifth_order_up_to_its_ends() {
        let errors = [31, 61, 121].map(|count| worst_rate(count, 0.0));
        for pair in errors.windows(2) {
            assert!(((pair[0] / pair[1]).log2() - 5.0).abs() < 0.5, "{errors:?}");
        }
    }

    #[test]
    fn a_polynomial_of_fifth_degree_is_reproduced_at_uneven_times() {
        let times: Vec<f64> = (0..40).map(|i| 0.05 * i as f64 + 0.015 * (i as f64 * 1.7).sin()).collect();
        let values: Vec<f64> = times.iter().map(|t| t.powi(5) - 3.0 * t.powi(3) + t).collect();
        let smoothing = Smoothing::new(&times, &values).expect("enough samples");
        for t in [0.0, 0.123, 0.9, 1.95] {
            let (value, rate) = smoothing.at(t);
            assert!((value - (t.powi(5) - 3.0 * t.powi(3) + t)).abs() < 1e-8);
            assert!((rate - (5.0 * t.powi(4) - 9.0 * t * t + 1.0)).abs() < 1e-6);
        }
    }

    #[test]
    fn noise_is_smoothed_far_below_finite_differences() {
        // A difference of neighbours would be off by 0.01 √2 / 0.006 ≈ 2.4.
        assert!(worst_rate(1001, 0.01) < 0.15, "{}", worst_rate(1001, 0.01));
    }

    #[test]
    fn too_few_samples_are_refused() {
        let times: Vec<f64> = (0..FEWEST - 1).map(|i| i as f64).collect();
        assert!(Smoothing::new(&times, &times).is_none());
    }
}
