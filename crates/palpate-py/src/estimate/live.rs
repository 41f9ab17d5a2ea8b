//! The online estimator, and sources that are watched with it.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use palpate::live::{Estimate, Live};
use palpate::palms::PalmPair;
use palpate::reconstruct::{ReconstructOptions, Reconstructor};
use palpate::{Log, Sample};
use palpate_io::{LogFile, RigFile};
use palpate_live::{Address, Batch, SourceError, Stream};
use pyo3::prelude::*;

use crate::estimate::doubt::DoubtData;
use crate::estimate::result::ResultData;
use crate::interop::errors::{self, OrRaise};
use crate::interop::work;
use crate::measured::log::LogData;
use crate::measured::rig::RigGiven;
use crate::object::shape::Shape;

/// Time between two looks at Python's signals while no sample comes.
const TICK: Duration = Duration::from_millis(50);

/// What is known after a sample.
///
/// Before anything is known, `shape` is None and numbers are NaN.
#[pyclass(frozen, module = "palpate", name = "LiveEstimate")]
pub struct EstimateData(Estimate);

impl EstimateData {
    /// A number of the pose; NaN without one.
    fn of_pose(&self, value: impl Fn(&palpate::reconstruct::Pose) -> f64) -> f64 {
        self.0.pose.as_ref().map_or(f64::NAN, value)
    }
}

#[pymethods]
impl EstimateData {
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

    /// int: samples that were not, because no palm log can have them.
    #[getter]
    fn refused(&self) -> u64 {
        self.0.refused
    }

    /// float: orientation of the object, radians; 0 at the first sample.
    #[getter]
    fn psi_rad(&self) -> f64 {
        self.of_pose(|pose| pose.psi_rad)
    }

    /// float: its standard deviation, radians.
    #[getter]
    fn psi_sd_rad(&self) -> f64 {
        self.of_pose(|pose| pose.psi_sd_rad)
    }

    /// tuple of float: centre of mass, x and y in the frame of the palms, metres.
    #[getter]
    fn com_m(&self) -> (f64, f64) {
        (self.of_pose(|pose| pose.com_x_m), self.of_pose(|pose| pose.com_y_m))
    }

    /// float: its standard deviation, metres.
    #[getter]
    fn com_sd_m(&self) -> f64 {
        self.of_pose(|pose| pose.com_sd_m)
    }

    /// SupportFunction or None: the shape about its centre of mass.
    #[getter]
    fn shape(&self) -> Option<Shape> {
        self.0.shape.clone().map(Shape)
    }

    /// float: standard deviation of the felt boundary, metres, root mean square.
    #[getter]
    fn r_sd_m(&self) -> f64 {
        self.0.r_sd_m()
    }

    /// float: fraction of the boundary (in normal angle) that was felt, 0 to 1.
    #[getter]
    fn coverage(&self) -> f64 {
        self.0.coverage
    }

    /// bool: the last search certified shape and motion, and nothing since contradicts them.
    #[getter]
    fn certified(&self) -> bool {
        self.0.is_certified()
    }

    /// bool: the same of the centre of mass as well.
    #[getter]
    fn com_certified(&self) -> bool {
        self.0.is_com_certified()
    }

    /// str: why not certified; empty when both verdicts are yes.
    #[getter]
    fn reason(&self) -> String {
        self.0.reason()
    }

    /// list of Doubt: those of the last search, one by one.
    #[getter]
    fn doubts(&self) -> Vec<DoubtData> {
        self.0.verdict.iter().flat_map(|verdict| verdict.doubts.iter().cloned().map(DoubtData)).collect()
    }

    /// bool: whether the newest samples contradict the shape, so that the verdict no longer holds.
    #[getter]
    fn contradicted(&self) -> bool {
        self.0.contradicted
    }

    /// bool: whether the pose of the newest sample is hardly known: several explain it, or it is on boundary that is not known.
    #[getter]
    fn ambiguous(&self) -> bool {
        self.0.ambiguous
    }

    /// int: poses that the newest samples may have; 0 without a shape.
    #[getter]
    fn hypotheses(&self) -> usize {
        self.0.hypotheses
    }

    /// int: objects that explain the samples equally well, by the last search; 0 before there is an answer.
    #[getter]
    fn alternatives(&self) -> usize {
        self.0.alternatives
    }

