//! `Result`: shape, motion and centre of mass, with error bars and a verdict.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use palpate::mechanics::ContactMode;
use palpate::reconstruct::{CenterStrip, Doubt, Jump, OutlinePoint, Pose, Verdict, center_strips, measured_forces};
use palpate::shape::SupportFunction;
use palpate::{Log, Reconstruction};
use palpate_io::Summary;
use palpate_report::{ReportInput, TruthOverlay};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::estimate::calibration;
use crate::estimate::doubt::DoubtData;
use crate::estimate::friction;
use crate::estimate::inertia;
use crate::estimate::jump::JumpData;
use crate::estimate::symmetry::SymmetryData;
use crate::interop::arrays::{self, Table};
use crate::interop::errors::{self, InternalError, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::interop::svg;
use crate::interop::whole::Whole;
use crate::measured::log::{LogData, escaped};
use crate::measured::truth::TrueData;
use crate::object::shape::Shape;

/// Friction and inertia of a pickled result.
type Forces = (Option<Vec<f64>>, Option<[f64; 6]>);

/// Shape, motion and centre of mass of the object behind a log, with error bars and a verdict.
///
/// The object frame has its origin at the centre of mass and is turned so that psi of the first sample is 0. Made by `reconstruct` or
/// `Result.load`. Arrays are read-only; m is the number of normal angles (720), n that of samples.
#[pyclass(frozen, module = "palpate", name = "Result")]
pub struct ResultData {
    pub found: Arc<Reconstruction>,
    /// Log or None: the log that was reconstructed; None after `Result.load`.
    ///
    /// The conventions of the rig are applied, and it is without the mistake that the first doubt may name.
    #[pyo3(get)]
    log: Option<Py<LogData>>,
    /// float: how long the reconstruction took.
    #[pyo3(get)]
    seconds: f64,
    /// numpy.ndarray: normal angles in the object frame, evenly spread over [0, 2 pi), shape (m,), radians.
    #[pyo3(get)]
    theta: Py<PyArray1<f64>>,
    /// numpy.ndarray: support function about the centre of mass, shape (m,), metres.
    #[pyo3(get)]
    r: Py<PyArray1<f64>>,
    /// numpy.ndarray: standard deviation of r after the best rotation, shape (m,), metres.
    #[pyo3(get)]
    r_sd: Py<PyArray1<f64>>,
    /// numpy.ndarray: boundary points in the object frame, shape (m, 2), metres.
    #[pyo3(get)]
    boundary: Py<PyArray2<f64>>,
    /// numpy.ndarray: radius of curvature, shape (m,), metres.
    #[pyo3(get)]
    curvature_radius: Py<PyArray1<f64>>,
    /// numpy.ndarray: how many separate passes of a contact went over each angle, shape (m,); 0 = never felt.
    ///
    /// Passes over a symmetric copy of it count too.
    #[pyo3(get)]
    touches: Py<PyArray1<u32>>,
    /// numpy.ndarray: whether a contact passed over each angle itself, shape (m,).
    ///
    /// Where `touches` is positive without, the boundary follows from symmetry. After `Result.load` it is what the poses say.
    #[pyo3(get)]
    felt_itself: Py<PyArray1<bool>>,
    /// numpy.ndarray: times of the samples, shape (n,), seconds.
    #[pyo3(get)]
    time: Py<PyArray1<f64>>,
    /// numpy.ndarray: orientation, unwrapped within a piece, shape (n,), radians.
    #[pyo3(get)]
    psi: Py<PyArray1<f64>>,
    /// numpy.ndarray: standard deviation of the orientation, shape (n,), radians.
    #[pyo3(get)]
    psi_sd: Py<PyArray1<f64>>,
    /// numpy.ndarray: centre of mass in the global frame, shape (n, 2), metres.
    #[pyo3(get)]
    com: Py<PyArray2<f64>>,
    /// numpy.ndarray: standard deviation of the centre of mass (root of the mean of both variances), shape (n,), metres.
    #[pyo3(get)]
    com_sd: Py<PyArray1<f64>>,
    /// numpy.ndarray: normal angle of the object at contact 1, shape (n,), radians.
    #[pyo3(get)]
    theta1: Py<PyArray1<f64>>,
    /// numpy.ndarray: normal angle of the object at contact 2, shape (n,), radians.
    #[pyo3(get)]
    theta2: Py<PyArray1<f64>>,
    /// numpy.ndarray: counts up at each jump, from 0, shape (n,).
    #[pyo3(get)]
    piece: Py<PyArray1<u32>>,
    /// numpy.ndarray: measured minus predicted position of contact 1, shape (n,), metres.
    ///
    /// NaN where no contact was seen, or after `Result.load`.
    #[pyo3(get)]
    residual1: Py<PyArray1<f64>>,
    /// numpy.ndarray: measured minus predicted position of contact 2, shape (n,), metres.
    ///
    /// NaN where no contact was seen, or after `Result.load`.
    #[pyo3(get)]
    residual2: Py<PyArray1<f64>>,
    /// numpy.ndarray: what contact 1 does under friction, shape (n,).
    ///
    /// 0 where the object sticks to the palm, 1 where it slides away from the base of the palm, -1 where it slides the other way; NaN where friction
    /// does not say.
    #[pyo3(get)]
    mode1: Py<PyArray1<f64>>,
    /// numpy.ndarray: what contact 2 does under friction, shape (n,).
    ///
    /// 0 where the object sticks to the palm, 1 where it slides towards the base of the palm, -1 where it slides the other way; NaN where friction
    /// does not say.
    #[pyo3(get)]
    mode2: Py<PyArray1<f64>>,
}

impl ResultData {
    /// With its arrays, and without the findings: a class of Python is what it shows, so that one that was pickled equals the first.
    pub fn of(py: Python<'_>, mut found: Reconstruction, log: Option<Py<LogData>>, seconds: f64) -> Self {
        found.findings = None;
        for other in &mut found.others {
            other.findings = None;
        }
        let along = |value: fn(&OutlinePoint) -> f64| arrays::column(py, found.outline.iter().map(value).collect());
        let over = |value: fn(&Pose) -> f64| arrays::column(py, found.motion.iter().map(value).collect());
        let left = |value: fn(&Pose) -> Option<f64>| arrays::sparse_column(py, found.motion.iter().map(value));
        let boundary: Vec<[f64; 2]> = found.outline.iter().map(|point| [point.x_m, point.y_m]).collect();
        let com: Vec<[f64; 2]> = found.motion.iter().map(|pose| [pose.com_x_m, pose.com_y_m]).collect();
        Self {
            log,
            seconds,
            theta: along(|point| point.theta_rad),
            r: along(|point| point.r_m),
            r_sd: along(|point| point.r_sd_m),
            boundary: arrays::table(py, &boundary),
            curvature_radius: along(|point| point.curvature_radius_m),
            touches: arrays::column(py, found.outline.iter().map(|point| point.touches).collect()),
            felt_itself: arrays::column(py, found.felt_itself()),
            time: over(|pose| pose.time_s),
            psi: over(|pose| pose.psi_rad),
            psi_sd: over(|pose| pose.psi_sd_rad),
            com: arrays::table(py, &com),
            com_sd: over(|pose| pose.com_sd_m),
            theta1: over(|pose| pose.theta1_rad),
            theta2: over(|pose| pose.theta2_rad),
            piece: arrays::column(py, found.motion.iter().map(|pose| pose.piece).collect()),
            residual1: left(|pose| pose.residual1_m),
            residual2: left(|pose| pose.residual2_m),
            mode1: left(|pose| mode(pose, 0)),
            mode2: left(|pose| mode(pose, 1)),
            found: Arc::new(found),
        }
    }

    /// What summary.json says.
    fn to_summary(&self, truth: Option<&TrueData>) -> PyResult<Summary> {
        let mut summary = Summary::new(&self.found, self.seconds);
        if let Some(log) = &self.log {
            summary.log.clone_from(&log.get().name);
            summary.notes.clone_from(&log.get().file.notes);
            summary = summary.with_forces(measured_forces(&log.get().file.log, &self.found).as_ref());
        }
        if let Some(truth) = truth {
            let errors = palpate::compare::compare(&self.found, &truth.truth).or_raise()?;
            summary.truth = Some(errors.into());
        }
        Ok(summary)
    }

    fn logged(&self) -> PyResult<&Log> {
        let log = self.log.as_ref().map(|log| &log.get().file.log);
        log.ok_or_else(|| {
            errors::input("this result was read from a folder and has no log, which the report shows".to_owned())
        })
    }

    fn page(&self, summary: &Summary, truth: Option<&TrueData>, title: Option<&str>) -> PyResult<String> {
        Ok(palpate_report::page(&self.report_input(summary, truth, title)?))
    }

    fn report_input<'a>(
        &'a self,
        summary: &'a Summary,
        truth: Option<&'a TrueData>,
        title: Option<&'a str>,
    ) -> PyResult<ReportInput<'a>> {
        let name = summary.log.as_deref();
        let overlay =
            truth.zip(summary.truth).map(|(truth, errors)| TruthOverlay { truth: &truth.truth, errors: errors.into() });
        Ok(ReportInput {
            title: title.or(name).unwrap_or("A palm log"),
            log: self.logged()?,
            reconstruction: &self.found,
            truth: overlay,
            seconds: summary.seconds,
            command: None,
            version: &summary.version,
        })
    }
}

