//! A part of a log whose samples turn together against the rest: a range of them, or several with others between.

use crate::estimate::motion::SHORT_SEGMENT;
use std::ops::Range;

/// Ranges of samples, in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part(Vec<Range<usize>>);

impl From<Range<usize>> for Part {
    fn from(range: Range<usize>) -> Self {
        Self(std::iter::once(range).collect())
    }
}

impl Part {
    /// Of ranges in order; those that follow each other are one.
    pub fn of<'a>(ranges: impl Iterator<Item = &'a Range<usize>>) -> Self {
        let mut joined: Vec<Range<usize>> = Vec::new();
        for range in ranges {
            match joined.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => joined.push(range.clone()),
            }
        }
        Self(joined)
    }

    pub fn ranges(&self) -> &[Range<usize>] {
        &self.0
    }

    pub fn contains(&self, sample: usize) -> bool {
        self.0.iter().any(|range| range.contains(&sample))
    }

    /// Whether it has samples enough to have a rotation of its own, and so has what lies before it.
    pub fn can_turn(&self) -> bool {
        let samples: usize = self.0.iter().map(ExactSizeIterator::len).sum();
        samples >= SHORT_SEGMENT && self.0.first().is_some_and(|first| first.start >= SHORT_SEGMENT)
    }

    /// A motion with this part of it turned.
    pub fn turned(&self, psi: &[f64], omega: f64) -> Vec<f64> {
        let mut psi = psi.to_vec();
        self.0.iter().for_each(|range| psi[range.clone()].iter_mut().for_each(|psi| *psi += omega));
        psi
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_its_samples_turn() {
        let part = Part::of([2..3, 3..4, 6..7].iter());
        assert_eq!(part.ranges(), [2..4, 6..7]);
        assert_eq!(part.turned(&[0.0; 8], 0.5), [0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.5, 0.0]);
        assert!((0..8).all(|sample| part.contains(sample) == [2, 3, 6].contains(&sample)));
        assert_eq!(Part::of(std::iter::once(&(2..7))), Part::from(2..7));
    }

    #[test]
    fn a_part_turns_from_some_samples_on() {
        let can_turn = |start: usize, samples: usize| Part::from(start..start + samples).can_turn();
        assert!(can_turn(SHORT_SEGMENT, SHORT_SEGMENT));
        assert!(!can_turn(SHORT_SEGMENT - 1, SHORT_SEGMENT) && !can_turn(SHORT_SEGMENT, SHORT_SEGMENT - 1));
        assert!(!Part::of(std::iter::empty()).can_turn());
    }
}
