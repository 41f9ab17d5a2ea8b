//! `RigCalibration`: a rig as its logs have it, and what each of them contributed.

use std::fmt::Write;

use palpate::calibrate::{Contribution, Drift, RigCalibration};
use palpate_io::RigFile;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::estimate::calibration;
use crate::estimate::doubt::DoubtData;
use crate::interop::errors::InternalError;
use crate::interop::pickled::{self, Pickled};
use crate::measured::rig::RigData;

/// The rig that wrote some logs as it is known now, and what each log contributed.
///
/// Made by `calibrate`. `str` says in a few lines what was found.
#[pyclass(frozen, eq, module = "palpate", name = "RigCalibration")]
#[derive(Clone, PartialEq)]
pub struct CalibrationData {
    found: RigCalibration,
    /// The rig with its conventions, and what else its file says.
    rig: RigFile,
    /// Of the logs.
    names: Vec<Option<String>>,
}

impl CalibrationData {
    /// With the conventions of the rig as it was before, and that rig itself where no log counts.
    pub fn of(mut found: RigCalibration, before: &RigFile, names: Vec<Option<String>>) -> Self {
        if found.used() == 0 {
            found.rig = before.rig;
        }
        Self { rig: RigFile { rig: found.rig, ..*before }, found, names }
    }

    fn contributions(&self) -> impl Iterator<Item = ContributionData> {
        let logs = self.found.logs.iter().zip(&self.names);
        logs.map(|(told, name)| ContributionData { told: told.clone(), name: name.clone() })
    }

    /// How many logs count, and of how many.
    fn counted(&self) -> String {
        let logs = self.found.logs.len();
        match self.found.used() {
            0 => format!("NOT calibrated, none of {logs} logs counts"),
            used => format!("calibrated by {used} of {logs} logs"),
        }
    }
}

#[pymethods]
impl CalibrationData {
    /// Rig: the rig as it is known now, with the conventions of the one that was given.
    ///
    /// `reconstruct` and `Log.from_csv` take it, and `Rig.to_toml` makes a rig file of it. Where no log counts, it is the rig that was given.
    #[getter]
    fn rig(&self) -> RigData {
        RigData(self.rig)
    }

