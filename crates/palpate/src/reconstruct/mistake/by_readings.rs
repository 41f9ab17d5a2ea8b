//! Mistakes that the readings of a log show by themselves, before anything is searched: units, zeros for no contact, coarse digits, and
//! angles under which the palms hold nothing.

use std::f64::consts::PI;

use super::{MILLI, Mistake};
use crate::log::{Log, Sample};
use crate::math::statistics::median;

/// Palms that never open wider than this, radians, were meant to open by as many radians as this has degrees: π degrees.
const RADIANS_AS_DEGREES: f64 = PI * PI / 180.0;

/// Contacts of which none is further from the base of its palm than the first, metres, and contacts of which one is further than the second, are
/// in other units.
const LENGTHS_M: [f64; 2] = [1e-3, 10.0];

/// Positions of exactly 0 that are not by chance.
const FEWEST_ZEROS: usize = 3;

/// A contact that was further out than this share of the usual position does not come to the base of the palm within a sample.
const LEAP_SHARE: f64 = 0.2;

/// Steps from which on positions (metres) and angles (radians, half a degree) are rounded coarsely: no sensor is as coarse.
const COARSE_M: f64 = 0.5e-3;
const COARSE_RAD: f64 = 0.5 * PI / 180.0;

/// Share of the samples in which palms of the right angles hold an object: contacts of a log with friction may be beyond.
const HELD: f64 = 0.95;

/// Where palms would hold an object in fewer of the samples, no balance of what rests on them explains the others, however long one is looked for.
const HELD_SELDOM: f64 = 0.5;

/// How far a value may be from a multiple of the step that it is rounded to, as a share of the step.
const OFF_STEP: f64 = 1e-3;

impl Mistake {
    /// Readings in units that no palms have: angles up to [`RADIANS_AS_DEGREES`], and positions each side of [`LENGTHS_M`].
    pub(super) fn in_units(log: &Log) -> Option<Self> {
        if angles_that_look_like_radians_in_degrees(log)[1] {
            return Some(Self::RadiansAsDegrees);
        }
        let scales = scales(log);
        if scales.iter().any(|scale| *scale > 1.0) {
            return Some(Self::MetersAsMillimeters);
        }
        scales.iter().any(|scale| *scale < 1.0).then_some(Self::MillimetersAsMeters)
    }

    /// What the readings of a log show at once: units, and zeros where there was no contact.
    pub(super) fn by_readings(log: &Log) -> Option<Self> {
        Self::in_units(log).or_else(|| {
            let readings = zeros(log, |_, _| true);
            (readings >= FEWEST_ZEROS).then_some(Self::ZerosForNoContact { readings })
        })
    }

    /// Zeros from which a contact would have to leap away in one sample, whatever the object: nobody needs to look for one to know them.
    pub(super) fn leaps_to_zero(log: &Log) -> Option<Self> {
        let leaping = zeros(log, |before_m, usual_m| before_m > LEAP_SHARE * usual_m);
        (leaping >= FEWEST_ZEROS).then(|| Self::ZerosForNoContact { readings: zeros(log, |_, _| true) })
    }

    /// Digits too few to tell an object by, where a log is not explained otherwise.
    pub(super) fn coarse_digits(log: &Log) -> Option<Self> {
        let step = |value: fn(&Sample) -> Option<f64>| step_of(log.samples.iter().filter_map(value).collect());
        let step_m = step(|sample| sample.s1_m).max(step(|sample| sample.s2_m));
        if step_m >= COARSE_M * (1.0 - OFF_STEP) {
            return Some(Self::CoarsePositions { step_m });
        }
        let step_rad = step(|sample| Some(sample.palms.phi1_rad)).max(step(|sample| Some(sample.palms.phi2_rad)));
        (step_rad >= COARSE_RAD * (1.0 - OFF_STEP)).then_some(Self::CoarseAngles { step_rad })
    }

    /// The mistakes in the angles of a log without which its palms hold an object against gravity: those that may be why `log` has an angle
    /// from palm 1 to palm 2 that no palms have. Nothing is computed of an object.
    ///
    /// ```
    /// use palpate::{Log, Sample, palms::PalmPair, reconstruct::Mistake};
    /// let sample = |t: f64| Sample::new(t, PalmPair::hinged(-1.0, -1.2), 0.03, 0.03);
    /// let log = Log { samples: (0..20).map(|index| sample(f64::from(index))).collect() };
    /// assert_eq!(Mistake::of_palms_that_hold_nothing(&log), [Mistake::BothClockwise]);
    /// ```
    pub fn of_palms_that_hold_nothing(log: &Log) -> Vec<Self> {
        let all = [Self::Phi2Clockwise, Self::BothClockwise, Self::PalmsSwapped];
        let mends = |mistake: &Self| mistake.undone_for(log, [0.0; 2]).is_some_and(|undone| hold(&undone));
        all.into_iter().filter(mends).collect()
    }
}

