//! The boundary at both contacts of an instant, with what its derivatives by the shape, by the palms and along the boundary need.

use crate::estimate::model::contact::supports;
use crate::palms::{ContactRow, Contacts};

/// Contacts and what of the boundary is needed for rows there.
pub(crate) struct Boundary {
    pub at: Contacts,
    pub v_by_theta: [f64; 2],
    /// cos kθ and sin kθ at both contacts for k = 1 … K.
    turns: Vec<([f64; 2], [f64; 2])>,
}

impl Boundary {
    pub fn new(coefficients: &[f64], directions: ([f64; 2], [f64; 2])) -> Self {
        let order = coefficients.len() / 2;
        let mut turns = Vec::with_capacity(order);
        let mut v_by_theta = [0.0; 2];
        let (cos, sin) = directions;
        let at = supports(coefficients, cos, sin, |index, cos, sin| {
            let k = (index + 1) as f64;
            for contact in 0..2 {
                let slope = coefficients[1 + order + index] * cos[contact] - coefficients[1 + index] * sin[contact];
                v_by_theta[contact] += k * (1.0 - k * k) * slope;
            }
            turns.push((cos, sin));
        });
        Self { at: at.into(), v_by_theta, turns }
    }

    /// A functional of (r, d, v) as one of the coefficients.
    pub fn row_of(&self, by: &ContactRow, row: &mut [f64]) {
        let order = self.turns.len();
        row[0] = by.r[0] + by.r[1] + by.v[0] + by.v[1];
        for (index, (cos, sin)) in self.turns.iter().enumerate() {
            let k = (index + 1) as f64;
            let (mut of_cos, mut of_sin) = (0.0, 0.0);
            for contact in 0..2 {
                let along = by.r[contact] + (1.0 - k * k) * by.v[contact];
                let across = k * by.d[contact];
                of_cos += along * cos[contact] + across * sin[contact];
                of_sin += along * sin[contact] - across * cos[contact];
            }
            (row[1 + index], row[1 + order + index]) = (of_cos, of_sin);
        }
    }

    /// The contacts after palm 1 and palm 2 have turned by these small angles, the object as it is.
    pub fn turned(&self, palms: [f64; 2]) -> Contacts {
        let Contacts { r, d, v } = self.at;
        Contacts {
            r: [0, 1].map(|k| r[k] - d[k] * palms[k]),
            d: [0, 1].map(|k| d[k] + (r[k] - v[k]) * palms[k]),
            v: [0, 1].map(|k| v[k] + self.v_by_theta[k] * palms[k]),
        }
    }
    /// The length of the boundary up to both contacts, from where its normal points along the body frame, metres: ∫ v dθ. `theta` are the normal
    /// angles there, not wrapped.
    pub fn arc_m(&self, coefficients: &[f64], theta: [f64; 2]) -> [f64; 2] {
        let order = self.turns.len();
        let mut arc = theta.map(|theta| coefficients[0] * theta);
        for (index, (cos, sin)) in self.turns.iter().enumerate().skip(1) {
            let k = (index + 1) as f64;
            for contact in 0..2 {
                let of_term = coefficients[1 + index] * sin[contact] - coefficients[1 + order + index] * cos[contact];
                arc[contact] += (1.0 / k - k) * of_term;
            }
        }
        arc
    }

    /// Adds `factor` times the derivative of that length at one contact by the coefficients to a row.
    pub fn add_arc_row(&self, theta: f64, contact: usize, factor: f64, row: &mut [f64]) {
        let order = self.turns.len();
        row[0] += factor * theta;
        for (index, (cos, sin)) in self.turns.iter().enumerate().skip(1) {
            let k = (index + 1) as f64;
            row[1 + index] += factor * (1.0 / k - k) * sin[contact];
            row[1 + order + index] -= factor * (1.0 / k - k) * cos[contact];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SupportFunction;

    const COEFFICIENTS: [f64; 7] = [0.03, 0.002, -0.001, 0.0005, 0.003, 0.0007, -0.0004];
    const THETA: [f64; 2] = [0.7, 7.9];

    fn boundary(coefficients: &[f64], theta: [f64; 2]) -> Boundary {
        Boundary::new(coefficients, (theta.map(f64::cos), theta.map(f64::sin)))
    }

    #[test]
    fn its_length_is_the_integral_of_the_radius_of_curvature() {
        let shape = SupportFunction::from_coefficients(&COEFFICIENTS);
        let [from, to] = boundary(&COEFFICIENTS, THETA).arc_m(&COEFFICIENTS, THETA);
        let step = (THETA[1] - THETA[0]) / 1e4;
        let sum: f64 = (0..10_000).map(|i| shape.at(THETA[0] + step * (f64::from(i) + 0.5)).v * step).sum();
        assert!((to - from - sum).abs() < 1e-9, "{} {sum}", to - from);
    }

    #[test]
    fn its_row_is_its_derivative_by_the_coefficients() {
        let mut row = [0.0; 7];
        boundary(&COEFFICIENTS, THETA).add_arc_row(THETA[1], 1, 2.0, &mut row);
        for (index, exact) in row.into_iter().enumerate() {
            let mut more = COEFFICIENTS;
            more[index] += 1e-3;
            let [.., with] = boundary(&more, THETA).arc_m(&more, THETA);
            let [.., without] = boundary(&COEFFICIENTS, THETA).arc_m(&COEFFICIENTS, THETA);
            assert!((exact - 2.0 * (with - without) / 1e-3).abs() < 1e-9, "{index}");
        }
    }
}
