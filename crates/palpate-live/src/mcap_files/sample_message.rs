//! A sample as a JSON message: the columns of a palm log, `null` where there is no value.

use palpate::Sample;
use palpate::palms::PalmPair;
use serde::{Deserialize, Serialize};

/// Topic of the samples.
pub(crate) const TOPIC: &str = "/palpate/sample";
/// Name of the metadata record with what stands in the comments of a CSV log.
pub(crate) const METADATA: &str = "palpate";

/// What stands in the comments of a CSV log.
pub(crate) fn metadata_record(metadata: &[(String, String)]) -> mcap::records::Metadata {
    mcap::records::Metadata { name: METADATA.to_owned(), metadata: metadata.iter().cloned().collect() }
}

/// The fields of the message.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleMessage {
    time_s: f64,
    phi1_rad: f64,
    phi2_rad: f64,
    s1_m: Option<f64>,
    s2_m: Option<f64>,
    #[serde(default)]
    base1_x_m: f64,
    #[serde(default)]
    base1_y_m: f64,
    #[serde(default)]
    base2_x_m: f64,
    #[serde(default)]
    base2_y_m: f64,
    s1_sd_m: Option<f64>,
    s2_sd_m: Option<f64>,
    force1_n: Option<f64>,
    force2_n: Option<f64>,
}

impl From<&Sample> for SampleMessage {
    fn from(sample: &Sample) -> Self {
        let PalmPair { phi1_rad, phi2_rad, base1_m: [base1_x_m, base1_y_m], base2_m: [base2_x_m, base2_y_m] } =
            sample.palms;
        let Sample { time_s, s1_m, s2_m, s1_sd_m, s2_sd_m, force1_n, force2_n, .. } = *sample;
        Self {
            time_s,
            phi1_rad,
            phi2_rad,
            s1_m,
            s2_m,
            base1_x_m,
            base1_y_m,
            base2_x_m,
            base2_y_m,
            s1_sd_m,
            s2_sd_m,
            force1_n,
            force2_n,
        }
    }
}

impl From<SampleMessage> for Sample {
    fn from(message: SampleMessage) -> Self {
        let SampleMessage { time_s, phi1_rad, phi2_rad, s1_m, s2_m, s1_sd_m, s2_sd_m, force1_n, force2_n, .. } =
            message;
        let palms = PalmPair {
            phi1_rad,
            phi2_rad,
            base1_m: [message.base1_x_m, message.base1_y_m],
            base2_m: [message.base2_x_m, message.base2_y_m],
        };
        Self { time_s, palms, s1_m, s2_m, s1_sd_m, s2_sd_m, force1_n, force2_n }
    }
}

/// The schema, for programs that show such files.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigs::RigSample;

    #[test]
    fn samples_come_back_from_their_messages_to_the_bit() {
        let palms = PalmPair { base2_m: [0.1, -0.2], ..PalmPair::hinged(1.0 / 3.0, 0.1 + 0.2) };
        let sample = Sample { s2_m: None, force1_n: Some(1e-300), ..Sample::new(1e9 + 1.0 / 7.0, palms, 0.03, 0.0) };
        let json = serde_json::to_vec(&SampleMessage::from(&sample)).expect("a message");
        assert_eq!(serde_json::from_slice::<SampleMessage>(&json).map(Sample::from).ok(), Some(sample));
    }

    #[test]
    fn the_schema_names_every_field() {
        let schema: serde_json::Value = serde_json::from_str(&Sample::schema()).expect("JSON");
        let sample = Sample::new(0.0, PalmPair::hinged(1.0, 1.0), 0.0, 0.0);
        let message = serde_json::to_value(SampleMessage::from(&sample)).expect("JSON");
        let fields = message.as_object().expect("an object");
        assert_eq!(schema["properties"].as_object().expect("an object").len(), fields.len());
        assert!(fields.keys().all(|name| schema["properties"][name].is_object()));
    }
}