/// Positions of exactly 0 for which `counts` is true of the last other position on the pad, and of the median of all others, metres.
fn zeros(log: &Log, counts: impl Fn(f64, f64) -> bool) -> usize {
    let of_pad = |s: fn(&Sample) -> Option<f64>| {
        let positions: Vec<f64> = log.samples.iter().filter_map(s).collect();
        let mut others: Vec<f64> = positions.iter().copied().filter(|s| *s != 0.0).collect();
        let first_m = others.first().copied().unwrap_or(0.0);
        let usual_m = if others.is_empty() { 0.0 } else { median(&mut others) };
        let mut last_m = first_m;
        positions
            .iter()
            .filter(|&&s_m| {
                if s_m != 0.0 {
                    last_m = s_m;
                }
                s_m == 0.0 && counts(last_m, usual_m)
            })
            .count()
    };
    of_pad(|sample| sample.s1_m) + of_pad(|sample| sample.s2_m)
}

/// Whether palms hold an object against gravity.
pub(super) fn hold(log: &Log) -> bool {
    held(log) >= HELD
}

/// Whether no object can be behind most of the readings: without friction the palms would hold none, or the positions on one palm are in other units than
/// those on the other.
pub(in crate::reconstruct) fn are_of_no_object(log: &Log) -> bool {
    let [of_palm1, of_palm2] = scales(log);
    held(log) < HELD_SELDOM || of_palm1 != of_palm2
}

/// Share of the samples in which they hold an object: each palm has a part of it above, and the other on the other side.
fn held(log: &Log) -> f64 {
    let holds = |sample: &&Sample| {
        let (phi1, phi2, phi12) = (sample.palms.phi1_rad, sample.palms.phi2_rad, sample.palms.phi12_rad());
        phi2 > 0.0 && phi2 < PI && phi1.sin() > 0.0 && phi12.sin() > 0.0
    };
    log.samples.iter().filter(holds).count() as f64 / log.samples.len().max(1) as f64
}

/// Whether φ₁ and φ₂ are radians that were read as degrees.
pub(super) fn angles_that_look_like_radians_in_degrees(log: &Log) -> [bool; 2] {
    let largest = |angle: fn(&Sample) -> f64| log.samples.iter().map(angle).fold(0.0, |most: f64, a| most.max(a.abs()));
    [largest(|sample| sample.palms.phi1_rad), largest(|sample| sample.palms.phi2_rad)]
        .map(|largest| largest > 0.0 && largest <= RADIANS_AS_DEGREES)
}

/// By what the positions on each palm are to be multiplied: 1 where their unit may be right.
pub(super) fn scales(log: &Log) -> [f64; 2] {
    let farthest = |s: fn(&Sample) -> Option<f64>| log.samples.iter().filter_map(s).fold(0.0, f64::max);
    [farthest(|sample| sample.s1_m), farthest(|sample| sample.s2_m)].map(|farthest_m| match farthest_m {
        far if far > LENGTHS_M[1] => 1.0 / MILLI,
        near if near > 0.0 && near < LENGTHS_M[0] => MILLI,
        _ => 1.0,
    })
}

