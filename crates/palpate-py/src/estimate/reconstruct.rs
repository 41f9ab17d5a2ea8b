//! `reconstruct`: log in, shape, motion and centre of mass out.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;

use palpate::reconstruct::{ReconstructError, Reconstructor, Start, UnknownMethod};
use palpate::{Log, Reconstruction};
use palpate_io::{LogFile, RigFile};
use pyo3::prelude::*;

use crate::estimate::result::ResultData;
use crate::interop::arrays::{self, Column};
use crate::interop::errors::{self, OrRaise};
use crate::interop::whole::Whole;
use crate::interop::work::{self, Teller};
use crate::measured::log::{LogData, LogGiven};
use crate::measured::rig::{self, RigGiven};
use crate::object::shape::Shape;

/// The options of the estimator from what Python calls them.
fn options(
    harmonics: Option<Whole>,
    sensor_sd_m: Option<f64>,
    method: &str,
    rig: &RigFile,
) -> PyResult<Reconstructor<'static>> {
    let method = method.parse().map_err(|error: UnknownMethod| errors::input(error.to_string()))?;
    let options = Reconstructor::new().harmonics(harmonics.map(Whole::count)).sensor_sd_m(sensor_sd_m);
    Ok(options.method(method).rig(rig.rig))
}

/// The rig that was given; without one, readings are taken as they are.
fn known(py: Python<'_>, rig: Option<RigGiven>) -> PyResult<RigFile> {
    rig.map_or_else(|| Ok(RigFile::exact()), |rig| rig.read(py))
}

/// Reconstructs on the pool and makes a result of it, and of the log that it is of where that is another than the one given.
fn solved(
    py: Python<'_>,
    log: &Py<LogData>,
    threads: Option<Whole>,
    progress: Option<&Bound<'_, PyAny>>,
    solve: impl FnOnce(&LogFile, &Teller) -> Result<(Reconstruction, Option<Log>), ReconstructError> + Send + 'static,
) -> PyResult<ResultData> {
    let file = Arc::clone(&log.get().file);
    let outcome = work::run_told(py, threads, progress, move |teller| {
        let started = Instant::now();
        solve(&file, teller).map(|solved| (solved, started.elapsed().as_secs_f64()))
    });
    let ((reconstruction, as_read), seconds) = outcome?.or_raise()?;
    let log = match as_read {
        Some(as_read) => Py::new(py, log.get().turned(py, as_read, log.get().conventions))?,
        None => log.clone_ref(py),
    };
    Ok(ResultData::of(py, reconstruction, Some(log), seconds))
}

