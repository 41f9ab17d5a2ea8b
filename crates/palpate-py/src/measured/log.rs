//! `Log`: what the robot knows, sample by sample.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use palpate::palms::PalmPair;
use palpate::{Log, Sample};
use palpate_io::{Conventions, LogFile};
use pyo3::exceptions::PyAttributeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use crate::interop::arrays::{self, Column, Table};
use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::measured::rig::{self, RigGiven};

/// Stands for the file in messages about columns in memory.
const COLUMNS: &str = "the columns (lines counted from 0)";
/// The same for a file object without a name.
const READER: &str = "the file object";
/// The same for a data frame.
const FRAME: &str = "the data frame (lines counted from 0)";

/// A palm log: palm angles and contact positions over time.
///
/// Columns whose names carry units, as in a CSV file, go through `from_numpy` or `from_pandas`; this takes SI units and radians. All are
/// checked by the rules of `palpate reconstruct`.
///
/// Parameters
/// ----------
/// time_s : array_like of float, datetime64 or timedelta64, shape (n,)
///     Time, increasing, seconds. Dates become seconds since the first of them.
/// phi1_rad : array_like of float, shape (n,)
///     Angle of palm 1 against the horizontal, radians.
/// phi2_rad : array_like of float, shape (n,)
///     Angle from palm 1 to palm 2, counter-clockwise, 0 to pi, radians.
/// s1_m, s2_m : array_like of float, shape (n,)
///     Distance of the contact from the base of each palm, metres; NaN where no contact was seen.
/// s1_sd_m, s2_sd_m : array_like of float, shape (n,), optional
///     Standard deviation of each reading, metres; NaN where it is not known.
/// base1_m, base2_m : array_like of float, shape (n, 2), optional
///     Base points of the palms in a frame whose Y axis points up, metres. Default: both in the origin.
/// force1_n, force2_n : array_like of float, shape (n,), optional
///     Normal force at each contact, newtons; NaN where it is not known.
/// metadata : dict of str to str, optional
///     Notes that go with the log into a file.
///
///
/// Raises
/// ------
/// ReadError
///     If a value is missing or impossible, time decreases, the palms are parallel, or fewer than 12 samples have both contacts.
#[pyclass(frozen, module = "palpate", name = "Log")]
pub struct LogData {
    pub file: Arc<LogFile>,
    /// Those of a rig that the samples were turned by, so that they are turned but once.
    pub conventions: Conventions,
    /// str or None: name of the file that it came from.
    #[pyo3(get)]
    pub name: Option<String>,
    /// numpy.ndarray: time, shape (n,), seconds; read-only, as all arrays here.
    #[pyo3(get)]
    time_s: Py<PyArray1<f64>>,
    /// numpy.ndarray: angle of palm 1 against the horizontal, shape (n,), radians.
    #[pyo3(get)]
    phi1_rad: Py<PyArray1<f64>>,
    /// numpy.ndarray: angle from palm 1 to palm 2, counter-clockwise, shape (n,), radians.
    #[pyo3(get)]
    phi2_rad: Py<PyArray1<f64>>,
    /// numpy.ndarray: distance of contact 1 from the base of its palm, shape (n,), metres; NaN where no contact was seen.
    #[pyo3(get)]
    s1_m: Py<PyArray1<f64>>,
    /// numpy.ndarray: distance of contact 2 from the base of its palm, shape (n,), metres; NaN where no contact was seen.
    #[pyo3(get)]
    s2_m: Py<PyArray1<f64>>,
    /// numpy.ndarray or None: standard deviation of each reading of pad 1, shape (n,), metres; None where nothing is stated.
    #[pyo3(get)]
    s1_sd_m: Option<Py<PyArray1<f64>>>,
    /// numpy.ndarray or None: standard deviation of each reading of pad 2, shape (n,), metres; None where nothing is stated.
    #[pyo3(get)]
    s2_sd_m: Option<Py<PyArray1<f64>>>,
    /// numpy.ndarray: base point of palm 1, shape (n, 2), metres.
    #[pyo3(get)]
    base1_m: Py<PyArray2<f64>>,
    /// numpy.ndarray: base point of palm 2, shape (n, 2), metres.
    #[pyo3(get)]
    base2_m: Py<PyArray2<f64>>,
    /// numpy.ndarray or None: normal force at contact 1, shape (n,), newtons; None where nothing is stated.
    #[pyo3(get)]
    force1_n: Option<Py<PyArray1<f64>>>,
    /// numpy.ndarray or None: normal force at contact 2, shape (n,), newtons; None where nothing is stated.
    #[pyo3(get)]
    force2_n: Option<Py<PyArray1<f64>>>,
}

