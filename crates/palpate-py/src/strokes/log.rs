//! `Strokes`: a log of a pivoting grasp.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use palpate::pivot::{PivotLog, PivotSample};
use pyo3::prelude::*;

use crate::interop::arrays::{self, Column};
use crate::interop::errors::OrRaise;

/// A log of strokes of a pivoting grasp: where an arm held the object, and where one pad felt it.
///
/// The other rig of Moll and Erdmann (2001), their figure 9. Arrays are read-only.
#[pyclass(frozen, module = "palpate", name = "Strokes")]
pub struct StrokesData {
    pub log: Arc<PivotLog>,
    /// str or None: the file that it was read from.
    #[pyo3(get)]
    pub name: Option<String>,
    /// numpy.ndarray: times of the samples, shape (n,), seconds.
    #[pyo3(get)]
    time_s: Py<PyArray1<f64>>,
    /// numpy.ndarray: where the arm held the pivot in the global frame, shape (n, 2), metres.
    #[pyo3(get)]
    pivot_m: Py<PyArray2<f64>>,
    /// numpy.ndarray: contact on the pad from its base point, shape (n,), metres; NaN without a contact.
    #[pyo3(get)]
    s_m: Py<PyArray1<f64>>,
}

impl StrokesData {
    pub fn of(py: Python<'_>, log: PivotLog, name: Option<String>) -> Self {
        let samples = &log.samples;
        let pivot: Vec<[f64; 2]> = samples.iter().map(|sample| [sample.pivot_x_m, sample.pivot_y_m]).collect();
        Self {
            time_s: arrays::column(py, samples.iter().map(|sample| sample.time_s).collect()),
            pivot_m: arrays::table(py, &pivot),
            s_m: arrays::sparse_column(py, samples.iter().map(|sample| sample.s_m)),
            name,
            log: Arc::new(log),
        }
    }
}

#[pymethods]
impl StrokesData {
    /// A log from columns of numbers.
    ///
    /// Parameters
    /// ----------
    /// time_s : array_like of float, shape (n,)
    ///     Times, increasing, seconds.
    /// pivot_x_m, pivot_y_m : array_like of float, shape (n,)
    ///     Where the arm held the object, metres; gravity acts along -y.
    /// s_m : array_like of float, shape (n,)
    ///     Where the pad felt it, along the pad from its base point, metres; NaN where no contact was seen.
    /// swing_period_s : float, optional
    ///     Period of small swings of the lifted object about the pivot, seconds: it tells how far the centre of mass is.
    #[new]
    #[pyo3(signature = (time_s, pivot_x_m, pivot_y_m, s_m, *, swing_period_s=None))]
    fn new(
        py: Python<'_>,
        time_s: Column,
        pivot_x_m: Column,
        pivot_y_m: Column,
        s_m: Column,
        swing_period_s: Option<f64>,
    ) -> PyResult<Self> {
        let [time, x, y, s] = [&time_s, &pivot_x_m, &pivot_y_m, &s_m].map(arrays::values);
        let names = [("time_s", &time), ("pivot_x_m", &x), ("pivot_y_m", &y), ("s_m", &s)];
        arrays::same_length(&names.map(|(name, column)| (name, column.len())))?;
        let samples = (0..time.len()).map(|index| PivotSample {
            time_s: time[index],
            pivot_x_m: x[index],
            pivot_y_m: y[index],
            s_m: (!s[index].is_nan()).then_some(s[index]),
        });
        Ok(Self::of(py, PivotLog { samples: samples.collect(), swing_period_s }, None))
    }

    /// Read a log from a CSV file.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The file, with columns for time, pivot_x, pivot_y and s, whose names carry units as in `time_s`.
    ///
    /// Returns
    /// -------
    /// Strokes
    ///     The log.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If the file cannot be read or is no such log.
    #[staticmethod]
    fn from_csv(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = py.detach(|| palpate_io::read_strokes(&path)).or_raise()?;
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        Ok(Self::of(py, file.log, name))
    }

    /// Write the log as a CSV file, which reads back to the same numbers.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The file, written whole or not at all.
    ///
    /// Raises
    /// ------
    /// WriteError
    ///     If it cannot be written.
    fn to_csv(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| palpate_io::write_strokes(&path, &self.log, &[])).or_raise()
    }

    /// float or None: period of small swings of the lifted object, seconds, where it is known.
    #[getter]
    fn swing_period_s(&self) -> Option<f64> {
        self.log.swing_period_s
    }

    fn __len__(&self) -> usize {
        self.log.samples.len()
    }

    fn __repr__(&self) -> String {
        let felt = self.log.samples.iter().filter(|sample| sample.s_m.is_some()).count();
        format!("<Strokes: {} samples, {felt} with a contact>", self.log.samples.len())
    }
}

/// A log, or the file of one.
#[derive(FromPyObject)]
pub enum StrokesGiven {
    Log(Py<StrokesData>),
    Path(PathBuf),
}

impl StrokesGiven {
    pub fn read(self, py: Python<'_>) -> PyResult<Py<StrokesData>> {
        match self {
            Self::Log(log) => Ok(log),
            Self::Path(path) => Py::new(py, StrokesData::from_csv(py, path)?),
        }
    }
}
