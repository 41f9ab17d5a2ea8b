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

/// The entry before an angle, and how far on to the next it is.
fn place(theta: f64) -> (usize, f64) {
    let place = fraction_of_turn(theta) * ENTRIES as f64;
    // It may round up to a whole turn; the table has an entry there.
    let entry = (place as usize).min(ENTRIES - 1);
    (entry, place - entry as f64)
}

/// The cubic between two entries with these values and slopes.
fn cubic(x: f64, [from, to]: [f64; 2], [slope, end_slope]: [f64; 2]) -> f64 {
    let y = 1.0 - x;
    let step = TAU / ENTRIES as f64;
    from * y * y * (1.0 + 2.0 * x) + to * x * x * (1.0 + 2.0 * y) + step * x * y * (slope * y - end_slope * x)
}

/// r, d and v of one shape at equally spaced normal angles.
#[derive(Clone)]
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
        let (entry, x) = place(theta);
        let (a, b) = (&self.entries[entry], &self.entries[entry + 1]);
        let cubic = |from: f64, to: f64, slope: f64, end_slope: f64| cubic(x, [from, to], [slope, end_slope]);
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

/// The same with the length of the boundary.
pub(crate) struct BoundaryTable {
    support: SupportTable,
    /// ∫ r dθ from 0 to each entry, metres.
    integral: Vec<f64>,
}

impl BoundaryTable {
    /// Of the coefficient vector (a0, a1 … aK, b1 … bK), metres.
    pub fn new(coefficients: &[f64]) -> Self {
        let step = TAU / ENTRIES as f64;
        let order = coefficients.len() / 2;
        let integral = |entry: usize| {
            let theta = step * entry as f64;
            let waves = (1..=order).map(|k| {
                let (sin, cos) = (k as f64 * theta).sin_cos();
                (coefficients[k] * sin + coefficients[order + k] * (1.0 - cos)) / k as f64
            });
            coefficients[0] * theta + waves.sum::<f64>()
        };
        Self { support: SupportTable::new(coefficients), integral: (0..=ENTRIES).map(integral).collect() }
    }

    /// r, d and v at both contacts of one sample.
    pub fn contacts(&self, instant: &Instant, psi: f64) -> Contacts {
        self.support.contacts(instant, psi)
    }

    /// The length of the boundary up to a normal angle, which is not wrapped, up to a constant, metres: ∫ v dθ = ∫ r dθ − d.
    pub fn arc_m(&self, theta: f64) -> f64 {
        let (entry, x) = place(theta);
        let of = |entry: usize| (self.integral[entry], self.support.entries[entry].r);
        let ((from, slope), (to, end_slope)) = (of(entry), of(entry + 1));
        let turns = (theta / TAU).floor();
        turns * self.integral[ENTRIES] + cubic(x, [from, to], [slope, end_slope]) - self.support.at(theta).d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Harmonics that fall as those of a shape with sharp corners do.
    fn with_sharp_corners(order: i32) -> Vec<f64> {
        let mut coefficients = vec![0.03];
        coefficients.extend((1..=order).map(|k| 0.01 / f64::from(k * k)));
        coefficients.extend((1..=order).map(|k| -0.007 / f64::from(k * k)));
        coefficients
    }

    #[test]
    fn the_length_of_the_boundary_is_that_of_the_series() {
        use crate::estimate::model::boundary::Boundary;
        let coefficients = with_sharp_corners(28);
        let table = BoundaryTable::new(&coefficients);
        let exact = |theta: f64| {
            let at = Boundary::new(&coefficients, ([theta.cos(); 2], [theta.sin(); 2]));
            at.arc_m(&coefficients, [theta; 2])[0]
        };
        for theta in (-700..700).map(|i| 0.0137 * f64::from(i)).chain([0.0, TAU, -TAU, -1e-18]) {
            let (from, to) = (exact(0.3), exact(theta));
            let read = table.arc_m(theta) - table.arc_m(0.3);
            assert!((read - (to - from)).abs() < 4e-9, "{theta}: {read} {}", to - from);
        }
    }

    #[test]
    fn a_table_agrees_with_the_series() {
        let coefficients = with_sharp_corners(48);
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
