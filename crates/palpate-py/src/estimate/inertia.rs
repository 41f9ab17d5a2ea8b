//! The inertia of a result, as Python and its pickles have it.

use palpate::reconstruct::InertiaEstimate;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Names of its numbers in the order of [`row_of`].
const NAMES: [&str; 6] = [
    "gyration_radius_m",
    "gyration_radius_sd_m",
    "uniform_gyration_radius_m",
    "damping_per_s",
    "damping_sd_per_s",
    "static_balance_sd_m",
];

/// All of it by name.
pub fn by_name<'py>(py: Python<'py>, inertia: &InertiaEstimate) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, value) in NAMES.into_iter().zip(row_of(inertia)) {
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

/// All of it in numbers.
pub fn row_of(inertia: &InertiaEstimate) -> [f64; 6] {
    let &InertiaEstimate {
        gyration_radius_m,
        gyration_radius_sd_m,
        uniform_gyration_radius_m,
        damping_per_s,
        damping_sd_per_s,
        static_balance_sd_m,
    } = inertia;
    [
        gyration_radius_m,
        gyration_radius_sd_m,
        uniform_gyration_radius_m,
        damping_per_s,
        damping_sd_per_s,
        static_balance_sd_m,
    ]
}

/// What these numbers were.
pub fn of_row(row: [f64; 6]) -> InertiaEstimate {
    let [
        gyration_radius_m,
        gyration_radius_sd_m,
        uniform_gyration_radius_m,
        damping_per_s,
        damping_sd_per_s,
        static_balance_sd_m,
    ] = row;
    InertiaEstimate {
        gyration_radius_m,
        gyration_radius_sd_m,
        uniform_gyration_radius_m,
        damping_per_s,
        damping_sd_per_s,
        static_balance_sd_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_says_all_of_it() {
        let row = [0.024, 1e-5, 0.0241, 0.4, 0.01, 6e-4];
        assert_eq!(row_of(&of_row(row)), row);
    }
}
