//! The two-point contact constraint (eq. 2 and 3 of Moll & Erdmann 2001) and what follows from it, written once for simulator,
//! estimator, certificate and the paper's method; generic over one instant and eight in step.
//!
//! Both palms touch the object. Measured from the point M where the lines of the palms meet, with c the centre of mass:
//!
//! c · n̄_k = r_k,  s₁ = c · t̄₁ − d₁ = (r₁ cos φ₂ + r₂)/sin φ₂ − d₁,  s₂ = −c · t̄₂ + d₂ = (r₂ cos φ₂ + r₁)/sin φ₂ + d₂.
//!
//! Everything is linear in (r, d) at the contacts, so that a derivative is the same map of a change of (r, d): by ψ of
//! (d, v − r), since θ falls as ψ grows; by the coefficients of r(θ) of the rows of the basis.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::math::lanes::Number;
use crate::shape::ContactSupport;

/// Contact angles (θ₁, θ₂) of an object at orientation `psi`: θ₁ = φ₁ − ψ − π/2 (eq. 1), θ₂ = θ₁ + φ₂ − π. Radians.
pub(crate) fn contact_angles(phi1: f64, phi2: f64, psi: f64) -> (f64, f64) {
    let theta1 = phi1 - psi - FRAC_PI_2;
    (theta1, theta1 + phi2 - PI)
}

/// The angles of both palms at one instant, by their sines and cosines: φ₁ and φ₁₂ = φ₁ + φ₂ against the horizontal, φ₂ between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PalmAngles<N = f64> {
    pub sin1: N,
    pub cos1: N,
    pub sin12: N,
    pub cos12: N,
    pub sin2: N,
    pub cos2: N,
    /// 1 / sin φ₂.
    pub inverse2: N,
}

/// Support function r, d = −r' and radius of curvature v at contact 1 and contact 2, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contacts<N = f64> {
    pub r: [N; 2],
    pub d: [N; 2],
    pub v: [N; 2],
}

/// A linear functional of (r, d, v) at the contacts: the derivative of a residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactRow<N = f64> {
    pub r: [N; 2],
    pub d: [N; 2],
    pub v: [N; 2],
}

impl<N: Number> ContactRow<N> {
    /// This row and `factor` times another.
    #[inline(always)]
    pub fn plus(&self, factor: N, other: &Self) -> Self {
        let sum = |a: [N; 2], b: [N; 2]| [a[0] + factor * b[0], a[1] + factor * b[1]];
        Self { r: sum(self.r, other.r), d: sum(self.d, other.d), v: sum(self.v, other.v) }
    }
}

impl PalmAngles {
    /// Of palms at φ₁ and φ₁ + φ₂, radians.
    pub fn new(phi1: f64, phi2: f64) -> Self {
        let ((sin1, cos1), (sin12, cos12)) = (phi1.sin_cos(), (phi1 + phi2).sin_cos());
        let (sin2, cos2) = phi2.sin_cos();
        Self { sin1, cos1, sin12, cos12, sin2, cos2, inverse2: 1.0 / sin2 }
    }
}

impl From<[ContactSupport; 2]> for Contacts {
    fn from([one, two]: [ContactSupport; 2]) -> Self {
        Self { r: [one.r, two.r], d: [one.d, two.d], v: [one.v, two.v] }
    }
}

impl<N: Number> Contacts<N> {
    /// Derivatives of (r, d) by ψ: d and v − r.
    #[inline(always)]
    pub fn by_psi(&self) -> ([N; 2], [N; 2]) {
        (self.d, [self.v[0] - self.r[0], self.v[1] - self.r[1]])
    }
}

impl<N: Number> PalmAngles<N> {
    /// Cosines and sines of both contact angles, from the sine and cosine of φ₁ − ψ.
    #[inline(always)]
    pub fn contact_directions(&self, sin: N, cos: N) -> ([N; 2], [N; 2]) {
        let (cos1, sin1) = (sin, -cos);
        let cos2 = sin1 * self.sin2 - cos1 * self.cos2;
        let sin2 = -(sin1 * self.cos2 + cos1 * self.sin2);
        ([cos1, cos2], [sin1, sin2])
    }

    /// Contact positions (s₁, s₂) from M (eq. 3).
    #[inline(always)]
    pub fn positions(&self, r: [N; 2], d: [N; 2]) -> [N; 2] {
        [(r[0] * self.cos2 + r[1]) * self.inverse2 - d[0], (r[1] * self.cos2 + r[0]) * self.inverse2 + d[1]]
    }

    /// (d₁, d₂) from the contact positions: eq. 3 solved for them.
    #[inline(always)]
    pub fn feet(&self, r: [N; 2], s: [N; 2]) -> [N; 2] {
        let [p1, p2] = self.positions(r, [N::ZERO; 2]);
        [p1 - s[0], s[1] - p2]
    }

