//! `CalibrationConstant`: what a log told of the rig that wrote it.

use palpate::reconstruct::{CalibrationEstimate, ConstantEstimate};
use palpate::sensor::{Calibration, CalibrationConstant};
use palpate_io::{ConstantSummary, Summary};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::interop::errors::InternalError;
use crate::interop::pickled::{self, Pickled};

/// A calibration constant of the rig as a log has it, in the unit of its name.
#[pyclass(frozen, eq, module = "palpate", name = "CalibrationConstant")]
#[derive(Clone, PartialEq)]
pub struct ConstantData(pub ConstantEstimate);

#[pymethods]
impl ConstantData {
    /// str: which constant it is, and its unit.
    ///
    /// 's1_zero_m', 's2_zero_m', 'scale_ratio' (scale 1 less scale 2), 'phi1_zero_rad', 'phi2_zero_rad', 'surface_difference_m' (1 less 2)
    /// or 'clock_offset_s'.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// float: what the log has it to be.
    #[getter]
    fn value(&self) -> f64 {
        self.0.value
    }

    /// float: its standard deviation; that of the rig as stated where the log tells nothing, and 0 for a constant that is exact.
    #[getter]
    fn sd(&self) -> f64 {
        self.0.sd
    }

    /// float: what the rig was stated to have.
    #[getter]
    fn stated(&self) -> f64 {
        self.0.stated
    }

    /// float: the standard deviation of that; 0 = exact.
    #[getter]
    fn prior_sd(&self) -> f64 {
        self.0.prior_sd
    }

    fn __repr__(&self) -> String {
        let ConstantEstimate { name, value, sd, stated, prior_sd } = &self.0;
        format!("<CalibrationConstant: {name} {value:.4e} ± {sd:.1e}, stated {stated:.4e} ± {prior_sd:.1e}>")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let ConstantEstimate { name, value, sd, stated, prior_sd } = &self.0;
        pickled::by_method::<Self>(py, "_made", (name, *value, *sd, *stated, *prior_sd))
    }

    #[staticmethod]
    fn _made(name: String, value: f64, sd: f64, stated: f64, prior_sd: f64) -> Self {
        Self(ConstantEstimate { name, value, sd, stated, prior_sd })
    }
}

/// The constants by name.
pub fn by_name<'py>(py: Python<'py>, constants: &[ConstantEstimate]) -> PyResult<Bound<'py, PyDict>> {
    let by_name = PyDict::new(py);
    for constant in constants {
        by_name.set_item(&constant.name, ConstantData(constant.clone()))?;
    }
    Ok(by_name)
}

/// As text, to be pickled.
pub fn text(calibration: &CalibrationEstimate) -> PyResult<String> {
    serde_json::to_string(calibration).map_err(internal)
}

/// The same, read back.
pub fn of_text(text: &str) -> PyResult<CalibrationEstimate> {
    serde_json::from_str(text).map_err(internal)
}

fn internal(error: serde_json::Error) -> PyErr {
    InternalError::new_err(format!("a calibration: {error}"))
}

/// What a summary says of it. It does not say what scales and surface offsets have in common, which are taken as those of a rig without
/// errors, nor how the constants are correlated.
pub fn of_summary(summary: &Summary) -> Option<CalibrationEstimate> {
    if summary.calibration.is_empty() {
        return None;
    }
    let told = |name: &str| summary.calibration.get(name).map_or(0.0, |constant| constant.value);
    let (scale_ratio, surface_difference_m) = (told("scale_ratio"), told("surface_difference_m"));
    let mut calibration = Calibration::default();
    calibration.zero_m = [told("s1_zero_m"), told("s2_zero_m")];
    calibration.scale = [1.0 + 0.5 * scale_ratio, 1.0 - 0.5 * scale_ratio];
    calibration.angle_zero_rad = [told("phi1_zero_rad"), told("phi2_zero_rad")];
    calibration.surface_m = [0.5 * surface_difference_m, -0.5 * surface_difference_m];
    calibration.clock_offset_s = told("clock_offset_s");
    let constant = |(name, told): (&String, &ConstantSummary)| {
        let &ConstantSummary { value, sd, stated, prior_sd } = told;
        ConstantEstimate { name: name.clone(), value, sd, stated, prior_sd }
    };
    let constants: Vec<ConstantEstimate> = summary.calibration.iter().map(constant).collect();
    let row = |(index, constant): (usize, &ConstantEstimate)| {
        let mut row = vec![0.0; constants.len()];
        row[index] = constant.sd.powi(2);
        row
    };
    let covariance = constants.iter().enumerate().map(row).collect();
    let (size_sd, offset_sd_m) = (summary.size_sd, summary.offset_sd_m);
    Some(CalibrationEstimate { calibration, constants, covariance, size_sd, offset_sd_m })
}

/// The open constants in the units of a person: name, and value with standard deviation.
pub fn told(calibration: &CalibrationEstimate) -> Vec<(String, String)> {
    let open = calibration.constants.iter().filter(|constant| constant.prior_sd > 0.0);
    open.map(|constant| {
        let (name, factor, unit) = shown(&constant.name);
        let value = format!("{:.3} &plusmn; {:.3} {unit}", factor * constant.value, factor * constant.sd);
        (name, value)
    })
    .collect()
}

/// How a constant is shown to a person: its name, and the factor to its unit.
pub fn shown(name: &str) -> (String, f64, &'static str) {
    let (factor, unit) = CalibrationConstant::named(name).map_or((1.0, ""), |about| (about.units_per_si, about.unit));
    let stem = ["_rad", "_m", "_s"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name);
    (stem.replace('_', " "), factor, if unit == "deg" { "°" } else { unit })
}
