//! The slip of the object along each palm, and the rates of ψ at which it vanishes.
//!
//! With the palms turning at w₁ and w₂ against the horizontal, ψ' = Ω, and the contact at σ_k along t̄_k from its base point b_k, the
//! supporting lines ask for c'·n̄_k = w_kσ_k + d_kΩ + b'_k·n̄_k. The slip of the object's material along t̄_k is
//! u_k = c'·t̄_k + r_kΩ − b'_k·t̄_k, linear in Ω: u_k = a_kΩ + e_k with
//!
//! a₁ = (s₂ − s₁ cos φ₂)/sin φ₂,  a₂ = (s₁ − s₂ cos φ₂)/sin φ₂ (s from the point where the lines of the palms meet).
//!
//! It vanishes where the object rolls on palm k: Ω = −e_k/a_k. For palms hinged at a point that stays this needs no shape,
//! ψ' = φ₁' + φ₂' s₂/(s₂ − s₁ cos φ₂) and ψ' = φ₁₂' − φ₂' s₁/(s₁ − s₂ cos φ₂). Between palms that turn as one an object turns with them, wherever
//! it is felt: rates are therefore those beyond palm 1, which no rounding enlarges where a_k is small.

use crate::palms::{Contacts, Palm, PalmAngles, PalmPair};

/// How the palms move, by some parameter (time, or the share of a step).
#[derive(Clone, Copy, Debug)]
pub(super) struct PalmRates {
    /// Of the angles against the horizontal.
    pub angles: [f64; 2],
    /// Of the base points, metres.
    pub bases_m: [[f64; 2]; 2],
}

impl PalmRates {
    /// Of an even motion from one pair to another, by the share of it.
    pub fn between(from: &PalmPair, to: &PalmPair) -> Self {
        let point = |a: [f64; 2], b: [f64; 2]| [b[0] - a[0], b[1] - a[1]];
        let first = to.phi1_rad - from.phi1_rad;
        let opening = to.phi2_rad - from.phi2_rad;
        let opening = if opening.abs() > ROUNDING_RAD { opening } else { 0.0 };
        Self {
            angles: [first, first + opening],
            bases_m: [point(from.base1_m, to.base1_m), point(from.base2_m, to.base2_m)],
        }
    }
}

/// Changes of the opening that are rounding, radians.
const ROUNDING_RAD: f64 = 1e-14;

/// Slip along both palms as a function of ψ': u_k = `by_psi_rate`\[k\] (ψ' − `of_palm1`) + `beyond`\[k\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Slip {
    pub by_psi_rate: [f64; 2],
    /// The rate of palm 1.
    of_palm1: f64,
    beyond: [f64; 2],
}

impl Slip {
    pub fn new(palms: &PalmPair, angles: &PalmAngles, at: &Contacts, rates: &PalmRates) -> Self {
        let [s1, s2] = angles.positions(at.r, at.d);
        let shift = palms.base_shifts_m(angles);
        let along =
            |k: usize, direction: [f64; 2]| rates.bases_m[k][0] * direction[0] + rates.bases_m[k][1] * direction[1];
        let normal = [palms.normal(Palm::One), palms.normal(Palm::Two)];
        let tangent = [palms.tangent(Palm::One), palms.tangent(Palm::Two)];
        let [of_palm1, of_palm2] = rates.angles;
        // σ₁ = s₁ − shift₁ and σ₂ = shift₂ − s₂: what base points apart and in motion carry besides.
        let carried = [along(0, normal[0]) - of_palm1 * shift[0], along(1, normal[1]) + of_palm2 * shift[1]];
        let opened = (of_palm2 - of_palm1) * s2;
        Self {
            by_psi_rate: [(s2 - s1 * angles.cos2) * angles.inverse2, (s1 - s2 * angles.cos2) * angles.inverse2],
            of_palm1,
            beyond: [
                (angles.cos2 * carried[0] + carried[1] - opened) * angles.inverse2 - along(0, tangent[0]),
                (angles.cos2 * (opened - carried[1]) - carried[0]) * angles.inverse2 - along(1, tangent[1]),
            ],
        }
    }

    /// The slip along palm `k` (0 or 1) at some ψ'.
    pub fn at(&self, k: usize, rate: f64) -> f64 {
        self.by_psi_rate[k] * (rate - self.of_palm1) + self.beyond[k]
    }

    /// ψ' of an object that rolls on palm `k` (0 or 1).
    pub fn rolling_rate(&self, k: usize) -> f64 {
        match self.beyond[k] {
            0.0 => self.of_palm1,
            beyond => self.of_palm1 - beyond / self.by_psi_rate[k],
        }
    }
}

