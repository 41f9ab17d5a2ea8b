//! The three residuals of one sample and their exact derivatives (`docs/theory.md`, maximum likelihood):
//! predicted minus measured s1 and s2 (contact, eq. 3 of Moll & Erdmann 2001) and the balance g = d1 sin φ12 + d2 sin φ1.

use crate::estimate::measurements::Instant;
use crate::math::lanes::Number;
use crate::mechanics::Forces;
use crate::mechanics::force_model::{ForceModel, ForceResidual, MotionState};
use crate::palms::{ContactRow, Contacts};
use crate::shape::ContactSupport;

/// Residuals of one sample (s1, s2 and balance) in metres, with their derivatives by ψ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residuals {
    pub value: [f64; 3],
    pub by_psi: [f64; 3],
}

impl Residuals {
    /// Whether the pose is balanced, to within the standard deviation `balance_m`, but not at a minimum of the potential energy.
    pub fn is_unstable(&self, balance_m: f64) -> bool {
        let [_, _, value] = self.value;
        let residual = ForceResidual { value, by_psi: self.by_psi[2], by_psi_rates: [0.0; 2] };
        Forces::default().is_unstable(&residual, 0.0, AT_REST * balance_m)
    }
}

/// A pose whose balance is missed by more standard deviations than this is not at rest but in motion (ringing), and not tested
/// for stability.
pub(crate) const AT_REST: f64 = 4.0;

/// Support function, its derivatives and the radius of curvature at several normal angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supports<N, const ANGLES: usize> {
    pub r: [N; ANGLES],
    pub d: [N; ANGLES],
    pub v: [N; ANGLES],
}

impl<N> From<Supports<N, 2>> for Contacts<N> {
    #[inline(always)]
    fn from(Supports { r, d, v }: Supports<N, 2>) -> Self {
        Self { r, d, v }
    }
}

/// Cosines and sines of both contact angles, from the sine and cosine of one angle only.
fn contact_directions(instant: &Instant, psi: f64) -> ([f64; 2], [f64; 2]) {
    let (sin, cos) = (instant.phi1 - psi).sin_cos();
    instant.palms.contact_directions(sin, cos)
}

/// r, d, v at several normal angles, given by their cosines and sines, from the coefficient vector (a0, a1 … aK, b1 … bK).
/// The angles are evaluated side by side, so that the loop vectorises. `visit` is given cos kθ and sin kθ for k = 1 … K.
#[inline(always)]
pub(crate) fn supports<N: Number, const ANGLES: usize>(
    coefficients: &[f64],
    cos: [N; ANGLES],
    sin: [N; ANGLES],
    mut visit: impl FnMut(usize, [N; ANGLES], [N; ANGLES]),
) -> Supports<N, ANGLES> {
    let (a, b) = coefficients[1..].split_at(coefficients.len() / 2);
    let mean = N::from(coefficients[0]);
    let (mut c, mut s) = ([N::from(1.0); ANGLES], [N::ZERO; ANGLES]);
    let mut sums = Supports { r: [mean; ANGLES], d: [N::ZERO; ANGLES], v: [mean; ANGLES] };
    let mut number = 1.0;
    for (index, (a, b)) in a.iter().zip(b).enumerate() {
        let bending = 1.0 - number * number;
        for i in 0..ANGLES {
            (c[i], s[i]) = (c[i] * cos[i] - s[i] * sin[i], s[i] * cos[i] + c[i] * sin[i]);
            let term = c[i] * *a + s[i] * *b;
            sums.r[i] = sums.r[i] + term;
            sums.d[i] = sums.d[i] + (s[i] * *a - c[i] * *b) * number;
            sums.v[i] = sums.v[i] + term * bending;
        }
        visit(index, c, s);
        number += 1.0;
    }
    sums
}

/// r, d, v at one normal angle, from the coefficient vector (a0, a1 … aK, b1 … bK).
pub(crate) fn support(coefficients: &[f64], theta: f64) -> ContactSupport {
    let (sin, cos) = theta.sin_cos();
    let Supports { r: [r], d: [d], v: [v] } = supports(coefficients, [cos], [sin], |_, _, _| ());
    ContactSupport { r, d, v }
}

/// r, d and v at both contacts of one sample.
pub(crate) fn contacts(instant: &Instant, coefficients: &[f64], psi: f64) -> Contacts {
    let (cos, sin) = contact_directions(instant, psi);
    supports(coefficients, cos, sin, |_, _, _| ()).into()
}

/// The residuals of one sample with these contacts.
pub(crate) fn combine(instant: &Instant, at: Contacts) -> Residuals {
    let (r_by_psi, d_by_psi) = at.by_psi();
    let ([s1, s2], [s1_by_psi, s2_by_psi]) =
        (instant.palms.positions(at.r, at.d), instant.palms.positions(r_by_psi, d_by_psi));
    let forces = Forces::default().residual(&MotionState::at_rest(instant.palms, at));
    Residuals { value: [s1 - instant.s1, s2 - instant.s2, forces.value], by_psi: [s1_by_psi, s2_by_psi, forces.by_psi] }
}

