//! The Cramér-Rao bound: how well any unbiased estimator could know the shape from a log, were the true shape and motion
//! those given.

use crate::estimate::coverage::{NODES, felt_nodes};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::error_bars::ErrorBars;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::estimate::solver::gauss_newton::Fit;
use crate::log::Log;
use crate::shape::SupportFunction;
use std::f64::consts::TAU;

/// Root mean square over the felt boundary of the smallest possible standard deviation of r (metres), for contact
/// positions of the standard deviation `sensor_sd_m` and exact balance; the common rotation, which cannot be known, is
/// taken out. `psi_rad` holds the true orientation at each sample.
///
/// Harmonics of the true shape that together amount to less than a hundredth of the noise do not count as unknowns.
///
/// `None` when the log does not determine the shape, or when `psi_rad` is not as long as the log.
pub fn cramer_rao_bound_m(log: &Log, shape: &SupportFunction, psi_rad: &[f64], sensor_sd_m: f64) -> Option<f64> {
    if psi_rad.len() != log.samples.len() || sensor_sd_m.is_nan() || sensor_sd_m <= 0.0 {
        return None;
    }
    let measurements = Measurements::new(log, None);
    let order = shape.visible_order(sensor_sd_m);
    let mut coefficients = shape.coefficients();
    coefficients_to_order(&mut coefficients, order);
    let size_m = shape.mean_radius_m();
    let fit = Fit {
        estimate: Estimate { coefficients, psi: psi_rad.to_vec(), cost: 0.0 },
        order,
        noise: Noise { sensor_m: sensor_sd_m, balance_m: 1e-3 * sensor_sd_m },
        // As good as none: the bound is the data's own. (The size is the true one, for convexity is told from it.)
        prior: Prior { size_m, scale_m: 1e6 * size_m },
        log_evidence: 0.0,
    };
    let felt: Vec<f64> = felt_nodes(&measurements, psi_rad).map(|node| TAU * node as f64 / NODES as f64).collect();
    let error_bars = ErrorBars::new(&measurements, &fit, &felt, 1.0)?;
    let mean: f64 = felt.iter().map(|&theta| error_bars.r_sd_m(theta).powi(2)).sum::<f64>() / felt.len() as f64;
    mean.is_finite().then(|| mean.sqrt())
}