/// Find shape, motion and centre of mass from a palm log and nothing else.
///
/// A doubtful answer is no error: it comes back as a result that is not certified. Where no object explains the log, the usual mistakes in how
/// it is written are tried (pads swapped, an angle of the wrong sign or from the wrong line, a pad read from its far end, ...): the first doubt names
/// the one without which it is explained, and the result is of the log without it. The same log gives the same result on any number of
/// threads. Other Python threads run meanwhile, and Ctrl-C ends the call.
///
/// Parameters
/// ----------
/// log : Log, str, os.PathLike, file object, pandas.DataFrame, or mapping of str to array_like
///     The palm log, or what one is made of: a CSV file, or columns whose names carry units, as for `Log.from_csv`, `Log.from_pandas` and
///     `Log.from_numpy`.
/// harmonics : int, optional
///     Number of harmonics of the support function, 2 to 64. Default: chosen by the data.
/// sensor_sd_m : float, optional
///     Standard deviation of the contact positions, metres. Default: what the log states, else estimated from it.
/// method : str
///     'likelihood': maximum likelihood, with error bars and a verdict. 'ode': the equations of Moll and Erdmann (2001), 'quadrature':
///     closed forms for the same; both for comparison, without error bars and never certified, and with the rig as stated.
/// rig : Rig or str or os.PathLike, optional
///     What is known of palms and pads, or the path of a rig file. Constants that are not exact are estimated with the shape as far as
///     the log tells them. Where the rig has conventions (signs of the angles, pads that count from the tip, base points), they are
///     applied to the log first, unless it was read by them. Default: readings are taken as they are.
/// min_touches : int
///     Boundary that a contact went over fewer times than this counts as never felt.
/// threads : int, optional
///     Threads to work with. Default: as many as there are processors.
/// progress : bool or callable, optional
///     True: a bar, by tqdm if it is installed; False: none; a callable: called with the stage (str) and the share of the work that is done
///     (float). Default: a bar if someone is watching.
///
/// Returns
/// -------
/// Result
///     Shape, motion and centre of mass, with error bars and a verdict.
///
/// Raises
/// ------
/// ReconstructError
///     If the log cannot be solved at all, or an option is out of range.
/// ReadError
///     If the log or the rig file cannot be read or is none.
/// InputError
///     If the log is none with the conventions of the rig, or was read by those of another.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg", 0.03)
/// >>> log, truth = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), rate_hz=10)
/// >>> result = palpate.reconstruct(log)
/// >>> result.certified
/// True
/// >>> abs(result.shape.perimeter_m - egg.perimeter_m) < 1e-5
/// True
#[expect(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
#[pyfunction]
#[pyo3(
    signature = (log, *, harmonics=None, sensor_sd_m=None, method="likelihood", rig=None, min_touches=Whole(0), threads=None,
        progress=None),
    text_signature = "(log, *, harmonics=None, sensor_sd_m=None, method='likelihood', rig=None, min_touches=0, threads=None, \
        progress=None)"
)]
pub fn reconstruct(
    py: Python<'_>,
    log: LogGiven,
    harmonics: Option<Whole>,
    sensor_sd_m: Option<f64>,
    method: &str,
    rig: Option<RigGiven>,
    min_touches: Whole,
    threads: Option<Whole>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<ResultData> {
    let rig = known(py, rig)?;
    let options = options(harmonics, sensor_sd_m, method, &rig)?;
    let log = log.with_conventions(py, &rig.conventions)?;
    solved(py, &log, threads, progress, move |file, teller| {
        let mut found = options.clone().progress(&|progress| teller.tell(progress)).run_or_name_mistake(&file.log)?;
        found.prune(min_touches.small());
        let as_read = match options.log_as_read(&file.log, &found) {
            Cow::Owned(as_read) => Some(as_read),
            Cow::Borrowed(_) => None,
        };
        Ok((found, as_read))
    })
}

/// Reconstruct from a known start; nothing is searched for.
///
/// For a log that was solved before, or to see what the estimator could reach.
///
/// Parameters
/// ----------
/// log : Log
///     The palm log.
/// shape : SupportFunction
///     The shape to start from.
/// psi_rad : array_like of float, shape (n,)
///     The orientation at each sample to start from, radians.
/// harmonics : int, optional
///     Number of harmonics of the support function, 2 to 64. Default: chosen by the data.
/// sensor_sd_m : float, optional
///     Standard deviation of the contact positions, metres. Default: what the log states, else estimated from it.
/// method : str
///     'likelihood': maximum likelihood, with error bars and a verdict. 'ode': the equations of Moll and Erdmann (2001), 'quadrature':
///     closed forms for the same; both for comparison, without error bars and never certified, and with the rig as stated.
/// rig : Rig or str or os.PathLike, optional
///     What is known of palms and pads, or the path of a rig file. Constants that are not exact are estimated with the shape as far as
///     the log tells them. Where the rig has conventions (signs of the angles, pads that count from the tip, base points), they are
///     applied to the log first, unless it was read by them. Default: readings are taken as they are.
/// threads : int, optional
///     Threads to work with. Default: as many as there are processors.
///
/// Returns
/// -------
/// Result
///     Shape, motion and centre of mass, with error bars and a verdict.
///
/// Raises
/// ------
/// ReconstructError
///     If the log cannot be solved, an option is out of range, or `psi_rad` is not as long as the log.
/// ReadError
///     If the rig file cannot be read or is none.
/// InputError
///     If the log is none with the conventions of the rig, or was read by those of another.
#[expect(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
#[pyfunction]
#[pyo3(signature = (log, shape, psi_rad, *, harmonics=None, sensor_sd_m=None, method="likelihood", rig=None, threads=None))]
pub fn reconstruct_from(
    py: Python<'_>,
    log: Py<LogData>,
    shape: &Shape,
    psi_rad: Column,
    harmonics: Option<Whole>,
    sensor_sd_m: Option<f64>,
    method: &str,
    rig: Option<RigGiven>,
    threads: Option<Whole>,
) -> PyResult<ResultData> {
    let rig = known(py, rig)?;
    let options = options(harmonics, sensor_sd_m, method, &rig)?;
    let log = rig::with_conventions(py, log, &rig.conventions)?;
    let (shape, psi) = (shape.0.clone(), arrays::values(&psi_rad));
    let silent = false.into_pyobject(py)?.to_owned().into_any();
    solved(py, &log, threads, Some(&silent), move |file, _| {
        let found = options.clone().start(Start::Motion { shape, psi_rad: psi }).run(&file.log)?;
        Ok((found, None))
    })
}

/// The Cramer-Rao bound: how well any unbiased estimator could know the shape.
///
/// Parameters
/// ----------
/// log : Log
///     The palm log.
/// shape : SupportFunction
///     The true shape.
/// psi_rad : array_like of float, shape (n,)
///     The true orientation at each sample, radians.
/// sensor_sd_m : float
///     Standard deviation of the contact positions, metres.
///
/// Returns
/// -------
/// float or None
///     Root mean square over the felt boundary of the smallest possible standard deviation of r, metres; None where the log does not
///     determine the shape, or `psi_rad` is not as long as the log.
#[pyfunction]
pub fn cramer_rao_bound_m(
    py: Python<'_>,
    log: Py<LogData>,
    shape: &Shape,
    psi_rad: Column,
    sensor_sd_m: f64,
) -> PyResult<Option<f64>> {
    let (file, shape, psi) = (Arc::clone(&log.get().file), shape.0.clone(), arrays::values(&psi_rad));
    work::run(py, None, None, move |_| palpate::information::cramer_rao_bound_m(&file.log, &shape, &psi, sensor_sd_m))
}
