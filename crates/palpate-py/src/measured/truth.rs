//! `Truth`: the true shape and motion behind a log.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2};
use palpate::truth::TruePose;
use palpate::{Truth, compare};
use pyo3::prelude::*;

use crate::interop::arrays::{self, Column, Table};
use crate::interop::errors::OrRaise;
use crate::interop::pickled::{self, Pickled};
use crate::object::shape::{Shape, support_columns};

/// True shape and motion behind a log, where someone knows them.
///
/// Parameters
/// ----------
/// theta_rad : array_like of float, shape (m,)
///     Normal angles, increasing from 0 to below 2 pi, radians.
/// r_m : array_like of float, shape (m,)
///     Support function about the centre of mass there, metres.
/// time_s : array_like of float, shape (n,)
///     Times of the samples of the log, seconds.
/// psi_rad : array_like of float, shape (n,)
///     Orientation, radians.
/// com_m : array_like of float, shape (n, 2)
///     Centre of mass in the global frame, metres.
///
///
/// Raises
/// ------
/// InputError
///     If columns that belong together differ in length.
#[pyclass(frozen, module = "palpate", name = "Truth")]
pub struct TrueData {
    pub truth: Truth,
    /// numpy.ndarray: normal angles, shape (m,), radians; read-only, as all arrays here.
    #[pyo3(get)]
    theta_rad: Py<PyArray1<f64>>,
    /// numpy.ndarray: support function about the centre of mass there, shape (m,), metres.
    #[pyo3(get)]
    r_m: Py<PyArray1<f64>>,
    /// numpy.ndarray: times of the samples of the log, shape (n,), seconds.
    #[pyo3(get)]
    time_s: Py<PyArray1<f64>>,
    /// numpy.ndarray: orientation, shape (n,), radians.
    #[pyo3(get)]
    psi_rad: Py<PyArray1<f64>>,
    /// numpy.ndarray: centre of mass in the global frame, shape (n, 2), metres.
    #[pyo3(get)]
    com_m: Py<PyArray2<f64>>,
}

impl TrueData {
    /// With its arrays.
    pub fn of(py: Python<'_>, truth: Truth) -> Self {
        let (theta_rad, r_m) = support_columns(py, &truth.support);
        let com: Vec<[f64; 2]> = truth.motion.iter().map(|pose| [pose.com_x_m, pose.com_y_m]).collect();
        Self {
            theta_rad,
            r_m,
            time_s: arrays::column(py, truth.motion.iter().map(|pose| pose.time_s).collect()),
            psi_rad: arrays::column(py, truth.motion.iter().map(|pose| pose.psi_rad).collect()),
            com_m: arrays::table(py, &com),
            truth,
        }
    }
}

#[pymethods]
impl TrueData {
    #[new]
    fn new(
        py: Python<'_>,
        theta_rad: Column,
        r_m: Column,
        time_s: Column,
        psi_rad: Column,
        com_m: Table,
    ) -> PyResult<Self> {
        let (theta, r) = (arrays::values(&theta_rad), arrays::values(&r_m));
        let (time, psi) = (arrays::values(&time_s), arrays::values(&psi_rad));
        let com: Vec<[f64; 2]> = arrays::rows("com_m", &com_m)?;
        arrays::same_length(&[("theta_rad", theta.len()), ("r_m", r.len())])?;
        arrays::same_length(&[("time_s", time.len()), ("psi_rad", psi.len()), ("com_m", com.len())])?;
        let poses = time.into_iter().zip(psi).zip(com);
        let pose = |((time_s, psi_rad), [com_x_m, com_y_m]): ((f64, f64), [f64; 2])| TruePose {
            time_s,
            psi_rad,
            com_x_m,
            com_y_m,
        };
        Ok(Self::of(py, Truth { support: theta.into_iter().zip(r).collect(), motion: poses.map(pose).collect() }))
    }

    /// Read a truth folder, `shape.csv` and `motion.csv`.
    ///
    /// Parameters
    /// ----------
    /// folder : str or os.PathLike
    ///     The folder, such as `egg.truth`.
    ///
    /// Returns
    /// -------
    /// Truth
    ///     What is in it.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If a file is missing or unusable.
    #[staticmethod]
    fn load(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let truth = py.detach(|| palpate_io::read_truth(&folder)).or_raise()?;
        Ok(Self::of(py, truth))
    }

    /// Write a truth folder, whole or not at all, in place of an earlier one.
    ///
    /// Parameters
    /// ----------
    /// folder : str or os.PathLike
    ///     The folder; those on the way to it are made.
    ///
    /// Raises
    /// ------
    /// WriteError
    ///     If it cannot be written, or holds anything but an earlier truth.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| palpate_io::write_truth(&folder, &self.truth)).or_raise()
    }

    /// SupportFunction: the true shape as a Fourier series of at most 90 harmonics.
    #[getter]
    fn shape(&self) -> PyResult<Shape> {
        compare::true_support(&self.truth).or_raise().map(Shape)
    }

    fn __len__(&self) -> usize {
        self.truth.motion.len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.truth == other.truth
    }

    fn __repr__(&self) -> String {
        format!("<Truth: {} directions, {} poses>", self.truth.support.len(), self.truth.motion.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (&self.theta_rad, &self.r_m, &self.time_s, &self.psi_rad, &self.com_m);
        pickled::by_class::<Self>(py, arguments)
    }
}
