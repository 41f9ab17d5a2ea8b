//! A line of a pivoting grasp: `T,x,y,s*CC`.

use palpate::pivot::{PivotLog, PivotSample};

use crate::line_protocol::LinePacket;
use crate::line_protocol::fields::{Fields, PacketError, with_check, wrapped_us};

/// Arms move the pivot slower than this, metres per second: a hundred times as fast as objects are dragged over a pad.
const FASTEST_PIVOT_M_PER_S: f64 = 2.0;
/// And the readings of where it is err by less than this, metres.
const LARGEST_PIVOT_ERROR_M: f64 = 0.01;

/// What a line says, in the units of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StrokesPacket {
    /// Time in microseconds; 0 follows 2³² − 1.
    pub time_us: u32,
    /// Pivot, X and Y, micrometres.
    pub pivot_um: [i32; 2],
    /// Contact position along the pad, micrometres; `None` without contact.
    pub s_um: Option<i32>,
}

impl StrokesPacket {
    /// Reads a line without its line feed; a carriage return before that is allowed.
    ///
    /// ```
    /// use palpate_live::protocol::StrokesPacket;
    /// let packet = StrokesPacket { time_us: 1_000_000, pivot_um: [500_000, 31_000], s_um: None };
    /// let line = packet.to_line();
    /// assert_eq!(line, "1000000,500000,31000,*73\n");
    /// assert_eq!(StrokesPacket::parse(line.trim_end().as_bytes()), Ok(packet));
    /// ```
    ///
    /// # Errors
    /// The check fails, or the fields are not as the protocol has them.
    pub fn parse(line: &[u8]) -> Result<Self, PacketError> {
        let fields = Fields::checked(line)?;
        fields.require("4", |count| count == 4)?;
        let time_us = fields.unsigned(0)?;
        Ok(Self { time_us, pivot_um: [fields.signed(1)?, fields.signed(2)?], s_um: fields.or_empty(3)? })
    }

    /// The line that says so, with its check and line feed.
    pub fn to_line(&self) -> String {
        let (time_us, [x_um, y_um]) = (self.time_us, self.pivot_um);
        let s_um = self.s_um.map_or_else(String::new, |s_um| s_um.to_string());
        with_check(format!("{time_us},{x_um},{y_um},{s_um}"))
    }

    /// The packet of a sample, rounded; times before 0 and beyond 2³² microseconds wrap.
    pub fn of_sample(sample: &PivotSample) -> Self {
        let rounded = |length_m: f64| (1e6 * length_m).round() as i32;
        Self {
            time_us: wrapped_us(sample.time_s),
            pivot_um: [sample.pivot_x_m, sample.pivot_y_m].map(rounded),
            s_um: sample.s_m.map(rounded),
        }
    }
}

impl LinePacket for StrokesPacket {
    type Sample = PivotSample;

    /// Lines are short, so that more of them come through whole beside one that passes by chance: of a million with one digit in ten changed, 327 wrong
    /// samples get through with three, one with four, none with five (`tests/noisy_line.rs`).
    const CONFIRMED: usize = 5;

    fn parse(line: &[u8]) -> Result<Self, PacketError> {
        Self::parse(line)
    }

    fn time_us(&self) -> u32 {
        self.time_us
    }

    fn sample(&self, time_s: f64) -> PivotSample {
        let [pivot_x_m, pivot_y_m] = self.pivot_um.map(|um| f64::from(um) / 1e6);
        PivotSample { time_s, pivot_x_m, pivot_y_m, s_m: self.s_um.map(|um| f64::from(um) / 1e6) }
    }

    /// Whether an arm gets from one line to the other.
    fn can_follow(&self, before: &Self, step_s: f64) -> bool {
        let moved_m = |axis: usize| (f64::from(self.pivot_um[axis]) - f64::from(before.pivot_um[axis])) / 1e6;
        moved_m(0).hypot(moved_m(1)) <= FASTEST_PIVOT_M_PER_S * step_s + LARGEST_PIVOT_ERROR_M
    }
}

/// The lines that a board would send of strokes.
pub fn lines_of_strokes(log: &PivotLog) -> impl Iterator<Item = String> {
    log.samples.iter().map(|sample| StrokesPacket::of_sample(sample).to_line())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_protocol::fields::LONGEST_LINE;
    use proptest::prelude::*;

    #[test]
    fn a_line_of_palms_is_none_and_a_pivot_does_not_leap() {
        let line = with_check("1,2,3,4,5".to_owned());
        let wrong = PacketError::Fields { fields: 5, needed: "4" };
        assert_eq!(StrokesPacket::parse(line.trim_end().as_bytes()), Err(wrong));
        let at = |x_um| StrokesPacket { time_us: 0, pivot_um: [x_um, 0], s_um: None };
        // In 10 ms 20 mm and the error of a reading, and a little more than that.
        assert!(at(29_999).can_follow(&at(0), 0.01) && !at(30_001).can_follow(&at(0), 0.01));
        assert!(!at(i32::MAX).can_follow(&at(i32::MIN), 1.0));
    }

    proptest! {
        #[test]
        fn packets_come_back_from_their_lines(time_us in any::<u32>(), pivot_um in any::<[i32; 2]>(), s_um in any::<Option<i32>>()) {
            let packet = StrokesPacket { time_us, pivot_um, s_um };
            let line = packet.to_line();
            prop_assert!(line.len() <= LONGEST_LINE);
            prop_assert_eq!(StrokesPacket::parse(line.trim_end_matches('\n').as_bytes()), Ok(packet));
        }
    }
}
