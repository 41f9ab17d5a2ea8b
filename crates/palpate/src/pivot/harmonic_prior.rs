//! What is believed of the harmonics of a shape before it is felt: from the second on they fall as a power of their number, which the readings tell
//! themselves by the evidence (MacKay, *Bayesian interpolation*, 1992). Harmonics that no reading resolves belong to the error bars by as much.

use nalgebra::{DMatrix, DVector};

/// The slowest decay: support functions with kinks, of rounded polygons.
const SLOWEST_DECAY: f64 = 2.0;

/// Decays that are compared; beyond the last one no harmonic is left after the third.
const DECAYS: [f64; 5] = [SLOWEST_DECAY, 3.0, 4.0, 5.0, 6.0];

/// Limits of the spread of the harmonics, as shares of the size: that of the second one is a quarter of it.
const SPREAD: [f64; 2] = [0.02, 2.0];

/// Rounds of the scale of one decay at most, …
const ROUNDS: usize = 10;

/// … which has settled when it changes by less than this share.
const SETTLED: f64 = 0.05;

/// Prior of the harmonics: that of number k ≥ 2 has the standard deviation scale/k^decay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HarmonicPrior {
    pub scale_m: f64,
    pub decay: f64,
}

/// Normal equations of coefficients and open constants near a state: information without the prior of the coefficients, a rotation held, and the gradient
/// where all unknowns are where their prior has them.
#[derive(Clone, Debug)]
pub(super) struct NormalEquations {
    pub information: DMatrix<f64>,
    pub gradient: DVector<f64>,
}

impl HarmonicPrior {
    /// With the slowest decay.
    pub fn of_scale(scale_m: f64) -> Self {
        Self { scale_m, decay: SLOWEST_DECAY }
    }

    /// Prior standard deviations of (a₀, a₁ … a_K, b₁ … b_K): ten sizes, a size for the first harmonic (where the pivot is), scale/k^decay.
    pub fn sds(self, order: usize, size_m: f64) -> Vec<f64> {
        let of = |k: usize| if k == 1 { size_m } else { self.scale_m / self.falls(k) };
        let of_one: Vec<f64> = (1..=order).map(of).collect();
        [&[10.0 * size_m], &of_one[..], &of_one[..]].concat()
    }

    /// The same decay with the likeliest scale: the mean square of the harmonics from the second on over what they fall by, with what is not known of them.
    pub fn rescaled(self, coefficients: &[f64], covariance: &DMatrix<f64>, size_m: f64) -> Self {
        let order = coefficients.len() / 2;
        if order < 2 {
            return self;
        }
        let square =
            |k: usize, index: usize| self.falls(k).powi(2) * (coefficients[index].powi(2) + covariance[(index, index)]);
        let sum: f64 = (2..=order).map(|k| square(k, k) + square(k, order + k)).sum();
        let [low, high] = SPREAD.map(|share| share * size_m * self.falls(2) / Self::of_scale(size_m).falls(2));
        Self { scale_m: (sum / (2 * (order - 1)) as f64).sqrt().clamp(low, high), ..self }
    }

    /// The likeliest decay and scale by what readings tell of so many harmonics, with these normal equations.
    pub fn likeliest(equations: &NormalEquations, order: usize, size_m: f64) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        let mut prior = Self::of_scale(size_m);
        for decay in DECAYS {
            // The scale at which the third harmonic stays what it was.
            prior = Self { scale_m: prior.scale_m * 3f64.powf(decay - prior.decay), decay };
            for _ in 0..ROUNDS {
                let (coefficients, covariance, _) = prior.posterior(equations, order, size_m)?;
                let next = prior.rescaled(&coefficients, &covariance, size_m);
                let change = (next.scale_m / prior.scale_m).ln().abs();
                prior = next;
                if change < SETTLED {
                    break;
                }
            }
            let (_, _, log_evidence) = prior.posterior(equations, order, size_m)?;
            if best.is_none_or(|(most, _)| log_evidence > most) {
                best = Some((log_evidence, prior));
            }
        }
        best.map(|(_, prior)| prior)
    }

    /// Coefficients, covariance of all unknowns, and ln of the evidence up to a constant of the readings.
    fn posterior(
        self,
        equations: &NormalEquations,
        order: usize,
        size_m: f64,
    ) -> Option<(Vec<f64>, DMatrix<f64>, f64)> {
        let sds = self.sds(order, size_m);
        let mut information = equations.information.clone();
        for (index, sd) in sds.iter().enumerate() {
            information[(index, index)] += 1.0 / (sd * sd);
        }
        let factor = information.cholesky()?;
        let mean = -factor.solve(&equations.gradient);
        let half_ln_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
        let prior: f64 = sds.iter().map(|sd| sd.ln()).sum();
        let log_evidence = -0.5 * equations.gradient.dot(&mean) - half_ln_determinant - prior;
        let coefficients = mean.as_slice()[..sds.len()].to_vec();
        log_evidence.is_finite().then(|| (coefficients, factor.inverse(), log_evidence))
    }

    /// k^decay.
    fn falls(self, k: usize) -> f64 {
        (k as f64).powf(self.decay)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// Coefficients of so many harmonics drawn from a prior, each told with this standard deviation.
    fn told(prior: HarmonicPrior, order: usize, sd_m: f64, seed: u64) -> NormalEquations {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
        let values: Vec<f64> = prior.sds(order, 0.03).iter().map(|sd| normal(*sd) + normal(sd_m)).collect();
        let information = DMatrix::from_diagonal_element(values.len(), values.len(), 1.0 / (sd_m * sd_m));
        NormalEquations { gradient: -&information * DVector::from_vec(values), information }
    }

    #[test]
    fn the_decay_of_drawn_harmonics_is_found() {
        for decay in [2.0, 4.0] {
            let drawn = HarmonicPrior { scale_m: 0.01, decay };
            let found =
                (0..20).map(|seed| HarmonicPrior::likeliest(&told(drawn, 12, 1e-7, seed), 12, 0.03).expect("one"));
            let close = found.filter(|found| (found.decay - decay).abs() < 0.5).count();
            assert!(close >= 16, "{close} of 20 at {decay}");
        }
    }

    /// Without readings the evidence is the same whatever the prior, and a scale stays within its limits.
    #[test]
    fn what_no_reading_tells_has_no_scale() {
        let nothing = NormalEquations { information: DMatrix::zeros(9, 9), gradient: DVector::zeros(9) };
        let found = HarmonicPrior::likeliest(&nothing, 4, 0.03).expect("one");
        assert!((0.02 * 0.03..=2.0 * 0.03).contains(&found.scale_m) && found.decay == SLOWEST_DECAY, "{found:?}");
    }
}
