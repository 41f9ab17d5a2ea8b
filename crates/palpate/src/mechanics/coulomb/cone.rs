//! Forces within the friction cones, and the balance that they keep with the weight.
//!
//! The force at contact k is N_k (n̄_k + τ_k t̄_k) with |τ_k| ≤ μ_k. The balance of forces gives, over the weight and with
//! D = (1 + τ₁τ₂) sin φ₂ + (τ₁ − τ₂) cos φ₂,
//!
//! N₁ = (sin φ₁₂ − τ₂ cos φ₁₂)/D,  N₂ = (sin φ₁ − τ₁ cos φ₁)/D,
//!
//! and the moment about the centre of mass, times D over the weight, is
//!
//! W = (sin φ₁₂ − τ₂ cos φ₁₂)(r₁τ₁ − d₁) + (sin φ₁ − τ₁ cos φ₁)(r₂τ₂ − d₂),
//!
//! a length, linear in the contacts and in each τ; without friction it is −g of [`frictionless`](crate::mechanics::frictionless). Where
//! D ≤ 0 for some τ within the cones the object jams between the palms: the forces that squeeze it may be of any size.

use crate::math::lanes::Number;
use crate::palms::{ContactRow, Contacts, PalmAngles};

/// Tangential over normal force at both contacts.
pub(crate) type Ratios<N = f64> = [N; 2];

/// Ratios at the edges of the cones: against slips with these signs.
pub(crate) fn at_the_edges(friction: [f64; 2], signs: [f64; 2]) -> Ratios {
    [-friction[0] * signs[0], -friction[1] * signs[1]]
}

/// N₁ D and N₂ D over the weight.
#[inline(always)]
pub(crate) fn levers<N: Number>(palms: &PalmAngles<N>, [tau1, tau2]: Ratios<N>) -> [N; 2] {
    [palms.sin12 - tau2 * palms.cos12, palms.sin1 - tau1 * palms.cos1]
}

/// W, metres: positive turns the object towards larger ψ.
#[inline(always)]
pub(crate) fn moment<N: Number>(palms: &PalmAngles<N>, at: &Contacts<N>, tau: Ratios<N>) -> N {
    let [n1, n2] = levers(palms, tau);
    n1 * (at.r[0] * tau[0] - at.d[0]) + n2 * (at.r[1] * tau[1] - at.d[1])
}

/// W as a function of r and d at the contacts.
#[inline(always)]
pub(crate) fn moment_row<N: Number>(palms: &PalmAngles<N>, tau: Ratios<N>) -> ContactRow<N> {
    let [n1, n2] = levers(palms, tau);
    ContactRow { r: [n1 * tau[0], n2 * tau[1]], d: [-n1, -n2], v: [N::ZERO; 2] }
}

/// The derivative of W by ψ, metres.
#[inline(always)]
pub(crate) fn moment_by_psi<N: Number>(palms: &PalmAngles<N>, at: &Contacts<N>, tau: Ratios<N>) -> N {
    let row = moment_row(palms, tau);
    let (r, d) = at.by_psi();
    row.r[0] * r[0] + row.r[1] * r[1] + row.d[0] * d[0] + row.d[1] * d[1]
}

/// The derivative of W, linear in each ratio, by that of contact `k`, metres.
#[inline(always)]
pub(crate) fn moment_by_ratio(palms: &PalmAngles, at: &Contacts, mut tau: Ratios, k: usize) -> f64 {
    tau[k] = 1.0;
    let with = moment(palms, at, tau);
    tau[k] = 0.0;
    with - moment(palms, at, tau)
}

/// The derivatives of W by the angles of palm 1 and palm 2 against the horizontal, ψ as it is, metres.
#[inline(always)]
pub(crate) fn moment_by_palms<N: Number>(palms: &PalmAngles<N>, at: &Contacts<N>, tau: Ratios<N>) -> [N; 2] {
    let [n1, n2] = levers(palms, tau);
    let arm = [at.r[0] * tau[0] - at.d[0], at.r[1] * tau[1] - at.d[1]];
    // θ_k grows with palm k: r' = −d and d' = r − v.
    let arm_by_theta = |k: usize| -(at.d[k] * tau[k]) - (at.r[k] - at.v[k]);
    [
        n1 * arm_by_theta(0) + (palms.cos1 + tau[0] * palms.sin1) * arm[1],
        n2 * arm_by_theta(1) + (palms.cos12 + tau[1] * palms.sin12) * arm[0],
    ]
}

/// D: positive unless the object jams.
#[inline(always)]
pub(crate) fn opening<N: Number>(palms: &PalmAngles<N>, [tau1, tau2]: Ratios<N>) -> N {
    palms.sin2 + tau1 * tau2 * palms.sin2 + (tau1 - tau2) * palms.cos2
}

/// The normal forces over the weight; `None` where the object jams.
pub(crate) fn normal_forces(palms: &PalmAngles, tau: Ratios) -> Option<[f64; 2]> {
    let opening = opening(palms, tau);
    (opening > 0.0).then(|| levers(palms, tau).map(|lever| lever / opening))
}

/// Derivatives of the normal forces over the weight by the ratio of contact `k`, where they are `normal`.
pub(crate) fn normal_forces_by_ratio(palms: &PalmAngles, tau: Ratios, normal: [f64; 2], k: usize) -> [f64; 2] {
    let opening_by = [tau[1] * palms.sin2 + palms.cos2, tau[0] * palms.sin2 - palms.cos2][k];
    // The ratio of one contact stands in the lever of the other.
    let levers_by = [[0.0, -palms.cos1], [-palms.cos12, 0.0]][k];
    let opening = opening(palms, tau);
    [0, 1].map(|of: usize| (levers_by[of] - normal[of] * opening_by) / opening)
}