    /// dict of str to CalibrationConstant: each constant from all logs together, by name.
    ///
    /// The names are those of `Result.calibration`.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        calibration::by_name(py, &self.found.constants)
    }

    /// list of LogContribution: what each log contributed, in the order given.
    #[getter]
    fn logs(&self) -> Vec<ContributionData> {
        self.contributions().collect()
    }

    /// int: how many logs count.
    #[getter]
    fn used(&self) -> usize {
        self.found.used()
    }

    /// int or None: which of `logs`, from 0, is at odds with all others; None where all agree.
    ///
    /// Its `drift` is more than four standard deviations. Something was mounted anew, or slipped, between the logs before and after.
    #[getter]
    fn drifted(&self) -> Option<usize> {
        self.found.drift().map(|(place, _)| place)
    }

    /// float: relative standard deviation of the size of every object.
    ///
    /// It comes from what the scales of both pads have in common, which only discs of a known radius tell.
    #[getter]
    fn size_sd(&self) -> f64 {
        self.found.rig.size_sd()
    }

    /// float: standard deviation of a parallel shift of every boundary, metres.
    ///
    /// It comes from what both surface offsets have in common, which only discs of a known radius tell.
    #[getter]
    fn offset_sd_m(&self) -> f64 {
        self.found.rig.offset_sd_m()
    }

    fn __str__(&self) -> String {
        let mut text = self.counted();
        let open = self.found.constants.iter().filter(|constant| constant.prior_sd > 0.0);
        for constant in open.filter(|_| self.found.used() > 0) {
            let (name, factor, unit) = calibration::shown(&constant.name);
            let [value, sd, stated, prior_sd] =
                [constant.value, constant.sd, constant.stated, constant.prior_sd].map(|value| factor * value);
            // Writing to a string does not fail.
            let _ = write!(text, "\n{name}: {value:.4} ± {sd:.4} {unit}, stated {stated:.3} ± {prior_sd:.3} {unit}");
        }
        for (place, log) in self.contributions().enumerate() {
            let _ = write!(text, "\nlog {place}{}", log.line());
        }
        if let Some((place, drift)) = self.found.drift() {
            let _ = write!(text, "\nlog {place} is at odds with the others: {}", DriftData(drift.clone()).text());
        }
        text
    }

    fn __repr__(&self) -> String {
        let drifted = self.found.drift().map(|(place, _)| format!(", log {place} is at odds with the others"));
        format!(
            "<RigCalibration: {}; size to {:.2} % and {:.3} mm all around{}>",
            self.counted(),
            100.0 * self.size_sd(),
            1e3 * self.offset_sd_m(),
            drifted.unwrap_or_default()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (encoded(&self.found)?, self.rig(), self.names.clone());
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(found: &str, rig: &RigData, names: Vec<Option<String>>) -> PyResult<Self> {
        decoded(found).map(|found| Self::of(found, &rig.0, names))
    }
}

/// What one log contributed to the calibration of its rig.
#[pyclass(frozen, eq, module = "palpate", name = "LogContribution")]
#[derive(Clone, PartialEq)]
pub struct ContributionData {
    told: Contribution,
    name: Option<String>,
}

impl ContributionData {
    /// Name and residuals, or why it does not count.
    fn line(&self) -> String {
        let mm = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{:.4}", 1e3 * value));
        let name = self.name.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
        if self.told.is_used {
            let (before, after) = (mm(self.told.residual_before_m), mm(self.told.residual_after_m));
            format!("{name}: {after} mm left in the contacts, {before} mm before")
        } else {
            format!("{name} does not count: {}", self.reason())
        }
    }
}

#[pymethods]
impl ContributionData {
    /// str or None: name of the file that the log came from.
    #[getter]
    fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// bool: whether the log counts: its reconstruction is certified, or it is of the disc that is known.
    #[getter]
    fn used(&self) -> bool {
        self.told.is_used
    }

    /// str: why the log does not count; empty where it does.
    #[getter]
    fn reason(&self) -> String {
        match &self.told {
            Contribution { is_used: true, .. } => String::new(),
            Contribution { failure: Some(failure), .. } => failure.clone(),
            Contribution { verdict, .. } if verdict.doubts.is_empty() => "it tells nothing of the rig".to_owned(),
            Contribution { verdict, .. } => verdict.to_string(),
        }
    }

    /// list of Doubt: what is doubtful about its reconstruction; empty where that is certified, failed, or was not needed.
    ///
    /// A log that counts may have doubts of the centre of mass alone.
    #[getter]
    fn doubts(&self) -> Vec<DoubtData> {
        self.told.verdict.doubts.iter().cloned().map(DoubtData).collect()
    }

    /// dict of str to CalibrationConstant: the constants from this log alone, by name; empty where it could not be reconstructed.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        calibration::by_name(py, &self.told.constants)
    }

    /// float or None: what is left in the contact positions with the constants as stated, metres; None where that cannot be said.
    #[getter]
    fn residual_before_m(&self) -> Option<f64> {
        self.told.residual_before_m
    }

    /// float or None: the same with the constants of all logs together.
    #[getter]
    fn residual_after_m(&self) -> Option<f64> {
        self.told.residual_after_m
    }

    /// ConstantDrift or None: the constant that differs most from that of all other logs.
    ///
    /// None where the log does not count, no other does, or they are of a disc.
    #[getter]
    fn drift(&self) -> Option<DriftData> {
        self.told.drift.clone().map(DriftData)
    }

    fn __repr__(&self) -> String {
        format!("<LogContribution{}>", self.line())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        pickled::by_method::<Self>(py, "_made", (encoded(&self.told)?, self.name()))
    }

    #[staticmethod]
    fn _made(told: &str, name: Option<String>) -> PyResult<Self> {
        decoded(told).map(|told| Self { told, name })
    }
}

/// A constant of one log against that of all other logs.
#[pyclass(frozen, eq, module = "palpate", name = "ConstantDrift")]
#[derive(Clone, PartialEq)]
pub struct DriftData(Drift);

impl DriftData {
    fn text(&self) -> String {
        let (name, factor, unit) = calibration::shown(&self.0.constant);
        format!(
            "{name} differs by {:.4} {unit}, {:.1} of its standard deviations",
            factor * self.0.difference,
            self.0.sds.abs()
        )
    }
}

#[pymethods]
impl DriftData {
    /// str: name of the constant, as in `CalibrationConstant.name`.
    #[getter]
    fn constant(&self) -> &str {
        &self.0.constant
    }

    /// float: that of the log less that of the others, in the unit of its name.
    #[getter]
    fn difference(&self) -> f64 {
        self.0.difference
    }

    /// float: the same in its standard deviations.
    #[getter]
    fn sds(&self) -> f64 {
        self.0.sds
    }

    fn __repr__(&self) -> String {
        format!("<ConstantDrift: {}>", self.text())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let Drift { constant, difference, sds } = &self.0;
        pickled::by_method::<Self>(py, "_made", (constant, *difference, *sds))
    }

    #[staticmethod]
    fn _made(constant: String, difference: f64, sds: f64) -> Self {
        Self(Drift { constant, difference, sds })
    }
}

/// As text, to be pickled.
fn encoded(thing: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(thing).map_err(internal)
}

/// The same, read back.
fn decoded<'a, T: serde::Deserialize<'a>>(text: &'a str) -> PyResult<T> {
    serde_json::from_str(text).map_err(internal)
}

fn internal(error: serde_json::Error) -> PyErr {
    InternalError::new_err(format!("a calibration: {error}"))
}
