//! `PalmPair`: what feels, at one instant.

use std::f64::consts::TAU;

use palpate::palms::{ContactRates, GeneralizedContactSupport, PalmPair};
use pyo3::prelude::*;

use crate::interop::arrays::four;
use crate::interop::errors;
use crate::interop::pickled::{self, Pickled};
use crate::object::shape::{Shape, finite};

/// Angles of palms stay within this many radians, as in a file: farther apart, a pose could not be followed in any time.
const MOST_TURNED_RAD: f64 = 2.0 * TAU;

/// Refuses palms that are turned too far. Angles that are no numbers are for others to refuse.
pub fn require_few_turns(palms: &PalmPair) -> PyResult<()> {
    if palms.phi1_rad.abs() > MOST_TURNED_RAD || palms.phi2_rad.abs() > MOST_TURNED_RAD {
        return Err(errors::input("the angles of the palms must lie within two turns".to_owned()));
    }
    Ok(())
}

/// Angles and base points of the two palms at one instant.
///
/// Palm 1 leaves its base point at the angle phi1 against the horizontal, palm 2 at phi1 + phi2. With both base points in the origin
/// they share a hinge.
///
/// Parameters
/// ----------
/// phi1_rad : float
///     Angle of palm 1 against the X axis, radians.
/// phi2_rad : float
///     Angle from palm 1 to palm 2, counter-clockwise, radians; an object can rest between 0 and pi.
/// base1_m, base2_m : tuple of float, default (0, 0)
///     Base points of the palms in the global frame (Y up), metres.
///
/// Raises
/// ------
/// InputError
///     If a number is not finite, or an angle beyond two turns.
#[pyclass(frozen, eq, module = "palpate", name = "PalmPair")]
#[derive(Clone, PartialEq)]
pub struct Palms(pub PalmPair);

