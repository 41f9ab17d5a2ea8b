//! What the comments above a log of strokes say of its rig and object.

use palpate::pivot::PivotRig;

use crate::csv::table::metadata;
use crate::read_error::{ReadError, ReadProblem};
use crate::rig::comment::KEY as RIG;
use crate::strokes::rig::parse_pivot_rig_comment;

/// Key of the period of small swings of the lifted object, seconds.
pub(super) const SWING_PERIOD: &str = "swing_period_s";

/// What comments say, as far as they do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrokesComments {
    /// `# rig: …`, as [`pivot_rig_comment`](crate::pivot_rig_comment) writes it.
    pub rig: Option<PivotRig>,
    /// `# swing_period_s: 0.41`: the period of small swings of the lifted object, seconds.
    pub swing_period_s: Option<f64>,
}

impl StrokesComments {
    /// Takes in a line above the header; `name` is what messages call the log. The first of several that say the same counts.
    ///
    /// # Errors
    /// It says something of these that cannot be understood.
    pub fn take_line(&mut self, name: &str, line: &str) -> Result<(), ReadError> {
        let said = line.trim_start().strip_prefix('#').and_then(metadata);
        said.map_or(Ok(()), |(key, value)| self.take(name, &key, &value))
    }

    /// The same of a comment `# key: value`, or of the metadata of a recording.
    ///
    /// # Errors
    /// As of [`take_line`](Self::take_line).
    pub fn take(&mut self, name: &str, key: &str, value: &str) -> Result<(), ReadError> {
        if key == SWING_PERIOD && self.swing_period_s.is_none() {
            let period_s = value.parse::<f64>().ok().filter(|period_s| *period_s > 0.0 && period_s.is_finite());
            let problem = || ReadProblem::SwingPeriod { text: crate::csv::text::quoted(value) };
            self.swing_period_s = Some(period_s.ok_or_else(|| ReadError::in_file(name, problem()))?);
        }
        if key == RIG && self.rig.is_none() {
            self.rig = Some(parse_pivot_rig_comment(name, value)?);
        }
        Ok(())
    }

    /// Of the metadata of a log.
    pub(super) fn of(name: &str, metadata: &[(String, String)]) -> Result<Self, ReadError> {
        let mut comments = Self::default();
        metadata.iter().try_for_each(|(key, value)| comments.take(name, key, value))?;
        Ok(comments)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_each_counts_and_what_is_none_is_refused() {
        let mut comments = StrokesComments::default();
        for line in ["# swing_period_s: 0.4", " # rig: exact", "# robot: left", "# swing_period_s: 0.5", "time_s"] {
            comments.take_line("log", line).expect("nothing wrong");
        }
        assert_eq!(comments, StrokesComments { rig: Some(PivotRig::default()), swing_period_s: Some(0.4) });
        for line in ["# swing_period_s: -1", "# rig: left hand"] {
            assert!(StrokesComments::default().take_line("log", line).is_err(), "{line}");
        }
    }
}
