//! Errors of contact positions and balance, as the estimator believes them.

use crate::estimate::measurements::Instant;
use crate::estimate::model::table::SupportTable;

/// Standard deviations of the measurements, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Of the contact positions.
    pub sensor_m: f64,
    /// Of the balance equation g.
    pub balance_m: f64,
}

impl Noise {
    /// Weights of the three residuals of an instant, 1/m.
    pub fn weights(&self, instant: &Instant) -> [f64; 3] {
        let inverse = 1.0 / self.sensor_m;
        [instant.weight1 * inverse, instant.weight2 * inverse, instant.balance_weight / self.balance_m]
    }
}

/// How far off contacts and balance usually are: variances, metres squared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    pub contact_m2: f64,
    pub balance_m2: f64,
    /// Samples over which errors of the balance hang together (friction, pace): so many tell as much as one.
    pub balance_memory: f64,
}

impl Spread {
    /// Squared standard deviations by which a sample is missed at an orientation. Contacts always hold; balance may be
    /// missed in bursts, so its part grows slowly only (Student's t with three degrees of freedom).
    pub fn misfit(&self, table: &SupportTable, instant: &Instant, psi: f64) -> f64 {
        let value = table.residuals(instant, psi).value;
        let contacts = (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2);
        contacts / self.contact_m2 + 4.0 / self.balance_memory * (value[2] * value[2] / (3.0 * self.balance_m2)).ln_1p()
    }
}

/// Degrees of freedom ν of the errors of the balance.
pub(crate) const STUDENT: f64 = 3.0;