impl LogData {
    /// With its arrays.
    pub fn of(py: Python<'_>, file: LogFile, name: Option<String>) -> Self {
        let samples = &file.log.samples;
        let required = |value: fn(&Sample) -> f64| arrays::column(py, samples.iter().map(value).collect());
        let seen = |value: fn(&Sample) -> Option<f64>| arrays::sparse_column(py, samples.iter().map(value));
        let stated = |value: fn(&Sample) -> Option<f64>| {
            samples.iter().any(|sample| value(sample).is_some()).then(|| seen(value))
        };
        let points = |value: fn(&Sample) -> [f64; 2]| {
            let rows: Vec<[f64; 2]> = samples.iter().map(value).collect();
            arrays::table(py, &rows)
        };
        Self {
            name,
            time_s: required(|sample| sample.time_s),
            phi1_rad: required(|sample| sample.palms.phi1_rad),
            phi2_rad: required(|sample| sample.palms.phi2_rad),
            s1_m: seen(|sample| sample.s1_m),
            s2_m: seen(|sample| sample.s2_m),
            s1_sd_m: stated(|sample| sample.s1_sd_m),
            s2_sd_m: stated(|sample| sample.s2_sd_m),
            base1_m: points(|sample| sample.palms.base1_m),
            base2_m: points(|sample| sample.palms.base2_m),
            force1_n: stated(|sample| sample.force1_n),
            force2_n: stated(|sample| sample.force2_n),
            file: Arc::new(file),
            conventions: Conventions::default(),
        }
    }

    /// Some of the samples, with what goes with all of them.
    fn with_samples(&self, py: Python<'_>, samples: Vec<Sample>) -> Self {
        let file = LogFile { log: Log { samples }, ..(*self.file).clone() };
        Self { conventions: self.conventions, ..Self::of(py, file, self.name.clone()) }
    }

    /// The same log with samples that were turned by these conventions.
    pub fn turned(&self, py: Python<'_>, log: Log, conventions: Conventions) -> Self {
        Self { conventions, ..self.with_samples(py, log.samples) }
    }
}

/// A CSV file as Python gives it: where it is, or what reads it.
#[derive(FromPyObject)]
pub enum CsvGiven {
    Path(PathBuf),
    Reader(Py<PyAny>),
}

impl CsvGiven {
    /// The log in it, as a rig with these conventions wrote it.
    fn log(self, py: Python<'_>, conventions: Conventions) -> PyResult<LogData> {
        let (file, name) = match self {
            Self::Path(path) => {
                let file = py.detach(|| palpate_io::read_log_as(&path, &conventions)).or_raise()?;
                (file, path.file_name().map(|name| name.to_string_lossy().into_owned()))
            }
            Self::Reader(reader) => {
                let reader = reader.into_bound(py);
                let read = reader.call_method0("read").map_err(|error| {
                    let is_none = error.is_instance_of::<PyAttributeError>(py);
                    let text =
                        "a log is read from the path of a file, or from a file object that gives its text or bytes";
                    if is_none { errors::input(text.to_owned()) } else { error }
                })?;
                let bytes = if let Ok(text) = read.extract::<String>() { text.into_bytes() } else { read.extract()? };
                let name: Option<String> = reader.getattr("name").and_then(|name| name.extract()).ok();
                let shown = name.as_deref().unwrap_or(READER);
                let parsed = py.detach(|| {
                    let bytes = palpate_io::bytes_from(shown, bytes.as_slice())?;
                    palpate_io::parse_log_as(shown, &bytes, &conventions)
                });
                let name = name.map(|name| name.rsplit(['/', '\\']).next().unwrap_or_default().to_owned());
                (parsed.or_raise()?, name)
            }
        };
        Ok(LogData { conventions, ..LogData::of(py, checked(py, file)?, name) })
    }
}