    /// The positions as functions of (r, d): what the mixture `share` of both makes of r₁, r₂, d₁ and d₂ (the adjoint of
    /// [`Self::positions`]).
    #[inline(always)]
    pub fn positions_row(&self, share: [N; 2]) -> ContactRow<N> {
        let ratio = self.cos2 * self.inverse2;
        ContactRow {
            r: [share[0] * ratio + share[1] * self.inverse2, share[0] * self.inverse2 + share[1] * ratio],
            d: [-share[0], share[1]],
            v: [N::ZERO; 2],
        }
    }

    /// Centre of mass (x, y) from M, between the supporting lines r₁ and r₂.
    #[inline(always)]
    pub fn center(&self, r: [N; 2]) -> [N; 2] {
        [(r[0] * self.cos12 + r[1] * self.cos1) * self.inverse2, (r[0] * self.sin12 + r[1] * self.sin1) * self.inverse2]
    }

    /// (r₁, r₂) of a centre of mass: c · n̄₁ and c · n̄₂.
    #[inline(always)]
    pub fn supports_of_center(&self, [x, y]: [N; 2]) -> [N; 2] {
        [y * self.cos1 - x * self.sin1, x * self.sin12 - y * self.cos12]
    }

    /// Derivatives of [`Self::positions`] by the angles of palm 1 and palm 2, each against the horizontal: `[palm][contact]`.
    /// ψ stays, so the contacts move over the object.
    #[inline(always)]
    pub fn positions_by_palms(&self, at: &Contacts<N>) -> [[N; 2]; 2] {
        let (square, ratio) = (self.inverse2 * self.inverse2, self.cos2 * self.inverse2);
        // By φ₂ alone: −(r₁ + r₂ cos φ₂)/sin²φ₂ and its mirror image. By θ: r' = −d, d' = r − v.
        let of1 = (at.r[0] + at.r[1] * self.cos2) * square;
        let of2 = (at.r[1] + at.r[0] * self.cos2) * square;
        [
            [of1 - at.d[0] * ratio - (at.r[0] - at.v[0]), of2 - at.d[0] * self.inverse2],
            [-of1 - at.d[1] * self.inverse2, -of2 - at.d[1] * ratio + (at.r[1] - at.v[1])],
        ]
    }

    /// Derivatives of [`Self::center`] by the angles of palm 1 and palm 2: `[palm][x, y]`; ψ stays.
    #[inline(always)]
    pub fn center_by_palms(&self, at: &Contacts<N>) -> [[N; 2]; 2] {
        let ([x, y], ratio) = (self.center(at.r), self.cos2 * self.inverse2);
        [
            [
                x * ratio - (at.r[1] * self.sin1 + at.d[0] * self.cos12) * self.inverse2,
                y * ratio + (at.r[1] * self.cos1 - at.d[0] * self.sin12) * self.inverse2,
            ],
            [
                -(x * ratio) - (at.r[0] * self.sin12 + at.d[1] * self.cos1) * self.inverse2,
                (at.r[0] * self.cos12 - at.d[1] * self.sin1) * self.inverse2 - y * ratio,
            ],
        ]
    }
}

