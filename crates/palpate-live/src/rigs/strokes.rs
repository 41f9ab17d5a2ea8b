//! Samples of a pivoting grasp, as sources and recordings have them.

use std::path::Path;

use palpate::pivot::PivotSample;
use palpate_io::{FURTHEST_M, ReadError, ReadProblem, StrokesComments, StrokesRowReader};

use crate::error::SourceError;
use crate::join::Joined;
use crate::line_protocol::strokes_packet::StrokesPacket;
use crate::mcap_files::strokes_message::StrokesMessage;
use crate::rigs::{RigSample, json_schema};
use crate::source::Source;
use crate::source::address::Address;

/// Times beyond this are none, seconds: they are no finer than a millisecond in a number of 64 bits.
const LONGEST_TIME_S: f64 = 1e13;

impl RigSample for PivotSample {
    type Rig = StrokesComments;
    /// Strokes are written in one way.
    type Conventions = ();
    type Rows = StrokesRowReader;
    type Packet = StrokesPacket;
    type Message = StrokesMessage;

    const SCHEMA: &'static str = "palpate.PivotSample";

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn at(self, time_s: f64) -> Self {
        Self { time_s, ..self }
    }

    fn is_implausible(&self, &(): &()) -> bool {
        let lengths_m = [Some(self.pivot_x_m), Some(self.pivot_y_m), self.s_m];
        let is_length = |length_m: f64| length_m.abs() <= FURTHEST_M;
        !(self.time_s.abs() <= LONGEST_TIME_S && lengths_m.into_iter().flatten().all(is_length))
    }

    fn conventions(_: &StrokesComments) {}

    fn take_comment(
        name: &str,
        line: &str,
        is_stated: bool,
        rig: &mut Option<StrokesComments>,
    ) -> Result<(), SourceError> {
        let mut comments = rig.unwrap_or_default();
        match comments.take_line(name, line) {
            // Another rig was stated.
            Err(error) if is_stated && matches!(*error.problem, ReadProblem::RigComment { .. }) => return Ok(()),
            taken => taken?,
        }
        *rig = Some(comments);
        Ok(())
    }

    fn rows(name: &str, header: &str, line: usize, (): ()) -> Result<StrokesRowReader, ReadError> {
        StrokesRowReader::new(name, header, line)
    }

    fn row(rows: &StrokesRowReader, text: &str, line: usize) -> Result<Option<Self>, ReadError> {
        rows.sample(text, line)
    }

    fn csv_header(metadata: &[(String, String)]) -> String {
        palpate_io::strokes_csv_header(metadata)
    }

    fn push_csv_row(&self, text: &mut String) {
        palpate_io::push_strokes_row(text, self);
    }

    fn schema() -> String {
        json_schema(Self::SCHEMA, &["time_s", "pivot_x_m", "pivot_y_m"], &["s_m"])
    }

    fn of_joined(joined: &Joined) -> Self {
        let Joined { time_s, place: [pivot_x_m, pivot_y_m], position_m: [s_m, _], .. } = *joined;
        Self { time_s, pivot_x_m, pivot_y_m, s_m }
    }

    fn between(before: f64, after: f64, share: f64) -> f64 {
        before + (after - before) * share
    }

    fn open_devices(address: &Address) -> Result<Box<dyn Source<Self>>, SourceError> {
        let problem = "an arm is no input device; let the program that moves it print lines of strokes, or send them over a serial port";
        Err(SourceError::Address { address: address.to_string(), problem: problem.to_owned() })
    }

    fn simulated(path: &Path, plan: &str) -> Result<(Vec<Self>, f64, StrokesComments), SourceError> {
        crate::source::simulated::strokes::simulated(path, plan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_arm_and_no_pad_has_is_implausible() {
        let sample = |time_s, pivot_x_m, s_m| PivotSample { time_s, pivot_x_m, pivot_y_m: 0.03, s_m };
        assert!(!sample(LONGEST_TIME_S, FURTHEST_M, Some(-FURTHEST_M)).is_implausible(&()));
        assert!(!sample(0.0, 0.5, None).is_implausible(&()));
        for wrong in [
            sample(1.001 * LONGEST_TIME_S, 0.5, None),
            sample(f64::NAN, 0.5, None),
            sample(0.0, 1.001 * FURTHEST_M, None),
            sample(0.0, f64::NAN, None),
            sample(0.0, 0.5, Some(f64::INFINITY)),
        ] {
            assert!(wrong.is_implausible(&()), "{wrong:?}");
        }
    }
}
