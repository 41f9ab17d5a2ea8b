//! The error model: Gaussian contact positions, and a balance with Student's t (`docs/theory.md`, what the log says of itself).

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

/// Robust variances of contacts and balance, metres squared, for decoding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Of a contact position.
    pub contact_m2: f64,
    /// Of the balance equation g.
    pub balance_m2: f64,
    /// Correlation time of the errors of the balance (friction, pace), in samples: so many carry the information of one.
    pub balance_memory: f64,
}

impl Spread {
    /// Squared standard deviations by which a sample is missed at an orientation: Gaussian contacts, and a balance whose share is
    /// logarithmic (Student's t), since it fails in bursts.
    pub fn misfit(&self, table: &SupportTable, instant: &Instant, psi: f64) -> f64 {
        let value = table.residuals(instant, psi).value;
        let contacts = (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2);
        contacts / self.contact_m2
            + (STUDENT + 1.0) / self.balance_memory * (value[2] * value[2] / (STUDENT * self.balance_m2)).ln_1p()
    }
}

/// Degrees of freedom ν of Student's t for the errors of the balance: heavy tails for bursts, but still a finite variance.
pub(crate) const STUDENT: f64 = 3.0;
