//! The errors of both methods on all trials: as a table to read, and as one to compute with.

use palpate::compare::compare;
use palpate::reconstruct::diagnostics;

use crate::html::escape;
use crate::paper::input::{Method, PaperInput, Trial};

const CSV_HEADER: &str = "log,method,rms_r_m,hausdorff_m,rms_psi_rad,rms_com_m,rms_contact_vector_m,certified";

/// Errors of a method on a trial, in SI units; not finite where there is none.
struct Errors {
    rms_r_m: f64,
    hausdorff_m: f64,
    rms_psi_rad: f64,
    rms_com_m: f64,
    rms_contact_vector_m: f64,
}

impl Errors {
    fn of(trial: &Trial, method: Method) -> Self {
        let found = trial.found(method);
        let squares: Vec<f64> = diagnostics(trial.log, found)
            .iter()
            .filter_map(|sample| sample.contact_vector_error_m)
            .map(|error| error * error)
            .collect();
        let rms_contact_vector_m = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        match compare(found, trial.truth) {
            Ok(errors) => Self {
                rms_r_m: errors.rms_r_m,
                hausdorff_m: errors.hausdorff_m,
                rms_psi_rad: errors.rms_psi_rad,
                rms_com_m: errors.rms_com_m,
                rms_contact_vector_m,
            },
            Err(_) => Self {
                rms_r_m: f64::NAN,
                hausdorff_m: f64::NAN,
                rms_psi_rad: f64::NAN,
                rms_com_m: f64::NAN,
                rms_contact_vector_m,
            },
        }
    }
}

fn rows<'a>(input: &'a PaperInput<'a>) -> impl Iterator<Item = (&'a Trial<'a>, Method, Errors, &'static str)> {
    input.trials().into_iter().flat_map(|trial| Method::BOTH.map(|method| (trial, method))).map(|(trial, method)| {
        let certified = if trial.found(method).is_certified() { "yes" } else { "no" };
        (trial, method, Errors::of(trial, method), certified)
    })
}

/// The table as HTML.
pub(in crate::paper) fn table(input: &PaperInput) -> String {
    let mut text = String::from(
        "<table>\n<thead><tr><th>log</th><th>method</th><th>RMS shape error (mm)</th><th>Hausdorff distance (mm)</th>\
         <th>RMS orientation error (°)</th><th>RMS centre-of-mass error (mm)</th><th>RMS contact vector error (mm)</th><th>certified</th></tr></thead>\n<tbody>\n",
    );
    for (trial, method, errors, certified) in rows(input) {
        let numbers = [
            1e3 * errors.rms_r_m,
            1e3 * errors.hausdorff_m,
            errors.rms_psi_rad.to_degrees(),
            1e3 * errors.rms_com_m,
            1e3 * errors.rms_contact_vector_m,
        ];
        let cells: String = numbers.into_iter().map(|value| format!("<td>{}</td>", three_digits(value))).collect();
        text +=
            &format!("<tr><td>{}</td><td>{}</td>{cells}<td>{certified}</td></tr>\n", escape(trial.name), method.name());
    }
    text + "</tbody>\n</table>\n"
}

/// The table as CSV, in SI units: a row for each log and method; a cell without a number is empty.
pub fn errors_csv(input: &PaperInput) -> String {
    let mut text = format!("{CSV_HEADER}\n");
    for (trial, method, errors, certified) in rows(input) {
        let Errors { rms_r_m, hausdorff_m, rms_psi_rad, rms_com_m, rms_contact_vector_m } = errors;
        let number = |value: f64| if value.is_finite() { format!("{value:.4e}") } else { String::new() };
        let cells = [rms_r_m, hausdorff_m, rms_psi_rad, rms_com_m, rms_contact_vector_m].map(number).join(",");
        text += &format!("{},{},{cells},{certified}\n", trial.file, method.option());
    }
    text
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
