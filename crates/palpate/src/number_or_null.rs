//! Numbers in text formats that have no NaN, such as JSON: for `#[serde(with = "palpate::number_or_null")]`.
//!
//! There a number that is not finite is written as null, and null is read as NaN. Binary formats hold every number as it is.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes a number; null where it is not finite and the format is for people to read.
///
/// # Errors
/// Those of the format.
pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() {
        value.is_finite().then_some(*value).serialize(serializer)
    } else {
        value.serialize(serializer)
    }
}

/// Reads a number; null is NaN.
///
/// # Errors
/// Those of the format, and what is neither a number nor null.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    if deserializer.is_human_readable() {
        Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
    } else {
        f64::deserialize(deserializer)
    }
}
