//! `LiveStrokes`: strokes of a pivoting grasp while they are felt.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use palpate::pivot::{
    LiveStrokes, PivotOptions, PivotReconstructError, PivotRig, PivotSample, StrokesEstimate,
    reconstruct_with_posterior,
};
use pyo3::prelude::*;

use crate::interop::errors::ReconstructError;
use crate::interop::work;
use crate::object::shape::Shape;
use crate::strokes::log::StrokesData;
use crate::strokes::reconstruct::rig_of;
use crate::strokes::result::StrokesResult;

/// What is known after a sample of strokes.
///
/// Before anything is known, `shape` is None and numbers are NaN.
#[pyclass(frozen, module = "palpate", name = "StrokesEstimate")]
pub struct StrokesEstimateData(StrokesEstimate);

#[pymethods]
impl StrokesEstimateData {
    /// float: time of the newest sample, seconds.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s
    }

    /// int: samples that were taken.
    #[getter]
    fn samples(&self) -> u64 {
        self.0.samples
    }

    /// int: samples that were not, because no log of strokes can have them.
    #[getter]
    fn refused(&self) -> u64 {
        self.0.refused
    }

    /// float: orientation of the object, radians, -pi to pi; 0 at the first contact. NaN without a contact, and where `on_unfelt`.
    #[getter]
    fn psi_rad(&self) -> f64 {
        self.0.psi_rad.unwrap_or(f64::NAN)
    }

    /// float: its standard deviation, radians.
    #[getter]
    fn psi_sd_rad(&self) -> f64 {
        self.0.psi_sd_rad.unwrap_or(f64::NAN)
    }

    /// bool: whether the contact is on boundary that the last search did not know, so that no orientation is given.
    #[getter]
    fn on_unfelt(&self) -> bool {
        self.0.is_on_unfelt
    }

    /// SupportFunction or None: the shape about the pivot, by the last search.
    #[getter]
    fn shape(&self) -> Option<Shape> {
        self.0.shape.clone().map(Shape)
    }

    /// float: standard deviation of the felt boundary, metres, root mean square, by the last search.
    #[getter]
    fn r_sd_m(&self) -> f64 {
        self.0.r_sd_m
    }

    /// float: fraction of the boundary (in normal angle) that the last search knew to be felt, 0 to 1.
    #[getter]
    fn coverage(&self) -> f64 {
        self.0.coverage
    }

    /// bool: the last search certified shape and motion, and no sample since contradicts them.
    #[getter]
    fn certified(&self) -> bool {
        self.0.is_certified()
    }

    /// str: why not certified; empty where it is.
    #[getter]
    fn reason(&self) -> String {
        self.0.reason()
    }

    fn __repr__(&self) -> String {
        let verdict = if self.0.is_certified() { "certified" } else { "not certified" };
        let (samples, felt) = (self.0.samples, 100.0 * self.0.coverage);
        format!("<StrokesEstimate after {samples} samples: {felt:.0} % felt, {verdict}>")
    }
}

/// An online estimator for the strokes of a pivoting grasp.
///
/// The same samples give the same estimates. The samples so far are reconstructed in the background each time they have grown by half, and each sample in
/// between is decoded against the shape that came out; one that comes before a search is over that should be waits for it. Other Python threads run meanwhile.
///
/// Parameters
/// ----------
/// rig : str or os.PathLike, optional
///     A file that says where the pad lies and how well pad and arm are known, see `docs/formats.md`. Default: a level pad at the origin.
/// calibrated : bool, default False
///     Without a rig file: whether readings are exact but for noise. Else zero, scale and tilt of the pad are estimated.
/// swing_period_s : float, optional
///     Period of small swings of the lifted object about the pivot, seconds: it tells how far the centre of mass is.
///
/// Raises
/// ------
/// ReadError
///     If the rig file cannot be read or is none.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg", 0.03).translated(0.004, 0.003)
/// >>> log, truth = palpate.simulate_strokes(egg, [[0.5, 0.65], [0.5, 0.35], [0.5, 0.7], [0.5, 0.3]], center_of_mass_m=(0.004, 0.003))
/// >>> live = palpate.LiveStrokes(calibrated=True)
/// >>> for time_s, pivot, s_m in zip(log.time_s, log.pivot_m, log.s_m):
/// ...     estimate = live.push(time_s, *pivot, s_m)
/// >>> estimate.certified
/// True
/// >>> live.finish().certified
/// True
#[pyclass(frozen, module = "palpate", name = "LiveStrokes")]
pub struct LiveStrokesData {
    live: Mutex<LiveStrokes>,
    rig: PivotRig,
}

#[pymethods]
impl LiveStrokesData {
    #[new]
    #[pyo3(signature = (*, rig=None, calibrated=false, swing_period_s=None))]
    fn new(py: Python<'_>, rig: Option<PathBuf>, calibrated: bool, swing_period_s: Option<f64>) -> PyResult<Self> {
        let rig = rig_of(py, rig, calibrated)?;
        let live = LiveStrokes::new(PivotOptions::new(rig)).swing_period_s(swing_period_s);
        Ok(Self { live: Mutex::new(live), rig })
    }

    /// Take a sample in.
    ///
    /// One that no log of strokes can have (a value that is infinite, a time before that of the last) is counted in `refused` of the estimate, and nothing else.
    ///
    /// Parameters
    /// ----------
    /// time_s : float
    ///     Time, seconds.
    /// pivot_x_m, pivot_y_m : float
    ///     Where the arm holds the object, metres; gravity acts along -y.
    /// s_m : float or None
    ///     Where the pad feels it, along the pad from its base point, metres; NaN or None where no contact was seen.
    ///
    /// Returns
    /// -------
    /// StrokesEstimate
    ///     What is known after it.
    #[pyo3(signature = (time_s, pivot_x_m, pivot_y_m, s_m))]
    fn push(
        &self,
        py: Python<'_>,
        time_s: f64,
        pivot_x_m: f64,
        pivot_y_m: f64,
        s_m: Option<f64>,
    ) -> StrokesEstimateData {
        let sample = PivotSample { time_s, pivot_x_m, pivot_y_m, s_m: s_m.filter(|s_m| !s_m.is_nan()) };
        py.detach(|| StrokesEstimateData(self.lock().push(&sample).clone()))
    }

    /// Reconstruct all samples, as `reconstruct_strokes` does.
    ///
    /// Samples may be pushed afterwards. Of more than 16 384 samples every second is reconstructed, of twice as many every fourth, and so on.
    ///
    /// Returns
    /// -------
    /// StrokesResult
    ///     Shape about the pivot and motion, with error bars and a verdict.
    ///
    /// Raises
    /// ------
    /// ReconstructError
    ///     If the samples cannot be solved at all.
    fn finish(&self, py: Python<'_>) -> PyResult<StrokesResult> {
        let log = py.detach(|| self.lock().log().clone());
        let options = PivotOptions::new(self.rig);
        let felt = log.clone();
        let started = Instant::now();
        let found = work::run(py, None, None, move |_| reconstruct_with_posterior(&felt, &options))?;
        let found = found.map_err(|error: PivotReconstructError| ReconstructError::new_err(error.to_string()))?;
        let log = Py::new(py, StrokesData::of(py, log, None))?;
        Ok(StrokesResult::of(py, found, log, self.rig, started.elapsed().as_secs_f64()))
    }
}

impl LiveStrokesData {
    /// A sample that panicked has left nothing that the next one needs.
    fn lock(&self) -> MutexGuard<'_, LiveStrokes> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
