//! `calibrate`: any number of logs in, the rig that wrote them out.

use palpate::Log;
use palpate::calibrate::calibrate_with_disc;
use palpate::reconstruct::{Progress, ReconstructOptions};
use palpate::sensor::Tolerances;
use palpate_io::RigFile;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::estimate::rig_calibration::CalibrationData;
use crate::interop::errors::{self, OrRaise};
use crate::interop::whole::Whole;
use crate::interop::work;
use crate::measured::log::LogData;
use crate::measured::rig::{self, RigGiven};

/// The logs of an iterable.
fn listed(logs: &Bound<'_, PyAny>) -> PyResult<Vec<Py<LogData>>> {
    if logs.is_instance_of::<LogData>() {
        return Err(PyTypeError::new_err("logs must be an iterable of Log; give [log] for a single one"));
    }
    let logs = logs.try_iter()?.map(|log| Ok(log?.extract()?)).collect::<PyResult<Vec<_>>>()?;
    if logs.is_empty() {
        return Err(errors::input("there is no log to calibrate by".to_owned()));
    }
    Ok(logs)
}

/// The rig that was given; without one, the default tolerances, and the conventions that the logs were read by.
fn known(py: Python<'_>, rig: Option<RigGiven>, logs: &[Py<LogData>]) -> PyResult<RigFile> {
    if let Some(rig) = rig {
        let rig = rig.read(py)?;
        if rig.rig.tolerances == Tolerances::NONE {
            let text = "every constant of the rig is exact, so there is nothing to calibrate; give their standard deviations, or no rig for the default tolerances";
            return Err(errors::input(text.to_owned()));
        }
        return Ok(rig);
    }
    let mut conventions = logs.iter().map(|log| log.get().conventions);
    let first = conventions.next().unwrap_or_default();
    if conventions.any(|other| other != first) {
        let text = "the logs were read by the conventions of different rigs (signs, directions of the pads, base points); give the rig that wrote them, or read them again";
        return Err(errors::input(text.to_owned()));
    }
    Ok(RigFile { conventions: first, ..RigFile::default() })
}

/// Calibrate a rig from any number of its logs.
///
/// Every log may be of another object, which need not be known. Together they tell the zeros of pads and angles, one scale against the
/// other, one surface against the other, and the clock. What both scales have in common (the size of every object) and what both surface
/// offsets have in common they do not tell; these stay as they were, but for discs of a known radius. A log that is not certified
/// counts for nothing, which is no error. Other Python threads run meanwhile, and Ctrl-C ends the call.
///
/// Parameters
/// ----------
/// logs : iterable of Log
///     The palm logs, all of one rig.
/// rig : Rig or str or os.PathLike, optional
///     What is known of the rig beforehand, or the path of a rig file. Where it has conventions, they are applied to the logs first, but
///     for those that were read by them. Default: the default tolerances, `Rig()`, as `palpate calibrate` has them without --rig, with the
///     conventions that the logs were read by; what a log says in a comment `# rig:` is left aside.
/// known_radius_m : float, optional
///     The logs are of a disc of this radius, metres, which may roll, slide and turn as it likes. It tells scales and surface offsets too,
///     as far as one radius tells them apart, but not the zero of phi1. Default: of objects that are not known.
/// threads : int, optional
///     Threads to work with. Default: as many as there are processors.
/// progress : bool or callable, optional
///     True: a bar, by tqdm if it is installed; False: none; a callable: called with the stage (str) and the share of the work that is done
///     (float). Default: a bar if someone is watching.
///
/// Returns
/// -------
/// RigCalibration
///     The rig as it is known now, and what each log contributed. Where no log counts, it is the rig that was given.
///
/// Raises
/// ------
/// InputError
///     If there is no log, every constant of the rig is exact, a log is none with the conventions of the rig or was read by those of
///     another, or the logs are not of a disc of the radius that was given.
/// ReconstructError
///     If a log has a value that none can have, or the rig is out of range.
/// ReadError
///     If the rig file cannot be read or is none.
///
/// Examples
/// --------
/// Two objects on a rig whose first pad has its zero 0.3 mm off, which nobody knows:
///
/// >>> import palpate
/// >>> logs = []
/// >>> for name in ("egg", "stone"):
/// ...     shape = palpate.SupportFunction.named(name)
/// ...     log, truth = palpate.simulate(shape, palpate.plan_turn(shape, 40.0), rate_hz=5)
/// ...     logs.append(palpate.Log(log.time_s, log.phi1_rad, log.phi2_rad, log.s1_m + 0.3e-3, log.s2_m))
/// >>> found = palpate.calibrate(logs)
/// >>> found.used
/// 2
/// >>> zero = found.constants["s1_zero_m"]
/// >>> abs(zero.value - 0.3e-3) < 5 * zero.sd < zero.prior_sd
/// True
/// >>> text = found.rig.to_toml()  # a rig file, for `reconstruct` and the command line
#[pyfunction]
#[pyo3(signature = (logs, *, rig=None, known_radius_m=None, threads=None, progress=None))]
pub fn calibrate(
    py: Python<'_>,
    logs: &Bound<'_, PyAny>,
    rig: Option<RigGiven>,
    known_radius_m: Option<f64>,
    threads: Option<Whole>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<CalibrationData> {
    let logs = listed(logs)?;
    let before = known(py, rig, &logs)?;
    let (mut names, mut samples) = (Vec::new(), Vec::new());
    for (place, log) in logs.into_iter().enumerate() {
        let log = rig::with_conventions(py, log, &before.conventions)
            .map_err(|error| errors::input(format!("logs[{place}]: {}", error.value(py))))?;
        names.push(log.get().name.clone());
        samples.push(log.get().file.log.clone());
    }
    let found = work::run_told(py, threads, progress, move |teller| {
        let logs: &[Log] = &samples;
        let Some(radius_m) = known_radius_m else {
            let options = ReconstructOptions::default().with_rig(before.rig).with_sensor_sd_m(before.reading_sd_m());
            return palpate::calibrate::calibrate(logs, &options, &|step| teller.tell(step)).or_raise();
        };
        let found = calibrate_with_disc(logs, radius_m, &before.rig).or_raise()?;
        teller.tell(Progress { stage: "done", fraction: 1.0 });
        Ok(found)
    })??;
    Ok(CalibrationData::of(found, &before, names))
}
