//! Errors of a sensor with a memory: neighbouring samples share them, so that what neighbours differ by ([`super::noise_from_log`]) shows only a part. How
//! much it hides, the residuals of a fit tell by their autocorrelation (`docs/theory.md`, what the log says of itself).

use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::residuals;
use crate::math::statistics::{autocorrelation, correlation_time, correlation_time_up_to};

/// Longest correlation time of the errors, in samples, that is taken for the memory of a sensor: what a wrong shape or motion leaves keeps
/// its sign over a whole feature of the boundary.
const SENSOR_MEMORY: f64 = 15.0;

/// Least share of the variance that third differences of errors with such a memory show.
const LEAST_SHOWN: f64 = 0.05;

/// How many times larger the errors of a sensor are than third differences of neighbouring readings show, by what the fit leaves.
pub(crate) fn hidden_from_neighbours(residuals_m: &[f64]) -> f64 {
    if correlation_time_up_to(residuals_m, SENSOR_MEMORY) > SENSOR_MEMORY {
        return 1.0;
    }
    let [one, two, three] = [1, 2, 3].map(|lag| autocorrelation(residuals_m, lag));
    let shown = (20.0 - 30.0 * one + 12.0 * two - 2.0 * three) / 20.0;
    1.0 / shown.clamp(LEAST_SHOWN, 1.0).sqrt()
}

/// The same of both sensors by what a fit leaves, whichever hides less.
pub(crate) fn hidden_from_neighbours_by(measurements: &Measurements, coefficients: &[f64], psi: &[f64]) -> f64 {
    let of_sensors = left_by(measurements, coefficients, psi);
    of_sensors.map(|of_sensor| hidden_from_neighbours(&of_sensor)).into_iter().fold(f64::INFINITY, f64::min)
}

/// Samples that share an error, by what a fit leaves: so many tell as much as one.
pub(crate) fn samples_per_error_by(measurements: &Measurements, coefficients: &[f64], psi: &[f64]) -> f64 {
    0.5 * left_by(measurements, coefficients, psi).map(|of_sensor| correlation_time(&of_sensor)).iter().sum::<f64>()
}

/// What a fit leaves of the readings of each sensor, metres.
fn left_by(measurements: &Measurements, coefficients: &[f64], psi: &[f64]) -> [Vec<f64>; 2] {
    let left =
        measurements.instants.iter().zip(psi).map(|(instant, psi)| contact_residuals_m(instant, coefficients, *psi));
    let (first, second): (Vec<Option<f64>>, Vec<Option<f64>>) = left.unzip();
    [first, second].map(|of_sensor| of_sensor.into_iter().flatten().collect())
}

/// Measured minus predicted contact positions of one sample, metres; `None` where a contact was not seen.
pub(crate) fn contact_residuals_m(instant: &Instant, coefficients: &[f64], psi: f64) -> (Option<f64>, Option<f64>) {
    let value = residuals(instant, coefficients, psi).value;
    ((instant.weight1 > 0.0).then_some(-value[0]), (instant.weight2 > 0.0).then_some(-value[1]))
}

/// Errors of unit variance with such a correlation time, samples: e_i = ρ e_{i−1} + white noise.
#[cfg(test)]
pub(crate) fn errors_with_memory(seed: u64, memory: f64, count: usize) -> Vec<f64> {
    use rand::{RngExt, SeedableRng};

    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let rho = (memory - 1.0) / (memory + 1.0);
    let mut error: f64 = rng.sample(rand_distr::StandardNormal);
    let mut next = || {
        let white: f64 = rng.sample(rand_distr::StandardNormal);
        error = rho * error + (1.0 - rho * rho).sqrt() * white;
        error
    };
    (0..count).map(|_| next()).collect()
}

/// A log without noise with such errors of both sensors, of this standard deviation in metres.
#[cfg(test)]
pub(crate) fn with_memory(mut log: crate::Log, sd_m: f64, memory: f64) -> crate::Log {
    let [first, second] = [1, 2].map(|seed| errors_with_memory(seed, memory, log.samples.len()));
    for (sample, (first, second)) in log.samples.iter_mut().zip(first.into_iter().zip(second)) {
        sample.s1_m = sample.s1_m.map(|s1_m| s1_m + sd_m * first);
        sample.s2_m = sample.s2_m.map(|s2_m| s2_m + sd_m * second);
    }
    log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_third_differences_hide_of_errors_with_a_memory_is_added_up_to_a_limit() {
        let hidden = |memory: f64| {
            let errors = errors_with_memory(1, memory, 40_000);
            let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            let third = |w: &[f64]| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2);
            let shown = errors.windows(4).map(third).sum::<f64>() / (errors.len() - 3) as f64 / 20.0;
            (hidden_from_neighbours(&errors), (variance / shown).sqrt())
        };
        for memory in [1.0, 4.0, 10.0] {
            let (found, expected) = hidden(memory);
            assert!((found / expected - 1.0).abs() < 0.05, "{found} for {expected}");
        }
        assert!(hidden(0.8 * SENSOR_MEMORY).0 > 3.0);
        assert_eq!(hidden(1.3 * SENSOR_MEMORY).0, 1.0, "a wrong shape leaves errors like these");
    }
}
