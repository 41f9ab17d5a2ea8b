//! The curve (r, d) of a shape and its radius of curvature v at many contact angles, eight of them in step.

use pulp::{Arch, Simd, WithSimd};

use crate::estimate::model::contact::{Supports, supports};
use crate::math::lanes::{LANES, Lanes, sin_cos};
use crate::shape::ContactSupport;

/// r, d and v at each angle, from the coefficients (a₀, a₁ … a_K, b₁ … b_K).
pub(super) fn curve(coefficients: &[f64], theta_rad: &[f64]) -> Vec<ContactSupport> {
    Arch::new().dispatch(Evaluating { coefficients, theta_rad })
}

/// Compiled for several instruction sets.
struct Evaluating<'a> {
    coefficients: &'a [f64],
    theta_rad: &'a [f64],
}

impl WithSimd for Evaluating<'_> {
    type Output = Vec<ContactSupport>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { coefficients, theta_rad } = self;
        let mut contacts = Vec::with_capacity(theta_rad.len());
        for angles in theta_rad.chunks(LANES) {
            let (sin, cos) = sin_cos(Lanes::loaded(angles));
            let Supports { r: [r], d: [d], v: [v] } = supports(coefficients, [cos], [sin], |_, _, _| ());
            for lane in 0..angles.len() {
                contacts.push(ContactSupport { r: r[lane], d: d[lane], v: v[lane] });
            }
        }
        contacts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::support;

    #[test]
    fn eight_angles_are_as_each_of_them() {
        let coefficients = [0.03, 0.002, -0.001, 0.0005, 0.003, 0.0012, -0.0004];
        for count in [0, 1, LANES, 2 * LANES + 3] {
            let theta: Vec<f64> = (0..count).map(|index| 1.7 * index as f64 - 9.0).collect();
            let contacts = curve(&coefficients, &theta);
            assert_eq!(contacts.len(), count);
            for (contact, theta) in contacts.iter().zip(&theta) {
                let alone = support(&coefficients, *theta);
                let off = [contact.r - alone.r, contact.d - alone.d, contact.v - alone.v];
                assert!(off.iter().all(|off| off.abs() < 1e-16), "{theta}: {off:?}");
            }
        }
    }
}
