//! `compare`: how far a result is from the truth.

use std::sync::Arc;

use palpate::compare::TruthError;
use pyo3::prelude::*;

use crate::estimate::result::ResultData;
use crate::interop::errors::OrRaise;
use crate::interop::pickled::{self, Pickled};
use crate::interop::work;
use crate::measured::truth::TrueData;

/// Errors of a result, after the best rotation.
#[pyclass(frozen, eq, module = "palpate", name = "TruthError")]
#[derive(Clone, PartialEq)]
pub struct Errors(pub TruthError);

#[pymethods]
impl Errors {
    /// float: RMS error of r over the felt outline, metres.
    #[getter]
    fn rms_r_m(&self) -> f64 {
        self.0.rms_r_m
    }

    /// float: the same with a translation taken out as well, the error of the form alone, metres.
    #[getter]
    fn rms_form_m(&self) -> f64 {
        self.0.rms_form_m
    }

    /// float: Hausdorff distance of the felt boundary, metres.
    #[getter]
    fn hausdorff_m(&self) -> f64 {
        self.0.hausdorff_m
    }

    /// float: RMS error of psi over all samples after the best offset, radians.
    #[getter]
    fn rms_psi_rad(&self) -> f64 {
        self.0.rms_psi_rad
    }

    /// float: RMS distance of the centre of mass over all samples, metres.
    #[getter]
    fn rms_com_m(&self) -> f64 {
        self.0.rms_com_m
    }

    fn __repr__(&self) -> String {
        format!(
            "<TruthError: r {:.3e} m (form alone {:.3e} m), psi {:.3e} rad, centre of mass {:.3e} m>",
            self.0.rms_r_m, self.0.rms_form_m, self.0.rms_psi_rad, self.0.rms_com_m
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let TruthError { rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m } = self.0;
        let arguments = (rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(rms_r_m: f64, rms_form_m: f64, hausdorff_m: f64, rms_psi_rad: f64, rms_com_m: f64) -> Self {
        Self(TruthError { rms_r_m, rms_form_m, hausdorff_m, rms_psi_rad, rms_com_m })
    }
}

/// How far a result is from the truth.
///
/// Parameters
/// ----------
/// result : Result
///     What was reconstructed.
/// truth : Truth
///     What is true, a pose for each sample of the log.
///
/// Returns
/// -------
/// TruthError
///     The errors.
///
/// Raises
/// ------
/// CompareError
///     If the two do not belong together, or one of them is empty.
#[pyfunction]
pub fn compare(py: Python<'_>, result: &ResultData, truth: &TrueData) -> PyResult<Errors> {
    let (found, truth) = (Arc::clone(&result.found), truth.truth.clone());
    let errors = work::run(py, None, None, move |_| palpate::compare::compare(&found, &truth))?;
    errors.or_raise().map(Errors)
}
