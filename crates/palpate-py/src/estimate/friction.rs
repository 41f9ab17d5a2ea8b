//! Coefficients of friction of a result, as Python and its pickles have them.

use palpate::reconstruct::FrictionEstimate;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The coefficients of both palms with their standard deviations.
pub fn by_name<'py>(py: Python<'py>, friction: &FrictionEstimate) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (palm, name) in ["mu1", "mu2"].into_iter().enumerate() {
        dict.set_item(name, friction.coefficients[palm])?;
        dict.set_item(format!("{name}_sd"), friction.coefficient_sds[palm])?;
    }
    Ok(dict)
}

/// All of it in numbers.
pub fn row_of(friction: &FrictionEstimate) -> Vec<f64> {
    let &FrictionEstimate { coefficients, coefficient_sds, center_m, center_sd_m, misfit, slides, rolls } = friction;
    let counts = [slides, rolls[0], rolls[1]].map(|count| count as f64);
    [&coefficients[..], &coefficient_sds, &center_m, &center_sd_m, &[misfit], &counts].concat()
}

/// What these numbers were.
pub fn of_row(row: &[f64]) -> Option<FrictionEstimate> {
    let &[first, second, first_sd, second_sd, x, y, x_sd, y_sd, misfit, slides, on1, on2] = row else { return None };
    Some(FrictionEstimate {
        coefficients: [first, second],
        coefficient_sds: [first_sd, second_sd],
        center_m: [x, y],
        center_sd_m: [x_sd, y_sd],
        misfit,
        slides: slides as usize,
        rolls: [on1 as usize, on2 as usize],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_says_all_of_it() {
        let friction = FrictionEstimate {
            coefficients: [0.1, 0.2],
            coefficient_sds: [0.01, 0.02],
            center_m: [1e-3, 2e-3],
            center_sd_m: [1e-4, 2e-4],
            misfit: 0.9,
            slides: 12,
            rolls: [3, 4],
        };
        assert_eq!(of_row(&row_of(&friction)), Some(friction));
        assert_eq!(of_row(&[0.1]), None);
    }
}