/// Signs of the slips of both contacts where ψ' is below, between and above the two rates of rolling. `by_psi_rate` is how the slips grow with
/// it (its sign counts), `order` the palm that is rolled on at the smaller rate and that at the larger.
pub(crate) fn slip_signs(by_psi_rate: [f64; 2], order: [usize; 2]) -> [[f64; 2]; 3] {
    let above = by_psi_rate.map(f64::signum);
    let mut between = above;
    between[order[1]] = -above[order[1]];
    [above.map(|sign| -sign), between, above]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SupportFunction;

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    fn contacts(palms: &PalmPair, psi: f64) -> Contacts {
        let (theta1, theta2) = palms.contact_angles(psi);
        Contacts::from([shape().at(theta1), shape().at(theta2)])
    }

    /// Palms with base points apart, all of it in motion.
    fn palms(share: f64) -> PalmPair {
        let from = PalmPair { phi1_rad: 0.5, phi2_rad: 1.2, base1_m: [0.004, -0.002], base2_m: [-0.003, 0.001] };
        let to = PalmPair { phi1_rad: 0.8, phi2_rad: 1.1, base1_m: [0.007, -0.001], base2_m: [-0.001, 0.004] };
        from.towards(&to, share)
    }

    /// Slip along a palm by finite differences: the material point at the contact, carried by the object and by the palm.
    fn numeric(k: usize, psi: f64, rate: f64) -> f64 {
        const STEP: f64 = 1e-6;
        let palm = [Palm::One, Palm::Two][k];
        let place = |share: f64| {
            let pair = palms(share);
            let stance = pair.stance(&pair.angles(), &shape(), psi + rate * (share - 0.3));
            (pair, stance.center_of_mass_m)
        };
        let here = palms(0.3);
        let at = contacts(&here, psi);
        let (n, t) = (here.normal(palm), here.tangent(palm));
        // From the centre of mass, in the object's frame.
        let arm = [-at.r[k] * n[0] - at.d[k] * t[0], -at.r[k] * n[1] - at.d[k] * t[1]];
        let along = |share: f64| {
            let (pair, center) = place(share);
            let (sin, cos) = (rate * (share - 0.3)).sin_cos();
            let point = [center[0] + cos * arm[0] - sin * arm[1], center[1] + sin * arm[0] + cos * arm[1]];
            let (base, t) = ([pair.base1_m, pair.base2_m][k], pair.tangent(palm));
            (point[0] - base[0]) * t[0] + (point[1] - base[1]) * t[1]
        };
        (along(0.3 + STEP) - along(0.3 - STEP)) / (2.0 * STEP)
    }

    #[test]
    fn slip_is_how_the_material_moves_along_the_palms() {
        let here = palms(0.3);
        let rates = PalmRates::between(&palms(0.0), &palms(1.0));
        for (psi, rate) in [(0.7, 0.4), (0.7, -1.3), (2.9, 0.0)] {
            let slip = Slip::new(&here, &here.angles(), &contacts(&here, psi), &rates);
            for k in 0..2 {
                let exact = slip.at(k, rate);
                assert!((exact - numeric(k, psi, rate)).abs() < 1e-9, "{k}: {exact} {}", numeric(k, psi, rate));
            }
        }
    }

    #[test]
    fn rolling_between_hinged_palms_needs_no_shape() {
        let (from, to) = (PalmPair::hinged(0.5, 1.2), PalmPair::hinged(0.7, 1.5));
        let at = contacts(&from, 0.7);
        let slip = Slip::new(&from, &from.angles(), &at, &PalmRates::between(&from, &to));
        let [s1, s2] = from.angles().positions(at.r, at.d);
        let cos2 = from.phi2_rad.cos();
        let expected = [0.2 + 0.3 * s2 / (s2 - s1 * cos2), 0.5 - 0.3 * s1 / (s1 - s2 * cos2)];
        for (k, expected) in expected.into_iter().enumerate() {
            assert!((slip.rolling_rate(k) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn between_palms_that_turn_as_one_an_object_turns_with_them() {
        // Rounding leaves 4e-16 of an opening.
        let (from, to) = (PalmPair::hinged(2.0, 0.5), PalmPair::hinged(2.1, 0.5 + 4e-16));
        let rates = PalmRates::between(&from, &to);
        for psi in [0.0, 1.0, 8.175_697_197_628] {
            let slip = Slip::new(&from, &from.angles(), &contacts(&from, psi), &rates);
            assert_eq!([slip.rolling_rate(0), slip.rolling_rate(1)], [rates.angles[0]; 2]);
        }
    }
}
