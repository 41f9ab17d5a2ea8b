//! `Doubt`: a reason why a result is not certified.

use palpate::reconstruct::Doubt;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value};

use crate::interop::errors::InternalError;
use crate::interop::pickled::{self, Pickled};

/// One reason why a result, or its centre of mass alone, is not certified.
///
/// Every kind has numbers of its own, whose names carry their unit. `docs/formats.md` lists them.
#[pyclass(frozen, eq, module = "palpate", name = "Doubt")]
#[derive(Clone, PartialEq)]
pub struct DoubtData(pub Doubt);

impl DoubtData {
    /// What it has in a file.
    fn fields(&self) -> PyResult<Map<String, Value>> {
        match serde_json::to_value(&self.0).map_err(internal)? {
            Value::Object(fields) => Ok(fields),
            other => Err(InternalError::new_err(format!("a doubt: {other}"))),
        }
    }
}

#[pymethods]
impl DoubtData {
    /// str: which kind of doubt, such as 'misfit', 'alternatives' or 'unbalanced'.
    #[getter]
    fn kind(&self) -> PyResult<String> {
        Ok(self.fields()?.get("kind").and_then(Value::as_str).unwrap_or_default().to_owned())
    }

    /// str: the doubt in one sentence.
    #[getter]
    fn text(&self) -> String {
        self.0.to_string()
    }

    /// str: where it comes from, 'input', 'rig', 'sensor', 'forces', 'felt', 'method' or 'unknown'.
    ///
    /// Doubts are in this order: what stands first spoils what stands after it.
    #[getter]
    fn cause(&self) -> PyResult<String> {
        let cause = serde_json::to_value(self.0.cause()).map_err(internal)?;
        Ok(cause.as_str().unwrap_or_default().to_owned())
    }

    /// str: what to do about it; empty where only words are known.
    #[getter]
    fn next_step(&self) -> String {
        self.0.next_step()
    }

    /// str: where the documentation says more of it, page and section.
    #[getter]
    fn docs(&self) -> String {
        self.0.docs()
    }

    /// dict: the numbers that raised it, by names with their unit, such as 'left_m'; empty where there are none.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (name, value) in self.fields()?.iter().filter(|(name, _)| !["kind", "text"].contains(&name.as_str())) {
            values.set_item(name, in_python(py, value)?)?;
        }
        Ok(values)
    }

    /// bool: whether it concerns the centre of mass alone; shape and motion may then be certified.
    #[getter]
    fn concerns_center_of_mass_only(&self) -> bool {
        self.0.concerns_center_of_mass_only()
    }

    fn __str__(&self) -> String {
        self.text()
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<Doubt {}: {}>", self.kind()?, self.0))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        pickled::by_method::<Self>(py, "_made", (serde_json::to_string(&self.0).map_err(internal)?,))
    }

    #[staticmethod]
    fn _made(json: &str) -> PyResult<Self> {
        serde_json::from_str(json).map(Self).map_err(internal)
    }
}

/// A number, a word or a yes or no. JSON has no NaN, but null.
fn in_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Bool(yes) => yes.into_bound_py_any(py),
        Value::String(word) => word.into_bound_py_any(py),
        Value::Number(number) => match number.as_u64() {
            Some(count) => count.into_bound_py_any(py),
            None => number.as_f64().unwrap_or(f64::NAN).into_bound_py_any(py),
        },
        _ => f64::NAN.into_bound_py_any(py),
    }
}

fn internal(error: serde_json::Error) -> PyErr {
    InternalError::new_err(format!("a doubt: {error}"))
}
