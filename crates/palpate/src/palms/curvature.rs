//! Radii of curvature at the contacts from how fast the readings change (eq. 9 of Moll & Erdmann 2001; the printed equation
//! reads r where the generalised r̃ is meant).

use super::GeneralizedContactSupport;

/// How fast a palm log changes at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactRates {
    /// dθ₁/dt = φ₁' − ψ', radians per second.
    pub theta1_rad_per_s: f64,
    /// dφ₂/dt, radians per second.
    pub phi2_rad_per_s: f64,
    /// dr̃₁/dt, metres per second.
    pub r1_m_per_s: f64,
    /// dr̃₂/dt, metres per second.
    pub r2_m_per_s: f64,
}

/// Radii of curvature (v₁, v₂) at the two contacts, metres:
///
/// v₁ = −(r̃₂' + (θ' + φ₂') d̃₂) / (θ' sin φ₂), v₂ = −(r̃₁' + θ' d̃₁) / ((θ' + φ₂') sin φ₂), ' = d/dt.
///
/// A contact that stands still on the object (its normal angle does not change) tells nothing: `None`.
pub fn radii_of_curvature_m(
    contact: &GeneralizedContactSupport,
    rates: &ContactRates,
    phi2_rad: f64,
) -> (Option<f64>, Option<f64>) {
    let theta1 = rates.theta1_rad_per_s;
    let theta2 = theta1 + rates.phi2_rad_per_s;
    let sin2 = phi2_rad.sin();
    let quotient = |top: f64, bottom: f64| Some(-top / bottom).filter(|v| v.is_finite());
    (
        quotient(rates.r2_m_per_s + theta2 * contact.d2, theta1 * sin2),
        quotient(rates.r1_m_per_s + theta1 * contact.d1, theta2 * sin2),
    )
}
