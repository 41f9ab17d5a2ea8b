//! Estimates as lines of JSON, one object each.

use palpate::live::Estimate;
use palpate::pivot::StrokesEstimate;
use serde_json::{Value, json};

use crate::terminal::Failure;

/// The line of an estimate. What is not known is null.
pub fn of(estimate: &Estimate) -> String {
    object(estimate).to_string()
}

/// The same as an object.
pub fn object(estimate: &Estimate) -> Value {
    let pose = estimate.pose.as_ref();
    json!({
        "time_s": estimate.time_s,
        "samples": estimate.samples,
        "psi_rad": pose.map(|pose| pose.psi_rad),
        "psi_sd_rad": pose.map(|pose| pose.psi_sd_rad),
        "com_x_m": pose.map(|pose| pose.com_x_m),
        "com_y_m": pose.map(|pose| pose.com_y_m),
        "com_sd_m": pose.map(|pose| pose.com_sd_m),
        "coverage": estimate.coverage,
        "certified": estimate.is_certified(),
        "com_certified": estimate.is_com_certified(),
        "reason": estimate.reason(),
        "r_sd_m": estimate.r_sd_m(),
        "hypotheses": estimate.hypotheses,
        "alternatives": estimate.alternatives,
        "searched": estimate.searched,
    })
}

/// The line of an estimate of strokes.
pub fn of_strokes(estimate: &StrokesEstimate) -> String {
    let line = json!({
        "time_s": estimate.time_s,
        "samples": estimate.samples,
        "theta_rad": estimate.theta_rad,
        "psi_rad": estimate.psi_rad,
        "psi_sd_rad": estimate.psi_sd_rad,
        "on_unfelt": estimate.is_on_unfelt,
        "coverage": estimate.coverage,
        "certified": estimate.is_certified(),
        "reason": estimate.reason(),
        "r_sd_m": estimate.r_sd_m,
        "alternatives": estimate.alternatives,
        "searched": estimate.searched,
    });
    line.to_string()
}

/// The last line: the summary of the result, as the text of its file.
pub fn last(summary: Result<String, serde_json::Error>) -> Result<String, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Other(format!("summary.json: {error}"));
    let text = summary.map_err(|error| failed(&error))?;
    let mut all: serde_json::Map<String, Value> = [("final".to_owned(), Value::Bool(true))].into_iter().collect();
    all.append(&mut serde_json::from_str(&text).map_err(|error| failed(&error))?);
    Ok(Value::Object(all).to_string())
}
