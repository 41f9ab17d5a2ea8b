//! Every error of the libraries as a Python exception, with the same words.

use palpate::calibrate::DiscError;
use palpate::compare::CompareError as RustCompareError;
use palpate::information::InformationError;
use palpate::palms::MotionError as RustMotionError;
use palpate::plan::PlanError;
use palpate::reconstruct::ReconstructError as RustReconstructError;
use palpate::shape::{ShapeError as RustShapeError, UnknownShape};
use palpate::simulate::SimulateError as RustSimulateError;
use palpate_io::{ReadError as RustReadError, RigError, WriteError as RustWriteError};
use palpate_sweep::{PlanError as SweepPlanError, SweepError as RustSweepError};
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(palpate._errors, InputError);
import_exception!(palpate._errors, ReadError);
import_exception!(palpate._errors, WriteError);
import_exception!(palpate._errors, ShapeError);
import_exception!(palpate._errors, MotionError);
import_exception!(palpate._errors, SimulateError);
import_exception!(palpate._errors, ReconstructError);
import_exception!(palpate._errors, CompareError);
import_exception!(palpate._errors, SweepError);
import_exception!(palpate._errors, InternalError);
import_exception!(palpate._errors, ReadWarning);

/// A Python warning for each note, told of the line that called palpate.
pub fn warn(py: Python<'_>, notes: &[String]) -> PyResult<()> {
    if notes.is_empty() {
        return Ok(());
    }
    let warn = py.import("warnings")?.getattr("warn")?;
    for note in notes {
        warn.call1((ReadWarning::new_err(note.clone()).into_value(py),))?;
    }
    Ok(())
}

/// An argument that cannot be used.
pub fn input(message: String) -> PyErr {
    InputError::new_err(message)
}

/// An error of a library as the exception that goes with it.
pub trait IntoException {
    /// The exception.
    fn into_exception(self) -> PyErr;
}

macro_rules! exceptions {
    ($($error:ty => $exception:ty),* $(,)?) => {$(
        impl IntoException for $error {
            fn into_exception(self) -> PyErr {
                <$exception>::new_err(self.to_string())
            }
        }
    )*};
}

exceptions! {
    RustShapeError => ShapeError,
    UnknownShape => ShapeError,
    RustMotionError => MotionError,
    PlanError => MotionError,
    InformationError => InputError,
    RustSimulateError => SimulateError,
    RustReconstructError => ReconstructError,
    RustCompareError => CompareError,
    RustWriteError => WriteError,
}

impl IntoException for RustReadError {
    fn into_exception(self) -> PyErr {
        ReadError::new_err((self.to_string(), self.file, self.line, self.column, self.problem.to_string()))
    }
}

/// The key of a rig file stands where a table has a column.
impl IntoException for RigError {
    fn into_exception(self) -> PyErr {
        ReadError::new_err((self.to_string(), self.file, self.line, self.key, self.problem.to_string()))
    }
}

/// What the command line has as an option is an argument here, and a rig need not be a file.
impl IntoException for DiscError {
    fn into_exception(self) -> PyErr {
        input(self.to_string().replace("--known-radius-mm", "known_radius_m").replace("the rig file", "the rig"))
    }
}

/// The key of a plan stands where a table has a column.
impl IntoException for SweepPlanError {
    fn into_exception(self) -> PyErr {
        ReadError::new_err((self.to_string(), self.file, self.line, self.key, self.problem.to_string()))
    }
}

impl IntoException for RustSweepError {
    fn into_exception(self) -> PyErr {
        match self {
            Self::Write(error) => error.into_exception(),
            _ => SweepError::new_err(self.to_string()),
        }
    }
}

/// `?` for the errors of the libraries.
pub trait OrRaise<T> {
    /// The value, or the exception that goes with the error.
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: IntoException> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(IntoException::into_exception)
    }
}
