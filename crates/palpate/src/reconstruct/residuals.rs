//! The three residuals of one sample and their exact derivatives (`docs/theory.md`, maximum likelihood):
//! predicted minus measured s1 and s2 (contact, eq. 3 of Moll & Erdmann 2001) and the balance g = d1 sin φ12 + d2 sin φ1.

use std::f64::consts::{FRAC_PI_2, PI};

use super::problem::Instant;

/// Residuals of one sample (s1, s2 and balance) in metres, with their derivatives by ψ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residuals {
    pub value: [f64; 3],
    pub by_psi: [f64; 3],
}

/// Powers of e^{iθ}: cos kθ and sin kθ for k = 1 … K at both contacts, and the sums r, d, v over them.
pub(super) struct Harmonics {
    order: usize,
    cos1: Vec<f64>,
    sin1: Vec<f64>,
    cos2: Vec<f64>,
    sin2: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub r: f64,
    pub d: f64,
    pub v: f64,
}

fn powers(theta: f64, cosines: &mut [f64], sines: &mut [f64]) {
    let (sin, cos) = theta.sin_cos();
    let (mut c, mut s) = (1.0, 0.0);
    for (cosine, sine) in cosines.iter_mut().zip(sines.iter_mut()) {
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        (*cosine, *sine) = (c, s);
    }
}

fn sums(coefficients: &[f64], cosines: &[f64], sines: &[f64]) -> Support {
    let order = cosines.len();
    let (a, b) = coefficients[1..].split_at(order);
    let (mut r, mut d, mut v) = (coefficients[0], 0.0, coefficients[0]);
    for k in 0..order {
        let number = (k + 1) as f64;
        let term = a[k] * cosines[k] + b[k] * sines[k];
        r += term;
        d += number * (a[k] * sines[k] - b[k] * cosines[k]);
        v += (1.0 - number * number) * term;
    }
    Support { r, d, v }
}

/// Contact angles (θ1, θ2), eq. 1.
pub(super) fn contact_angles(instant: &Instant, psi: f64) -> (f64, f64) {
    let theta1 = instant.phi1 - psi - FRAC_PI_2;
    (theta1, theta1 + instant.phi2 - PI)
}

/// r, d, v at one normal angle, from the coefficient vector (a0, a1 … aK, b1 … bK).
pub(super) fn support(coefficients: &[f64], theta: f64) -> Support {
    let order = coefficients.len() / 2;
    let (sin, cos) = theta.sin_cos();
    let (mut c, mut s) = (1.0, 0.0);
    let (a, b) = coefficients[1..].split_at(order);
    let (mut r, mut d, mut v) = (coefficients[0], 0.0, coefficients[0]);
    for k in 0..order {
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        let number = (k + 1) as f64;
        let term = a[k] * c + b[k] * s;
        r += term;
        d += number * (a[k] * s - b[k] * c);
        v += (1.0 - number * number) * term;
    }
    Support { r, d, v }
}

fn combine(instant: &Instant, one: Support, two: Support) -> Residuals {
    let (c2, inverse) = (instant.cos2, 1.0 / instant.sin2);
    let value = [
        (one.r * c2 + two.r) * inverse - one.d - instant.s1,
        (two.r * c2 + one.r) * inverse + two.d - instant.s2,
        one.d * instant.sin12 + two.d * instant.sin1,
    ];
    // θ falls as ψ grows: ∂r/∂ψ = d, ∂d/∂ψ = v − r.
    let by_psi = [
        (one.d * c2 + two.d) * inverse + (one.r - one.v),
        (two.d * c2 + one.d) * inverse - (two.r - two.v),
        -(one.r - one.v) * instant.sin12 - (two.r - two.v) * instant.sin1,
    ];
    Residuals { value, by_psi }
}

/// The residuals of one sample for a shape and an orientation.
pub(super) fn residuals(instant: &Instant, coefficients: &[f64], psi: f64) -> Residuals {
    let (theta1, theta2) = contact_angles(instant, psi);
    combine(instant, support(coefficients, theta1), support(coefficients, theta2))
}

impl Harmonics {
    pub fn new(order: usize) -> Self {
        let empty = || vec![0.0; order];
        Self { order, cos1: empty(), sin1: empty(), cos2: empty(), sin2: empty() }
    }