#[pymethods]
impl ResultData {
    /// SupportFunction: the shape about its centre of mass.
    #[getter]
    fn shape(&self) -> Shape {
        Shape(self.found.shape.clone())
    }

    /// bool: shape and motion are statistically consistent with the log, unique and convex.
    #[getter]
    fn certified(&self) -> bool {
        self.found.is_certified()
    }

    /// bool: `certified`, and force and torque balance within the noise, so that the centre of mass can be trusted too.
    #[getter]
    fn com_certified(&self) -> bool {
        self.found.is_com_certified()
    }

    /// str: why not certified; empty when both verdicts are yes.
    #[getter]
    fn reason(&self) -> String {
        self.found.verdict.reason()
    }

    /// list of Doubt: the same one by one, with the numbers behind each; empty when both verdicts are yes.
    #[getter]
    fn doubts(&self) -> Vec<DoubtData> {
        self.found.verdict.doubts.iter().cloned().map(DoubtData).collect()
    }

    /// float: weighted squared residuals per degree of freedom; near 1 for a fit that is consistent with the noise.
    #[getter]
    fn chi2_per_dof(&self) -> f64 {
        self.found.chi2_per_dof
    }

    /// float: fraction of the boundary (in normal angle) that was felt, 0 to 1.
    #[getter]
    fn coverage(&self) -> f64 {
        self.found.coverage
    }