#[pymethods]
impl Palms {
    #[new]
    #[pyo3(signature = (phi1_rad, phi2_rad, base1_m=(0.0, 0.0), base2_m=(0.0, 0.0)),
        text_signature = "(phi1_rad, phi2_rad, base1_m=(0.0, 0.0), base2_m=(0.0, 0.0))")]
    fn new(phi1_rad: f64, phi2_rad: f64, base1_m: (f64, f64), base2_m: (f64, f64)) -> PyResult<Self> {
        let palms = PalmPair { phi1_rad, phi2_rad, base1_m: base1_m.into(), base2_m: base2_m.into() };
        finite("angles and base points of palms", &[phi1_rad, phi2_rad, base1_m.0, base1_m.1, base2_m.0, base2_m.1])?;
        require_few_turns(&palms)?;
        Ok(Self(palms))
    }

    /// float: angle of palm 1 against the X axis, radians.
    #[getter]
    fn phi1_rad(&self) -> f64 {
        self.0.phi1_rad
    }

    /// float: angle from palm 1 to palm 2, radians.
    #[getter]
    fn phi2_rad(&self) -> f64 {
        self.0.phi2_rad
    }

    /// float: angle of palm 2 against the X axis, radians.
    #[getter]
    fn phi12_rad(&self) -> f64 {
        self.0.phi12_rad()
    }

    /// tuple of float: base point of palm 1, metres.
    #[getter]
    fn base1_m(&self) -> (f64, f64) {
        self.0.base1_m.into()
    }

    /// tuple of float: base point of palm 2, metres.
    #[getter]
    fn base2_m(&self) -> (f64, f64) {
        self.0.base2_m.into()
    }

    /// Normal angles at which an object touches the palms.
    ///
    /// Parameters
    /// ----------
    /// psi_rad : float
    ///     Orientation of the object, radians.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     theta1 and theta2 in the object frame, radians.
    fn contact_angles(&self, psi_rad: f64) -> (f64, f64) {
        self.0.contact_angles(psi_rad)
    }

    /// Where an object touches the palms.
    ///
    /// Parameters
    /// ----------
    /// shape : SupportFunction
    ///     The object.
    /// psi_rad : float
    ///     Its orientation, radians.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     s1 and s2, distances of the contacts from the base points, metres.
    fn contact_positions_m(&self, shape: &Shape, psi_rad: f64) -> (f64, f64) {
        self.0.contact_positions_m(&shape.0, psi_rad)
    }

    /// The contact points in the global frame.
    ///
    /// Parameters
    /// ----------
    /// s1_m, s2_m : float
    ///     Distances of the contacts from the base points, metres.
    ///
    /// Returns
    /// -------
    /// tuple of tuple of float
    ///     The points on palm 1 and on palm 2, metres.
    fn contact_points_m(&self, s1_m: f64, s2_m: f64) -> ((f64, f64), (f64, f64)) {
        let (point1, point2) = self.0.contact_points_m(s1_m, s2_m);
        (point1.into(), point2.into())
    }

    /// Generalised contact support functions from the readings (eq. 8 of Moll and Erdmann 2001).
    ///
    /// Parameters
    /// ----------
    /// s1_m, s2_m : float
    ///     Distances of the contacts from the base points, metres.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     r1, d1, r2 and d2: the vector between the contacts along the normal and the tangent at each, metres.
    fn generalized_support_m(&self, s1_m: f64, s2_m: f64) -> (f64, f64, f64, f64) {
        four(GeneralizedContactSupport::of_readings(&self.0, s1_m, s2_m))
    }

    /// The centre of mass of an object that touches both palms.
    ///
    /// Parameters
    /// ----------
    /// shape : SupportFunction
    ///     The object.
    /// psi_rad : float
    ///     Its orientation, radians.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     X and Y in the global frame, metres.
    fn center_of_mass_m(&self, shape: &Shape, psi_rad: f64) -> (f64, f64) {
        let (theta1, theta2) = self.0.contact_angles(psi_rad);
        self.0.center_of_mass_m(shape.0.at(theta1), shape.0.at(theta2)).into()
    }

    /// Normal forces that carry the weight of an object, without friction.
    ///
    /// Parameters
    /// ----------
    /// mass_kg : float
    ///     Mass of the object, kilograms.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     Forces of palm 1 and palm 2, newtons; negative where the object does not rest on both.
    fn contact_forces_n(&self, mass_kg: f64) -> (f64, f64) {
        palpate::mechanics::contact_forces_n(&self.0, mass_kg)
    }

    fn __repr__(&self) -> String {
        let PalmPair { phi1_rad, phi2_rad, base1_m, base2_m } = self.0;
        let bases = if base1_m == [0.0; 2] && base2_m == [0.0; 2] {
            String::new()
        } else {
            format!(", base1_m=({}, {}), base2_m=({}, {})", base1_m[0], base1_m[1], base2_m[0], base2_m[1])
        };
        format!("PalmPair(phi1_rad={phi1_rad}, phi2_rad={phi2_rad}{bases})")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (self.0.phi1_rad, self.0.phi2_rad, self.base1_m(), self.base2_m());
        pickled::by_class::<Self>(py, arguments)
    }
}

/// Radii of curvature at the two contacts from how fast the readings change (eq. 9 of Moll and Erdmann 2001).
///
/// Parameters
/// ----------
/// support_m : tuple of float
///     Generalised contact support functions r1, d1, r2 and d2, metres.
/// rates : tuple of float
///     How fast theta1 and phi2 (radians per second) and r1 and r2 (metres per second) change.
/// phi2_rad : float
///     Opening of the palms, radians.
///
/// Returns
/// -------
/// tuple of float or None
///     v1 and v2, metres; None for a contact that stands still on the object.
#[pyfunction]
pub fn radii_of_curvature_m(
    support_m: (f64, f64, f64, f64),
    rates: (f64, f64, f64, f64),
    phi2_rad: f64,
) -> (Option<f64>, Option<f64>) {
    let (r1, d1, r2, d2) = support_m;
    let (theta1_rad_per_s, phi2_rad_per_s, r1_m_per_s, r2_m_per_s) = rates;
    palpate::palms::radii_of_curvature_m(
        &GeneralizedContactSupport { r1, d1, r2, d2 },
        &ContactRates { theta1_rad_per_s, phi2_rad_per_s, r1_m_per_s, r2_m_per_s },
        phi2_rad,
    )
}
