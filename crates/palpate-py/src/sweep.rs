//! Sweeps: the jobs of a plan, and the folder that they are done in. The rest is in `python/palpate/_sweep.py`.

use std::ffi::OsStr;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use numpy::Element;
use palpate::reconstruct::Progress;
use palpate_sweep::columns::{Values, columns};
use palpate_sweep::{Job, Outcome, Source, Sweep, SweepError, SweepFolder, parse_plan, read_plan};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::interop::arrays;
use crate::interop::errors::{self, InternalError, OrRaise};
use crate::interop::whole::Whole;
use crate::interop::work;

/// What messages call a plan that is no file.
const TEXT: &str = "the plan";
/// What a listener is told that a sweep is at.
const STAGE: &str = "jobs";

/// A job of a sweep: a simulation or a log, how it is reconstructed, and what the result is held against.
///
/// `sweep_jobs` makes a list of them. A job is plain data and gives the same row of the table wherever it is done.
#[pyclass(frozen, module = "palpate", name = "SweepJob")]
pub struct JobData {
    job: Job,
    base: PathBuf,
}

#[pymethods]
impl JobData {
    /// The job as plain data.
    ///
    /// Returns
    /// -------
    /// dict of str to object
    ///     Dictionaries, lists, numbers and strings, by the names of a plan.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.getattr("loads")?.call1((encoded(&self.job)?,))
    }

    fn __eq__(&self, other: &Self) -> bool {
        (&self.job, &self.base) == (&other.job, &other.base)
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<SweepJob: {}>", encoded(&self.job)?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        Ok((py.get_type::<Self>().getattr("_made")?, (encoded(&self.job)?, &self.base).into_pyobject(py)?))
    }

    #[staticmethod]
    fn _made(job: &str, base: PathBuf) -> PyResult<Self> {
        Ok(Self { job: decoded(job)?, base })
    }
}

/// The jobs of a plan, in the order of the table.
///
/// Parameters
/// ----------
/// plan : str or os.PathLike
///     Path of a plan, a TOML file as for `palpate sweep`; or its text, if there is a line break in it. Logs are looked for from the
///     folder of the file, or from the working directory.
///
/// Returns
/// -------
/// list of SweepJob
///     The jobs. `sweep` takes them, or some of them, or those of several plans together.
///
/// Raises
/// ------
/// ReadError
///     If the plan cannot be read, or makes no sense.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> jobs = palpate.sweep_jobs('''
/// ... kind = "simulate"
/// ... trials = 50
/// ... objects.named = { name = ["egg", "stone"] }
/// ... touchpads = [{ noise_sd_m = [0.1e-3, 0.3e-3] }]
/// ... ''')
/// >>> len(jobs)
/// 200
#[pyfunction]
pub fn sweep_jobs(py: Python<'_>, plan: PathBuf) -> PyResult<Vec<JobData>> {
    py.detach(|| {
        let text = plan.as_os_str().to_str().filter(|text| text.contains('\n'));
        let (parsed, base) = match text {
            Some(text) => (parse_plan(TEXT, text), Path::new("")),
            None => (read_plan(&plan), plan.parent().unwrap_or(Path::new(""))),
        };
        // The working directory may be another one by the time of the sweep, and is on another machine.
        let base = std::path::absolute(Path::new(".").join(base)).unwrap_or_else(|_| base.to_path_buf());
        let jobs = parsed.and_then(|plan| Sweep::new(&plan, &base)).or_raise()?.jobs;
        Ok(jobs.into_iter().map(|job| JobData { job, base: base.clone() }).collect())
    })
}

/// Do jobs that were sent here, on one thread, until the time is up; at least one.
///
/// Parameters
/// ----------
/// jobs : list of (int, str)
///     Number and text of each job.
/// base : str
///     The folder from which logs are looked for.
/// seconds : float
///     No job is begun after so many.
///
/// Returns
/// -------
/// list of str
///     The outcomes of the first jobs, as text.
///
/// Raises
/// ------
/// SweepError
///     If a log is not the one that the sweep was planned with.
#[pyfunction]
pub fn run_sweep_jobs(py: Python<'_>, jobs: Vec<(u64, String)>, base: PathBuf, seconds: f64) -> PyResult<Vec<String>> {
    let jobs: Vec<(u64, Job)> =
        jobs.iter().map(|(number, job)| Ok((*number, decoded(job)?))).collect::<PyResult<_>>()?;
    let outcomes = work::run(py, Some(1), None, move |teller| {
        let clock = Instant::now();
        let mut outcomes: Vec<Outcome> = Vec::new();
        for (number, job) in &jobs {
            if !outcomes.is_empty() && clock.elapsed().as_secs_f64() >= seconds {
                break;
            }
            outcomes.push(job.run_elsewhere(*number, &base)?);
            teller.tell(Progress { stage: STAGE, fraction: outcomes.len() as f64 / jobs.len() as f64 });
        }
        Ok::<_, SweepError>(outcomes)
    })?;
    outcomes.or_raise()?.iter().map(encoded).collect()
}

