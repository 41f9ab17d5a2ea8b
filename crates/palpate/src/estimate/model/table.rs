//! A tabulated support function with cubic Hermite interpolation, for evaluating thousands of orientations of one shape.

use crate::estimate::measurements::Instant;
use crate::estimate::model::contact::{Residuals, combine, support};
use crate::palms::Contacts;
use crate::shape::ContactSupport;
use std::f64::consts::TAU;

/// Entries over the circle. For 48 harmonics a_k of the size of 1/k², a third of the mean radius the largest, the cubics
/// between them are accurate to h⁴ Σ k⁵ a_k/384: 1e-7 of the mean radius.
const ENTRIES: usize = 2048;

/// An angle as a fraction of a turn, in [0, 1], for angles of up to 10¹⁸ turns.
pub(crate) fn fraction_of_turn(theta: f64) -> f64 {
    let turns = theta / TAU;
    // Several times as fast as `rem_euclid`.
    let left = turns - (turns as i64) as f64;
    if left < 0.0 { left + 1.0 } else { left }
}

/// r, d and v of one shape at equally spaced normal angles.
pub(crate) struct SupportTable {
    entries: Vec<ContactSupport>,
}

impl SupportTable {
    /// Of the coefficient vector (a0, a1 … aK, b1 … bK), metres.
    pub fn new(coefficients: &[f64]) -> Self {
        let step = TAU / ENTRIES as f64;
        Self { entries: (0..=ENTRIES).map(|entry| support(coefficients, step * entry as f64)).collect() }
    }

    /// r, d and v at a normal angle: cubics through r with its slope −d and through d with its slope r − v; v between two
    /// entries is linear.
    pub fn at(&self, theta: f64) -> ContactSupport {
        let step = TAU / ENTRIES as f64;
        let place = fraction_of_turn(theta) * ENTRIES as f64;
        // It may round up to a whole turn; the table has an entry there.
        let entry = (place as usize).min(ENTRIES - 1);
        let x = place - entry as f64;
        let (a, b) = (&self.entries[entry], &self.entries[entry + 1]);
        let cubic = |from: f64, to: f64, slope: f64, end_slope: f64| {
            let y = 1.0 - x;
            from * y * y * (1.0 + 2.0 * x) + to * x * x * (1.0 + 2.0 * y) + step * x * y * (slope * y - end_slope * x)
        };
        ContactSupport {
            r: cubic(a.r, b.r, -a.d, -b.d),
            d: cubic(a.d, b.d, a.r - a.v, b.r - b.v),
            v: a.v + x * (b.v - a.v),
        }
    }

    /// The residuals of one sample.
    pub fn residuals(&self, instant: &Instant, psi: f64) -> Residuals {
        combine(instant, self.contacts(instant, psi))
    }

    /// r, d and v at both contacts of one sample.
    pub fn contacts(&self, instant: &Instant, psi: f64) -> Contacts {
        let (theta1, theta2) = instant.contact_angles(psi);
        Contacts::from([self.at(theta1), self.at(theta2)])
    }

    /// Height of the centre of mass over the point where the palms meet, metres.
    pub fn height_m(&self, instant: &Instant, psi: f64) -> f64 {
        let [_, height] = instant.palms.center(self.contacts(instant, psi).r);
        height
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_agrees_with_the_series() {
        // 48 harmonics that fall as those of a shape with sharp corners do.
        let mut coefficients = vec![0.03];
        coefficients.extend((1..=48).map(|k| 0.01 / f64::from(k * k)));
        coefficients.extend((1..=48).map(|k| -0.007 / f64::from(k * k)));
        let table = SupportTable::new(&coefficients);
        for theta in (-700..700).map(|i| 0.0137 * f64::from(i)).chain([0.0, TAU, -1e-18]) {
            let (exact, read) = (support(&coefficients, theta.rem_euclid(TAU)), table.at(theta));
            assert!((exact.r - read.r).abs() < 1.1e-10, "r at {theta}");
            // h⁴ Σ k⁵ a_k/384.
            assert!((exact.d - read.d).abs() < 4e-9, "d at {theta}");
            // h² Σ k⁴ a_k/8.
            assert!((exact.v - read.v).abs() < 6e-4, "v at {theta}");
        }
    }
}
