//! The Cramér-Rao bound as one number.

use super::Information;
use crate::log::Log;
use crate::shape::SupportFunction;

/// Root mean square over the felt boundary of the smallest possible standard deviation of r (metres), for contact
/// positions of the standard deviation `sensor_sd_m` and exact balance; the common rotation, which cannot be known, is
/// taken out. `psi_rad` holds the true orientation at each sample. [`Information::of`] tells more, and what is wrong where there is none.
///
/// Harmonics of the true shape that together amount to less than a hundredth of the noise do not count as unknowns.
///
/// `None` when the log does not determine the shape, or when `psi_rad` is not as long as the log.
pub fn cramer_rao_bound_m(log: &Log, shape: &SupportFunction, psi_rad: &[f64], sensor_sd_m: f64) -> Option<f64> {
    Information::of(log, shape, psi_rad, sensor_sd_m).ok().map(|information| information.rms_r_sd_m())
}
