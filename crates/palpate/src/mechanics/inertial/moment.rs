//! The moment of the forces on an object in motion between turning palms whose base points stay.
//!
//! With p_k the angle of palm k against the horizontal, σ_k the place of its contact along t̄_k from its base point (s₁ and −s₂) and Ω = ψ', the
//! centre of mass c obeys
//!
//! c'·n̄_k = p_k' σ_k + d_k Ω,
//! c''·n̄_k = p_k'' σ_k + d_k Ω' + 2 p_k' c'·t̄_k + r_k Ω (2 p_k' − Ω) + v_k (p_k' − Ω)²,
//!
//! linear in r, d and v at the contacts, and (c·t̄₁, c·t̄₂) = ((c·n̄₁ cos φ₂ + c·n̄₂), −(c·n̄₁ + c·n̄₂ cos φ₂))/sin φ₂ for any vector. Newton's law
//! gives the contact forces N_k (n̄_k + τ_k t̄_k), and Euler's the moment about the centre of mass less what turns the object; times D over the
//! weight (`coulomb/cone.rs`) that is
//!
//! W = [n₁ (r₁τ₁ − d₁) + n₂ (r₂τ₂ − d₂) − D k² (Ω' + λ Ω)]/g,  n₁ = τ₂ a·n̄₂ − a·t̄₂,  n₂ = a·t̄₁ − τ₁ a·n̄₁,  a = c'' + g Ȳ,
//!
//! a length that vanishes. k is the radius of gyration and λ the rate at which a drag on the rotation damps it. At rest W is that of
//! [`coulomb`](crate::mechanics::coulomb), and without friction −g of [`frictionless`](crate::mechanics::frictionless).

use crate::mechanics::coulomb::{Ratios, opening};
use crate::mechanics::force_model::MotionState;
use crate::mechanics::gravity::STANDARD_GRAVITY_M_PER_S2;
use crate::palms::{ContactRow, Contacts, PalmAngles};

/// How an object resists being turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inertia {
    /// Square of the radius of gyration about the centre of mass, m².
    pub gyration_m2: f64,
    /// Drag on the rotation over the moment of inertia, 1/s.
    pub damping_per_s: f64,
}

/// W and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InertialMoment {
    /// W, metres.
    pub value_m: f64,
    /// By r, d and v at the contacts.
    pub row: ContactRow,
    /// By ψ', metres times seconds.
    pub by_psi_rate: f64,
    /// By ψ'', metres times seconds squared.
    pub by_psi_acceleration: f64,
    /// By the square of the radius of gyration, 1/m.
    pub by_gyration_m2: f64,
    /// By the damping, metres times seconds.
    pub by_damping: f64,
    /// Normal forces over the weight.
    pub normal_forces: [f64; 2],
}

impl InertialMoment {
    /// The derivative of W by ψ, from the contacts and the derivatives of v by θ there, metres.
    pub fn by_psi(&self, at: &Contacts, v_by_theta: [f64; 2]) -> f64 {
        let ((r, d), row) = (at.by_psi(), &self.row);
        (0..2).map(|k| row.r[k] * r[k] + row.d[k] * d[k] - row.v[k] * v_by_theta[k]).sum()
    }
}

/// Components along t̄₁ and t̄₂ of the vector with these components along n̄₁ and n̄₂.
fn along_tangents(palms: &PalmAngles, n: [f64; 2]) -> [f64; 2] {
    let [first, second] = palms.positions(n, [0.0; 2]);
    [first, -second]
}

/// The adjoint of [`along_tangents`].
fn along_tangents_row(palms: &PalmAngles, t: [f64; 2]) -> [f64; 2] {
    palms.positions_row([t[0], -t[1]]).r
}

/// How far each contact lies along t̄_k from its base point, metres.
fn along_palms(state: &MotionState) -> [f64; 2] {
    let (at, outwards) = (&state.contacts, along_tangents(&state.palms, state.contacts.r));
    [outwards[0] - at.d[0] - state.base_shifts_m[0], outwards[1] - at.d[1] + state.base_shifts_m[1]]
}

