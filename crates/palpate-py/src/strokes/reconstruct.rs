//! `reconstruct_strokes`: shape about the pivot and motion from a log of strokes.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use palpate::pivot::{PadPose, PivotOptions, PivotReconstructError, PivotRig, reconstruct_with_posterior};
use pyo3::prelude::*;

use crate::interop::errors::{OrRaise, ReconstructError};
use crate::interop::whole::Whole;
use crate::interop::work;
use crate::strokes::log::StrokesGiven;
use crate::strokes::result::StrokesResult;

/// Find shape and motion from the strokes of a pivoting grasp and nothing else.
///
/// An arm holds the object at a pivot, about which it turns freely, and drags it over one pad (Moll and Erdmann 2001, figure 9). Shape and
/// motion follow from contact alone; where the centre of mass is, only from the angle at which the object hung before each stroke.
///
/// Parameters
/// ----------
/// log : Strokes or str or os.PathLike
///     The log, or the CSV file of one.
/// rig : str or os.PathLike, optional
///     A file that says where the pad lies and how well pad and arm are known, see `docs/formats.md`. Default: a level pad at the origin.
/// calibrated : bool, default False
///     Without a rig file: whether readings are exact but for noise. Else zero, scale and tilt of the pad are estimated.
/// harmonics : int, optional
///     Number of harmonics of the support function, 2 to 48. Default: chosen by the data.
/// threads : int, optional
///     Threads to work with. Default: as many as there are processors.
///
/// Returns
/// -------
/// StrokesResult
///     Shape about the pivot and motion, with error bars and a verdict.
///
/// Raises
/// ------
/// ReconstructError
///     If the log cannot be solved at all, or an option is out of range.
/// ReadError
///     If the log or the rig file cannot be read or is none.
#[pyfunction]
#[pyo3(signature = (log, *, rig=None, calibrated=false, harmonics=None, threads=None))]
pub fn reconstruct_strokes(
    py: Python<'_>,
    log: StrokesGiven,
    rig: Option<PathBuf>,
    calibrated: bool,
    harmonics: Option<Whole>,
    threads: Option<Whole>,
) -> PyResult<StrokesResult> {
    let log = log.read(py)?;
    let rig = rig_of(py, rig, calibrated)?;
    let options = PivotOptions::new(rig).harmonics(harmonics.map(Whole::count));
    let felt = Arc::clone(&log.get().log);
    let solved = work::run(py, threads.map(|threads| threads.0), None, move |_| {
        let started = Instant::now();
        reconstruct_with_posterior(&felt, &options).map(|found| (found, started.elapsed().as_secs_f64()))
    })?;
    let ((found, posterior), seconds) =
        solved.map_err(|error: PivotReconstructError| ReconstructError::new_err(error.to_string()))?;
    Ok(StrokesResult::of(py, (found, posterior), log, rig, seconds))
}

/// The rig of a file; without one it is exact, or an ordinary one that nobody calibrated, with a level pad in the origin.
pub fn rig_of(py: Python<'_>, path: Option<PathBuf>, calibrated: bool) -> PyResult<PivotRig> {
    Ok(match path {
        Some(path) => py.detach(|| palpate_io::read_pivot_rig(&path)).or_raise()?,
        None if calibrated => PivotRig::exact(PadPose::default()),
        None => PivotRig::uncalibrated(PadPose::default()),
    })
}
