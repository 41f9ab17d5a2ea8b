//! `EnergyLandscape`, `RestPose` and `follow`: where the object rests, and where it jumps to.

use std::convert::Infallible;
use std::f64::consts::PI;

use palpate::mechanics::{EnergyLandscape, RestPose};
use palpate::palms::{PalmPair, SMALLEST_OPENING_RAD};
use palpate::simulate::SimulateError as RustSimulateError;
use pyo3::prelude::*;

use crate::estimate::jump::JumpData;
use crate::interop::arrays::{self, Numbers};
use crate::interop::errors::OrRaise;
use crate::interop::pickled::{self, Pickled};
use crate::interop::work;
use crate::object::shape::{Shape, finite};
use crate::palms_motion::palms::Palms;

/// The height of the centre of mass over all orientations of an object between two still palms.
///
/// Parameters
/// ----------
/// shape : SupportFunction
///     The object.
/// palms : PalmPair
///     The palms, neither parallel nor crossed.
///
/// Raises
/// ------
/// SimulateError
///     If the palms are parallel or crossed.
#[pyclass(frozen, module = "palpate", name = "EnergyLandscape")]
pub struct Landscape {
    shape: Shape,
    palms: Palms,
    landscape: EnergyLandscape,
}

/// Palms between which an object can rest.
fn open(palms: &PalmPair) -> PyResult<()> {
    let phi2_rad = palms.phi2_rad;
    if phi2_rad > SMALLEST_OPENING_RAD && phi2_rad < PI - SMALLEST_OPENING_RAD {
        return Ok(());
    }
    Err(RustSimulateError::Parallel { time_s: 0.0, phi2_rad }).or_raise()
}

#[pymethods]
impl Landscape {
    #[new]
    fn new(shape: &Shape, palms: &Palms) -> PyResult<Self> {
        open(&palms.0)?;
        let landscape = EnergyLandscape::new(&shape.0, &palms.0);
        Ok(Self { shape: shape.clone(), palms: palms.clone(), landscape })
    }

    /// Height of the centre of mass over the origin.
    ///
    /// Parameters
    /// ----------
    /// psi_rad : float or array_like of float
    ///     Orientation, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray
    ///     Height in metres, in the shape of the input.
    fn height_m<'py>(&self, py: Python<'py>, psi_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &psi_rad, |psi| self.landscape.height_m(psi))
    }

    /// Balance g = d1 sin(phi12) + d2 sin(phi1), 0 where force and torque balance.
    ///
    /// Parameters
    /// ----------
    /// psi_rad : float or array_like of float
    ///     Orientation, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray
    ///     g in metres, in the shape of the input.
    fn balance_m<'py>(&self, py: Python<'py>, psi_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &psi_rad, |psi| self.landscape.balance_m(psi))
    }

    /// Slope of the balance; positive where a balanced pose is stable.
    ///
    /// Parameters
    /// ----------
    /// psi_rad : float or array_like of float
    ///     Orientation, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray
    ///     dg/dpsi in metres, in the shape of the input.
    fn balance_slope_m<'py>(&self, py: Python<'py>, psi_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &psi_rad, |psi| self.landscape.balance_slope_m(psi))
    }

    /// bool: whether every orientation is balanced alike, as for a disc with its mass in the centre.
    #[getter]
    fn is_flat(&self) -> bool {
        self.landscape.is_flat()
    }

    /// All stable poses.
    ///
    /// Returns
    /// -------
    /// list of RestPose
    ///     In order of psi, 0 to 2 pi; empty on a flat landscape.
    fn stable_poses(&self) -> Vec<Rest> {
        self.landscape.stable_poses().into_iter().map(Rest).collect()
    }

    /// The minimum of the energy reached by going downhill all the way.
    ///
    /// Parameters
    /// ----------
    /// psi_rad : float
    ///     Where to start, radians.
    ///
    /// Returns
    /// -------
    /// float
    ///     Orientation at rest, radians, unwrapped.
    fn descend(&self, psi_rad: f64) -> f64 {
        self.landscape.descend(psi_rad)
    }

    fn __repr__(&self) -> String {
        format!("<EnergyLandscape: {} stable poses>", self.landscape.stable_poses().len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (self.shape.clone(), self.palms.clone());
        pickled::by_class::<Self>(py, arguments)
    }
}

/// A stable pose of an object between two still palms.
#[pyclass(frozen, eq, module = "palpate", name = "RestPose")]
#[derive(Clone, PartialEq)]
pub struct Rest(RestPose);

#[pymethods]
impl Rest {
    /// float: orientation, radians, 0 to 2 pi.
    #[getter]
    fn psi_rad(&self) -> f64 {
        self.0.psi_rad
    }

    /// float: height of the centre of mass over the origin, metres.
    #[getter]
    fn height_m(&self) -> f64 {
        self.0.height_m
    }

    /// float: second derivative of the height by psi, metres; 0 where the pose is about to vanish.
    #[getter]
    fn stiffness_m(&self) -> f64 {
        self.0.stiffness_m
    }

    fn __repr__(&self) -> String {
        let RestPose { psi_rad, height_m, stiffness_m } = self.0;
        format!("<RestPose: psi {psi_rad:.4} rad, height {height_m:.5} m, stiffness {stiffness_m:.5} m>")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (self.0.psi_rad, self.0.height_m, self.0.stiffness_m);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(psi_rad: f64, height_m: f64, stiffness_m: f64) -> Self {
        Self(RestPose { psi_rad, height_m, stiffness_m })
    }
}

/// Follow a stable pose while the palms move evenly from one pair to another.
///
/// Parameters
/// ----------
/// shape : SupportFunction
///     The object.
/// start, end : PalmPair
///     The palms before and after.
/// psi_rad : float
///     Orientation at the start, radians; if it is not stable, the object first goes downhill.
///
/// Returns
/// -------
/// psi_rad : float
///     Orientation at the end, radians, unwrapped.
/// jumps : list of Jump
///     The jumps on the way. Their times run from 0 (`start`) to 1 (`end`).
///
/// Raises
/// ------
/// SimulateError
///     If the palms are parallel or crossed at either end.
#[pyfunction]
pub fn follow(
    py: Python<'_>,
    shape: &Shape,
    start: &Palms,
    end: &Palms,
    psi_rad: f64,
) -> PyResult<(f64, Vec<JumpData>)> {
    finite("psi_rad", &[psi_rad])?;
    open(&start.0)?;
    open(&end.0)?;
    let (shape, start, end) = (shape.0.clone(), start.0, end.0);
    let followed = work::run(py, None, None, move |_| {
        palpate::mechanics::follow::<Infallible>(&shape, (0.0, start), (1.0, end), psi_rad, |_, _, _| Ok(()))
    })?;
    let (psi, jumps) = match followed {
        Ok(found) => found,
        Err(never) => match never {},
    };
    Ok((psi, jumps.into_iter().map(JumpData).collect()))
}
