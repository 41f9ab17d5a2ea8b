//! Columns of numbers between Rust and numpy. A vector that goes out becomes the array's memory, an array of `float64` that
//! comes in is read where it is; anything else that numpy understands is converted once.

use numpy::ndarray::Array2;
use numpy::{AllowTypeChange, IntoPyArray, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayLikeDyn};
use numpy::{Element, PyArrayMethods};
use palpate::palms::GeneralizedContactSupport;
use pyo3::prelude::*;

use crate::interop::errors;

/// A column that came in.
pub type Column<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;
/// A table that came in.
pub type Table<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;
/// A number or an array of any shape that came in.
pub type Numbers<'py> = PyArrayLikeDyn<'py, f64, AllowTypeChange>;

/// A column that goes out, read-only: it may be shared by many.
pub fn column<T: Element>(py: Python<'_>, values: Vec<T>) -> Py<PyArray1<T>> {
    let array = values.into_pyarray(py);
    array.readwrite().make_nonwriteable();
    array.unbind()
}

/// A column of numbers that may be missing; these become NaN.
pub fn sparse_column(py: Python<'_>, values: impl Iterator<Item = Option<f64>>) -> Py<PyArray1<f64>> {
    column(py, values.map(|value| value.unwrap_or(f64::NAN)).collect())
}

/// A read-only table of rows with `N` numbers each.
pub fn table<const N: usize>(py: Python<'_>, rows: &[[f64; N]]) -> Py<PyArray2<f64>> {
    let array = Array2::from_shape_fn((rows.len(), N), |(row, column)| rows[row][column]).into_pyarray(py);
    array.readwrite().make_nonwriteable();
    array.unbind()
}

/// The rows of a table that came in, which must have `N` columns; `what` is its name for the message.
pub fn rows<const N: usize>(what: &str, table: &Table) -> PyResult<Vec<[f64; N]>> {
    let table = table.as_array();
    if table.ncols() != N {
        let (rows, columns) = table.dim();
        return Err(errors::input(format!("{what} must have the shape (n, {N}), not ({rows}, {columns})")));
    }
    Ok(table.rows().into_iter().map(|row| std::array::from_fn(|column| row[column])).collect())
}

/// The numbers of a column that came in.
pub fn values(column: &Column) -> Vec<f64> {
    column.as_array().to_vec()
}

/// Columns that belong together must be of one length.
pub fn same_length(columns: &[(&str, usize)]) -> PyResult<()> {
    let Some((first, length)) = columns.first() else { return Ok(()) };
    match columns.iter().find(|(_, other)| other != length) {
        None => Ok(()),
        Some((name, other)) => Err(errors::input(format!(
            "{first} and {name} differ in length ({length} against {other}); give one value for each sample"
        ))),
    }
}

/// `function` of every number; a float for a float, an array for an array.
pub fn mapped<'py>(
    py: Python<'py>,
    numbers: &Numbers<'py>,
    function: impl FnMut(f64) -> f64,
) -> PyResult<Bound<'py, PyAny>> {
    let result = numbers.as_array().mapv(function);
    if result.ndim() == 0 {
        let only = result.first().copied().unwrap_or(f64::NAN);
        return Ok(only.into_pyobject(py)?.into_any());
    }
    Ok(result.into_pyarray(py).into_any())
}

/// The generalised contact support functions in the order of the paper: r1, d1, r2 and d2.
pub fn four(support: GeneralizedContactSupport) -> (f64, f64, f64, f64) {
    (support.r1, support.d1, support.r2, support.d2)
}
