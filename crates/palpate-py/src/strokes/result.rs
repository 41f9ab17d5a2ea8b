//! `StrokesResult`: shape about the pivot and motion, with error bars and a verdict.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2};
use palpate::pivot::{PivotPose, PivotPosterior, PivotReconstruction, PivotRig, PivotTruthError, compare_strokes};
use palpate::reconstruct::OutlinePoint;
use palpate_io::StrokesSummary;
use palpate_report::{StrokesInput, StrokesTruthOverlay, strokes_page};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::interop::arrays;
use crate::interop::errors::{InternalError, OrRaise};
use crate::interop::whole::Whole;
use crate::measured::truth::TrueData;
use crate::object::shape::Shape;
use crate::strokes::log::StrokesData;

/// Shape about the pivot and motion of the object behind a log of strokes, with error bars and a verdict.
///
/// The object frame has its origin at the pivot and is turned so that psi of the first contact is 0. Made by `reconstruct_strokes`. Arrays are
/// read-only; m is the number of normal angles (720), n that of samples.
#[pyclass(frozen, module = "palpate", name = "StrokesResult")]
pub struct StrokesResult {
    found: PivotReconstruction,
    posterior: PivotPosterior,
    rig: PivotRig,
    /// Strokes: the log that was reconstructed.
    #[pyo3(get)]
    log: Py<StrokesData>,
    /// float: how long the reconstruction took.
    #[pyo3(get)]
    seconds: f64,
    /// numpy.ndarray: normal angles in the object frame, evenly spread over [0, 2 pi), shape (m,), radians.
    #[pyo3(get)]
    theta: Py<PyArray1<f64>>,
    /// numpy.ndarray: support function about the pivot, shape (m,), metres.
    #[pyo3(get)]
    r: Py<PyArray1<f64>>,
    /// numpy.ndarray: standard deviation of r after the best rotation, shape (m,), metres.
    #[pyo3(get)]
    r_sd: Py<PyArray1<f64>>,
    /// numpy.ndarray: boundary points in the object frame, shape (m, 2), metres.
    #[pyo3(get)]
    boundary: Py<PyArray2<f64>>,
    /// numpy.ndarray: how many separate passes of the contact went over each angle, shape (m,); 0 = never felt.
    #[pyo3(get)]
    touches: Py<PyArray1<u32>>,
    /// numpy.ndarray: times of the samples, shape (n,), seconds.
    #[pyo3(get)]
    time: Py<PyArray1<f64>>,
    /// numpy.ndarray: orientation, shape (n,), radians; NaN without a contact or where it could not be placed.
    #[pyo3(get)]
    psi: Py<PyArray1<f64>>,
    /// numpy.ndarray: standard deviation of the orientation, shape (n,), radians; NaN as psi is.
    #[pyo3(get)]
    psi_sd: Py<PyArray1<f64>>,
    /// numpy.ndarray: measured minus predicted height of the pivot over the pad, shape (n,), metres; NaN as psi is.
    #[pyo3(get)]
    height_residual: Py<PyArray1<f64>>,
    /// numpy.ndarray: measured minus predicted offset of the contact from the foot of the pivot, shape (n,), metres; NaN as psi is.
    #[pyo3(get)]
    offset_residual: Py<PyArray1<f64>>,
}

impl StrokesResult {
    pub fn of(
        py: Python<'_>,
        (found, posterior): (PivotReconstruction, PivotPosterior),
        log: Py<StrokesData>,
        rig: PivotRig,
        seconds: f64,
    ) -> Self {
        let along = |value: fn(&OutlinePoint) -> f64| arrays::column(py, found.outline.iter().map(value).collect());
        let left = |value: fn(&PivotPose) -> Option<f64>| arrays::sparse_column(py, found.motion.iter().map(value));
        let boundary: Vec<[f64; 2]> = found.outline.iter().map(|point| [point.x_m, point.y_m]).collect();
        Self {
            log,
            rig,
            seconds,
            theta: along(|point| point.theta_rad),
            r: along(|point| point.r_m),
            r_sd: along(|point| point.r_sd_m),
            boundary: arrays::table(py, &boundary),
            touches: arrays::column(py, found.outline.iter().map(|point| point.touches).collect()),
            time: arrays::column(py, found.motion.iter().map(|pose| pose.time_s).collect()),
            psi: left(|pose| pose.psi_rad),
            psi_sd: left(|pose| pose.psi_sd_rad),
            height_residual: left(|pose| pose.height_residual_m),
            offset_residual: left(|pose| pose.offset_residual_m),
            found,
            posterior,
        }
    }

    /// What was found, and what is left open of it.
    pub fn known(&self) -> (&PivotReconstruction, &PivotPosterior) {
        (&self.found, &self.posterior)
    }

    /// Angle of the pad against the horizontal, radians, as the log has it.
    pub fn tilt_rad(&self) -> f64 {
        self.rig.pad.tilt_rad + self.found.calibration.tilt_rad
    }

    /// Centre of mass from the pivot, metres, where direction and distance are told.
    pub fn center_of_mass_m(&self) -> Option<[f64; 2]> {
        let center = self.found.center_of_mass?;
        let (sin, cos) = center.direction_rad.sin_cos();
        center.distance_m.map(|distance_m| [distance_m * cos, distance_m * sin])
    }