    fn __repr__(&self) -> String {
        let verdict = if self.0.is_certified() { "certified" } else { "not certified" };
        let (samples, felt) = (self.0.samples, 100.0 * self.0.coverage);
        format!("<LiveEstimate after {samples} samples: {felt:.0} % felt, {verdict}>")
    }
}

/// An online estimator: shape, pose and centre of mass while the samples come.
///
/// The same samples give the same estimates. A search over the samples so far runs in the background now and then, and a filter goes on from what it found; a
/// sample that comes before a search is over that should be waits for it. Other Python threads run meanwhile.
///
/// Parameters
/// ----------
/// rig : Rig or str or os.PathLike, optional
///     What is known of palms and pads, or the path of a rig file. Default: readings are taken as they are.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg", 0.03)
/// >>> log, truth = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), rate_hz=10)
/// >>> live = palpate.Live()
/// >>> for sample in zip(log.time_s, log.phi1_rad, log.phi2_rad, log.s1_m, log.s2_m):
/// ...     estimate = live.push(*sample)
/// >>> estimate.certified
/// True
/// >>> live.finish().certified
/// True
#[pyclass(frozen, module = "palpate", name = "Live")]
pub struct LiveData {
    live: Mutex<Live>,
    rig: RigFile,
}

#[pymethods]
impl LiveData {
    #[new]
    #[pyo3(signature = (*, rig=None))]
    fn new(py: Python<'_>, rig: Option<RigGiven>) -> PyResult<Self> {
        let rig = rig.map_or_else(|| Ok(RigFile::exact()), |rig| rig.read(py))?;
        Ok(Self::of(&rig))
    }

    /// Take a sample in.
    ///
    /// One that no palm log can have (a value that is infinite, parallel palms, a time before that of the last) is counted in `refused` of the estimate,
    /// and nothing else.
    ///
    /// Parameters
    /// ----------
    /// time_s : float
    ///     Time, seconds.
    /// phi1_rad, phi2_rad : float
    ///     Angle of palm 1 against the horizontal, and from palm 1 to palm 2, radians.
    /// s1_m, s2_m : float or None
    ///     Distance of each contact from the base of its palm, metres; NaN or None where no contact was seen.
    ///
    /// Returns
    /// -------
    /// LiveEstimate
    ///     What is known after it.
    #[pyo3(signature = (time_s, phi1_rad, phi2_rad, s1_m, s2_m))]
    fn push(
        &self,
        py: Python<'_>,
        time_s: f64,
        phi1_rad: f64,
        phi2_rad: f64,
        s1_m: Option<f64>,
        s2_m: Option<f64>,
    ) -> EstimateData {
        let seen = |position: Option<f64>| position.filter(|position| !position.is_nan());
        let sample = Sample {
            s1_m: seen(s1_m),
            s2_m: seen(s2_m),
            ..Sample::new(time_s, PalmPair::hinged(phi1_rad, phi2_rad), 0.0, 0.0)
        };
        py.detach(|| self.take(&sample))
    }

    /// Reconstruct all samples, as `reconstruct` does.
    ///
    /// Samples may be pushed afterwards. Of more than 65 536 samples every second is reconstructed, of twice as many every fourth, and so on.
    ///
    /// Returns
    /// -------
    /// Result
    ///     Shape, motion and centre of mass, with error bars and a verdict.
    ///
    /// Raises
    /// ------
    /// ReconstructError
    ///     If the samples cannot be solved at all.
    fn finish(&self, py: Python<'_>) -> PyResult<ResultData> {
        let log = py.detach(|| self.lock().log().clone());
        let options = options(&self.rig);
        let file = LogFile { log: log.clone(), metadata: Vec::new(), notes: Vec::new() };
        let started = Instant::now();
        let found = work::run_told(py, None, None, move |teller| {
            Reconstructor::from(options).progress(&|progress| teller.tell(progress)).run(&log)
        });
        let found = found?.or_raise()?;
        let log = Py::new(py, LogData::of(py, file, None))?;
        Ok(ResultData::of(py, found, Some(log), started.elapsed().as_secs_f64()))
    }
}

impl LiveData {
    fn of(rig: &RigFile) -> Self {
        Self { live: Mutex::new(Live::new(options(rig))), rig: *rig }
    }

    /// A sample that panicked has left nothing that the next one needs.
    fn lock(&self) -> MutexGuard<'_, Live> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, sample: &Sample) -> EstimateData {
        let log = self.rig.conventions.apply(&Log { samples: vec![*sample] });
        let mut live = self.lock();
        for sample in &log.samples {
            live.push(sample);
        }
        EstimateData(live.estimate().clone())
    }
}