impl PalmAngles {
    /// X of the centre of mass from M straight from the contact positions: in balance without friction the three lines of force meet
    /// in one point (eq. 10).
    pub fn balance_x(&self, s1: f64, s2: f64) -> f64 {
        (s1 * self.sin12 - s2 * self.sin1) / self.sin2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{LANES, Lanes};
    use crate::palms::PalmPair;
    use crate::shape::SupportFunction;

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    /// Palm angles and contacts for palms at the angles p₁ and p₂ against the horizontal.
    fn setting(p1: f64, p2: f64, psi: f64) -> (PalmAngles, Contacts) {
        let angles = PalmAngles::new(p1, p2 - p1);
        let (theta1, theta2) = contact_angles(p1, p2 - p1, psi);
        (angles, Contacts::from([shape().at(theta1), shape().at(theta2)]))
    }

    const P1: f64 = 0.6;
    const P2: f64 = 1.9;
    const PSI: f64 = 0.7;

    #[test]
    fn positions_are_where_the_outline_touches_the_palms() {
        let (angles, at) = setting(P1, P2, PSI);
        let palms = PalmPair::hinged(P1, P2 - P1);
        let [s1, s2] = angles.positions(at.r, at.d);
        let (point1, point2) = palms.contact_points_m(s1, s2);
        let [x, y] = angles.center(at.r);
        let (theta1, theta2) = palms.contact_angles(PSI);
        let (sin, cos) = PSI.sin_cos();
        for (theta, point) in [(theta1, point1), (theta2, point2)] {
            let on = shape().boundary_point(theta);
            let [u, v] = [x + cos * on.x_m - sin * on.y_m, y + sin * on.x_m + cos * on.y_m];
            assert!((u - point[0]).abs() < 1e-15 && (v - point[1]).abs() < 1e-15, "{u} {v} {point:?}");
        }
    }

    #[test]
    fn feet_and_supports_invert_positions_and_center() {
        let (angles, at) = setting(P1, P2, PSI);
        let feet = angles.feet(at.r, angles.positions(at.r, at.d));
        let supports = angles.supports_of_center(angles.center(at.r));
        for k in 0..2 {
            assert!((feet[k] - at.d[k]).abs() < 1e-15 && (supports[k] - at.r[k]).abs() < 1e-15);
        }
    }

    #[test]
    fn the_row_is_the_adjoint_of_the_positions() {
        let (angles, at) = setting(P1, P2, PSI);
        let share = [0.3, -1.7];
        let row = angles.positions_row(share);
        let [s1, s2] = angles.positions(at.r, at.d);
        let applied: f64 = (0..2).map(|k| row.r[k] * at.r[k] + row.d[k] * at.d[k] + row.v[k] * at.v[k]).sum();
        assert!((applied - (share[0] * s1 + share[1] * s2)).abs() < 1e-15);
    }

    #[test]
    fn directions_are_those_of_the_contact_angles() {
        let (angles, _) = setting(P1, P2, PSI);
        let (sin, cos) = (P1 - PSI).sin_cos();
        let (cosines, sines) = angles.contact_directions(sin, cos);
        let (theta1, theta2) = contact_angles(P1, P2 - P1, PSI);
        for (k, theta) in [theta1, theta2].into_iter().enumerate() {
            assert!((cosines[k] - theta.cos()).abs() < 1e-15 && (sines[k] - theta.sin()).abs() < 1e-15);
        }
    }

    #[test]
    fn derivatives_by_psi_and_by_the_palms_match_finite_differences() {
        const STEP: f64 = 1e-6;
        let values = |p1: f64, p2: f64, psi: f64| {
            let (angles, at) = setting(p1, p2, psi);
            let ([s1, s2], [x, y]) = (angles.positions(at.r, at.d), angles.center(at.r));
            [s1, s2, x, y]
        };
        let slope = |d1: f64, d2: f64, d3: f64| -> [f64; 4] {
            let plus = values(P1 + STEP * d1, P2 + STEP * d2, PSI + STEP * d3);
            let minus = values(P1 - STEP * d1, P2 - STEP * d2, PSI - STEP * d3);
            std::array::from_fn(|i| (plus[i] - minus[i]) / (2.0 * STEP))
        };
        let (angles, at) = setting(P1, P2, PSI);
        let (by_palms, center_by_palms) = (angles.positions_by_palms(&at), angles.center_by_palms(&at));
        let (r, d) = at.by_psi();
        let by_psi = [angles.positions(r, d), angles.center(r)].concat();
        for (exact, numeric) in [
            (by_psi, slope(0.0, 0.0, 1.0)),
            ([by_palms[0], center_by_palms[0]].concat(), slope(1.0, 0.0, 0.0)),
            ([by_palms[1], center_by_palms[1]].concat(), slope(0.0, 1.0, 0.0)),
        ] {
            for i in 0..4 {
                assert!((exact[i] - numeric[i]).abs() < 1e-10, "{exact:?} {numeric:?}");
            }
        }
    }

    #[test]
    fn eight_in_step_are_the_same_as_one_at_a_time() {
        let at = |lane: usize| setting(P1 + 0.05 * lane as f64, P2 - 0.03 * lane as f64, PSI + 0.1 * lane as f64);
        let each: [(PalmAngles, Contacts); LANES] = std::array::from_fn(at);
        let gather = |value: &dyn Fn(&(PalmAngles, Contacts)) -> f64| Lanes::from_fn(|lane| value(&each[lane]));
        let angles = PalmAngles {
            sin1: gather(&|(a, _)| a.sin1),
            cos1: gather(&|(a, _)| a.cos1),
            sin12: gather(&|(a, _)| a.sin12),
            cos12: gather(&|(a, _)| a.cos12),
            sin2: gather(&|(a, _)| a.sin2),
            cos2: gather(&|(a, _)| a.cos2),
            inverse2: gather(&|(a, _)| a.inverse2),
        };
        let pair = |value: fn(&Contacts) -> [f64; 2]| [0, 1].map(|k| gather(&|(_, c)| value(c)[k]));
        let contacts = Contacts { r: pair(|c| c.r), d: pair(|c| c.d), v: pair(|c| c.v) };
        let (positions, by_palms) = (angles.positions(contacts.r, contacts.d), angles.positions_by_palms(&contacts));
        for (lane, (angles, contacts)) in each.iter().enumerate() {
            let alone = (angles.positions(contacts.r, contacts.d), angles.positions_by_palms(contacts));
            for k in 0..2 {
                assert_eq!(positions[k][lane], alone.0[k]);
                assert_eq!([by_palms[0][k][lane], by_palms[1][k][lane]], [alone.1[0][k], alone.1[1][k]]);
            }
        }
    }
}
