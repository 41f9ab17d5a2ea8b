//! What did not become a sample, counted by cause.

use std::fmt;
use std::ops::AddAssign;

/// Readings that were left out, and what else befell a source, since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Lines that failed their check, were cut off or could not be understood; messages likewise.
    pub faulty: u64,
    /// Lines or messages beyond the longest accepted.
    pub too_long: u64,
    /// Lines that passed their check, but stood alone among faulty ones.
    pub unconfirmed: u64,
    /// Samples with values that no rig has.
    pub implausible: u64,
    /// Samples with the time of the one before.
    pub doubled: u64,
    /// Samples older than the one before.
    pub late: u64,
    /// Tactile readings without palm angles close enough in time.
    pub without_angles: u64,
    /// Samples that came faster than they were taken, and the oldest of which were dropped.
    pub overflowed: u64,
    /// Times that a clock was set back, or that a board began to count anew.
    pub clock_steps: u64,
    /// Times that the source was gone, or that it said to have lost readings.
    pub gaps: u64,
}

impl Losses {
    /// Each count with what it counts, one and several.
    fn counts(&self) -> [(u64, &'static str, &'static str); 10] {
        [
            (self.faulty, "faulty line or message", "faulty lines or messages"),
            (self.too_long, "overlong line or message", "overlong lines or messages"),
            (self.unconfirmed, "line alone among faulty ones", "lines alone among faulty ones"),
            (self.implausible, "implausible sample", "implausible samples"),
            (self.doubled, "doubled sample", "doubled samples"),
            (self.late, "late sample", "late samples"),
            (self.without_angles, "reading without palm angles", "readings without palm angles"),
            (self.overflowed, "sample too fast to be taken", "samples too fast to be taken"),
            (self.clock_steps, "step of a clock", "steps of a clock"),
            (self.gaps, "interruption", "interruptions"),
        ]
    }

    /// Whether nothing was lost and nothing happened.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl AddAssign for Losses {
    fn add_assign(&mut self, other: Self) {
        self.faulty += other.faulty;
        self.too_long += other.too_long;
        self.unconfirmed += other.unconfirmed;
        self.implausible += other.implausible;
        self.doubled += other.doubled;
        self.late += other.late;
        self.without_angles += other.without_angles;
        self.overflowed += other.overflowed;
        self.clock_steps += other.clock_steps;
        self.gaps += other.gaps;
    }
}

impl fmt::Display for Losses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told: Vec<String> = self
            .counts()
            .into_iter()
            .filter(|(count, ..)| *count > 0)
            .map(|(count, one, several)| format!("{count} {}", if count == 1 { one } else { several }))
            .collect();
        f.write_str(if told.is_empty() { "nothing" } else { "" })?;
        f.write_str(&told.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_are_told_by_cause_and_added() {
        let mut losses = Losses { faulty: 1, gaps: 2, ..Losses::default() };
        assert_eq!(losses.to_string(), "1 faulty line or message, 2 interruptions");
        losses += losses;
        assert_eq!(losses, Losses { faulty: 2, gaps: 4, ..Losses::default() });
        assert_eq!(Losses::default().to_string(), "nothing");
        assert!(Losses::default().is_none() && !losses.is_none());
    }
}