    /// Symmetry: how the object is symmetric, as far as the log can tell.
    #[getter]
    fn symmetry(&self) -> SymmetryData {
        SymmetryData(self.found.symmetry)
    }

    /// int: number of distinct arrangements that fit equally well; 1 when the answer is unique.
    #[getter]
    fn alternatives(&self) -> usize {
        self.found.alternatives
    }

    /// float: standard deviation of the contact positions, stated or estimated, metres.
    #[getter]
    fn sensor_sd_m(&self) -> f64 {
        self.found.sensor_sd_m
    }

    /// float: standard deviation of the balance equation, metres.
    #[getter]
    fn balance_sd_m(&self) -> f64 {
        self.found.balance_sd_m
    }

    /// dict of str to CalibrationConstant, or None: the constants of the rig as the log has them, by name.
    ///
    /// The names are 's1_zero_m', 's2_zero_m', 'scale_ratio', 'phi1_zero_rad', 'phi2_zero_rad', 'surface_difference_m' and
    /// 'clock_offset_s'. None where all constants are exact or there is no rig, and from the methods without error bars.
    #[getter]
    fn calibration<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.found.calibration.as_ref().map(|calibration| calibration::by_name(py, &calibration.constants)).transpose()
    }

    /// dict of str to float, or None: coefficients of friction of both palms, where friction explains the log.
    ///
    /// They are `mu1` and `mu2`, with `mu1_sd` and `mu2_sd`. The centre of mass is then that of Coulomb's law. None where the object slid
    /// without friction, or for a result that was read from a folder.
    #[getter]
    fn friction<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.found.friction.as_ref().map(|found| friction::by_name(py, found)).transpose()
    }

    /// dict of str to float, or None: what measured normal forces say.
    ///
    /// `weight_n` with `weight_sd_n` (by their noise alone), `mass_kg`, and `force_sd_n`, the standard deviation of a measured force. None where
    /// none were measured, where palms are so fast that inertia counts, or for a result that was read from a folder.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(log) = &self.log else { return Ok(None) };
        let Some(found) = measured_forces(&log.get().file.log, &self.found) else { return Ok(None) };
        let by_name = PyDict::new(py);
        by_name.set_item("weight_n", found.weight_n)?;
        by_name.set_item("weight_sd_n", found.weight_sd_n)?;
        by_name.set_item("mass_kg", found.mass_kg())?;
        by_name.set_item("force_sd_n", found.force_sd_n)?;
        Ok(Some(by_name))
    }

    /// numpy.ndarray or None: what each sample alone leaves to the centre of mass under friction, shape (n, 2), metres.
    ///
    /// The left and right edges of a strip, from where the centre of mass was found, along (cos psi, -sin psi) in the object frame; NaN where
    /// the object jams between the palms. None without friction, or for a result that was read from a folder.
    #[getter]
    fn com_strips(&self, py: Python<'_>) -> Option<Py<PyArray2<f64>>> {
        self.found.friction?;
        let strips = center_strips(&self.log.as_ref()?.get().file.log, &self.found);
        let edges = |strip: &Option<_>| strip.map_or([f64::NAN; 2], |CenterStrip { low_m, high_m }| [low_m, high_m]);
        Some(arrays::table(py, &strips.iter().map(edges).collect::<Vec<_>>()))
    }

    /// dict of str to float, or None: how the object resists being turned, where palms are so fast that it counts.
    ///
    /// `gyration_radius_m` (about the centre of mass) with `gyration_radius_sd_m`, and `uniform_gyration_radius_m`, that of an even mass;
    /// `damping_per_s` with `damping_sd_per_s`, the drag on the rotation over the moment of inertia; `static_balance_sd_m`, by how much balance
    /// alone is missed. None where balance holds, or for a result that was read from a folder.
    #[getter]
    fn inertia<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.found.inertia.as_ref().map(|found| inertia::by_name(py, found)).transpose()
    }

    /// float: relative standard deviation of the size, which no log tells.
    ///
    /// It comes from what the scales of both pads have in common; 0 without a `calibration`. `r_sd` is for the scales as stated.
    #[getter]
    fn size_sd(&self) -> f64 {
        self.found.calibration.as_ref().map_or(0.0, |calibration| calibration.size_sd)
    }

    /// float: standard deviation of a parallel shift of the boundary, which no log tells, metres.
    ///
    /// It comes from what both surface offsets have in common; 0 without a `calibration`. `r_sd` is for the offsets as stated.
    #[getter]
    fn offset_sd_m(&self) -> f64 {
        self.found.calibration.as_ref().map_or(0.0, |calibration| calibration.offset_sd_m)
    }

    /// list of Jump: the jumps to other poses, in order of time.
    #[getter]
    fn jumps(&self) -> Vec<JumpData> {
        self.found.jumps.iter().map(|jump| JumpData(*jump)).collect()
    }

    /// list of Result: the arrangements besides this one that fit equally well.
    #[getter]
    fn others(&self, py: Python<'_>) -> Vec<Self> {
        let log = || self.log.as_ref().map(|log| log.clone_ref(py));
        let others = self.found.others.iter();
        others.map(|other| Self::of(py, other.clone(), log(), self.seconds)).collect()
    }

    /// dict: what `summary.json` in a result folder says.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let json = self.to_summary(None)?.to_json();
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
    ///     What is true, to compare with in report and summary.
    /// title : str, optional
    ///     Heading of the report. Default: the name of the log.
    ///
    /// Raises
    /// ------
    /// WriteError
    ///     If the folder cannot be written, or holds anything but an earlier result.
    /// CompareError
    ///     If the truth does not belong to the log.
    /// InputError
    ///     If the result was read from a folder and has no log to show.
    #[pyo3(signature = (folder, *, truth=None, title=None))]
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        truth: Option<PyRef<TrueData>>,
        title: Option<&str>,
    ) -> PyResult<()> {
        let truth = truth.as_deref();
        let summary = self.to_summary(truth)?;
        let page = self.page(&summary, truth, title)?;
        py.detach(|| palpate_io::write_result(&folder, &self.found, &summary, &page)).or_raise()
    }

    /// Read a result folder.
    ///
    /// The shape is fitted to the outline in the folder, which holds neither the log nor the residuals.
    ///
    /// Parameters
    /// ----------
    /// folder : str or os.PathLike
    ///     The folder, written by `Result.save` or `palpate reconstruct`.
    ///
    /// Returns
    /// -------
    /// Result
    ///     What is in it.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If a file is missing or unusable.
    #[staticmethod]
    fn load(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let (mut found, summary) = loaded(py, &folder)?;
        for number in 1..summary.alternatives {
            let inside = palpate_io::alternative_dir_of(&folder, number);
            // The folder keeps the first few.
            if !inside.is_dir() {
                break;
            }
            found.others.push(loaded(py, &inside)?.0);
        }
        Ok(Self::of(py, found, None, summary.seconds))
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
    /// InputError
    ///     If the result was read from a folder and has no log to show.
    #[pyo3(signature = (*, truth=None, title=None))]
    fn report_html(&self, truth: Option<PyRef<TrueData>>, title: Option<&str>) -> PyResult<String> {
        let truth = truth.as_deref();
        self.page(&self.to_summary(truth)?, truth, title)
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
    /// InputError
    ///     If the result was read from a folder and has no log to show.
    #[pyo3(signature = (*, truth=None, title=None, height=Whole(900)), text_signature = "($self, *, truth=None, title=None, height=900)")]
    fn show(&self, py: Python<'_>, truth: Option<PyRef<TrueData>>, title: Option<&str>, height: Whole) -> PyResult<()> {
        let page = self.report_html(truth, title)?;
        py.import("palpate._show")?.getattr("show_page")?.call1((page, height.small()))?;
        Ok(())
    }

    /// The motion as an animated GIF: first palms and contacts alone, then what follows from them.
    ///
    /// In a notebook, `IPython.display.Image(result.animation())` plays it.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike, optional
    ///     Where to write it. Default: it is returned.
    ///
    /// Returns
    /// -------
    /// bytes or None
    ///     The GIF file; None where it was written.
    ///
    /// Raises
    /// ------
    /// WriteError
    ///     If it cannot be written.
    /// InputError
    ///     If the result was read from a folder and has no log to show, or nothing moves.
    #[pyo3(signature = (path=None))]
    fn animation<'py>(&self, py: Python<'py>, path: Option<PathBuf>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let summary = self.to_summary(None)?;
        let input = self.report_input(&summary, None, None)?;
        let gif = py.detach(|| palpate_report::animation(&input)).map_err(|error| errors::input(error.to_string()))?;
        match path {
            Some(path) => py.detach(|| palpate_io::write_whole(&path, &gif)).or_raise().map(|()| None),
            None => Ok(Some(PyBytes::new(py, &gif))),
        }
    }

    /// The motion, or the shape, as a pandas data frame.
    ///
    /// Parameters
    /// ----------
    /// table : {'motion', 'shape'}
    ///     'motion': a row for each sample, with time as index and the columns of `motion.csv`, and the residuals. 'shape': a row for each
    ///     normal angle, which is the index, with the columns of `shape.csv`.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     The table, in SI units and radians.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If there is no such table.
    #[pyo3(signature = (table="motion"))]
    fn to_pandas<'py>(slf: &Bound<'py, Self>, table: &str) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._pandas")?.getattr("frame_of_result")?.call1((slf, table))
    }

    /// Draw the outline with its 95 % band, in millimetres.
    ///
    /// Where the boundary was never felt it is dashed; a cross marks the centre of mass.
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib.axes.Axes, optional
    ///     Where to draw; by default in a new figure.
    /// truth : Truth, optional
    ///     What is true, drawn beside it, turned by what the motions differ.
    /// magnify : float, default 1
    ///     The band is drawn so many times wider than it is.
    ///
    /// Returns
    /// -------
    /// matplotlib.axes.Axes
    ///     The axes drawn in.
    #[pyo3(signature = (ax=None, *, truth=None, magnify=1.0))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        ax: Option<Bound<'py, PyAny>>,
        truth: Option<Bound<'py, TrueData>>,
        magnify: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._plot")?.getattr("plot_result")?.call1((slf, ax, truth, magnify))
    }

    /// Draw orientation and centre of mass over time, with 95 % bands.
    ///
    /// Parameters
    /// ----------
    /// axes : sequence of matplotlib.axes.Axes, optional
    ///     Two of them; by default in a new figure.
    /// truth : Truth, optional
    ///     What is true, drawn beside it, turned by what the motions differ.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     The two axes drawn in.
    #[pyo3(signature = (axes=None, *, truth=None))]
    fn plot_motion<'py>(
        slf: &Bound<'py, Self>,
        axes: Option<Bound<'py, PyAny>>,
        truth: Option<Bound<'py, TrueData>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._plot")?.getattr("plot_motion")?.call1((slf, axes, truth))
    }

    /// Draw measured minus predicted contact positions over time, in micrometres.
    ///
    /// Dashed lines are two standard deviations of the sensor noise, between which 95 % of them should lie.
    ///
    /// Parameters
    /// ----------
    /// axes : sequence of matplotlib.axes.Axes, optional
    ///     Two of them, one for each palm; by default in a new figure.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     The two axes drawn in.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If the result was read from a folder and has no residuals.
    #[pyo3(signature = (axes=None))]
    fn plot_residuals<'py>(slf: &Bound<'py, Self>, axes: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._plot")?.getattr("plot_residuals")?.call1((slf, axes))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.found == other.found
    }

    fn __repr__(&self) -> String {
        format!(
            "<Result: {}; {} samples, {:.0} % felt, {} jumps{}>",
            self.verdict(),
            self.found.motion.len(),
            100.0 * self.found.coverage,
            self.found.jumps.len(),
            if self.found.calibration.is_some() { ", rig estimated" } else { "" }
        )
    }

    fn _repr_html_(&self) -> String {
        let found = &self.found;
        let item = |doubt: &Doubt| {
            let (what, next) = (escaped(&doubt.to_string()), escaped(&doubt.next_step()));
            let next = if next.is_empty() { next } else { format!("<br>{next} <code>{}</code>", doubt.docs()) };
            format!("<li>{what}{next}</li>")
        };
        let items: String = found.verdict.doubts.iter().map(item).collect();
        let reason = if items.is_empty() { items } else { format!("<ul>{items}</ul>") };
        let symmetric = found.symmetry.symmetry.is_any();
        let symmetry = symmetric.then(|| format!("<p>The object is {}.</p>", escaped(&found.symmetry.to_string())));
        let mut rows = vec![
            ("mean radius".to_owned(), format!("{:.3} mm", 1e3 * found.shape.mean_radius_m())),
            ("boundary felt".to_owned(), format!("{:.0} %", 100.0 * found.coverage)),
            ("sensor noise".to_owned(), format!("{:.2} &micro;m", 1e6 * found.sensor_sd_m)),
            ("&chi;&sup2; per degree of freedom".to_owned(), format!("{:.3}", found.chi2_per_dof)),
            ("samples".to_owned(), found.motion.len().to_string()),
            ("jumps".to_owned(), found.jumps.len().to_string()),
            ("arrangements that fit".to_owned(), found.alternatives.to_string()),
        ];
        if let Some(calibration) = &found.calibration {
            let (size, offset_mm) = (100.0 * calibration.size_sd, 1e3 * calibration.offset_sd_m);
            rows.push((
                "size known to, as the rig is".to_owned(),
                format!("{size:.2} %, and {offset_mm:.3} mm all around"),
            ));
            rows.extend(calibration::told(calibration));
        }
        let rows: String =
            rows.iter().map(|(name, value)| format!("<tr><td>{name}</td><td>{value}</td></tr>")).collect();
        format!(
            "<div style=\"display:flex;gap:1.5em;align-items:center\">{}<div><b>{}</b>{reason}{}<table>{rows}</table></div></div>",
            svg::result(found),
            self.verdict(),
            symmetry.unwrap_or_default()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let found = &self.found;
        let verdict = (self.doubts(), found.alternatives, self.symmetry());
        let numbers = [found.chi2_per_dof, found.coverage, found.sensor_sd_m, found.balance_sd_m, self.seconds];
        let outline: Vec<[f64; 7]> = found.outline.iter().map(palpate_io::point_row).collect();
        let motion: Vec<[f64; MOTION_COLUMNS]> = found.motion.iter().map(motion_row).collect();
        let tables = (arrays::table(py, &outline), arrays::table(py, &motion));
        let calibration = found.calibration.as_ref().map(calibration::text).transpose()?;
        let forces = (found.friction.as_ref().map(friction::row_of), found.inertia.as_ref().map(inertia::row_of));
        let shape = (self.shape(), calibration, forces);
        let arguments = (verdict, numbers, shape, tables, self.jumps(), self.others(py), &self.log);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "the parts of a pickled result")]
    fn _made(
        py: Python<'_>,
        verdict: (Vec<PyRef<DoubtData>>, usize, PyRef<SymmetryData>),
        numbers: [f64; 5],
        shape: (PyRef<Shape>, Option<String>, Forces),
        tables: (Table, Table),
        jumps: Vec<PyRef<JumpData>>,
        others: Vec<PyRef<Self>>,
        log: Option<Py<LogData>>,
    ) -> PyResult<Self> {
        let ((doubts, alternatives, symmetry), (shape, calibration, (friction, inertia))) = (verdict, shape);
        let [chi2_per_dof, coverage, sensor_sd_m, balance_sd_m, seconds] = numbers;
        let found = Reconstruction {
            findings: None,
            shape: shape.0.clone(),
            outline: arrays::rows("an outline", &tables.0)?.into_iter().map(palpate_io::point_of).collect(),
            motion: arrays::rows("a motion", &tables.1)?.iter().map(pose).collect(),
            verdict: Verdict::new(doubts.iter().map(|doubt| doubt.0.clone()).collect()),
            chi2_per_dof,
            jumps: jumps.iter().map(|jump| jump.0).collect(),
            coverage,
            alternatives,
            symmetry: symmetry.0,
            others: others.iter().map(|other| (*other.found).clone()).collect(),
            sensor_sd_m,
            balance_sd_m,
            calibration: calibration.as_deref().map(calibration::of_text).transpose()?,
            friction: friction.as_deref().and_then(friction::of_row),
            inertia: inertia.map(inertia::of_row),
        };
        Ok(Self::of(py, found, log, seconds))
    }
}

