//! `Information` and `posterior`: how well a log determines a shape.

use std::sync::Arc;

use numpy::PyArray1;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use palpate::information;
use pyo3::prelude::*;

use crate::estimate::result::ResultData;
use crate::interop::arrays::{self, Column, Numbers};
use crate::interop::errors::OrRaise;
use crate::interop::pickled::{self, Pickled};
use crate::interop::work;
use crate::measured::log::LogData;
use crate::object::shape::Shape;

/// What a log tells of a shape, as a covariance: the Cramer-Rao bound for a motion that is planned, or the posterior of a result.
///
/// A common rotation of shape and motion cannot be known and is no error: everything is after the best rotation over the felt boundary.
#[pyclass(frozen, eq, module = "palpate", name = "Information")]
#[derive(Clone, PartialEq)]
pub struct InformationData(pub information::Information);

#[pymethods]
impl InformationData {
    /// What the samples of a log tell of a shape, at known orientations and with exact balance.
    ///
    /// Of the log only the palms count, and which contacts were seen: planned motions can be judged before they are made.
    ///
    /// Parameters
    /// ----------
    /// log : Log
    ///     The palm log.
    /// shape : SupportFunction
    ///     The object.
    /// psi_rad : array_like of float, shape (n,)
    ///     Its orientation at each sample, radians.
    /// sensor_sd_m : float
    ///     Standard deviation of the contact positions, metres.
    ///
    /// Returns
    /// -------
    /// Information
    ///     What the log tells.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `psi_rad` is not as long as the log, a number is out of range, or the log does not determine the shape.
    #[staticmethod]
    fn of(py: Python<'_>, log: Py<LogData>, shape: &Shape, psi_rad: Column, sensor_sd_m: f64) -> PyResult<Self> {
        let (file, shape, psi) = (Arc::clone(&log.get().file), shape.0.clone(), arrays::values(&psi_rad));
        let of = move |_: &_| information::Information::of(&file.log, &shape, &psi, sensor_sd_m);
        work::run(py, None, None, of)?.or_raise().map(Self)
    }

    /// int: number of harmonics that count as unknown.
    #[getter]
    fn order(&self) -> usize {
        self.0.order()
    }

    /// numpy.ndarray of float, shape (m,): normal angles of the felt boundary, radians.
    #[getter]
    fn felt_rad(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        arrays::column(py, self.0.felt_rad().to_vec())
    }

    /// float: root mean square over the felt boundary of the standard deviation of r, metres.
    #[getter]
    fn rms_r_sd_m(&self) -> f64 {
        self.0.rms_r_sd_m()
    }

    /// float: standard deviation of the centre of mass in the object, metres (root of the mean of both variances).
    #[getter]
    fn center_of_mass_sd_m(&self) -> f64 {
        self.0.center_of_mass_sd_m()
    }

    /// numpy.ndarray of float, shape (2 K + 1, 2 K + 1): covariance of (a_0, a_1 ... a_K, b_1 ... b_K), square metres.
    #[getter]
    fn covariance_m2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let (values, size) = (self.0.covariance_m2(), 2 * self.0.order() + 1);
        Array2::from_shape_fn((size, size), |(row, column)| values[row * size + column]).into_pyarray(py)
    }

    /// Standard deviation of r.
    ///
    /// Parameters
    /// ----------
    /// theta_rad : array_like of float
    ///     Normal angles, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray of float
    ///     The standard deviation at each, metres.
    fn r_sd_m<'py>(&self, py: Python<'py>, theta_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &theta_rad, |theta| self.0.r_sd_m(theta))
    }

    /// The change of the shape that is known least.
    ///
    /// Returns
    /// -------
    /// sd_m : float
    ///     Standard deviation along it, metres.
    /// change : SupportFunction
    ///     The change of the support function by one standard deviation; no object of its own.
    fn weakest_direction(&self) -> (f64, Shape) {
        let information::WeakestDirection { sd_m, change } = self.0.weakest_direction();
        (sd_m, Shape(change))
    }

    fn __repr__(&self) -> String {
        format!(
            "<Information: r to {:.3e} m over the felt boundary, centre of mass to {:.3e} m, {} harmonics>",
            self.0.rms_r_sd_m(),
            self.0.center_of_mass_sd_m(),
            self.0.order()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        pickled::by_method::<Self>(py, "_made", (self.0.covariance_m2(), self.0.felt_rad().to_vec()))
    }

    #[staticmethod]
    fn _made(covariance_m2: Vec<f64>, felt_rad: Vec<f64>) -> PyResult<Self> {
        information::Information::from_parts(covariance_m2, felt_rad).or_raise().map(Self)
    }
}

/// The posterior of the shape of a result: what its error bars are made of.
///
/// Parameters
/// ----------
/// log : Log
///     The palm log that was reconstructed.
/// result : Result
///     What came of it, by maximum likelihood.
///
/// Returns
/// -------
/// Information
///     The posterior, in the frame of the result.
///
/// Raises
/// ------
/// InputError
///     If the two do not belong together, the result has no error bars, or the log does not determine the shape.
#[pyfunction]
pub fn posterior(py: Python<'_>, log: Py<LogData>, result: &ResultData) -> PyResult<InformationData> {
    let (found, file) = (Arc::clone(&result.found), Arc::clone(&log.get().file));
    let posterior = move |_: &_| information::posterior(&file.log, &found);
    work::run(py, None, None, posterior)?.or_raise().map(InformationData)
}
