//! Fewer samples for the search: readings evenly spread over each segment say where it belongs, and the others follow.

use std::ops::Range;

use crate::math::angle::wrapped;

/// Samples of a segment that the search uses, at most.
const PER_SEGMENT: usize = 40;

/// Two samples part where one is moved by so much more than the other, radians: a leap lies between them.
const PARTS_RAD: f64 = 0.5;

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

    /// Angles of all samples of the segments, moved by what those that stay were moved by: in between linearly, or where two of these part, up to the longest
    /// step between them as the first, and beyond as the second.
    pub fn spread(&self, theta_rad: &[f64], moved_rad: &[f64]) -> Vec<f64> {
        let mut all = theta_rad.to_vec();
        for range in &self.ranges {
            let mut last = None;
            for place in range.clone() {
                let index = self.kept[place];
                let by = moved_rad[place] - theta_rad[index];
                let Some((from, before)) = last else {
                    all[index] += by;
                    last = Some((index, by));
                    continue;
                };
                // Whole turns are none.
                let parts = wrapped(by - before);
                let step = |index: usize| (theta_rad[index] - theta_rad[index - 1]).abs();
                let longest = (from + 1..=index).max_by(|a, b| step(*a).total_cmp(&step(*b))).unwrap_or(index);
                for between in from + 1..=index {
                    let share = if parts.abs() < PARTS_RAD {
                        (between - from) as f64 / (index - from) as f64
                    } else {
                        f64::from(u8::from(between >= longest))
                    };
                    all[between] = theta_rad[between] + before + share * parts;
                }
                last = Some((index, before + parts));
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn what_is_between_follows() {
        let thinning = Thinning::new(&[0..100, 100..110]);
        assert_eq!(thinning.ranges, [0..PER_SEGMENT, PER_SEGMENT..PER_SEGMENT + 10]);
        assert!([0, 99, 100, 109].iter().all(|index| thinning.kept.contains(index)));
        let values: Vec<f64> = (0..110).map(|index| 0.1 * f64::from(index)).collect();
        let moved: Vec<f64> = thinning.of(&values).iter().map(|value| 2.0 * value + 1.0).collect();
        let all = thinning.spread(&values, &moved);
        assert!(all.iter().zip(&values).all(|(all, value)| (all - 2.0 * value - 1.0).abs() < 1e-9));
    }

    /// What lies beyond a leap between two samples that stay is turned with the second, a whole turn aside.
    #[test]
    fn what_parts_does_so_at_the_leap() {
        let segment = 0..118;
        let thinning = Thinning::new(std::slice::from_ref(&segment));
        let leap = thinning.kept[20] + 2;
        assert!(leap < thinning.kept[21]);
        let theta: Vec<f64> =
            (0..118).map(|index| 0.01 * index as f64 + if index < leap { 0.0 } else { 1.3 }).collect();
        for turns in [0.0, 1.0] {
            let by = |index: usize| if index < leap { 0.2 } else { -1.6 + turns * TAU };
            let moved: Vec<f64> = thinning.kept.iter().map(|&index| theta[index] + by(index)).collect();
            for (index, all) in thinning.spread(&theta, &moved).into_iter().enumerate() {
                let expected = theta[index] + if index < leap { 0.2 } else { -1.6 };
                assert!((all - expected).abs() < 1e-9, "{index}");
            }
        }
    }
}