/// A log as Python gives it: itself, a CSV file, a data frame, or columns by name.
#[derive(FromPyObject)]
pub enum LogGiven {
    Log(Py<LogData>),
    Path(PathBuf),
    Other(Py<PyAny>),
}

impl LogGiven {
    /// The log with signs, directions and base points as palpate has them.
    pub fn with_conventions(self, py: Python<'_>, conventions: &Conventions) -> PyResult<Py<LogData>> {
        let log = match self {
            Self::Log(log) => log,
            // What is read by the conventions may have angles that no log has without.
            Self::Path(path) => Py::new(py, CsvGiven::Path(path).log(py, *conventions)?)?,
            Self::Other(other) => {
                let given = other.bind(py);
                let log = if given.hasattr("read")? {
                    CsvGiven::Reader(other).log(py, *conventions)?
                } else if given.hasattr("iloc")? {
                    LogData::from_pandas(py, given)?
                } else if given.hasattr("keys")? || given.hasattr("dtype")? {
                    LogData::from_numpy(py, Some(given), None)?
                } else {
                    let kind = given.get_type().name()?;
                    let message = "a log is a Log, the path of a CSV file, an open file, a data frame, or a mapping of names to columns";
                    let one = if given.hasattr("__iter__")? { "; one log for each call" } else { "" };
                    return Err(errors::input(format!("{message}, not {kind}{one}")));
                };
                Py::new(py, log)?
            }
        };
        rig::with_conventions(py, log, conventions)
    }
}

