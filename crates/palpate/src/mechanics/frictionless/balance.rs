//! Force/torque balance without friction: the lines of both contact forces and of gravity meet in one point (eq. 10 of Moll & Erdmann 2001).
//! With d̃₂ = −r₁ sin φ₂ − d₁ cos φ₂ − d₂ from the contact constraint (eq. 3 and 8) it becomes one short equation,
//!
//! g = d₁ sin φ₁₂ + d₂ sin φ₁ = 0.
//!
//! g is sin φ₂ times the derivative of the height of the centre of mass by ψ, so that a pose is stable where
//! g' = (v₁ − r₁) sin φ₁₂ + (v₂ − r₂) sin φ₁ > 0 (' by ψ). Its derivative by time, eq. 13 to 18 of the paper, ends in eq. 21 for ψ'
//! (`reconstruct/paper/equations.rs`).

use super::fold::followed;
use crate::math::lanes::Number;
use crate::mechanics::force_model::{ForceModel, ForceResidual, MotionState, SharedParameter};
use crate::mechanics::jump::Jump;
use crate::palms::{ContactRow, PalmPair};
use crate::shape::SupportFunction;

/// Slow palms without friction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frictionless;

impl ForceModel for Frictionless {
    const NEIGHBOURS: usize = 0;
    const READS_CURVATURE: bool = false;
    const PARAMETERS: &'static [SharedParameter] = &[];

    #[inline(always)]
    fn residual<N: Number>(&self, at: &MotionState<N>) -> ForceResidual<N> {
        let balance = |d: [N; 2]| d[0] * at.palms.sin12 + d[1] * at.palms.sin1;
        let (_, d_by_psi) = at.contacts.by_psi();
        ForceResidual { value: balance(at.contacts.d), by_psi: balance(d_by_psi), by_psi_rates: [N::ZERO; 2] }
    }

    #[inline(always)]
    fn row<N: Number>(&self, at: &MotionState<N>) -> ContactRow<N> {
        ContactRow { r: [N::ZERO; 2], d: [at.palms.sin12, at.palms.sin1], v: [N::ZERO; 2] }
    }

    #[inline(always)]
    fn by_palms<N: Number>(&self, at: &MotionState<N>) -> [N; 2] {
        let MotionState { palms, contacts: at, .. } = at;
        [
            (at.r[0] - at.v[0]) * palms.sin12 + at.d[1] * palms.cos1,
            at.d[0] * palms.cos12 + (at.r[1] - at.v[1]) * palms.sin1,
        ]
    }

    fn is_unstable(&self, residual: &ForceResidual, slack_m: f64, balance_m: f64) -> bool {
        residual.by_psi < -slack_m && residual.value.abs() < balance_m
    }

    fn advance(&self, shape: &SupportFunction, from: &PalmPair, to: &PalmPair, psi_rad: f64) -> (f64, Vec<Jump>) {
        followed(shape, from, to, psi_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::EnergyLandscape;
    use crate::palms::{Contacts, PalmAngles};

    const PSI: f64 = 0.7;

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    /// At rest between palms at the angles p₁ and p₂ against the horizontal.
    fn at(p1: f64, p2: f64, psi: f64) -> MotionState {
        let palms = PalmPair::hinged(p1, p2 - p1);
        let (theta1, theta2) = palms.contact_angles(psi);
        MotionState::at_rest(PalmAngles::new(p1, p2 - p1), Contacts::from([shape().at(theta1), shape().at(theta2)]))
    }

    #[test]
    fn balance_is_the_slope_of_the_potential_energy() {
        for psi in [0.0, 0.7, 2.9, 4.4] {
            let landscape = EnergyLandscape::new(&shape(), &PalmPair::hinged(0.6, 1.3));
            let ForceResidual { value, by_psi, .. } = Frictionless.residual(&at(0.6, 1.9, psi));
            assert!((value - landscape.balance_m(psi)).abs() < 1e-16);
            assert!((by_psi - landscape.balance_slope_m(psi)).abs() < 1e-16);
        }
    }

    #[test]
    fn derivatives_match_finite_differences() {
        const STEP: f64 = 1e-6;
        let value = |p1: f64, p2: f64, psi: f64| Frictionless.residual(&at(p1, p2, psi)).value;
        let here = at(0.6, 1.9, PSI);
        let by_psi = (value(0.6, 1.9, PSI + STEP) - value(0.6, 1.9, PSI - STEP)) / (2.0 * STEP);
        let by_palm1 = (value(0.6 + STEP, 1.9, PSI) - value(0.6 - STEP, 1.9, PSI)) / (2.0 * STEP);
        let by_palm2 = (value(0.6, 1.9 + STEP, PSI) - value(0.6, 1.9 - STEP, PSI)) / (2.0 * STEP);
        assert!((Frictionless.residual(&here).by_psi - by_psi).abs() < 1e-10);
        let exact = Frictionless.by_palms(&here);
        assert!((exact[0] - by_palm1).abs() < 1e-10 && (exact[1] - by_palm2).abs() < 1e-10);
    }

    #[test]
    fn the_row_applied_to_the_contacts_is_the_residual() {
        let here = at(0.6, 1.9, PSI);
        let (row, c) = (Frictionless.row(&here), here.contacts);
        let applied: f64 = (0..2).map(|k| row.r[k] * c.r[k] + row.d[k] * c.d[k] + row.v[k] * c.v[k]).sum();
        assert!((applied - Frictionless.residual(&here).value).abs() < 1e-18);
    }

    #[test]
    fn only_a_balanced_pose_at_no_minimum_is_unstable() {
        let at = |by_psi: f64, value: f64| ForceResidual { value, by_psi, by_psi_rates: [0.0; 2] };
        assert!(Frictionless.is_unstable(&at(-0.01, 1e-5), 0.0, 4e-5));
        assert!(!Frictionless.is_unstable(&at(0.01, 1e-5), 0.0, 4e-5), "at rest");
        assert!(!Frictionless.is_unstable(&at(-0.01, 5e-5), 0.0, 4e-5), "on its way");
        assert!(!Frictionless.is_unstable(&at(-0.01, 1e-5), 0.02, 4e-5), "within the slack");
    }
}