/// The ratio at contact `k` at which W = 0 while the other contact has its ratio in `tau`: W is linear in it. `None` where W does not depend
/// on it.
pub(crate) fn balancing_ratio(palms: &PalmAngles, at: &Contacts, mut tau: Ratios, k: usize) -> Option<f64> {
    tau[k] = 0.0;
    let ratio = -moment(palms, at, tau) / moment_by_ratio(palms, at, tau, k);
    ratio.is_finite().then_some(ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::EnergyLandscape;
    use crate::palms::{Palm, PalmPair};
    use crate::shape::SupportFunction;

    const TAU: Ratios = [0.23, -0.31];

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    /// Palms at the angles p₁ and p₂ against the horizontal, and the contacts there.
    fn setting(p1: f64, p2: f64, psi: f64) -> (PalmPair, PalmAngles, Contacts) {
        let palms = PalmPair::hinged(p1, p2 - p1);
        let (theta1, theta2) = palms.contact_angles(psi);
        (palms, palms.angles(), Contacts::from([shape().at(theta1), shape().at(theta2)]))
    }

    #[test]
    fn forces_carry_the_weight_and_their_moment_is_w() {
        let (palms, angles, at) = setting(0.6, 1.9, 0.7);
        let forces = normal_forces(&angles, TAU).expect("not jammed");
        let (mut sum, mut moment_of_forces) = ([0.0; 2], 0.0);
        for (k, palm) in [Palm::One, Palm::Two].into_iter().enumerate() {
            let (n, t) = (palms.normal(palm), palms.tangent(palm));
            let force = [0, 1].map(|axis| forces[k] * (n[axis] + TAU[k] * t[axis]));
            // From the centre of mass to the contact: −r n̄ − d t̄.
            let arm = [0, 1].map(|axis| -at.r[k] * n[axis] - at.d[k] * t[axis]);
            moment_of_forces += arm[0] * force[1] - arm[1] * force[0];
            sum = [sum[0] + force[0], sum[1] + force[1]];
        }
        assert!(sum[0].abs() < 1e-15 && (sum[1] - 1.0).abs() < 1e-15, "{sum:?}");
        let expected = moment(&angles, &at, TAU) / opening(&angles, TAU);
        assert!((moment_of_forces - expected).abs() < 1e-16, "{moment_of_forces} {expected}");
    }

    #[test]
    fn without_friction_it_is_the_slope_of_the_potential_energy() {
        let (palms, angles, at) = setting(0.6, 1.9, 0.7);
        let landscape = EnergyLandscape::new(&shape(), &palms);
        assert!((moment(&angles, &at, [0.0; 2]) + landscape.balance_m(0.7)).abs() < 1e-16);
    }

    #[test]
    fn derivatives_match_finite_differences() {
        const STEP: f64 = 1e-6;
        let value = |p1: f64, p2: f64, psi: f64| {
            let (_, angles, at) = setting(p1, p2, psi);
            moment(&angles, &at, TAU)
        };
        let (_, angles, at) = setting(0.6, 1.9, 0.7);
        let numeric = [
            value(0.6 + STEP, 1.9, 0.7) - value(0.6 - STEP, 1.9, 0.7),
            value(0.6, 1.9 + STEP, 0.7) - value(0.6, 1.9 - STEP, 0.7),
            value(0.6, 1.9, 0.7 + STEP) - value(0.6, 1.9, 0.7 - STEP),
        ]
        .map(|difference| difference / (2.0 * STEP));
        let [by_palm1, by_palm2] = moment_by_palms(&angles, &at, TAU);
        for (exact, numeric) in [by_palm1, by_palm2, moment_by_psi(&angles, &at, TAU)].into_iter().zip(numeric) {
            assert!((exact - numeric).abs() < 1e-10, "{exact} {numeric}");
        }
    }

    #[test]
    fn normal_forces_follow_the_ratios_as_their_derivatives_say() {
        const STEP: f64 = 1e-6;
        let (_, angles, _) = setting(0.6, 1.9, 0.7);
        let normal = normal_forces(&angles, TAU).expect("not jammed");
        for k in 0..2 {
            let there = |step: f64| {
                let mut tau = TAU;
                tau[k] += step;
                normal_forces(&angles, tau).expect("not jammed")
            };
            let (more, less) = (there(STEP), there(-STEP));
            let exact = normal_forces_by_ratio(&angles, TAU, normal, k);
            for of in 0..2 {
                let numeric = (more[of] - less[of]) / (2.0 * STEP);
                assert!((exact[of] - numeric).abs() < 1e-9, "{k} {of}: {} {numeric}", exact[of]);
            }
        }
    }

    #[test]
    fn the_balancing_ratio_balances() {
        let (_, angles, at) = setting(0.6, 1.9, 0.7);
        for k in 0..2 {
            let mut tau = TAU;
            tau[k] = balancing_ratio(&angles, &at, TAU, k).expect("there is one");
            assert!(moment(&angles, &at, tau).abs() < 1e-16);
        }
    }

    #[test]
    fn narrow_palms_jam() {
        // tan 0.15 = 0.151: two cones of half that width meet.
        let (_, narrow, _) = setting(1.5, 1.65, 0.0);
        assert!(normal_forces(&narrow, [-0.08, 0.08]).is_none());
        assert!(normal_forces(&narrow, [-0.07, 0.07]).is_some());
    }
}