/// Radii of curvature at the contacts of an object in this motion whose contacts move along their palms (t̄_k) at these rates, m/s: by slip and by
/// rolling, σ_k' = c'·t̄_k + r_k Ω + v_k (p_k' − Ω). 0 where a contact does not move over the object.
pub(crate) fn radii_of_curvature_in_motion_m(state: &MotionState, rates_m_per_s: [f64; 2]) -> [f64; 2] {
    let MotionState { palms, contacts: at, palm_rates: p, psi_rate, .. } = state;
    let sigma = along_palms(state);
    let velocity_t = along_tangents(palms, [0, 1].map(|k| p[k] * sigma[k] + at.d[k] * psi_rate));
    [0, 1].map(|k| {
        let rolled = rates_m_per_s[k] - velocity_t[k] - at.r[k] * psi_rate;
        let over_object = p[k] - psi_rate;
        if over_object == 0.0 { 0.0 } else { rolled / over_object }
    })
}

impl Inertia {
    /// W of an object in this motion, with these ratios of the forces at its contacts.
    pub fn moment(&self, state: &MotionState, tau: Ratios) -> InertialMoment {
        const G: f64 = STANDARD_GRAVITY_M_PER_S2;
        let MotionState { palms, contacts: at, palm_rates: p, palm_accelerations, psi_rate, psi_acceleration, .. } =
            state;
        let sigma = along_palms(state);
        let velocity_n = [0, 1].map(|k| p[k] * sigma[k] + at.d[k] * psi_rate);
        let velocity_t = along_tangents(palms, velocity_n);
        let by_r = [0, 1].map(|k| psi_rate * (2.0 * p[k] - psi_rate));
        let by_v = [0, 1].map(|k| (p[k] - psi_rate).powi(2));
        let acceleration_n = [0, 1].map(|k| {
            palm_accelerations[k] * sigma[k]
                + at.d[k] * psi_acceleration
                + 2.0 * p[k] * velocity_t[k]
                + at.r[k] * by_r[k]
                + at.v[k] * by_v[k]
        });
        let acceleration_t = along_tangents(palms, acceleration_n);
        let a_n = [acceleration_n[0] + G * palms.cos1, acceleration_n[1] - G * palms.cos12];
        let a_t = [acceleration_t[0] + G * palms.sin1, acceleration_t[1] - G * palms.sin12];
        let n = [tau[1] * a_n[1] - a_t[1], a_t[0] - tau[0] * a_n[0]];
        let arm = [0, 1].map(|k| at.r[k] * tau[k] - at.d[k]);
        let opening = opening(palms, tau);
        let turning = psi_acceleration + self.damping_per_s * psi_rate;
        let value_m = (n[0] * arm[0] + n[1] * arm[1] - opening * self.gyration_m2 * turning) / G;

        // By the accelerations of the centre of mass along both normals; then what each of them is made of.
        let (ratio, inverse) = (palms.cos2 * palms.inverse2, palms.inverse2);
        let by_acceleration =
            [(inverse * arm[0] + (ratio - tau[0]) * arm[1]) / G, ((tau[1] + ratio) * arm[0] + inverse * arm[1]) / G];
        let by_velocity_n = along_tangents_row(palms, [0, 1].map(|k| 2.0 * p[k] * by_acceleration[k]));
        let by_sigma = [0, 1].map(|k| by_acceleration[k] * palm_accelerations[k] + by_velocity_n[k] * p[k]);
        let of_sigma = along_tangents_row(palms, by_sigma);
        let row = ContactRow {
            r: [0, 1].map(|k| of_sigma[k] + by_acceleration[k] * by_r[k] + n[k] * tau[k] / G),
            d: [0, 1]
                .map(|k| by_acceleration[k] * psi_acceleration + by_velocity_n[k] * psi_rate - by_sigma[k] - n[k] / G),
            v: [0, 1].map(|k| by_acceleration[k] * by_v[k]),
        };
        let velocity_by_rate = along_tangents(palms, at.d);
        let by_rate: f64 = (0..2)
            .map(|k| {
                let of_acceleration = 2.0 * p[k] * velocity_by_rate[k] + 2.0 * (at.r[k] - at.v[k]) * (p[k] - psi_rate);
                by_acceleration[k] * of_acceleration
            })
            .sum();
        InertialMoment {
            value_m,
            row,
            by_psi_rate: by_rate - opening * self.gyration_m2 * self.damping_per_s / G,
            by_psi_acceleration: by_acceleration[0] * at.d[0] + by_acceleration[1] * at.d[1]
                - opening * self.gyration_m2 / G,
            by_gyration_m2: -opening * turning / G,
            by_damping: -opening * self.gyration_m2 * psi_rate / G,
            normal_forces: n.map(|n| n / (opening * G)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::coulomb;
    use crate::palms::{Palm, PalmPair};
    use crate::shape::SupportFunction;

    const INERTIA: Inertia = Inertia { gyration_m2: 5e-4, damping_per_s: 0.4 };
    const TAU: Ratios = [0.23, -0.31];
    /// Base points of palms that are not hinged, metres.
    const BASES: [[f64; 2]; 2] = [[4e-3, -1e-3], [-3e-3, 2e-3]];

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    /// Palms and ψ at some time, as polynomials of it.
    fn motion(t: f64) -> (PalmPair, f64) {
        let palms = PalmPair::hinged(0.6 + 1.5 * t - 4.0 * t * t, 1.3 - 0.8 * t + 6.0 * t * t);
        (PalmPair { base1_m: BASES[0], base2_m: BASES[1], ..palms }, 0.7 + 2.0 * t + 11.0 * t * t)
    }

    /// The state at that time.
    fn state(t: f64) -> MotionState {
        let (palms, psi) = motion(t);
        let (theta1, theta2) = palms.contact_angles(psi);
        let angles = palms.angles();
        MotionState {
            palms: angles,
            contacts: Contacts::from([shape().at(theta1), shape().at(theta2)]),
            base_shifts_m: palms.base_shifts_m(&angles),
            palm_rates: [1.5 - 8.0 * t, 0.7 + 4.0 * t],
            palm_accelerations: [-8.0, 4.0],
            psi_rate: 2.0 + 22.0 * t,
            psi_acceleration: 22.0,
        }
    }

    #[test]
    fn newton_and_euler_hold_with_the_accelerations_of_the_path() {
        const STEP: f64 = 1e-4;
        let center = |t: f64| {
            let (palms, psi) = motion(t);
            palms.stance(&palms.angles(), &shape(), psi).center_of_mass_m
        };
        let (before, here, after) = (center(-STEP), center(0.0), center(STEP));
        let acceleration = [0, 1].map(|axis| (before[axis] - 2.0 * here[axis] + after[axis]) / (STEP * STEP));
        let (palms, _) = motion(0.0);
        let at = state(0.0);
        let moment = INERTIA.moment(&at, TAU);
        let (mut force, mut turning) = ([0.0; 2], 0.0);
        for (k, palm) in [Palm::One, Palm::Two].into_iter().enumerate() {
            let (n, t) = (palms.normal(palm), palms.tangent(palm));
            let of_contact = [0, 1].map(|axis| moment.normal_forces[k] * (n[axis] + TAU[k] * t[axis]));
            let arm = [0, 1].map(|axis| -at.contacts.r[k] * n[axis] - at.contacts.d[k] * t[axis]);
            turning += arm[0] * of_contact[1] - arm[1] * of_contact[0];
            force = [force[0] + of_contact[0], force[1] + of_contact[1]];
        }
        let g = STANDARD_GRAVITY_M_PER_S2;
        assert!((force[0] - acceleration[0] / g).abs() < 1e-7, "{force:?} {acceleration:?}");
        assert!((force[1] - 1.0 - acceleration[1] / g).abs() < 1e-7, "{force:?} {acceleration:?}");
        let left = turning - INERTIA.gyration_m2 * (22.0 + 0.4 * 2.0) / g;
        assert!((moment.value_m - left * opening(&at.palms, TAU)).abs() < 1e-15, "{left}");
    }

    #[test]
    fn the_rates_of_the_contacts_give_the_radii_of_curvature() {
        const STEP: f64 = 1e-5;
        let positions = |t: f64| {
            let (palms, psi) = motion(t);
            let (s1, s2) = palms.contact_positions_m(&shape(), psi);
            [s1, -s2]
        };
        let (before, after) = (positions(-STEP), positions(STEP));
        let rates = [0, 1].map(|k| (after[k] - before[k]) / (2.0 * STEP));
        let at = state(0.0);
        let blank = MotionState { contacts: Contacts { v: [0.0; 2], ..at.contacts }, ..at };
        let found = radii_of_curvature_in_motion_m(&blank, rates);
        for (found, truth) in found.into_iter().zip(at.contacts.v) {
            assert!((found - truth).abs() < 1e-8, "{found} {truth}");
        }
        // A contact that does not move over the object tells nothing, and its radius is asked for nowhere.
        let rolling = MotionState { psi_rate: blank.palm_rates[0], ..blank };
        assert_eq!(radii_of_curvature_in_motion_m(&rolling, rates)[0], 0.0);
    }

    #[test]
    fn at_rest_it_is_the_moment_of_slow_palms() {
        let at = MotionState::at_rest(state(0.0).palms, state(0.0).contacts);
        for tau in [[0.0; 2], TAU] {
            let slow = coulomb::moment(&at.palms, &at.contacts, tau);
            assert!((INERTIA.moment(&at, tau).value_m - slow).abs() < 1e-16);
        }
    }

    #[test]
    fn derivatives_match_finite_differences() {
        const STEP: f64 = 1e-6;
        let here = state(0.0);
        let exact = INERTIA.moment(&here, TAU);
        let slope = |of: &dyn Fn(f64) -> f64| (of(STEP) - of(-STEP)) / (2.0 * STEP);
        let by_rate =
            slope(&|step| INERTIA.moment(&MotionState { psi_rate: here.psi_rate + step, ..here }, TAU).value_m);
        let by_acceleration = slope(&|step| {
            INERTIA.moment(&MotionState { psi_acceleration: here.psi_acceleration + step, ..here }, TAU).value_m
        });
        let (palms, psi) = motion(0.0);
        let (theta1, theta2) = palms.contact_angles(psi);
        let by_psi = slope(&|step| {
            let contacts = Contacts::from([shape().at(theta1 - step), shape().at(theta2 - step)]);
            INERTIA.moment(&MotionState { contacts, ..here }, TAU).value_m
        });
        let by_gyration =
            slope(&|step| Inertia { gyration_m2: INERTIA.gyration_m2 + step, ..INERTIA }.moment(&here, TAU).value_m);
        let by_damping = slope(&|step| {
            Inertia { damping_per_s: INERTIA.damping_per_s + step, ..INERTIA }.moment(&here, TAU).value_m
        });
        let v_by_theta = [theta1, theta2].map(|theta| slope(&|step| shape().at(theta + step).v));
        for (name, exact, numeric) in [
            ("rate", exact.by_psi_rate, by_rate),
            ("acceleration", exact.by_psi_acceleration, by_acceleration),
            ("psi", exact.by_psi(&here.contacts, v_by_theta), by_psi),
            ("gyration", exact.by_gyration_m2, by_gyration),
            ("damping", exact.by_damping, by_damping),
        ] {
            assert!((exact - numeric).abs() < 1e-7 * exact.abs().max(1e-2), "{name}: {exact} {numeric}");
        }
        for k in 0..2 {
            let changed = |change: &dyn Fn(&mut Contacts, f64)| {
                slope(&|step| {
                    let mut contacts = here.contacts;
                    change(&mut contacts, step);
                    INERTIA.moment(&MotionState { contacts, ..here }, TAU).value_m
                })
            };
            let numeric = [
                changed(&|contacts, step| contacts.r[k] += step),
                changed(&|contacts, step| contacts.d[k] += step),
                changed(&|contacts, step| contacts.v[k] += step),
            ];
            for (exact, numeric) in [exact.row.r[k], exact.row.d[k], exact.row.v[k]].into_iter().zip(numeric) {
                assert!((exact - numeric).abs() < 1e-8, "{exact} {numeric}");
            }
        }
    }
}