#[pymethods]
impl LogData {
    #[new]
    #[pyo3(signature = (time_s, phi1_rad, phi2_rad, s1_m, s2_m, *, s1_sd_m=None, s2_sd_m=None, base1_m=None, base2_m=None,
        force1_n=None, force2_n=None, metadata=None))]
    #[expect(clippy::too_many_arguments, reason = "Python calls it by keywords")]
    fn new(
        py: Python<'_>,
        time_s: &Bound<'_, PyAny>,
        phi1_rad: &Bound<'_, PyAny>,
        phi2_rad: &Bound<'_, PyAny>,
        s1_m: &Bound<'_, PyAny>,
        s2_m: &Bound<'_, PyAny>,
        s1_sd_m: Option<&Bound<'_, PyAny>>,
        s2_sd_m: Option<&Bound<'_, PyAny>>,
        base1_m: Option<Table>,
        base2_m: Option<Table>,
        force1_n: Option<&Bound<'_, PyAny>>,
        force2_n: Option<&Bound<'_, PyAny>>,
        metadata: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let given = [
            ("time_s", Some(time_s)),
            ("phi1_rad", Some(phi1_rad)),
            ("phi2_rad", Some(phi2_rad)),
            ("s1_m", Some(s1_m)),
            ("s2_m", Some(s2_m)),
            ("s1_sd_m", s1_sd_m),
            ("s2_sd_m", s2_sd_m),
            ("force1_n", force1_n),
            ("force2_n", force2_n),
        ];
        let mut columns = Vec::new();
        for (name, values) in given {
            if let Some(values) = values {
                columns.push(column(name, values)?);
            }
        }
        for (base, table) in [("base1", base1_m), ("base2", base2_m)] {
            if let Some(table) = table {
                let rows: Vec<[f64; 2]> = arrays::rows(&format!("{base}_m"), &table)?;
                for (axis, name) in [format!("{base}_x_m"), format!("{base}_y_m")].into_iter().enumerate() {
                    columns.push((name, rows.iter().map(|row| row[axis].to_string()).collect()));
                }
            }
        }
        let file = checked(py, palpate_io::log_from_columns(COLUMNS, &columns).or_raise()?)?;
        let metadata = metadata.into_iter().flatten().map(|(key, value)| Ok((key.extract()?, value.extract()?)));
        let metadata = metadata.collect::<PyResult<_>>()?;
        Ok(Self::of(py, LogFile { metadata, ..file }, None))
    }

    /// Read a palm log from a CSV file.
    ///
    /// Parameters
    /// ----------
    /// path : str, os.PathLike or file object
    ///     The file, or one compressed by gzip, or what has a method `read` that gives its text or bytes. Columns are found by name, in any order; the name carries the unit, such as s1_mm or
    ///     "phi1 (deg)".
    /// rig : Rig or str or os.PathLike, optional
    ///     The rig that wrote it, or its file: signs of the angles, directions of the pads and base points are taken as the rig has them,
    ///     which `reconstruct` then does not do again. Needed where palm 2 counts negative angles. The constants of the rig stay in the
    ///     log. Default: as palpate has them.
    ///
    /// Returns
    /// -------
    /// Log
    ///     The log; what there is to say about the file is in its `notes`.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If the file cannot be read or is no usable palm log; the message says where, what, and what to do.
    #[staticmethod]
    #[pyo3(signature = (path, *, rig=None))]
    fn from_csv(py: Python<'_>, path: CsvGiven, rig: Option<RigGiven>) -> PyResult<Self> {
        let conventions = match rig {
            Some(rig) => rig.read(py)?.conventions,
            None => Conventions::default(),
        };
        path.log(py, conventions)
    }

    /// A palm log from arrays whose names carry units, as the columns of a CSV file do.
    ///
    /// Parameters
    /// ----------
    /// columns : mapping of str to array_like, or structured numpy.ndarray, optional
    ///     The columns by name, such as time_s, phi1_deg, phi2_deg, s1_mm, s2_mm; others are left aside, with a warning. Time may be a
    ///     datetime64 or timedelta64, which needs no unit in its name.
    /// **named : array_like
    ///     More of them.
    ///
    /// Returns
    /// -------
    /// Log
    ///     The log.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If a column is missing or has no unit, or as for `Log`.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, palpate
    /// >>> n = np.arange(20)
    /// >>> log = palpate.Log.from_numpy(time_ms=50 * n, phi1_deg=60 + n, phi2_deg=74 + n, s1_mm=30 + 0 * n, s2_mm=32 + 0 * n)
    /// >>> float(log.s1_m[0])
    /// 0.03
    #[staticmethod]
    #[pyo3(signature = (columns=None, /, **named))]
    fn from_numpy(
        py: Python<'_>,
        columns: Option<&Bound<'_, PyAny>>,
        named: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut all = Vec::new();
        if let Some(columns) = columns {
            all.extend(columns_of(columns)?);
        }
        for (name, values) in named.into_iter().flatten() {
            all.push(column(&name.extract::<String>()?, &values)?);
        }
        let file = checked(py, palpate_io::log_from_columns(COLUMNS, &all).or_raise()?)?;
        Ok(Self::of(py, file, None))
    }

    /// A palm log from a pandas data frame whose column names carry units.
    ///
    /// Parameters
    /// ----------
    /// frame : pandas.DataFrame
    ///     A row for each sample, with columns as in a CSV file. A missing value in s1 or s2 means that no contact was seen. Time is a
    ///     column or the index, as numbers in the unit that its name says, or as dates (read as seconds since the first) or durations.
    ///
    /// Returns
    /// -------
    /// Log
    ///     The log.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If a column is missing or has no unit, or as for `Log`.
    #[staticmethod]
    fn from_pandas(py: Python<'_>, frame: &Bound<'_, PyAny>) -> PyResult<Self> {
        let columns = py.import("palpate._pandas")?.getattr("columns_of")?.call1((frame,))?;
        let file = checked(py, palpate_io::log_from_columns(FRAME, &columns_of(&columns)?).or_raise()?)?;
        Ok(Self::of(py, file, None))
    }

    /// The log as a pandas data frame.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     A row for each sample, with the columns of a CSV file in SI units; optional ones only where something is stated.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._pandas")?.getattr("frame_of")?.call1((slf,))
    }

    /// The log as a dictionary of arrays.
    ///
    /// Returns
    /// -------
    /// dict of str to numpy.ndarray
    ///     The columns of a CSV file in SI units, in its order; optional ones only where something is stated.
    fn to_numpy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        let required = [
            ("time_s", &self.time_s),
            ("phi1_rad", &self.phi1_rad),
            ("phi2_rad", &self.phi2_rad),
            ("s1_m", &self.s1_m),
            ("s2_m", &self.s2_m),
        ];
        for (name, values) in required {
            columns.set_item(name, values)?;
        }
        let samples = &self.file.log.samples;
        let bases = |sample: &Sample| {
            let ([x1, y1], [x2, y2]) = (sample.palms.base1_m, sample.palms.base2_m);
            [x1, y1, x2, y2]
        };
        if samples.iter().any(|sample| bases(sample) != [0.0; 4]) {
            for (place, name) in ["base1_x_m", "base1_y_m", "base2_x_m", "base2_y_m"].into_iter().enumerate() {
                columns
                    .set_item(name, arrays::column(py, samples.iter().map(|sample| bases(sample)[place]).collect()))?;
            }
        }
        let stated = [
            ("s1_sd_m", &self.s1_sd_m),
            ("s2_sd_m", &self.s2_sd_m),
            ("force1_n", &self.force1_n),
            ("force2_n", &self.force2_n),
        ];
        for (name, values) in stated {
            if let Some(values) = values {
                columns.set_item(name, values)?;
            }
        }
        Ok(columns)
    }

    /// Draw palm angles and contact positions over time, in degrees and millimetres.
    ///
    /// Parameters
    /// ----------
    /// axes : sequence of matplotlib.axes.Axes, optional
    ///     Two of them; by default in a new figure.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     The two axes drawn in.
    #[pyo3(signature = (axes=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, axes: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._plot")?.getattr("plot_log")?.call1((slf, axes))
    }

    /// Write the log to a CSV file, with digits enough to read back the same numbers.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The file, written whole or not at all; folders on the way to it are made.
    ///
    /// Raises
    /// ------
    /// WriteError
    ///     If it cannot be written, or metadata would not read back.
    fn to_csv(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| palpate_io::write_log(&path, &self.file.log, &self.file.metadata)).or_raise()
    }

    /// dict of str to str: notes that go with the log into a file; a copy.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let metadata = PyDict::new(py);
        for (key, value) in &self.file.metadata {
            metadata.set_item(key, value)?;
        }
        Ok(metadata)
    }

    /// list of str: what there is to say about the file or table, such as columns left aside.
    ///
    /// Each of them is a `ReadWarning` as well.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.file.notes.clone()
    }

    fn __len__(&self) -> usize {
        self.file.log.samples.len()
    }

    fn __getitem__(&self, py: Python<'_>, samples: &Bound<'_, PyAny>) -> PyResult<Self> {
        let all = &self.file.log.samples;
        // numpy knows slices, masks and indices, and what is wrong with one.
        let numbers = py.import("numpy")?.getattr("arange")?.call1((all.len(),))?.get_item(samples)?;
        let chosen: Vec<usize> = numbers.extract().map_err(|_| {
            errors::input("a log is cut by a slice, a mask or an array of indices; its columns are arrays".to_owned())
        })?;
        Ok(self.with_samples(py, chosen.into_iter().filter_map(|index| all.get(index).copied()).collect()))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.file.log == other.file.log
    }

    fn __repr__(&self) -> String {
        format!("<Log: {}>", self.told())
    }

    fn _repr_html_(&self) -> String {
        let name = self.name.as_deref().map(|name| format!(" {}", escaped(name))).unwrap_or_default();
        let notes: String = self.file.notes.iter().map(|note| format!("<br>{}", escaped(note))).collect();
        format!("<p><b>Palm log{name}</b>: {}{notes}</p>", escaped(&self.told()))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let file = &self.file;
        let notes = (file.metadata.clone(), file.notes.clone());
        let arguments = (self.to_rows(py), notes, self.name.clone(), rig::conventions_text(&self.conventions));
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(
        py: Python<'_>,
        rows: Table,
        told: (Vec<(String, String)>, Vec<String>),
        name: Option<String>,
        conventions: &str,
    ) -> PyResult<Self> {
        let samples = arrays::rows("a log", &rows)?.iter().map(sample).collect();
        let (metadata, notes) = told;
        let file = LogFile { log: Log { samples }, metadata, notes };
        Ok(Self { conventions: rig::conventions_of(conventions)?, ..Self::of(py, file, name) })
    }
}