    /// The residuals of one sample; writes their derivatives by the coefficients into three rows of length 2K + 1.
    pub fn linearise(
        &mut self,
        instant: &Instant,
        coefficients: &[f64],
        psi: f64,
        rows: &mut [Vec<f64>; 3],
    ) -> Residuals {
        let order = self.order;
        let (theta1, theta2) = contact_angles(instant, psi);
        powers(theta1, &mut self.cos1, &mut self.sin1);
        powers(theta2, &mut self.cos2, &mut self.sin2);
        let one = sums(coefficients, &self.cos1, &self.sin1);
        let two = sums(coefficients, &self.cos2, &self.sin2);
        let (c2, inverse) = (instant.cos2, 1.0 / instant.sin2);
        let (sin1, sin12) = (instant.sin1, instant.sin12);
        let ratio = c2 * inverse;
        let [row1, row2, row3] = rows;
        row1[0] = ratio + inverse;
        row2[0] = ratio + inverse;
        row3[0] = 0.0;
        let (row1a, row1b) = row1[1..].split_at_mut(order);
        let (row2a, row2b) = row2[1..].split_at_mut(order);
        let (row3a, row3b) = row3[1..].split_at_mut(order);
        for k in 0..order {
            let number = (k + 1) as f64;
            let (ca, sa, cb, sb) = (self.cos1[k], self.sin1[k], self.cos2[k], self.sin2[k]);
            row1a[k] = ca * ratio + cb * inverse - number * sa;
            row1b[k] = sa * ratio + sb * inverse + number * ca;
            row2a[k] = cb * ratio + ca * inverse + number * sb;
            row2b[k] = sb * ratio + sa * inverse - number * cb;
            row3a[k] = number * (sa * sin12 + sb * sin1);
            row3b[k] = -number * (ca * sin12 + cb * sin1);
        }
        combine(instant, one, two)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Sample;
    use crate::palms::PalmPair;
    use crate::shape::SupportFunction;
    use crate::{Log, reconstruct::problem::Problem};

    fn instant() -> Instant {
        let palms = PalmPair { phi1_rad: 0.5, phi2_rad: 1.3, base1_m: [0.01, -0.02], base2_m: [-0.03, 0.005] };
        let log = Log { samples: vec![Sample::new(0.0, palms, 0.03, 0.04)] };
        Problem::new(&log, None).instants[0]
    }

    const COEFFICIENTS: [f64; 7] = [0.03, 0.002, -0.001, 0.0005, 0.003, 0.0007, -0.0004];

    #[test]
    fn residuals_are_the_forward_model_minus_the_measurement() {
        let palms = PalmPair { phi1_rad: 0.5, phi2_rad: 1.3, base1_m: [0.01, -0.02], base2_m: [-0.03, 0.005] };
        let shape = SupportFunction::from_coefficients(&COEFFICIENTS);
        let (s1, s2) = palms.contact_positions_m(&shape, 0.7);
        let value = residuals(&instant(), &COEFFICIENTS, 0.7).value;
        assert!((value[0] - (s1 - 0.03)).abs() < 1e-15);
        assert!((value[1] - (s2 - 0.04)).abs() < 1e-15);
    }

    #[test]
    fn jacobians_match_finite_differences() {
        let instant = instant();
        let mut rows = [vec![0.0; 7], vec![0.0; 7], vec![0.0; 7]];
        let exact = Harmonics::new(3).linearise(&instant, &COEFFICIENTS, 0.7, &mut rows);
        let step = 1e-6;
        let (plus, minus) =
            (residuals(&instant, &COEFFICIENTS, 0.7 + step), residuals(&instant, &COEFFICIENTS, 0.7 - step));
        for (j, row) in rows.iter().enumerate() {
            let slope = (plus.value[j] - minus.value[j]) / (2.0 * step);
            assert!((slope - exact.by_psi[j]).abs() < 1e-9, "by psi, residual {j}");
            for m in 0..7 {
                let mut moved = COEFFICIENTS;
                moved[m] += 1e-3;
                let slope = (residuals(&instant, &moved, 0.7).value[j] - exact.value[j]) / 1e-3;
                assert!((slope - row[m]).abs() < 1e-10, "coefficient {m}, residual {j}");
            }
        }
    }
}
