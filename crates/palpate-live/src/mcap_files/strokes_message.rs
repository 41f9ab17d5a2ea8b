//! A sample of strokes as a JSON message: the columns of their log, `null` where there is no contact.

use palpate::pivot::PivotSample;
use serde::{Deserialize, Serialize};

/// The fields of the message.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrokesMessage {
    time_s: f64,
    pivot_x_m: f64,
    pivot_y_m: f64,
    s_m: Option<f64>,
}

impl From<&PivotSample> for StrokesMessage {
    fn from(sample: &PivotSample) -> Self {
        let PivotSample { time_s, pivot_x_m, pivot_y_m, s_m } = *sample;
        Self { time_s, pivot_x_m, pivot_y_m, s_m }
    }
}

impl From<StrokesMessage> for PivotSample {
    fn from(message: StrokesMessage) -> Self {
        let StrokesMessage { time_s, pivot_x_m, pivot_y_m, s_m } = message;
        Self { time_s, pivot_x_m, pivot_y_m, s_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigs::RigSample;

    #[test]
    fn samples_come_back_from_their_messages_to_the_bit_and_the_schema_names_every_field() {
        let sample = PivotSample { time_s: 1e9 + 1.0 / 7.0, pivot_x_m: 0.1 + 0.2, pivot_y_m: 1.0 / 3.0, s_m: None };
        let json = serde_json::to_value(StrokesMessage::from(&sample)).expect("a message");
        let schema: serde_json::Value = serde_json::from_str(&PivotSample::schema()).expect("JSON");
        let fields = json.as_object().expect("an object");
        assert_eq!(schema["properties"].as_object().expect("an object").len(), fields.len());
        assert!(fields.keys().all(|name| schema["properties"][name].is_object()));
        let text = json.to_string();
        assert_eq!(serde_json::from_str::<StrokesMessage>(&text).map(PivotSample::from).ok(), Some(sample));
    }
}
