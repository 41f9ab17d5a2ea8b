//! `Rig`: what is known of palms and pads before a log is read.

use std::path::PathBuf;

use palpate::sensor::Rig;
use palpate_io::{Conventions, RigFile};
use pyo3::prelude::*;

use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::measured::log::LogData;

/// What messages call a rig that is no file.
const TEXT: &str = "the rig";

/// What is known of palms and pads before a log is read: calibration constants, each with its standard deviation, and conventions.
///
/// `Rig()` has the default tolerances: nobody measured with care. `reconstruct` estimates the constants that are not exact together with
/// the shape, as far as the log tells them. A standard deviation of 0 means exact. Pairs are palm 1 and palm 2.
///
/// Examples
/// --------
/// A pad whose zero is 0.3 mm off, which nobody knows:
///
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg")
/// >>> log, truth = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), rate_hz=5)
/// >>> log = palpate.Log(log.time_s, log.phi1_rad, log.phi2_rad, log.s1_m + 0.3e-3, log.s2_m)
/// >>> result = palpate.reconstruct(log, rig=palpate.Rig())
/// >>> zero = result.calibration["s1_zero_m"]
/// >>> abs(zero.value - 0.3e-3) < 5 * zero.sd < zero.prior_sd
/// True
#[pyclass(frozen, eq, module = "palpate", name = "Rig")]
#[derive(Clone, PartialEq)]
pub struct RigData(pub RigFile);

#[pymethods]
impl RigData {
    #[new]
    fn new() -> Self {
        Self(RigFile::default())
    }

    /// A rig whose constants are all known exactly: readings are taken as they are, as without a rig.
    ///
    /// Returns
    /// -------
    /// Rig
    ///     The rig.
    #[staticmethod]
    fn exact() -> Self {
        Self(RigFile::exact())
    }

    /// Read a rig file.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The file, TOML as `palpate rig --template` prints it. Every key may be left out; it carries its unit, such as zero_mm.
    ///
    /// Returns
    /// -------
    /// Rig
    ///     The rig.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If the file cannot be read or is no usable rig file; the message says where, what, and what to do. The key is its `column`.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| palpate_io::read_rig(&path)).or_raise().map(Self)
    }

    /// A rig from the text of a rig file.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     The text, TOML.
    ///
    /// Returns
    /// -------
    /// Rig
    ///     The rig.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     As for `read`.
    ///
    /// Examples
    /// --------
    /// >>> import palpate
    /// >>> rig = palpate.Rig.parse('''
    /// ... [palm1]
    /// ... zero_mm = 0.3
    /// ... zero_sd_um = 20
    /// ... ''')
    /// >>> rig.zero_m, rig.zero_sd_m
    /// ((0.0003, 0.0), (2e-05, 0.0005))
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Self> {
        palpate_io::parse_rig(TEXT, text).or_raise().map(Self)
    }

    /// A rig file to begin with: every key with its unit, its meaning and how to measure it.
    ///
    /// Returns
    /// -------
    /// str
    ///     The text, TOML. It says what `Rig()` is.
    #[staticmethod]
    fn template() -> &'static str {
        palpate_io::rig_template()
    }

    /// The rig as a rig file, in SI units, with digits enough to read back the same numbers.
    ///
    /// Returns
    /// -------
    /// str
    ///     The text, TOML: every constant with its standard deviation, the rest where it is known.
    fn to_toml(&self) -> String {
        palpate_io::rig_to_toml(&self.0)
    }

    /// tuple of float: what each pad adds to every position, metres: reading = scale * position + zero.
    #[getter]
    fn zero_m(&self) -> (f64, f64) {
        self.0.rig.calibration.zero_m.into()
    }

    /// tuple of float: standard deviations of `zero_m`, metres.
    #[getter]
    fn zero_sd_m(&self) -> (f64, f64) {
        self.0.rig.tolerances.zero_sd_m.into()
    }

    /// tuple of float: what each pad multiplies every position by; 1 without error.
    #[getter]
    fn scale(&self) -> (f64, f64) {
        self.0.rig.calibration.scale.into()
    }

    /// tuple of float: standard deviations of `scale`.
    ///
    /// What both have in common goes into the size of every object, whatever a log tells.
    #[getter]
    fn scale_sd(&self) -> (f64, f64) {
        self.0.rig.tolerances.scale_sd.into()
    }

    /// tuple of float: how far each sensing surface lies in front of the line through the base point of its palm, metres.
    #[getter]
    fn surface_offset_m(&self) -> (f64, f64) {
        self.0.rig.calibration.surface_m.into()
    }

    /// tuple of float: standard deviations of `surface_offset_m`, metres.
    ///
    /// What both have in common shifts every boundary, whatever a log tells.
    #[getter]
    fn surface_offset_sd_m(&self) -> (f64, f64) {
        self.0.rig.tolerances.surface_sd_m.into()
    }

    /// tuple of float: what the encoders add to phi1 and to phi2, radians.
    #[getter]
    fn phi_zero_rad(&self) -> (f64, f64) {
        self.0.rig.calibration.angle_zero_rad.into()
    }

    /// tuple of float: standard deviations of `phi_zero_rad`, radians.
    #[getter]
    fn phi_zero_sd_rad(&self) -> (f64, f64) {
        self.0.rig.tolerances.angle_zero_sd_rad.into()
    }

    /// float: how much later than the positions of a sample its angles were read, seconds.
    #[getter]
    fn clock_offset_s(&self) -> f64 {
        self.0.rig.calibration.clock_offset_s
    }

    /// float: standard deviation of `clock_offset_s`, seconds.
    #[getter]
    fn clock_offset_sd_s(&self) -> f64 {
        self.0.rig.tolerances.clock_offset_sd_s
    }

    fn __repr__(&self) -> String {
        let Rig { calibration, tolerances, .. } = &self.0.rig;
        let clock = ([calibration.clock_offset_s], [tolerances.clock_offset_sd_s]);
        let conventions = self.0.conventions != Conventions::default();
        format!(
            "<Rig: zero {} mm, scale {}, surface offset {} mm, phi zero {} rad, clock offset {} ms{}>",
            told(calibration.zero_m, tolerances.zero_sd_m, 1e3),
            told(calibration.scale, tolerances.scale_sd, 1.0),
            told(calibration.surface_m, tolerances.surface_sd_m, 1e3),
            told(calibration.angle_zero_rad, tolerances.angle_zero_sd_rad, 1.0),
            told(clock.0, clock.1, 1e3),
            if conventions { ", conventions of its own" } else { "" }
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        pickled::by_method::<Self>(py, "parse", (self.to_toml(),))
    }
}

