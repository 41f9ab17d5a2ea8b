//! How objects are pickled: as a call that makes them anew.

use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// What `__reduce__` returns: what to call, and its arguments.
pub type Pickled<'py> = PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)>;

/// A call of the class `T`, as people make one.
pub fn by_class<'py, T: PyTypeInfo>(
    py: Python<'py>,
    arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
) -> Pickled<'py> {
    Ok((py.get_type::<T>().into_any(), arguments.into_pyobject(py).map_err(Into::into)?))
}

/// A call of a static method of the class `T`.
pub fn by_method<'py, T: PyTypeInfo>(
    py: Python<'py>,
    name: &str,
    arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error: Into<PyErr>>,
) -> Pickled<'py> {
    Ok((py.get_type::<T>().getattr(name)?, arguments.into_pyobject(py).map_err(Into::into)?))
}