/// The step that all values are multiples of; 0 where there is none, or nothing moves.
fn step_of(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let Some((&least, &most)) = values.first().zip(values.last()) else { return 0.0 };
    let rounding = 1e-9 * (most - least);
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > rounding);
    let step = gaps.fold(f64::INFINITY, f64::min);
    let is_on_step = |value: &f64| {
        let count = (value - least) / step;
        (count - count.round()).abs() < OFF_STEP * (1.0 + count)
    };
    if step.is_finite() && values.iter().all(is_on_step) { step } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;

    fn log_of(sample: impl Fn(f64) -> Sample) -> Log {
        Log { samples: (0..40).map(|index| sample(f64::from(index) / 40.0)).collect() }
    }

    /// A log that is right: it shows nothing, and is changed by the tests.
    fn right(t: f64) -> Sample {
        Sample::new(t, PalmPair::hinged(0.6 + 0.3 * t.sin(), 1.2 + 0.2 * t), 0.03 + 0.004 * t, 0.04 - 0.005 * t)
    }

    #[test]
    fn a_right_log_shows_nothing() {
        let log = log_of(right);
        assert_eq!((Mistake::by_readings(&log), Mistake::coarse_digits(&log)), (None, None));
        assert!(hold(&log));
    }

    #[test]
    fn units_show_on_each_side_of_their_limits() {
        let opening = |phi2: f64| log_of(|t| Sample { palms: PalmPair::hinged(0.6, phi2), ..right(t) });
        assert_eq!(Mistake::by_readings(&opening(0.0548)), Some(Mistake::RadiansAsDegrees));
        assert_eq!(Mistake::by_readings(&opening(0.0549)), None);
        let far = |s1_m: f64| log_of(|t| Sample { s1_m: Some(s1_m), ..right(t) });
        assert_eq!(Mistake::by_readings(&far(9.99)), None);
        assert_eq!(Mistake::by_readings(&far(10.01)), Some(Mistake::MillimetersAsMeters));
        assert_eq!(Mistake::by_readings(&far(1.01e-3)), None);
        assert_eq!(Mistake::by_readings(&far(0.99e-3)), Some(Mistake::MetersAsMillimeters));
        // One palm is never so much longer than the other.
        assert!(!are_of_no_object(&far(1.01e-3)) && are_of_no_object(&far(0.99e-3)));
        assert!(!are_of_no_object(&far(9.99)) && are_of_no_object(&far(10.01)));
        // Each column is mended by itself.
        let undone = Mistake::MetersAsMillimeters.undone_for(&far(0.5e-3), [0.0; 2]).expect("it can be undone");
        assert!((undone.samples[1].s1_m.unwrap_or_default() - 0.5).abs() < 1e-12);
        assert_eq!(undone.samples[1].s2_m, far(0.5e-3).samples[1].s2_m);
    }

    #[test]
    fn zeros_far_from_the_contact_before_them_are_known_at_once() {
        let log = |before_m: f64| {
            let mut log = log_of(right);
            for index in [5, 15, 25] {
                log.samples[index].s2_m = Some(before_m);
                log.samples[index + 1].s2_m = Some(0.0);
            }
            log
        };
        // The usual position on pad 2 is half of the way from 40 to 35 mm.
        assert_eq!(Mistake::leaps_to_zero(&log(0.95 * LEAP_SHARE * 0.0375)), None);
        let mistake = Mistake::leaps_to_zero(&log(1.05 * LEAP_SHARE * 0.0375));
        assert_eq!(mistake, Some(Mistake::ZerosForNoContact { readings: 3 }));
        assert_eq!(Mistake::leaps_to_zero(&log_of(right)), None);
    }

    #[test]
    fn three_exact_zeros_are_not_by_chance() {
        let zeros = |count: usize| {
            let mut log = log_of(right);
            log.samples[10..10 + count].iter_mut().for_each(|sample| sample.s2_m = Some(0.0));
            log
        };
        assert_eq!(Mistake::by_readings(&zeros(2)), None);
        let mistake = Mistake::by_readings(&zeros(3));
        assert_eq!(mistake, Some(Mistake::ZerosForNoContact { readings: 3 }));
        let undone = mistake.and_then(|mistake| mistake.undone_for(&zeros(3), [0.0; 2])).expect("it can be undone");
        assert!(undone.samples[10].s2_m.is_none() && undone.samples[13].s2_m.is_some());
    }

    #[test]
    fn digits_are_coarse_from_half_a_millimetre_and_half_a_degree_on() {
        let to = |step: f64, value: f64| (value / step).round() * step;
        let positions = |step: f64| log_of(|t| Sample { s1_m: Some(to(step, 0.03 + 0.02 * t)), ..right(t) });
        assert_eq!(Mistake::coarse_digits(&positions(4e-4)), None);
        assert!(
            matches!(Mistake::coarse_digits(&positions(5e-4)), Some(Mistake::CoarsePositions { step_m }) if (step_m - 5e-4).abs() < 1e-9)
        );
        let angles = |step: f64| {
            let step = step.to_radians();
            log_of(|t| Sample { palms: PalmPair::hinged(to(step, 0.6 + 0.3 * t), 1.2 + 0.2 * t), ..right(t) })
        };
        assert_eq!(Mistake::coarse_digits(&angles(0.4)), None);
        assert!(matches!(Mistake::coarse_digits(&angles(0.5)), Some(Mistake::CoarseAngles { .. })));
    }

    #[test]
    fn gravity_tells_which_mistake_of_the_angles_it_is() {
        let angles = |change: fn(f64, f64) -> (f64, f64)| {
            let log = log_of(|t| {
                let (phi1, phi2) = change(right(t).palms.phi1_rad, right(t).palms.phi2_rad);
                Sample { palms: PalmPair::hinged(phi1, phi2), ..right(t) }
            });
            Mistake::of_palms_that_hold_nothing(&log)
        };
        assert_eq!(angles(|phi1, phi2| (phi1, -phi2)), [Mistake::Phi2Clockwise]);
        assert_eq!(angles(|phi1, phi2| (-phi1, -phi2)), [Mistake::BothClockwise]);
        assert_eq!(angles(|phi1, phi2| (phi1 + phi2, -phi2)), [Mistake::PalmsSwapped]);
        assert_eq!(angles(|phi1, phi2| (phi1 - 3.0, -phi2)), []);
    }

    #[test]
    fn palms_may_let_go_in_one_sample_of_twenty() {
        let tilted = |count: usize| {
            let mut log = log_of(right);
            log.samples[..count].iter_mut().for_each(|sample| sample.palms.phi1_rad = -0.1);
            log
        };
        assert!(hold(&tilted(2)) && !hold(&tilted(3)));
        // Those that let go of it in more than half hold nothing.
        assert!(!are_of_no_object(&tilted(20)) && are_of_no_object(&tilted(21)));
    }
}