    fn errors(&self, truth: Option<&TrueData>) -> PyResult<Option<PivotTruthError>> {
        truth.map(|truth| compare_strokes(&self.found, &truth.truth)).transpose().or_raise()
    }

    fn page(&self, truth: Option<&TrueData>, errors: Option<PivotTruthError>, title: Option<&str>) -> String {
        let log = self.log.get();
        strokes_page(&StrokesInput {
            title: title.or(log.name.as_deref()).unwrap_or("Strokes"),
            log: &log.log,
            rig: &self.rig,
            reconstruction: &self.found,
            truth: truth.zip(errors).map(|(truth, errors)| StrokesTruthOverlay { truth: &truth.truth, errors }),
            seconds: self.seconds,
            command: None,
            version: env!("CARGO_PKG_VERSION"),
        })
    }
}

#[pymethods]
impl StrokesResult {
    /// bool: shape and motion are consistent with the log, unique and convex: they can be relied on within their error bars.
    #[getter]
    fn certified(&self) -> bool {
        self.found.is_certified()
    }

    /// list of str: why the result is not certified, a sentence and what to do about it each; empty where it is.
    #[getter]
    fn doubts(&self) -> Vec<String> {
        self.found.doubts.iter().map(|doubt| format!("{doubt}. {}", doubt.next_step())).collect()
    }

    /// SupportFunction: the shape about the pivot.
    #[getter]
    fn shape(&self) -> Shape {
        Shape(self.found.shape.clone())
    }

    /// float: fraction of the boundary that was felt, 0 to 1.
    #[getter]
    fn coverage(&self) -> f64 {
        self.found.coverage
    }

    /// float or None: direction from the pivot to the centre of mass in the object frame, radians; None where strokes do not tell it.
    #[getter]
    fn center_of_mass_direction_rad(&self) -> Option<f64> {
        self.found.center_of_mass.map(|center| center.direction_rad)
    }

    /// dict: what `summary.json` in a result folder says.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let json = StrokesSummary::new(&self.found, None).to_json();
        let json = json.map_err(|error| InternalError::new_err(format!("summary.json: {error}")))?;
        Ok(py.import("json")?.getattr("loads")?.call1((json,))?.cast_into::<PyDict>()?)
    }

    /// Write a result folder: report.html, shape.csv, motion.csv and summary.json, as `palpate reconstruct` does.
    ///
    /// Parameters
    /// ----------
    /// folder : str or os.PathLike
    ///     The folder, made if missing, written whole or not at all; an earlier result in it is replaced.
    /// truth : Truth, optional
    ///     What is true, to compare with.
    /// title : str, optional
    ///     Heading of the report. Default: the name of the log.
    ///
    /// Raises
    /// ------
    /// WriteError
    ///     If the folder cannot be written, or holds anything but an earlier result.
    /// CompareError
    ///     If the truth does not belong to the log.
    #[pyo3(signature = (folder, *, truth=None, title=None))]
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        truth: Option<PyRef<TrueData>>,
        title: Option<&str>,
    ) -> PyResult<()> {
        let truth = truth.as_deref();
        let errors = self.errors(truth)?;
        let summary = StrokesSummary::new(&self.found, errors.as_ref());
        let page = self.page(truth, errors, title);
        py.detach(|| palpate_io::write_strokes_result(&folder, &self.found, &summary, &page)).or_raise()
    }

    /// The report as one self-contained HTML page.
    ///
    /// Parameters
    /// ----------
    /// truth : Truth, optional
    ///     What is true, to compare with.
    /// title : str, optional
    ///     Heading. Default: the name of the log.
    ///
    /// Returns
    /// -------
    /// str
    ///     The page.
    ///
    /// Raises
    /// ------
    /// CompareError
    ///     If the truth does not belong to the log.
    #[pyo3(signature = (*, truth=None, title=None))]
    fn report_html(&self, truth: Option<PyRef<TrueData>>, title: Option<&str>) -> PyResult<String> {
        let truth = truth.as_deref();
        Ok(self.page(truth, self.errors(truth)?, title))
    }

    /// Show the report: in the notebook that calls, else in a browser.
    ///
    /// Parameters
    /// ----------
    /// truth : Truth, optional
    ///     What is true, to compare with.
    /// title : str, optional
    ///     Heading. Default: the name of the log.
    /// height : int, default 900
    ///     Height within a notebook, pixels.
    ///
    /// Raises
    /// ------
    /// CompareError
    ///     If the truth does not belong to the log.
    #[pyo3(signature = (*, truth=None, title=None, height=Whole(900)), text_signature = "($self, *, truth=None, title=None, height=900)")]
    fn show(&self, py: Python<'_>, truth: Option<PyRef<TrueData>>, title: Option<&str>, height: Whole) -> PyResult<()> {
        let page = self.report_html(truth, title)?;
        py.import("palpate._show")?.getattr("show_page")?.call1((page, height.small()))?;
        Ok(())
    }

    fn __repr__(&self) -> String {
        let verdict = if self.found.is_certified() { "certified" } else { "not certified" };
        let felt = 100.0 * self.found.coverage;
        format!("<StrokesResult: {verdict}, {felt:.0} % felt, {} samples>", self.found.motion.len())
    }
}
