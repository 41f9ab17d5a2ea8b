//! The table of errors: both methods on all trials.

use palpate::compare::compare;
use palpate::reconstruct::diagnostics;

use crate::html::escape;
use crate::paper::input::{Method, PaperInput, Trial};

/// The table as HTML.
pub(in crate::paper) fn table(input: &PaperInput) -> String {
    let mut text = String::from(
        "<table>\n<thead><tr><th>log</th><th>method</th><th>RMS shape error (mm)</th><th>Hausdorff distance (mm)</th>\
         <th>RMS orientation error (°)</th><th>RMS centre-of-mass error (mm)</th><th>RMS contact vector error (mm)</th><th>certified</th></tr></thead>\n<tbody>\n",
    );
    for trial in [&input.palms, &input.fingers, &input.experiment] {
        for method in Method::BOTH {
            text += &row(trial, method);
        }
    }
    text + "</tbody>\n</table>\n"
}

fn row(trial: &Trial, method: Method) -> String {
    let found = trial.found(method);
    let mut numbers = match compare(found, trial.truth) {
        Ok(errors) => vec![
            1e3 * errors.rms_r_m,
            1e3 * errors.hausdorff_m,
            errors.rms_psi_rad.to_degrees(),
            1e3 * errors.rms_com_m,
        ],
        Err(_) => vec![f64::NAN; 4],
    };
    let squares: Vec<f64> = diagnostics(trial.log, found)
        .iter()
        .filter_map(|sample| sample.contact_vector_error_m)
        .map(|error| error * error)
        .collect();
    numbers.push(1e3 * (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt());
    let cells: String = numbers.into_iter().map(|value| format!("<td>{}</td>", three_digits(value))).collect();
    let certified = if found.is_certified() { "yes" } else { "no" };
    format!("<tr><td>{}</td><td>{}</td>{cells}<td>{certified}</td></tr>\n", escape(trial.name), method.name())
}

/// Three significant digits, at most five decimals; a dash where there is no number.
fn three_digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    let decimals = if magnitude.is_finite() { (2.0 - magnitude).clamp(0.0, 5.0) } else { 0.0 };
    format!("{value:.0$}", decimals as usize)
}
