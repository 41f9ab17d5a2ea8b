//! Whole numbers that count or seed: from 0 on.

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;

use crate::interop::errors;

/// A whole number from 0 to 2⁶⁴ − 1.
#[derive(Clone, Copy, Debug)]
pub struct Whole(pub u64);

impl Whole {
    /// As a count; numbers too large for one are as large as a count can be.
    pub fn count(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }

    /// As a small count; numbers too large for one are as large as it can be.
    pub fn small(self) -> u32 {
        u32::try_from(self.0).unwrap_or(u32::MAX)
    }
}

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        object.extract::<u64>().map(Self).map_err(|error| {
            if error.is_instance_of::<PyOverflowError>(object.py()) {
                errors::input(format!("{} is out of range; give a whole number from 0 to {}", &*object, u64::MAX))
            } else {
                error
            }
        })
    }
}
