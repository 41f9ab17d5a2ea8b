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

impl Residuals {
    /// Whether the pose is balanced, the balance being missed by `balance_m` as a rule, but at no minimum of the potential energy. A
    /// pose off its balance is on its way (ringing); only one that rests can rest unstably.
    pub fn is_restless(&self, balance_m: f64) -> bool {
        self.by_psi[2] < 0.0 && self.value[2].abs() < 4.0 * balance_m
    }
}

/// Support function, its derivatives and the radius of curvature at one normal angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub r: f64,
    pub d: f64,
    pub v: f64,
}

/// The same at several normal angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Supports<const ANGLES: usize> {
    pub r: [f64; ANGLES],
    pub d: [f64; ANGLES],
    pub v: [f64; ANGLES],
}

impl<const ANGLES: usize> Supports<ANGLES> {
    fn each(&self) -> [Support; ANGLES] {
        std::array::from_fn(|i| Support { r: self.r[i], d: self.d[i], v: self.v[i] })
    }
}

/// Contact angles (θ1, θ2), eq. 1.
pub(super) fn contact_angles(instant: &Instant, psi: f64) -> (f64, f64) {
    let theta1 = instant.phi1 - psi - FRAC_PI_2;
    (theta1, theta1 + instant.phi2 - PI)
}

/// Cosines and sines of both contact angles, from the sine and cosine of one angle only.
fn contact_directions(instant: &Instant, psi: f64) -> ([f64; 2], [f64; 2]) {
    let (sin, cos) = (instant.phi1 - psi).sin_cos();
    let (cos1, sin1) = (sin, -cos);
    let cos2 = sin1 * instant.sin2 - cos1 * instant.cos2;
    let sin2 = -(sin1 * instant.cos2 + cos1 * instant.sin2);
    ([cos1, cos2], [sin1, sin2])
}

/// r, d, v at several normal angles, given by their cosines and sines, from the coefficient vector (a0, a1 … aK, b1 … bK).
/// The angles go in step, so that the processor can take them together. `visit` is shown cos kθ and sin kθ for k = 1 … K.
#[inline(always)]
pub(super) fn supports<const ANGLES: usize>(
    coefficients: &[f64],
    cos: [f64; ANGLES],
    sin: [f64; ANGLES],
    mut visit: impl FnMut(usize, [f64; ANGLES], [f64; ANGLES]),
) -> Supports<ANGLES> {
    let (a, b) = coefficients[1..].split_at(coefficients.len() / 2);
    let (mut c, mut s) = ([1.0; ANGLES], [0.0; ANGLES]);
    let mut sums = Supports { r: [coefficients[0]; ANGLES], d: [0.0; ANGLES], v: [coefficients[0]; ANGLES] };
    let mut number = 1.0;
    for (index, (a, b)) in a.iter().zip(b).enumerate() {
        let bending = 1.0 - number * number;
        for i in 0..ANGLES {
            (c[i], s[i]) = (c[i] * cos[i] - s[i] * sin[i], s[i] * cos[i] + c[i] * sin[i]);
            let term = a * c[i] + b * s[i];
            sums.r[i] += term;
            sums.d[i] += number * (a * s[i] - b * c[i]);
            sums.v[i] += bending * term;
        }
        visit(index, c, s);
        number += 1.0;
    }
    sums
}

/// r, d, v at one normal angle, from the coefficient vector (a0, a1 … aK, b1 … bK).
pub(super) fn support(coefficients: &[f64], theta: f64) -> Support {
    let (sin, cos) = theta.sin_cos();
    let [support] = supports(coefficients, [cos], [sin], |_, _, _| ()).each();
    support
}

pub(super) fn combine(instant: &Instant, [one, two]: [Support; 2]) -> Residuals {
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
    let (cos, sin) = contact_directions(instant, psi);
    combine(instant, supports(coefficients, cos, sin, |_, _, _| ()).each())
}

/// The residuals of one sample as functions of the coefficients: linear, through r1, r2, d1 and d2, with cos kθ and sin kθ
/// at both contacts.
pub(super) struct Linearised {
    numbers: Vec<f64>,
    cos: [Vec<f64>; 2],
    sin: [Vec<f64>; 2],
}

impl Linearised {
    pub fn new(order: usize) -> Self {
        let empty = || vec![0.0; order];
        Self { numbers: (1..=order).map(|k| k as f64).collect(), cos: [empty(), empty()], sin: [empty(), empty()] }
    }

    /// Moves to another sample, orientation and shape; the residuals there.
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
        combine(instant, both.each())
    }

    /// Writes the derivative, by the coefficients, of the three residuals in the mixture `share`.
    pub fn mixed_row(&self, instant: &Instant, share: [f64; 3], row: &mut [f64]) {
        let inverse = 1.0 / instant.sin2;
        let ratio = instant.cos2 * inverse;
        // What the mixture makes of r1, r2, d1 and d2.
        let (r1, r2) = (share[0] * ratio + share[1] * inverse, share[0] * inverse + share[1] * ratio);
        let (d1, d2) = (share[2] * instant.sin12 - share[0], share[2] * instant.sin1 + share[1]);
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
    fn only_a_balanced_pose_at_no_minimum_is_restless() {
        let at = |stiffness: f64, balance: f64| Residuals { value: [0.0, 0.0, balance], by_psi: [0.1, 0.1, stiffness] };
        assert!(at(-0.01, 1e-5).is_restless(1e-5));
        assert!(!at(0.01, 1e-5).is_restless(1e-5), "at rest");
        assert!(!at(-0.01, 5e-5).is_restless(1e-5), "on its way");
    }

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