/// As of `palpate reconstruct`.
fn options(rig: &RigFile) -> ReconstructOptions {
    ReconstructOptions::default().with_rig(rig.rig).with_sensor_sd_m(rig.reading_sd_m())
}

/// The estimates of a source, one for each sample: what `watch` returns.
#[pyclass(frozen, module = "palpate", name = "Watch")]
pub struct WatchData {
    stream: Stream,
    stated: Option<RigFile>,
    waiting: Mutex<VecDeque<Sample>>,
    live: Mutex<Option<Py<LiveData>>>,
}

#[pymethods]
impl WatchData {
    fn __iter__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<EstimateData>> {
        let Some(sample) = self.next(py)? else { return Ok(None) };
        let live = self.live(py)?;
        Ok(Some(py.detach(|| live.get().take(&sample))))
    }

    /// Reconstruct what came so far, as `Live.finish`.
    ///
    /// Returns
    /// -------
    /// Result
    ///     Shape, motion and centre of mass, with error bars and a verdict.
    ///
    /// Raises
    /// ------
    /// ReconstructError
    ///     If the samples cannot be solved at all.
    fn finish(&self, py: Python<'_>) -> PyResult<ResultData> {
        self.live(py)?.get().finish(py)
    }

    /// str: what was lost so far, by cause.
    #[getter]
    fn losses(&self) -> String {
        self.stream.losses().to_string()
    }
}

impl WatchData {
    /// The next sample; Ctrl-C is heard while none comes.
    fn next(&self, py: Python<'_>) -> PyResult<Option<Sample>> {
        loop {
            if let Some(sample) = self.waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front() {
                return Ok(Some(sample));
            }
            match py.detach(|| self.stream.next(TICK)).or_raise()? {
                Batch::End => return Ok(None),
                Batch::Samples(samples) => {
                    self.waiting.lock().unwrap_or_else(PoisonError::into_inner).extend(samples);
                }
            }
            py.check_signals()?;
        }
    }

    /// The estimator, which begins with the first sample: the rig may be known no sooner.
    fn live(&self, py: Python<'_>) -> PyResult<Py<LiveData>> {
        let mut live = self.live.lock().unwrap_or_else(PoisonError::into_inner);
        if live.is_none() {
            let rig = self.stated.or(self.stream.rig()).unwrap_or_default();
            *live = Some(Py::new(py, LiveData::of(&rig))?);
        }
        live.as_ref().map(|live| live.clone_ref(py)).ok_or_else(|| errors::input("there is no estimator".to_owned()))
    }
}

/// Watch a source: an estimate for each sample, as it comes.
///
/// Parameters
/// ----------
/// source : str
///     As of `palpate watch`: the path of a CSV file, which is followed as it grows, 'serial:/dev/ttyUSB0', 'evdev:...', 'mcap:FILE' or 'sim:PLAN.toml'.
/// rig : Rig or str or os.PathLike, optional
///     What is known of palms and pads, or the path of a rig file. Default: what the source says, or else an ordinary rig that nobody calibrated.
///
/// Returns
/// -------
/// Watch
///     An iterator over `LiveEstimate`; its `finish` reconstructs what came so far.
///
/// Raises
/// ------
/// InputError
///     If there is no such source, or it fails.
///
/// Examples
/// --------
/// >>> import palpate, pathlib
/// >>> pathlib.Path("plan.toml").write_text("shape = 'egg'\nduration_s = 40\nrate_hz = 10\nspeed = 0\n") # doctest: +SKIP
/// >>> for estimate in palpate.watch("sim:plan.toml"): # doctest: +SKIP
/// ...     print(estimate.psi_rad, estimate.certified)
#[pyfunction]
#[pyo3(signature = (source, *, rig=None))]
pub fn watch(py: Python<'_>, source: &str, rig: Option<RigGiven>) -> PyResult<WatchData> {
    let stated = rig.map(|rig| rig.read(py)).transpose()?;
    let address: Address = source.parse().or_raise()?;
    let conventions = stated.map(|rig| rig.conventions);
    let stream = address.open(conventions).and_then(|source| Stream::start(source, conventions)).or_raise()?;
    Ok(WatchData { stream, stated, waiting: Mutex::default(), live: Mutex::default() })
}

impl errors::IntoException for SourceError {
    fn into_exception(self) -> PyErr {
        errors::input(self.to_string())
    }
}
