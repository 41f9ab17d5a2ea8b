//! Fewer samples for the search: readings evenly spread over each segment say where it belongs, and the others follow.

use std::ops::Range;

/// Samples of a segment that the search uses, at most.
const PER_SEGMENT: usize = 40;

/// Some of the samples of each segment.
pub(super) struct Thinning {
    /// Numbers of the samples that stay.
    pub kept: Vec<usize>,
    /// The segments among those.
    pub ranges: Vec<Range<usize>>,
}

impl Thinning {
    /// Of segments; first and last sample of each stay.
    pub fn new(segments: &[Range<usize>]) -> Self {
        let (mut kept, mut ranges) = (Vec::new(), Vec::new());
        for range in segments {
            let begin = kept.len();
            let last = range.len().saturating_sub(1);
            let count = range.len().min(PER_SEGMENT);
            kept.extend((0..count).map(|place| range.start + place * last / (count - 1).max(1)));
            ranges.push(begin..kept.len());
        }
        Self { kept, ranges }
    }

    /// Values of the samples that stay.
    pub fn of<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.kept.iter().map(|&index| values[index]).collect()
    }

    /// Values of all samples of the segments, moved by what those that stay were moved by, in between linearly.
    pub fn spread(&self, values: &[f64], moved: &[f64]) -> Vec<f64> {
        let mut all = values.to_vec();
        for range in &self.ranges {
            let change: Vec<f64> = range.clone().map(|place| moved[place] - values[self.kept[place]]).collect();
            for (place, pair) in change.windows(2).enumerate() {
                let (from, to) = (self.kept[range.start + place], self.kept[range.start + place + 1]);
                for index in from..=to {
                    let share = (index - from) as f64 / (to - from).max(1) as f64;
                    all[index] = values[index] + pair[0] + share * (pair[1] - pair[0]);
                }
            }
            if let [only] = change[..] {
                all[self.kept[range.start]] += only;
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_between_follows() {
        let thinning = Thinning::new(&[0..100, 100..110]);
        assert_eq!(thinning.ranges, [0..PER_SEGMENT, PER_SEGMENT..PER_SEGMENT + 10]);
        assert!([0, 99, 100, 109].iter().all(|index| thinning.kept.contains(index)));
        let values: Vec<f64> = (0..110).map(f64::from).collect();
        let moved: Vec<f64> = thinning.of(&values).iter().map(|value| 2.0 * value + 1.0).collect();
        let all = thinning.spread(&values, &moved);
        assert!(all.iter().zip(&values).all(|(all, value)| (all - 2.0 * value - 1.0).abs() < 1e-9));
    }
}