impl ResultData {
    fn verdict(&self) -> &'static str {
        match (self.found.is_certified(), self.found.is_com_certified()) {
            (true, true) => "certified: shape, motion and centre of mass",
            (true, false) => "certified: shape and motion, but not the centre of mass",
            _ => "NOT certified",
        }
    }
}

/// What a result folder (or that of an alternative) holds.
fn loaded(py: Python<'_>, folder: &std::path::Path) -> PyResult<(Reconstruction, Summary)> {
    let summary = palpate_io::read_summary(folder).or_raise()?;
    let outline = py.detach(|| palpate_io::read_shape_csv(folder)).or_raise()?;
    let motion = py.detach(|| palpate_io::read_motion_csv(folder)).or_raise()?;
    let samples: Vec<(f64, f64)> = outline.iter().map(|point| (point.theta_rad, point.r_m)).collect();
    let shape = SupportFunction::from_samples(&samples, summary.harmonics.min(samples.len())).or_raise()?;
    let jump = |jump: &palpate_io::JumpSummary| Jump {
        time_s: jump.time_s,
        psi_before_rad: jump.psi_before_rad,
        psi_after_rad: jump.psi_after_rad,
        height_before_m: jump.height_drop_m,
        height_after_m: 0.0,
        physical: jump.physical,
    };
    let found = Reconstruction {
        findings: None,
        shape,
        outline,
        motion,
        verdict: summary.verdict(),
        chi2_per_dof: summary.chi2_per_dof,
        jumps: summary.jump_details.iter().map(jump).collect(),
        coverage: summary.coverage,
        alternatives: summary.alternatives,
        symmetry: summary.symmetry.into(),
        others: Vec::new(),
        sensor_sd_m: summary.sensor_sd_m,
        balance_sd_m: summary.balance_sd_m,
        calibration: calibration::of_summary(&summary),
        friction: None,
        inertia: None,
    };
    Ok((found, summary))
}

