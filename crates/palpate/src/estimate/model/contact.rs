//! The three residuals of one sample and their exact derivatives (`docs/theory.md`, maximum likelihood):
//! predicted minus measured s1 and s2 (contact, eq. 3 of Moll & Erdmann 2001) and the balance g = d1 sin φ12 + d2 sin φ1.

use crate::estimate::measurements::{Instant, Measurements};
use crate::math::lanes::Number;
use crate::mechanics::Forces;
use crate::mechanics::force_model::{ForceModel, ForceResidual, MotionState};
use crate::palms::Contacts;
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
pub(crate) fn contact_directions(instant: &Instant, psi: f64) -> ([f64; 2], [f64; 2]) {
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

/// Standard deviation of ψ at every sample by its contacts alone, given the form and that of a contact position.
pub(crate) fn psi_sd_by_contacts(
    measurements: &Measurements,
    coefficients: &[f64],
    psi: &[f64],
    sensor_m: f64,
) -> Vec<f64> {
    let sd = |(instant, psi): (&Instant, &f64)| {
        let by_psi = residuals(instant, coefficients, *psi).by_psi;
        sensor_m / (instant.weight1 * by_psi[0]).hypot(instant.weight2 * by_psi[1])
    };
    measurements.instants.iter().zip(psi).map(sd).collect()
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
    fn derivatives_by_psi_match_finite_differences() {
        let instant = instant();
        let at = |psi: f64| residuals(&instant, &COEFFICIENTS, psi);
        let (exact, step) = (at(0.7), 1e-6);
        for j in 0..3 {
            let slope = (at(0.7 + step).value[j] - at(0.7 - step).value[j]) / (2.0 * step);
            assert!((slope - exact.by_psi[j]).abs() < 1e-9, "residual {j}");
        }
    }
}