impl LogData {
    fn told(&self) -> String {
        let samples = &self.file.log.samples;
        let span = samples.first().zip(samples.last()).map_or(0.0, |(first, last)| last.time_s - first.time_s);
        let both = samples.iter().filter(|sample| sample.s1_m.is_some() && sample.s2_m.is_some()).count();
        format!("{} samples in {span:.2} s, {both} with both contacts", samples.len())
    }

    /// All there is to know of each sample; NaN where nothing is.
    fn to_rows(&self, py: Python<'_>) -> Py<PyArray2<f64>> {
        let rows: Vec<[f64; 13]> = self.file.log.samples.iter().map(row).collect();
        arrays::table(py, &rows)
    }
}

fn row(sample: &Sample) -> [f64; 13] {
    let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let ([x1, y1], [x2, y2]) = (sample.palms.base1_m, sample.palms.base2_m);
    let [s1, s2, sd1, sd2] = [sample.s1_m, sample.s2_m, sample.s1_sd_m, sample.s2_sd_m].map(or_nan);
    let [force1, force2] = [sample.force1_n, sample.force2_n].map(or_nan);
    let palms = &sample.palms;
    [sample.time_s, palms.phi1_rad, palms.phi2_rad, x1, y1, x2, y2, s1, s2, sd1, sd2, force1, force2]
}