/// The folder of a sweep at work, locked until it is finished or closed.
///
/// Parameters
/// ----------
/// jobs : list of SweepJob
///     The jobs, in the order of the table.
/// folder : str or os.PathLike
///     The folder; made if missing.
///
/// Attributes
/// ----------
/// base : str
///     The folder from which logs are looked for.
///
/// Raises
/// ------
/// InputError
///     If there is no job, or the logs are not looked for from one folder.
/// SweepError
///     If the folder belongs to another sweep, another program is at work in it, or it cannot be written.
#[pyclass(frozen, module = "palpate._palpate", name = "SweepFolder")]
pub struct FolderData {
    sweep: Arc<Sweep>,
    /// `None` when it is closed.
    folder: Arc<Mutex<Option<SweepFolder>>>,
}

#[pymethods]
impl FolderData {
    #[new]
    fn new(py: Python<'_>, jobs: Vec<Py<JobData>>, folder: PathBuf) -> PyResult<Self> {
        if jobs.is_empty() {
            return Err(errors::input("there is no job".to_owned()));
        }
        let mut bases = jobs.iter().map(Py::get).filter(|data| matches!(data.job.source, Source::Log(_)));
        let base = bases.next().map_or(PathBuf::new(), |data| data.base.clone());
        if let Some(other) = bases.find(|data| data.base != base) {
            let (one, other) = (base.display(), other.base.display());
            return Err(errors::input(format!(
                "the jobs come from plans in two folders, {one} and {other}; make one plan, or two sweeps"
            )));
        }
        let sweep = Sweep { jobs: jobs.iter().map(|data| data.get().job.clone()).collect(), base };
        let folder = py.detach(|| sweep.open(&folder)).or_raise()?;
        Ok(Self { sweep: Arc::new(sweep), folder: Arc::new(Mutex::new(Some(folder))) })
    }

    #[getter]
    fn base(&self) -> &OsStr {
        self.sweep.base.as_os_str()
    }

    /// How many jobs are finished, of how many.
    ///
    /// Returns
    /// -------
    /// finished : int
    ///     So many are, counting those of earlier calls.
    /// jobs : int
    ///     Of so many.
    fn done(&self) -> PyResult<(u64, u64)> {
        self.with(|folder| {
            let done = folder.done();
            (done.finished, done.jobs)
        })
    }

    /// Which jobs are not finished.
    ///
    /// Returns
    /// -------
    /// list of int
    ///     Their numbers, in order.
    fn todo(&self) -> PyResult<Vec<u64>> {
        self.with(|folder| folder.todo())
    }

    /// Jobs as they are sent to other machines.
    ///
    /// Parameters
    /// ----------
    /// numbers : list of int
    ///     Which.
    ///
    /// Returns
    /// -------
    /// list of (int, str)
    ///     Number and text of each.
    fn letters(&self, numbers: Vec<u64>) -> PyResult<Vec<(u64, String)>> {
        let job = |number: u64| usize::try_from(number).ok().and_then(|number| self.sweep.jobs.get(number));
        let known = numbers.into_iter().filter_map(|number| Some((number, job(number)?)));
        known.map(|(number, job)| Ok((number, encoded(job)?))).collect()
    }

    /// Keep what came of jobs.
    ///
    /// Parameters
    /// ----------
    /// outcomes : list of str
    ///     What `run_sweep_jobs` gave, from anywhere, in any order.
    ///
    /// Raises
    /// ------
    /// SweepError
    ///     If the journal cannot be written.
    fn keep(&self, py: Python<'_>, outcomes: Vec<String>) -> PyResult<()> {
        let outcomes = outcomes.iter().map(|outcome| decoded(outcome)).collect::<PyResult<Vec<Outcome>>>()?;
        let kept = py.detach(|| self.with(|folder| outcomes.into_iter().try_for_each(|outcome| folder.keep(outcome))));
        kept?.or_raise()
    }