/// Constants with their standard deviations, in a unit that is so many times smaller.
fn told<const N: usize>(values: [f64; N], sds: [f64; N], times: f64) -> String {
    let one = |(value, sd): (f64, f64)| format!("{} ± {}", short(times * value), short(times * sd));
    let all: Vec<String> = values.into_iter().zip(sds).map(one).collect();
    all.join(" and ")
}

/// A number with no more than six decimals, and no zeros behind them.
fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    (if text == "-0" { "0" } else { text }).to_owned()
}

/// A rig as it comes from Python.
#[derive(FromPyObject)]
pub enum RigGiven {
    Rig(Py<RigData>),
    File(PathBuf),
}

impl RigGiven {
    /// The rig; a file is read.
    pub fn read(&self, py: Python<'_>) -> PyResult<RigFile> {
        match self {
            Self::Rig(rig) => Ok(rig.get().0),
            Self::File(path) => py.detach(|| palpate_io::read_rig(path)).or_raise(),
        }
    }
}

/// The log with signs, directions and base points as palpate has them; as it is where they are so already.
pub fn with_conventions(py: Python<'_>, log: Py<LogData>, conventions: &Conventions) -> PyResult<Py<LogData>> {
    let data = log.get();
    if *conventions == Conventions::default() || *conventions == data.conventions {
        return Ok(log);
    }
    if data.conventions != Conventions::default() {
        let text = "the log was read by the conventions of another rig (signs, directions of the pads, base points); give that rig, or read the log again";
        return Err(errors::input(text.to_owned()));
    }
    let applied = conventions.apply(&data.file.log);
    let angles_rad = applied.samples.iter().map(|sample| sample.palms.phi2_rad);
    if let Some((index, phi2_rad)) =
        angles_rad.enumerate().find(|(_, phi2_rad)| !(0.0..std::f64::consts::PI).contains(phi2_rad))
    {
        let sign = conventions.angle_signs[1];
        return Err(errors::input(format!(
            "sample {} (counted from 1): with sign2 = {sign} of the rig the angle from palm 1 to palm 2 is {phi2_rad} rad, and it must lie between 0 and pi; correct the sign, or read the log by the rig: Log.from_csv(path, rig=rig)",
            index + 1
        )));
    }
    Py::new(py, data.turned(py, applied, *conventions))
}

/// Conventions as text, to be pickled.
pub fn conventions_text(conventions: &Conventions) -> String {
    palpate_io::rig_to_toml(&RigFile { conventions: *conventions, ..RigFile::default() })
}

/// The same, read back.
pub fn conventions_of(text: &str) -> PyResult<Conventions> {
    Ok(palpate_io::parse_rig(TEXT, text).or_raise()?.conventions)
}