fn sample(row: &[f64; 13]) -> Sample {
    let [time_s, phi1_rad, phi2_rad, x1, y1, x2, y2, s1, s2, sd1, sd2, force1, force2] = *row;
    let known = |value: f64| Some(value).filter(|value| !value.is_nan());
    Sample {
        time_s,
        palms: PalmPair { phi1_rad, phi2_rad, base1_m: [x1, y1], base2_m: [x2, y2] },
        s1_m: known(s1),
        s2_m: known(s2),
        s1_sd_m: known(sd1),
        s2_sd_m: known(sd2),
        force1_n: known(force1),
        force2_n: known(force2),
    }
}

/// Columns by name: of a mapping, or of a structured array.
fn columns_of(table: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Vec<String>)>> {
    let pairs: Vec<(String, Bound<'_, PyAny>)> = if let Ok(mapping) = table.cast::<PyMapping>() {
        mapping.items()?.extract()?
    } else {
        let names: Option<Vec<String>> = table.getattr("dtype").and_then(|kind| kind.getattr("names")?.extract()).ok();
        let names = names.ok_or_else(|| {
            errors::input("the columns must be a mapping of names to arrays, or a structured array".to_owned())
        })?;
        let columns = names.into_iter().map(|name| table.get_item(&name).map(|column| (name, column)));
        columns.collect::<PyResult<_>>()?
    };
    pairs.into_iter().map(|(name, values)| column(&name, &values)).collect()
}

/// A column with its cells. Dates and durations of numpy know their unit: whatever the name says, they are read in seconds, dates as the
/// time since the first.
fn column(name: &str, values: &Bound<'_, PyAny>) -> PyResult<(String, Vec<String>)> {
    let kind: Option<String> = values.getattr("dtype").and_then(|kind| kind.getattr("kind")?.extract()).ok();
    let is_date = match kind.as_deref() {
        Some("M") => true,
        Some("m") => false,
        _ => return Ok((name.to_owned(), cells(name, values)?)),
    };
    let Some(in_seconds) = palpate_io::name_in_seconds(name) else {
        // No other quantity is a date; as text it is refused, or left aside.
        return Ok((name.to_owned(), cells(name, &values.call_method1("astype", ("str",))?)?));
    };
    let durations = if is_date && values.len().is_ok_and(|length| length > 0) {
        values.sub(values.get_item(0)?)?
    } else {
        values.clone()
    };
    let second = values.py().import("numpy")?.getattr("timedelta64")?.call1((1, "s"))?;
    Ok((in_seconds, cells(name, &durations.div(second)?)?))
}

/// A log that was read, after a Python warning for each of its notes.
fn checked(py: Python<'_>, file: LogFile) -> PyResult<LogFile> {
    errors::warn(py, &file.notes)?;
    Ok(file)
}

/// The cells of a column: numbers where it holds numbers, else what Python prints.
fn cells(name: &str, values: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if let Ok(numbers) = values.extract::<Column>() {
        return Ok(arrays::values(&numbers).iter().map(f64::to_string).collect());
    }
    if values.getattr("ndim").and_then(|ndim| ndim.extract::<usize>()).is_ok_and(|ndim| ndim != 1) {
        return Err(errors::input(format!("{name} must be one-dimensional, with one value for each sample")));
    }
    let cells = values.try_iter().map_err(|_| errors::input(format!("{name} must be an array")))?;
    cells.map(|cell| cell.map(|cell| if cell.is_none() { String::new() } else { cell.to_string() })).collect()
}

/// Text that is safe within HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