    /// Do all jobs that are not finished, here.
    ///
    /// Parameters
    /// ----------
    /// threads : int, optional
    ///     Threads to work with. Default: as many as there are processors.
    /// listener : callable, optional
    ///     Called with "jobs" and the share of them that is finished.
    ///
    /// Raises
    /// ------
    /// SweepError
    ///     If the journal cannot be written.
    #[pyo3(signature = (threads=None, listener=None))]
    fn run(&self, py: Python<'_>, threads: Option<Whole>, listener: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let threads = match threads {
            Some(threads) => work::thread_count(threads.0)?,
            None => std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN),
        };
        let (sweep, folder, todo) = (Arc::clone(&self.sweep), Arc::clone(&self.folder), self.todo()?);
        // The thread of this pool waits for those that do the jobs.
        let done = work::run(py, Some(1), listener, move |teller| {
            sweep.each(&todo, threads, &mut |outcome| {
                // Closed when nobody waits any more, which the teller notices.
                let mut done = None;
                if let Some(folder) = locked(&folder).as_mut() {
                    folder.keep(outcome)?;
                    done = Some(folder.done());
                }
                let fraction = done.map_or(1.0, |done| done.finished as f64 / done.jobs as f64);
                teller.tell(Progress { stage: STAGE, fraction });
                Ok(())
            })
        });
        done?.or_raise()
    }

    /// Write the tables and close the folder.
    ///
    /// Returns
    /// -------
    /// dict of str to numpy.ndarray
    ///     The columns of `results.parquet`.
    ///
    /// Raises
    /// ------
    /// SweepError
    ///     If a job is not finished.
    /// WriteError
    ///     If the tables cannot be written.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let folder = locked(&self.folder).take().ok_or_else(closed)?;
        let outcomes = py.detach(|| folder.finish()).or_raise()?;
        let by_name = PyDict::new(py);
        for (name, values) in columns(&outcomes) {
            by_name.set_item(name, array(py, values)?)?;
        }
        Ok(by_name)
    }

    /// Close the folder. What is finished is kept.
    fn close(&self) {
        locked(&self.folder).take();
    }
}

impl FolderData {
    /// Something about the folder, as long as it is open.
    fn with<T>(&self, act: impl FnOnce(&mut SweepFolder) -> T) -> PyResult<T> {
        locked(&self.folder).as_mut().map(act).ok_or_else(closed)
    }
}

fn locked(folder: &Mutex<Option<SweepFolder>>) -> MutexGuard<'_, Option<SweepFolder>> {
    folder.lock().unwrap_or_else(PoisonError::into_inner)
}

fn closed() -> PyErr {
    errors::input("the folder is closed".to_owned())
}

/// A job or an outcome as text, to be sent away.
fn encoded(thing: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(thing).map_err(|error| InternalError::new_err(error.to_string()))
}

/// The same, received.
fn decoded<'a, T: serde::Deserialize<'a>>(text: &'a str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| errors::input(format!("this was not sent by palpate: {error}")))
}

/// A column of the table: NaN or None where a value is null.
fn array(py: Python<'_>, values: Values) -> PyResult<Py<PyAny>> {
    fn column<T: Element>(py: Python<'_>, values: Vec<T>) -> Py<PyAny> {
        arrays::column(py, values).into_any()
    }
    fn objects<'py>(py: Python<'py>, values: Vec<impl IntoPyObject<'py>>) -> PyResult<Py<PyAny>> {
        let objects = values.into_iter().map(|value| value.into_py_any(py)).collect::<PyResult<Vec<Py<PyAny>>>>()?;
        Ok(column(py, objects))
    }
    match values {
        Values::Counts(values) => Ok(column(py, values.into_iter().map(|count| count as i64).collect())),
        Values::MaybeCounts(values) => {
            Ok(arrays::sparse_column(py, values.into_iter().map(|count| count.map(|count| count as f64))).into_any())
        }
        Values::Numbers(values) => Ok(arrays::sparse_column(py, values.into_iter()).into_any()),
        Values::Flags(values) => Ok(column(py, values)),
        Values::MaybeFlags(values) => objects(py, values),
        Values::Texts(values) => objects(py, values),
        Values::MaybeTexts(values) => objects(py, values),
    }
}