/// The contact mode of a palm, by the sign of its slip.
fn mode(pose: &Pose, palm: usize) -> Option<f64> {
    pose.modes.map(|modes| modes[palm].slip_sign())
}

/// Columns of a pickled motion: the numbers of `motion.csv`, the residuals and the contact modes.
const MOTION_COLUMNS: usize = 13;

/// A row of them; NaN where there is none.
fn motion_row(pose: &Pose) -> [f64; MOTION_COLUMNS] {
    let mut row = [f64::NAN; MOTION_COLUMNS];
    row[..9].copy_from_slice(&palpate_io::pose_row(pose));
    let besides = [pose.residual1_m, pose.residual2_m, mode(pose, 0), mode(pose, 1)];
    for (cell, value) in row[9..].iter_mut().zip(besides) {
        *cell = value.unwrap_or(f64::NAN);
    }
    row
}

fn pose(row: &[f64; MOTION_COLUMNS]) -> Pose {
    let known = |value: f64| Some(value).filter(|value| !value.is_nan());
    let pose = palpate_io::pose_of(std::array::from_fn(|column| row[column]));
    let modes = ContactMode::of_slip_sign(row[11]).zip(ContactMode::of_slip_sign(row[12])).map(Into::into);
    Pose { residual1_m: known(row[9]), residual2_m: known(row[10]), modes, ..pose }
}