/// Derivatives of the three residuals by the angles of palm 1 and palm 2, each against the horizontal: `[palm][residual]`, ψ as
/// it is.
pub(crate) fn by_palms(instant: &Instant, at: &Contacts) -> [[f64; 3]; 2] {
    let [[s11, s21], [s12, s22]] = instant.palms.positions_by_palms(at);
    let [g1, g2] = Forces::default().by_palms(&MotionState::at_rest(instant.palms, *at));
    [[s11, s21, g1], [s12, s22, g2]]
}

/// The residuals of one sample for a shape and an orientation.
pub(crate) fn residuals(instant: &Instant, coefficients: &[f64], psi: f64) -> Residuals {
    combine(instant, contacts(instant, coefficients, psi))
}

/// The residuals of one sample as functions of the coefficients: linear, through r1, r2, d1 and d2, with cos kθ and sin kθ
/// at both contacts.
pub(crate) struct Linearised {
    numbers: Vec<f64>,
    cos: [Vec<f64>; 2],
    sin: [Vec<f64>; 2],
}

impl Linearised {
    pub fn new(order: usize) -> Self {
        let empty = || vec![0.0; order];
        Self { numbers: (1..=order).map(|k| k as f64).collect(), cos: [empty(), empty()], sin: [empty(), empty()] }
    }

    /// Evaluates another sample, orientation and shape; returns the residuals there.
    pub fn at(&mut self, instant: &Instant, coefficients: &[f64], psi: f64) -> Residuals {
        let order = self.numbers.len();
        let ([cos1, cos2], [sin1, sin2]) = (&mut self.cos, &mut self.sin);
        let (cos1, cos2) = (&mut cos1[..order], &mut cos2[..order]);
        let (sin1, sin2) = (&mut sin1[..order], &mut sin2[..order]);
        let (cos, sin) = contact_directions(instant, psi);
        let both = supports(&coefficients[..2 * order + 1], cos, sin, |index, c, s| {
            (cos1[index], cos2[index]) = (c[0], c[1]);
            (sin1[index], sin2[index]) = (s[0], s[1]);
        });
        combine(instant, both.into())
    }

    /// Writes the derivative, by the coefficients, of the three residuals in the mixture `share`.
    pub fn mixed_row(&self, instant: &Instant, share: [f64; 3], row: &mut [f64]) {
        let of_contacts = instant.palms.positions_row([share[0], share[1]]);
        // At rest the row of the forces does not depend on the contacts.
        let contacts = Contacts { r: [0.0; 2], d: [0.0; 2], v: [0.0; 2] };
        let of_forces = Forces::default().row(&MotionState::at_rest(instant.palms, contacts));
        let ContactRow { r: [r1, r2], d: [d1, d2], .. } = of_contacts.plus(share[2], &of_forces);
        let order = self.numbers.len();
        let (mean, harmonics) = row.split_at_mut(1);
        mean[0] = r1 + r2;
        let (a, b) = harmonics.split_at_mut(order);
        let (a, b) = (&mut a[..order], &mut b[..order]);
        let ([cos1, cos2], [sin1, sin2]) = (&self.cos, &self.sin);
        let (cos1, cos2) = (&cos1[..order], &cos2[..order]);
        let (sin1, sin2) = (&sin1[..order], &sin2[..order]);
        for k in 0..order {
            a[k] = r1 * cos1[k] + r2 * cos2[k] + self.numbers[k] * (d1 * sin1[k] + d2 * sin2[k]);
            b[k] = r1 * sin1[k] + r2 * sin2[k] - self.numbers[k] * (d1 * cos1[k] + d2 * cos2[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Log;
    use crate::estimate::measurements::Measurements;
    use crate::log::Sample;
    use crate::palms::PalmPair;
    use crate::shape::SupportFunction;

    fn instant() -> Instant {
        let palms = PalmPair { phi1_rad: 0.5, phi2_rad: 1.3, base1_m: [0.01, -0.02], base2_m: [-0.03, 0.005] };
        let log = Log { samples: vec![Sample::new(0.0, palms, 0.03, 0.04)] };
        Measurements::new(&log, None).instants[0]
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
        let mut linearised = Linearised::new(3);
        let exact = linearised.at(&instant, &COEFFICIENTS, 0.7);
        let step = 1e-6;
        let (plus, minus) =
            (residuals(&instant, &COEFFICIENTS, 0.7 + step), residuals(&instant, &COEFFICIENTS, 0.7 - step));
        for j in 0..3 {
            let slope = (plus.value[j] - minus.value[j]) / (2.0 * step);
            assert!((slope - exact.by_psi[j]).abs() < 1e-9, "by psi, residual {j}");
            let mut row = [0.0; 7];
            linearised.mixed_row(&instant, std::array::from_fn(|i| f64::from(i == j)), &mut row);
            for m in 0..7 {
                let mut moved = COEFFICIENTS;
                moved[m] += 1e-3;
                let slope = (residuals(&instant, &moved, 0.7).value[j] - exact.value[j]) / 1e-3;
                assert!((slope - row[m]).abs() < 1e-10, "coefficient {m}, residual {j}");
            }
        }
    }
}
